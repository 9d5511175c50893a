"""Errors of orientation estimates against a reference, and the numbers that sum them up.

The functions of orientations take arrays of any leading shape (..., 4), scalar-first, sensor to earth; one side may
lack leading axes (many estimates against one reference). A row that holds a NaN gives NaN. A quaternion whose norm
differs from 1 by more than 1e-3 is a ValueError; smaller differences (rounding in a file, float32) are
normalised away. q and -q are the same orientation everywhere. Angles are computed by atan2 of lengths, which
is exact to rounding at every angle (an arc cosine has an error of 1e-8 near zero).

The numbers (`rmse`, `mae`, `mad`, ...) are taken along the last axis of errors (..., T) of any unit, over the samples
of a mask, without the NaN ones; they are NaN where no sample is left.

`align` finds constant rotations of both frames and an offset of the clocks between an estimate and a reference.

Sources: BROAD (Laidig, Caruso, Cereatti, Seel, Data 6(7):72, 2021) for total, heading and inclination error;
Huynh, "Metrics for 3D rotations: comparison and analysis", J. Math. Imaging and Vision 35:155-164, 2009, for
the distances; Yin et al., IEEE Signal Processing Letters 22(11), 2015, for `imre`.
"""

from ahrs_rs.metrics._align import Alignment, align
from ahrs_rs.metrics._orientation import (
    Score,
    StaticDynamic,
    chordal_distance,
    error_angles,
    error_quat,
    euler,
    euler_error,
    geodesic_distance,
    heading_error,
    inclination_error,
    inner_product_distance,
    score,
    static_dynamic,
    total_error,
)
from ahrs_rs.metrics._statistics import Box, box, gae, imre, mad, mae, mape, rmse

__all__ = [
    "Alignment",
    "Box",
    "Score",
    "StaticDynamic",
    "align",
    "box",
    "chordal_distance",
    "error_angles",
    "error_quat",
    "euler",
    "euler_error",
    "gae",
    "geodesic_distance",
    "heading_error",
    "imre",
    "inclination_error",
    "inner_product_distance",
    "mad",
    "mae",
    "mape",
    "rmse",
    "score",
    "static_dynamic",
    "total_error",
]
