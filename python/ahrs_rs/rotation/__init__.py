"""Rotations as arrays of quaternions, without scipy.

>>> import numpy as np
>>> import ahrs_rs as ar
>>> q = ar.rotation.from_euler([90.0, 0.0, 30.0], "ZYX", degrees=True)
>>> ar.rotation.rotate(q, [1.0, 0.0, 0.0]).round(6) + 0.0
array([0., 1., 0.])
>>> ar.rotation.to_euler(q, "ZYX", degrees=True).round(6) + 0.0
array([90.,  0., 30.])

Quaternions are scalar-first ``[w, x, y, z]``, of unit norm, by the Hamilton product, and rotate from the sensor frame
to the earth frame: ``v_earth = q ⊗ v_sensor ⊗ q*``. That is scipy's ``Rotation.from_quat(q, scalar_first=True)``, and
the product ``p ⊗ q`` turns by q first. q and -q are the same rotation.

All functions take arrays of any leading shape, whose leading axes are broadcast as numpy's are. They compute in float32
where all arrays are float32, else in float64, and agree with scipy to 1e-13 (float32: 1e-6). A row with a NaN gives
NaN. A quaternion whose norm differs from 1 by more than 1e-3 is a ValueError; smaller differences are normalised away.
"""

from ahrs_rs.rotation._algebra import about_axis, distance, inverse, product, rotate, shortest_arc, swing_twist
from ahrs_rs.rotation._euler import from_euler, to_euler
from ahrs_rs.rotation._forms import from_matrix, from_rotvec, to_matrix, to_rotvec
from ahrs_rs.rotation._mean import mean
from ahrs_rs.rotation._rate import angular_rate, integrate
from ahrs_rs.rotation._time import continuous, interpolate, slerp, unwrap

__all__ = [
    "about_axis",
    "angular_rate",
    "continuous",
    "distance",
    "from_euler",
    "from_matrix",
    "from_rotvec",
    "integrate",
    "interpolate",
    "inverse",
    "mean",
    "product",
    "rotate",
    "shortest_arc",
    "slerp",
    "swing_twist",
    "to_euler",
    "to_matrix",
    "to_rotvec",
    "unwrap",
]
