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
from ahrs_rs.calibration import Calibration, CalibrationError, CalibrationWarning, EllipsoidFit

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "calibration.md"
FILTERS = ("VQF", "Madgwick")
#: The recordings of slow rotation, in which the sensor was turned in more directions than in most others.
COMMON = ("02_", "05_")

HEAD = """# Calibration

Made by `make calibration` on the recordings of BROAD and RepoIMU. Deviation: standard deviation of the magnetometer's norm
over its mean, in % (the measure of Cirillo et al. 2014), over all samples, outliers included.

## Each recording by itself

`ar.calibration.magnetometer` with 6 and with 9 parameters; a dash is a recording that does not determine them, which is
refused with an error that says what is missing. Coverage: share of 72 cells of equal area of the sphere that the field was
seen in; observability: information about the least known combination of the 9 parameters, over that of evenly spread
directions (below 0.02 it is refused), by the 6-parameter fit where the 9 are refused.

"""

HEADING = """
## Heading

RMSE of the heading in degrees over the samples with movement, defaults of the filters, 9D: raw, by the calibration of the
recording itself (6 and 9 parameters), and by one calibration of the recordings 02 and 05 together (9 parameters) for all.
RepoIMU's truth differs from north and from the sensor by constant rotations, so it has no heading error to speak of.

"""

EXPLANATION = """
BROAD's magnetometer comes calibrated: what is left of its deviation is the field of the room, which differs from place to
place by a few percent and is no error of the sensor. It is correlated over a hundred to two thousand readings, so that a
recording of 53,000 of them tells what 30 to 500 independent ones do, and the fits say so: a scale is known to 0.5 % to 2 %,
not to the 0.01 % that white noise would give. That is as much as they change, and so the heading becomes better on some
recordings and worse on others. A calibration is worth having where a sensor has none: hard iron of 10 µT on each axis, put
on the recordings 02 and 05 here, makes VQF's heading error {iron_before:.1f}°, and their own calibration takes it back to
{iron_after:.1f}° ({raw:.1f}° without the iron).

The attached magnets (32, 35) were put on and taken off during the recordings, which no constant calibration describes: both
are refused. Translations (10 to 18, 27) do not turn the sensor enough. RepoIMU's T-sticks were turned about one axis at a
time, each recording in few attitudes: all are refused, alone and taken together.
"""


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
        "| recording | before | 6 | 9 | 02 and 05 | coverage | observability | refused |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | --- |",
    ]
    for name, recording in recordings:
        assert recording.mag is not None
        six, nine = fitted(recording.mag, 6), fitted(recording.mag, 9)
        after = [one.deviation_after if isinstance(one, EllipsoidFit) else None for one in (six, nine)]
        best = next((one for one in (nine, six) if isinstance(one, EllipsoidFit)), None)
        said = {str(n): one.removeprefix("mag: ") for n, one in ((6, six), (9, nine)) if isinstance(one, str)}
        reason = f"{' and '.join(said)}: {list(said.values())[0]}" if said else ""
        group = common.get(name.partition(" ")[0])
        joint = None if group is None else deviation(group.apply(recording.mag))
        lines.append(
            f"| {name} | {deviation(recording.mag):.2f} | {shown(after[0])} | {shown(after[1])} | {shown(joint)} "
            f"| {'–' if best is None else f'{best.coverage:.0%}'} "
            f"| {'–' if best is None else f'{best.observability:.3f}'} | {reason} |"
        )
    return lines


def headings(recordings: list[tuple[str, ar.Recording]], common: Calibration) -> list[str]:
    columns = [f"{name} {kind}" for name in FILTERS for kind in ("raw", "6", "9", "02 and 05")]
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
    assert isinstance(fitted(sticks, 6), str), "the text says that the T-sticks together are refused"
    common = {"BROAD": joint.calibration}
    text = HEAD + "\n".join(deviations(read + others, common)) + "\n" + HEADING
    text += "\n".join(headings(read, joint.calibration)) + "\n" + EXPLANATION.format(**with_iron(turned))
    DOCUMENT.write_text(text, encoding="utf-8")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
