"""Text files of devices and phones, in the layouts that their programs write."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from devices import readings

XYZ = "XYZ"


def lines(header: Iterable[str], rows: Iterable[Sequence[object]], separator: str = ",", end: str = "\n") -> str:
    """Header lines over rows."""
    return end.join([*header, *(separator.join(map(str, row)) for row in rows), ""])


def xsens(
    n: int,
    *,
    separator: str = "\t",
    first: int = 65500,
    lost: Iterable[int] = (),
    fine: bool = True,
    rate: str = "",
    quat: str = "Quat_q",
    decimal: str = ".",
    start: int = 2**32 - 5000,
    end: str = "\r\n",
) -> str:
    """MT Manager's export at 100 Hz; PacketCounter and SampleTimeFine wrap on the way."""
    columns = ["PacketCounter", "SampleTimeFine", "Year", "Month", "Day", "Second"]
    columns += [f"{name}_{axis}" for name in ("Acc", "Gyr", "Mag") for axis in XYZ]
    if quat == "Quat_q":
        columns += [f"Quat_q{index}" for index in range(4)]
    header = [
        "// General information: ",
        "//  MT Manager version: 2022.2.0 ",
        "// Device information: ",
        "//  DeviceId: 00B42D4B",
    ]
    header += [f"//  Update Rate: {rate}"] if rate else []
    header += ["// Coordinate system: ENU", separator.join(columns)]
    acc, gyr, mag, q = readings.acc(n), readings.gyr(n), readings.mag(n) / 50.0, readings.quat(n)
    rows = []
    for k in range(n):
        stamp = str((start + 100 * k) % 2**32) if fine else ""
        values = [*acc[k], *gyr[k], *mag[k], *(q[k] if quat == "Quat_q" else ())]
        row = [
            str((first + k) % 2**16),
            stamp,
            "",
            "",
            "",
            "",
            *(f"{value:.6f}".replace(".", decimal) for value in values),
        ]
        if k not in set(lost):
            rows.append(row)
    return lines(header, rows, separator, end)


def dot(
    n: int, *, lost: Iterable[int] = (), preamble: bool = True, start: int = 2**32 - 500_000, orientation: str = "Quat"
) -> str:
    """Movella DOT's CSV at 60 Hz in a mode with orientation, acceleration, angular rate (deg/s) and field."""
    header = ["sep=,"]
    if preamble:
        header += [
            "DeviceTag:,Sensor 1",
            "FirmwareVersion:,2.0.0",
            "OutputRate:,60Hz",
            "Measurement Mode:,Custom Mode 5",
            "",
        ]
    names = [f"Quat_{axis}" for axis in "WXYZ"] if orientation == "Quat" else [f"Euler_{axis}" for axis in XYZ]
    columns = ["PacketCounter", "SampleTimeFine", *names]
    columns += [f"{name}_{axis}" for name in ("Acc", "Gyr", "Mag") for axis in XYZ]
    acc, gyr, mag, q = readings.acc(n), np.degrees(readings.gyr(n)), readings.mag(n) / 50.0, readings.quat(n)
    rows = []
    for k in range(n):
        turned = q[k] if orientation == "Quat" else (10.0, 20.0, 30.0)
        values = [f"{value:.6f}" for value in (*turned, *acc[k], *gyr[k], *mag[k])]
        if k not in set(lost):
            rows.append([str(k + 1), str((start + 16667 * k) % 2**32), *values])
    return lines([*header, ",".join(columns)], rows)


def shimmer(
    n: int,
    *,
    separator: str = ",",
    two: bool = False,
    clip: bool = False,
    raw: bool = True,
    device: str = "Shimmer_5E90",
) -> str:
    """ConsensysPRO's CSV at 32768/328 Hz; `two` accelerometers, of which the low-noise one has clipped where asked."""
    acc, gyr, mag = readings.acc(n), np.degrees(readings.gyr(n)), readings.mag(n) / 50.0
    groups: list[tuple[str, str, NDArray[np.float64]]] = []
    if two:
        low = acc.copy()
        low[n // 2] = [20.0, 0.0, 0.0] if clip else low[n // 2]
        groups.append(("Accel_LN", "m/(s^2)", low))
    groups += [("Accel_WR", "m/(s^2)", acc), ("Gyro", "deg/s", gyr), ("Mag", "local_flux", mag)]
    names, units = [f"{device}_Timestamp_Unix_CAL"], ["ms"]
    if raw:
        names, units = [*names, f"{device}_Timestamp_RAW"], [*units, "no_units"]
    for name, unit, _ in groups:
        names += [f"{device}_{name}_{axis}_CAL" for axis in XYZ]
        units += [unit] * 3
    rows = []
    for k in range(n):
        stamp = [f"{1.7e12 + k * 328000.0 / 32768:.7f}"] + ([str(k * 328 % 65536)] if raw else [])
        rows.append([*stamp, *(f"{value:.9f}" for _, _, part in groups for value in part[k]), ""])
    header = [f'"sep={separator}"', separator.join([*names, ""]), separator.join([*units, ""])]
    return lines(header, rows, separator)


def shimmer_four_lines(n: int) -> str:
    """The older export: device, signal, form and unit in four lines, separated by tabs."""
    signals = [("Timestamp", "mSecs")]
    for name, unit in (
        ("Low Noise Accelerometer", "m/(sec^2)*"),
        ("Gyroscope", "deg/sec*"),
        ("Magnetometer", "local*"),
    ):
        signals += [(f"{name} {axis}", unit.rstrip("*") if name != "Magnetometer" else "local_flux") for axis in XYZ]
    header = ["\t".join(["Shimmer_5E90"] * len(signals)), "\t".join(name for name, _ in signals)]
    header += ["\t".join(["CAL"] * len(signals)), "\t".join(unit for _, unit in signals)]
    acc, gyr, mag = readings.acc(n), np.degrees(readings.gyr(n)), readings.mag(n) / 50.0
    rows = [[f"{1000.0 + 10.0 * k:.6f}", *(f"{value:.9f}" for value in (*acc[k], *gyr[k], *mag[k]))] for k in range(n)]
    return lines(header, rows, "\t")


def apdm_format_7(n: int, labels: Sequence[str] = ("Lumbar", "Right Foot")) -> str:
    """APDM's CSV of format 7: sensors side by side under three lines."""
    first, second, third = ["Format=7"], ["Time"], [""]
    for number, label in enumerate(labels):
        first += [str(5718 + number), "", "", label, *[""] * 10]
        second += [
            "Accelerometer",
            "",
            "",
            "Gyroscope",
            "",
            "",
            "Magnetometer",
            "",
            "",
            "Barometer",
            "Orientation",
            "",
            "",
            "",
        ]
        third += [*XYZ, *XYZ, *XYZ, "", "S", *XYZ]
    rows = []
    for k in range(n):
        row = [str(1550879504438281 + 7812 * k)]
        for number in range(len(labels)):
            values = (
                *readings.acc(n)[k],
                *(readings.gyr(n)[k] * (number + 1)),
                *readings.mag(n)[k],
                101.3,
                *readings.quat(n)[k],
            )
            row += [f"{value:.6f}" for value in values]
        rows.append(row)
    return lines([",".join(first), ",".join(second), ",".join(third)], rows)


def apdm_named(n: int, labels: Sequence[str] = ("Lumbar", "Chest")) -> str:
    """APDM's older CSV: a test's name, a rate, names such as Lumbar/Acceleration/X over a line of units."""
    names, units = ["Time"], ["s"]
    for label in labels:
        for quantity, unit in (("Acceleration", "m/s^2"), ("Angular Velocity", "rad/s"), ("Magnetic Field", "uT")):
            names += [f"{label}/{quantity}/{axis}" for axis in XYZ]
            units += [unit] * 3
    values = np.hstack([readings.acc(n), readings.gyr(n), readings.mag(n)])
    rows = [[f"{k / 128:.6f}", *(f"{v:.6f}" for _ in labels for v in values[k])] for k in range(n)]
    return lines(["Test Name:,Walk,,", "Sample Rate:,128,Hz,", ",".join(names), ",".join(units)], rows)


def gcsv(n: int, *, orientation: str = "YxZ") -> str:
    """Gyroflow's log of integers at 1000 Hz: 1e-4 rad/s, 1e-3 g, 1e-3 gauss."""
    header = [
        "GYROFLOW IMU LOG",
        "version,1.3",
        "id,logger",
        f"orientation,{orientation}",
        "tscale,0.001",
        "gscale,0.0001",
    ]
    header += ["ascale,0.001", "mscale,0.001", "t,gx,gy,gz,ax,ay,az,mx,my,mz"]
    gyr, acc = np.rint(readings.gyr(n) * 1e4).astype(int), np.rint(readings.acc(n) / 9.80665 * 1e3).astype(int)
    mag = np.rint(readings.mag(n) * 10).astype(int)
    return lines(header, [[k, *gyr[k], *acc[k], *mag[k]] for k in range(n)])


# -- folders -----------------------------------------------------------------------------------------------------------


def euroc(folder: Path, n: int, *, truth: bool = True, turn: str = "0, 1, 0, -1, 0, 0, 0, 0, 1") -> Path:
    """EuRoC's folder: an IMU at 200 Hz, turned in the body as given (rows of a matrix), the truth at 100 Hz."""
    imu, state = folder / "mav0" / "imu0", folder / "mav0" / "state_groundtruth_estimate0"
    imu.mkdir(parents=True)
    start = 1403636579758555392
    header = "#timestamp [ns]," + ",".join(f"w_RS_S_{a} [rad s^-1]" for a in "xyz")
    header += "," + ",".join(f"a_RS_S_{a} [m s^-2]" for a in "xyz")
    rows = [
        [
            start + 5_000_000 * k,
            *map(repr, (readings.gyr(n)[k] + 0.0).tolist()),
            *map(repr, readings.acc(n)[k].tolist()),
        ]
        for k in range(n)
    ]
    (imu / "data.csv").write_text(lines([header], rows, end="\r\n"))
    a = turn.split(",")
    pose = ", ".join([*a[:3], " 0.1", *a[3:6], " 0.2", *a[6:], " 0.3", " 0, 0, 0, 1"])
    (imu / "sensor.yaml").write_text(f"sensor_type: imu\nT_BS:\n  cols: 4\n  rows: 4\n  data: [{pose}]\nrate_hz: 200\n")
    if truth:
        state.mkdir()
        names = ["#timestamp", *(f"p_RS_R_{a} [m]" for a in "xyz"), *(f"q_RS_{a} []" for a in "wxyz")]
        names += [f"v_RS_R_{a} [m s^-1]" for a in "xyz"]
        q = readings.quat(n)
        table = [[start + 10_000_000 * k, 1, 2, 3, *map(repr, q[k].tolist()), 0.1, 0.2, 0.3] for k in range(n // 2)]
        (state / "data.csv").write_text(lines([", ".join(names)], table, end="\r\n"))
    return folder


def ngimu(folder: Path, n: int) -> Path:
    """NGIMU's folder: sensors at 100 Hz, the quaternion at 50 Hz."""
    folder.mkdir(parents=True, exist_ok=True)
    names = ["Time (s)", *(f"Gyroscope {a} (deg/s)" for a in XYZ), *(f"Accelerometer {a} (g)" for a in XYZ)]
    names += [*(f"Magnetometer {a} (uT)" for a in XYZ), "Barometer (hPa)"]
    values = np.hstack([np.degrees(readings.gyr(n)), readings.acc(n) / 9.80665, readings.mag(n)])
    rows = [[f"{k / 100:.6f}", *(f"{v:.9f}" for v in values[k]), "1013.2"] for k in range(n)]
    (folder / "sensors.csv").write_text(lines([",".join(names)], rows, end="\r\n"))
    table = [[f"{k / 50:.6f}", *(f"{v:.9f}" for v in readings.quat(n)[k])] for k in range(n // 2)]
    (folder / "quaternion.csv").write_text(lines(["Time (s),W,X,Y,Z"], table, end="\r\n"))
    return folder


def ximu3(folder: Path, n: int) -> Path:
    """An x-IMU3's folder as its converter (1.9.1) writes it: inertial 400 Hz, magnetometer and quaternion 100 Hz."""
    folder.mkdir(parents=True, exist_ok=True)
    six = np.hstack([np.degrees(readings.gyr(n)), readings.acc(n) / 9.80665])
    names = ["Timestamp (us)", *(f"Gyroscope {a} (deg/s)" for a in XYZ), *(f"Accelerometer {a} (g)" for a in XYZ)]
    rows = [[1_000_000 + 2500 * k, *(f"{v:.6f}" for v in six[k])] for k in range(n)]
    (folder / "Inertial.csv").write_text(lines([",".join(names)], rows))
    for name, header, values in (
        ("Magnetometer", "Timestamp (us),X (a.u.),Y (a.u.),Z (a.u.)", readings.mag(n) / 50),
        ("Quaternion", "Timestamp (us),W,X,Y,Z", readings.quat(n)),
    ):
        table = [[1_000_010 + 10_000 * k, *(f"{v:.6f}" for v in values[4 * k])] for k in range(n // 4)]
        (folder / f"{name}.csv").write_text(lines([header], table))
    ping = '{"ping":{"interface":"USB","name":"x-IMU3","sn":"01234567"}}'
    (folder / "Command.json").write_text(f"[\n    {ping}\n\n]")
    return folder


def sensorlogger(
    folder: Path, n: int, *, platform: str = "android", standard: str = "false", order: str = "zyx", total: bool = True
) -> Path:
    """Sensor Logger's folder at 100 Hz; accelerations have the sign of the platform."""
    folder.mkdir(parents=True, exist_ok=True)
    sign = -1.0 if platform == "ios" and standard == "false" else 1.0
    gravity = np.tile([0.0, 0.0, 9.80665], (n, 1))
    files = {
        "Gyroscope": readings.gyr(n),
        "Magnetometer": readings.mag(n),
        "Accelerometer": sign * (readings.acc(n) - gravity),
        "Gravity": sign * gravity,
    }
    if total:
        files["TotalAcceleration"] = readings.acc(n)
    start = 1760000000000000000
    for name, values in files.items():
        rows = [
            [start + 10_000_000 * k, f"{0.05 + 0.01 * k:.9f}", *(repr(float(values[k]["xyz".index(a)])) for a in order)]
            for k in range(n)
        ]
        (folder / f"{name}.csv").write_text(lines([",".join(["time", "seconds_elapsed", *order])], rows))
    names = "version,device name,recording epoch time,platform,standardisation"
    (folder / "Metadata.csv").write_text(f"{names}\n3,phone,1760000000000,{platform},{standard}\n")
    return folder


def phyphox(folder: Path, n: int, *, separator: str = ",", decimal: str = ".") -> Path:
    """phyphox's folder: gyroscope and acceleration at 100 Hz, field at 50 Hz, and its meta files."""
    (folder / "meta").mkdir(parents=True, exist_ok=True)
    streams = {
        "Gyroscope": ("Gyroscope {} (rad/s)", readings.gyr(n), 0.01),
        "Accelerometer": ("Acceleration {} (m/s^2)", readings.acc(n), 0.01),
        "Linear Acceleration": ("Linear Acceleration {} (m/s^2)", 0.1 * readings.acc(n), 0.01),
        "Magnetometer": ("Magnetic field {} (µT)", readings.mag(n)[: n // 2], 0.02),
    }
    for name, (label, values, step) in streams.items():
        header = separator.join(f'"{one}"' for one in ["Time (s)", *(label.format(a) for a in "xyz")])
        rows = [[f"{v:.9E}".replace(".", decimal) for v in (step * k, *values[k])] for k in range(len(values))]
        (folder / f"{name}.csv").write_text(lines([header], rows, separator), encoding="utf-8")
    (folder / "meta" / "device.csv").write_text('"property","value"\n"deviceModel","phone"\n')
    times = '"event","experiment time","system time","system time text"\n'
    (folder / "meta" / "time.csv").write_text(
        times + '"START",0.000000000E0,1.760000000000E9,"2025-10-09 08:53:20.000 UTC"\n'
    )
    return folder
