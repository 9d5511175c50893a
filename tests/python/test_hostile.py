"""Data that cannot be: what is refused, and that nothing poisons a filter."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ahrs_rs as ar
from ahrs_rs import Status
from cases import CASES, COMMON
from signals import RATE, finite_and_unit, motion


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("value", [np.inf, -np.inf])
@pytest.mark.parametrize("sensor", ["gyr", "acc", "mag"])
def test_an_infinite_value_is_a_value_error_with_its_first_index(sensor: str, value: float, dtype: type) -> None:
    signals = motion(10, 19).astype(dtype)
    getattr(signals, sensor)[[4, 7], [2, 0]] = value
    with pytest.raises(ValueError, match=rf"{sensor}: .*infinite.*index \(4, 2\)"):
        ar.Madgwick(rate=RATE).run(*signals.sensors())
    batch = [np.stack((motion(10, 20).astype(dtype).sensors()[i], array)) for i, array in enumerate(signals.sensors())]
    with pytest.raises(ValueError, match=rf"{sensor}: .*infinite.*index \(1, 4, 2\)"):
        ar.Madgwick(rate=RATE).run(*batch)


@pytest.mark.parametrize(
    ("t", "message"),
    [
        ([0.0, 1.0, 0.5, 0.2], r"t: expected stamps that do not decrease, got 0\.5 after 1 at index 2"),
        ([0.0, np.nan, 1.0, 2.0], "t: expected finite stamps, got NaN at index 1"),
        ([0.0, 1.0, np.inf, np.inf], "t: expected finite stamps, got inf at index 2"),
        ([0.0, 1.0, 2.0], r"t: expected shape \(4,\), got \(3,\)"),
        ([[0.0, 1.0, 2.0, 3.0]], r"t: expected shape \(4,\), got \(1, 4\)"),
    ],
)
def test_stamps_that_decrease_or_are_not_finite_are_a_value_error(t: list[Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ar.Tilt(rate=RATE).run(np.zeros((4, 3)), t=t)


def test_a_decreasing_stamp_of_one_of_many_recordings_names_the_recording() -> None:
    t = np.array([[0.0, 1.0, 2.0], [0.0, 1.0, 0.5]])
    with pytest.raises(ValueError, match="at index 2 of recording 1"):
        ar.Tilt().run(np.zeros((2, 3, 3)), t=t)


@pytest.mark.parametrize(
    "q0", [[0.0] * 4, [np.nan, 0.0, 0.0, 1.0], [np.inf, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [[1.0, 0.0, 0.0, 0.0]]]
)
def test_a_q0_that_is_no_attitude_is_a_value_error(q0: list[Any]) -> None:
    f = ar.Tilt(rate=RATE)
    with pytest.raises(ValueError, match="q0: expected"):
        f.run(np.zeros((2, 3)), q0=q0)
    state = f.state()
    with pytest.raises(ValueError, match="q0: expected"):
        f.reset(q0)
    assert f.state() == state


def test_a_q0_is_normalised_from_any_length() -> None:
    for scale in (1e-300, 1e-3, 7.0, 1e300):
        est = ar.GyroIntegration(rate=RATE).run(np.zeros((1, 3)), q0=np.array([1.0, 1.0, 0.0, 0.0]) * scale)
        assert np.abs(est.quat - [[0.5**0.5, 0.5**0.5, 0.0, 0.0]]).max() < 1e-15


# Nothing poisons a filter.

HOSTILE = st.one_of(
    st.floats(allow_nan=True, allow_infinity=False),
    st.sampled_from([0.0, -0.0, 1e-170, 5e-324, 1e200, -1e308, np.nan, 1.0, 9.81, 1e-20, 1e19, 1e38]),
)
ROWS = st.lists(st.tuples(*[HOSTILE] * 9, st.floats(0.0, 1e9)), min_size=1, max_size=12)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@given(rows=ROWS, hold=st.sampled_from(["zero-order", "linear"]))
@settings(max_examples=150)
def test_no_data_makes_any_filter_not_finite(dtype: type, rows: list[tuple[float, ...]], hold: str) -> None:
    data = np.array(rows)
    limit = float(np.finfo(dtype).max)
    gyr, acc, mag = (data[:, i : i + 3].clip(-limit, limit).astype(dtype) for i in (0, 3, 6))
    t = np.cumsum(data[:, 9])
    good = motion(5, 21).astype(dtype)
    for case in CASES:
        f = case.make(rate=RATE, gyr_hold=hold, declination=0.1)
        est = f.run(gyr, acc, mag, t=t)
        assert finite_and_unit(est.quat), case.label
        assert est.gyr_bias is None or np.isfinite(est.gyr_bias).all(), case.label
        # And what comes after it is computed from good data.
        after = f.run(*good.sensors(), state=est.state)
        assert finite_and_unit(after.quat), case.label
        # With a linear hold the first mean still has the last rate in it, which may be too large, and says so. Steps of
        # 10 ms are gaps after those of a microsecond.
        told = after.status[1 if hold == "linear" else 0 :]
        assert not (told & COMMON & ~Status.GAP).any(), case.label


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@given(rows=ROWS, data=st.data())
@settings(max_examples=150)
def test_no_parameters_make_any_filter_not_finite(
    dtype: type, rows: list[tuple[float, ...]], data: st.DataObject
) -> None:
    table = np.array(rows)
    limit = float(np.finfo(dtype).max)
    gyr, acc, mag = (table[:, i : i + 3].clip(-limit, limit).astype(dtype) for i in (0, 3, 6))
    for name, cls in ar.FILTERS.items():
        params = {
            spec.name: data.draw(
                st.sampled_from(spec.options)
                if spec.options
                else st.one_of(st.sampled_from(spec.range), st.floats(*spec.range)),
                label=f"{name}.{spec.name}",
            )
            for spec in cls.PARAMS.values()
        }
        est = cls(rate=RATE, **params).run(gyr, acc, mag, t=np.cumsum(table[:, 9]))
        assert finite_and_unit(est.quat), name
        assert (est.state is not None) == cls.STREAMING  # made, and checked, when it is asked for
        assert est.gyr_bias is None or np.isfinite(est.gyr_bias).all(), name
