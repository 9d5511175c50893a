"""Laws of `ahrs-rs filters` and `ahrs-rs demo`."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs.cli import _filters as filters_module
from commands import EVERY_FILTER, Capture, output_of, without


def test_list_of_filters_has_every_filter_with_its_parameters(capsys: Capture) -> None:
    words = output_of(capsys, "filters").split()
    for name, cls in ar.FILTERS.items():
        assert name in words
        assert all(any(word.startswith(f"{param}=") for word in words) for param in cls.PARAMS)


@EVERY_FILTER
def test_description_of_a_filter_has_all_of_its_metadata(cls: type[ar.Filter], capsys: Capture) -> None:
    shown = output_of(capsys, "filters", cls.NAME.lower())
    text = " ".join(shown.split())
    assert max(map(len, shown.splitlines())) <= 100
    assert " ".join(cls.SOURCE.split()) in text
    for param in cls.PARAMS.values():
        assert " ".join(param.doc.split()) in text
        default = param.default if param.options else f"{param.default:.6g}"
        assert f" {param.name} = {default} {param.unit}".rstrip() in text
        for option in param.options or ():
            assert str(option) in text
    for name in (*cls.PRESETS, *cls.OUTPUTS):
        assert name in text


def test_json_of_the_filters_holds_their_metadata(capsys: Capture) -> None:
    described = json.loads(output_of(capsys, "filters", "--json"))
    assert [one["name"] for one in described] == list(ar.FILTERS)
    for one in described:
        cls = ar.FILTERS[one["name"]]
        assert json.loads(output_of(capsys, "filters", cls.NAME, "--json")) == one
        assert one["presets"] == {name: dict(values) for name, values in cls.PRESETS.items()}
        for entry, param in zip(one["params"], cls.PARAMS.values(), strict=True):
            assert entry["default"] == param.default
            assert (entry["name"], entry["unit"], entry["doc"]) == (param.name, param.unit, param.doc)
            assert entry["range"] == (param.range and list(param.range))
            assert entry["options"] == (param.options and list(param.options))


def test_infinite_bounds_are_null_in_json(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    param = ar.Param("gain", "A gain.", "1/s", 1.0, (0.0, math.inf), None)
    monkeypatch.setattr(filters_module, "FILTERS", {"Gain": type("Gain", (ar.Filter,), _metadata(param))})
    (described,) = json.loads(output_of(capsys, "filters", "--json"))
    assert described["params"][0]["range"] == [0.0, None]
    assert described["streaming"] is False


def _metadata(param: ar.Param) -> dict[str, Any]:
    texts = {"NAME": "Gain", "SOURCE": "none", "EQUIVARIANCE": "exact", "__doc__": "A gain.\n\nMore."}
    flags = {"STREAMING": False, "FEEDBACK": True, "MAGNETOMETER": True}
    return {**texts, **flags, "PARAMS": {param.name: param}, "PRESETS": {}, "OUTPUTS": {}}


def test_demo_writes_recording_orientation_and_plot(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("matplotlib")
    folder = tmp_path / "results"
    shown = output_of(capsys, "demo", "-o", folder, "--duration", "5", "--rate", "50", "--seed", "3")
    assert {path.name for path in folder.iterdir()} == {"recording.npz", "orientation.csv", "errors.png"}
    assert all(f"wrote {path}" in shown for path in folder.iterdir())
    assert all(name in shown for name in ar.FILTERS)
    recording, simulation = ar.read(folder / "recording.npz"), ar.simulate.demo(5.0, 50.0, 3)
    assert np.array_equal(recording.gyr, simulation.gyr)
    best = ar.FILTERS[shown.splitlines()[3].split()[0]](rate=50.0)
    est = best.run(simulation.gyr, simulation.acc, simulation.mag, t=simulation.t)
    with (folder / "orientation.csv").open() as text:
        rows = list(csv.DictReader(text))
    assert np.array_equal([float(row["qw"]) for row in rows], est.quat[:, 0])


def test_demo_can_be_repeated_and_gives_the_same_again(tmp_path: Path, capsys: Capture) -> None:
    orientations = []
    for _ in range(2):
        output_of(capsys, "demo", "-o", tmp_path, "--duration", "3")
        orientations.append((tmp_path / "orientation.csv").read_bytes())
    assert orientations[0] == orientations[1]


def test_demo_without_matplotlib_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    without(monkeypatch, "matplotlib")
    shown = output_of(capsys, "demo", "-o", tmp_path, "--duration", "3")
    assert "errors.png was not drawn: plots need matplotlib: pip install ahrs-rs[plot]" in shown
    assert {path.name for path in tmp_path.iterdir()} == {"recording.npz", "orientation.csv"}
