"""Reading recordings, writing recordings and estimates.

A new format is one module with `sniff`, `load` and perhaps `sensors`, and one row in `_registry.FORMATS`.
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING as _TYPE_CHECKING

from ._contents import SensorInfo
from ._read import formats, from_frame, read, read_all, sensors

if _TYPE_CHECKING:
    from ._estimate import save_estimate, write_estimate, writers
    from ._recording import save_recording
    from ._registry import FORMATS
    from ._sto_out import write_sto

__all__ = [
    "FORMATS",
    "SensorInfo",
    "formats",
    "from_frame",
    "read",
    "read_all",
    "save_estimate",
    "save_recording",
    "sensors",
    "write_estimate",
    "write_sto",
    "writers",
]

#: Name -> its module, which is imported where it is first used, so that the package itself is there at once.
_LATER = {
    "FORMATS": "_registry",
    "save_estimate": "_estimate",
    "save_recording": "_recording",
    "write_estimate": "_estimate",
    "write_sto": "_sto_out",
    "writers": "_estimate",
}


def __getattr__(name: str) -> object:
    if name in _LATER:
        return getattr(_import_module(f"{__name__}.{_LATER[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_LATER})
