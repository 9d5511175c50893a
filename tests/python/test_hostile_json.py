"""Files of JSON that somebody else wrote, or that were damaged: a `ValueError` of one line, whatever they hold."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import _json, calibration, tuning
from commands import Capture, error_of, saved

DEEP = "[" * 100_000
DIGITS = "9" * 10_000
#: What stands in place of a value.
VALUES: list[Any] = [
    None,
    True,
    -1,
    3,
    10**400,
    1.5,
    "x",
    "1.0",
    "",
    [],
    [1.0],
    [[]],
    {},
    {"a": 1},
    [[1.0] * 3] * 3,
    [None] * 3,
    [["1"] * 3] * 3,
]
TEXTS = ["", "{", "[]", "null", "3", '"x"', DEEP, DIGITS, '{"a": ' * 50_000, "\ufeff{}", "{}", '{"format": 3}']


def cal() -> dict[str, Any]:
    """A calibration file with both kinds of calibrations."""
    return {
        "format": "ahrs_rs.calibration",
        "version": 1,
        "model": "y = S (x - b)",
        "acc": {"matrix": np.eye(3).tolist(), "offset": [0.1, 0.2, 0.3], "unit": "m/s²", "info": {"method": "six"}},
        "mag": {
            "gain_slope": [0.0] * 3, "gain_at_zero": [1.0] * 3, "bias_slope": [0.0] * 3, "bias_at_zero": [1.0] * 3,
            "range": [0.0, 30.0], "covariance": np.eye(12).tolist(), "unit": "µT", "info": {},
        },
    }  # fmt: skip


def tuned() -> dict[str, Any]:
    """A file of tuned parameters."""
    scores = {"recordings": [0, 1], "errors": [1.0, 2.0], "defaults": [2.0, 3.0], "mean": 1.5, "default_mean": 2.5}
    return {
        "format": "ahrs_rs.tuned", "version": 1, "filter": "Madgwick", "params": {"beta": 0.1}, "metric": "total",
        "method": "grid", "seed": 0, "evaluated": 3, "train": scores, "test": scores, "history": [1.5],
    }  # fmt: skip


def state() -> dict[str, Any]:
    content: dict[str, Any] = json.loads(ar.Mahony(rate=100.0).state().to_json())
    return content


LOADERS: dict[str, tuple[Callable[[Path], Any], Callable[[], dict[str, Any]]]] = {
    "cal": (calibration.load, cal),
    "tuned": (tuning.Tuned.load, tuned),
    "state": (lambda path: ar.State.from_json(path.read_bytes()), state),
}
EVERY_LOADER = pytest.mark.parametrize(("load", "valid"), LOADERS.values(), ids=LOADERS)


def changes(content: Any) -> Iterator[Any]:
    """The content with every one of its values replaced by each of `VALUES`, or left out, one at a time."""
    if isinstance(content, dict):
        for key in content:
            yield {other: value for other, value in content.items() if other != key}
            for value in VALUES:
                yield content | {key: value}
            for value in changes(content[key]):
                yield content | {key: value}
        yield content | {"unknown": 1}


@EVERY_LOADER
def test_a_file_is_read(load: Callable[[Path], Any], valid: Callable[[], dict[str, Any]], tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(json.dumps(valid()))
    load(tmp_path / "a.json")


@EVERY_LOADER
@pytest.mark.parametrize("text", TEXTS, ids=range(len(TEXTS)))
def test_text_that_is_none_is_a_value_error(
    load: Callable[[Path], Any], valid: object, text: str, tmp_path: Path
) -> None:
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(ValueError, match=r"^[^\n]+$"):
        load(tmp_path / "a.json")


@EVERY_LOADER
def test_bytes_that_are_no_text_are_a_value_error(load: Callable[[Path], Any], valid: object, tmp_path: Path) -> None:
    for content in (b"\xff\xfe\x00", b"{\xff}", b"\0" * 100):
        (tmp_path / "a.json").write_bytes(content)
        with pytest.raises(ValueError, match=r"^[^\n]+$"):
            load(tmp_path / "a.json")


@EVERY_LOADER
def test_whatever_value_is_replaced_the_file_is_read_or_a_value_error(
    load: Callable[[Path], Any], valid: Callable[[], dict[str, Any]], tmp_path: Path
) -> None:
    refused = []
    path = tmp_path / "a.json"
    for content in changes(valid()):
        path.write_text(json.dumps(content))
        try:
            load(path)
        except ValueError as error:
            refused.append(str(error))
    assert len(refused) > 100
    assert all(message and "\n" not in message and len(message) < 600 for message in refused)


@EVERY_LOADER
def test_a_file_cut_off_or_with_a_byte_changed_is_read_or_a_value_error(
    load: Callable[[Path], Any], valid: Callable[[], dict[str, Any]], tmp_path: Path
) -> None:
    path = tmp_path / "a.json"
    content = json.dumps(valid()).encode()
    rng = np.random.default_rng(0)
    refused = []
    for index in rng.integers(0, len(content), 300):
        for damaged in (content[:index], content[:index] + bytes([rng.integers(256)]) + content[index + 1 :]):
            path.write_bytes(damaged)
            try:
                load(path)
            except ValueError as error:
                refused.append(str(error))
    assert len(refused) > 300
    assert not any("\n" in message for message in refused)


def test_a_file_of_any_length_is_not_read_as_a_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_json, "MOST_BYTES", 2**20)
    (tmp_path / "a.json").write_text(" " * 2**20 + "{}")
    with pytest.raises(ValueError, match="longer than 1 MiB"):
        calibration.load(tmp_path / "a.json")


@pytest.mark.parametrize(
    ("unit", "honoured"), [("m/s²", True), ("g", False), ("µT", False), ("", False), (None, False)]
)
def test_a_unit_is_honoured_or_refused(unit: str | None, honoured: bool, tmp_path: Path, capsys: Capture) -> None:
    content = cal()
    content["acc"]["unit"] = unit
    path = tmp_path / "cal.json"
    path.write_text(json.dumps(content))
    if honoured:
        assert dict(calibration.load(path))["acc"] == calibration.Calibration(np.eye(3), [0.1, 0.2, 0.3])
        return
    with pytest.raises(
        ValueError, match=r"cal\.json: acc: unit: expected m/s², which readings and offsets are in, got"
    ):
        calibration.load(path)
    walk = saved(tmp_path / "walk.npz")
    told = error_of(capsys, "run", walk, "--filter", "tilt", "--calibration", path)
    assert "acc: unit: expected m/s²" in told


def test_either_letter_of_micro_is_the_unit_of_a_magnetometer(tmp_path: Path) -> None:
    content = cal()
    content["mag"]["unit"] = "\u03bcT"
    (tmp_path / "cal.json").write_text(json.dumps(content))
    assert "mag" in dict(calibration.load(tmp_path / "cal.json"))


def test_another_model_is_refused(tmp_path: Path) -> None:
    (tmp_path / "cal.json").write_text(json.dumps(cal() | {"model": "y = S x - b"}))
    with pytest.raises(ValueError, match=r"model: expected 'y = S \(x - b\)', got 'y = S x - b'"):
        calibration.load(tmp_path / "cal.json")
