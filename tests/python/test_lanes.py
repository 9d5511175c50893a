"""The batch engine: recordings side by side in vector registers."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from cases import Case, assert_same_attitudes, each_case
from signals import RATE, gappy, motion


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@each_case
def test_recordings_side_by_side_are_those_alone_bit_for_bit(case: Case, dtype: type) -> None:
    signals = [gappy(motion(150, seed, jitter=True), seed).astype(dtype) for seed in range(19)]
    data = np.stack([np.stack(one.sensors()) for one in signals], axis=1)
    t = np.stack([one.t for one in signals])
    f = case.make(rate=RATE)
    together = f.run(*data, t=t)
    for index, one in enumerate(signals):
        alone = f.run(*one.sensors(), t=one.t)
        assert np.array_equal(together.quat[index], alone.quat)
        assert np.array_equal(together.status[index], alone.status)
        if alone.gyr_bias is not None:
            assert together.gyr_bias is not None
            assert np.array_equal(together.gyr_bias[index], alone.gyr_bias)
        assert together.state[index] == alone.state


@each_case
def test_further_outputs_of_recordings_side_by_side_are_those_alone(case: Case) -> None:
    names = tuple(case.cls.OUTPUTS)
    data = np.stack([np.stack(motion(40, seed).sensors()) for seed in range(5)], axis=1)
    f = case.make(rate=RATE)
    together = f.run(*data, outputs=names)
    for name in names:
        for index in range(5):
            alone = f.run(*data[:, index], outputs=names)
            assert np.array_equal(together.extra[name][index], alone.extra[name], equal_nan=True)


@pytest.mark.parametrize("sliced", [np.s_[:, ::2], np.s_[::-1], np.s_[:, :, ::-1]])
def test_any_layout_of_inputs_and_of_out_is_the_same(sliced: tuple[slice, ...]) -> None:
    data = [array[sliced] for array in np.stack([np.stack(motion(90, s).sensors()) for s in range(9)], axis=1)]
    f = ar.Mahony(rate=RATE)
    expected = f.run(*[np.ascontiguousarray(array) for array in data])
    room = np.full((*expected.quat.shape[:-1], 8), 7.0)
    est = f.run(*data, out=room[..., ::-2])
    assert_same_attitudes(est, expected)
    assert np.array_equal(room[..., ::-2], expected.quat)
    assert np.all(room[..., ::2] == 7.0)


def test_an_infinite_value_in_any_lane_is_an_error_that_says_where() -> None:
    data = np.stack([np.stack(motion(200, seed).sensors()) for seed in range(12)], axis=1)
    f = ar.Madgwick(rate=RATE)
    for sensor, name in enumerate(("gyr", "acc", "mag")):
        broken = data.copy()
        broken[sensor, 7, 150, 2] = -np.inf
        with pytest.raises(ValueError, match=rf"{name}: expected finite values.*\(7, 150, 2\)"):
            f.run(*broken)
        with pytest.raises(ValueError, match=rf"recording 7: {name}: expected finite values.*\(150, 2\)"):
            ar.run_many(f, [tuple(broken[:, index]) for index in range(12)])
    estimates = ar.run_many(f, [tuple(broken[:, index]) for index in range(12)], errors="return")
    assert [type(est) for est in estimates] == [ar.Estimate] * 7 + [ValueError] + [ar.Estimate] * 4
    assert np.array_equal(estimates[8].quat, f.run(*data[:, 8]).quat)


BITS = """
import hashlib
import numpy as np
import ahrs_rs as ar
from signals import RATE, gappy, motion

digest = hashlib.sha256()
for dtype in (np.float64, np.float32):
    signals = [gappy(motion(150, seed), seed).astype(dtype) for seed in range(19)]
    data = np.stack([np.stack(one.sensors()) for one in signals], axis=1)
    for cls in ar.FILTERS.values():
        est = cls(rate=RATE).run(*data)
        digest.update(est.quat.tobytes() + est.status.tobytes())
print(ar._native.INSTRUCTIONS, digest.hexdigest())
"""


def with_instructions(name: str) -> subprocess.CompletedProcess[str]:
    """A process in which the variable for tests and measurements chooses the instructions."""
    env = {**os.environ, "AHRS_RS_ISA": name}
    words = [sys.executable, "-c", BITS]
    return subprocess.run(words, env=env, cwd=Path(__file__).parent, capture_output=True, text=True, check=False)


def test_all_instructions_of_this_machine_give_the_same_bits() -> None:
    refused = with_instructions("none")
    names = re.search(r"AHRS_RS_ISA: expected one of (.*) on this machine and build, got \"none\"", refused.stderr)
    assert refused.returncode != 0
    assert names is not None, refused.stderr
    runs = {name: with_instructions(name) for name in names[1].split(", ")}
    assert len(runs) > 1, "one after the other, and at least one kind of lanes"
    assert {run.returncode for run in runs.values()} == {0}, [run.stderr for run in runs.values()]
    used, digests = zip(*(run.stdout.split() for run in runs.values()), strict=True)
    assert used == tuple(runs), "the variable chooses them"
    assert len(set(digests)) == 1, dict(zip(used, digests, strict=True))


MEMORY = """
import resource, sys
import numpy as np
import ahrs_rs as ar

N, T = 200, 6401
gyr = np.ones((N, T, 3)); acc = np.ones((N, T, 3)); mag = np.ones((N, T, 3))
f = ar.Mahony(rate=100.0)
f.run(gyr[:, :100], acc[:, :100], mag[:, :100])
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
est = f.run(gyr, acc, mag)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
results = est.quat.nbytes + est.gyr_bias.nbytes + est.status.nbytes
print(peak * 1024 - before * 1024 - results)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the unit of ru_maxrss is that of Linux")
def test_memory_stays_at_inputs_outputs_and_some_megabytes() -> None:
    # In a process of its own, whose largest size nothing else has raised.
    result = subprocess.run([sys.executable, "-c", MEMORY], capture_output=True, text=True, check=True)
    # The tiles of a thread are a third of a megabyte; the rest is the interpreter's.
    assert int(result.stdout) < 16e6
