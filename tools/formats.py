"""Makes docs/formats.md: what is read, by which library and version, what it gives and what is lost.

Run by `make formats`. Quantities, units, axes and clocks are what `ahrs_rs.read` says of a file of each format that is
written for it (tests/python/devices); what is lost, and since when the reading is tested, stands here.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "python"))

import ahrs_rs as ar  # noqa: E402
from ahrs_rs import io  # noqa: E402
from devices.samples import SAMPLES  # noqa: E402

PAGE = ROOT / "docs" / "formats.md"
ROWS = 400
#: Package of a sample, as imported -> as installed.
PACKAGES = {"cwa_reader_rs": "cwa-reader-rs", "telemetry_parser": "telemetry-parser"}
#: Since when tests write and read it, with the library of that day.
SINCE = "2026-11-29"

#: Sample -> how it is written in the tests, and what is lost or left out.
LOST = {
    "PX4 ULog": ("bytes by the specification", "drop-outs of the logger (gaps, told); samples beyond the logged rate"),
    "ArduPilot DataFlash": (
        "bytes by the specification",
        "TimeUS is that of logging; batches of raw samples (ISBH, ISBD)",
    ),
    "ROS 1 bag": ("rosbags", "topics other than Imu, MagneticField, FluidPressure, Temperature; covariances"),
    "ROS 2 bag": ("rosbags", "as ROS 1"),
    "MCAP": ("rosbags", "as ROS 1; messages of other encodings than ROS"),
    "EuRoC/ASL folder": ("text by its layout", "cameras; stamps that a spreadsheet rounded are refused"),
    "x-IMU3 folder": ("text by its layout, ximu3", "earth acceleration; what is no motion"),
    "NGIMU folder": ("text by its layout", "what is neither motion nor pressure"),
    "Xsens MT Manager": ("text by its layout", "lost packets (gaps, told); size of the field; FreeAcc, VelInc, OriInc"),
    "Movella DOT": ("text by its layout", "lost packets (gaps, told); size of the field; FreeAcc, dq, dv"),
    "Shimmer": ("text by its layout", "uncalibrated signals; size of the field; biosignals"),
    "APDM HDF5": ("h5py", "annotations, button"),
    "APDM CSV": ("text by its layout", "digits of a pressure that was written as its bytes"),
    "Sensor Logger": ("text by its layout", "uncalibrated sensors beside calibrated ones; location"),
    "phyphox": ("text by its layout", "location, audio, light; pauses are gaps"),
    "Axivity AX6": (
        "bytes by the specification",
        "lost blocks (gaps, told); the time zone of the device's clock; light",
    ),
    "C3D": ("ezc3d", "there is no clock; frames beyond 65,535 (told); markers, forces"),
    "GoPro": ("bytes by the specification", "there is no stamp a sample; lost payloads (gaps, told)"),
    "Gyroflow": ("text by its layout", "what the integers round off"),
    "telemachus": ("pyarrow", "position, events; whether gravity is in, without a manifest"),
}
#: Formats that have been left out, and why.
LEFT_OUT = (
    (
        "x-IMU3",
        "`.ximu3` itself: it is converted by x-io's software; the folder is read, and tested with ximu3's converter",
    ),
    ("Axivity", "the magnetometer of a CWA file, whose unit the format does not state"),
    ("Gyroflow", "`.gyroflow` projects, whose motion is compressed in a form of its own"),
    ("videos", "cameras other than GoPro's: their axes and units could not be checked"),
    ("Sensor Logger", "JSON and SQLite exports: export a zip"),
    ("DataFlash", "`.log` text logs and MAVLink telemetry (`.tlog`): take the `.bin`"),
)
HEAD = """# Formats

Made by `make formats`. `ar.read` knows a format by its content, `ahrs-rs formats` prints the list, and `ar.sensors`
says which sensors are in a file. Everything comes in rad/s, specific force in m/s² and µT; the units below are
those in the files. A device's own orientation is `rec.device_quat`, never the truth. What was assumed, repaired,
ignored or lost in a file is told in one `DataWarning` and stands in `rec.meta`.

The libraries are extras: `pip install ahrs-rs[px4]` and the like. pymavlink is under the LGPL; it is no part of
`[all]`, and it is imported only where a DataFlash log is read. ezc3d and telemetry-parser, which damaged files
crash or make want gigabytes, read in a process of their own with limits of time and memory. `make damage` reads a
thousand damaged files of each format.
"""
#: Columns of the first table.
COLUMNS = (
    "format",
    "read by",
    "extra",
    "streams: unit in the file",
    "axes",
    "clock",
    "lost or left out",
    "written in tests by",
)


def main() -> int:
    """Write the page, or check that it is current."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="do not write; exit status 1 if the page would change")
    options = parser.parse_args()
    page = _page()
    if options.check:
        current = PAGE.read_text(encoding="utf-8") == page
        print(f"{PAGE.relative_to(ROOT)} is {'current' if current else 'not current: make formats'}")
        return 0 if current else 1
    PAGE.write_text(page, encoding="utf-8")
    return 0


def _page() -> str:
    lines = [HEAD, "## What devices write", ""]
    lines += [f"| {' | '.join(COLUMNS)} |", f"| {' | '.join('---' for _ in COLUMNS)} |"]
    with tempfile.TemporaryDirectory() as place:
        for name in SAMPLES:
            lines.append(_row(name, Path(place)))
    lines += [
        "",
        f"All rows are tested since {SINCE}, with the versions that stand in them.",
        "",
        "## Tables and archives",
        "",
    ]
    lines += ["| format | read by | extra | options | note |", "| --- | --- | --- | --- | --- |"]
    devices = {kind for kind, _, _ in SAMPLES.values()}
    for key, known in io.formats().items():
        if key not in devices:
            options = ", ".join(sorted(known.options))
            lines.append(f"| {known.title} | {known.library} | {known.extra} | {options} | {known.note} |")
    lines += ["", "## Left out", ""]
    lines += [f"- {what}: {why}." for what, why in LEFT_OUT]
    return "\n".join(lines) + "\n"


def _row(name: str, place: Path) -> str:
    kind, package, make = SAMPLES[name]
    folder = place / name.replace("/", " ")
    folder.mkdir()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.DataWarning)
        recording = next(iter(ar.read_all(make(folder, ROWS)).values()))
    meta: dict[str, Any] = recording.meta
    units = meta.get("units", {})
    streams = [f"{stream}: {units[stream]}" if stream in units else stream for stream in recording.streams]
    package = PACKAGES.get(package, package)
    written, lost = LOST[name]
    axes = str(meta.get("axes", "the sensor's"))
    cells = [
        f"{name}",
        f"{package} {importlib.metadata.version(package)}",
        io.formats()[kind].extra,
        ", ".join(streams),
        axes,
        str(meta.get("clock", "the sensor's own")),
        lost,
        written,
    ]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    sys.exit(main())
