"""The samples of devices that AHRS_RS_DATA names: each is read right, or refused by a line that says what to do."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from commands import DATA, needs_data
from reading import needs

FOLDER = Path(DATA) / "formats"

#: Sample -> package, options, samples and rate (Hz) of the gyroscope, what holds of the recording.
READ: dict[str, tuple[str, dict[str, Any], int, float, Callable[[ar.Recording], bool]]] = {
    "apdm_format7.csv": ("pyarrow", {"sensor": "Right Foot"}, 3, 128, lambda r: near(r.acc[0], [-3.73, 3.11, 8.51])),
    "apdm_v5_made.h5": ("h5py", {}, 300, 128, lambda r: near(r.mag[0], [20, 0, -40]) and r.ref is None),
    "ardupilot_made.bin": ("pymavlink", {"sensor": "IMU1"}, 200, 50, lambda r: near(r.acc[0], [0, 0, -9.31])),
    "euroc_imu0_data.csv": ("pyarrow", {}, 200, 200, lambda r: near(r.acc[0], [9.099, 0.1, -3.599])),
    "imu_ros1.bag": ("rosbags", {}, 3, 1, lambda r: near(r.gyr[0], [0.1, 0.2, 0.3]) and r.t[0] == 0.0),
    "imu_ros2.mcap": ("rosbags", {}, 3, 1, lambda r: r.meta["start"] == "2023-11-14T22:13:20+00:00"),
    "movella_dot_custom5.csv": ("pyarrow", {}, 600, 60, lambda r: near(r.gyr[0], np.radians([0.0063, -0.0066, 0.032]))),
    "phyphox_gyroscope_decimal_comma.csv": ("pyarrow", {}, 50, 100, lambda r: near(r.gyr[0], [-0.0249, 0.1, 0])),
    "sensorlogger_Gyroscope.csv": ("pyarrow", {}, 200, 100, lambda r: near(r.gyr[0], [0.1, 0.197, 0.302])),
    "shimmer_consensys.csv": ("pyarrow", {}, 200, 73.14, lambda r: near(r.gyr[0], [np.pi / 2, 0.0087, -0.0087])),
    "telemachus_made.parquet": ("pyarrow", {}, 200, 100, lambda r: near(r.acc[0], [0, 0, 9.81])),
    "ximu3_device": (
        "pyarrow",
        {},
        400,
        400,
        lambda r: near(r.acc[0], [0, 0, 9.80665]) and len(r.streams["mag"]) == 20,
    ),
    "xsens_mtmanager_semicolon.txt": (
        "pyarrow",
        {"rate": 100.0},
        5,
        100,
        lambda r: near(r.acc[0], [0.07, -0.04, 9.92]),
    ),
    "xsens_mtmanager_with_date.txt": ("pyarrow", {}, 600, 100, lambda r: near(r.gyr[0], [0, 0, 0.1])),
}
#: Sample -> package, what the refusal says.
REFUSED = {
    "apdm_format7.csv": ("pyarrow", r"give sensor= .*'Lumbar', 'Right Ankle'"),
    "ardupilot_made.bin": ("pymavlink", r"give sensor= .*'IMU0', 'IMU1'"),
    "imu_made.c3d": ("ezc3d", r"state no unit: give it, as units="),
    "xsens_mtmanager_semicolon.txt": ("pyarrow", r"give rate="),
}


def near(found: Any, expected: Any) -> bool:
    """Equal to the digits that stand in the table above."""
    return bool(np.allclose(found, expected, atol=6e-3))


@needs_data
@pytest.mark.filterwarnings("ignore::ahrs_rs.DataWarning")
@pytest.mark.parametrize("name", [pytest.param(name, marks=needs(row[0])) for name, row in READ.items()])
def test_a_sample_is_read_right(name: str) -> None:
    _, options, count, rate, holds = READ[name]
    rec = ar.read(FOLDER / name, **options)
    assert len(rec.streams["gyr"]) == count
    assert rec.rate == pytest.approx(rate, rel=1e-3)
    assert holds(rec)


@needs_data
@pytest.mark.parametrize("name", [pytest.param(name, marks=needs(row[0])) for name, row in REFUSED.items()])
def test_a_sample_is_refused_with_what_to_do(name: str) -> None:
    with pytest.raises(ValueError, match=REFUSED[name][1]) as caught:
        ar.read(FOLDER / name)
    assert "\n" not in str(caught.value)


@needs_data
def test_of_sensor_loggers_accelerometer_nothing_becomes_the_specific_force() -> None:
    with pytest.warns(ar.DataWarning, match="without gravity only"):
        rec = ar.read(FOLDER / "sensorlogger_Accelerometer.csv")
    assert list(rec.streams) == ["linear_acceleration"]
