"""Laws of the numbers that sum up many errors."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.cbook import boxplot_stats
from numpy.typing import NDArray
from scipy import stats
from scipy.spatial.transform import Rotation

from ahrs_rs import metrics

FloatArray = NDArray[np.float64]
Number = Callable[..., "float | FloatArray"]

#: Rounding of sums and means of some hundred numbers, relative to their size.
ROUNDING = 1e-13

NUMBERS = {"rmse": metrics.rmse, "mae": metrics.mae, "mad": metrics.mad, "gae": metrics.gae, "imre": metrics.imre}
EVERY_NUMBER = pytest.mark.parametrize("number", NUMBERS.values(), ids=NUMBERS)


def random_errors(count: int, seed: int = 0) -> FloatArray:
    return 10.0 ** np.random.default_rng(seed).uniform(-3, 3, count) * np.random.default_rng(seed + 1).choice(
        [-1.0, 1.0], count
    )


def literal_imre(errors: FloatArray) -> float:
    """The definition, line by line."""
    left = [abs(float(one)) for one in errors]
    while len(left) > 1:
        low, high = min(left), max(left)
        left.remove(low)
        left.remove(high)
        left.append(0.5 * low + 0.5 * high)
    return left[0]


def test_numbers_of_errors_known_by_hand() -> None:
    error = [3.0, -4.0, 1.0, 2.0, -10.0]
    assert metrics.rmse(error) == pytest.approx(math.sqrt((9 + 16 + 1 + 4 + 100) / 5), rel=ROUNDING)
    assert metrics.mae(error) == 4.0
    # The median is 1, the distances to it are 2, 5, 0, 1, 11.
    assert metrics.mad(error) == 2.0
    assert metrics.gae(error) == pytest.approx(240.0 ** (1 / 5), rel=ROUNDING)
    # 1 2 3 4 10 -> 2 3 4 5.5 -> 3 3.75 4 -> 3.5 3.75 -> 3.625
    assert metrics.imre(error) == 3.625
    # 50 %, 200 %, 10 %, 20 %, and none of zero
    assert metrics.mape(error, [6.0, 2.0, -10.0, 10.0, 0.0]) == pytest.approx(70.0, rel=ROUNDING)
    assert metrics.mape(error, [6.0, 2.0, -10.0, 10.0, 0.0], least=2.0) == pytest.approx(80.0 / 3.0, rel=ROUNDING)


def test_numbers_equal_those_of_scipy_and_sklearn() -> None:
    scores = pytest.importorskip("sklearn.metrics")
    truth, error = np.random.default_rng(2).uniform(1, 9, 501), random_errors(501)
    assert metrics.mad(error) == pytest.approx(stats.median_abs_deviation(error), rel=ROUNDING)
    assert metrics.gae(error) == pytest.approx(stats.gmean(np.abs(error)), rel=ROUNDING)
    # The estimate truth + error rounds the error to the size of the truth: 1e-16 of 1 where it is 1e-3.
    estimate = truth + error
    assert metrics.rmse(error) == pytest.approx(scores.root_mean_squared_error(truth, estimate), rel=1e-12)
    assert metrics.mae(error) == pytest.approx(scores.mean_absolute_error(truth, estimate), rel=1e-12)
    expected = 100.0 * scores.mean_absolute_percentage_error(truth, estimate)
    assert metrics.mape(error, truth) == pytest.approx(expected, rel=1e-12)


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=40))
def test_imre_is_that_of_its_definition(values: list[float]) -> None:
    # Equal numbers may leave in another order, which changes nothing.
    assert metrics.imre(values) == literal_imre(np.array(values))


@pytest.mark.parametrize("count", [2, 3, 10, 1000, 1001])
def test_imre_of_many_is_that_of_its_definition(count: int) -> None:
    for error in (random_errors(count), np.random.default_rng(5).standard_normal(count)):
        assert metrics.imre(error) == literal_imre(error)


@EVERY_NUMBER
@given(scale=st.floats(1e-3, 1e3))
def test_numbers_scale_with_the_errors_and_know_no_order(number: Number, scale: float) -> None:
    error = random_errors(60)
    assert number(scale * error) == pytest.approx(scale * number(error), rel=ROUNDING)
    assert number(error[::-1]) == pytest.approx(number(error), rel=ROUNDING)


@EVERY_NUMBER
def test_each_series_has_its_number_over_the_samples_that_count(number: Number) -> None:
    error = random_errors(240).reshape(2, 3, 40)
    error[0, 0, :5] = np.nan
    error[1, 2] = np.nan
    mask = np.random.default_rng(1).random((2, 3, 40)) < 0.5
    found = number(error, mask)
    assert np.shape(found) == (2, 3)
    for i, j in np.ndindex(2, 3):
        kept = error[i, j][mask[i, j] & ~np.isnan(error[i, j])]
        expected = number(kept) if kept.size else np.nan
        assert np.asarray(found)[i, j] == pytest.approx(expected, rel=ROUNDING, nan_ok=True)
    assert math.isnan(float(number(error[1, 2])))
    assert isinstance(number(error[0, 1]), float)
    with pytest.raises(ValueError, match=r"mask: expected shape \(2, 3, 40\), got \(3,\)"):
        number(error, np.ones(3, dtype=bool))
    with pytest.raises(ValueError, match="mask: expected an array of bool"):
        number(error, np.ones(40))
    with pytest.raises(ValueError, match="error: expected shape"):
        number(1.0)


def test_geometric_mean_with_a_zero_is_zero_and_a_constant_error_has_no_deviation() -> None:
    assert metrics.gae([1.0, 0.0, 5.0]) == 0.0
    assert metrics.mad([-3.0, -3.0, -3.0]) == 0.0


def test_mape_refuses_a_truth_of_another_shape() -> None:
    with pytest.raises(ValueError, match=r"truth: expected shape \(3,\), got \(2,\)"):
        metrics.mape([1.0, 2.0, 3.0], [1.0, 2.0])
    assert math.isnan(float(metrics.mape([1.0, 2.0], 0.0)))


@pytest.mark.parametrize("whisker", [0.0, 0.5, 1.5, math.inf])
@given(values=st.lists(st.floats(-100, 100), min_size=1, max_size=30))
def test_boxes_equal_those_of_matplotlib(values: list[float], whisker: float) -> None:
    found = metrics.box(values, whisker=whisker)
    (expected,) = boxplot_stats(np.array(values), whis=(0, 100) if math.isinf(whisker) else whisker)
    names = {"low": "whislo", "q1": "q1", "median": "med", "q3": "q3", "high": "whishi"}
    for ours, theirs in names.items():
        assert getattr(found, ours) == pytest.approx(float(expected[theirs]), rel=ROUNDING, abs=1e-300)
    assert found.outliers == len(expected["fliers"])


def test_a_box_known_by_hand() -> None:
    found = metrics.box([[1.0, 2.0, 3.0, 4.0, 5.0, 100.0, np.nan], [7.0] * 7])
    assert np.asarray(found.median).tolist() == [3.5, 7.0]
    assert np.asarray(found.q1).tolist() == [2.25, 7.0]
    assert np.asarray(found.q3).tolist() == [4.75, 7.0]
    assert np.asarray(found.low).tolist() == [1.0, 7.0]
    assert np.asarray(found.high).tolist() == [5.0, 7.0]
    assert np.asarray(found.outliers).tolist() == [1.0, 0.0]
    with pytest.raises(ValueError, match="whisker: expected a number that is not negative"):
        metrics.box([1.0], whisker=-1.0)


def turned(angle: float, axis: int, count: int = 4) -> FloatArray:
    vector = np.zeros((count, 3))
    vector[:, axis] = angle
    return np.asarray(Rotation.from_rotvec(vector).as_quat(scalar_first=True))


def test_error_angles_are_those_of_the_turn_from_estimate_to_truth_in_the_sensor_frame() -> None:
    ref = np.asarray(Rotation.random(4, rng=np.random.default_rng(0)).as_quat(scalar_first=True))
    for axis in range(3):
        turn = Rotation.from_quat(turned(0.1, axis), scalar_first=True)
        est = (Rotation.from_quat(ref, scalar_first=True) * turn.inv()).as_quat(scalar_first=True)
        expected = np.zeros(3)
        expected[axis] = 0.1
        assert metrics.error_angles(est, ref) == pytest.approx(np.tile(expected, (4, 1)), abs=ROUNDING)


def test_static_and_dynamic_errors_known_by_hand() -> None:
    ref = turned(0.0, 0)
    est = np.concatenate((turned(-0.01, 0, 2), turned(-0.02, 2, 2)))
    found = metrics.static_dynamic(est, ref, np.array([False, False, True, True]), degrees=False)
    assert found.static == pytest.approx([0.01, 0.0, 0.0], abs=ROUNDING)
    assert found.dynamic == pytest.approx([0.0, 0.0, 0.02], abs=ROUNDING)
    masked = metrics.static_dynamic(est, ref, np.array([False, True, True, True]), np.array([False, True, True, False]))
    assert np.isnan(masked.static).all()
    assert masked.dynamic == pytest.approx(np.degrees([0.01, 0.0, 0.02]) / math.sqrt(2.0), abs=ROUNDING)
    both = metrics.static_dynamic(np.stack((est, ref)), ref, np.array([False, False, True, True]))
    assert both.dynamic.shape == (2, 3)
    with pytest.raises(ValueError, match="moving: expected an array of bool"):
        metrics.static_dynamic(est, ref, np.ones(4))
    with pytest.raises(ValueError, match="est: expected shape"):
        metrics.static_dynamic(est[0], ref[0], np.array(True))


def test_absolute_euler_errors_ignore_the_jump_and_the_sign() -> None:
    est, ref = turned(np.radians(179.0), 2, 1), turned(np.radians(-178.0), 2, 1)
    wrapped = metrics.euler_error(est, ref, degrees=True)
    absolute = metrics.euler_error(est, ref, degrees=True, convention="absolute")
    # Degrees of a half turn: 180 times the rounding of 1.
    assert wrapped == pytest.approx(np.array([[0.0, 0.0, -3.0]]), abs=1e-12)
    assert absolute == pytest.approx(np.array([[0.0, 0.0, 1.0]]), abs=1e-12)
    # What the paper's convention cannot see.
    small = metrics.euler_error(turned(0.2, 0, 1), turned(-0.2, 0, 1), convention="absolute")
    assert small == pytest.approx(np.zeros((1, 3)), abs=ROUNDING)
    with pytest.raises(ValueError, match="convention: expected 'wrapped' or 'absolute'"):
        metrics.euler_error(est, ref, convention="Ludwig")
