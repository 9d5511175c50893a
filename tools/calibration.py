"""Magnetometer calibration on real recordings: `make calibration`, kept as docs/calibration.md.

The recordings are found through the environment variable AHRS_RS_DATA (folders `broad/` and `repoimu/`).
"""

from __future__ import annotations

import dataclasses
import os
import sys
import warnings
from pathlib import Path

import numpy as np

import ahrs_rs as ar

sys.path.insert(0, str(Path(__file__).parent))

from accuracy_scores import scores

from ahrs_rs.calibration import Calibration, CalibrationError, CalibrationWarning, EllipsoidFit

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "calibration.md"
FILTERS = ("VQF", "Madgwick")
#: The recordings of slow rotation, in which the sensor was turned in more directions than in most others.
COMMON = ("02_", "05_")

HEAD = """# Calibration

Made by `make calibration` on the recordings of BROAD and RepoIMU. Deviation: standard deviation of the magnetometer's
norm over its mean, in % (the measure of Cirillo et al. 2014), over all samples, outliers included.

## Each recording by itself

`ar.calibration.magnetometer` with 6 and with 9 parameters; a dash is a recording that does not determine them, which
is refused with the error in the last column. Joint: one calibration for all recordings of a sensor, fitted on 02 and 05
together (BROAD, 9 parameters) and on the three T-sticks together (RepoIMU, 6 parameters; 9 are {sticks}). Coverage:
share of 72 cells of equal area of the sphere that the field was seen in; observability: information about the least
known combination of the parameters, over that of evenly spread directions (below 0.02 it is refused).

"""

HEADING = """
## Heading

RMSE of the heading in degrees over the samples with movement, defaults of the filters, 9D: raw, by the calibration of
the recording itself (6 and 9 parameters), and by the joint one. RepoIMU is left out: its truth differs from north and
from the sensor by constant rotations.

"""

EXPLANATION = """
BROAD's magnetometer comes calibrated: what is left of its deviation is the field of the room, which differs from place
to place by a few percent and is no error of the sensor. It is correlated over {correlation} readings, so that a
recording of 53,000 of them tells what some hundred independent ones do, and the fits say so: a scale is known to
{known} of itself, not to the 0.01 % that white noise would give. That is as much as they change, and so the
heading becomes better on some recordings and worse on others. A calibration is worth having where a sensor has none:
hard iron of 10 µT on each axis, put on the recordings 02 and 05 here, makes VQF's heading error {iron_before:.1f}°,
and their own calibration takes it back to {iron_after:.1f}° ({raw:.1f}° without the iron).

The magnets of 32 and 35 were put on during the recordings and taken off again (the norm is that of the room at both
ends), which no constant calibration describes.
"""


DELAY = """
## Delay of the magnetometer

`ar.calibration.mag_delay`: how late the magnetometer is behind the gyroscope, with its standard error, the windows of a
second that it was found in, and what the field varies by in them beyond what was estimated, in % of its norm. The
magnet of 32 moves with the sensor, and is no hard iron as it comes and goes. Then the mean RMSE in degrees (total /
heading) on BROAD without and with `mag_delay=`{together:.4f}, the mean of BROAD's by their standard errors.

"""


def delays(recordings: list[tuple[str, ar.Recording]]) -> list[str]:
    lines = ["| recording | delay, ms | ± | windows | field, % |", "| --- | ---: | ---: | ---: | ---: |"]
    broad = []
    for name, recording in recordings:
        try:
            found = ar.calibration.mag_delay(recording)
        except CalibrationError as error:
            lines.append(f"| {name} | {str(error).removeprefix('mag: ')} | | | |")
            continue
        if name.startswith("BROAD"):
            broad.append(found)
        numbers = f"{1e3 * found.delay:.2f} | {1e3 * found.standard_error:.2f} | {found.windows}"
        lines.append(f"| {name} | {numbers} | {100 * found.residual:.2f} |")
    weights = [one.standard_error**-2 for one in broad]
    together = float(np.average([one.delay for one in broad], weights=weights))
    lines += ["", "| filter | 0 | mag_delay |", "| --- | ---: | ---: |"]
    known = [recording for name, recording in recordings if name.startswith("BROAD")]
    for name, cls in ar.FILTERS.items():
        if "mag_delay" in cls.PARAMS:
            cells = [delayed(known, name, delay) for delay in (0.0, together)]
            lines.append(f"| {name} | {' | '.join(cells)} |")
    return [DELAY.format(together=together) + lines[0], *lines[1:]]


def delayed(recordings: list[ar.Recording], name: str, delay: float) -> str:
    """Mean errors, total and heading."""
    total, heading, _ = scores(name, {"mag_delay": delay}, recordings).mean(axis=0)
    return f"{total:.2f} / {heading:.2f}"


def fitted(mag: np.ndarray, parameters: int) -> EllipsoidFit | str:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", CalibrationWarning)  # RepoIMU's unit is its own
            return ar.calibration.magnetometer(mag, parameters=parameters)
    except CalibrationError as error:
        return str(error)


def deviation(mag: np.ndarray) -> float:
    norm = np.linalg.norm(mag[~np.isnan(mag).any(axis=1)], axis=1)
    return float(100 * norm.std() / norm.mean())


def heading(recording: ar.Recording, name: str, calibration: Calibration | None = None) -> float:
    f = ar.FILTERS[name](rate=recording.rate)
    mag = recording.mag if calibration is None else calibration.apply(recording.mag)
    est = f.run(recording.gyr, recording.acc, mag, t=recording.t)
    return float(ar.metrics.score(est.quat, recording.ref, recording.mask).heading)


def shown(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


def deviations(recordings: list[tuple[str, ar.Recording]], common: dict[str, Calibration]) -> list[str]:
    lines = [
        "| recording | before | 6 | 9 | joint | coverage | observability | refused |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | --- |",
    ]
    for name, recording in recordings:
        assert recording.mag is not None
        six, nine = fitted(recording.mag, 6), fitted(recording.mag, 9)
        after = [one.deviation_after if isinstance(one, EllipsoidFit) else None for one in (six, nine)]
        best = next((one for one in (nine, six) if isinstance(one, EllipsoidFit)), None)
        said = {str(n): one.removeprefix("mag: ") for n, one in ((6, six), (9, nine)) if isinstance(one, str)}
        reason = f"{' and '.join(said)}: {next(iter(said.values()))}" if said else ""
        group = common.get(name.partition(" ")[0])
        joint = None if group is None else deviation(group.apply(recording.mag))
        lines.append(
            f"| {name} | {deviation(recording.mag):.2f} | {shown(after[0])} | {shown(after[1])} | {shown(joint)} "
            f"| {'–' if best is None else f'{best.coverage:.0%}'} "
            f"| {'–' if best is None else f'{best.observability:.3f}'} | {reason} |"
        )
    return lines


def headings(recordings: list[tuple[str, ar.Recording]], common: Calibration) -> list[str]:
    columns = [f"{name} {kind}" for name in FILTERS for kind in ("raw", "6", "9", "joint")]
    lines = [f"| recording | {' | '.join(columns)} |", f"| --- |{' ---: |' * len(columns)}"]
    rows = []
    for label, recording in recordings:
        assert recording.mag is not None
        own = [fitted(recording.mag, parameters) for parameters in (6, 9)]
        row: list[float | None] = []
        for name in FILTERS:
            row.append(heading(recording, name))
            row += [heading(recording, name, one.calibration) if isinstance(one, EllipsoidFit) else None for one in own]
            row.append(heading(recording, name, common))
        rows.append(row)
        lines.append(f"| {label} | {' | '.join(map(shown, row))} |")
    means = [shown(float(np.mean(column))) if None not in column else "" for column in zip(*rows, strict=True)]
    return [*lines, f"| mean | {' | '.join(means)} |"]


def with_iron(recordings: list[ar.Recording]) -> dict[str, float]:
    """VQF's mean heading error with hard iron, with the calibration of what was recorded so, and without the iron."""
    iron = [dataclasses.replace(one, mag=one.mag + 10.0) for one in recordings if one.mag is not None]
    fit = ar.calibration.magnetometer(np.concatenate([one.mag for one in iron if one.mag is not None]))
    return {
        "raw": float(np.mean([heading(one, "VQF") for one in recordings])),
        "iron_before": float(np.mean([heading(one, "VQF") for one in iron])),
        "iron_after": float(np.mean([heading(one, "VQF", fit.calibration) for one in iron])),
    }


def main() -> int:
    folder = os.environ.get("AHRS_RS_DATA")
    broad = sorted(Path(folder, "broad").glob("*.hdf5")) if folder else []
    repoimu = sorted(Path(folder, "repoimu").glob("*.csv")) if folder else []
    if not (broad and repoimu):
        print("calibration: set AHRS_RS_DATA to the folder that holds broad/ and repoimu/", file=sys.stderr)
        return 2
    read = [(f"BROAD {path.stem}", ar.read(path)) for path in broad]
    others = [(f"RepoIMU {path.stem}", ar.read(path)) for path in repoimu]
    turned = [one for name, one in read if name.removeprefix("BROAD ").startswith(COMMON)]
    joint = fitted(np.concatenate([one.mag for one in turned if one.mag is not None]), 9)
    sticks = np.concatenate([one.mag for name, one in others if "TStick" in name and one.mag is not None])
    assert isinstance(joint, EllipsoidFit), joint
    stick, stick9 = fitted(sticks, 6), fitted(sticks, 9)
    assert isinstance(stick, EllipsoidFit), stick
    common = {"BROAD": joint.calibration, "RepoIMU": stick.calibration}
    own = [fitted(one.mag, 6) for _, one in read if one.mag is not None]
    fits = [one for one in own if isinstance(one, EllipsoidFit)]
    known = [float((one.std[:3] / one.values[:3]).max()) for one in fits]
    of = f"{min(one.correlation for one in fits):.0f} to {max(one.correlation for one in fits):.0f}"
    numbers = with_iron(turned) | {"correlation": of, "known": f"{min(known):.1%} to {max(known):.1%}"}
    text = (
        HEAD.format(sticks="refused" if isinstance(stick9, str) else "as well determined")
        + "\n".join(deviations(read + others, common))
        + "\n"
        + HEADING
    )
    text += "\n".join(headings(read, joint.calibration)) + "\n" + EXPLANATION.format(**numbers)
    text += "\n".join(delays(read + others)) + "\n"
    DOCUMENT.write_text(text, encoding="utf-8")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
