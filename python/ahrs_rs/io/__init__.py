"""Reading recordings, writing estimates.

A new format is one module with `sniff`, `load` and perhaps `sensors`, and one row in `_registry.FORMATS`.
"""

from typing import TYPE_CHECKING

from ._contents import SensorInfo
from ._estimate import write_estimate
from ._read import formats, from_frame, read, read_all, sensors

if TYPE_CHECKING:
    from ._registry import FORMATS

__all__ = [
    "FORMATS",
    "SensorInfo",
    "formats",
    "from_frame",
    "read",
    "read_all",
    "sensors",
    "write_estimate",
]


def __getattr__(name: str) -> object:
    if name == "FORMATS":
        return formats()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
