"""Laws of the simulated sensor: what an exact one reads, and what each error changes."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from ahrs_rs import metrics, simulate
from ahrs_rs.simulate import Clock, Compound, Dipole, IronFloor, Sensor, Setup, Switched, Temperature, Triad, still
from test_simulate_motion import EVERY_SCENARIO, SCENARIOS

GRAVITY = [0.0, 0.0, simulate.GRAVITY]


def rotation(quat: np.ndarray) -> Rotation:
    return Rotation.from_quat(quat, scalar_first=True)


@cache
def hand(rate: float = 100.0, duration: float = 20.0) -> Setup:
    """A hand-held sensor without errors."""
    return simulate.SCENARIOS["demo"].setup(rate=rate, duration=duration, sensor="ideal")


def at_rest(sensor: Sensor, duration: float, rate: float) -> Setup:
    return Setup(motion=still(), rate=rate, duration=duration, sensor=sensor)


def integrated(recording: ar.Recording, setup: Setup, **options: Any) -> float:
    """Largest error in rad of the integrated angular rates."""
    q0 = setup.motion.orientation(np.array([-1.0 / setup.rate]))[0]
    est = ar.GyroIntegration(rate=setup.rate, **options).run(recording.gyr, q0=q0, t=recording.t)
    return float(metrics.total_error(est.quat, recording.ref).max())


# What an exact sensor reads.


@EVERY_SCENARIO
def test_mean_rates_integrate_to_the_truth(name: str) -> None:
    setup = simulate.SCENARIOS[name.split()[0]].setup(duration=60.0, sensor="ideal", seed=2, **SCENARIOS[name])
    # 60 s have up to 30,000 steps with some ten roundings each: 3e-11 if all of one sign.
    assert integrated(setup.record(), setup) < 1e-10


@pytest.mark.parametrize("name", ["demo", "way_points", "rotation_test", "walking"])
def test_instantaneous_rates_integrate_to_the_truth_as_closely_as_the_step_allows(name: str) -> None:
    held, linear = [], []
    for rate in (100.0, 200.0, 400.0):
        setup = simulate.SCENARIOS[name].setup(duration=30.0, rate=rate, sensor="ideal", rates="instantaneous")
        recording = setup.record()
        held.append(integrated(recording, setup))
        linear.append(integrated(recording, setup, gyr_hold="linear"))
    # Held over the step before it, a rate errs by half of its change: the first order of the step. The mean
    # of both ends errs by the second order. Beyond the leading order some percent of the ratio remain.
    assert np.divide(held[:-1], held[1:]) == pytest.approx([2.0, 2.0], rel=0.1)
    assert np.divide(linear[:-1], linear[1:]) == pytest.approx([4.0, 4.0], rel=0.25)
    assert linear[0] < 0.1 * held[0]
    assert held[2] > 1e-6  # it is not the mean rate


def test_instantaneous_rates_are_those_of_the_motion() -> None:
    setup = replace(hand(), rates="instantaneous")
    recording = setup.record()
    assert np.array_equal(recording.gyr, setup.motion.angular_rate(recording.t))


@EVERY_SCENARIO
def test_an_exact_sensor_reads_acceleration_and_field_in_its_axes(name: str) -> None:
    setup = simulate.SCENARIOS[name.split()[0]].setup(duration=20.0, sensor="ideal", seed=2, **SCENARIOS[name])
    recording, truth = replace(setup, disturbances=()).record_with_truth()
    attitude = rotation(recording.ref)
    # A rotation there and back: a few roundings of up to 100 m/s² and 50 µT.
    assert np.abs(attitude.apply(recording.acc) - setup.motion.acceleration(recording.t) - GRAVITY).max() < 1e-12
    assert np.abs(attitude.apply(recording.mag) - simulate.FIELD).max() < 1e-12
    assert np.array_equal(truth.position, setup.motion.position(recording.t))
    for sensor in ("gyr", "acc", "mag"):
        assert np.array_equal(getattr(recording, sensor), getattr(truth, sensor))


@EVERY_SCENARIO
def test_the_truth_is_unit_continuous_and_starts_with_positive_w(name: str) -> None:
    ref = simulate.SCENARIOS[name.split()[0]](duration=60.0, seed=1, **SCENARIOS[name]).ref
    assert ref is not None
    assert np.abs(np.linalg.norm(ref, axis=1) - 1.0).max() < 3e-15
    assert ref[0, 0] >= 0.0
    assert (ref[1:] * ref[:-1]).sum(axis=1).min() > 0.9


@settings(max_examples=20)
@given(st.integers(0, 1000), st.tuples(*[st.floats(-3.0, 3.0)] * 3))
def test_a_turned_sensor_reads_turned_vectors(seed: int, mounting: tuple[float, float, float]) -> None:
    setup = simulate.SCENARIOS["way_points"].setup(seed=seed, duration=5.0, sensor="ideal")
    added = still(*mounting)
    turned = replace(setup, motion=Compound(setup.motion, added)).record()
    plain, mount = setup.record(), rotation(added.orientation(np.zeros(1)))[0]
    for name in ("gyr", "acc", "mag"):
        # Roundings of 50 µT; a rate is a rotation of 1e-16 accuracy over 0.01 s.
        assert np.abs(mount.apply(getattr(turned, name)) - getattr(plain, name)).max() < 1e-12
    assert metrics.total_error(turned.ref, (rotation(plain.ref) * mount).as_quat(scalar_first=True)).max() < 1e-14


def test_a_motion_whose_sign_jumps_gives_a_continuous_truth() -> None:
    class Jumping:
        motion = hand().motion

        def orientation(self, t: np.ndarray) -> np.ndarray:
            return np.where((t * 7.0 % 2.0 < 1.0)[:, None], 1.0, -1.0) * self.motion.orientation(t)

        def __getattr__(self, name: str) -> Any:
            return getattr(self.motion, name)

    plain, jumping = hand().record(), replace(hand(), motion=Jumping()).record()
    assert np.array_equal(plain.ref, jumping.ref)
    assert np.array_equal(plain.gyr, jumping.gyr)


def test_samples_do_not_depend_on_the_length_of_the_recording() -> None:
    # Blocks and drifts are drawn in order: a longer recording begins with the shorter one.
    setup = replace(hand(1000.0, 12.0), sensor=replace(simulate.SENSORS["rough"], clock=Clock(jitter=0.1)))
    sensor = setup.sensor
    sensor = replace(sensor, gyr=replace(sensor.gyr, dropout=0.0), acc=replace(sensor.acc, dropout=0.0), mag=Triad())
    sensor = replace(sensor, gyr=replace(sensor.gyr, instability=0.0, random_walk=0.0))
    setup = replace(setup, sensor=sensor)
    long, short = setup.record(), replace(setup, duration=7.0).record()
    for name in ("t", "gyr", "mag", "ref"):
        assert np.array_equal(getattr(long, name)[:7000], getattr(short, name))


# Errors.


def allan(x: np.ndarray, rate: float, tau: float) -> np.ndarray:
    """Overlapping Allan deviation of (T, 3) at one averaging time (IEEE Std 952, C.1)."""
    m = round(tau * rate)
    total = np.concatenate((np.zeros((1, 3)), np.cumsum(x, axis=0))) / rate
    second = total[2 * m :] - 2.0 * total[m:-m] + total[: -2 * m]
    deviation: np.ndarray = np.sqrt(0.5 * np.mean(second**2, axis=0)) / (m / rate)
    return deviation


def test_white_noise_has_the_allan_deviation_of_its_density() -> None:
    density = {"gyr": 2e-4, "acc": 3e-3, "mag": 0.05}
    sensor = Sensor(**{name: Triad(density=value) for name, value in density.items()})
    recording = at_rest(sensor, 600.0, 200.0).record(seed=4)
    for name, value in density.items():
        noise = getattr(recording, name) - [{"gyr": 0.0, "acc": GRAVITY, "mag": simulate.FIELD}[name]]
        for tau in (0.05, 0.5, 2.0):
            # An overlapping Allan deviation of T/τ independent stretches scatters by some √(τ/T): 6 % at 2 s; 4 sigma.
            assert allan(noise, 200.0, tau) == pytest.approx(
                value / np.sqrt(2.0 * tau), rel=0.02 + 4 * (tau / 600) ** 0.5
            )


def test_rate_random_walk_has_the_allan_deviation_of_its_density() -> None:
    gyr = np.concatenate(
        [at_rest(Sensor(gyr=Triad(random_walk=1e-4)), 1000.0, 50.0).record(seed).gyr for seed in range(12)], axis=1
    )
    for tau in (1.0, 5.0, 25.0):
        found = np.sqrt(np.mean([allan(gyr[:, i : i + 3], 50.0, tau) ** 2 for i in range(0, 36, 3)]))
        # K √(τ/3); 36 independent axes of T/τ stretches each: 3 % at the longest; 4 sigma.
        assert found == pytest.approx(1e-4 * np.sqrt(tau / 3.0), rel=0.12)


def test_bias_instability_is_the_floor_of_the_allan_deviation() -> None:
    sensor = Sensor(gyr=Triad(instability=1e-3))
    found = {
        tau: np.sqrt(np.mean([allan(at_rest(sensor, 2000.0, 20.0).record(s).gyr, 20.0, tau) ** 2 for s in range(8)]))
        for tau in (3.0, 10.0, 30.0, 100.0)
    }
    for deviation in found.values():
        # 0.664 B between the shortest and the longest correlation time; processes a decade apart ripple by some 5 %,
        # and 24 axes of 2000 s scatter by 5 % at 100 s: two sigma beside the ripple.
        assert deviation == pytest.approx(0.664e-3, rel=0.15)


def test_one_correlation_time_makes_a_gauss_markov_process() -> None:
    sensor = Sensor(gyr=Triad(instability=1e-3, instability_times=(2.0,)))
    gyr = np.concatenate([at_rest(sensor, 1000.0, 50.0).record(seed).gyr for seed in range(8)], axis=1)
    # The Allan deviation's peak at 1.89 τ is 0.6174 σ, which is made 0.664 B: σ = 1.0754 B, and e⁻¹ of it after τ.
    assert gyr.std() == pytest.approx(1.0784e-3, rel=0.05)
    lag = 100
    assert np.mean(gyr[lag:] * gyr[:-lag]) / gyr.var() == pytest.approx(np.exp(-1.0), abs=0.07)
    assert np.sqrt(np.mean([allan(gyr[:, i : i + 3], 50.0, 3.78) ** 2 for i in range(0, 24, 3)])) == pytest.approx(
        0.664e-3, rel=0.08
    )


@settings(max_examples=40)
@given(
    st.integers(1, 300),
    st.floats(0.0, 1.0, exclude_max=True),
    st.integers(0, 2**32 - 1),
    st.sampled_from([1.0, 1e-200]),
)
def test_a_decaying_sum_is_its_recursion(count: int, keep: float, seed: int, scale: float) -> None:
    kicks = np.random.default_rng(seed).standard_normal((2, count))
    keep = keep * scale
    expected = np.zeros((2, count))
    state = np.zeros(2)
    for k in range(count):
        state = keep * state + kicks[:, k]
        expected[:, k] = state
    from ahrs_rs.simulate._noise import decaying_sum

    # Weights of up to 1e3 within a run cost three of sixteen digits.
    assert np.abs(decaying_sum(kicks, keep) - expected).max() < 1e-11


#: Effect -> a sensor that has it alone. What it changes is named before the colon.
EFFECTS: dict[str, Sensor] = {
    **{
        f"{name}: {effect}": replace(Sensor(), **{name: Triad(**{effect: value})})
        for name in ("gyr", "acc", "mag")
        for effect, value in {
            "density": 0.1,
            "noise": 0.1,
            "bias": 0.2,
            "bias_deviation": 0.3,
            "instability": 0.1,
            "random_walk": 0.1,
            "scale_deviation": 0.1,
            "misalignment_deviation": 0.1,
            "range": 0.5,
            "resolution": 0.25,
            "dropout": 0.2,
        }.items()
    },
    "acc: rate": Sensor(acc=Triad(rate=30.0)),
    "mag: rate": Sensor(mag=Triad(rate=30.0)),
    "mag: mag_delay": Sensor(mag_delay=0.05),
    "gyr: g_sensitivity": Sensor(g_sensitivity=0.01),
    "gyr: gain_slope": Sensor(gyr=Triad(gain_slope=0.01), temperature=Temperature(start=20.0)),
    "acc: bias_slope": Sensor(acc=Triad(bias_slope=0.01), temperature=Temperature(start=20.0)),
    "temperature: temperature": Sensor(temperature=Temperature(start=20.0, noise=0.1)),
    "t: clock": Sensor(clock=Clock(jitter=0.1)),
}


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_alone_changes_only_what_it_is_of(name: str) -> None:
    plain, real = hand().record(), replace(hand(), sensor=EFFECTS[name]).record(seed=3)
    changed = {
        one for one in ("t", "gyr", "acc", "mag", "ref") if not np.array_equal(getattr(plain, one), getattr(real, one))
    }
    expected = {"t": {"t", "gyr", "acc", "mag", "ref"}, "temperature": set()}.get(
        name.split(":")[0], {name.split(":")[0]}
    )
    assert changed == expected
    assert (real.temperature is None) == (EFFECTS[name].temperature is None)


#: Effects that add to the readings, and so can be told apart in their sum.
ADDING = {"density": 0.1, "bias": 0.2, "bias_deviation": 0.3, "instability": 0.1, "random_walk": 0.1}


@pytest.mark.parametrize("effect", ADDING)
@pytest.mark.parametrize("triad", ["gyr", "acc", "mag"])
def test_switching_an_effect_off_leaves_the_draws_of_the_others(triad: str, effect: str) -> None:
    every = Sensor(gyr=Triad(**ADDING), acc=Triad(**ADDING), mag=Triad(**ADDING))
    less = replace(every, **{triad: Triad(**{one: value for one, value in ADDING.items() if one != effect})})
    one, two, alone = (
        replace(hand(), sensor=sensor).record(3) for sensor in (every, less, EFFECTS[f"{triad}: {effect}"])
    )
    gained = getattr(one, triad) - getattr(two, triad)
    assert np.abs(gained).max() > 0.0
    # What the effect gives alone, but for roundings of 50 µT.
    assert np.abs(gained - (getattr(alone, triad) - getattr(hand().record(), triad))).max() < 1e-13
    for other in {"gyr", "acc", "mag"} - {triad}:
        assert np.array_equal(getattr(one, other), getattr(two, other))


@pytest.mark.parametrize("sensor", simulate.SENSORS)
def test_the_same_seed_gives_the_same_bits_and_another_seed_others(sensor: str) -> None:
    setup = replace(hand(), sensor=simulate.SENSORS[sensor])
    one, two, other = setup.record(5), setup.record(5), setup.record(6)
    for name in ("t", "gyr", "acc", "mag", "ref", "temperature"):
        assert (getattr(one, name) is None) == (getattr(two, name) is None)
        if getattr(one, name) is not None:
            assert np.array_equal(getattr(one, name), getattr(two, name), equal_nan=True)
    assert one.meta == two.meta
    assert np.array_equal(one.gyr, other.gyr) == (sensor == "ideal")


def test_the_same_seed_and_sensor_have_the_same_constant_errors_in_every_scenario() -> None:
    keys = [f"{name}_{what}" for name in ("gyr", "acc", "mag") for what in ("bias", "matrix")]
    found = [
        {key: scenario(sensor="mpu9250", remaining=1.0, duration=2.0, seed=8).meta[key] for key in keys}
        for scenario in simulate.SCENARIOS.values()
    ]
    assert all(one == found[0] for one in found)


@settings(max_examples=30)
@given(st.floats(1e-3, 10.0), st.floats(1e-6, 2.0), st.integers(0, 99))
def test_readings_stay_in_range_and_on_the_steps_of_the_resolution(limit: float, resolution: float, seed: int) -> None:
    sensor = Sensor(acc=Triad(range=limit, resolution=resolution))
    recording, truth = replace(hand(), sensor=sensor).record_with_truth(seed)
    steps = recording.acc / resolution
    assert np.abs(steps - np.rint(steps)).max() < 1e-6
    # The last step may lie beyond the range by half of itself.
    assert np.abs(recording.acc).max() <= limit + 0.5 * resolution
    inside = np.abs(truth.acc) < limit
    assert np.abs(recording.acc - truth.acc)[inside].max(initial=0.0) <= 0.5 * resolution * (1.0 + 1e-9)


def test_matrix_bias_and_temperature_are_applied_as_the_model_says() -> None:
    matrix = ((1.1, 0.02, 0.0), (-0.03, 0.9, 0.01), (0.0, 0.05, 1.2))
    triad = Triad(
        matrix=matrix, bias=(0.1, 0.2, 0.3), gain_slope=0.01, bias_slope=(0.0, 0.1, -0.1), reference_temperature=10.0
    )
    warm = Temperature(start=15.0, end=35.0, time_constant=5.0)
    recording, truth = replace(hand(), sensor=Sensor(acc=triad, temperature=warm)).record_with_truth()
    assert recording.temperature is not None
    away = (35.0 - 20.0 * np.exp(-recording.t / 5.0) - 10.0)[:, None]
    expected = truth.acc @ np.array(matrix).T + 0.01 * away * truth.acc + [0.1, 0.2, 0.3] + away * [0.0, 0.1, -0.1]
    assert np.abs(recording.acc - expected).max() < 1e-12
    assert recording.temperature == pytest.approx(away[:, 0] + 10.0)
    assert np.abs(truth.acc_bias - [0.1, 0.2, 0.3] - away * [0.0, 0.1, -0.1]).max() < 1e-13


def test_hyytis_table_4_is_the_model_of_the_sparkfun() -> None:
    sensor = replace(simulate.SENSORS["sparkfun6dof"], temperature=Temperature(start=30.0, end=30.0))
    exact = {"density": 0.0, "instability": 0.0, "resolution": 0.0}
    sensor = replace(sensor, gyr=replace(sensor.gyr, **exact), acc=replace(sensor.acc, **exact))
    recording, truth = replace(hand(), sensor=sensor).record_with_truth()
    # Eqs 16 and 17 at 30 °C, x axis.
    gain, bias = -0.00049316 * 30.0 + 1.06731340, -0.01551443 * 30.0 + 0.99740194
    assert recording.acc[:, 0] == pytest.approx(gain * truth.acc[:, 0] + bias, abs=1e-12)
    gain, bias = 0.00027886 * 30.0 + 0.99130982, np.radians(-0.01188330 * 30.0 + 0.24566657)
    assert recording.gyr[:, 0] == pytest.approx(gain * truth.gyr[:, 0] + bias, abs=1e-12)


def test_the_gyroscope_feels_the_specific_force_by_its_sensitivity() -> None:
    matrix = ((0.01, 0.0, 0.02), (0.0, -0.01, 0.0), (0.03, 0.0, 0.0))
    recording, truth = replace(hand(), sensor=Sensor(g_sensitivity=matrix)).record_with_truth()
    assert np.abs(recording.gyr - truth.gyr - truth.acc @ np.array(matrix).T).max() < 1e-14


def test_a_calibrated_sensor_keeps_noise_and_loses_the_rest() -> None:
    rough = simulate.SENSORS["rough"]
    for triad in (rough.calibrated().gyr, rough.calibrated().acc):
        plain = Triad()
        lost = {
            "bias",
            "bias_deviation",
            "matrix",
            "scale_deviation",
            "misalignment_deviation",
            "gain_slope",
            "bias_slope",
        }
        for one in fields(triad):
            value = getattr(triad, one.name)
            if one.name in lost:
                assert value == getattr(plain, one.name), one.name
    assert rough.calibrated().gyr.density == rough.gyr.density
    assert rough.calibrated(1.0) == rough
    assert rough.calibrated(0.5).gyr.bias_deviation == 0.5 * rough.gyr.bias_deviation
    assert rough.with_gyr_bias((1.0, 2.0, 3.0)).gyr.bias == (1.0, 2.0, 3.0)


# Rates, delays, missing rows, clocks.


@pytest.mark.parametrize(("rate", "slow"), [(1000.0, 100.0), (500.0, 220.0), (100.0, 99.9), (50.0, 100.0)])
def test_a_slower_sensor_has_its_number_of_rows_evenly_spread(rate: float, slow: float) -> None:
    recording = at_rest(Sensor(mag=Triad(rate=slow)), 20.0, rate).record()
    assert recording.mag is not None
    read = np.flatnonzero(~np.isnan(recording.mag).any(axis=1))
    assert abs(len(read) - min(slow, rate) * 20.0) <= 1.0
    assert read[0] == 0
    assert np.diff(read).max() - np.diff(read).min() <= 1


def test_a_late_magnetometer_reads_what_was() -> None:
    late = replace(hand(), sensor=Sensor(mag_delay=0.05, mag=Triad(rate=25.0))).record()
    plain = hand().record()
    read = ~np.isnan(late.mag).any(axis=1)
    read[:5] = False
    then = np.flatnonzero(read) - 5
    assert np.abs(late.mag[read] - plain.mag[then]).max() < 1e-12  # t - 0.05 differs from the row's time by rounding


@settings(max_examples=30)
@given(st.floats(0.0, 1.0), st.floats(1.0, 30.0), st.integers(0, 2**32 - 1))
def test_missing_rows_are_as_many_as_stated(part: float, length: float, seed: int) -> None:
    sensor = Sensor(acc=Triad(dropout=part, dropout_length=length))
    recording = at_rest(sensor, 400.0, 100.0).record(seed)
    missing = np.isnan(recording.acc).any(axis=1)
    assert np.isnan(recording.acc[missing]).all()
    # Groups of geometric length L and the rows between them vary the count of 40,000 by at most √(2 n L) or so: five
    # sigma, with L at least what so many missing rows make necessary.
    longest = max(length, part / (1.0 - part) if part < 1.0 else 1.0)
    assert abs(missing.mean() - part) < 5.0 * np.sqrt(2.0 * longest / 40_000) + 1e-9


def test_missing_rows_come_in_groups_of_the_stated_length() -> None:
    recording = at_rest(Sensor(acc=Triad(dropout=0.1, dropout_length=8.0)), 2000.0, 100.0).record()
    missing = np.isnan(recording.acc).any(axis=1)
    groups = np.count_nonzero(np.diff(missing.astype(int)) > 0)
    assert missing.sum() / groups == pytest.approx(8.0, rel=0.1)  # 2500 groups: 2 %


def test_lost_rows_leave_the_others_with_their_stamps() -> None:
    lossy, truth = replace(hand(), sensor=Sensor(clock=Clock(lost=0.2, lost_length=3.0))).record_with_truth(seed=1)
    plain = hand().record()
    kept = np.isin(plain.t, lossy.t)
    assert 0.6 < kept.mean() < 0.95
    assert len(lossy) == kept.sum()
    for name in ("t", "gyr", "acc", "mag", "ref"):
        assert np.array_equal(getattr(lossy, name), getattr(plain, name)[kept])
    assert np.array_equal(truth.t, lossy.t)
    assert lossy.mask is not None
    assert len(lossy.mask) == len(lossy)


def test_stamps_are_true_or_nominal() -> None:
    true, nominal = (replace(hand(), sensor=Sensor(clock=Clock(jitter=0.2, stamps=one))) for one in ("true", "nominal"))
    (one, truth), other = true.record_with_truth(seed=2), nominal.record(seed=2)
    assert np.array_equal(other.t, np.arange(len(other)) / 100.0)
    jitter = (one.t - other.t) * 100.0
    assert jitter.std() == pytest.approx(0.2, rel=0.1)
    assert np.abs(jitter).max() <= 0.45 + 1e-9
    assert np.array_equal(one.t, truth.t)
    for name in ("gyr", "acc", "mag", "ref"):
        assert np.array_equal(getattr(one, name), getattr(other, name))
    assert integrated(one, true) < 1e-12  # gyr is the mean rate between the true times
    assert integrated(other, nominal) > 1e-4


# Magnetic disturbances.


def test_a_dipole_is_seen_at_its_place_and_falls_with_the_third_power() -> None:
    magnet = Dipole(position=(1.0, 2.0, 3.0), moment=(0.0, 0.0, 10.0))
    draw = np.random.default_rng(0)
    on_axis = magnet.field(np.zeros(2), np.array([[1.0, 2.0, 4.0], [1.0, 2.0, 5.0]]), draw)
    assert on_axis == pytest.approx(np.array([[0.0, 0.0, 2.0], [0.0, 0.0, 0.25]]))  # 2 µ₀m/4πr³
    beside = magnet.field(np.zeros(1), np.array([[2.0, 2.0, 3.0]]), draw)
    assert beside == pytest.approx(np.array([[0.0, 0.0, -1.0]]))
    assert np.isfinite(magnet.field(np.zeros(1), np.array([[1.0, 2.0, 3.0]]), draw)).all()


@pytest.mark.parametrize("one", [Dipole(position=(0.0, 0.0, -1.0), moment=(3.0, 4.0, 5.0)), IronFloor(seed=3)])
def test_fields_of_iron_have_neither_sources_nor_curl_outside_of_it(one: Any) -> None:
    place, h = np.random.default_rng(1).uniform(0.0, 1.0, (50, 3)), 1e-4
    gradient = np.stack(
        [
            (one.field(np.zeros(50), place + step, None) - one.field(np.zeros(50), place - step, None)) / (2.0 * h)
            for step in h * np.eye(3)
        ],
        axis=2,
    )
    # Of the second order in h, with third derivatives of some hundred µT/m³.
    assert np.abs(np.trace(gradient, axis1=1, axis2=2)).max() < 1e-5
    assert np.abs(gradient - gradient.transpose(0, 2, 1)).max() < 1e-5
    assert np.abs(gradient).max() > 0.1


def test_an_iron_floor_has_its_size_and_dies_out_upward() -> None:
    place = np.random.default_rng(1).uniform(-200.0, 200.0, (20_000, 3))
    place[:, 2] = 0.0
    field = [IronFloor(deviation=4.0, seed=s).field(place[:, 0], place, None) for s in range(4)]  # type: ignore[arg-type]
    assert np.sqrt(np.mean([np.sum(one**2, axis=1) for one in field])) == pytest.approx(4.0, rel=0.05)
    above = IronFloor(deviation=4.0).field(place[:, 0], place + np.array([0.0, 0.0, 2.0]), None)  # type: ignore[arg-type]
    assert np.sqrt(np.mean(np.sum(above**2, axis=1))) < 1.0


@pytest.mark.parametrize("rise", [0.0, 0.05])
def test_a_switched_field_turns_with_the_sensor_and_is_off_outside_its_time(rise: float) -> None:
    gripper = Switched(amplitude=(10.0, -5.0, 2.0), period=2.0, duty=0.25, start=4.0, end=12.0, rise=rise)
    recording, truth = replace(hand(), disturbances=(gripper,)).record_with_truth()
    assert truth.disturbance is not None
    on = (recording.t >= 4.0) & (recording.t < 12.0) & ((recording.t - 4.0) % 2.0 < 0.5)
    settled = np.array([4.45, 10.45])
    assert np.abs(truth.disturbance[recording.t < 4.0]).max() == 0.0
    assert np.abs(truth.disturbance[recording.t > 12.5]).max() < 20.0 * np.exp(-0.5 / 0.05)
    for time in settled:  # 9 time constants after switching on
        assert truth.disturbance[round(time * 100)] == pytest.approx([10.0, -5.0, 2.0], rel=2e-4)
    if rise == 0.0:
        assert np.array_equal(truth.disturbance != 0.0, np.repeat(on[:, None], 3, axis=1))
    assert np.abs(recording.mag - hand().record().mag - truth.disturbance).max() < 1e-13
    assert np.array_equal(recording.gyr, hand().record().gyr)


def test_a_current_that_is_switched_is_continuous() -> None:
    level = Switched(amplitude=(1.0, 0.0, 0.0), period=1.0, rise=0.3, end=5.3).level(np.arange(-1.0, 9.0, 1e-4))
    assert np.abs(np.diff(level)).max() < 1e-4 / 0.3 * 1.01
    assert level.min() >= 0.0
    assert level.max() < 1.0


def test_noise_of_a_switched_field_is_there_only_while_it_is_on() -> None:
    gripper = Switched(amplitude=(0.0, 0.0, 0.0), period=20.0, noise=3.0)
    field = gripper.field(np.arange(0.0, 20.0, 0.01), np.zeros((2000, 3)), np.random.default_rng(0))
    assert field[:1000].std() == pytest.approx(3.0, rel=0.05)
    assert np.abs(field[1000:]).max() == 0.0


def test_disturbances_add_up_and_earths_turn_with_the_attitude() -> None:
    both = (Dipole(position=(0.5, 0.5, 0.5), moment=(0.0, 1.0, 0.0)), IronFloor())
    setup = replace(hand(), disturbances=both)
    recording, truth = setup.record_with_truth()
    expected = sum(one.field(recording.t, truth.position, None) for one in both)  # type: ignore[arg-type]
    assert np.abs(rotation(recording.ref).apply(truth.disturbance) - expected).max() < 1e-12
    assert np.array_equal(recording.mag, setup.record().mag)


# Truth, meta, errors.


def test_readings_are_truth_bias_and_white_noise() -> None:
    sensor = simulate.SENSORS["rough"]
    sensor = replace(
        sensor,
        **{
            name: replace(
                getattr(sensor, name),
                density=0.0,
                noise=0.0,
                resolution=0.0,
                scale_deviation=0.0,
                gain_slope=0.0,
                dropout=0.0,
                rate=None,
            )
            for name in ("gyr", "acc", "mag")
        },
        g_sensitivity=0.0,
    )
    sensor = replace(
        sensor, **{name: replace(getattr(sensor, name), misalignment_deviation=0.0) for name in ("gyr", "acc", "mag")}
    )
    recording, truth = replace(hand(), sensor=sensor).record_with_truth(seed=2)
    for name in ("gyr", "acc", "mag"):
        assert np.abs(getattr(recording, name) - getattr(truth, name) - getattr(truth, f"{name}_bias")).max() < 1e-13
        assert np.ptp(getattr(truth, f"{name}_bias"), axis=0).min() > 0.0


@pytest.mark.parametrize("name", simulate.SCENARIOS)
def test_the_meta_tells_everything_and_survives_a_file(name: str, tmp_path: Path) -> None:
    recording = simulate.scenario(name, sensor="rough", duration=2.0, seed=4)
    recording.save(tmp_path / "a.npz")
    read = ar.read(tmp_path / "a.npz")
    for key, value in json.loads(json.dumps(recording.meta, allow_nan=False)).items():
        assert read.meta[key] == value
    assert recording.meta["simulation"] == name
    assert np.array_equal(read.gyr, recording.gyr, equal_nan=True)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Triad(density=-1.0), "density: expected a finite number that is not negative"),
        (lambda: Triad(bias=(1.0, 2.0)), "bias: expected a finite number, or three"),  # type: ignore[arg-type]
        (lambda: Triad(noise="loud"), "noise: expected a finite number"),  # type: ignore[arg-type]
        (lambda: Triad(matrix=((1.0,),)), r"matrix: expected a \(3, 3\) array"),  # type: ignore[arg-type]
        (lambda: Triad(instability_times=()), "instability_times: expected increasing positive numbers"),
        (lambda: Triad(instability_times=(2.0, 1.0)), "instability_times: expected increasing positive numbers"),
        (lambda: Triad(instability_times=(1.0, 2.0, 3.0)), "instability_times: expected times that rise by a constant"),
        (lambda: Triad(range=0.0), "range: expected a positive number or None"),
        (lambda: Triad(rate=-5.0), "rate: expected a positive number or None"),
        (lambda: Triad(dropout=1.5), "dropout: expected a finite number from 0 to 1, got 1.5"),
        (lambda: Triad(dropout_length=0.5), "dropout_length: expected a finite number from 1"),
        (lambda: Triad(resolution=float("nan")), "resolution: expected a finite number from 0"),
        (lambda: Triad().calibrated(2.0), "remaining: expected a finite number from 0 to 1"),
        (lambda: Temperature(time_constant=0.0), "time_constant: expected a positive number of s"),
        (lambda: Temperature(start=float("inf")), "start: expected a finite number"),
        (lambda: Clock(jitter=0.5), "jitter: expected a finite number from 0 to 0.25"),
        (lambda: Clock(stamps="late"), "stamps: expected 'true' or 'nominal', got 'late'"),
        (lambda: Sensor(gyr=Triad(rate=10.0)), "gyr.rate: a gyroscope is read in every row"),
        (lambda: Sensor(acc=1.0), "acc: expected a Triad"),  # type: ignore[arg-type]
        (lambda: Sensor(mag=1.0), "mag: expected a Triad or None"),  # type: ignore[arg-type]
        (lambda: Sensor(temperature=20.0), "temperature: expected a Temperature or None"),  # type: ignore[arg-type]
        (lambda: Sensor(mag_delay=-1.0), "mag_delay: expected a finite number from 0"),
        (lambda: Sensor(g_sensitivity=((1.0,),)), r"g_sensitivity: expected a \(3, 3\) array"),  # type: ignore[arg-type]
        (lambda: at_rest(Sensor(), 1.0, 0.0), "rate: expected a positive number"),
        (lambda: at_rest(Sensor(), 0.01, 100.0), "duration: expected at least two samples"),
        (lambda: replace(hand(), rates="median"), "rates: expected one of mean, instantaneous"),
        (lambda: replace(hand(), gravity=-1.0), "gravity: expected a positive number"),
        (lambda: replace(hand(), earth_field=np.zeros(2)), "earth_field: expected three finite numbers"),
        (lambda: replace(hand(), sensor="mpu9250"), "sensor: expected a Sensor"),
        (lambda: hand().record(-1), "seed: expected an integer that is not negative"),
        (lambda: at_rest(Sensor(clock=Clock(lost=1.0)), 1.0, 10.0).record(), "clock.lost: fewer than two rows"),
        (lambda: simulate.scenario("moon"), "scenario: unknown 'moon'; there are demo, static"),
        (lambda: simulate.scenario("demo", sensor="moon"), "sensor: unknown 'moon'; there are ideal"),
        (lambda: simulate.scenario("demo", rate=-1.0), "rate: expected a positive number"),
        (lambda: simulate.scenario("demo", seed=-1), "seed: expected an integer that is not negative"),
        (
            lambda: simulate.scenario("static", yawn=1.0),
            r"static has no parameter 'yawn' \(did you mean yaw\?\); there are",
        ),
        (lambda: simulate.scenario("static", roll="up"), "roll: expected a value like 0.0, got 'up'"),
        (lambda: simulate.scenario("static", roll=float("nan")), "roll: expected a finite number"),
        (lambda: simulate.scenario("walking", place="knee"), "place: expected 'pelvis' or 'foot', got 'knee'"),
        (lambda: simulate.scenario("robot_arm", speed=0.0), "speed: expected a positive number"),
        (lambda: simulate.scenario("vibration", acc=-1.0), "acc: expected a number that is not negative"),
        (lambda: simulate.scenario("way_points", turn=3.0), "orientations: the turns between way points are too large"),
    ],
)
def test_impossible_arguments_are_refused_by_name(call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()
