"""JSON of files that anybody may have written: what is wrong with it is a ``ValueError`` of one line."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

#: Files of ours have some thousand characters; what is much longer is none, and is not read as a whole.
MOST_BYTES = 64 * 2**20


def parse(text: str | bytes) -> Any:
    """What the text holds; ``ValueError`` also where it is nested too deeply or a number has too many digits."""
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("is not JSON of ours: nested too deeply") from None
    except (ValueError, TypeError) as error:
        raise ValueError(f"is not JSON: {' '.join(str(error).split())}") from None


def read(path: str | os.PathLike[str]) -> Any:
    """What the file holds, in UTF-8; ``ValueError`` without the name of the file."""
    with Path(path).open("rb") as file:
        content = file.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise ValueError(f"is not JSON of ours: longer than {MOST_BYTES >> 20} MiB")
    return parse(content)
