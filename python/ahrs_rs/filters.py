"""The filter classes, one for each filter of the native registry."""

from ahrs_rs import _native
from ahrs_rs._classes import Registry, make_class

FILTERS = Registry((spec["name"], make_class(spec)) for spec in _native.registry())

globals().update(FILTERS)
__all__ = ["FILTERS", *FILTERS]
