"""Every format that is read, in the order in which they are looked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from ahrs_rs.io._contents import Options, SensorData, SensorInfo
from ahrs_rs.io._source import Source

#: Options of a table of columns.
TABLE = frozenset({"columns", "units", "separator", "decimal", "skip_rows", "timezone"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Format:
    """A format: what it is, how it is recognised, how it is read.

    Parameters
    ----------
    title : what it is, in a few words.
    sniff : whether a source is of this format, by its first bytes or the names in it.
    load : sensor -> what the source holds of it; a device with one sensor gives one entry of any name. Where
        ``options.sensor`` is given, that one alone is enough.
    sensors : what is in the source, without reading it whole; None counts what `load` gives.
    endings : of file names that only this format has.
    extra, library : what has to be installed, as ``pip install ahrs-rs[extra]``, and the library that reads it.
    options : those of `Options` that it takes beside axes, rate and sensor; "rate" where the reader itself applies it
        (packet numbers count on over gaps).
    binary : whether it is never text, so that a text is not looked at.
    main : the sensor that is read where none is asked for, of files whose other sensors are parts of it.
    note : what a user has to know, in one sentence.
    """

    title: str
    sniff: Callable[[Source], bool]
    load: Callable[[Source, Options], dict[str, SensorData]]
    sensors: Callable[[Source, Options], list[SensorInfo]] | None = None
    endings: tuple[str, ...] = ()
    extra: str = ""
    library: str = ""
    options: frozenset[str] = frozenset()
    binary: bool = False
    main: str = ""
    note: str = ""


def _of(module: str, name: str) -> Callable[..., Any]:
    """A function of a reader, whose module is imported where it is first called: few of them are needed at a time."""

    def called(*args: Any) -> Any:
        return getattr(import_module(f"{__package__}.{module}"), name)(*args)

    return called


#: Name -> format; the first one whose `sniff` agrees is taken, so the general ones come last.
FORMATS: dict[str, Format] = {
    "px4": Format(
        title="PX4 ULog",
        sniff=_of("_px4", "sniff"),
        binary=True,
        load=_of("_px4", "load"),
        sensors=_of("_px4", "sensors"),
        endings=(".ulg", ".ulog"),
        extra="px4",
        library="pyulog",
        main="sensor_combined",
        note="sensor_combined is read; the single sensors by sensor=.",
    ),
    "dataflash": Format(
        title="ArduPilot DataFlash log",
        sniff=_of("_dataflash", "sniff"),
        binary=True,
        load=_of("_dataflash", "load"),
        sensors=_of("_dataflash", "sensors"),
        extra="mavlink",
        library="pymavlink",
        note="pymavlink is under the LGPL, and is imported only where such a log is read.",
    ),
    "ros": Format(
        title="ROS 1 bag, ROS 2 bag, MCAP",
        sniff=_of("_ros", "sniff"),
        load=_of("_ros", "load"),
        sensors=_of("_ros", "sensors"),
        endings=(".bag", ".mcap", ".db3"),
        extra="ros",
        library="rosbags",
        note="Times are those of the header, not of the recording.",
    ),
    "euroc": Format(
        title="EuRoC/ASL folder with truth, or one of its files",
        sniff=_of("_euroc", "sniff"),
        load=_of("_euroc", "load"),
        extra="io",
        library="pyarrow",
        options=frozenset({"rate"}),
    ),
    "xio": Format(
        title="x-IMU3 or NGIMU folder",
        sniff=_of("_xio", "sniff"),
        load=_of("_xio", "load"),
        endings=(".ximu3",),
        extra="io",
        library="pyarrow",
    ),
    "xsens": Format(
        title="Xsens MT Manager export",
        sniff=_of("_xsens", "sniff"),
        load=_of("_xsens", "load"),
        extra="io",
        library="pyarrow",
        options=frozenset({"rate"}),
    ),
    "dot": Format(
        title="Movella DOT export",
        sniff=_of("_dot", "sniff"),
        load=_of("_dot", "load"),
        extra="io",
        library="pyarrow",
        options=frozenset({"rate"}),
    ),
    "shimmer": Format(
        title="Shimmer export",
        sniff=_of("_shimmer", "sniff"),
        load=_of("_shimmer", "load"),
        extra="io",
        library="pyarrow",
    ),
    "apdm": Format(
        title="APDM (HDF5)",
        sniff=_of("_apdm", "sniff_hdf5"),
        binary=True,
        load=_of("_apdm", "load_hdf5"),
        sensors=_of("_apdm", "sensors_hdf5"),
        extra="io",
        library="h5py",
    ),
    "apdm-csv": Format(
        title="APDM export (CSV)",
        sniff=_of("_apdm", "sniff_csv"),
        load=_of("_apdm", "load_csv"),
        extra="io",
        library="pyarrow",
    ),
    "sensorlogger": Format(
        title="Sensor Logger (folder, zip or one file)",
        sniff=_of("_sensorlogger", "sniff"),
        load=_of("_sensorlogger", "load"),
        extra="io",
        library="pyarrow",
    ),
    "phyphox": Format(
        title="phyphox (folder, zip or one file)",
        sniff=_of("_phyphox", "sniff"),
        load=_of("_phyphox", "load"),
        extra="io",
        library="pyarrow",
    ),
    "axivity": Format(
        title="Axivity AX6 or AX3",
        sniff=_of("_axivity", "sniff"),
        binary=True,
        load=_of("_axivity", "load"),
        sensors=_of("_axivity", "sensors"),
        endings=(".cwa",),
        extra="axivity",
        library="cwa-reader-rs",
    ),
    "c3d": Format(
        title="C3D, inertial sensors among the analog channels",
        sniff=_of("_c3d", "sniff"),
        binary=True,
        load=_of("_c3d", "load"),
        sensors=_of("_c3d", "sensors"),
        endings=(".c3d",),
        extra="c3d",
        library="ezc3d",
        options=frozenset({"units", "rate"}),
        note="Units are often left empty in the file: give units=.",
    ),
    "gopro": Format(
        title="GoPro video",
        sniff=_of("_gopro", "sniff"),
        binary=True,
        load=_of("_gopro", "load"),
        endings=(".mp4", ".mov", ".360"),
        extra="video",
        library="telemetry-parser",
    ),
    "gcsv": Format(
        title="Gyroflow log",
        sniff=_of("_gcsv", "sniff"),
        load=_of("_gcsv", "load"),
        endings=(".gcsv",),
        extra="io",
        library="pyarrow",
    ),
    "sto": Format(
        title="OpenSim orientations (.sto)", sniff=_of("_sto", "sniff"), load=_of("_sto", "load"), endings=(".sto",)
    ),
    "telemachus": Format(
        title="telemachus table",
        sniff=_of("_telemachus", "sniff"),
        binary=True,
        load=_of("_telemachus", "load"),
        extra="io",
        library="pyarrow",
    ),
    "broad": Format(
        title="BROAD trial (HDF5)",
        sniff=_of("_broad", "sniff"),
        binary=True,
        load=_of("_broad", "load"),
        endings=(".hdf5", ".h5"),
        extra="io",
        library="h5py",
    ),
    "npz": Format(
        title="numpy arrays",
        sniff=_of("_npz", "sniff"),
        binary=True,
        load=_of("_npz", "load"),
        endings=(".npz",),
        library="numpy",
    ),
    "parquet": Format(
        title="Parquet table",
        sniff=_of("_table", "sniff_parquet"),
        binary=True,
        load=_of("_table", "load_parquet"),
        endings=(".parquet", ".pq"),
        extra="io",
        library="pyarrow",
        options=TABLE,
    ),
    "repoimu": Format(
        title="RepoIMU recording (CSV)",
        sniff=_of("_repoimu", "sniff"),
        load=_of("_repoimu", "load"),
        extra="io",
        library="pyarrow",
    ),
    "tum": Format(title="TUM trajectory", sniff=_of("_tum", "sniff"), load=_of("_tum", "load"), endings=(".tum",)),
    "csv": Format(
        title="text table",
        sniff=_of("_table", "sniff"),
        load=_of("_table", "load"),
        extra="io",
        library="pyarrow",
        options=TABLE,
    ),
}
