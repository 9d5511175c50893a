"""The picture of the README: `make picture`, kept as docs/picture.png.

The recordings of BROAD are found through the environment variable AHRS_RS_DATA (folder `broad/`).
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from matplotlib.figure import Figure

import ahrs_rs as ar

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "picture.png"
#: The recording of the left side, its part, s, and the filter that is drawn.
RECORDING, BEGIN, END, DRAWN = "18_undisturbed_fast_translation_with_breaks_B.hdf5", 76.0, 86.0, "SelfCalKF"
#: From the least to the most accurate: what runs online, at its defaults.
FILTERS = ("Fusion", "Madgwick", "BasicVQF", "VQF", "MEKF", "SelfCalKF")


def picture(folder: Path) -> Figure:
    """Angles of a recording with the optical truth, and the errors of some filters on all of them."""
    files = sorted(folder.glob("*.hdf5"))
    if not files:
        raise SystemExit(f"AHRS_RS_DATA: expected recordings of BROAD in {folder}, found none")
    figure = Figure(figsize=(10.0, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(2.0, 1.0))
    rec = ar.read(folder / RECORDING)
    est = ar.FILTERS[DRAWN]().run(rec)
    begin = rec.t[0]
    part = (rec.t >= begin + BEGIN) & (rec.t <= begin + END)
    ar.plots.angles(est.quat[part], rec.t[part] - begin, ref=rec.require("ref")[part], ax=left)
    left.set_title(f"BROAD {RECORDING[:2]}, a fast translation: {DRAWN} and the optical truth", fontsize="medium")
    left.legend(ncols=6, frameon=False, fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.16))
    errors: dict[str, list[float]] = {name: [] for name in FILTERS}
    for file in files:
        one = ar.read(file)
        for name in FILTERS:
            quat = ar.FILTERS[name]().run(one).quat
            errors[name].append(float(ar.metrics.score(quat, one.require("ref"), one.mask).total))
    ar.plots.boxes(errors, label="total RMSE [°]", ax=right)
    right.set_yscale("log")
    right.set_yticks([1, 2, 5, 10, 20, 50], ["1", "2", "5", "10", "20", "50"])
    right.set_title(f"errors on {len(files)} recordings, at the defaults", fontsize="medium")
    right.tick_params("x", rotation=35)
    for name, values in errors.items():
        print(f"{name:<12} {sum(values) / len(values):.2f}")
    return figure


if __name__ == "__main__":
    data = os.environ.get("AHRS_RS_DATA", "")
    if not data:
        sys.exit("AHRS_RS_DATA: expected the folder of the recordings, and it is not set")
    ar.plots.save(picture(Path(data) / "broad"), PICTURE)
    print(f"wrote {PICTURE.name}, {PICTURE.stat().st_size // 1000} kB")
