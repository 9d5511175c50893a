"""A process that is forked after a batch, or amid one, computes batches too."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from signals import RATE, motion

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")

SIGNALS = [motion(samples, seed) for seed, samples in enumerate((3000, 2000, 2500, 3000, 1000))]
STACKED = [np.stack([one.sensors()[k][:1000] for one in SIGNALS]) for k in range(3)]


def _recordings() -> list[ar.Recording]:
    return [ar.Recording(t=one.t, gyr=one.gyr, acc=one.acc, mag=one.mag, ref=one.truth, rate=RATE) for one in SIGNALS]


#: What is computed in several threads.
WORKS: dict[str, Callable[[], Any]] = {
    "run": lambda: ar.VQF(rate=RATE).run(*STACKED, threads=4).quat,
    "run_many": lambda: [
        est.quat for est in ar.run_many(ar.Mahony(rate=RATE), [x.sensors() for x in SIGNALS], threads=4)
    ],
    "offline": lambda: [
        est.quat for est in ar.run_many(ar.OfflineVQF(rate=RATE), [x.sensors() for x in SIGNALS], threads=4)
    ],
    "sweep": lambda: ar.sweep(ar.Madgwick, {"beta": np.linspace(0.01, 0.3, 70)}, _recordings(), threads=4).errors,
    "by default": lambda: ar.VQF(rate=RATE).run(*STACKED).quat,
}

PROGRAM = """
import os, sys, threading
sys.path.insert(0, sys.argv[1])
from test_fork import WORKS, digest
work = WORKS[sys.argv[2]]
expected = digest(work())
stop = threading.Event()

def beside():
    while not stop.is_set():
        work()

others = [threading.Thread(target=beside) for _ in range(int(sys.argv[3]))]
for one in others:
    one.start()
for _ in range(5):
    child = os.fork()
    if child == 0:
        os._exit(0 if digest(work()) == expected else 3)
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 0, status
stop.set()
for one in others:
    one.join()
print("done")
"""


def digest(result: Any) -> bytes:
    return b"".join(np.ascontiguousarray(part).tobytes() for part in (result if isinstance(result, list) else [result]))


@pytest.mark.parametrize("others", [0, 2], ids=["after a batch", "amid batches of other threads"])
@pytest.mark.parametrize("name", WORKS)
def test_a_forked_child_computes_the_same_bits(name: str, others: int) -> None:
    # In a process of its own, which is ended after two minutes: what hangs would stop all tests.
    command = [
        sys.executable,
        "-W",
        "ignore::DeprecationWarning",
        "-c",
        PROGRAM,
        str(Path(__file__).parent),
        name,
        str(others),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.stdout == "done\n", done.stderr


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs /proc")
def test_no_thread_outlives_a_call() -> None:
    def count() -> int:
        return len(list(Path("/proc/self/task").iterdir()))

    def compute() -> None:
        for work in WORKS.values():
            work()

    compute()  # numpy's own threads, if it starts any, are there from now on
    before = count()
    compute()
    for _ in range(100):  # the system lists a thread for some time after it has been joined
        if count() <= before:
            return
        time.sleep(0.01)
    pytest.fail(f"{count()} threads, {before} before")
