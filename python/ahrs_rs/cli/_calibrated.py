"""The option of commands by which recordings are calibrated."""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from ahrs_rs._recording import Recording

if TYPE_CHECKING:
    from ahrs_rs.calibration import Calibrations


def add_option(parser: argparse.ArgumentParser) -> None:
    """The option of other commands by which recordings are calibrated."""
    parser.add_argument(
        "--calibration",
        metavar="FILE",
        help="cal.json of `ahrs-rs calibrate`, applied to the readings; @NAME is what `calibrate --device NAME` kept "
        "last before the recording's date",
    )


def given(args: argparse.Namespace) -> Calibrations | str | None:
    """The calibrations that `add_option` asks for, or the name of the device that has them."""
    if args.calibration is None:
        return None
    from ahrs_rs import calibration  # here: no other command needs it

    if args.calibration.startswith("@"):
        device: str = args.calibration[1:]
        calibration.find(device, which="closest")  # refuses an unknown one before recordings are read
        return device
    return calibration.load(Path(args.calibration))


def applied(calibrations: Calibrations | str | None, recording: Recording) -> tuple[Recording, list[str]]:
    """The recording with the calibrations, and what is to be known of them."""
    if calibrations is None:
        return recording, []
    from ahrs_rs import calibration

    if isinstance(calibrations, str):
        calibrations = calibration.find(calibrations, recording.meta.get("start"))
    from ahrs_rs.calibration import CalibrationWarning

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", CalibrationWarning)
        result = calibrations.apply(recording)
    notes = [str(one.message) for one in caught]
    lacking = [sensor for sensor, _ in calibrations if getattr(recording, sensor) is None]
    if lacking:
        notes.append(f"calibrated, but not in the recording: {', '.join(lacking)}")
    return result, notes
