"""Short forms of `make attack`: commands that are killed, calls that leave no memory."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar

TOOLS = Path(__file__).resolve().parents[2] / "tools"
sys.path.insert(0, str(TOOLS))

import attack  # noqa: E402
import attack_commands  # noqa: E402
import attack_memory  # noqa: E402

pytestmark = pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs Linux")


@pytest.mark.parametrize("name", ["run (csv)", "calibrate", "tune"])
def test_a_command_that_is_killed_leaves_files_that_are_as_before_or_whole(name: str, tmp_path: Path) -> None:
    attack_commands.recordings(tmp_path / "data", 0.5)
    command = next(one for one in attack_commands.commands(tmp_path / "data") if one.name == name)
    own = attack_commands.fresh(tmp_path / "own")
    seconds, new = command.run(own)
    for moment in np.linspace(0.3, 1.0, 4) * seconds:
        command.prepare(own)
        with command.start(own) as process:
            if attack.run_until(process, float(moment)):
                process.kill()
        assert command.wrong(own, new) == []
    # What was killed is gone on from, or done again, to the same bytes; nothing of it is left.
    command.run(own)
    assert command.wrong(own, new) == []
    assert not list(own.rglob(".*.part*"))


def test_a_whole_output_is_known_from_a_part_of_it() -> None:
    """What the test above believes."""
    table = b"name,time\na,1.5\nb,2.5\n"
    assert attack_commands.whole("t.csv", table, table.replace(b"1.5", b"9.75"))
    assert not any(attack_commands.whole("t.csv", table[:end], table) for end in range(len(table)))
    assert not any(attack_commands.whole("t.json", table[:end], table) for end in range(len(table)))
    page = b"<!DOCTYPE html>\n<p>\n</html>\n"
    assert not any(attack_commands.whole("t.html", page[:end], page) for end in range(len(page)))


@pytest.mark.parametrize("name", ["VQF", "SelfCalKF", "OfflineVQF"])
def test_calls_leave_no_memory(name: str) -> None:
    f = ar.FILTERS[name](rate=100.0)
    gyr, acc = np.zeros((60, 3)), np.tile([0.0, 0.0, 9.81], (60, 1))

    def call() -> None:
        f.run(gyr, acc, threads=2)
        ar.run_many(f, [(gyr, acc)] * 3, threads=2)

    _, _, growth = attack_memory._growth(call, 0.03)
    assert min(growth) <= attack_memory.LIMIT


def test_a_leak_would_be_seen() -> None:
    """What the test above believes."""
    kept: list[bytes] = []
    _, _, growth = attack_memory._growth(lambda: kept.append(bytes(1000)), 0.03)
    assert min(growth) > attack_memory.LIMIT
