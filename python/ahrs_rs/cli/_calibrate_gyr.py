"""``ahrs-rs calibrate gyr`` and ``ferraris``: rests and turns of a recording."""

from __future__ import annotations

import argparse
import itertools
import math
import warnings

import numpy as np

from ahrs_rs import calibration
from ahrs_rs._printable import printable
from ahrs_rs._recording import Recording
from ahrs_rs._typing import FloatArray
from ahrs_rs.calibration import CalibrationWarning
from ahrs_rs.cli import _calibrate_output
from ahrs_rs.cli._common import CliError
from ahrs_rs.cli._place import Place

#: An axis is up or down, or is that of a turn, where it has so much of the whole: within 26°.
SIDE = 0.9
#: A motion is the turn that is told where its angle is so many times that one: a quarter turn is no half.
SAME_ANGLE = (0.75, 1.33)


def gyroscope(args: argparse.Namespace) -> int:
    """The command for gyroscopes."""
    _calibrate_output.check_outputs(args)
    if len(args.files) != 1:
        raise CliError(f"expected one recording of a gyroscope, got {len(args.files)}")
    (recording,) = _calibrate_output.read(args)
    caught: list[warnings.WarningMessage] = []
    if args.reference:
        if recording.ref is None:
            raise CliError(f"--reference: {args.files[0]} has no reference")
        found = calibration.gyroscope_from_reference(recording.require("gyr"), recording.ref, t=recording.t)
    else:
        turns = _turns(args.turns) if args.turns else []
        rests = calibration.gyroscope_rests(recording.require("gyr"), recording.rate)
        gyr = recording.require("gyr")
        rest = np.concatenate([gyr[part] for part in rests])
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", CalibrationWarning)
            found = calibration.gyroscope(rest, _cut(recording, rests, turns))
    print(f"gyr        {printable(args.files[0])}")
    for k, axis in enumerate("xyz"):
        gain = ""
        if (args.turns or args.reference) and np.isfinite(found.gain_std[k, k]):
            gain = f"gain {found.gain[k, k]:.6g} ± {found.gain_std[k, k]:.2g}, "
        print(f"{axis}          {gain}bias {found.bias[k]:.6g} ± {found.bias_std[k]:.2g} rad/s")
    for one in caught:
        print(f"note       {one.message}")
    _calibrate_output.print_told([recording])
    _calibrate_output.write(args, found.calibration, recordings=[recording])
    return 0


def ferraris(args: argparse.Namespace) -> int:
    """The command for six positions and turns: both sensors, from one recording or several in order."""
    _calibrate_output.check_outputs(args)
    told = _turns(args.turns)
    positions: list[tuple[FloatArray, FloatArray]] = []
    turns: list[calibration.Turn] = []
    recordings = _calibrate_output.read(args)
    for recording in recordings:
        gyr, acc = recording.require("gyr"), recording.require("acc")
        rests = calibration.gyroscope_rests(gyr, recording.rate)
        positions += [(acc[part], gyr[part]) for part in rests if _is_side(acc[part])]
        turns += _named(recording, rests, told[len(turns) :])
    if len(turns) != len(told):
        axis, angle = told[len(turns)]
        raise CliError(
            f"--turns: {axis}={math.degrees(angle):g} is not in the recordings; found before it: {len(turns)} turns"
        )
    found = calibration.ferraris(positions, turns, gravity=Place.of(args, recordings[0]).gravity(args.gravity))
    print(f"ferraris   {' '.join(map(printable, args.files))}: {len(positions)} positions, {len(turns)} turns")
    for name, unit, gain, bias in (
        ("acc", "m/s²", found.acc_gain, found.acc_bias),
        ("gyr", "rad/s", found.gyr_gain, found.gyr_bias),
    ):
        for k, axis in enumerate("xyz"):
            row = " ".join(f"{one:9.6f}" for one in gain[k])
            print(f"{name} {axis}      gain ({row}), bias {bias[k]:.6g} {unit}")
    missed = math.degrees(np.abs(found.gyr_residual).max())
    print(f"residual   {np.abs(found.acc_residual).max():.3g} m/s² and {missed:.3g}° at most")
    _calibrate_output.print_told(recordings)
    _calibrate_output.write(args, found.calibrations, recordings=recordings)
    return 0


def _is_side(acc: FloatArray) -> bool:
    """Whether the sensor lay on one of its sides: else it was put down for a turn."""
    mean = np.nanmean(acc, axis=0)
    return bool(np.abs(mean).max() >= SIDE * np.linalg.norm(mean))


def _named(recording: Recording, rests: list[slice], told: list[tuple[str, float]]) -> list[calibration.Turn]:
    """The turns that are told, in their order, among all motions between rests."""
    gyr = recording.require("gyr")
    found: list[calibration.Turn] = []
    for part, angle in _motions(recording, rests):
        if len(found) == len(told):
            break
        axis, wanted = told[len(found)]
        along = angle["xyz".index(axis)] / wanted
        if SAME_ANGLE[0] <= along <= SAME_ANGLE[1] and abs(along * wanted) >= SIDE * np.linalg.norm(angle):
            found.append(calibration.Turn(gyr[part], axis, wanted, t=recording.t[part]))
    return found


def _motions(recording: Recording, rests: list[slice]) -> list[tuple[slice, FloatArray]]:
    """What is between the rests, where it is a turn: its samples, and by how much, rad."""
    gyr = recording.require("gyr")
    bias = np.nanmean(np.concatenate([gyr[part] for part in rests]), axis=0)
    between = []
    for before, after in itertools.pairwise(rests):
        part = slice((before.start + before.stop) // 2, (after.start + after.stop) // 2)
        angle = np.nansum((gyr[part] - bias)[1:] * np.diff(recording.t[part])[:, None], axis=0)
        if np.linalg.norm(angle) > 0.5:
            between.append((part, angle))
    return between


def _turns(text: str) -> list[tuple[str, float]]:
    turns = []
    for one in text.split(","):
        axis, _, angle = (part.strip() for part in one.partition("="))
        try:
            turns.append((axis, math.radians(float(angle))))
        except ValueError:
            axis = ""
        if axis not in tuple("xyz"):
            raise CliError(f"--turns: expected AXIS=DEG like x=360, got {one!r}")
    return turns


def _cut(recording: Recording, rests: list[slice], turns: list[tuple[str, float]]) -> list[calibration.Turn]:
    """What is between the rests, where it is one of the turns that are known."""
    if not turns:
        return []
    gyr = recording.require("gyr")
    between = [part for part, _ in _motions(recording, rests)]
    if len(between) != len(turns):
        raise CliError(f"--turns: the recording has {len(between)} turns between its rests, got {len(turns)}")
    return [
        calibration.Turn(gyr[part], axis, angle, t=recording.t[part])
        for part, (axis, angle) in zip(between, turns, strict=True)
    ]
