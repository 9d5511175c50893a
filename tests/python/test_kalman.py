"""What the Kalman filters report beside the attitude, their gains, and the parameters that they refuse."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are

import ahrs_rs as ar
from ahrs_rs import Status
from cases import CASES, COMMON, Case, each_case_with
from settling import DEGREE2
from signals import RATE, Signals, angle_between, disturbed, gappy, motion, rotation, still

#: Those that measure at every sample: `SelfCalKF`, which does once a block, has tests of its own (tests/selfcal).
KALMAN_CASES = [case for case in CASES if case.kalman and "nis" in case.cls.OUTPUTS]
KALMAN_NAMES = sorted({case.name for case in KALMAN_CASES})
each_kalman = each_case_with(lambda case: case in KALMAN_CASES)
DTYPES = pytest.mark.parametrize("dtype", [np.float64, np.float32])

#: Shapes of a row. Innovations: of the angles; specific force; rate, force and field; tilt and heading.
SHAPES: dict[str, dict[str, tuple[int, ...]]] = {
    "LinearKalman": {"covariance": (3, 3), "innovation": (2,), "nis": (2,)},
    "EKF": {"covariance": (3, 3), "innovation": (9,), "nis": (3,)},
    "DcmImu": {"covariance": (3, 3), "innovation": (3,), "nis": ()},
    "MEKF": {"covariance": (3, 3), "innovation": (3,), "nis": (2,)},
}


# Outputs.


def test_the_filters_with_a_covariance_are_those_with_a_row_of_shapes() -> None:
    assert sorted(SHAPES) == KALMAN_NAMES


@DTYPES
@each_kalman
def test_outputs_have_the_shapes_of_the_documentation(case: Case, dtype: type) -> None:
    f = case.make(rate=RATE)
    outputs = tuple(f.OUTPUTS)
    assert set(outputs) == set(SHAPES[case.name])
    signals = motion(30, 1).astype(dtype)
    one = f.run(*signals.sensors(), outputs=outputs)
    many = f.run(*(np.stack([array] * 2) for array in signals.sensors()), outputs=outputs)
    for name, shape in SHAPES[case.name].items():
        assert (one.extra[name].shape, one.extra[name].dtype) == ((30, *shape), dtype)
        assert many.extra[name].shape == (2, 30, *shape)
    assert one.covariance is one.extra["covariance"]
    assert f.run(*signals.sensors(), outputs=("nis",)).covariance is None


@DTYPES
@each_kalman
def test_the_covariance_of_streaming_is_that_of_the_batch(case: Case, dtype: type) -> None:
    signals = gappy(motion(200, 2), 3).astype(dtype)
    f = case.make(rate=RATE, dtype=dtype)
    batch = f.run(*signals.sensors(), outputs=("covariance",)).covariance
    assert batch is not None
    for k in range(200):
        f.update(*(array[k] for array in signals.sensors()))
        assert f.covariance is not None
        assert f.covariance.dtype == dtype
        assert np.array_equal(f.covariance, batch[k])


@each_kalman
def test_an_innovation_is_there_where_a_measurement_is(case: Case) -> None:
    signals = motion(300, 4)
    lost = np.random.default_rng(5).random((2, 300)) < 0.5
    est = case.make(rate=RATE).run(
        *signals.without(acc=lost[0], mag=lost[1]).sensors(), q0=signals.before, outputs=("innovation", "nis")
    )
    acc, mag = ~lost
    # Columns of either output by the sensor that they need; a gyroscope that is the filter's input has none.
    gyr = np.full(300, case.own_rate)
    sensors = {
        "LinearKalman": {"innovation": [acc] * 2, "nis": [acc] * 2},
        "EKF": {"innovation": [gyr] * 3 + [acc] * 3 + [mag] * 3, "nis": [gyr, acc, mag]},
        "DcmImu": {"innovation": [acc] * 3, "nis": [acc]},
        "MEKF": {"innovation": [acc] * 2 + [mag], "nis": [acc, mag]},
    }
    for name, columns in sensors[case.name].items():
        values = est.extra[name].reshape(300, -1)
        assert np.array_equal(np.isfinite(values), np.stack(columns, axis=1)), name
    assert np.nanmin(est.extra["nis"]) >= 0.0


@st.composite
def any_signals(draw: st.DrawFn) -> tuple[Signals, bool]:
    """Motion of any pace and noise, with gaps of up to a minute and any rows missing; and whether in nine axes."""
    seed = draw(st.integers(0, 1000), label="seed")
    signals = motion(
        300,
        seed,
        rate=draw(st.sampled_from([20.0, 100.0, 1000.0]), label="rate"),
        noise=draw(st.sampled_from([0.0, 0.01, 1.0, 10.0]), label="noise"),
        level=True,
        jitter=draw(st.booleans(), label="jitter"),
    )
    rng = np.random.default_rng(seed)
    gaps = np.where(rng.random(300) < 0.02, rng.uniform(0.0, draw(st.sampled_from([0.0, 1.0, 60.0]), label="gap")), 0.0)
    lost = rng.random((3, 300)) < np.array(draw(st.tuples(*[st.sampled_from([0.0, 0.1, 0.9])] * 3)))[:, None]
    signals = replace(signals, t=signals.t + np.cumsum(gaps)).without(gyr=lost[0], acc=lost[1], mag=lost[2])
    return signals, draw(st.booleans(), label="nine")


#: Gaps of a minute, again and again, look like stamps in packets.
@pytest.mark.filterwarnings("ignore::ahrs_rs.DataWarning")
@DTYPES
@given(drawn=any_signals())
@settings(max_examples=150)
def test_covariances_are_symmetric_and_positive_definite(dtype: type, drawn: tuple[Signals, bool]) -> None:
    # Level motion: at pitch 90° the roll of LinearKalman turns about the vertical, and two angles have no third axis.
    signals, nine = drawn
    for case in KALMAN_CASES:
        est = case.make(rate=RATE).run(*signals.astype(dtype).sensors(nine=nine), t=signals.t, outputs=("covariance",))
        assert est.covariance is not None
        p = est.covariance.astype(np.float64)
        assert np.array_equal(p, np.swapaxes(p, -1, -2)), case.label
        # An unknown heading counts as π²/3 rad², of which float32 rounds away variances of inclination of 1e-7 rad².
        rounding = 0.0 if dtype is np.float64 else np.finfo(dtype).eps * p.max(axis=(1, 2))
        assert np.all(np.linalg.eigvalsh(p)[:, 0] > -rounding), case.label


@each_kalman
def test_an_unknown_heading_has_the_variance_of_a_uniform_angle(case: Case) -> None:
    signals = motion(50, 6)
    for nine in (False, True):
        est = case.make(rate=RATE).run(*signals.sensors(nine=nine), outputs=("covariance",))
        assert est.covariance is not None
        up = rotation(est.quat).inv().apply([0.0, 0.0, 1.0])
        about_up = np.einsum("ki,kij,kj->k", up, est.covariance, up)[1:]
        if nine and case.cls.MAGNETOMETER:
            assert about_up.max() < 1.0
        else:
            # Rounding of a sum of nine products.
            assert np.abs(about_up - math.pi**2 / 3.0).max() < 1e-14


@each_case_with(lambda case: case.name == "MEKF")
def test_status_says_what_mekf_makes_of_its_measurements(case: Case) -> None:
    status = case.run(disturbed()).status
    rest, acc, mag, recovering = (
        np.flatnonzero(status & bit) / RATE
        for bit in (Status.REST, Status.ACC_REJECTED, Status.MAG_REJECTED, Status.RECOVERING)
    )
    # 1.5 s after rest begins, as long as it lasts and as the low-pass filters of half a second need to see its end.
    assert np.all(((rest > 1.49) & (rest < 4.5)) | ((rest > 21.5) & (rest < 24.5)))
    assert len(rest) > 4.0 * RATE
    # An acceleration that lasts: a mean over 10 s of 1.7 m/s² doubles the noise, which 8 m/s² make in 2.4 s or more.
    assert 10.0 < acc.min() < 15.0
    assert acc.max() < 15.0 + 2.0 * 10.0
    # A wrong field is refused at once, for 10 s, and is the reference from then on.
    assert np.array_equal(mag[mag >= 24.0], np.arange(2400, 3400) / RATE)
    assert recovering[-1] == 34.0


# Gains.


def riccati(dt: float, angle_process: float, bias_process: float, variance: float) -> tuple[float, float, float]:
    """Steady state of LinearKalman's axis: the variance of its angle after and before an update, and the gain K1."""
    phi = np.array([[1.0, -dt], [0.0, 1.0]])
    before = solve_discrete_are(
        phi.T, np.array([[1.0], [0.0]]), np.diag([angle_process, bias_process]) * dt, np.array([[variance]])
    )[0, 0]
    gain = before / (before + variance)
    return float(gain * variance), float(before), float(gain)


#: Parikh's matrices and a set that settles sooner: process noise of angle (rad²/s) and bias (rad²/s³), variance (rad²).
LINEAR = [
    (0.01181 * DEGREE2 / 0.005, 4.28e-6 * DEGREE2 / 0.005, 2650.0 * DEGREE2),
    (1e-3, 1e-4, 1e-2),
]


@pytest.mark.parametrize(("angle", "bias", "variance"), LINEAR)
def test_the_gain_of_a_linear_kalman_filter_at_rest_is_that_of_its_riccati_equation(
    angle: float, bias: float, variance: float
) -> None:
    # The slowest pole of Parikh's matrices is 0.019/s, so that in 1000 s the covariance settles to exp(-38). The level
    # sensor trembles by 1e-6 rad: enough for innovations of ten digits, too little to mix roll, pitch and heading.
    rate, samples = 20.0, 20_000
    data = still([1.0, 0.0, 0.0, 0.0], samples)
    data["acc"] = data["acc"] + 1e-5 * np.random.default_rng(7).standard_normal((samples, 3))
    f = ar.LinearKalman(rate=rate, angle_process=angle, bias_process=bias, angle_variance=variance)
    est = f.run(**data, outputs=("covariance", "innovation", "nis"))
    after, before, gain = riccati(1.0 / rate, angle, bias, variance)
    assert est.covariance is not None
    assert est.covariance[-1].diagonal()[:2] == pytest.approx([after] * 2, rel=1e-7)
    s = est.extra["innovation"][-1] ** 2 / est.extra["nis"][-1]
    assert s == pytest.approx([before + variance] * 2, rel=1e-7)
    assert est.covariance[-1, 0, 0] / variance == pytest.approx(gain, rel=1e-7)


@pytest.mark.parametrize("gain", [1e-6, 0.003, 0.5, 0.999])
def test_a_complementary_filter_from_a_kalman_gain_has_its_time_constant(gain: float) -> None:
    f = ar.Complementary.from_kalman_gain(gain, rate=RATE, frame="NED", integration="first-order")
    tau = (1.0 - gain) / gain / RATE
    # 1 - (1 - K1) loses the digits of a small gain.
    assert f.params["tau"] == pytest.approx(tau, rel=1e-15 / gain + 1e-15)
    assert (f.rate, f.frame, f.params["integration"]) == (RATE, "NED", "first-order")
    signals = motion(300, 8)
    same = ar.Complementary(tau=f.params["tau"], rate=RATE, frame="NED", integration="first-order")
    assert np.array_equal(f.run(*signals.sensors()).quat, same.run(*signals.sensors()).quat)


@pytest.mark.parametrize("gain", [0.0, 1.0, -0.1, 2.0, math.nan, math.inf])
def test_a_gain_out_of_range_is_a_value_error(gain: float) -> None:
    with pytest.raises(ValueError, match=r"^gain"):
        ar.Complementary.from_kalman_gain(gain, rate=RATE)


def test_a_gain_without_a_rate_is_an_error() -> None:
    with pytest.raises(TypeError, match="rate"):
        ar.Complementary.from_kalman_gain(0.5)


@pytest.mark.parametrize(("angle", "bias", "variance"), LINEAR)
def test_a_linear_kalman_filter_at_its_steady_gain_is_a_complementary_filter(
    angle: float, bias: float, variance: float
) -> None:
    # Without a bias the two are the same equations: the Kalman filter settles, the other goes on from there.
    gain = -0.5 * angle / RATE / variance
    gain += math.sqrt(gain**2 - 2.0 * gain)  # K² = (1 - K) q/r, of the scalar Riccati equation
    signals = motion(60_000, 9, level=True)
    f = ar.LinearKalman(rate=RATE, angle_process=angle, bias_process=0.0, angle_variance=variance, initial_bias=1e-9)
    settled = f.run(*(array[:50_000] for array in signals.sensors()))
    rest = [array[50_000:] for array in signals.sensors()]
    kalman = f.run(*rest, state=settled.state)
    twin = ar.Complementary.from_kalman_gain(gain, rate=RATE).run(*rest, q0=settled.quat[-1])
    # 1e-9 rad/s of bias over the time constant of 3 s.
    assert angle_between(kalman.quat, twin.quat).max() < 1e-8


@pytest.mark.parametrize(("angle", "bias", "variance"), LINEAR)
def test_a_complementary_filter_from_the_gain_k1_tracks_a_linear_kalman_filter(
    angle: float, bias: float, variance: float
) -> None:
    # What differs is the bias b that the latter estimates: roll and pitch are turned by at most |b| (1 + tan 40°) dt a
    # step more, and a complementary filter forgets that within τ. 40° is 30° of the motion and errors.
    gain = riccati(1.0 / RATE, angle, bias, variance)[2]
    signals = motion(40_000, 10, level=True)
    est = ar.LinearKalman(rate=RATE, angle_process=angle, bias_process=bias, angle_variance=variance).run(
        *signals.sensors()
    )
    twin = ar.Complementary.from_kalman_gain(gain, rate=RATE)
    other = twin.run(*signals.sensors())
    assert est.gyr_bias is not None
    # Compared after the gain has settled: 10,000 samples.
    largest = np.linalg.norm(est.gyr_bias, axis=1).max()
    difference = np.abs(est.euler() - other.euler())[10_000:, :2]
    assert difference.max() < largest * (1.0 + math.tan(math.radians(40.0))) * float(twin.params["tau"])


# Parameters.

#: Standard deviations and variances by which something is divided.
NOISE = {
    "LinearKalman": ["angle_variance"],
    "EKF": [f"{sensor}_variance_{axis}" for sensor in ("gyr", "acc", "mag") for axis in "xyz"],
    "DcmImu": ["acc_std"],
    "MEKF": ["gyr_noise", "bias_noise", "acc_noise", "heading_noise", "rest_noise", "mag_tolerance"],
}
#: Of the start, and the gravity by which accelerometers are scaled.
POSITIVE = {
    "LinearKalman": ["initial_bias"],
    "EKF": ["initial_rate", "gravity"],
    "DcmImu": ["initial_dcm", "initial_bias", "gravity"],
    "MEKF": ["initial_inclination", "initial_heading", "initial_bias", "gravity"],
}


@pytest.mark.parametrize("value", [-1.0, -1e-300, math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("name", KALMAN_NAMES)
def test_no_parameter_is_negative_or_not_finite(name: str, value: float) -> None:
    cls = ar.FILTERS[name]
    numbers = [key for key, spec in cls.PARAMS.items() if spec.options is None]
    assert set(NOISE[name] + POSITIVE[name]) <= set(numbers)
    for key in numbers:
        with pytest.raises(ValueError, match=rf"^{key}: expected a number in"):
            cls(**{key: value})


@pytest.mark.parametrize("name", KALMAN_NAMES)
def test_a_noise_of_zero_is_refused(name: str) -> None:
    for key in NOISE[name] + POSITIVE[name]:
        with pytest.raises(ValueError, match=rf"^{key}: expected a number in"):
            ar.FILTERS[name](**{key: 0.0})


@pytest.mark.parametrize("value", [0, 1])
@pytest.mark.parametrize("name", KALMAN_NAMES)
def test_the_ends_of_every_range_leave_a_finite_filter(name: str, value: int) -> None:
    cls = ar.FILTERS[name]
    signals = motion(300, 11)
    for key, spec in cls.PARAMS.items():
        if spec.range is None:
            continue
        params: dict[str, Any] = {key: spec.range[value]}
        est = cls(rate=RATE, **params).run(*signals.sensors(), outputs=("covariance",))
        assert np.isfinite(est.quat).all(), key
        assert np.isfinite(est.covariance).all(), key
        assert not (est.status & COMMON).any(), key
