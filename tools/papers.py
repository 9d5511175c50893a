"""The five papers reproduced: `make papers`, kept as docs/papers.md.

Real recordings are found through the environment variable AHRS_RS_DATA (folder `broad/`). Times are ratios: nanoseconds
say something of one machine only, and stand in the report of `ahrs-rs papers --out`.
"""

from __future__ import annotations

import sys
from pathlib import Path

import ahrs_rs as ar
from ahrs_rs.cli._common import CliError
from ahrs_rs.cli._papers import find_recordings
from ahrs_rs.papers import STUDIES, study
from ahrs_rs.papers._text import claims_with_numbers, markdown

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "papers.md"

HEAD = """# Five papers, reproduced

Made by `make papers`: every study on a simulation of its paper's protocol and on {count} recordings of BROAD (Laidig,
Caruso, Cereatti, Seel, Data 6(7):72, 2021). `ahrs-rs papers --out DIR` makes the same with plots. Angles in degrees;
"–" is what a paper does not give, or what cannot be said. Times are relative to the shortest one.

"""


def main() -> int:
    """Writes the document."""
    try:
        files = find_recordings(None)
    except CliError as error:
        print(f"papers: {error}", file=sys.stderr)
        return 2
    if not files:
        print("papers: set AHRS_RS_DATA to the folder that holds broad/*.hdf5", file=sys.stderr)
        return 2
    recordings = [ar.read(file) for file in files]
    studies = [study(name, recordings) for name in STUDIES]
    parts = [markdown(claims_with_numbers(studies)).replace("**Claims**", "## Which claims hold")]
    for one in studies:
        parts += [f"## {one.name}", one.title, one.protocol, *(markdown(table) for table in one.tables)]
    text = HEAD.format(count=len(files)) + "\n\n".join(parts) + "\n"
    DOCUMENT.write_text(text, encoding="utf-8")
    print(f"wrote {DOCUMENT.name}: {len(studies)} studies")
    return 0


if __name__ == "__main__":
    sys.exit(main())
