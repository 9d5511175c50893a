"""What accuracy `Report.recommend` may promise: RMSE on real recordings, into python/ahrs_rs/_check/_expected.py.

Of the filters that it names, on the BROAD recordings of AHRS_RS_DATA: the total error with a still and with a disturbed
field, and the inclination error without the magnetometer. `make accuracy` runs it.
"""

from __future__ import annotations

import os
import statistics
import sys
import warnings
from pathlib import Path

import ahrs_rs as ar

FILTERS = ("VQF", "OfflineVQF", "SelfCalKF", "SelfCalSmoother")
OUT = Path(__file__).resolve().parent.parent / "python/ahrs_rs/_check/_expected.py"
HEAD = '''"""RMSE in degrees on BROAD's recordings, median and worst: made by tools/check_expected.py, not by hand."""

from __future__ import annotations

#: (filter, what): (median, worst, recordings). Totals; of "6D" the inclination.
EXPECTED: dict[tuple[str, str], tuple[float, float, int]] = {
'''


def errors(folder: Path) -> dict[tuple[str, str], list[float]]:
    """(filter, what) -> RMSE of each recording, °."""
    found: dict[tuple[str, str], list[float]] = {}
    for path in sorted((folder / "broad").glob("*.hdf5")):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ar.DataWarning)
            recording = ar.read(path)
        kind = "disturbed" if "_disturbed" in path.name else "still field"
        for name in FILTERS:
            f = ar.FILTERS[name](rate=recording.rate)
            nine = ar.metrics.score(f.run(recording).quat, recording.ref, mask=recording.mask)
            six = f.run(recording.gyr, recording.acc, t=recording.t).quat
            inclination = ar.metrics.score(six, recording.ref, mask=recording.mask).inclination
            found.setdefault((name, kind), []).append(float(nine.total))
            found.setdefault((name, "6D"), []).append(float(inclination))
    return found


def page(found: dict[tuple[str, str], list[float]]) -> str:
    """The module's text."""
    lines = [
        f'    ("{name}", "{kind}"): ({statistics.median(values):.2f}, {max(values):.2f}, {len(values)}),'
        for (name, kind), values in sorted(found.items())
    ]
    return HEAD + "\n".join(lines) + "\n}\n"


def main() -> int:
    """Write the module."""
    folder = os.environ.get("AHRS_RS_DATA", "")
    if not folder:
        print("AHRS_RS_DATA is not set", file=sys.stderr)
        return 1
    OUT.write_text(page(errors(Path(folder))), encoding="utf-8")
    print(f"wrote {OUT}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
