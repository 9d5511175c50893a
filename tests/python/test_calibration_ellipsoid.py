"""Ellipsoid calibration: known errors are recovered, as closely as it says, and what cannot be known is refused."""

from __future__ import annotations

import re
import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares
from scipy.stats import binom, chi2

from ahrs_rs.calibration import (
    GRAVITY,
    CalibrationError,
    CalibrationWarning,
    EllipsoidFit,
    _linear,
    accelerometer,
    ellipsoid,
    magnetometer,
)
from calibrated import FloatArray, directions, sensor, symmetric, vector_of

BOTH = pytest.mark.parametrize("parameters", [6, 9])
SEEDS = range(200)


def rotation(random: np.random.Generator) -> FloatArray:
    q, r = np.linalg.qr(random.standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


# Known errors.


@BOTH
def test_readings_without_noise_give_the_errors_exactly(parameters: int) -> None:
    for seed in range(10):
        x, s, b = sensor(seed, parameters, noise=0.0)
        fit = ellipsoid(x, parameters=parameters, norm=48.0)
        # Rounding of readings of 100 µT, times a condition below 100.
        assert np.allclose(fit.values, vector_of(s, b, parameters), rtol=0, atol=1e-11)
        assert fit.outliers == 0
        # The mean radius is what det S = 1 leaves.
        free = ellipsoid(x, parameters=parameters)
        scale = np.linalg.det(s) ** (1 / 3)
        assert np.allclose(free.calibration.matrix, s / scale, rtol=0, atol=1e-12)
        assert free.norm == pytest.approx(48.0 / scale, rel=1e-12)


@pytest.fixture(scope="module")
def normal_errors() -> dict[int, tuple[FloatArray, FloatArray]]:
    """For 6 and 9 parameters: errors over their reported deviations (200, p), and their squared lengths."""
    found = {}
    for parameters in (6, 9):
        errors, lengths = [], []
        for seed in SEEDS:
            x, s, b = sensor(seed, parameters)
            fit = ellipsoid(x, parameters=parameters, norm=48.0)
            difference = fit.values - vector_of(s, b, parameters)
            errors.append(difference / fit.std)
            lengths.append(difference @ np.linalg.solve(fit.covariance, difference))
        found[parameters] = (np.array(errors), np.array(lengths))
    return found


@BOTH
def test_known_errors_are_within_the_reported_bounds_in_95_percent_of_200_seeds(
    parameters: int, normal_errors: dict[int, tuple[FloatArray, FloatArray]]
) -> None:
    errors, lengths = normal_errors[parameters]
    # Of 200 seeds binomial(200, 0.95) are within: 181 to 198 but once in a thousand on each side. The covariance is
    # itself estimated, from 400 readings, so a Wald test is right to 1/400 · p² ≈ 10 % of the 5 %.
    low, high = binom.ppf([0.001, 0.999], len(SEEDS), 0.95)
    within = np.count_nonzero(np.abs(errors) < 1.96, axis=0)
    joint = np.count_nonzero(lengths < chi2.ppf(0.95, parameters))
    print(f"{parameters} parameters: each within {within.min()} to {within.max()} of 200, jointly {joint}")
    assert low - 4 <= within.min()
    assert within.max() <= high + 1
    assert low - 4 <= joint <= high + 1


@BOTH
def test_errors_have_no_bias_and_the_reported_spread(
    parameters: int, normal_errors: dict[int, tuple[FloatArray, FloatArray]]
) -> None:
    errors, _ = normal_errors[parameters]
    # Mean of 200 of variance 1: 0.071; spread: 0.05. Four deviations, for 15 numbers each.
    assert np.abs(errors.mean(axis=0)).max() < 4 * 0.071
    assert np.abs(errors.std(axis=0) - 1.0).max() < 4 * 0.05


@BOTH
def test_an_estimated_norm_has_its_reported_deviation(parameters: int) -> None:
    errors = []
    for seed in range(60):
        x, s, _ = sensor(seed, parameters)
        fit = ellipsoid(x, parameters=parameters)
        errors.append((fit.norm - 48.0 / np.linalg.det(s) ** (1 / 3)) / fit.norm_std)
    # Of 60: mean 0.13, spread 0.09; four deviations.
    assert abs(np.mean(errors)) < 0.52
    assert np.std(errors) == pytest.approx(1.0, abs=0.37)


def test_noise_across_the_radius_does_not_shrink_the_sphere() -> None:
    # Noise of 5 % makes readings 0.25 % longer in the mean; 20,000 of them tell 0.05 % (1.4 σ/√n) from that.
    x, s, _ = sensor(1, 6, count=20_000, noise=2.4)
    fit = ellipsoid(x, parameters=6)
    assert fit.norm == pytest.approx(48.0 / np.linalg.det(s) ** (1 / 3), rel=1e-3)


def test_the_uncertainty_grows_with_the_correlation_of_the_noise() -> None:
    random = np.random.default_rng(2)
    x, _, b = sensor(2, 9, count=5000, noise=0.0)
    # A field whose strength varies, each time or as a moving average over 20 readings.
    steps = 0.01 * random.standard_normal(5019)
    noise = np.convolve(steps, np.full(20, 20**-0.5), "valid")[:, None]
    white, coloured = ellipsoid(b + (x - b) * (1 + steps[:5000, None])), ellipsoid(b + (x - b) * (1 + noise))
    assert white.correlation < 1.2
    assert coloured.correlation == pytest.approx(20.0, rel=0.3)  # Σ ρ of a triangle; its estimate's own noise
    assert np.all(coloured.std > 3 * white.std)


# Of more than 50,000 readings gradients alone are summed up; those of nine parameters are no sensor of six.
@pytest.mark.parametrize(("parameters", "of", "count"), [(6, 6, 300), (9, 9, 300), (6, 9, 60_000), (9, 9, 60_000)])
def test_the_fit_is_the_minimum_that_scipy_finds(parameters: int, of: int, count: int) -> None:
    x, _, _ = sensor(3, of, count=count)
    fit = ellipsoid(x, parameters=parameters)
    # Without the outliers: one in 16,000 is beyond four deviations of normal noise, which makes norms larger, too.
    mean = fit.norm * (1.0 + (fit.residual_rms / fit.norm) ** 2)
    x = x[np.argsort(np.abs(np.linalg.norm(fit.calibration.apply(x), axis=1) - mean))[: fit.samples]]
    pairs = ((0, 1), (0, 2), (1, 2))

    def residuals(theta: FloatArray) -> FloatArray:
        a = np.diag(theta[:3])
        for value, (i, j) in zip(theta[3:-3], pairs, strict=False):
            a[i, j] = a[j, i] = value
        radius = np.linalg.det(a) ** (-1 / 3)
        return radius * (np.linalg.norm((x - theta[-3:]) @ a, axis=1) - 1.0)

    start = fit.values * 1.01
    start[:-3] /= fit.norm
    found = least_squares(residuals, start, method="lm", xtol=1e-14, ftol=1e-14, gtol=1e-14)
    s = np.diag(found.x[:3])
    for value, (i, j) in zip(found.x[3:-3], pairs, strict=False):
        s[i, j] = s[j, i] = value
    s /= np.linalg.det(s) ** (1 / 3)
    # Where steps of the sum of squares are rounding (1e-16), parameters are known to its root.
    assert np.allclose(fit.values, vector_of(s, found.x[-3:], parameters), rtol=0, atol=1e-6)


def test_the_linear_start_is_cirillos_solution() -> None:
    # Equations 2 to 6 by hand, translated so that d is not near 0.
    x, s, b = sensor(4, 6, noise=0.0)
    z = x - x.mean(axis=0)
    design = np.concatenate((z**2, -2 * z), axis=1)
    solution = np.linalg.lstsq(design, np.ones(len(z)), rcond=None)[0]
    bar, c = solution[:3], solution[3:]
    centre = c / bar  # eq 5
    d = 1 / (1 + centre @ (bar * centre))  # eqs 3, 4
    squared, centre_here = _linear.algebraic(x.T, 6)
    # Rounding times the condition of squares of readings, 1e4.
    assert np.allclose(np.diag(squared), d * bar, rtol=1e-10)
    assert np.allclose(centre_here, centre + x.mean(axis=0), rtol=0, atol=1e-9)
    assert np.allclose(np.sqrt(np.diag(squared)) * 48.0, np.diag(s), rtol=1e-10)
    assert np.allclose(centre_here, b, rtol=0, atol=1e-9)


# Laws.


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), parameters=st.sampled_from([6, 9]), noise=st.floats(0.0, 1.5))
def test_calibrating_calibrated_readings_changes_nothing(seed: int, parameters: int, noise: float) -> None:
    x, _, _ = sensor(seed, parameters, count=200, noise=noise)
    once = ellipsoid(x, parameters=parameters)
    again = ellipsoid(once.calibration.apply(x), parameters=parameters)
    # The refinement ends at steps of 1e-10 of the radius, and a hundredth of that remains; readings are up to 100.
    assert np.allclose(again.calibration.matrix, np.eye(3), rtol=0, atol=1e-9)
    assert np.allclose(again.calibration.offset, 0.0, rtol=0, atol=1e-7)
    assert again.norm == pytest.approx(once.norm, rel=1e-9)
    assert again.deviation_before == pytest.approx(once.deviation_after, rel=1e-6, abs=1e-9)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), noise=st.floats(0.0, 1.5))
def test_nine_parameters_turn_with_the_sensor(seed: int, noise: float) -> None:
    x, _, _ = sensor(seed, 9, count=200, noise=noise)
    r = rotation(np.random.default_rng(seed))
    fit, turned = ellipsoid(x), ellipsoid(x @ r.T)
    assert np.allclose(turned.calibration.matrix, r @ fit.calibration.matrix @ r.T, rtol=0, atol=1e-9)
    assert np.allclose(turned.calibration.offset, r @ fit.calibration.offset, rtol=0, atol=1e-7)
    assert turned.norm == pytest.approx(fit.norm, rel=1e-9)
    assert turned.observability == pytest.approx(fit.observability, rel=1e-6)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), scale=st.floats(1e-3, 1e3), parameters=st.sampled_from([6, 9]))
def test_another_unit_and_another_offset_change_nothing_else(seed: int, scale: float, parameters: int) -> None:
    x, _, _ = sensor(seed, parameters, count=200)
    shift = np.array([7.0, -3.0, 11.0])
    fit, other = ellipsoid(x, parameters=parameters), ellipsoid(scale * (x + shift), parameters=parameters)
    assert np.allclose(other.calibration.matrix, fit.calibration.matrix, rtol=0, atol=1e-9)
    assert np.allclose(other.calibration.offset / scale - shift, fit.calibration.offset, rtol=0, atol=1e-7)
    assert other.norm == pytest.approx(scale * fit.norm, rel=1e-9)


@BOTH
def test_hard_iron_of_ten_times_the_field_and_more_does_no_harm(parameters: int) -> None:
    x, _, _ = sensor(5, parameters)
    fit = ellipsoid(x, parameters=parameters)
    for iron in (480.0, 48_000.0):
        far = ellipsoid(x + np.array([iron, -iron, iron]), parameters=parameters)
        # The readings themselves lose iron · 1e-16 of 48.
        assert np.allclose(far.calibration.matrix, fit.calibration.matrix, rtol=0, atol=1e-9)
        assert np.allclose(far.calibration.offset - [iron, -iron, iron], fit.calibration.offset, rtol=0, atol=1e-7)


@BOTH
@pytest.mark.parametrize("share", [0.05, 0.2])
def test_a_fifth_of_outliers_does_no_harm(parameters: int, share: float) -> None:
    for seed in range(20):
        x, s, b = sensor(seed, parameters, count=1000)
        random = np.random.default_rng(1000 + seed)
        bad = random.random(1000) < share
        x[bad] = random.uniform(-1000, 1000, (int(bad.sum()), 3))
        fit = ellipsoid(x, parameters=parameters, norm=48.0)
        difference = fit.values - vector_of(s, b, parameters)
        # One in a million by chance, for 40 fits; the readings that lie on the ellipsoid by chance are counted in.
        assert difference @ np.linalg.solve(fit.covariance, difference) < chi2.ppf(1 - 1e-6, parameters)
        assert bad.sum() * 0.9 < fit.outliers <= bad.sum() + 5


def test_lying_still_half_of_the_time_does_no_harm() -> None:
    x, s, b = sensor(6, 9, count=2000)
    random = np.random.default_rng(6)
    rest = x[0] + 0.4 * random.standard_normal((4000, 3))
    moving = x.copy()
    moving[:200] = random.uniform(-300, 300, (200, 3))  # a tenth of the motion is disturbed
    fit = ellipsoid(np.concatenate((rest[:2000], moving, rest[2000:])), norm=48.0)
    # x[0] is itself 0.4 off the ellipsoid, and counts for two thirds of the readings.
    assert np.allclose(fit.values, vector_of(s, b, 9), rtol=0, atol=1.0)
    assert 150 < fit.outliers < 400


# What the result says.


def test_the_result_counts_and_measures_what_it_used() -> None:
    x, _, _ = sensor(7, 9, count=2000)
    x[::10] = np.nan
    x[1] = [500.0, 0.0, 0.0]
    fit = magnetometer(x)
    assert (fit.missing, fit.outliers, fit.samples) == (200, 1, 1799)
    there = x[~np.isnan(x).any(axis=1)]
    for raw, shown in ((there, fit.deviation_before), (fit.calibration.apply(there), fit.deviation_after)):
        norms = np.linalg.norm(raw, axis=1)
        assert shown == pytest.approx(100 * norms.std() / norms.mean(), rel=1e-9)
    clean = fit.calibration.apply(np.delete(there, np.flatnonzero(there[:, 0] == 500.0), axis=0))
    # Both are RMS of 1799 residuals about the norm; the noise's own mean, σ²/r, is not in the norm.
    assert fit.residual_rms == pytest.approx(np.std(np.linalg.norm(clean, axis=1)), rel=0.01)
    assert 0.4 * 0.7 < fit.residual_rms < 0.4 * 1.3
    assert fit.coverage == 1.0
    assert fit.observability == pytest.approx(1.0, abs=0.2)
    assert fit.names == ("S_xx", "S_yy", "S_zz", "S_xy", "S_xz", "S_yz", "b_x", "b_y", "b_z")
    assert "2000" not in fit.summary()
    assert "1799 used, 1 outliers, 200 missing" in fit.summary()
    assert fit.calibration.info["norm"] == fit.norm


def test_cirillos_measure_falls_from_a_sensor_like_theirs() -> None:
    # Their magnetometer: 17.9 % before, 2.8 % after. Ours with noise of 2.8 %.
    x, _, _ = sensor(8, 6, iron=12.0, noise=0.028 * 48.0, count=2000)
    fit = ellipsoid(x, parameters=6)
    assert fit.deviation_before > 10.0
    assert fit.deviation_after == pytest.approx(2.8, rel=0.1)


# Refusals.


def refusal(x: Any, **keywords: Any) -> str:
    with pytest.raises(CalibrationError) as caught:
        magnetometer(x, **keywords)
    return str(caught.value)


def test_too_few_readings_are_refused() -> None:
    x, _, _ = sensor(9, 9)
    assert "expected at least 9 readings for 9 parameters, got 5 (0 are NaN)" in refusal(x[:5])
    assert "expected at least 6 readings for 6 parameters, got 0 (7 are NaN)" in refusal(
        np.full((7, 3), np.nan), parameters=6
    )


@BOTH
@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_equal_readings_are_refused(parameters: int, noise: float) -> None:
    x = np.full((100, 3), 20.0) + noise * np.random.default_rng(0).standard_normal((100, 3))
    said = refusal(x, parameters=parameters)
    assert re.search("turn the sensor (slowly )?in all directions", said)


@BOTH
@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_readings_in_a_plane_are_refused_with_the_axis_that_is_missing(parameters: int, noise: float) -> None:
    angle = np.linspace(0, 20, 500)
    flat = np.stack((20 * np.cos(angle), 20 * np.sin(angle), np.full(500, -43.0)), axis=1)
    flat += noise * np.random.default_rng(0).standard_normal(flat.shape)
    said = refusal(flat, parameters=parameters)
    assert "lie in a plane, and say nothing about the axis z" in said
    assert "turn the sensor about x and y too" in said
    assert "lie on a line" in refusal(np.outer(np.linspace(-1, 1, 50), [10.0, 20.0, 30.0]), parameters=parameters)


@BOTH
def test_an_unseen_side_is_refused_and_named(parameters: int) -> None:
    x, s, b = sensor(10, parameters, count=4000)
    up = (x - b) @ s.T / 48.0
    for axis, name in enumerate("xyz"):
        said = refusal(x[up[:, axis] > 0.3], parameters=parameters)
        assert f"the field along −{name}" in said
        assert "upside down" in said or name != "z"


def test_somewhat_more_than_a_half_sphere_is_enough() -> None:
    x, s, b = sensor(11, 9, count=4000)
    fit = magnetometer(x[(x - b)[:, 2] > -10.0], norm=48.0)
    difference = fit.values - vector_of(s, b, 9)
    assert difference @ np.linalg.solve(fit.covariance, difference) < chi2.ppf(0.999, 9)


def test_axes_alone_do_for_six_parameters_and_are_told_not_to_for_nine() -> None:
    random = np.random.default_rng(12)
    poses = np.repeat(np.concatenate((np.eye(3), -np.eye(3))), 50, axis=0)
    x = 48.0 * poses + 0.2 * random.standard_normal((300, 3)) + [3.0, -8.0, 1.0]
    assert np.allclose(magnetometer(x, parameters=6).calibration.offset, [3.0, -8.0, 1.0], atol=0.1)  # 4 · 0.2/√50
    said = refusal(x)
    assert "tilted by about 45°" in said
    assert "parameters=6 would do with these" in said


def test_noise_alone_is_refused() -> None:
    random = np.random.default_rng(13)
    with pytest.raises(CalibrationError, match=r"would be known to|do not determine"):
        magnetometer(20.0 * random.standard_normal((40, 3)))


@pytest.mark.parametrize(
    ("factor", "norm", "message"),
    [
        (0.01, 48.0, r"mag: expected readings of about 48 µT, got 0.\d+: are they in Gauss \(times 100\)\?"),
        (1e-6, 48.0, r"are they in Tesla \(times 1e6\)\?"),
        (1000.0, 48.0, r"are they in nT"),
        (0.2, 48.0, r"expected readings of about 48 µT, got [\d.]+$"),
    ],
)
def test_readings_of_another_unit_than_the_norm_are_refused(factor: float, norm: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        magnetometer(factor * sensor(14, 9)[0], norm=norm)


def test_a_field_that_is_not_earths_is_calibrated_with_a_warning() -> None:
    x = 0.01 * sensor(15, 9)[0]
    with pytest.warns(CalibrationWarning, match="Earth's field is 22 to 67 µT: are the readings in another unit"):
        fit = magnetometer(x)
    assert fit.deviation_after < 2.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        magnetometer(100 * x)


@pytest.mark.parametrize(
    ("x", "keywords", "message"),
    [
        (np.zeros((5, 2)), {}, r"mag: expected shape \(T, 3\), got \(5, 2\)"),
        (np.zeros(3), {}, r"mag: expected shape \(T, 3\)"),
        ([["a", "b", "c"]], {}, "mag: expected an array of real numbers"),
        (np.array([[1.0, 2.0, np.inf]] * 9), {}, "mag: expected finite values or NaN .* at row 0"),
        (np.zeros((9, 3)), {"parameters": 7}, "parameters: expected 3, 4, 6 or 9, got 7"),
        (np.zeros((9, 3)), {"norm": -1.0}, "norm: expected a positive number"),
        (np.zeros((9, 3)), {"norm": np.nan}, "norm: expected a positive number"),
    ],
)
def test_what_is_no_argument_is_a_value_error_that_names_it(x: Any, keywords: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        magnetometer(x, **keywords)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(0, 40),
    kind=st.sampled_from(["normal", "tiny", "huge", "grid", "gaps", "line", "two points"]),
    parameters=st.sampled_from([6, 9]),
)
def test_any_readings_give_a_finite_calibration_or_say_why_not(
    seed: int, count: int, kind: str, parameters: int
) -> None:
    random = np.random.default_rng(seed)
    x = random.standard_normal((count, 3))
    match kind:
        case "tiny":
            x *= 1e-160
        case "huge":
            x *= 1e160
        case "grid":
            x = np.round(x)
        case "gaps":
            x[random.random(x.shape) < 0.2] = np.nan
        case "line":
            x = np.outer(x[:, 0], [1.0, 2.0, 3.0])
        case "two points":
            x = np.where(x[:, :1] > 0, [1.0, 2.0, 3.0], [-2.0, 0.0, 1.0])
    said = ""
    try:
        assert_sound(ellipsoid(x, parameters=parameters))
    except CalibrationError as error:
        said = str(error)
    assert said == "" or said.startswith("x: ")


def assert_sound(fit: EllipsoidFit) -> None:
    for numbers in (fit.values, fit.covariance, fit.norm, fit.residual_rms, fit.deviation_after, fit.correlation):
        assert np.isfinite(numbers).all()
    assert np.linalg.eigvalsh(fit.calibration.matrix)[0] > 0
    assert np.array_equal(fit.calibration.matrix, fit.calibration.matrix.T)
    assert np.linalg.eigvalsh(fit.covariance)[0] >= -1e-12 * np.linalg.eigvalsh(fit.covariance)[-1]


# Accelerometers.

RATE = 100.0


def held(seed: int, poses: int, parameters: int = 6) -> tuple[FloatArray, FloatArray, FloatArray]:
    """An accelerometer that is held for 3 s in each pose and shaken for 2 s in between."""
    random = np.random.default_rng(seed)
    s, b = symmetric(random, parameters, 0.05), random.uniform(-0.5, 0.5, 3)
    parts = []
    for up in directions(random, poses):
        shake = 6.0 * random.standard_normal((200, 3))
        parts += [np.tile(GRAVITY * up, (300, 1)), GRAVITY * directions(random, 1) + shake]
    force = np.concatenate(parts)
    return force @ np.linalg.inv(s).T + b + 0.05 * random.standard_normal(force.shape), s, b


@BOTH
@pytest.mark.parametrize("select", ["rest", "robust"])
def test_an_accelerometer_is_calibrated_by_its_rests_among_motion(parameters: int, select: str) -> None:
    for seed in range(5):
        x, s, b = held(seed, 24, parameters)
        fit = accelerometer(x, rate=RATE, select=select, parameters=parameters)
        difference = np.abs(fit.values - vector_of(s, b, parameters))
        if select == "rest":
            assert fit.left_out > 24 * 150
            assert difference @ (difference / fit.std**2) < 200  # a wrong selection is off by hundreds of deviations
            assert difference.max() < 0.02  # 24 poses, noise 0.05/√25 in each of some ten windows
        else:
            # Of the shaken readings those within 4 σ of the sphere stay: some 2 % of all, of either side.
            assert difference.max() < 0.05
        assert fit.norm == GRAVITY
        assert fit.norm_std == 0.0


def test_known_rests_are_taken_as_they_are() -> None:
    x, s, b = held(6, 20)
    still = (np.arange(len(x)) % 500) < 300
    fit = accelerometer(x, still=still)
    assert np.allclose(fit.values, vector_of(s, b, 6), rtol=0, atol=0.02)
    assert fit.samples == pytest.approx(still.sum(), abs=5)
    assert fit.left_out == 20 * 200
    windows = accelerometer(x, still=still, rate=RATE)
    assert np.allclose(windows.values, vector_of(s, b, 6), rtol=0, atol=0.02)
    with pytest.raises(ValueError, match=r"still: expected bool of shape \(10000,\), got float64 of \(3,\)"):
        accelerometer(x, still=np.zeros(3))


def test_a_sensor_that_never_points_down_is_told_to_be_turned_upside_down() -> None:
    x, _, b = held(7, 60)
    up = np.repeat((x.reshape(60, 500, 3)[:, :300].mean(axis=1) - b)[:, 2] / GRAVITY > 0.5, 500)
    with pytest.raises(CalibrationError, match=r"nothing was recorded with .*z pointing down .*upside down too"):
        accelerometer(x[up], rate=RATE)


def test_an_accelerometer_in_g_is_refused_with_the_factor() -> None:
    x, _, _ = held(8, 20)
    with pytest.raises(
        ValueError, match=r"acc: expected readings of about 9.807 m/s², got 1.*in g \(times 9.80665\)\?"
    ):
        accelerometer(x / GRAVITY, rate=RATE)
    with pytest.raises(ValueError, match="are they in mg"):
        accelerometer(x * 1000 / GRAVITY, rate=RATE, select="robust")


def test_arguments_of_an_accelerometer_are_checked() -> None:
    x, _, _ = held(9, 20)
    with pytest.raises(ValueError, match="rate: needed to find the windows at rest"):
        accelerometer(x)
    with pytest.raises(ValueError, match='select: expected "rest" or "robust"'):
        accelerometer(x, rate=RATE, select="all")
    with pytest.raises(ValueError, match="gravity: expected a positive number"):
        accelerometer(x, rate=RATE, gravity=0.0)
    shaken = 10.0 * np.random.default_rng(0).standard_normal((1000, 3))
    with pytest.raises(CalibrationError, match=r"expected at least 6 windows at rest for 6 parameters, got 0"):
        accelerometer(shaken, rate=RATE)
