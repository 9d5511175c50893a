"""Laws of reading CSV and Parquet: names, units, contents."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ahrs_rs.io import read
from recordings import recording, write_text

pa = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")

GRAVITY = 9.80665
#: Units that a file does not state, and the like, are told; test_read_told.py has their tests.
pytestmark = pytest.mark.filterwarnings("ignore::ahrs_rs.DataWarning")
XIO_HEADER = (
    "Time (s),Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),Accelerometer X (g),"
    "Accelerometer Y (g),Accelerometer Z (g),Magnetometer X (uT),Magnetometer Y (uT),Magnetometer Z (uT)"
)


@pytest.mark.parametrize(
    ("header", "factors"),
    [
        (XIO_HEADER, (1, np.pi / 180, GRAVITY, 1)),
        ("t,gx,gy,gz,ax,ay,az,mx,my,mz", (1, 1, 1, 1)),
        (
            "time [ms],gyr_x [rad/s],gyr_y [rad/s],gyr_z [rad/s],ax (m/s^2),ay (m/s^2),az (m/s^2),"
            "mag_x (uT),mag_y (uT),mag_z (uT)",
            (1e-3, 1, 1, 1),
        ),
        (
            "timestamp_us,gyro_x_dps,gyro_y_dps,gyro_z_dps,acc_x_g,acc_y_g,acc_z_g,mag_x_nT,mag_y_nT,mag_z_nT",
            (1e-6, np.pi / 180, GRAVITY, 1e-3),
        ),
        (
            "Time (µs),GYROSCOPE X (°/s),GYROSCOPE Y (°/s),GYROSCOPE Z (°/s),ACCELEROMETER X (m/s²),"
            "ACCELEROMETER Y (m/s²),ACCELEROMETER Z (m/s²),MAGNETIC FIELD X (μT),MAGNETIC FIELD Y (μT),"
            "MAGNETIC FIELD Z (μT)",
            (1e-6, np.pi / 180, 1, 1),
        ),
        (
            "seconds,gyroX,gyroY,gyroZ,accX,accY,accZ,magX (gauss),magY (gauss),magZ (gauss)",
            (1, 1, 1, 100),
        ),
        (
            "timestamp [ns],wx [deg/s],wy [deg/s],wz [deg/s],Acc_X [mg],Acc_Y [mg],Acc_Z [mg],"
            "Mag_X [mG],Mag_Y [mG],Mag_Z [mG]",
            (1e-9, np.pi / 180, GRAVITY * 1e-3, 0.1),
        ),
        (
            "t_s,angular_velocity_x,angular_velocity_y,angular_velocity_z,accel_x_m_s2,accel_y_m_s2,"
            "accel_z_m_s2,mag_x (a.u.),mag_y (a.u.),mag_z (a.u.)",
            (1, 1, 1, 1),
        ),
        (
            "# time,imu_gyr_x [mdps],imu_gyr_y [mdps],imu_gyr_z [mdps],imu_acc_x,imu_acc_y,imu_acc_z,"
            "imu_mag_x,imu_mag_y,imu_mag_z",
            (1, np.pi / 180e3, 1, 1),
        ),
    ],
)
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_names_and_units_are_understood(
    tmp_path: Path, header: str, factors: tuple[float, float, float, float], separator: str
) -> None:
    source = recording()
    assert source.acc is not None
    assert source.mag is not None
    parts = (source.t, source.gyr, source.acc, source.mag)
    table = np.column_stack([part / factor for part, factor in zip(parts, factors, strict=True)])
    path = write_text(tmp_path / "a.csv", header.replace(",", separator), table, separator)
    found = read(path)
    for name, expected in zip(("t", "gyr", "acc", "mag"), parts, strict=True):
        # A division and a multiplication: two roundings.
        assert np.allclose(getattr(found, name), expected, rtol=8e-16, atol=0)
    assert found.meta["repairs"] == []


def test_missing_units_are_assumed_to_be_si_and_told(tmp_path: Path) -> None:
    rows = np.random.default_rng(0).random((10, 7))
    rows[:, 0] = np.arange(10)
    path = write_text(tmp_path / "a.csv", "t,gx,gy,gz,ax (g),ay (g),az (g)", rows)
    found = read(path)
    assert np.array_equal(found.gyr, rows[:, 1:4])
    assert found.meta["assumed_units"] == {"t": "s", "gyr": "rad/s"}
    assert found.meta["units"] == {"t": "s", "gyr": "rad/s", "acc": "g"}


def test_truth_temperature_and_mask_of_a_table_are_read(tmp_path: Path) -> None:
    header = "t,gx,gy,gz,ref_w,ref_x,ref_y,ref_z,temperature (K),movement,comment"
    rows = [f"{k / 10},0,0,0,1,0,0,0,{300 + k},{k % 2},free text" for k in range(5)]
    found = read(write_text(tmp_path / "a.csv", header, rows))
    assert found.ref is not None
    assert found.temperature is not None
    assert found.mask is not None
    assert found.ref.tolist() == [[1.0, 0, 0, 0]] * 5
    assert found.temperature == pytest.approx(np.arange(5) + 26.85, rel=1e-14)
    assert found.mask.tolist() == [False, True, False, True, False]
    assert found.meta["ignored_columns"] == ["comment"]
    words = write_text(tmp_path / "b.csv", "t,gx,gy,gz,mask", [f"{k},0,0,0,{k < 3}" for k in range(5)])
    assert np.array_equal(read(words).mask, [True, True, True, False, False])


def test_quaternion_is_the_truth_only_where_it_is_named_so(tmp_path: Path) -> None:
    header = "t,gx,gy,gz,qw,qx,qy,qz,ref_qw,ref_qx,ref_qy,ref_qz"
    path = write_text(tmp_path / "a.csv", header, [f"{k},0,0,0,1,0,0,0,0,1,0,0" for k in range(5)])
    found = read(path)
    assert found.ref is not None
    assert found.ref[0].tolist() == [0.0, 1.0, 0.0, 0.0]
    assert found.device_quat is not None
    assert found.device_quat[0].tolist() == [1.0, 0.0, 0.0, 0.0]
    named = read(path, columns={"ref": ["qw", "qx", "qy", "qz"]})
    assert named.ref is not None
    assert named.ref[0].tolist() == [1.0, 0.0, 0.0, 0.0]
    assert named.device_quat is None


def test_suffix_that_is_no_unit_is_left_for_the_plain_name(tmp_path: Path) -> None:
    header = "t,gx,gy,gz,gyr_x_filtered,temp_room,time_utc"
    found = read(write_text(tmp_path / "a.csv", header, [f"{k},1,2,3,4,5,noon" for k in range(5)]))
    assert found.gyr[0].tolist() == [1.0, 2.0, 3.0]
    assert found.temperature is None
    assert found.meta["ignored_columns"] == ["gyr_x_filtered", "temp_room", "time_utc"]


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("t,gx (furlong),gy (furlong),gz (furlong)", r"column 'gx \(furlong\)': unknown unit 'furlong'"),
        ("t (min),gx,gy,gz", r"column 't \(min\)': unknown unit 'min'"),
        ("t,gx,gy,gz,ax [m/s],ay [m/s],az [m/s]", r"column 'ax \[m/s\]': unknown unit 'm/s'"),
        ("t,gx,gy,gz,temperature (R)", r"column 'temperature \(R\)': unknown unit 'R'"),
        ("t,gx,gy,ax,ay,az", r"gyr: no column for z, only \['gx', 'gy'\]"),
        ("t,gx,gy,gz,ref_qw,ref_qx,ref_qy", "ref: no column for z"),
        ("t,u,v,w", "has no column of a gyroscope.* only 't', 'u'"),
        ("gx,gy,gz,ax,ay,az", "has no times"),
        ("t,gx,gy,gz,gx", "columns 'gx' and 'gx' are the same quantity and axis"),
        ("t,gx,gy,gz,gyr_x", "columns 'gx' and 'gyr_x' are the same quantity and axis"),
        ("t,gx (rad/s),gy (rad/s),gz (deg/s)", "gyr: expected one unit for all axes, got"),
        ("0.0,1.0,2.0,3.0", r"has no header line: name its 4 columns by columns=\[...\]"),
        ("some,words", "has no column of a gyroscope"),
    ],
)
def test_headers_that_cannot_be_understood_are_refused(tmp_path: Path, header: str, message: str) -> None:
    path = write_text(tmp_path / "a.csv", header, np.ones((5, header.count(",") + 1)))
    with pytest.raises(ValueError, match=message) as error:
        read(path)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_header_in_latin_1_and_byte_order_marks_are_read(tmp_path: Path) -> None:
    text = "t (s),gx (°/s),gy (°/s),gz (°/s)\n0,180,0,0\n1,180,0,0\n"
    for encoding in ("latin-1", "utf-8", "utf-8-sig"):
        (tmp_path / "a.csv").write_bytes(text.encode(encoding))
        assert read(tmp_path / "a.csv").gyr[:, 0].tolist() == [math.pi, math.pi]


def test_spaces_blank_lines_and_separators_at_the_end_do_no_harm(tmp_path: Path) -> None:
    plain = "t, gx, gy, gz\n0, 1, 2, 3\n1, 4, 5, 6\n"
    variants = (
        plain,
        "\n\n" + plain,
        plain.replace("\n", "\r\n"),
        plain + "\n\n",
        plain.replace("\n", ",\n"),
        plain.replace("gz", "gz,,"),
        plain.replace("3\n", "3,\n").replace("6\n", "6,\n"),
        plain.rstrip(),
    )
    for text in variants:
        (tmp_path / "a.csv").write_text(text)
        assert read(tmp_path / "a.csv").gyr.tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], repr(text)


def test_parquet_follows_the_rules_of_csv(tmp_path: Path) -> None:
    source = recording()
    assert source.acc is not None
    assert source.ref is not None
    columns: dict[str, Any] = {"t": source.t, "label": ["x"] * 50, "mask": source.mask}
    columns |= {f"gyr_{axis}_dps": np.degrees(source.gyr[:, i]) for i, axis in enumerate("xyz")}
    columns |= {f"linear.a{axis}": source.gyr[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"a{axis}": source.acc[:, i].astype(np.float32) for i, axis in enumerate("xyz")}
    columns |= {f"q{axis}": source.ref[:, i] for i, axis in enumerate("wxyz")}
    parquet.write_table(pa.table(columns), tmp_path / "a.parquet")
    found = read(tmp_path / "a.parquet")
    assert np.allclose(found.gyr, source.gyr, rtol=1e-15, atol=0)
    assert np.array_equal(found.acc, source.acc.astype(np.float32))
    assert np.array_equal(found.device_quat, source.ref)
    assert np.array_equal(found.mask, source.mask)
    assert found.meta["assumed_units"] == {"t": "s", "acc": "m/s²"}
    assert found.meta["ignored_columns"] == ["label", "linear.ax", "linear.ay", "linear.az"]
    columns["ax"] = columns["label"]
    parquet.write_table(pa.table(columns), tmp_path / "b.parquet")
    with pytest.raises(ValueError, match="column 'ax': expected numbers"):
        read(tmp_path / "b.parquet")


def test_parquet_timestamps_are_times_since_the_first(tmp_path: Path) -> None:
    stamps = np.datetime64("2024-05-01T12:00:00", "ns") + np.arange(5) * np.timedelta64(10, "ms")
    columns = {"timestamp": stamps, "gx": [1, None, 3, 4, 5], "gy": np.ones(5), "gz": np.ones(5)}
    parquet.write_table(pa.table(columns), tmp_path / "a.parquet")
    found = read(tmp_path / "a.parquet")
    assert found.t.tolist() == [0.0, 0.01, 0.02, 0.03, 0.04]
    assert np.isnan(found.gyr[:, 0]).tolist() == [False, True, False, False, False]


def test_damaged_parquet_is_refused(tmp_path: Path) -> None:
    parquet.write_table(pa.table({"t": np.arange(1000.0)}), tmp_path / "a.parquet")
    whole = (tmp_path / "a.parquet").read_bytes()
    (tmp_path / "b.parquet").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ValueError, match=r"b\.parquet: is not a readable Parquet file"):
        read(tmp_path / "b.parquet")


def test_missing_values_stay_nan(tmp_path: Path) -> None:
    rows = ["0,1,2,3,1,1,1", "1,,,,1,1,1", "2,NaN,nan,NA,,null,None", "3,1,2,3,1,1,1"]
    found = read(write_text(tmp_path / "a.csv", "t,gx,gy,gz,mx,my,mz", rows))
    assert found.mag is not None
    assert np.isnan(found.gyr).all(axis=1).tolist() == [False, True, True, False]
    assert np.isnan(found.mag).all(axis=1).tolist() == [False, False, True, False]
    assert found.meta["repairs"] == []


def test_infinite_values_become_nan_and_are_told(tmp_path: Path) -> None:
    rows = ["0,1,2,3", "1,inf,2,-inf", "2,1e400,2,3", "3,1,2,3"]
    found = read(write_text(tmp_path / "a.csv", "t,gx,gy,gz", rows))
    assert np.isnan(found.gyr).any(axis=1).tolist() == [False, True, True, False]
    assert found.gyr[1, 1] == 2.0
    assert found.meta["repairs"] == ["gyr: 3 infinite values turned into NaN"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,gx,gy,gz\n", "has a header, but no rows"),
        ("t,gx,gy,gz", "has a header, but no rows"),
        ("t,gx,gy,gz\n0,1,2\n1,1,2,3\n", "line 2: expected 4 cells, got 3"),
        ("t,gx,gy,gz\n0,1,2,3\n1,1,2,3,4\n2,1,2,3\n", "line 3: expected 4 cells, got 5"),
        ("t,gx,gy,gz\n0,1,2,3\n1,1,2,3,4\n", "line 3: expected 4 cells, got 5"),
        ("t,gx,gy,gz\n0,1,2,3\n1,oops,2,3\n", "column 'gx': .*invalid value 'oops'"),
        ("t,gx,gy,gz\n0,1,2,3\n1,1,2,3\n2,1,2,0x1\n", "column 'gz': .*invalid value '0x1'"),
        ("t,gx,gy,gz,mask\n0,1,2,3,maybe\n", "column 'mask': expected true and false or 1 and 0"),
        ("\n\n \n", "is of no known format"),
        ("t,gx,gy,gz\n0,1,2,3\n\0\0\0\0", "is of no known format"),
        ("t,gx,gy,gz\n0,1,2,3\n", "rate: expected a number"),
        ("t,gx,gy,gz\n,1,2,3\n,1,2,3\n", "t: expected at least two valid times, got 0"),
        ("t,gx,gy,gz\n3,1,2,3\n2,1,2,3\n", "t: expected times that increase"),
    ],
)
def test_damaged_text_is_refused_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=message) as error:
        read(path)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_last_row_that_is_cut_off_is_left_out_and_told(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,gx,gy,gz\n0,1,2,3\n1,1,2,3\n2,1,2")
    found = read(tmp_path / "a.csv")
    assert len(found) == 2
    assert found.meta["repairs"] == ["last row is cut off: left out"]


def test_large_table_is_read_exactly(tmp_path: Path) -> None:
    count = 100_000
    random = np.random.default_rng(0)
    table = np.column_stack((np.arange(count) / 1000, random.standard_normal((count, 9)) * 10))
    path = tmp_path / "a.csv"
    np.savetxt(path, table, fmt="%.17g", delimiter=",", header="t,gx,gy,gz,ax,ay,az,mx,my,mz", comments="")
    found = read(path)
    assert len(found) == count
    assert np.array_equal(np.column_stack((found.t, found.gyr, found.acc, found.mag)), table)
