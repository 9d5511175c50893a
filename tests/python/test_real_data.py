"""Real recordings: the accuracy that is known for BROAD, and sound output for everything else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import metrics
from cases import Case, each_case
from reading import told

#: Means over the 12 recordings of total, heading and inclination error in degrees, as an independent implementation of
#: the papers gives them (None: not known). Two digits after the point, and starts and steps that may differ: 2 %.
REFERENCES: list[tuple[str, dict[str, Any], tuple[float | None, float | None, float | None]]] = [
    ("Madgwick", {"gradient": "paper", "integration": "first-order", "beta": 0.1}, (4.94, 3.77, 2.73)),
    ("Madgwick", {"gradient": "paper", "integration": "first-order", "beta": 0.08}, (4.84, 3.80, 2.52)),
    ("Madgwick", {"gradient": "tangent", "beta": 0.08}, (4.83, None, None)),
    ("Madgwick", {"gradient": "tangent", "beta": 0.1}, (5.02, None, None)),
    ("Mahony", {"kp": 0.74, "ki": 0.0012}, (11.3, 10.0, 4.7)),
    ("VQF", {}, (2.32, 2.17, 0.59)),
    ("BasicVQF", {}, (3.90, 3.72, 0.99)),
    ("OfflineVQF", {}, (1.84, 1.73, 0.47)),
    # This project's own, as docs/accuracy.md has them.
    ("SelfCalKF", {}, (1.37, 1.18, 0.54)),
    ("SelfCalSmoother", {}, (1.28, 1.11, 0.46)),
    # The imufusion package, started at the identity.
    ("Fusion", {}, (16.2, 11.8, 7.9)),
]


@pytest.fixture(scope="module")
def everything(recordings: list[Path]) -> list[ar.Recording]:
    return [told(file)[0] for file in recordings]


@pytest.mark.parametrize(("name", "params", "expected"), REFERENCES, ids=str)
def test_errors_over_broad_are_those_known(
    broad: list[ar.Recording], name: str, params: dict[str, Any], expected: tuple[float | None, ...]
) -> None:
    estimates = ar.run_many(ar.FILTERS[name](rate=broad[0].rate, **params), broad)
    scores = [metrics.score(est.quat, r.ref, r.mask) for est, r in zip(estimates, broad, strict=True)]
    for kind, known in zip(("total", "heading", "inclination"), expected, strict=True):
        mean = float(np.mean([getattr(score, kind) for score in scores]))
        if known is not None:
            assert mean == pytest.approx(known, rel=0.02), kind


@each_case
def test_every_recording_gives_finite_unit_attitudes(case: Case, everything: list[ar.Recording]) -> None:
    for recording in everything:
        f = case.make(rate=recording.rate)
        for est in (
            f.run(recording.gyr, recording.acc, recording.mag, t=recording.t),
            f.run(recording.gyr, recording.acc),
        ):
            # A few ulp, as in `test_invariants`; NaN is not below it.
            assert np.abs(np.linalg.norm(est.quat, axis=1) - 1.0).max() < 1e-15
            assert not np.any(est.status & ar.Status.NOT_ALIGNED)
            assert est.gyr_bias is None or np.isfinite(est.gyr_bias).all()


@each_case
def test_float32_is_as_good_as_float64_on_broad(case: Case, broad: list[ar.Recording]) -> None:
    recording = broad[0]
    f = case.make(rate=recording.rate)
    arrays = (recording.gyr, recording.acc, recording.mag)
    errors = [
        metrics.score(f.run(*(a.astype(dtype) for a in arrays)).quat, recording.ref, recording.mask).total
        for dtype in (np.float64, np.float32)
    ]
    # The filters are wrong by degrees; float32 by less than a hundredth of one, and Euler angles, which amplify
    # rounding near pitch 90°, by less than a tenth.
    assert errors[1] == pytest.approx(errors[0], abs=0.1 if case.first_order or case.name == "Complementary" else 0.01)


def test_a_batch_of_real_recordings_is_a_loop(broad: list[ar.Recording]) -> None:
    samples = min(len(r) for r in broad)
    arrays = [np.stack([getattr(r, name)[:samples] for r in broad]) for name in ("gyr", "acc", "mag")]
    f = ar.Madgwick.preset("hyyti2015", rate=broad[0].rate)
    whole = f.run(*arrays)
    for i in range(len(broad)):
        assert np.array_equal(whole.quat[i], f.run(*(a[i] for a in arrays)).quat)
