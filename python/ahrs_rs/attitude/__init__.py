"""Attitude of a single moment, from directions that a sensor sees and that are known on earth.

>>> import numpy as np
>>> import ahrs_rs as ar
>>> acc, mag = [0.0, 0.0, 9.81], [0.0, 22.0, -42.0]  # level, x to the east
>>> ar.attitude.saam(acc, mag)
array([1., 0., 0., 0.])

The functions need no gyroscope, no time and no start, and each row stands for itself. Two families are here:

- `triad`, `svd`, `davenport`, `quest`, `flae`, `oleq` take pairs of directions: `sensor` (..., n, 3), as the sensor
  measures them, and `earth` (..., n, 3), as they are known on earth. TRIAD takes two pairs, the first one as
  exact. The others take any number of pairs and solve Wahba's problem: they find the rotation R that
  minimises ½ Σ aᵢ |bᵢ - Rᵀ rᵢ|² (`wahba_loss`), for directions bᵢ in the sensor frame, rᵢ on earth and
  weights aᵢ. They differ in how they find it, and agree to rounding. `pairs` makes the two arrays from
  accelerometer and magnetometer.
- `saam`, `famc`, `fqa` take an accelerometer and a magnetometer, (..., 3) each, and a frame. The accelerometer gives
  the inclination, the magnetometer the heading alone. What they find is what `triad` finds for the same two pairs.

All of them are vectorised over the leading axes. The quaternions are scalar-first, of unit norm, from sensor to earth,
with w ≥ 0. Vectors may have any length but zero: only their directions count. The accelerometer is specific
force: at rest and level it points up. The computation is in float64, and the result is float32 where all arrays are.

A pair with a vector that is zero or holds a NaN is left out. A row is NaN where what is left does not determine the
attitude: fewer than two pairs, or directions along one line (a vertical magnetic field, free fall). Directions
count as on one line where rounding of the inputs alone could turn the attitude by about one degree.

`triad_covariance` and `wahba_covariance` give the covariance of the attitude's error, in the sensor frame, in rad².

Every recorded moment by itself is noisy, and wrong while the sensor accelerates: `ar.FILTERS` has filters that
use the gyroscope too.
"""

from ahrs_rs.attitude._acc_mag import famc, fqa, saam
from ahrs_rs.attitude._flae import flae
from ahrs_rs.attitude._oleq import oleq
from ahrs_rs.attitude._pairs import pairs
from ahrs_rs.attitude._quest import quest
from ahrs_rs.attitude._triad import triad, triad_covariance
from ahrs_rs.attitude._wahba import davenport, svd, wahba_covariance, wahba_loss

__all__ = [
    "davenport",
    "famc",
    "flae",
    "fqa",
    "oleq",
    "pairs",
    "quest",
    "saam",
    "svd",
    "triad",
    "triad_covariance",
    "wahba_covariance",
    "wahba_loss",
]
