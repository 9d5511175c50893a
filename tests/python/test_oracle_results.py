"""What is kept of the oracles is found out where it is not what they compute."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import oracle_results
from oracle import OracleResult
from oracle_results import Twin, kept_rows, packed, twins, unpacked
from oracle_sources import HERE, code, imported, modules_hash

SAMPLES = 1234


def result(scale: float = 1.0) -> OracleResult:
    rng = np.random.default_rng(1)
    status = rng.integers(0, 256, SAMPLES).astype(np.uint8)
    # Multiples of 2⁻⁴⁰, which are kept to the bit.
    values = [
        scale * np.rint(2.0**40 * rng.standard_normal((SAMPLES, *shape))) / 2.0**40 for shape in ((4,), (3,), (3, 3))
    ]
    return OracleResult(values[0], values[1], status, {"covariance": values[2]})


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty folder of results, and no commit that asks for one."""
    monkeypatch.setattr(oracle_results, "FOLDER", tmp_path)
    monkeypatch.setattr(oracle_results, "chosen", lambda title: False)
    monkeypatch.setattr(oracle_results, "ALL", False)
    oracle_results.forget()
    yield tmp_path
    oracle_results.forget()


def computed(monkeypatch: pytest.MonkeyPatch, name: str, sources: str, made: OracleResult, **options: bool) -> Twin:
    """As `make oracle` does."""
    with monkeypatch.context() as patch:
        patch.setattr(oracle_results, "ALL", True)
        (twin,) = twins("filter", name, sources, lambda: made, **options)
    return twin


def never() -> OracleResult:
    pytest.fail("the oracle is asked for what is kept")


def test_every_fiftieth_row_and_the_last_of_each_output_are_kept(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    full, short = result(), result(2.0)
    short = OracleResult(short.quat[:1], None, short.status[:1], {})
    whole = computed(monkeypatch, "b", "sources", full)
    assert whole.values["quat"] is full.quat
    computed(monkeypatch, "a", "sources", short)
    computed(monkeypatch, "c", "sources", full, status_only=True)
    (twin,) = twins("filter", "b", "sources", never)
    assert list(kept_rows(SAMPLES)) == [*range(0, SAMPLES, 50), SAMPLES - 1]
    for name, values in (("quat", full.quat), ("gyr_bias", full.gyr_bias), ("covariance", full.extra["covariance"])):
        assert np.array_equal(twin.values[name], values[twin.rows])
    assert set(twin.extra) == {"covariance"}
    (twin,) = twins("filter", "a", "sources", never)
    assert set(twin.values) == {"quat"}
    assert np.array_equal(twin.values["quat"], short.quat)
    (twin,) = twins("filter", "c", "sources", never, status_only=True)
    assert not twin.values
    twin.assert_same_status(full.status)
    assert {file.name for file in folder.iterdir()} == {"filter.npz", "sources.json"}


def test_numbers_are_kept_to_half_of_what_counts_as_rounding_and_of_symmetric_matrices_a_half() -> None:
    rng = np.random.default_rng(3)
    for values in (rng.standard_normal((40, 4)), 1e9 * rng.standard_normal(40), rng.standard_normal((40, 2, 3))):
        values[7] = [np.nan, np.inf, -np.inf, 0.0][values.ndim]
        ((key, kept),) = packed("one", values).items()
        name, read = unpacked(key, kept)
        assert (name, read.shape, kept.size) == ("one", values.shape, 8 * values.size)
        whole = np.isfinite(values)
        assert np.array_equal(read[~whole], values[~whole], equal_nan=True)
        # Half a unit of the last place that is kept, 2⁻⁴⁵, of one or of the power of two above the number.
        assert np.all(np.abs(read[whole] - values[whole]) <= 2.0**-45 * np.maximum(1.0, 2.0 * np.abs(values[whole])))
    square = rng.standard_normal((40, 3, 3))
    ((key, kept),) = packed("two", square + np.swapaxes(square, 1, 2)).items()
    assert kept.size == 8 * 40 * 6
    read = unpacked(key, kept)[1]
    assert np.array_equal(read, np.swapaxes(read, 1, 2))
    assert np.abs(read - square - np.swapaxes(square, 1, 2)).max() < 1e-12
    ((_, kept),) = packed("three", square).items()
    assert kept.size == 8 * 40 * 9


def test_other_sources_are_an_error_until_the_oracle_has_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    computed(monkeypatch, "a", "old", result())
    before = (folder / "filter.npz").read_bytes()
    with pytest.raises(AssertionError, match="filter: a: kept of other sources"):
        next(twins("filter", "a", "new", never))
    # What it computes is the same: the file of numbers stays as it is.
    computed(monkeypatch, "a", "new", result(1.0 + 1e-15))
    assert (folder / "filter.npz").read_bytes() == before
    next(twins("filter", "a", "new", never))
    computed(monkeypatch, "a", "new", result(1.0 + 1e-9))
    assert (folder / "filter.npz").read_bytes() != before


def test_a_chosen_result_is_compared_as_kept_and_in_full(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    computed(monkeypatch, "a", "sources", result())
    monkeypatch.setattr(oracle_results, "chosen", lambda title: True)
    kept, full = twins("filter", "a", "sources", lambda: result(2.0))
    assert np.array_equal(2.0 * kept.values["quat"], full.values["quat"][kept.rows])


def test_a_twentieth_is_chosen_and_another_one_at_another_commit(monkeypatch: pytest.MonkeyPatch) -> None:
    titles = [f"filter: {number}" for number in range(4000)]
    picks = []
    for commit in ("one", "another"):
        monkeypatch.setattr(oracle_results, "commit", lambda commit=commit: commit)
        picks.append({title for title in titles if oracle_results.chosen(title)})
        # 200 are expected; the standard deviation is 14.
        assert 140 < len(picks[-1]) < 260
    assert len(picks[0] & picks[1]) < 40


def test_a_status_that_differs_anywhere_is_named_by_its_row(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = result()
    computed(monkeypatch, "a", "sources", made)
    (twin,) = twins("filter", "a", "sources", lambda: made)
    for dtype in (np.uint8, np.uint16, np.int64):
        twin.assert_same_status(made.status.astype(dtype))
    status = made.status.astype(np.uint16)
    status[777] ^= 256
    with pytest.raises(AssertionError, match="filter: a: status in row 777"):
        twin.assert_same_status(status)
    # Of the bits that count alone.
    computed(monkeypatch, "b", "sources", made)
    with monkeypatch.context() as patch:
        patch.setattr(oracle_results, "ALL", True)
        list(twins("filter", "b", "sources", lambda: made, mask=3))
    (twin,) = twins("filter", "b", "sources", never, mask=3)
    twin.assert_same_status(status)
    (twin,) = twins("filter", "a", "sources", lambda: result(2.0))
    monkeypatch.setattr(oracle_results, "status_hash", lambda status, mask: "another")
    with pytest.raises(AssertionError, match="the oracle gives another status than is kept"):
        twin.assert_same_status(made.status)


def test_sources_are_code_without_comments_and_documentation() -> None:
    plain = "def f(x):\n    return '# no comment' + x\n"
    told = (
        '"""Of f."""\n\n\n# First.\ndef f(x):  # of x\n    """Two\n\n    lines."""\n\n    return \'# no comment\' + x\n'
    )
    assert code(told) == code(plain)
    assert code(plain.replace("+ x", "+ 2 * x")) != code(plain)
    assert code(plain.replace("# no", "# one")) != code(plain), "a string is code"


def test_sources_are_a_module_with_what_it_imports() -> None:
    oracle = HERE / "oracle"
    of_mekf = imported(oracle / "mekf.py")
    assert {oracle / f"{name}.py" for name in ("mekf", "kalman", "so3", "gyro_integration")} <= of_mekf
    assert oracle / "vqf.py" not in of_mekf
    assert modules_hash("oracle/mekf.py") != modules_hash("oracle/vqf.py")
    assert imported(HERE / "selfcal_cases.py") == {HERE / "selfcal_cases.py", HERE / "signals.py"}
