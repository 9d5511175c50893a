"""Checkpoints: nothing of what they hold is computed again, and nothing of it is lost, whatever ends the process."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import _cells
from ahrs_rs._cells import Cells
from signals import RATE, motion

LENGTHS = (500, 40, 300)
BETAS = np.geomspace(0.01, 1.0, 50)


def recordings() -> list[ar.Recording]:
    made = []
    for seed, samples in enumerate(LENGTHS):
        signals = motion(samples, seed)
        gyr, acc, mag = signals.sensors()
        made.append(ar.Recording(t=signals.t, gyr=gyr, acc=acc, mag=mag, ref=signals.truth, rate=RATE))
    # One whose error is none: NaN is a result, and not the same as one that is not known.
    return [*made, dataclasses.replace(made[1], mask=np.zeros(len(made[1]), dtype=bool))]


def total(est: ar.Estimate, one: ar.Recording) -> float:
    assert one.ref is not None
    return float(ar.metrics.score(est.quat, one.ref, one.mask).total)


def swept(checkpoint: Path | None, **changes: Any) -> ar.Sweep:
    keywords: dict[str, Any] = {"metric": "total", **changes}
    return ar.sweep(
        ar.Madgwick, {"beta": BETAS, "gradient": ["tangent", "paper"]}, recordings(), checkpoint=checkpoint, **keywords
    )


def same(one: ar.Sweep, other: ar.Sweep) -> bool:
    return one.params == other.params and one.errors.tobytes() == other.errors.tobytes() and bool(one.done.all())


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many errors each portion has."""
    found: list[int] = []

    def count_calls_of(name: str) -> None:
        compute = getattr(Cells, name)

        def counting(self: Cells, sets: list[int], which: list[int], count: Any) -> None:
            found.append(len(sets) * len(which))
            compute(self, sets, which, count)

        monkeypatch.setattr(Cells, name, counting)

    count_calls_of("_side_by_side")
    count_calls_of("_one_by_one")
    return found


@pytest.mark.parametrize("metric", ["total", "heading", total])
def test_a_sweep_with_a_checkpoint_gives_the_same_bits_and_is_not_computed_twice(
    metric: Any, tmp_path: Path, computed: list[int]
) -> None:
    whole = swept(None, metric=metric)
    assert computed == [400]
    computed.clear()
    assert same(swept(tmp_path / "part.jsonl", metric=metric), whole)
    assert sum(computed) == 400
    computed.clear()
    assert same(swept(tmp_path / "part.jsonl", metric=metric), whole)
    assert not computed


def test_offline_filters_have_checkpoints_too(tmp_path: Path, computed: list[int]) -> None:
    arguments = (ar.OfflineVQF, {"tau_acc": [1.0, 3.0]}, recordings()[:3])
    whole = ar.sweep(*arguments)
    computed.clear()
    assert same(ar.sweep(*arguments, checkpoint=tmp_path / "part.jsonl"), whole)
    assert same(ar.sweep(*arguments, checkpoint=tmp_path / "part.jsonl"), whole)
    assert sum(computed) == 6


def slow(monkeypatch: pytest.MonkeyPatch, seconds: float) -> None:
    """As if every portion took so long."""
    ticks: Iterator[float] = iter(np.arange(100_000) * seconds)
    monkeypatch.setattr(_cells.time, "monotonic", lambda: next(ticks))


def test_where_work_is_slow_a_portion_is_one_register_of_sets_over_one_recording(
    tmp_path: Path, computed: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = swept(None)
    computed.clear()
    monkeypatch.setattr(_cells, "FIRST", 1.0)
    slow(monkeypatch, 1e6)
    assert same(swept(tmp_path / "part.jsonl"), whole)
    assert max(computed) == _cells.LANES
    computed.clear()
    one_by_one = swept(None, metric=total)
    computed.clear()
    assert same(swept(tmp_path / "function.jsonl", metric=total), one_by_one)
    assert set(computed) == {1}


def test_portions_grow_where_work_is_fast(tmp_path: Path, computed: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    whole = swept(None)
    computed.clear()
    monkeypatch.setattr(_cells, "FIRST", 1000.0)
    slow(monkeypatch, 1e-3)
    assert same(swept(tmp_path / "part.jsonl"), whole)
    assert computed[0] <= _cells.LANES
    assert computed[-1] > 4 * computed[0]


def test_what_is_computed_stands_in_the_file_after_each_portion(
    tmp_path: Path, computed: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "part.jsonl"
    monkeypatch.setattr(_cells, "FIRST", 1.0)
    slow(monkeypatch, 1e6)
    known: list[int] = []
    compute = Cells._side_by_side

    def looking(self: Cells, *args: Any) -> None:
        lines = [json.loads(line) for line in path.read_text().splitlines()[1:]]
        known.append(sum(error is not None for _, errors in lines for error in errors))
        compute(self, *args)

    monkeypatch.setattr(Cells, "_side_by_side", looking)
    swept(path)
    assert known == np.cumsum([0, *computed[:-1]]).tolist()


def test_a_file_cut_off_at_any_byte_is_gone_on_from(tmp_path: Path) -> None:
    path = tmp_path / "part.jsonl"
    arguments = (ar.Madgwick, {"beta": [0.1, 0.2, 0.3]}, recordings())
    whole = ar.sweep(*arguments, checkpoint=path)
    content = path.read_bytes()
    for end in range(len(content)):
        path.write_bytes(content[:end])
        assert same(ar.sweep(*arguments, checkpoint=path), whole)
        assert same(ar.sweep(*arguments, checkpoint=path), whole)


@pytest.mark.parametrize("torn", [b"\0" * 4096, b"\xff\xfe", b"[" * 100_000, b"1" * 10_000, b'["0", [1.0'], ids=len)
def test_lines_that_were_torn_are_left_out(torn: bytes, tmp_path: Path) -> None:
    path = tmp_path / "part.jsonl"
    whole = swept(path)
    head, *lines = path.read_bytes().splitlines()
    path.write_bytes(b"\n".join([head, torn, *lines[5:], torn]))
    assert same(swept(path), whole)


@pytest.mark.parametrize(
    "line",
    [
        "[]", "{}", "3", '"x"', "null", '["0"]', '["0", 1.0]', '["0", [1.0]]', '["0", [1.0, 2.0, 3.0, "4.0"]]',
        '["0", [1.0, 2.0, 3.0, [4.0]]]', '["0", [1.0, 2.0, 3.0, 12345]]', "[0, [1.0, 2.0, 3.0, 4.0]]",
        '["0", [1.0, 2.0, 3.0, true]]',
    ],
)  # fmt: skip
def test_lines_that_are_none_of_a_checkpoint_are_a_value_error_that_names_file_and_line(
    line: str, tmp_path: Path
) -> None:
    path = tmp_path / "part.jsonl"
    swept(path)
    content = path.read_text() + line + "\n"
    path.write_text(content)
    with pytest.raises(
        ValueError, match=rf"checkpoint: .*part\.jsonl: expected a set and 4 errors in line {content.count(chr(10))}$"
    ):
        swept(path)
    assert path.read_text() == content


@pytest.mark.parametrize(
    "changes",
    [{"metric": "heading"}, {"metric": total}, {"dtype": np.float32}, {"frame": "NED"}, {"declination": 0.1}],
    ids=["metric", "function", "dtype", "frame", "declination"],
)
def test_a_checkpoint_of_another_sweep_is_refused_and_kept(changes: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "part.jsonl"
    swept(path)
    content = path.read_bytes()
    with pytest.raises(ValueError, match="is of another search"):
        swept(path, **changes)
    with pytest.raises(ValueError, match="is of another search"):
        ar.sweep(ar.Madgwick, {"beta": BETAS}, recordings(), checkpoint=path)
    with pytest.raises(ValueError, match="is of another search"):
        ar.sweep(ar.Madgwick, {"beta": BETAS, "gradient": ["tangent", "paper"]}, recordings()[::-1], checkpoint=path)
    assert path.read_bytes() == content


@pytest.mark.parametrize("content", [b"", b"important notes", b"important\nnotes\n", b"{}\n"])
def test_no_other_file_is_written_over(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_bytes(content)
    if content:
        with pytest.raises(ValueError, match="is of another search"):
            swept(path)
        assert path.read_bytes() == content
    else:
        assert swept(path).done.all()


#: A sweep of some seconds that says when it begins.
SWEEP = """
import sys
import numpy as np
import ahrs_rs as ar
sys.path.insert(0, sys.argv[2])
from test_checkpoint import long_sweep
print(flush=True)
long_sweep(sys.argv[1])
"""


def long_sweep(checkpoint: str | Path | None) -> ar.Sweep:
    signals = motion(20_000, 1)
    gyr, acc, mag = signals.sensors()
    one = ar.Recording(t=signals.t, gyr=gyr, acc=acc, mag=mag, ref=signals.truth, rate=RATE)
    grid = {"beta": np.geomspace(0.01, 1.0, 600)}
    return ar.sweep(ar.Madgwick, grid, [one, one], threads=1, checkpoint=checkpoint)


def test_a_sweep_that_was_killed_goes_on_to_the_same_bits(tmp_path: Path) -> None:
    path = tmp_path / "part.jsonl"
    for _ in range(3):
        size = path.stat().st_size if path.exists() else 0
        command = [sys.executable, "-c", SWEEP, str(path), str(Path(__file__).parent)]
        with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
            while process.poll() is None and not (path.exists() and path.stat().st_size > max(size, 1000)):
                time.sleep(0.001)
            process.kill()
    kept = path.read_text().count("\n") - 1
    assert kept > 0
    assert same(long_sweep(path), long_sweep(None))
