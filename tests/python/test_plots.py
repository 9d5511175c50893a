"""Laws of the plots."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import plots
from commands import Capture, output_of, saved, simulated


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return saved(tmp_path / "walk.npz")


@pytest.mark.parametrize(("ending", "start"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_plot_is_drawn_in_the_format_of_its_ending(
    ending: str, start: bytes, file: Path, tmp_path: Path, capsys: Capture
) -> None:
    pytest.importorskip("matplotlib")
    plot = tmp_path / f"errors.{ending}"
    assert f"wrote {plot}" in output_of(capsys, "compare", file, "--plot", plot)
    assert plot.read_bytes().startswith(start)


def test_plot_of_many_files_has_a_line_and_a_value_of_each(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib")
    files = [saved(tmp_path / f"{seed}.npz", seed) for seed in range(5)]
    drawn = []
    monkeypatch.setattr(plots, "save", lambda figure, path: (drawn.append(figure), path.write_bytes(b"")))
    output_of(capsys, "compare", *files, "--filters", "tilt,vqf", "--plot", tmp_path / "e.png")
    ((total, boxes), *_) = np.reshape(drawn[0].axes, (3, 2))
    assert len(total.get_lines()) == 2 * (5 + 1)
    assert [text.get_text() for text in total.get_legend().get_texts()] == ["VQF", "Tilt"]
    assert [label.get_text() for label in drawn[0].axes[5].get_xticklabels()] == ["VQF", "Tilt"]
    assert boxes.get_ylabel() == "total RMSE [°]"


def test_a_finished_panel_holds_no_reference() -> None:
    recording = simulated()
    panel = plots.ErrorPanel(recording, "")
    panel.finish()
    with pytest.raises(ValueError, match="as the panel is finished"):
        panel.add("a", recording.ref)
    panel.add("a", recording.ref, recording.ref)
    assert list(panel.curves) == ["a"]


def test_figure_has_an_axis_for_every_error_and_a_curve_for_every_estimate() -> None:
    pytest.importorskip("matplotlib")
    recording = simulated()
    assert recording.ref is not None
    quats = {f"estimate {i}": np.roll(recording.ref, i, axis=0) for i in range(31)}
    figure = plots.errors(recording, quats, "many")
    assert [axes.get_ylabel() for axes in figure.axes] == [f"{name} error [°]" for name in plots.ERRORS]
    assert figure.axes[-1].get_xlabel().startswith("time [s]")
    for axes in figure.axes:
        assert [line.get_label() for line in axes.get_lines()] == list(quats)
        assert len({(str(line.get_color()), str(line.get_linestyle())) for line in axes.get_lines()[:20]}) == 20
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [*quats, "not scored"]


def test_thinned_errors_keep_the_mean_square() -> None:
    recording = ar.simulate.demo(duration=40.0, rate=100.0)
    assert recording.ref is not None
    random = np.random.default_rng(0)
    quat = recording.ref + 0.1 * random.standard_normal(recording.ref.shape)
    quat /= np.linalg.norm(quat, axis=1, keepdims=True)
    panel = plots.ErrorPanel(recording, "")
    panel.add("noisy", quat)
    assert len(recording) % plots.POINTS == 0, "all points stand for equally many samples"
    for name, error in plots.ERRORS.items():
        # Sums of 4000 doubles in another order: roundings of 2e-16, of which fewer than 4000 add up.
        expected = ar.metrics.rmse(error(quat, recording.ref, degrees=True))
        assert ar.metrics.rmse(panel.curves["noisy"][name]) == pytest.approx(expected, rel=1e-12)


def test_short_recordings_are_drawn_sample_by_sample_with_gaps_where_truth_lacks() -> None:
    recording = simulated()[:100]
    assert recording.ref is not None
    ref = recording.ref.copy()
    ref[10:20] = np.nan
    panel = plots.ErrorPanel(dataclasses.replace(recording, ref=ref), "")
    panel.add("still", recording.ref)
    assert np.array_equal(panel.t, recording.t)
    for curve in panel.curves["still"].values():
        assert np.array_equal(np.flatnonzero(np.isnan(curve)), np.arange(10, 20))


def test_figures_without_anything_to_draw_are_refused() -> None:
    recording = simulated()
    with pytest.raises(ValueError, match="got ref None"):
        plots.errors(dataclasses.replace(recording, ref=None), {})
    with pytest.raises(ValueError, match="at least one sample"):
        plots.ErrorPanel(recording[:0], "")
    with pytest.raises(ValueError, match="got 1 panels and 0 labels"):
        plots.errors(recording, {})
