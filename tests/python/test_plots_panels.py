"""What `plot` draws: of recordings, estimates, reports, fits and sweeps, with and without what is optional."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import _display, plots
from commands import simulated, without

pytest.importorskip("matplotlib")

from matplotlib.figure import Figure


def labels(ax: Any) -> list[str]:
    return [str(line.get_label()) for line in ax.get_lines()]


def legend(ax: Any) -> list[str]:
    return [text.get_text() for text in ax.get_legend().get_texts()]


def bands(ax: Any, label: str) -> list[tuple[float, float]]:
    """Begin and end of the bands with a label."""
    found = [one for one in ax.collections if one.get_label() == label]
    return [
        (float(path.vertices[:, 0].min()), float(path.vertices[:, 0].max()))
        for one in found
        for path in one.get_paths()
    ]


@pytest.fixture(scope="module")
def rec() -> ar.Recording:
    return ar.simulate.demo(duration=20.0)


# Estimates.


def test_angles_are_those_of_the_estimate_and_cut_where_they_wrap() -> None:
    t = np.arange(400) / 100.0
    yaw = np.pi * t  # two turns
    quat = np.stack([np.cos(yaw / 2), 0 * t, 0 * t, np.sin(yaw / 2)], axis=1)
    ax = plots.angles(quat, t)
    assert labels(ax) == ["roll", "pitch", "yaw"]
    x, y = ax.get_lines()[2].get_data()
    assert np.count_nonzero(np.isnan(y)) == 2, "one cut a turn, at 180°"
    # No line is drawn between two points that are half a turn apart.
    assert np.nanmax(np.abs(np.diff(y))) < 180.0
    expected = (np.degrees(yaw) + 180.0) % 360.0 - 180.0
    known = ~np.isnan(y)
    # Of degrees by arctan2: roundings of some 1e-14 of 180°; +180 and -180 are one angle.
    difference = (y[known] - expected + 180.0) % 360.0 - 180.0
    assert np.abs(difference).max() < 1e-10
    assert np.array_equal(x[known], t)


def test_the_truth_is_drawn_beside(rec: ar.Recording) -> None:
    est = ar.VQF().run(rec)
    ax = plots.angles(est, ref=rec.ref)
    assert labels(ax)[3:] == ["roll (truth)", "pitch (truth)", "yaw (truth)"]
    expected = ar.metrics.euler(rec.ref, degrees=True)
    y = ax.get_lines()[4].get_ydata()  # pitch does not wrap
    assert np.allclose(y, expected[:, 1], rtol=0, atol=1e-9)
    with pytest.raises(ValueError, match=r"^ref: expected shape \(2000, 4\), got \(5, 4\)"):
        plots.angles(est, ref=rec.ref[:5])


def test_a_gap_of_the_clock_breaks_lines_and_is_shaded(rec: ar.Recording) -> None:
    keep = (rec.t < 5.0) | (rec.t > 8.0)
    cut = ar.Recording(t=rec.t[keep], gyr=rec.gyr[keep], acc=rec.acc[keep])
    est = ar.Madgwick().run(cut)
    for ax in (plots.angles(est), plots.quaternion(est), plots.sensor(cut, "acc")):
        ((begin, end),) = bands(ax, "gap")
        assert (begin, end) == pytest.approx((4.99, 8.01), abs=1e-9)
        for line in ax.get_lines()[:3]:
            x, y = line.get_data()
            inside = (x > 5.0) & (x < 8.0)
            assert np.isnan(y[inside]).all()
            assert inside.sum() == 1


def test_the_bias_has_a_band_of_its_standard_deviation_where_it_is_known(rec: ar.Recording) -> None:
    ax = plots.bias(ar.VQF().run(rec))
    assert labels(ax) == ["x", "y", "z"]
    assert not ax.collections
    est = ar.VQF().run(rec, outputs="bias_sigma")
    ax = plots.bias(est)
    vertices = ax.collections[0].get_paths()[0].vertices
    # The edges of the band at the last sample.
    last = vertices[vertices[:, 0] == est.t[-1]][:, 1]
    middle, sigma = np.degrees([est.gyr_bias[-1, 0], est.extra["bias_sigma"][-1]])
    assert (last.min(), last.max()) == pytest.approx((middle - sigma, middle + sigma), rel=1e-12)
    with pytest.raises(ValueError, match="got gyr_bias None"):
        plots.bias(ar.GyroIntegration().run(rec))


def test_status_has_a_row_for_each_bit_that_is_set(rec: ar.Recording) -> None:
    acc = rec.acc.copy()
    acc[500:700] = np.nan
    est = ar.Madgwick().run(dataclasses.replace(rec, acc=acc))
    ax = plots.status(est)
    rows = [label.get_text() for label in ax.get_yticklabels()]
    union = int(np.bitwise_or.reduce(est.status))
    assert rows == [flag.name for flag in ar.Status if union & flag.value]
    row = rows.index("ACC_MISSING")
    (path,) = ax.collections[row].get_paths()
    assert (path.vertices[:, 0].min(), path.vertices[:, 0].max()) == pytest.approx((5.0, 7.0), abs=1e-9)
    clean = plots.status(ar.GyroIntegration().run(rec.t[:0, None] * np.ones(3), t=rec.t[:0]))
    assert [text.get_text() for text in clean.texts] == ["no flag at any sample"]


@pytest.mark.parametrize("name", [name for name, cls in ar.FILTERS.items() if "nis" in cls.OUTPUTS])
def test_innovations_have_the_gates_of_their_degrees_of_freedom(name: str, rec: ar.Recording) -> None:
    from scipy.stats import chi2

    est = ar.FILTERS[name]().run(rec, outputs="nis")
    columns = est.extra["nis"].reshape(len(est), -1).shape[1]
    ax = plots.innovations(est, confidence=0.95)
    curves = [line for line in ax.get_lines() if len(line.get_xdata()) > 2]
    dashed = [line for line in ax.get_lines() if str(line.get_label()).startswith("χ²")]
    assert len(curves) == len(dashed) == columns
    text = ar.FILTERS[name].OUTPUTS["nis"]
    for line in dashed:
        dof = int(str(line.get_label()).split()[2].rstrip(","))
        assert line.get_ydata()[0] == pytest.approx(chi2.ppf(0.95, dof), rel=1e-9)
        assert (
            str(dof) in text or dof == 1
        )  # as the filter's own words say; those of one angle are squares over variances
    with pytest.raises(ValueError, match=r"confidence: expected a number between 0 and 1, got 1\.5"):
        plots.innovations(est, confidence=1.5)


def test_the_gates_of_the_filters_themselves_are_drawn(rec: ar.Recording) -> None:
    assert "rejected above 4" in labels(plots.innovations(ar.MEKF(mag_gate=2.0).run(rec, outputs="nis")))
    vector = plots.innovations(ar.MEKF(magnetometer="vector").run(rec, outputs="nis"))
    assert "χ² of 3, 99.7 %" in labels(vector)
    f = ar.Fusion(acceleration_rejection=10.0)
    ax = plots.innovations(f.run(rec, outputs=("acceleration_error", "magnetic_error")))
    assert labels(ax) == ["acceleration error", "rejected above 10°", "magnetic error"]
    assert labels(plots.innovations(ar.Mahony().run(rec, outputs="innovation"))) == ["0", "1", "2"]
    with pytest.raises(ValueError, match=r"expected one of the outputs nis, .*, got none"):
        plots.innovations(ar.Mahony().run(rec))


def test_an_estimate_has_the_panels_that_there_is_something_for(rec: ar.Recording) -> None:
    def panels(est: ar.Estimate) -> list[str]:
        return [ax.get_ylabel() for ax in est.plot()]

    bias, nis = "gyroscope's bias [°/s]", "normalised innovation squared"
    assert panels(ar.GyroIntegration().run(rec)) == ["angle [°]"]
    assert panels(ar.MEKF().run(rec, outputs="nis"))[:3] == ["angle [°]", bias, nis]
    axes = Figure().subplots(3)
    est = ar.VQF().run(rec)
    assert list(est.plot(ax=axes)) == list(axes)
    with pytest.raises(ValueError, match="ax: expected 3 axes of matplotlib, got 2 axes"):
        est.plot(ax=axes[:2])
    with pytest.raises(ValueError, match="ax: expected 3 axes of matplotlib, got str"):
        est.plot(ax="top")


def test_one_of_several_recordings_is_asked_for(rec: ar.Recording) -> None:
    both = [np.stack([array, array[::-1]]) for array in (rec.gyr, rec.acc, rec.mag)]
    est = ar.VQF(rate=100.0).run(*both, outputs="bias_sigma")
    with pytest.raises(ValueError, match="recording: expected which of the 2 recordings"):
        est.plot()
    with pytest.raises(ValueError, match="recording: expected a number from 0 to 1, got 2"):
        plots.angles(est, recording=2)
    line = plots.quaternion(est, recording=1).get_lines()[0]
    assert np.array_equal(line.get_ydata(), est.quat[1, :, 0])
    assert len(est.plot(recording=1)) >= 2


@pytest.mark.parametrize("count", [0, 1, 2])
def test_short_estimates_and_recordings_are_drawn(count: int, rec: ar.Recording) -> None:
    short = rec[:count]
    est = ar.MEKF(rate=100.0).run(short, outputs=("nis", "innovation"))
    for ax in (*est.plot(ref=short.ref), plots.quaternion(est), plots.status(est), *short.plot()):
        for line in ax.get_lines():
            if np.count_nonzero(~np.isnan(line.get_ydata())) == 1 and len(line.get_xdata()) == 1:
                assert line.get_marker() == "o", "a line of one point is not seen"
        ax.figure.canvas.draw()
    assert plots.spectrum(short).texts[0].get_text() == "too few readings"


# Recordings.


def test_a_recording_has_an_axes_for_each_sensor_with_its_readings(rec: ar.Recording) -> None:
    axes = rec.plot()
    assert [ax.get_ylabel() for ax in axes] == ["angular rate [rad/s]", "specific force [m/s²]", "magnetic field [µT]"]
    for ax, values in zip(axes, (rec.gyr, rec.acc, rec.mag), strict=True):
        for line, column in zip(ax.get_lines(), values.T, strict=True):
            assert np.array_equal(line.get_ydata(), column)
    (temperature,) = ar.Recording(t=np.arange(3.0), temperature=[20.0, 21.0, 22.0]).plot()
    assert temperature.get_ylabel() == "temperature [°C]"
    with pytest.raises(ValueError, match="recording: expected one of gyr"):
        ar.Recording(t=np.arange(3.0), ref=[[1.0, 0.0, 0.0, 0.0]] * 3).plot()
    with pytest.raises(ValueError, match=r"^mag: expected a magnetometer, the recording has gyr"):
        plots.sensor(ar.Recording(t=np.arange(3.0), gyr=np.zeros((3, 3))), "mag")
    with pytest.raises(ValueError, match="name: expected one of gyr, acc, mag, temperature, got 'ref'"):
        plots.sensor(rec, "ref")


def test_a_sensor_is_drawn_at_its_own_times() -> None:
    rec = simulated()  # its magnetometer has one row in three
    line = plots.sensor(rec, "mag").get_lines()[0]
    assert np.array_equal(line.get_xdata(), rec.streams["mag"].t)
    assert not np.isnan(line.get_ydata()).any()


def test_rests_gaps_and_clipped_readings_are_marked(rec: ar.Recording) -> None:
    t = np.arange(3000) / 100.0
    random = np.random.default_rng(0)
    gyr = 0.001 * random.standard_normal((3000, 3))
    gyr[1000:2000, 1] += 8.0 * np.sin(t[:1000])
    gyr = np.clip(gyr, -4.0, 4.0)
    gyr[2500:2600] = np.nan
    rec = ar.Recording(t=t, gyr=gyr)
    ax = plots.sensor(rec)
    (marked,) = [line for line in ax.get_lines() if line.get_label() == "clipped"]
    assert np.array_equal(marked.get_xdata(), t[np.abs(gyr[:, 1]) == 4.0])
    assert set(marked.get_ydata()) == {-4.0, 4.0}
    assert bands(ax, "gap") == [pytest.approx((25.0, 26.0))]
    expected = ar.calibration.find_rest(rec).seconds
    assert np.allclose(bands(ax, "rest"), expected, rtol=0, atol=1e-12)
    assert set(legend(ax)) == {"x", "y", "z", "clipped", "gap", "rest"}
    assert set(legend(plots.sensor(rec, marks=False))) == {"x", "y", "z"}


def test_a_long_recording_is_thinned_to_what_is_seen() -> None:
    t = np.arange(400_000) / 1000.0
    values = np.sin(t)
    values[123_456] = 50.0
    values[200_000:210_000] = np.nan
    at, shown = _display.thinned(t, values, 5000)
    assert len(at) <= 5000
    assert np.nanmax(shown) == 50.0
    # The gap begins and ends where it did, and nothing else is one.
    missing = at[np.isnan(shown)]
    assert (missing[0], missing[-1]) == (t[200_000], t[209_999])
    assert np.isnan(shown[(at >= t[200_000]) & (at <= t[209_999])]).all()


def test_gaps_are_not_seen_between_packets() -> None:
    t = np.repeat(np.arange(100) * 0.1, 10)
    assert _display.gaps(t).size == 0
    t[500:] += 3.0
    assert _display.gaps(t).tolist() == [499]
    assert _display.gaps(np.zeros(5)).size == 0


def test_the_spectrum_has_the_power_of_the_signal() -> None:
    rate, frequency = 200.0, 25.0
    t = np.arange(20_000) / rate
    acc = np.zeros((len(t), 3))
    acc[:, 0] = 2.0 * np.sin(2 * np.pi * frequency * t)
    acc[:, 1:] = 1e-3 * np.random.default_rng(0).standard_normal((len(t), 2))
    x, y, _ = plots.spectrum(ar.Recording(t=t, acc=acc), "acc").get_lines()
    at, density = x.get_data()
    assert at[np.argmax(density)] == pytest.approx(frequency, abs=rate / 256)
    # The variance of a sine is half of its square; the window keeps it within the leakage beyond the band, 1e-3.
    assert np.sum(density**2) * (at[1] - at[0]) == pytest.approx(2.0, rel=1e-3)
    # White noise of standard deviation s has the one-sided density s √(2/rate); 64 windows, 129 bins: 2 %.
    assert np.median(y.get_ydata()) == pytest.approx(1e-3 * np.sqrt(2.0 / rate), rel=0.05)
    with pytest.raises(ValueError, match="name: expected one of gyr, acc, mag, got 'temperature'"):
        plots.spectrum(ar.Recording(t=t, acc=acc), "temperature")


# Reports.


def test_a_report_draws_its_evidence(rec: ar.Recording) -> None:
    axes = ar.check(rec).plot()
    titles = [ax.get_title() for ax in axes]
    assert titles.count("Norms over half a second each") == 3
    assert "The field in the sensor's axes" in titles
    assert titles[-1].startswith("Spectrum")
    assert [ax.name for ax in axes].count("3d") == 1
    for ax in axes:
        assert ax.get_lines()
    empty = ar.check(rec[:0]).plot()
    assert empty.shape == (0,)
    with pytest.raises(ValueError, match="expected axes with a 3D projection"):
        ar.check(rec).plot(ax=Figure().subplots(len(axes)))


# Errors over many recordings.


def test_boxes_have_the_quartiles_of_the_metrics() -> None:
    errors = {"a": [1.0, 2.0, 3.0, 4.0, 30.0, np.nan], "none": [np.nan]}
    ax = plots.boxes(errors)
    assert [label.get_text() for label in ax.get_xticklabels()] == ["a", "none"]
    box = ar.metrics.box(errors["a"])
    levels = {float(value) for line in ax.get_lines() for value in line.get_ydata() if np.isfinite(value)}
    assert {box.low, box.q1, box.median, box.q3, box.high, 30.0} <= levels
    with pytest.raises(ValueError, match="errors: expected at least one label"):
        plots.boxes({})
    with pytest.raises(ValueError, match=r"a: expected shape \(n,\), got \(1, 2\)"):
        plots.boxes({"a": [[1.0, 2.0]]})


def test_many_recordings_are_a_thin_line_each_with_their_mean_and_spread() -> None:
    times = [np.arange(2500) / 100.0, 5.0 + np.arange(1250) / 100.0, np.array([3.0]), np.zeros(0)]
    errors = {"a": [np.full(len(t), level) for t, level in zip(times, (1.0, 3.0, 7.0, 9.0), strict=True)]}
    ax = plots.error_times(errors, times)
    *thin, mean = ax.get_lines()
    assert len(thin) == 4
    assert legend(ax) == ["a"]
    assert [float(np.nanmean(line.get_ydata())) for line in thin[:3]] == [1.0, 3.0, 7.0]
    assert thin[2].get_marker() == "."
    x, y = mean.get_data()
    # After 12.5 s one of them is left; there is a mean, and no spread.
    assert np.allclose(y[(x > 1.0) & (x < 12.4)], 2.0)
    assert np.allclose(y[x > 12.6], 1.0)
    vertices = ax.collections[0].get_paths()[0].vertices
    inside = vertices[(vertices[:, 0] > 1.0) & (vertices[:, 0] < 12.0)][:, 1]
    assert (inside.min(), inside.max()) == pytest.approx((2.0 - np.sqrt(2.0), 2.0 + np.sqrt(2.0)))
    with pytest.raises(ValueError, match="errors: expected 4 recordings of a, got 1"):
        plots.error_times({"a": [np.zeros(3)]}, times)
    with pytest.raises(ValueError, match=r"expected shape \(2500,\) of a, recording 0, got \(3,\)"):
        plots.error_times({"a": [np.zeros(3)] * 4}, times)


# Calibrations.


def test_a_fit_is_drawn_over_its_sphere() -> None:
    x = np.random.default_rng(0).standard_normal((500, 3))
    x = 48.0 * x / np.linalg.norm(x, axis=1, keepdims=True) + [12.0, -3.0, 5.0]
    x[10] = np.nan
    fit = ar.calibration.magnetometer(x)
    grid = fit.plot(x)
    assert grid.shape == (2, 4)
    assert len(grid[0, 0].get_lines()[0].get_xdata()) == 499
    assert grid[1, 0].patches[0].radius == fit.norm
    # The readings lie on the sphere to the digits of the fit.
    assert np.allclose(grid[1, 3].get_lines()[0].get_ydata(), fit.norm, rtol=1e-6)
    with pytest.raises(ValueError, match="ax: expected 8 axes"):
        fit.plot(x, ax=Figure().subplots(2, 2))
    with pytest.raises(ValueError, match=r"readings: expected shape \(T, 3\), got \(5,\)"):
        fit.plot(np.zeros(5))


def test_positions_and_turns_are_drawn() -> None:
    held = [np.tile(sign * 9.9 * np.eye(3)[axis] + 0.1, (5, 1)) for axis in range(3) for sign in (1, -1)]
    before, after, gravity = ar.calibration.six_positions(held).plot(held).get_lines()
    assert np.allclose(before.get_ydata(), [np.linalg.norm(one[0]) for one in held])
    assert np.allclose(after.get_ydata(), 9.80665)
    assert gravity.get_ydata()[0] == 9.80665
    fit = ar.calibration.gyroscope(np.full((500, 3), 0.01))
    assert fit.plot().texts[0].get_text() == "no turns: bias alone"
    residual = dataclasses.replace(fit, residual=np.radians([[1.0, 2.0, 3.0], [-4.0, 5.0, 6.0]]))
    heights = sorted(patch.get_height() for patch in residual.plot().patches)
    assert np.allclose(heights, [-4.0, 1.0, 2.0, 3.0, 5.0, 6.0])


def test_allan_deviations_have_their_confidence_and_model() -> None:
    x = np.random.default_rng(0).standard_normal(5000)
    found = ar.calibration.allan(x, 100.0)
    ax = found.plot()
    curve, model = ax.get_lines()
    assert np.array_equal(curve.get_ydata(), found.deviation)
    assert np.array_equal(model.get_ydata(), found.model(found.tau[found.tau >= found.fitted_from]))
    assert (ax.get_xscale(), ax.get_yscale(), len(ax.collections)) == ("log", "log", 1)
    assert len(found.plot(model=False).get_lines()) == 1
    assert legend(plots.allan({"first": found, "second": found})) == ["first", "second"]


# Sweeps.


def found_by(params: list[dict[str, Any]], errors: Any) -> ar.Sweep:
    errors = np.asarray(errors, dtype=np.float64)
    return ar.Sweep("Madgwick", params, "total", errors, ~np.isnan(errors))


def test_one_parameter_has_a_line_for_each_recording_and_the_mean() -> None:
    found = found_by([{"beta": 10.0**k} for k in (-1, 0, 1)], [[3.0, 5.0], [1.0, 2.0], [8.0, np.nan]])
    ax = found.plot()
    one, two, mean, best = ax.get_lines()
    assert np.array_equal(one.get_ydata(), [3.0, 1.0, 8.0])
    assert np.array_equal(two.get_ydata(), [5.0, 2.0, np.nan], equal_nan=True)
    assert np.array_equal(mean.get_ydata(), [4.0, 1.5, np.nan], equal_nan=True), "the last set is not done"
    assert (best.get_xdata()[0], best.get_ydata()[0]) == (1.0, 1.5)
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_xscale()) == ("beta", "total error [°]", "log")


def test_two_parameters_are_a_map_with_the_best_of_the_others() -> None:
    params = [{"a": a, "b": b, "c": c} for a in (1.0, 2.0) for b in ("x", "y") for c in (0, 1)]
    found = found_by(params, [[float(k)] for k in (9, 1, 8, 2, 7, 3, 6, 4)])
    ax = found.plot(["a", "b"])
    assert ax.collections[0].get_array().reshape(2, 2).tolist() == [[1.0, 3.0], [2.0, 4.0]]
    assert [label.get_text() for label in ax.get_yticklabels()] == ["x", "y"]
    star = ax.get_lines()[0]
    assert (star.get_xdata()[0], star.get_ydata()[0]) == (1.0, 0.0)
    assert found.plot("b").get_xlabel() == "b"
    for wrong in ("d", ["a", "b", "c"], []):
        with pytest.raises(ValueError, match="params: expected one or two of a, b, c"):
            found.plot(wrong)


def test_a_sweep_of_which_nothing_is_done_is_drawn_empty() -> None:
    found = found_by([{"beta": 0.1}, {"beta": 0.2}], np.full((2, 3), np.nan))
    assert np.isnan(found.plot().get_lines()[-1].get_ydata()).all()
    assert "best" not in found._repr_html_()


# What is missing is told.


def test_without_matplotlib_plots_say_what_to_install(rec: ar.Recording, monkeypatch: pytest.MonkeyPatch) -> None:
    est = ar.VQF().run(rec)
    without(monkeypatch, "matplotlib")
    for draw in (est.plot, rec.plot, ar.check(rec).plot):
        with pytest.raises(ImportError, match=r"plots need matplotlib: pip install ahrs-rs\[plot\]"):
            draw()
