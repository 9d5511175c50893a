"""Tables of programs that are known by the names of their columns, and what those names do not tell."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs.io._names import Column

FRONT_RIGHT_DOWN = "front-right-down"
#: PX4 writes this where no sample of the accelerometer belongs to one of the gyroscope.
PX4_NO_SAMPLE = 2147483647


@dataclass(frozen=True, slots=True)
class Profile:
    """What is known of the tables of a program.

    Parameters
    ----------
    title : the program.
    source : where it is said.
    needs : names of columns (as they are, or regular expressions) of which a table has to have all.
    units : quantity -> unit of columns that state none.
    columns : header -> quantity of a column that is not what its name seems to tell ("" : nothing that is read).
    axes : those of the device.
    missing : (column, value, quantity): in rows with that value there is no sample of the quantity.
    rate : a column with the rate in Hz, for stamps that are too coarse.
    note : a sentence for `meta`.
    """

    title: str
    source: str
    needs: tuple[str, ...]
    units: Mapping[str, str] = field(default_factory=dict)
    columns: Mapping[str, str] = field(default_factory=dict)
    axes: str = ""
    missing: tuple[str, float, str] | None = None
    rate: str = ""
    note: str = ""

    def fits(self, headers: Sequence[str]) -> bool:
        """Whether a table with these columns is one of this program."""
        names = [header.strip().strip("\"'") for header in headers]
        return all(any(re.fullmatch(need, name) for name in names) for need in self.needs)

    def adapt(self, column: Column) -> Column:
        """A column with the unit that this program writes, where it states none."""
        unit = self.units.get(column.quantity)
        return column if unit is None or column.unit else replace(column, unit=unit)


PROFILES: tuple[Profile, ...] = (
    Profile(
        title="PX4 sensor_combined (ulog2csv)",
        source="PX4 message definition SensorCombined.msg; pyulog's ulog2csv",
        needs=(r"gyro_rad\[0\]", r"accelerometer_m_s2\[0\]"),
        units={"t": "us"},
        axes=FRONT_RIGHT_DOWN,
        missing=("accelerometer_timestamp_relative", PX4_NO_SAMPLE, "acc"),
    ),
    Profile(
        title="ArduPilot IMU message (mavlogdump, pymavlink)",
        source="ArduPilot log message documentation, IMU: GyrX rad/s, AccX m/s/s, T degC",
        needs=("GyrX", "AccX", "(?:TimeUS|EG|EA|GH|AH|I)"),
        units={"t": "us", "gyr": "rad/s", "acc": "m/s2", "temperature": "degC"},
        columns={"T": "temperature", "timestamp": "t:s"},
        axes=FRONT_RIGHT_DOWN,
    ),
    Profile(
        title="ArduPilot MAG message (mavlogdump, pymavlink)",
        source="ArduPilot log message documentation, MAG: MagX mGauss",
        needs=("MagX", "(?:OfsX|MOX|MOfsX)"),
        units={"t": "us", "mag": "mGauss"},
        columns={"timestamp": "t:s"},
        axes=FRONT_RIGHT_DOWN,
    ),
    Profile(
        title="MAVLink SCALED_IMU",
        source="MAVLink common message set: xacc mG, xgyro mrad/s, xmag mgauss, time_boot_ms",
        needs=(r".*time_boot_ms", r".*xacc", r".*xgyro"),
        units={"acc": "mG", "gyr": "mrad/s", "mag": "mgauss"},
        axes=FRONT_RIGHT_DOWN,
    ),
    Profile(
        title="MAVLink HIGHRES_IMU",
        source="MAVLink common message set: xacc m/s/s, xgyro rad/s, xmag gauss, time_usec",
        needs=(r".*xacc", r".*xgyro", r".*(?:abs_pressure|fields_updated)"),
        units={"acc": "m/s2", "gyr": "rad/s", "mag": "gauss"},
        axes=FRONT_RIGHT_DOWN,
    ),
    Profile(
        title="OpenLog Artemis",
        source="SparkFun OpenLog Artemis firmware: aX mg, gX dps, mX uT",
        needs=("aX", "gX", "(?:imu_degC|output_Hz|rtcTime)"),
        units={"acc": "mg", "gyr": "dps", "mag": "uT"},
        rate="output_Hz",
    ),
    Profile(
        title="Betaflight black box (blackbox_decode)",
        source="Betaflight blackbox-tools: time in us, gyroADC in deg/s",
        needs=("loopIteration", r"gyroADC\[0\].*"),
        units={"t": "us", "gyr": "deg/s"},
    ),
    Profile(
        title="ROS (rostopic echo -p)",
        source="ROS wiki, rostopic: times in ns; sensor_msgs/Imu in rad/s and m/s² (REP 145)",
        needs=(r"%?time", r"field\.header\.stamp"),
        units={"t": "ns", "gyr": "rad/s", "acc": "m/s2", "mag": "T"},
    ),
    Profile(
        title="ROS sensor_msgs/Imu",
        source="sensor_msgs/Imu: rad/s, m/s², with gravity (REP 145); MagneticField: tesla",
        needs=(r".*angular_velocity[._/]x", r".*linear_acceleration[._/]x"),
        units={"gyr": "rad/s", "acc": "m/s2"},
    ),
    Profile(
        title="Sensor Logger",
        source="Sensor Logger's README: Accelerometer.csv is without gravity",
        needs=("time", "seconds_elapsed", "x", "y", "z"),
        units={"gyr": "rad/s", "acc": "m/s2", "linear_acceleration": "m/s2", "mag": "uT"},
        columns={"time": "t:ns"},
    ),
)


def profile_of(headers: Sequence[str]) -> Profile | None:
    """The first profile that fits a table with these columns."""
    return next((profile for profile in PROFILES if profile.fits(headers)), None)


def ros_linear_acceleration(headers: Sequence[str]) -> bool:
    """Whether a linear acceleration is that of ROS, which holds gravity: the angular velocity stands beside it."""
    names = [header.lower() for header in headers]
    angular = any("angular_velocity" in name for name in names)
    other = any(re.search(r"gravity|accelerometer|(?:^|[^a-z])acc(?:el)?[^a-z]", name) for name in names)
    return angular and any("linear_acceleration" in name for name in names) and not other


def adapter(headers: Sequence[str], profile: Profile | None) -> Callable[[Column], Column]:
    """What a profile, and ROS's name of the specific force, make of a column."""
    with_gravity = ros_linear_acceleration(headers)

    def adapt(column: Column) -> Column:
        if column.quantity == "linear_acceleration" and with_gravity:
            column = replace(column, quantity="acc")
        if profile is None:
            return column
        told = profile.columns.get(column.header.strip())
        if told is not None:
            quantity, _, unit = told.partition(":")
            column = replace(column, quantity=quantity, axis=0, unit=unit or column.unit)
        return profile.adapt(column)

    return adapt


def without_missing(
    profile: Profile | None, marks: Mapping[str, NDArray[Any]], quantity: str
) -> NDArray[np.bool_] | None:
    """The rows in which a profile says that there is no sample of a quantity, or None."""
    if profile is None or profile.missing is None or profile.missing[2] != quantity:
        return None
    name, value, _ = profile.missing
    return None if name not in marks else np.asarray(marks[name] == value)
