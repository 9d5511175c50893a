"""The scenarios keep the papers' protocols, and the command line writes them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import metrics, simulate
from ahrs_rs.simulate import SCENARIOS, SENSORS, Setup
from commands import Capture, error_of, output_of

DEGREE = np.pi / 180.0


def exact(name: str, **params: Any) -> tuple[Setup, ar.Recording]:
    setup = SCENARIOS[name].setup(sensor="ideal", **params)
    return setup, setup.record()


def during(recording: ar.Recording, phase: str) -> np.ndarray:
    """(T,) which samples are in a phase, without its first and last step."""
    inside = np.zeros(len(recording), dtype=bool)
    for start, end in recording.meta["phases"][phase]:
        inside |= (recording.t > start + 0.02) & (recording.t < end - 0.02)
    assert inside.any()
    return inside


@pytest.mark.parametrize(
    ("name", "options", "samples", "rate"),
    [
        ("quadrotor", {}, 6401, 100.0),
        ("moving_hand", {}, 2000, 160.0),
        ("static", {"sensor": "mpu6050", "rate": 160.0, "duration": 12.5}, 2000, 160.0),
        ("warm_up", {}, 120_000, 50.0),
    ],
)
def test_recordings_have_the_papers_numbers_of_samples(
    name: str, options: dict[str, Any], samples: int, rate: float
) -> None:
    recording = simulate.scenario(name, **options)
    assert (len(recording), recording.rate) == (samples, rate)


def test_rates_are_those_of_the_papers() -> None:
    expected = {
        "robot_arm": 500,
        "back_and_forth": 200,
        "vibration": 200,
        "rotation_test": 150,
        "acceleration_test": 150,
    }
    assert {name: SCENARIOS[name].rate for name in expected} == expected


@pytest.mark.parametrize("speed", [18.0, 45.0])
def test_the_robot_arm_turns_each_axis_alone_with_the_mean_speed_then_all(speed: float) -> None:
    _, recording = exact("robot_arm", speed=speed * DEGREE)
    angles = np.degrees(metrics.euler(recording.ref))
    for axis, name in enumerate(("roll", "pitch", "yaw")):
        inside = during(recording, name)
        others = [i for i in range(3) if i != axis]
        assert np.abs(angles[inside][:, others]).max() < 1e-12
        assert np.ptp(angles[inside][:, axis]) == pytest.approx(60.0, abs=1e-3)
        assert np.mean(np.abs(np.degrees(recording.gyr[inside, axis]))) == pytest.approx(speed, rel=0.03)
    assert np.ptp(angles[during(recording, "combined")], axis=0) == pytest.approx([60.0] * 3, abs=1e-3)
    assert np.abs(recording.gyr[during(recording, "static")]).max() < 1e-12
    assert recording.duration == pytest.approx(12.0 + 480.0 / speed, abs=0.01)


def test_the_gripper_disturbs_the_magnetometer_alone() -> None:
    free, disturbed = (simulate.scenario("robot_arm", gripper=size, seed=3) for size in (0.0, 20.0))
    assert np.array_equal(free.gyr, disturbed.gyr)
    assert np.array_equal(free.acc, disturbed.acc)
    read = ~np.isnan(free.mag).any(axis=1)
    assert 0.43 < read.mean() < 0.45  # 220 of 500 Hz
    difference = np.linalg.norm((disturbed.mag - free.mag)[read], axis=1)
    assert np.median(difference[(free.t[read] % 2.0 > 0.3) & (free.t[read] % 2.0 < 1.0)]) == pytest.approx(
        22.0, rel=0.15
    )
    assert np.median(difference[free.t[read] % 2.0 > 1.5]) < 0.2


@pytest.mark.parametrize("bank", [0.0, 15.0])
def test_back_and_forth_accelerates_as_asked_at_the_banked_attitudes(bank: float) -> None:
    setup, recording = exact("back_and_forth", bank=bank * DEGREE, acceleration=4.0)
    inside = during(recording, "accelerating")
    acceleration = setup.motion.acceleration(recording.t)
    assert np.abs(acceleration).max(axis=0) == pytest.approx([4.0] * 3, rel=1e-3)
    # The 20 ms at the ends of a phase: the rise of a rise that lasts 250 ms.
    assert np.abs(acceleration[~inside]).max() < 0.5
    angles = np.degrees(metrics.euler(recording.ref[inside]))
    banked = {(round(roll, 6), round(pitch, 6)) for roll, pitch, _ in angles}
    assert banked == ({(bank, 0.0), (0.0, bank)} if bank else {(0.0, 0.0)})
    assert np.abs(recording.gyr[inside]).max() < 1e-12


def test_vibration_has_the_stated_root_mean_square_and_turns_nothing_for_long() -> None:
    setup, recording = exact("vibration", acc=3.0, gyr=15.0 * DEGREE)
    t = np.arange(0.0, 20.0, 1e-4)
    # Sines of close frequencies beat with periods of up to some seconds.
    assert np.sqrt(np.mean(setup.motion.acceleration(t) ** 2, axis=0)) == pytest.approx([3.0] * 3, rel=0.05)
    assert np.sqrt(np.mean(setup.motion.angular_rate(t) ** 2, axis=0)) == pytest.approx([15.0 * DEGREE] * 3, rel=0.05)
    assert np.degrees(metrics.inclination_error(recording.ref, np.array([1.0, 0.0, 0.0, 0.0])).max()) < 0.15


def test_the_quadrotor_flies_around_a_rectangle_and_its_heading_passes_180_degrees() -> None:
    setup, recording = exact("quadrotor", acc=0.0, gyr=0.0)
    place = setup.motion.position(recording.t)
    assert np.ptp(place, axis=0) == pytest.approx([5.0, 4.0, 1.5], abs=1e-6)
    assert place[-1] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    angles = np.degrees(metrics.euler(recording.ref))
    assert np.abs(np.diff(angles[:, 2])).max() > 350.0
    assert 3.0 < np.abs(angles[:, :2]).max() < 30.0
    # The accelerometer of a body that is carried by its thrust feels nothing across it.
    assert np.abs(recording.acc[:, :2]).max() < 1e-12


def test_the_rotation_test_drives_one_path_four_times_at_halved_speeds() -> None:
    setup, recording = exact("rotation_test", rate=300.0)
    runs = [during(recording, f"run_{k}") for k in range(1, 5)]
    peaks = [np.linalg.norm(recording.gyr[run], axis=1).max() for run in runs]
    assert np.divide(peaks[:-1], peaks[1:]) == pytest.approx([2.0] * 3, rel=0.01)
    assert 60.0 < np.degrees(peaks[0]) < 200.0
    extent = [np.ptp(metrics.euler(recording.ref[run]), axis=0) for run in runs]
    assert all(np.allclose(one, extent[0], atol=0.02) for one in extent)
    assert np.abs(setup.motion.acceleration(recording.t)).max() > 0.3  # in 6D


def test_the_acceleration_test_moves_one_axis_at_a_time_at_halved_speeds() -> None:
    setup, recording = exact("acceleration_test")
    velocity = setup.motion.velocity(recording.t)
    for axis, name in enumerate("xyz"):
        inside = during(recording, name)
        assert np.abs(velocity[inside][:, axis]).max() == pytest.approx(1.0, rel=0.01)
        assert np.abs(np.delete(velocity[inside], axis, axis=1)).max() == 0.0
        assert np.sum(np.diff((np.abs(velocity[inside][:, axis]) > 0.05).astype(int)) == 1) >= 8
    assert np.degrees(metrics.total_error(recording.ref, recording.ref[0])).max() < 0.8


def test_an_added_gyroscope_bias_is_added_to_every_axis() -> None:
    plain, biased = (simulate.scenario("acceleration_test", seed=2, gyr_bias=bias) for bias in (0.0, 7.0 * DEGREE))
    # Both are rounded to the steps of the sensor's resolution.
    assert np.abs(biased.gyr - plain.gyr - 7.0 * DEGREE).max() <= SENSORS["inertialink"].gyr.resolution * 1.0001
    assert np.array_equal(plain.acc, biased.acc)


def test_the_cooled_sensor_warms_up_and_its_bias_with_it() -> None:
    recording = simulate.scenario("warm_up", rate=10.0)
    assert recording.temperature is not None
    assert recording.temperature[0] == pytest.approx(15.0, abs=0.1)
    assert recording.temperature[-1] == pytest.approx(35.0, abs=0.5)
    slope = [np.polyfit(recording.temperature, np.degrees(recording.gyr[:, i]), 1)[0] for i in range(3)]
    # Table 4; the noise of 24,000 samples leaves 1e-4 °/s per °C and flicker noise of 10 °/h up to 4e-4.
    assert slope == pytest.approx([-0.01188330, -0.00845710, 0.00542382], abs=1e-3)


def test_a_walkers_pelvis_bounces_twice_a_stride_and_a_foot_rests_in_every_stance() -> None:
    setup, _ = exact("walking", heel=0.0)
    t = np.arange(10.0, 40.0, 0.01)
    vertical = setup.motion.acceleration(t)[:, 2]
    spectrum = np.abs(np.fft.rfft(vertical * np.hanning(len(vertical))))
    assert np.fft.rfftfreq(len(t), 0.01)[spectrum.argmax()] == pytest.approx(1.8, abs=0.04)  # steps/s
    assert np.linalg.norm(setup.motion.velocity(t)[:, :2], axis=1).mean() == pytest.approx(1.4, rel=0.05)
    setup, recording = exact("walking", place="foot")
    speed = np.linalg.norm(setup.motion.velocity(t), axis=1)
    assert 0.3 < np.mean(speed < 1e-6) < 0.6
    assert setup.motion.velocity(t)[:, 0].mean() == pytest.approx(1.4, rel=0.05)
    assert np.degrees(np.linalg.norm(recording.gyr, axis=1)).max() > 300.0


def test_iron_beside_the_way_is_passed() -> None:
    _, truth = SCENARIOS["walking"].with_truth(iron=50.0, sensor="ideal")
    assert truth.disturbance is not None
    size = np.linalg.norm(truth.disturbance, axis=1)
    assert size.max() > 3.0
    assert size.min() < 0.3


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario_can_be_filtered(name: str) -> None:
    recording = simulate.scenario(name, duration=30.0, seed=1, sensor="mpu9250", remaining=0.0)
    est = ar.VQF(rate=recording.rate).run(recording.gyr, recording.acc, recording.mag, t=recording.t)
    # Far more than VQF errs under acceleration and vibration, far less than with a wrong axis, sign or unit.
    assert metrics.score(est.quat, recording.ref, recording.mask).inclination < 5.0


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_parameter_is_documented(name: str) -> None:
    scenario = SCENARIOS[name]
    for param in scenario.params:
        assert f"`{param}`" in scenario.doc or param in ("roll", "pitch", "yaw", "interval"), param


# The command line.


def test_the_command_writes_what_the_function_gives(capsys: Capture, tmp_path: Path) -> None:
    file = tmp_path / "arm.npz"
    scenario = ["simulate", "--scenario", "robot_arm", "--set", "speed=45deg", "--set", "gripper=20", "--seed", "3"]
    sensor = ["--sensor", "rough", "--remaining", "0.5", "--gyr-bias", "1deg", "--rate", "250", "--duration", "8"]
    printed = output_of(capsys, *scenario, *sensor, "-o", file)
    assert str(file) in printed
    read = ar.read(file)
    expected = simulate.scenario(
        "robot_arm", speed=45 * DEGREE, gripper=20.0, seed=3, sensor="rough", remaining=0.5, gyr_bias=DEGREE,
        rate=250.0, duration=8.0,
    )  # fmt: skip
    for name in ("t", "gyr", "acc", "mag", "ref", "temperature"):
        assert np.array_equal(getattr(read, name), getattr(expected, name), equal_nan=True)
    assert read.rate == 250.0


def test_the_list_names_every_scenario_parameter_and_sensor(capsys: Capture) -> None:
    printed = output_of(capsys, "simulate", "--list")
    for name, scenario in SCENARIOS.items():
        assert name in printed
        assert all(f"{param}=" in printed for param in scenario.params)
    assert all(name in printed for name in SENSORS)


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario_can_be_written(name: str, capsys: Capture, tmp_path: Path) -> None:
    output_of(capsys, "simulate", "--scenario", name, "--duration", 2, "-o", tmp_path / "a.npz")
    assert ar.read(tmp_path / "a.npz").meta["simulation"] == name


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("--scenario moon -o a.npz", "--scenario: unknown 'moon'; there are demo, static"),
        ("--scenario demo", "-o: expected a file to write to"),
        ("--scenario demo -o a.csv", "-o: expected a name that ends in .npz, got 'a.csv'"),
        ("--scenario demo -o nowhere/a.npz", "there is no directory"),
        ("--scenario static -o a.npz --set rol=1", "static has no parameter 'rol' (did you mean roll?)"),
        ("--scenario static -o a.npz --set roll=up", "static.roll: expected a number, got 'up'"),
        ("--scenario walking -o a.npz --set place=knee", "place: expected 'pelvis' or 'foot'"),
        ("--scenario demo -o a.npz --seed -1", "seed: expected an integer that is not negative"),
        ("--scenario demo -o a.npz --remaining 2", "remaining: expected a finite number from 0 to 1"),
        ("--scenario demo -o a.npz --rate 1e9", "are over 50,000,000 samples"),
        ("--scenario demo -o a.npz --sensor moon", "argument --sensor: invalid choice: 'moon'"),
        ("--scenario demo --list", "not allowed with argument --scenario"),
        ("", "one of the arguments --scenario --list is required"),
    ],
)
def test_wrong_arguments_are_told_in_one_line(
    arguments: str, message: str, capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert message in error_of(capsys, "simulate", *arguments.split())
    assert not list(tmp_path.iterdir())
