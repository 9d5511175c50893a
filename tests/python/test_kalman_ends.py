"""Covariances at the ends of all parameters' ranges: symmetric to the last bit, and of no negative variance."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar

KALMAN = [name for name, cls in ar.FILTERS.items() if "covariance" in cls.OUTPUTS]
DTYPES = [np.float64, np.float32]
#: In motion, and at rest, where nothing is added to what rounding takes away.
RECORDINGS = [ar.simulate.demo(4.0, 100.0, 0), ar.simulate.scenario("static", duration=4.0, rate=100.0)]


def ends(cls: type[ar.Filter]) -> list[dict[str, Any]]:
    """Every parameter at each end of its range, and at every option, all others having their defaults."""
    return [
        {name: value}
        for name, param in cls.PARAMS.items()
        for value in (param.options if param.options is not None else param.range or ())
    ]


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("name", KALMAN)
def test_covariances_are_covariances_at_the_ends_of_all_ranges(name: str, dtype: type) -> None:
    cls = ar.FILTERS[name]
    outputs = [output for output in ("covariance", "nis") if output in cls.OUTPUTS]
    for params in ends(cls):
        for recording in RECORDINGS:
            for mag in (recording.mag, None):
                arrays = [None if x is None else x.astype(dtype) for x in (recording.gyr, recording.acc, mag)]
                est = cls(rate=100.0, **params).run(*arrays, outputs=outputs)
                p = est.extra["covariance"]
                what = (params, mag is not None)
                assert np.isfinite(p).all(), what
                assert np.array_equal(p, p.transpose(0, 2, 1)), what
                variances = np.diagonal(p, axis1=1, axis2=2)
                assert (variances >= 0.0).all(), what
                # Turning a covariance into the sensor frame rounds some tens of times.
                smallest = np.linalg.eigvalsh(p.astype(np.float64))[:, 0]
                assert (smallest >= -50.0 * np.finfo(dtype).eps * variances.max(axis=1)).all(), what
                if "nis" in outputs:
                    assert not (est.extra["nis"] < 0.0).any(), what
