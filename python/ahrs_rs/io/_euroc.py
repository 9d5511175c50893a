"""EuRoC's and other folders of the ASL layout: mav0/imu0/data.csv with sensor.yaml, and the truth beside it.

Times in ns, gyroscope first. The truth (state_groundtruth_estimate0, mocap0 or vicon0) is the orientation of its own
sensor; with both T_BS, the poses of the sensors in the body, it becomes that of the IMU. Its frame has z up and a
heading of its own.
"""

from __future__ import annotations

import re
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _quat
from ahrs_rs._typing import FloatArray
from ahrs_rs.io import _attitude
from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._lines import header_of, is_text, read_named
from ahrs_rs.io._source import Source
from ahrs_rs.io._stamps import seconds, utc

GYR, ACC = tuple(f"w_RS_S_{axis}" for axis in "xyz"), tuple(f"a_RS_S_{axis}" for axis in "xyz")
QUAT = tuple(f"q_RS_{axis}" for axis in "wxyz")
#: Beside the orientation, in the frame of the truth.
MOTION = {"velocity": "v_RS_R_", "position": "p_RS_R_"}
#: Folders of the truth, in the order of preference.
TRUTHS = ("state_groundtruth_estimate0", "mocap0", "gt0", "vicon0")
FRAME = "z up, heading of the motion capture"
#: Stamps of which so many repeat the one before have been rounded.
ROUNDED = 0.5


def sniff(source: Source) -> bool:
    """Whether a folder has imu0/data.csv, or the columns of a file are called as in EuRoC."""
    if source.names:
        return bool(_imus(source)) or bool(_truth(source))
    return is_text(source.head) and any(name.startswith(("w_RS_S_", "q_RS_w")) for name in header_of(source.head))


def _imus(source: Source) -> dict[str, str]:
    """Sensor's name -> its file."""
    found = {
        PurePosixPath(name).parent.name: name for name in source.names if re.search(r"(^|/)imu\d+/data\.csv$", name)
    }
    if not found and "data.csv" in source.names and "sensor.yaml" in source.names:
        header = header_of(source.read("data.csv", 4096))
        if any(name.startswith("w_RS_S_") for name in header):
            return {"imu0": "data.csv"}  # the folder of one sensor
    return dict(sorted(found.items()))


def _truth(source: Source) -> str | None:
    """The file of the truth."""
    return next((name for truth in TRUTHS for name in source.names if f"/{name}".endswith(f"/{truth}/data.csv")), None)


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read the IMUs of a folder with their truth, or one file."""
    if not source.names:
        table = _read(source.read())
        return {"imu0": _sensor(table, None, None, options, {})}
    imus, truth = _imus(source), _truth(source)
    if not imus:
        raise ValueError(f"has no imu0/data.csv, only {', '.join(source.names[:6])}")
    found_truth = _read(source.read(truth)) if truth else None
    poses = {name: _orientation_in_body(source, name) for name in [*imus.values(), *([truth] if truth else [])]}
    turn = {}
    for name, file in imus.items():
        turn[name] = _quat.multiply(_quat.conjugate(poses[truth]), poses[file]) if truth else None
    wanted = {name: file for name, file in imus.items() if options.sensor in (None, name)} or imus
    info = {"truth": truth} if truth else {}
    return {
        name: _sensor(_read(source.read(file)), found_truth, turn[name], options, info) for name, file in wanted.items()
    }


def _read(content: bytes) -> Any:
    """The table, its columns by their names without units."""
    table = read_named(content, exact=[name for name in header_of(content) if "timestamp" in name.lower()])
    table.columns = {name.partition("[")[0].strip(): values for name, values in table.columns.items()}
    return table


def _sensor(table: Any, truth: Any, turn: FloatArray | None, options: Options, info: dict[str, Any]) -> SensorData:
    stamps: dict[str, NDArray[Any]] = {"rows": _stamps(table)}
    if truth is not None:
        stamps["truth"] = _stamps(truth)
    rounded = [name for name, stamp in stamps.items() if _are_rounded(stamp)]
    data = SensorData(streams={}, meta={"repairs": list(table.repairs), "info": info, "clock": "of the sensor, ns"})
    if rounded and options.rate is None:
        raise ValueError(
            "has stamps that a spreadsheet has rounded (as 1.403E+18): take the original file, or give the rate, "
            "as rate=200 (--rate 200), which leaves out the truth"
        )
    if options.rate is not None:
        times: dict[str, Any] = {"rows": None, "truth": None}
        data.rate = options.rate
        if truth is not None:
            data.say("ignored", "the truth, as a given rate says nothing of its stamps")
            truth = None
    else:
        times, origin = seconds(stamps, 1e-9)
        start = utc(origin)
        if start:
            data.meta["start"] = start
    for stream, names in (("gyr", GYR), ("acc", ACC)):
        if set(names) <= set(table.columns):
            data.streams[stream] = (times["rows"], table.vectors(names))
    _add_truth(data, truth if truth is not None else table, times["truth" if truth is not None else "rows"], turn)
    if not data.streams:
        raise ValueError(
            f"has none of the columns w_RS_S_x, a_RS_S_x and q_RS_w, only {', '.join(table.columns)}"[:300]
        )
    units = {"gyr": "rad/s", "acc": "m/s²"}
    data.meta["units"] = {stream: unit for stream, unit in units.items() if stream in data.streams}
    return data


def _add_truth(data: SensorData, table: Any, t: Any, turn: FloatArray | None) -> None:
    if set(QUAT) <= set(table.columns):
        quat = _attitude.recorded(table.vectors(QUAT))
        data.streams["ref"] = (t, quat if turn is None else _quat.multiply(quat, turn))
        data.meta["ref_frame"] = FRAME
    for stream, prefix in MOTION.items():
        names = [f"{prefix}{axis}" for axis in "xyz"]
        if set(names) <= set(table.columns):
            data.streams[stream] = (t, table.vectors(names))


def _stamps(table: Any) -> NDArray[Any]:
    for name in table.columns:
        if "timestamp" in name.lower():
            stamps: NDArray[Any] = table.columns[name]
            return stamps
    raise ValueError(f"has no column timestamp, only {', '.join(table.columns)}"[:300])


def _are_rounded(stamps: NDArray[Any]) -> bool:
    """Whether integers of ns have become floats that hold the same value for many rows."""
    return stamps.dtype.kind == "f" and len(stamps) > 2 and bool(np.mean(np.diff(stamps) == 0.0) > ROUNDED)


def _orientation_in_body(source: Source, name: str) -> FloatArray:
    """The orientation of a sensor in the body, from T_BS in its sensor.yaml; none is the body's own."""
    path = (PurePosixPath(name).parent / "sensor.yaml").as_posix()
    if path not in source.names:
        return np.array([1.0, 0.0, 0.0, 0.0])
    text = source.read(path).decode("latin-1")
    match = re.search(r"T_BS:.*?data:\s*\[([^\]]*)\]", text, re.S)
    try:
        values = np.array([float(cell) for cell in match[1].split(",")]) if match else np.eye(4).reshape(-1)
        matrix = values.reshape(4, 4)[None, :3, :3]
    except ValueError:
        raise ValueError(f"{path}: T_BS: expected 16 numbers") from None
    if not np.allclose(matrix[0] @ matrix[0].T, np.eye(3), atol=1e-3) or np.linalg.det(matrix[0]) < 0:
        raise ValueError(f"{path}: T_BS: expected a rotation")
    turn: FloatArray = _attitude.from_matrix(matrix)[0]
    return turn
