"""The low-pass filter beside scipy's, in streams, gaps and every layout."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import signal as scipy_signal

import ahrs_rs as ar
from ahrs_rs.signal import LowPass, low_pass, zero_phase

ORDERS = range(1, 9)
#: Relative to the rate.
CUTOFFS = (1e-3, 1e-2, 0.1, 0.25, 0.4, 0.45)


def samples(shape: tuple[int, ...], seed: int = 0) -> NDArray[np.float64]:
    return 9.8 + np.random.default_rng(seed).standard_normal(shape)


def reference(x: NDArray[Any], order: int, cutoff: float) -> NDArray[Any]:
    """The bilinear transform in numbers of 64 bits of mantissa, run by scipy, starting at rest at the first sample.

    scipy's own design in doubles is off by epsilon over (2π cutoff)² at low cut-offs, which is tested apart.
    """
    c = np.tan(np.longdouble(np.pi) * np.longdouble(cutoff))
    sections = []
    if order % 2:
        sections.append([c, c, 0, 1 + c, c - 1, 0])
    for pair in range(order // 2):
        k = 2 * np.sin(np.longdouble(np.pi) * (2 * pair + 1) / (2 * order))
        sections.append([c * c, 2 * c * c, c * c, 1 + k * c + c * c, 2 * (c * c - 1), 1 - k * c + c * c])
    y = x.astype(np.longdouble)
    for row in np.array(sections, dtype=np.longdouble):
        # The difference from the first sample starts at zero.
        start = y[0]
        y = scipy_signal.lfilter(row[:3] / row[3], row[3:] / row[3], y - start, axis=0) + start
    return y


# scipy 1.15 and 1.16 announced an end of extended precision in lfilter, which 1.17 did not bring.
@pytest.mark.filterwarnings("ignore:dtype=float128 is not supported by lfilter:DeprecationWarning")
@pytest.mark.parametrize("cutoff", CUTOFFS)
@pytest.mark.parametrize("order", ORDERS)
def test_it_is_the_butterworth_filter_started_without_a_transient(order: int, cutoff: float) -> None:
    x = samples((20_000,))
    y = low_pass(x, 100.0 * cutoff, 100.0, order)
    # Rounding, epsilon of the signal a step, stays for 1/(2π cutoff) steps: 200 · 2.2e-16, and adds up over sections.
    assert np.abs(y - reference(x, order, cutoff)).max() < 1e-12 * np.abs(x).max()
    sections = scipy_signal.butter(order, 2.0 * cutoff, output="sos")
    theirs = scipy_signal.sosfilt(sections, x, zi=scipy_signal.sosfilt_zi(sections) * x[0])[0]
    # Coefficients in doubles, of which differences of the size (2π cutoff)² matter: 2.5e4 epsilon at 1e-3 = 6e-12.
    allowed = 1e-12 if cutoff >= 1e-2 else 1e-11
    assert np.abs(y - theirs).max() < allowed * np.abs(x).max()


@pytest.mark.parametrize("order", ORDERS)
def test_float32_keeps_the_signal(order: int) -> None:
    x = samples((20_000, 3)).astype(np.float32)
    y = low_pass(x, 1.0, 200.0, order)
    assert y.dtype == np.float32
    # The value stalls where its increment is below half an ulp: k ulp/(4g) a section, here 32 ulp of 9.8 (9.5e-7) at
    # most, and four sections, of which the ringing ones double it.
    assert np.abs(y - low_pass(x.astype(np.float64), 1.0, 200.0, order)).max() < 4 * 2 * 32 * 9.5e-7


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("shape", [(200,), (200, 1), (200, 5), (3, 200, 4)])
def test_layouts_and_splits_change_no_bit(shape: tuple[int, ...], dtype: type) -> None:
    f = LowPass(5, 7.0, 100.0)
    x = samples(shape).astype(dtype)
    along = 0 if len(shape) < 3 else 1
    np.moveaxis(x, along, 0)[50:60] = np.nan
    whole = f.run(x)
    assert whole.shape == x.shape
    assert whole.dtype == dtype
    wide = np.repeat(np.repeat(x, 2, axis=-1), 2, axis=0)[::2][..., ::2]
    for other in (np.asfortranarray(x), wide, x[::-1].copy()[::-1]):
        assert np.array_equal(f.run(other), whole, equal_nan=True)
    first, middle, last = np.split(x, (80, 81), axis=along)
    parts, state = [], None
    for part in (first, middle, last):
        y, state = f.run(part, state=state, return_state=True)
        state = pickle.loads(pickle.dumps(state))
        parts.append(y)
    assert np.array_equal(np.concatenate(parts, axis=along), whole, equal_nan=True)


def test_many_recordings_are_each_alone_and_channels_too() -> None:
    x = samples((3, 150, 7))
    t = np.cumsum(np.random.default_rng(1).uniform(0.0, 0.02, (3, 150)), axis=1)
    f = LowPass(4, 5.0)
    whole = f.run(x, t)
    for recording in range(3):
        alone = f.run(x[recording], t[recording])
        assert np.array_equal(alone, whole[recording])
        for channel in range(7):
            assert np.array_equal(f.run(x[recording, :, channel], t[recording]), alone[:, channel])


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("shape", [(), (3,)])
def test_streaming_is_the_run_bit_for_bit(shape: tuple[int, ...], dtype: type) -> None:
    x = samples((120, *shape)).astype(dtype)
    x[30:33] = np.nan
    steps = np.random.default_rng(2).choice([0.0, 0.0078125, 0.015625], 120)  # exact in both precisions, as their sums
    f = LowPass(4, 5.0, 100.0, dtype=dtype)
    streamed = []
    for index, (row, dt) in enumerate(zip(x, steps, strict=True)):
        if index == 60:
            f = pickle.loads(pickle.dumps(f))
        streamed.append(f.update(row, dt))
    assert streamed[0].shape == shape
    assert streamed[0].dtype == dtype
    assert np.array_equal(np.array(streamed), f.run(x, np.cumsum(steps)))
    state = f.state()
    expected = f.update(x[5])
    f.restore(state)
    assert np.array_equal(f.update(x[5]), expected)
    assert np.array_equal(f.run(x[5:6], state=state)[0], expected), "a run goes on from a stream"
    twin = copy.deepcopy(f)
    assert np.array_equal(twin.update(x[6]), f.update(x[6]))
    f.reset()
    assert np.array_equal(f.update(x[7]), x[7])


def test_a_row_with_a_nan_holds_the_output_and_its_time_counts() -> None:
    x = samples((100, 3))
    t = np.arange(100) / 100.0
    broken = x.copy()
    broken[40:43, 1] = np.nan
    f = LowPass(3, 4.0, 100.0)
    y = f.run(broken)
    assert np.array_equal(y[40:43], np.repeat(y[39:40], 3, axis=0))
    kept = np.delete(np.arange(100), [40, 41, 42])
    # The time of the gap is a sum of steps there and a difference of stamps here.
    assert np.allclose(y[kept], f.run(x[kept], t[kept]), rtol=0, atol=1e-12)
    broken[:5] = np.nan
    assert np.isnan(f.run(broken)[:5]).all()
    assert np.array_equal(f.run(broken)[5], broken[5])


def test_a_cutoff_above_nyquist_passes_through() -> None:
    x = samples((50, 2))
    assert np.array_equal(low_pass(x, 50.0, 100.0), x)
    assert np.array_equal(low_pass(x, 1e6, 100.0), x)


@given(st.integers(1, 8), st.floats(0.01, 0.4), st.integers(0, 2**32 - 1))
def test_steady_signals_pass_with_gain_one_at_any_steps(order: int, cutoff: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.choice([0.0, 1e-6, 0.3, 1.0], 4000))
    x = np.where(np.arange(4000) < 1000, rng.standard_normal(4000), 2.5)
    y = LowPass(order, cutoff).run(x, t)
    # 1300 s or more of a constant: the slowest poles leave exp(−2π · 0.01 · 0.195 · 900 s) = 2e-5 of the noise.
    assert abs(y[-1] - 2.5) < 1e-3
    assert np.abs(y).max() < 30.0


def test_zero_phase_has_no_delay_and_leaves_gaps() -> None:
    t = np.arange(2000) / 100.0
    slow = np.sin(2 * np.pi * 0.5 * t)
    x = slow + np.sin(2 * np.pi * 30.0 * t)
    y = zero_phase(x, 5.0, 100.0)
    # Twice the gain of order 4 at a tenth of the cut-off: 1 − (0.1)⁸; at six times it 6⁻⁸.
    assert np.abs(y - slow)[200:-200].max() < 1e-5
    many = np.stack((np.stack((x, -x), axis=1), np.stack((2 * x, x), axis=1)))
    many[1, 500:503, 0] = np.nan
    both = zero_phase(many, 5.0, 100.0)
    assert np.allclose(both[0, :, 0], y, rtol=0, atol=1e-12)
    assert np.isnan(both[1, 500:503]).all()
    assert np.isnan(both).sum() == 6
    # Shorter than the filter; its coefficients in doubles have the gain one to 1e-13 or so.
    assert np.allclose(zero_phase([1.0, 1.0], 5.0, 100.0), 1.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: LowPass(0, 1.0), "order: expected a whole number from 1 to 8, got 0"),
        (lambda: LowPass(9, 1.0), "order: expected a whole number from 1 to 8, got 9"),
        (lambda: LowPass(2.0, 1.0), "order: expected a whole number"),  # type: ignore[arg-type]
        (lambda: LowPass(2, 0.0), "cutoff: expected a positive, finite number of Hz, got 0.0"),
        (lambda: LowPass(2, np.nan), "cutoff: expected a positive"),
        (lambda: LowPass(2, 1.0, -5.0), "rate: expected a positive"),
        (lambda: LowPass(2, 1.0, dtype=np.int32), "dtype: expected float32 or float64, got int32"),
        (lambda: LowPass(2, 1.0).run([1.0]), "t: expected stamps"),
        (lambda: LowPass(2, 1.0).update(1.0), "dt: expected a time step"),
        (lambda: LowPass(2, 1.0).update(1.0, -1.0), "dt: expected a finite number of seconds, not negative, got -1"),
        (lambda: LowPass(2, 1.0, 9.0).update([[1.0]]), r"x: expected a number or shape \(C,\), got shape \(1, 1\)"),
        (lambda: LowPass(2, 1.0, 9.0).run(1.0), r"x: expected shape \(T,\), \(T, C\) or \(N, T, C\), got \(\)"),
        (lambda: LowPass(2, 1.0, 9.0).run(["a"]), "x: expected an array of real numbers"),
        (lambda: LowPass(2, 1.0, 9.0).run([[1.0, np.inf]]), "x: expected finite values or NaN .* index"),
        (lambda: LowPass(2, 1.0, 9.0).run([1.0, 2.0], [1.0, 0.5]), "t: expected stamps that do not decrease"),
        (lambda: LowPass(2, 1.0, 9.0).run([1.0, 2.0], [1.0]), r"t: expected shape \(2,\), got \(1,\)"),
        (lambda: LowPass(2, 1.0, 9.0).run([1.0], state=3), "state: expected a LowPassState, got int"),  # type: ignore[call-overload]
        (lambda: zero_phase([1.0], 5.0, 10.0), "cutoff: expected less than half of rate, 5 Hz, got 5"),
        (lambda: zero_phase([np.nan], 1.0, 10.0), "x: expected at least one row without NaN"),
        (lambda: zero_phase([np.inf], 1.0, 10.0), "x: expected finite values"),
        (lambda: zero_phase(1.0, 1.0, 10.0), "x: expected shape"),
    ],
)
def test_errors_say_what_is_expected(call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()


def test_a_state_of_another_filter_is_refused() -> None:
    x = samples((10, 3))
    _, state = LowPass(4, 5.0, 100.0).run(x, return_state=True)
    for other in (LowPass(3, 5.0, 100.0), LowPass(4, 6.0, 100.0)):
        with pytest.raises(ValueError, match="state: expected one of"):
            other.run(x, state=state)
    with pytest.raises(ValueError, match="dtype"):
        LowPass(4, 5.0, 100.0).run(x.astype(np.float32), state=state)
    with pytest.raises(ValueError, match="state"):
        LowPass(4, 5.0, 100.0).run(x[:, :2], state=state)
    with pytest.raises(ValueError, match="dtype"):
        LowPass(4, 5.0, 100.0, dtype=np.float32).restore(state)
    stamped = LowPass(4, 5.0).run(x, np.arange(10.0), return_state=True)[1]
    with pytest.raises(ValueError, match="do not decrease"):
        LowPass(4, 5.0).run(x, np.arange(10.0), state=stamped)
    assert ar.signal.LowPass is LowPass
