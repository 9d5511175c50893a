"""Reading recordings, writing recordings and estimates.

A new format is one module with `sniff`, `load` and perhaps `sensors`, and one row in `_registry.FORMATS`.
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING as _TYPE_CHECKING
from typing import Any as _Any

from ahrs_rs._recording import FORMATS as _HOOKS
from ahrs_rs.io._contents import SensorInfo
from ahrs_rs.io._finish import keeping_doubtful as keeping_doubtful
from ahrs_rs.io._read import formats, from_frame, read, read_all, sensors

if _TYPE_CHECKING:
    from ahrs_rs.io._estimate import save_estimate, write_estimate, writers
    from ahrs_rs.io._recording import save_recording
    from ahrs_rs.io._registry import FORMATS
    from ahrs_rs.io._sto_out import write_sto

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


def _save(*args: _Any) -> None:
    __getattr__("save_recording")(*args)


# `Recording` knows nothing of formats; its methods `from_frame` and `save` find them here.
_HOOKS.update(from_frame=from_frame, save=_save)


def __getattr__(name: str) -> _Any:
    if name in _LATER:
        return getattr(_import_module(f"{__name__}.{_LATER[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_LATER})
