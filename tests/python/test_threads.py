"""Many threads: on one filter, on shared arrays, and inside a run. Results never depend on them."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from cases import COMMON, Case, assert_same_attitudes, each_case, each_streaming_filter
from signals import RATE, Signals, gappy, motion

pytestmark = pytest.mark.threads

THREADS = 8


def at_once(work: Callable[[int], Any], threads: int = THREADS) -> list[Any]:
    """The results of `work(0)`, `work(1)`, ... in threads that begin together."""
    barrier = threading.Barrier(threads)

    def begin(index: int) -> Any:
        barrier.wait()
        return work(index)

    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(begin, range(threads)))


def ragged(seed: int = 0) -> list[Signals]:
    """Recordings of different lengths, one of them of none."""
    return [gappy(motion(samples, seed + samples), samples) for samples in (700, 3, 0, 256, 257, 1, 1500, 40)]


# One filter in many threads.


@each_streaming_filter
def test_no_update_of_many_threads_on_one_filter_is_lost(name: str) -> None:
    f = ar.FILTERS[name](rate=RATE)
    updates = 500

    def work(index: int) -> None:
        for _ in range(updates):
            f.update([0.01 * index, 0.0, 0.02], [0.0, 0.1, 9.8], [0.0, 20.0, -40.0])

    at_once(work)
    assert f.state().samples == THREADS * updates
    assert abs(np.linalg.norm(f.quat) - 1.0) < 1e-15


def test_the_turns_of_many_threads_add_up() -> None:
    f = ar.GyroIntegration(rate=RATE)
    f.reset(q0=[1.0, 0.0, 0.0, 0.0])
    at_once(lambda _: [f.update([0.0, 0.0, 0.1]) for _ in range(250)])
    # All turns are about one axis, so their order is of no consequence: 2000 of 1 mrad.
    angle = 2.0 * np.arctan2(f.quat[3], f.quat[0])
    # 2000 roundings of 1e-16.
    assert abs(angle - 2.0) < 1e-12


@each_streaming_filter
def test_reading_and_copying_while_others_update_never_sees_half_a_sample(name: str) -> None:
    f = ar.FILTERS[name](rate=RATE)

    def work(index: int) -> bool:
        whole = True
        for k in range(200):
            if index % 2:
                f.update([1.0, 0.2 * index, 0.3], [0.1 * k, 0.1, 9.8], [0.0, 20.0, -40.0])
            else:
                twin = f.copy()
                # The last four variables of the common part are flags; the quaternion is always a unit one.
                whole &= abs(np.linalg.norm(twin.quat) - 1.0) < 1e-15 and len(f.state().variables) > 0
                whole &= int(f.status) & COMMON == 0 or f.state().samples == 0
        return whole

    assert all(at_once(work))


@each_case
def test_runs_of_many_threads_on_one_filter_and_shared_arrays_give_the_same_bits(case: Case) -> None:
    signals = gappy(motion(1000, 1), 2)
    f = case.make(rate=RATE)
    plain = f.run(*signals.sensors())
    for est in at_once(lambda _: [f.run(*signals.sensors()) for _ in range(3)]):
        for one in est:
            assert_same_attitudes(one, plain)
    assert f.state().samples == 0


def test_runs_beside_updates_are_not_disturbed() -> None:
    signals = motion(2000, 3)
    f = ar.Mahony(rate=RATE)
    plain = f.run(*signals.sensors())

    def work(index: int) -> bool:
        if index % 2:
            return np.array_equal(f.run(*signals.sensors()).quat, plain.quat)
        for k in range(200):
            f.update(*(array[k] for array in signals.sensors()))
        return True

    assert all(at_once(work))
    assert f.state().samples == 200 * THREADS // 2


# A reset whose argument runs Python code that uses the same filter, from this thread or from another one.
CALLED_BACK = """
import threading
import numpy as np
import ahrs_rs as ar

f = ar.Madgwick(rate=100.0)

class Attitude:
    def __array__(self, dtype=None, copy=None):
        other = threading.Thread(target=f.update, args=([0.0, 0.0, 0.1],))
        other.start()
        other.join()
        f.update([0.0, 0.0, 0.1])
        return np.array([1.0, 0.0, 0.0, 0.0])

f.reset(q0=Attitude())
print("done")
"""


def test_an_argument_that_uses_the_filter_itself_does_not_lock_it_for_ever() -> None:
    # In a process of its own, which is ended after 30 s: a lock that is never given back would stop all tests.
    result = subprocess.run(
        [sys.executable, "-c", CALLED_BACK], capture_output=True, text=True, timeout=30, check=False
    )
    assert result.stdout == "done\n", result.stderr


# Threads inside a run.


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@each_case
def test_the_number_of_threads_of_a_run_changes_no_bit(case: Case, dtype: type) -> None:
    data = np.stack([np.stack(gappy(motion(400, seed), seed).astype(dtype).sensors()) for seed in range(11)], axis=1)
    f = case.make(rate=RATE)
    plain = f.run(*data, threads=1)
    for threads in (2, 8, None):
        est = f.run(*data, threads=threads)
        assert_same_attitudes(est, plain)
        assert np.array_equal(est.status, plain.status)
        assert est.state == plain.state


def others_count_during(work: Callable[[], Any]) -> int:
    """How far a Python thread counts while `work` runs, with no switch of threads but where work lets go."""
    counter = 0
    stop = threading.Event()
    started = threading.Event()

    def count() -> None:
        nonlocal counter
        started.set()
        while not stop.is_set():
            counter += 1
            time.sleep(0.0)

    before = sys.getswitchinterval()
    thread = threading.Thread(target=count)
    thread.start()
    started.wait()
    sys.setswitchinterval(1000.0)  # s: nobody is interrupted, so only a released lock lets the other thread in
    try:
        time.sleep(0.05)  # the other thread must have begun to wait by the new interval
        at_start = counter
        work()
        return counter - at_start
    finally:
        sys.setswitchinterval(before)
        stop.set()
        thread.join()


def test_the_count_stands_still_while_a_native_function_keeps_the_lock() -> None:
    assert others_count_during(lambda: sum(range(3_000_000))) == 0


def test_run_releases_the_interpreter_lock() -> None:
    data = np.full((3, 2, 200_000, 3), 6.0)  # 10 m/s² of specific force: readings that may be
    f = ar.Madgwick(rate=RATE)
    assert others_count_during(lambda: f.run(*data)) > 0
    assert others_count_during(lambda: f.run(*data[:, 0])) > 0


def test_run_many_releases_the_interpreter_lock() -> None:
    data = np.ones((3, 4, 100_000, 3))
    f = ar.Madgwick(rate=RATE)
    assert others_count_during(lambda: ar.run_many(f, [tuple(data[:, i]) for i in range(4)], threads=2)) > 0


# Many recordings.


@pytest.mark.parametrize("threads", [1, 2, 8, None])
@each_case
def test_run_many_is_a_loop_in_the_same_order(case: Case, threads: int | None) -> None:
    f = case.make(rate=RATE)
    recordings = ragged()
    estimates = ar.run_many(f, [r.sensors() for r in recordings], threads=threads)
    assert len(estimates) == len(recordings)
    for est, recording in zip(estimates, recordings, strict=True):
        one = f.run(*recording.sensors())
        assert_same_attitudes(est, one)
        assert np.array_equal(est.status, one.status)
        assert est.state == one.state
    assert f.state().samples == 0


def test_run_many_takes_recordings_dicts_and_tuples() -> None:
    signals = motion(50, 4)
    f = ar.Mahony(rate=RATE)
    recording = ar.Recording(t=signals.t, gyr=signals.gyr, acc=signals.acc, mag=signals.mag)
    six = ar.Recording(t=signals.t, gyr=signals.gyr, acc=signals.acc)
    keywords = {"gyr": signals.gyr, "acc": signals.acc, "q0": signals.before, "outputs": ("innovation",)}
    estimates = ar.run_many(f, [recording, six, keywords, signals.sensors(), (signals.gyr,)])
    loop = [
        f.run(*signals.sensors(), t=signals.t),
        f.run(signals.gyr, signals.acc, t=signals.t),
        f.run(**keywords),
        f.run(*signals.sensors()),
        f.run(signals.gyr),
    ]
    for est, one in zip(estimates, loop, strict=True):
        assert_same_attitudes(est, one)
    assert np.array_equal(estimates[2].extra["innovation"], loop[2].extra["innovation"])


def test_run_many_goes_on_from_the_states_of_another() -> None:
    f = ar.Madgwick(rate=RATE)
    recordings = [motion(samples, samples) for samples in (100, 60, 31)]
    first = ar.run_many(f, [tuple(array[:30] for array in r.sensors()) for r in recordings])
    rest = [
        dict(zip(("gyr", "acc", "mag"), (array[30:] for array in r.sensors()), strict=True)) | {"state": est.state}
        for r, est in zip(recordings, first, strict=True)
    ]
    for est, r in zip(ar.run_many(f, rest), recordings, strict=True):
        assert np.array_equal(est.quat, f.run(*r.sensors()).quat[30:])


def test_run_many_of_nothing_is_nothing() -> None:
    assert ar.run_many(ar.Tilt(rate=RATE), []) == []
    assert ar.run_many(ar.Tilt(rate=RATE), iter(())) == []


def test_run_many_takes_a_generator_once() -> None:
    recordings = (r.sensors() for r in ragged())
    assert [len(est) for est in ar.run_many(ar.Tilt(rate=RATE), recordings)] == [len(r) for r in ragged()]


def bad_recordings() -> list[Any]:
    good = motion(20, 5).sensors()
    infinite = np.full((5, 3), np.inf)
    return [good, (infinite,), good, "no recording", {"gyr": good[0], "unknown": 1}, good]


def test_run_many_puts_an_exception_in_the_place_of_its_recording() -> None:
    estimates = ar.run_many(ar.Tilt(rate=RATE), bad_recordings(), errors="return")
    kinds = [ar.Estimate, ValueError, ar.Estimate, ValueError, TypeError, ar.Estimate]
    assert [type(est) for est in estimates] == kinds
    assert str(estimates[1]).startswith("recording 1: gyr: ")
    assert str(estimates[3]).startswith("recording 3: expected a Recording, a dict or a tuple")


@pytest.mark.parametrize("threads", [1, 8])
def test_run_many_raises_an_error_that_names_the_recording(threads: int) -> None:
    recordings = bad_recordings()[:3]
    with pytest.raises(ValueError, match="recording 1: gyr: expected finite values"):
        ar.run_many(ar.Tilt(rate=RATE), recordings, threads=threads)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"errors": "ignore"}, "errors: expected 'raise' or 'return'"),
        ({"threads": 0}, "threads: expected a positive whole number"),
        ({"threads": True}, "threads: expected a positive whole number"),
    ],
)
def test_run_many_checks_its_options(keywords: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ar.run_many(ar.Tilt(rate=RATE), [], **keywords)
