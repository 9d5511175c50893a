"""Laws of the parameter `mag_delay`: a late magnetometer is turned into the present sensor frame."""

from __future__ import annotations

import dataclasses
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import metrics
from cases import CASES, Case
from commands import DATA, needs_data
from late import late
from signals import FIELD, UP, about_z, angle_between, conjugate, gappy, motion, rotation
from test_oracle import SAMPLES, Inputs, compare

DELAYED = [cls for cls in ar.FILTERS.values() if "mag_delay" in cls.PARAMS]
EVERY_DELAYED = pytest.mark.parametrize("cls", DELAYED, ids=lambda cls: cls.NAME)


def test_some_filters_take_a_delay() -> None:
    assert {"MEKF", "VQF", "BasicVQF", "OfflineVQF"} <= {cls.NAME for cls in DELAYED}


@cache
def gaps_and_jitter(_: bool) -> Inputs:
    return Inputs(gappy(motion(SAMPLES // 4, 1, jitter=True), 3).rounded(), use_t=True)


@pytest.mark.parametrize(
    "case",
    [case for case in CASES if case.label in ("mekf", "mekf-vector", "vqf", "basic-vqf")],
    ids=lambda case: case.label,
)
def test_it_agrees_with_the_oracle(case: Case) -> None:
    """Which takes the attitude of a delay ago, where the filter turns the field."""
    compare(dataclasses.replace(case, params={**case.params, "mag_delay": 0.03}), gaps_and_jitter)


@EVERY_DELAYED
@pytest.mark.parametrize("delay", [0.007, 0.02, 0.1])
def test_at_a_constant_rate_a_late_field_is_as_good_as_one_in_time(cls: type[ar.Filter], delay: float) -> None:
    """About the vertical, of which the accelerometer sees nothing; the delay need not be a multiple of the step."""
    rate, speed, samples = 100.0, 1.5, 3000
    gyr = np.tile([0.0, 0.0, speed], (samples, 1))
    acc = np.tile(UP, (samples, 1))
    angle = 0.4 + speed * np.arange(samples) / rate
    fields = [rotation(conjugate(about_z(angle - speed * shift))).apply(FIELD) for shift in (0.0, delay)]
    prompt = cls(rate=rate).run(gyr, acc, fields[0])
    caught_up = cls(rate=rate, mag_delay=delay).run(gyr, acc, fields[1])  # type: ignore[call-arg]
    settled = samples // 2
    # MEKF starts with the first reading as it is, and forgets that within seconds; the others turn it too.
    assert angle_between(caught_up.quat, prompt.quat)[settled:].max() < (1e-3 if cls.NAME == "MEKF" else 1e-9)
    left_alone = cls(rate=rate).run(gyr, acc, fields[1])
    off = angle_between(left_alone.quat, prompt.quat)[settled:]
    assert off == pytest.approx(speed * delay, rel=0.05)


@EVERY_DELAYED
def test_the_planted_delay_is_the_best_parameter(cls: type[ar.Filter]) -> None:
    recording = late(0.02, seed=2)
    totals = []
    for delay in (0.0, 0.01, 0.02, 0.03, 0.04):
        f = cls(rate=recording.rate, mag_delay=delay)  # type: ignore[call-arg]
        est = f.run(recording.gyr, recording.acc, recording.mag)
        score = metrics.score(est.quat[1000:], np.asarray(recording.ref)[1000:])
        totals.append(float(score.heading))
    # MEKF's own errors, of the inclination under acceleration, are as large as 5 ms' worth.
    assert totals[2] < 1.05 * min(totals)
    assert totals[2] < 0.5 * totals[0]


@EVERY_DELAYED
def test_a_sweep_over_delays_gives_the_errors_of_each(cls: type[ar.Filter]) -> None:
    """In lanes some of which have none."""
    recording = late(0.01, duration=20.0)
    delays = [0.0, 0.01, 0.0, 0.02, 0.005]
    found = ar.sweep(cls, {"mag_delay": delays}, [recording], metric="total")
    for delay, error in zip(delays, np.asarray(found.errors).ravel(), strict=True):
        est = cls(rate=recording.rate, mag_delay=delay).run(  # type: ignore[call-arg]
            recording.gyr, recording.acc, recording.mag, t=recording.t
        )
        assert error == pytest.approx(float(metrics.score(est.quat, np.asarray(recording.ref)).total), rel=1e-12)


@EVERY_DELAYED
def test_a_delay_is_refused_where_it_is_negative_or_long(cls: type[ar.Filter]) -> None:
    for delay in (-0.01, 1.5, float("nan")):
        with pytest.raises(ValueError, match=r"mag_delay: expected a number in \[0, 1\] s, got"):
            cls(rate=100.0, mag_delay=delay)  # type: ignore[call-arg]


@needs_data
def test_broad_gains_by_its_delay() -> None:
    """The 12 recordings' magnetometer is 13 ms late: OfflineVQF's 1.84° become 1.53° (0.3° of it in one recording)."""
    pytest.importorskip("h5py")
    totals = []
    for delay in (0.0, 0.013):
        errors = []
        for path in sorted((Path(DATA) / "broad").glob("*.hdf5")):
            r = ar.read(path)
            assert r.ref is not None
            est = ar.OfflineVQF(rate=r.rate, mag_delay=delay).run(r.gyr, r.acc, r.mag)
            errors.append(metrics.score(est.quat, r.ref, r.mask).total)
        totals.append(float(np.mean(errors)))
    assert totals[0] == pytest.approx(1.838, abs=2e-3)
    assert totals[1] == pytest.approx(1.527, abs=2e-3)
