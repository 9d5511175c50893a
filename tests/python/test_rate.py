"""The nominal rate of a recording does not depend on how its stamps come."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ahrs_rs as ar

RATE, N = 100.0, 4000
REGULAR = np.arange(N) / RATE
COUNTS = np.arange(N)
STAMPS = {
    "regular": REGULAR,
    "with jitter of a tenth of a step": REGULAR + np.random.default_rng(0).uniform(-5e-4, 5e-4, N),
    "two in a packet": COUNTS // 2 * 2 / RATE,
    "four in a packet": COUNTS // 4 * 4 / RATE,
    "ten in a packet": COUNTS // 10 * 10 / RATE,
    "pairs, 0.5 ms apart": COUNTS // 2 * 2 / RATE + COUNTS % 2 * 5e-4,
    "threes, 0.1 ms apart": COUNTS // 3 * 3 / RATE + COUNTS % 3 * 1e-4,
    "two in five lost": np.delete(REGULAR, np.flatnonzero(np.random.default_rng(2).random(N) < 0.4)),
    "many gaps that are longer than what is there": REGULAR + COUNTS // 100 * 5.0,
    "a clock of whole ms": np.floor(REGULAR * 1e3) / 1e3,
    "a clock that ticks at 64 Hz": np.floor(REGULAR * 64.0) / 64.0,
    "a gap of 10 s": REGULAR + np.where(COUNTS > N // 2, 10.0, 0.0),
    "packets of four and a gap": COUNTS // 4 * 4 / RATE + np.where(COUNTS >= N // 2, 10.0, 0.0),
    "one in ten lost": np.delete(REGULAR, np.arange(7, N, 10)),
    "a start far from zero": REGULAR + 1.7e9,
}


@pytest.mark.parametrize("t", STAMPS.values(), ids=STAMPS)
def test_the_rate_is_that_of_the_sensor_however_its_stamps_come(t: np.ndarray) -> None:
    # Jitter and the ticks of a clock move the two ends by up to a step or tick: 1 in 4,000, or 16 ms in 40 s.
    assert ar._recording.nominal_rate(t) == pytest.approx(RATE, rel=5e-4)


@given(st.floats(0.5, 2000.0), st.integers(2, 500))
def test_the_rate_of_a_regular_clock_is_exact(rate: float, n: int) -> None:
    assert ar._recording.nominal_rate(np.arange(n) / rate) == pytest.approx(rate, rel=1e-12)


def test_a_clock_that_stands_still_has_no_rate() -> None:
    for t in ([], [1.0], [1.0, 1.0]):
        with pytest.raises(ValueError, match="rate: expected a number"):
            ar._recording.nominal_rate(np.array(t))


def test_noise_of_a_filter_does_not_change_when_a_clock_ticks_coarsely() -> None:
    """Windows and noises that are counted in samples go by this rate."""
    gyr = np.random.default_rng(1).normal(0.0, 2e-3, (N, 3))
    rates = [
        ar.Recording(t=STAMPS[name], gyr=gyr).rate for name in ("regular", "four in a packet", "pairs, 0.5 ms apart")
    ]
    assert max(rates) / min(rates) == pytest.approx(1.0, rel=5e-4)
