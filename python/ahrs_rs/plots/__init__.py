"""Figures: recordings, estimates, errors, calibrations, tuning.

Needs matplotlib (the extra ``plot``), which is imported only when something is drawn. Functions take ``ax=`` and return
the axes, one or an array of them; without it they make a figure by pyplot, which a notebook shows by itself. The
methods ``plot`` of recordings, estimates, reports, fits and sweeps are these functions. `errors`, `draw` and
`draw_many` return a ``matplotlib.figure.Figure``, which `save` writes anywhere.
"""

from ahrs_rs.plots._calibration import allan, ellipsoid, noise, positions, turns
from ahrs_rs.plots._errors import ERRORS, POINTS, ErrorPanel, draw, errors
from ahrs_rs.plots._estimate import angles, bias, estimate, quaternion, status
from ahrs_rs.plots._evidence import evidence
from ahrs_rs.plots._figure import check_ending, require_matplotlib, save
from ahrs_rs.plots._innovations import innovations
from ahrs_rs.plots._many import boxes, draw_many, error_times
from ahrs_rs.plots._recording import recording, sensor, spectrum
from ahrs_rs.plots._tuning import sweep

__all__ = [
    "ERRORS",
    "POINTS",
    "ErrorPanel",
    "allan",
    "angles",
    "bias",
    "boxes",
    "check_ending",
    "draw",
    "draw_many",
    "ellipsoid",
    "error_times",
    "errors",
    "estimate",
    "evidence",
    "innovations",
    "noise",
    "positions",
    "quaternion",
    "recording",
    "require_matplotlib",
    "save",
    "sensor",
    "spectrum",
    "status",
    "sweep",
    "turns",
]
