"""The page: its frame, the player, the scenes and plotly's script in one text."""

from __future__ import annotations

import html
import json
from collections.abc import Sequence
from importlib import resources
from typing import Any

from ahrs_rs._optional import require


def require_plotly() -> Any:
    """The module that has plotly's script; an ImportError that says what to install, where plotly is missing."""
    return require("plotly.offline", "view", "the page needs")


def page(title: str, scenes: Sequence[dict[str, Any]]) -> str:
    """One HTML text; ImportError without plotly."""
    library: str = require_plotly().get_plotlyjs()
    files = resources.files(__package__)
    encoded = json.dumps(scenes, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")
    parts = {
        "TITLE": html.escape(title),
        "STYLE": files.joinpath("style.css").read_text(encoding="utf-8"),
        "PLAYER": files.joinpath("player.js").read_text(encoding="utf-8"),
        "SCENES": encoded,
        "LIBRARY": library,
    }
    # Cut once, so that nothing that is put in is looked into.
    frame = files.joinpath("page.html").read_text(encoding="utf-8").split("%%")
    return "".join(parts[part] if index % 2 else part for index, part in enumerate(frame))
