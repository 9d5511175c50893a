"""Damaged files: an error of one line with the path, or what is left of them (`make damage` tries a thousand times)."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

import ahrs_rs as ar
from ahrs_rs import io
from devices.damage import damaged_copy
from devices.samples import SAMPLES
from reading import needs

#: Trials of each format; fewer where each starts a process.
TRIALS, CHILD_TRIALS = 15, 3
CASES = [
    pytest.param(
        name, make, CHILD_TRIALS if package in ("ezc3d", "telemetry_parser") else TRIALS, id=name, marks=needs(package)
    )
    for name, (_, package, make) in SAMPLES.items()
]
PAGE = Path(__file__).resolve().parents[2] / "docs" / "formats.md"


@pytest.mark.parametrize(("name", "make", "trials"), CASES)
def test_damage_gives_an_error_of_one_line_or_what_is_left(tmp_path: Path, name: str, make, trials: int) -> None:
    (tmp_path / "valid").mkdir()
    (tmp_path / "copy").mkdir()
    sample = make(tmp_path / "valid", 200)
    refused: list[str] = []
    complaints: list[str] = []
    for seed in range(trials):
        path, what = damaged_copy(sample, tmp_path / "copy", seed)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                found = ar.read_all(path)
                assert found, what
            except ValueError as error:
                refused.append(str(error))
                wrong = str(path) not in refused[-1] or "\n" in refused[-1] or len(refused[-1]) > 1000
                complaints += [f"{what}: {error}"] if wrong else []
        assert all(one.category is ar.DataWarning for one in caught), what
    assert not complaints
    assert len(refused) < trials, "damage that leaves nothing tells nothing of what is left"


def test_the_page_of_formats_has_a_row_for_each() -> None:
    page = PAGE.read_text(encoding="utf-8")
    devices = {kind for kind, _, _ in SAMPLES.values()}
    missing = [name for name in SAMPLES if f"| {name} |" not in page]
    missing += [one.title for key, one in io.formats().items() if key not in devices and f"| {one.title} |" not in page]
    assert not missing, "make formats"


@pytest.mark.parametrize(("name", "make", "trials"), CASES)
def test_a_sample_is_of_its_format_and_of_no_other(tmp_path: Path, name: str, make, trials: int) -> None:
    from ahrs_rs.io._source import Source

    kind = SAMPLES[name][0]
    source = Source.of(make(tmp_path, 200))
    others = {"apdm": {"broad"}, "telemachus": {"parquet"}}.get(kind, set()) | {"csv", "repoimu"}
    assert {key for key, one in io.formats().items() if one.sniff(source)} - others == {kind}
