"""One sample at a time, a piece at a time or all at once: the same bits."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from cases import CASES, Case, each_case
from signals import RATE, Signals, gappy, motion

DTYPES = [np.float64, np.float32]
SAMPLES = 700


def recording(seed: int, dtype: type = np.float64, samples: int = SAMPLES) -> Signals:
    """Motion with jitter and gaps, also at the very start."""
    signals = gappy(motion(samples, seed, jitter=True), seed + 100)
    return signals.without(acc=slice(0, seed % 5), mag=slice(0, 7 * (seed % 3))).astype(dtype)


def cuts(seed: int, samples: int = SAMPLES) -> list[slice]:
    """The samples cut into random pieces, some of one sample, some of none."""
    rng = np.random.default_rng(seed)
    inner = np.sort(rng.integers(0, samples + 1, 25))
    ends = [0, 0, 1, 2, *inner, inner[-1], samples]
    return [slice(int(a), int(b)) for a, b in zip(sorted(ends), sorted(ends)[1:], strict=False)]


def assert_same(pieces: list[ar.Estimate], whole: ar.Estimate) -> None:
    """The estimates of the pieces, one after the other, are those of the whole, bit for bit."""
    assert np.array_equal(np.concatenate([e.quat for e in pieces], axis=-2), whole.quat)
    assert np.array_equal(np.concatenate([e.status for e in pieces], axis=-1), whole.status)
    assert (whole.gyr_bias is None) == any(e.gyr_bias is None for e in pieces)
    if whole.gyr_bias is not None:
        assert np.array_equal(np.concatenate([e.gyr_bias for e in pieces], axis=-2), whole.gyr_bias)
    for name, values in whole.extra.items():
        axis = whole.quat.ndim - 2
        # NaN is an innovation that there is not.
        assert np.array_equal(np.concatenate([e.extra[name] for e in pieces], axis=axis), values, equal_nan=True)


def run_in_pieces(f: ar.Filter, signals: Signals, seed: int, *, with_t: bool, **first: Any) -> list[ar.Estimate]:
    pieces: list[ar.Estimate] = []
    more: dict[str, Any] = {"outputs": tuple(f.OUTPUTS)}
    for cut in cuts(seed):
        start = {"state": pieces[-1].state} if pieces else first
        time = {"t": signals.t[cut]} if with_t else {}
        pieces.append(f.run(*(array[cut] for array in signals.sensors()), **time, **start, **more))
    return pieces


@pytest.mark.parametrize("with_t", [False, True], ids=["rate", "t"])
@pytest.mark.parametrize("dtype", DTYPES)
@each_case
def test_a_split_run_equals_the_whole_run(case: Case, dtype: type, with_t: bool) -> None:
    for seed, settings in enumerate(({}, {"frame": "NED", "declination": 0.2}, {"gyr_hold": "linear"})):
        f = case.make(rate=RATE, **settings)
        signals = recording(seed, dtype)
        time = {"t": signals.t} if with_t else {}
        whole = f.run(*signals.sensors(), **time, outputs=tuple(f.OUTPUTS))
        pieces = run_in_pieces(f, signals, seed, with_t=with_t)
        assert_same(pieces, whole)
        assert pieces[-1].state == whole.state


@pytest.mark.parametrize("with_t", [False, True], ids=["rate", "t"])
@each_case
def test_a_split_run_from_q0_equals_the_whole_run(case: Case, with_t: bool) -> None:
    f = case.make(rate=RATE, declination=-0.1, frame="NWU")
    signals = recording(4)
    time = {"t": signals.t} if with_t else {}
    whole = f.run(*signals.sensors(), **time, q0=signals.before, outputs=tuple(f.OUTPUTS))
    assert_same(run_in_pieces(f, signals, 4, with_t=with_t, q0=signals.before), whole)


@pytest.mark.parametrize("cut", [1, 2, 350])
@each_case
def test_a_split_run_of_stamps_without_rate_equals_the_whole_run(case: Case, cut: int) -> None:
    f = case.make()
    signals = recording(5)
    whole = f.run(*signals.sensors(), t=signals.t)
    first = f.run(*(array[:cut] for array in signals.sensors()), t=signals.t[:cut])
    second = f.run(*(array[cut:] for array in signals.sensors()), t=signals.t[cut:], state=first.state)
    assert_same([first, second], whole)
    assert second.state == whole.state


@pytest.mark.parametrize("dtype", DTYPES)
@each_case
def test_a_split_run_of_many_recordings_equals_the_whole_run(case: Case, dtype: type) -> None:
    f = case.make(rate=RATE)
    all_signals = [recording(seed, dtype) for seed in range(3)]
    arrays = [np.stack([s.sensors()[i] for s in all_signals]) for i in range(3)]
    t = np.stack([s.t for s in all_signals])
    whole = f.run(*arrays, t=t)
    pieces: list[ar.Estimate] = []
    for cut in cuts(1):
        state = pieces[-1].state if pieces else None
        pieces.append(f.run(*(a[:, cut] for a in arrays), t=t[:, cut], state=state))
    assert_same(pieces, whole)
    assert isinstance(whole.state, list)
    assert pieces[-1].state == whole.state
    assert whole.state == [f.run(*s.sensors(), t=s.t).state for s in all_signals]


def stream(f: ar.Filter, signals: Signals, dt: np.ndarray | None) -> ar.Estimate:
    """The samples through `update`, collected as `run` gives them."""
    rows: list[tuple[Any, ...]] = []
    for k in range(len(signals)):
        quat = f.update(*(array[k] for array in signals.sensors()), dt=None if dt is None else float(dt[k]))
        assert np.array_equal(quat, f.quat)
        rows.append((quat, f.gyr_bias, int(f.status)))
    quats, biases, status = zip(*rows, strict=True)
    bias = None if biases[0] is None else np.array(biases)
    return ar.Estimate(np.array(quats), bias, np.array(status, np.uint16), signals.t, f.state(), {})


@pytest.mark.parametrize("with_t", [False, True], ids=["rate", "t"])
@pytest.mark.parametrize("dtype", DTYPES)
@each_case
def test_streaming_equals_batch(case: Case, dtype: type, with_t: bool) -> None:
    for seed, settings in enumerate(({"gyr_hold": "linear"}, {"frame": "NED", "declination": 0.2})):
        f = case.make(rate=RATE, dtype=dtype, **settings)
        signals = recording(seed + 1, dtype)
        batch = f.run(*signals.sensors(), t=signals.t if with_t else None)
        # The first sample aligns, whatever its dt; a filter that starts by itself turns by it.
        first = 1.0 / RATE if case.starts_itself else 0.5
        streamed = stream(f, signals, np.concatenate(([first], np.diff(signals.t))) if with_t else None)
        assert streamed.quat.dtype == dtype
        assert_same([streamed], batch)
        assert streamed.state.variables == batch.state.variables
        assert streamed.state.samples == batch.state.samples


@each_case
def test_streaming_from_q0_equals_batch(case: Case) -> None:
    f = case.make(rate=RATE, frame="NED", declination=0.1)
    signals = recording(3)
    batch = f.run(*signals.sensors(), t=signals.t, q0=signals.before)
    f.reset(q0=signals.before)
    # With rate and t given, rate is the step of sample 0.
    assert_same([stream(f, signals, np.concatenate(([1.0 / RATE], np.diff(signals.t))))], batch)


@each_case
def test_run_and_update_continue_each_other(case: Case) -> None:
    f = case.make(rate=RATE)
    signals = recording(6)
    whole = f.run(*signals.sensors())
    for k in range(200):
        f.update(*(array[k] for array in signals.sensors()))
    rest = f.run(*(array[200:] for array in signals.sensors()), state=f.state())
    assert np.array_equal(rest.quat, whole.quat[200:])
    g = case.make(rate=RATE)
    g.restore(f.run(*(array[:200] for array in signals.sensors())).state)
    assert np.array_equal(g.quat, whole.quat[199])
    for k in range(200, 260):
        assert np.array_equal(g.update(*(array[k] for array in signals.sensors())), whole.quat[k])


@each_case
def test_run_never_changes_the_filter(case: Case) -> None:
    f = case.make(rate=RATE)
    signals = recording(7)
    for k in range(10):
        f.update(*(array[k] for array in signals.sensors()))
    before = (f.state(), f.quat.copy(), f.status, repr(f))
    f.run(*signals.sensors())
    f.run(*signals.sensors(), t=signals.t, state=f.state())
    f.run(*signals.sensors(), q0=signals.before)
    assert f.state() == before[0]
    assert np.array_equal(f.quat, before[1])
    assert (f.status, repr(f)) == before[2:]


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize(
    "clone",
    [lambda f: f.copy(), copy.copy, copy.deepcopy, lambda f: pickle.loads(pickle.dumps(f))],
    ids=["copy()", "copy.copy", "deepcopy", "pickle"],
)
@each_case
def test_a_clone_goes_its_own_way(case: Case, clone: Any, dtype: type) -> None:
    f = case.make(rate=RATE, frame="NED", declination=0.1, gyr_hold="linear", dtype=dtype)
    signals = recording(8, dtype)
    for k in range(20):
        f.update(*(array[k] for array in signals.sensors()))
    twin = clone(f)
    assert type(twin) is type(f)
    assert repr(twin) == repr(f)
    assert twin.state() == f.state()
    row = [array[20] for array in signals.sensors()]
    after = f.update(*row)
    assert twin.state() != f.state()
    assert np.array_equal(twin.update(*row), after)


@each_case
def test_a_pickled_state_is_the_state(case: Case) -> None:
    f = case.make(rate=RATE)
    signals = recording(9)
    state = f.run(*signals.sensors(), t=signals.t).state
    again = pickle.loads(pickle.dumps(state))
    assert again == state
    assert copy.deepcopy(state) == state
    f.restore(again)
    assert f.state() == state


def test_reset_starts_anew() -> None:
    signals = recording(10)
    for case in CASES:
        f, fresh = case.make(rate=RATE), case.make(rate=RATE)
        for k in range(50):
            f.update(*(array[k] for array in signals.sensors()))
        f.reset()
        assert f.state() == fresh.state()
        assert np.array_equal(f.quat, [1.0, 0.0, 0.0, 0.0])
        f.reset(q0=signals.before)
        assert np.abs(f.quat * np.sign(f.quat[0]) - signals.before * np.sign(signals.before[0])).max() < 1e-15


def other_filters() -> list[tuple[str, ar.Filter]]:
    return [
        ("Mahony", ar.Mahony(rate=RATE)),
        ("beta", ar.Madgwick(rate=RATE, beta=0.05)),
        ("gradient", ar.Madgwick(rate=RATE, gradient="paper")),
        ("frame", ar.Madgwick(rate=RATE, frame="NED")),
        ("declination", ar.Madgwick(rate=RATE, declination=0.1)),
        ("gyr_hold", ar.Madgwick(rate=RATE, gyr_hold="linear")),
        ("float32", ar.Madgwick(rate=RATE, dtype=np.float32)),
    ]


@pytest.mark.parametrize(("what", "other"), other_filters(), ids=lambda value: value if isinstance(value, str) else "")
def test_a_state_of_another_filter_is_a_value_error_that_says_what_differs(what: str, other: ar.Filter) -> None:
    signals = recording(11)
    f = ar.Madgwick(rate=RATE)
    state = other.state()
    with pytest.raises(ValueError, match=f"state: .*{what}"):
        f.restore(state)
    with pytest.raises(ValueError, match=f"state: .*{what}"):
        f.run(*signals.sensors(), state=state)
    f.restore(ar.Madgwick(rate=50.0).state())  # the rate is no part of the filter


def test_a_state_needs_its_filter_its_number_and_no_q0() -> None:
    f = ar.Madgwick(rate=RATE)
    data = np.ones((2, 4, 3))
    with pytest.raises(ValueError, match="state: expected 2 states, one for each recording, got 1"):
        f.run(data, state=f.state())
    with pytest.raises(ValueError, match="state: expected a State"):
        f.run(data[0], state=[1])
    with pytest.raises(ValueError, match="q0: expected None where a state is given"):
        f.run(data[0], state=f.state(), q0=[1.0, 0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="state: expected a state of Madgwick, got one of Tilt"):
        f.run(data, state=[f.state(), ar.Tilt().state()])


def test_stamps_must_go_on_from_the_state() -> None:
    f = ar.Tilt()
    state = f.run(np.zeros((3, 3)), t=[0.0, 1.0, 2.0]).state
    with pytest.raises(ValueError, match=r"t: expected stamps that do not decrease, got 1\.5 after 2 at index 0"):
        f.run(np.zeros((2, 3)), t=[1.5, 2.5], state=state)
    assert f.run(np.zeros((2, 3)), t=[2.0, 2.5], state=state).state.last_t == 2.5


@pytest.mark.parametrize("dt", [-0.01, np.nan, np.inf])
def test_a_bad_step_of_update_is_a_value_error_and_changes_nothing(dt: float) -> None:
    f = ar.Mahony(rate=RATE)
    f.update([0.1, 0.2, 0.3], [0.0, 0.0, 9.8], dt=0.01)
    state = f.state()
    with pytest.raises(ValueError, match="dt: expected a finite number of seconds, not negative"):
        f.update([0.1, 0.2, 0.3], [0.0, 0.0, 9.8], dt=dt)
    with pytest.raises(ValueError, match="gyr: expected finite values"):
        f.update([np.inf, 0.2, 0.3], [0.0, 0.0, 9.8])
    with pytest.raises(ValueError, match=r"acc: expected shape \(3,\), got \(2,\)"):
        f.update([0.1, 0.2, 0.3], [0.0, 9.8])
    assert f.state() == state


def test_update_needs_a_step_where_there_is_no_rate() -> None:
    with pytest.raises(ValueError, match=r"dt: .*without rate"):
        ar.Mahony().update([0.0, 0.0, 0.0])
