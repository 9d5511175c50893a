"""docs/tables.md, the units and columns that are understood in tables, from the code: `make tables`.

With --check, only says whether the page is current.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from pathlib import Path

from ahrs_rs.io._names import AXES
from ahrs_rs.io._profiles import PROFILES
from ahrs_rs.io._units import ASSUMED, SIZELESS, UNITS
from ahrs_rs.io._vocabulary import PHRASES, TIMES

ROOT = Path(__file__).resolve().parents[1]
DOCUMENT = ROOT / "docs" / "tables.md"

HEAD = """# Tables: units and columns

Made by `make tables` from the code that reads them (python/ahrs_rs/io). A table is text (CSV and its relatives, also
packed as .gz or .zip), Parquet, or a data frame. What a table does not tell is an option, on the command line and in
Python:

| option | in Python | what it says |
| --- | --- | --- |
| `--columns gyr=wx,wy,wz` | `columns={"gyr": ["wx", "wy", "wz"], "t": "millis"}` | which columns a quantity has |
| `--columns t,gx,gy,gz` | `columns=["t", "gx", "gy", "gz"]` | the names of a table without a header |
| `--units gyr=deg/s,acc=g` | `units={"gyr": "deg/s", "acc": "g"}` | units, over what the table says |
| `--axes x,-y,-z` | `axes="x,-y,-z"` | which axes of the table x, y and z are |
| `--separator ";"` | `separator=";"` | between cells; a character, `tab` or `blanks` |
| `--decimal ,` | `decimal=","` | the decimal sign |
| `--skip-rows 7` | `skip_rows=7` | lines above the header |
| `--sensor left` | `sensor="left"` | which of several sensors; `ahrs-rs sensors FILE` lists them |
| `--timezone Europe/Berlin` | `timezone="Europe/Berlin"` | of local times; else UTC |
| `--between 10:60` | `between=(10, 60)` | what was recorded between these times, s |
| `--rate 100` | `rate=100.0` | Hz, for a table without times, or in their place |
| `--layout my_logger.toml` | `layout="my_logger.toml"` | a file with these options |

A layout file is TOML, and can be shared. Options go over it.

```toml
axes = "x,-y,-z"
decimal = ","

[columns]
t = "millis"
gyr = ["p", "q", "r"]

[units]
t = "ms"
gyr = "deg/s"
acc = "g"
```

Found without options: separator, decimal sign, encoding (UTF-8, UTF-16, Latin-1), lines above the header, `sep=` lines,
a line of units below the header, dates and times in ISO 8601, whole seconds with nanoseconds beside, clocks that start
again after 16 or 32 bits, several clocks (one is chosen by plausibility, the others are named), several sensors
(left_foot_gyr_x, or a column with their number). What was assumed, repaired, ignored or doubted is told: by the
commands in a line each, in Python as one `ahrs_rs.DataWarning` and in `Recording.meta`.
"""

UNITS_HEAD = """
## Units

Letters and digits decide: m/s², m/s^2, m_s2 and m s-2 are the same, and so are upper and lower case. A number may stand
before one (0.1 deg/s). Units stand in brackets, at the end of a name, or in a line below the header. Where nothing is
stated, the one of `Recording` is assumed, and that is told; readings that no inertial sensor gives in it are an error.

| quantity | of `Recording` | factor | written as |
| --- | --- | --- | --- |
"""

NAMES_HEAD = """
## Names of columns

A name is split into words at signs, at capital letters, and where a sensor's name meets an axis (GyrX, xacc). Upper and
lower case are the same. What stands before the quantity is the sensor (left_foot_gyro_x); words behind the axis are
that where several quantities have the same ones (acc_x_dashboard). x, y, z or 0, 1, 2 are axes. Single letters gx, ax,
mx, wx are read where nothing else stands before them. An orientation is the truth only where a name says so (ref_qw,
truth, optical, vicon, ...) or by `columns={"ref": [...]}`; else it is what the device estimated,
`Recording.device_quat`.

| quantity | axes | names |
| --- | --- | --- |
"""

PROGRAMS_HEAD = """
## Programs that are known by their columns

They say more than their names do: units, axes of the device, times.

| program | known by | units | axes | source |
| --- | --- | --- | --- | --- |
"""


def units() -> str:
    """The rows of the table of units."""
    rows = []
    for quantity, known in UNITS.items():
        of: dict[tuple[float, float], list[str]] = defaultdict(list)
        for name, conversion in known.items():
            if name not in SIZELESS:
                of[conversion].append(name)
        if quantity in ("ref", "device_quat", "mask"):
            continue
        for (factor, offset), names in sorted(of.items(), key=lambda one: -len(one[1])):
            shift = f", then {offset:+.6g}" if offset else ""
            rows.append(f"| {quantity} | {ASSUMED[quantity]} | {factor:.8g}{shift} | {', '.join(names)} |")
    rows.append(f"| gyr, acc, mag | as it is | 1 | {', '.join(sorted(SIZELESS))}: of no known size, not judged |")
    return "\n".join(rows) + "\n"


def names() -> str:
    """The rows of the table of names."""
    rows = []
    for quantity, phrases in PHRASES.items():
        axes = "w, x, y, z" if quantity == "quat" else ", ".join(filter(None, AXES.get(quantity, ())))
        rows.append(f"| {quantity} | {axes} | {', '.join(sorted({' '.join(phrase) for phrase in phrases}))} |")
    rows.append(f"| t | | {', '.join(sorted({' '.join(phrase) for phrase in TIMES}))} |")
    return "\n".join(rows) + "\n"


def programs() -> str:
    """The rows of the table of programs."""
    rows = []
    for one in PROFILES:
        known = ", ".join(f"`{need.replace('|', chr(92) + '|')}`" for need in one.needs)
        said = ", ".join(f"{quantity} {unit}" for quantity, unit in one.units.items())
        rows.append(f"| {one.title} | {known} | {said} | {one.axes} | {one.source} |")
    return "\n".join(rows) + "\n"


def document() -> str:
    """The whole page."""
    return HEAD + UNITS_HEAD + units() + NAMES_HEAD + names() + PROGRAMS_HEAD + programs()


def main() -> int:
    """Write the page, or with --check compare it."""
    text = document()
    if "--check" in sys.argv[1:]:
        current = DOCUMENT.is_file() and DOCUMENT.read_text(encoding="utf-8") == text
        print(f"{DOCUMENT.relative_to(ROOT)} is {'current' if current else 'not current: run make tables'}")
        return 0 if current else 1
    DOCUMENT.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
