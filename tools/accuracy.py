"""Errors of every filter on the BROAD and RepoIMU recordings: `make accuracy`, kept as docs/accuracy.md.

The recordings are found through the environment variable AHRS_RS_DATA (folders `broad/` and `repoimu/`).
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import ahrs_rs as ar

sys.path.insert(0, str(Path(__file__).parent))

import accuracy_selfcal
from accuracy_scores import aligned_scores, scores, table

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "accuracy.md"

HEAD = """# Accuracy

Made by `make accuracy` on {count} recordings of BROAD (Laidig, Caruso, Cereatti, Seel, Data 6(7):72, 2021; optical
truth, 285.7 Hz): mean over the recordings of the RMSE in degrees, over the samples with movement, of the total, the
heading and the inclination error. 9D unless said; where a parameter is not given it is the default. A 6D filter has the
heading of its start, so its total and heading errors show the gyroscope's drift.

"""

EXPLANATION = """
The references for these recordings: Madgwick with the paper's gradient 4.94 / 3.77 / 2.73 at β = 0.1 and 4.84 / 3.80 /
2.52 at β = 0.08, with the tangent gradient 4.83 total at 0.08; Mahony 11.3 / 10.0 / 4.7 at kp = 0.74, ki = 0.0012. With
the papers' first-order step they come out to the digit; the exponential map changes the third one.

VQF and BasicVQF equal the package of their authors to 1e-12 rad, so that its errors are theirs: 2.32 / 2.17 / 0.59 and
3.90 / 3.72 / 0.99. OfflineVQF equals it to 1e-9 rad, and knows the future: 1.84 / 1.73 / 0.47. Without 30 % of the
samples, at random but with true times, VQF's total is 2.80, with gyr_hold="linear" 2.52; the rest taken for samples at
a fixed rate gives 55.5.

MEKF's defaults were chosen on these recordings. Its error is bounded by the vibrating phone (27), where the heading is
7° off, and on the others by the heading of the magnetometer. EKF estimates no bias and trusts the accelerometer as far
as a robot arm allows, so that external acceleration tilts it and the field is then seen tilted. LinearKalman and DcmImu
are 6D: only their inclination can be compared, and DcmImu's is bounded by the fast translations (16, 18, 30), where the
acceleration does not average out within its memory.

Fusion is the imufusion package's filter: imufusion 1.3.3 itself, at its defaults, gives 16.18 / 11.84 / 7.93 on these
recordings, whether it starts at the identity (of its NWU) or is seeded with the alignment to the first sample. The
recordings rest for 26 s or more before the movement that is scored; the identity is wrong by some 90° there, which the
gain of the start has taken back to 0.1° within 0.8 s. So starting from the first sample saves that second, and nothing
of the score; where the identity is 180° off it saves the wait for noise, which alone leads away from there. Its
published gain of 0.5 rad/s forgets the gyroscope within two seconds, too soon for the translations and magnets here.
"""

REPOIMU = """
## RepoIMU

The same for the filters that use a magnetometer, at their defaults, on {count} recordings of RepoIMU (Szczęsna et al.,
ICCVG 2016; optical truth, 90 to 100 Hz). The optical frames are rotated against the sensor's and against north, and
nobody knows by how much: for each recording and filter the rotations and the offset of the clocks that fit best
(`ar.metrics.align`) are taken out, and with them every constant error. Where a recording turns about one axis only,
the rotation of the sensor frame about it is not observable, and whatever fits best is taken; these are
{lacking}.
Total error by recording, then the means.

"""

#: The settings of x-io's own example, and smaller gains.
FUSION: list[dict[str, Any]] = [
    {
        "bias": True,
        "gyroscope_range": 2000.0,
        "acceleration_rejection": 10.0,
        "magnetic_rejection": 10.0,
        "rejection_timeout": 5.0,
    },
    {"bias": True, "gain": 0.2},
    {"bias": True, "gain": 0.05},
]


def parameter_sets() -> list[tuple[str, dict[str, Any]]]:
    """One row each: the references, then every filter at its defaults and with each of its presets."""
    rows: list[tuple[str, dict[str, Any]]] = [
        ("Madgwick", {"beta": beta, "gradient": gradient, "integration": integration})
        for gradient in ("paper", "tangent")
        for beta in (0.08, 0.1)
        for integration in ("first-order", "exponential")
    ]
    rows += [
        ("Mahony", {"kp": 0.74, "ki": 0.0012, "integration": "first-order"}),
        ("Mahony", {"kp": 0.74, "ki": 0.0012}),
    ]
    for name, cls in ar.FILTERS.items():
        rows.append((name, {}))
        for param in cls.PARAMS.values():
            if param.options and param.name not in ("integration", "gradient"):
                rows += [(name, {param.name: option}) for option in param.options if option != param.default]
        rows += [(name, {"preset": preset}) for preset in cls.PRESETS]
    return rows + [("Fusion", parameters) for parameters in FUSION]


def repoimu(recordings: list[ar.Recording], names: list[str]) -> str:
    """The section on RepoIMU."""
    head = ["filter", *names, "total", "heading", "inclination"]
    lines = []
    lacking: set[str] = set()
    for name, cls in ar.FILTERS.items():
        if cls.MAGNETOMETER:
            rows, found = aligned_scores(name, {}, recordings)
            lacking |= {which for which, one in zip(names, found, strict=True) if not one.determined}
            numbers = [*rows[:, 0], *rows.mean(axis=0)]
            lines.append([name, *(f"{number:.2f}" for number in numbers)])
    shown = ", ".join(which for which in names if which in lacking) or "none of these"
    return REPOIMU.format(count=len(recordings), lacking=shown) + table(head, lines)


def main() -> int:
    folder = os.environ.get("AHRS_RS_DATA")
    files = sorted(Path(folder, "broad").glob("*.hdf5")) if folder else []
    if not files:
        print("accuracy: set AHRS_RS_DATA to the folder that holds broad/*.hdf5", file=sys.stderr)
        return 2
    recordings = [ar.read(file) for file in files]
    lines = []
    for name, keywords in parameter_sets():
        means = scores(name, keywords, recordings).mean(axis=0)
        shown = ", ".join(f"{key}={value}" for key, value in keywords.items()) or "defaults"
        lines.append([name, shown, *(f"{mean:.2f}" for mean in means)])
    head = ["filter", "parameters", "total", "heading", "inclination"]
    text = HEAD.format(count=len(files)) + table(head, lines, texts=2) + EXPLANATION
    others = sorted(Path(folder, "repoimu").glob("*.csv"))
    repo_recordings, repo_names = [ar.read(file) for file in others], [file.stem.replace("_", " ") for file in others]
    if others:
        text += repoimu(repo_recordings, repo_names)
    broad_names = [file.stem[:2] for file in files]
    text += accuracy_selfcal.sections(recordings, broad_names, repo_recordings, repo_names)
    DOCUMENT.write_text(text, encoding="utf-8")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
