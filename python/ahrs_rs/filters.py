"""The filter classes, one for each filter of the native registry."""

from ahrs_rs import _native
from ahrs_rs._classes import make_class

FILTERS = {spec["name"]: make_class(spec) for spec in _native.registry()}

globals().update(FILTERS)
__all__ = ["FILTERS", *FILTERS]
