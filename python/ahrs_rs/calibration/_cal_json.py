"""cal.json: a readable, versioned file with the numbers of each calibrated sensor."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ahrs_rs import _atomic, _json
from ahrs_rs._stored import shown

FORMAT = "ahrs_rs.calibration"
VERSION = 1
#: The sensors in the order of the file, with the unit of what is calibrated.
UNITS = {"gyr": "rad/s", "acc": "m/s²", "mag": "µT"}
MODEL = "y = S (x - b)"


def read(path: Path) -> dict[str, Any]:
    """What the file holds of each sensor, unchecked; ``ValueError`` where it is no such file."""
    try:
        content = _json.read(path)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ValueError(f'{path}: is not a calibration: no "format": "{FORMAT}"')
    if content.get("version") != VERSION:
        raise ValueError(f"{path}: expected version {VERSION} of the format, got {shown(content.get('version'))}")
    if content.get("model", MODEL) != MODEL:
        raise ValueError(f"{path}: model: expected {MODEL!r}, got {shown(content['model'])}")
    unknown = [key for key in content if key not in (*UNITS, "format", "version", "model")]
    if unknown:
        raise ValueError(f"{path}: expected the sensors {', '.join(UNITS)}, got {shown(unknown[0])}")
    return {sensor: content[sensor] for sensor in UNITS if sensor in content}


def write(path: str | os.PathLike[str], sensors: Mapping[str, Any]) -> None:
    """Write the numbers of the sensors; ``ValueError`` where there are none, or the name does not end in .json."""
    path = Path(path)
    if path.suffix.lower() != ".json":
        raise ValueError(f"path: expected a name that ends in .json, got {path.name!r}")
    if not sensors:
        raise ValueError("expected at least one sensor with a calibration, got none")
    text = json.dumps(
        {"format": FORMAT, "version": VERSION, "model": MODEL, **sensors},
        indent=2,
        ensure_ascii=False,
        allow_nan=False,
    )
    # Rows of numbers stand in one line.
    text = re.sub(r"\[[^][{}]*\]", lambda found: " ".join(found[0].split()).replace("[ ", "["), text)
    _atomic.write_text(path, text.replace(" ]", "]") + "\n")


def check_sensor(sensor: str) -> None:
    """Raise a ``ValueError`` where the file has no such sensor."""
    if sensor not in UNITS:
        raise ValueError(f"sensor: expected one of {', '.join(UNITS)}, got {sensor!r}")
