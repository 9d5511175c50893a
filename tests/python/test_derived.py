"""What follows from attitudes: against differences of a simulated truth, other packages, and perturbed attitudes."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import _quat
from calibrated import FloatArray
from commands import Capture, error_of, output_of, saved

RATE = 1000.0
PLACE = 9.83  # gravity of a place near a pole, m/s²


def truth(frame: str = "ENU", seed: int = 0) -> tuple[ar.Recording, ar.simulate.Truth, ar.Estimate]:
    """A motion that turns and moves, exactly measured, with the true attitudes as an estimate."""
    random = np.random.default_rng(seed)
    path = ar.simulate.spline(random.uniform(-1.0, 1.0, (9, 3)), 1.0)
    motion = ar.simulate.SplineMotion.through_turns(random.uniform(-0.8, 0.8, (8, 3)), 1.0, path)
    setup = ar.simulate.Setup(motion=motion, rate=RATE, duration=8.0, gravity=PLACE, rates="instantaneous")
    rec, exact = setup.record_with_truth()
    assert rec.ref is not None
    return rec, exact, estimate(_quat.multiply(np.asarray(FROM_ENU[frame])[None], rec.ref), rec.t, frame=frame)


#: The rotations from east-north-up: half a turn about (1, 1, 0), and a quarter turn back about the vertical.
HALF = np.sqrt(0.5)
FROM_ENU = {"ENU": (1.0, 0.0, 0.0, 0.0), "NED": (0.0, HALF, HALF, 0.0), "NWU": (HALF, 0.0, 0.0, -HALF)}


def estimate(quat: FloatArray, t: FloatArray, *, bias: Any = None, frame: str = "ENU", **extra: Any) -> ar.Estimate:
    status = np.zeros(quat.shape[:-1], dtype=np.uint16)
    return ar.Estimate(quat, bias, status, t, None, MappingProxyType(extra), frame)


@pytest.mark.parametrize("frame", FROM_ENU)
def test_linear_acceleration_is_the_second_difference_of_the_position(frame: str) -> None:
    rec, exact, est = truth(frame)
    found = est.linear_acceleration(rec.acc, gravity=PLACE)
    second = np.zeros_like(exact.position)
    second[1:-1] = (exact.position[2:] - 2 * exact.position[1:-1] + exact.position[:-2]) * RATE**2
    expected = _quat.rotate(np.broadcast_to(FROM_ENU[frame], est.quat.shape), second)
    # The third derivative of a cubic spline leaps at its knots: half of a leap of some 30 m/s³ over a step of 1 ms.
    inner = slice(50, -50)
    assert np.abs(expected[inner]).max() > 1.0
    assert np.abs(found - expected)[inner].max() < 0.05
    assert np.median(np.abs(found - expected)[inner]) < 1e-6
    in_sensor = est.linear_acceleration(rec.acc, "sensor", gravity=PLACE)
    assert np.allclose(_quat.rotate(est.quat, in_sensor), found, rtol=0, atol=1e-12)
    assert np.allclose(in_sensor + est.gravity(PLACE), rec.acc, rtol=0, atol=1e-12)


@pytest.mark.parametrize("frame", FROM_ENU)
def test_the_turn_rate_is_the_difference_of_the_attitudes(frame: str) -> None:
    rec, _, est = truth(frame)
    bias = np.array([0.1, -0.2, 0.05])
    assert rec.gyr is not None
    est = dataclasses.replace(est, gyr_bias=np.broadcast_to(bias, rec.gyr.shape))
    step = _quat.log(_quat.multiply(_quat.conjugate(est.quat[:-2]), est.quat[2:])) * (0.5 * RATE)
    found = est.turn_rate(rec.gyr + bias)
    # The second derivative of the rate over six times the square of a step of 1 ms: 30 rad/s³ at most here.
    assert np.abs(found[1:-1] - step)[50:-50].max() < 2e-5
    assert np.allclose(est.turn_rate(rec.gyr + bias, "earth"), _quat.rotate(est.quat, found), rtol=0, atol=1e-12)
    without = dataclasses.replace(est, gyr_bias=None)
    assert np.array_equal(without.turn_rate(rec.gyr), rec.gyr)


@pytest.mark.parametrize("frame", FROM_ENU)
def test_heading_and_inclination_are_those_of_the_compass_in_every_frame(frame: str) -> None:
    # An attitude by its heading, then pitch up, in words of the compass: x points north-east, 30° up.
    turn = _quat.about_axis(2, np.array([np.pi / 4]))  # east to north, from x east: heading 45°
    pitched = _quat.multiply(turn, _quat.about_axis(1, np.array([-np.pi / 6])))
    est = estimate(_quat.multiply(np.asarray(FROM_ENU[frame])[None], pitched), np.zeros(1), frame=frame)
    assert est.heading(degrees=True) == pytest.approx([45.0], abs=1e-12)
    expected = 150.0 if frame == "NED" else 30.0  # its z axis is to be down
    assert est.inclination(degrees=True) == pytest.approx([expected], abs=1e-12)
    assert est.heading() == pytest.approx([np.pi / 4], abs=1e-14)


@pytest.mark.parametrize("heading", [0.0, 1.0, 90.0, 179.0, 181.0, 270.0, 359.0])
def test_headings_go_around_the_compass(heading: float) -> None:
    quat = _quat.about_axis(2, np.deg2rad([90.0 - heading]))
    for dtype, size in ((np.float64, 1e-12), (np.float32, 1e-4)):
        found = estimate(quat.astype(dtype), np.zeros(1)).heading(degrees=True)
        assert found.dtype == dtype
        assert 0.0 <= found[0] < 360.0
        assert (found[0] - heading + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=size)


def test_the_heading_of_a_vertical_axis_is_none_and_its_deviation_infinite() -> None:
    up = _quat.about_axis(1, np.array([-np.pi / 2]))
    est = estimate(up, np.zeros(1), covariance=1e-4 * np.eye(3)[None])
    assert est.heading()[0] == 0.0
    assert est.heading_std()[0] == np.inf
    level = estimate(_quat.about_axis(2, np.array([0.3])), np.zeros(1), covariance=np.diag([4e-4, 9e-4, 1.0])[None])
    assert level.inclination_std() == pytest.approx([0.03], rel=1e-9)  # the worst direction


def test_deviations_are_those_of_perturbed_attitudes() -> None:
    random = np.random.default_rng(3)
    for frame in FROM_ENU:
        quat = random.standard_normal(4)
        quat /= np.linalg.norm(quat)
        root = 1e-3 * random.standard_normal((3, 3))
        est = estimate(quat[None], np.zeros(1), frame=frame, covariance=(root @ root.T)[None])
        # Errors of the attitude in the sensor frame: q exp(d).
        errors = random.standard_normal((40_000, 3)) @ root.T
        many = estimate(_quat.multiply(quat[None], _quat.exp(errors)), np.zeros(40_000), frame=frame)
        heading = np.angle(np.exp(1j * (many.heading() - est.heading())))
        # The spread of 40,000 numbers is known to 0.35 %: five deviations, and the second order of errors of 3e-3.
        assert est.heading_std()[0] == pytest.approx(heading.std(), rel=0.02)
        assert est.inclination_std()[0] == pytest.approx((many.inclination() - est.inclination()).std(), rel=0.02)


def test_a_filters_deviations_are_of_the_size_of_its_errors() -> None:
    rec = ar.simulate.demo(duration=60.0, rate=100.0, seed=2)
    est = ar.MEKF(rate=100.0).run(rec, outputs=["covariance"])
    exact = estimate(np.asarray(rec.ref), rec.t)
    error = np.angle(np.exp(1j * (est.heading() - exact.heading())))[1000:]
    ratio = error / est.heading_std()[1000:]
    # One recording: errors are correlated over seconds, and the filter's noise is not quite the simulated one.
    assert 0.1 < np.sqrt(np.mean(ratio**2)) < 5.0


def test_rotation_vectors_are_scipys() -> None:
    rotation = pytest.importorskip("scipy.spatial.transform").Rotation
    quat = np.random.default_rng(4).standard_normal((100, 4))
    quat /= np.linalg.norm(quat, axis=1, keepdims=True)
    est = estimate(quat, np.arange(100.0))
    assert np.allclose(est.rotation_vector(), rotation.from_quat(quat[:, [1, 2, 3, 0]]).as_rotvec(), rtol=0, atol=1e-12)


def test_gravity_and_accelerations_are_imufusions() -> None:
    imufusion = pytest.importorskip("imufusion")
    rec = ar.simulate.demo(duration=10.0, rate=100.0, seed=1)
    other = imufusion.Ahrs()
    other.set_settings(imufusion.AhrsSettings(convention=imufusion.CONVENTION_ENU))
    rows: dict[str, list[Any]] = {"quat": [], "gravity": [], "linear": [], "earth": []}
    assert rec.acc is not None
    assert rec.gyr is not None
    for gyr, acc in zip(np.rad2deg(rec.gyr), rec.acc / ar.calibration.GRAVITY, strict=True):
        other.update_no_magnetometer(gyr, acc)
        rows["quat"].append(other.get_quaternion())
        rows["gravity"].append(other.get_gravity())
        rows["linear"].append(other.get_linear_acceleration())
        rows["earth"].append(other.get_earth_acceleration())
    est = estimate(np.array(rows["quat"], dtype=np.float64), rec.t)
    # Theirs are float32, in g: 1e-7 of some tens of m/s².
    for name, mine in (
        ("gravity", est.gravity()),
        ("linear", est.linear_acceleration(rec.acc, "sensor")),
        ("earth", est.linear_acceleration(rec.acc)),
    ):
        assert np.abs(ar.calibration.GRAVITY * np.array(rows[name]) - mine).max() < 1e-4, name


def test_several_recordings_side_by_side_are_as_each_alone() -> None:
    recs = [ar.simulate.demo(duration=3.0, rate=100.0, seed=k) for k in range(3)]
    f = ar.MEKF(rate=100.0)
    acc, gyr = (np.stack([getattr(rec, name) for rec in recs]) for name in ("acc", "gyr"))
    many = f.run(gyr, acc, np.stack([rec.mag for rec in recs]), outputs=["covariance"])
    for k, rec in enumerate(recs):
        one = f.run(rec.gyr, rec.acc, rec.mag, outputs=["covariance"])
        for call in (
            lambda e: e.heading(),
            lambda e: e.heading_std(),
            lambda e: e.inclination(),
            lambda e: e.inclination_std(),
            lambda e: e.gravity(),
            lambda e: e.rotation_vector(),
        ):
            assert np.array_equal(call(many)[k], call(one))
        assert np.array_equal(many.turn_rate(gyr)[k], one.turn_rate(rec.gyr))
        assert np.array_equal(many.linear_acceleration(acc)[k], one.linear_acceleration(rec.acc))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda e: e.turn_rate(np.zeros((3, 3))), r"gyr: expected shape \(2, 3\), got \(3, 3\)"),
        (lambda e: e.turn_rate(np.zeros((2, 3)), "body"), "frame: expected one of 'sensor', 'earth', got 'body'"),
        (lambda e: e.linear_acceleration(np.zeros((2, 3)), "body"), "frame: expected one of 'earth', 'sensor'"),
        (
            lambda e: e.heading_std(),
            r"covariance: expected an estimate of run\(\.\.\., outputs=\[.*got one with no outputs",
        ),
        (lambda e: e.gravity("strong"), "gravity: expected a number, got 'strong'"),
        (lambda e: e.save("a.csv", outputs=["headin"]), r"outputs: .*, got 'headin' \(did you mean heading\?\)"),
        (lambda e: e.save("a.csv", outputs=["turn_rate"]), "recording: needed for the output turn_rate, got None"),
        (lambda e: e.save("a.tum", outputs=["heading"]), r"outputs: expected none in \.tum"),
    ],
)
def test_what_does_not_follow_is_told(call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call(estimate(np.tile([1.0, 0.0, 0.0, 0.0], (2, 1)), np.arange(2.0)))


def test_the_command_writes_what_is_asked_for(tmp_path: Path, capsys: Capture) -> None:
    path = saved(tmp_path / "a.npz")
    rec = ar.read(path)
    names = "gravity,linear_acceleration,linear_acceleration_sensor,turn_rate,heading,heading_std,inclination"
    names += ",inclination_std,rotation_vector"
    out = tmp_path / "b.npz"
    output_of(capsys, "run", path, "--filter", "mekf", "--outputs", names, "--gravity", 9.81, "--degrees", "-o", out)
    est = ar.MEKF(rate=rec.rate).run(rec, outputs=["covariance"])
    with np.load(out) as found:
        assert np.array_equal(found["gravity"], est.gravity(9.81))
        assert np.array_equal(found["linear_acceleration"], est.linear_acceleration(rec.acc, gravity=9.81))
        assert np.array_equal(
            found["linear_acceleration_sensor"], est.linear_acceleration(rec.acc, "sensor", gravity=9.81)
        )
        assert np.array_equal(found["turn_rate_deg_s"], np.rad2deg(est.turn_rate(rec.gyr)))
        assert np.array_equal(found["heading_deg"], est.heading(degrees=True))
        assert np.array_equal(found["heading_std_deg"], est.heading_std(degrees=True))
        assert np.array_equal(found["inclination_deg"], est.inclination(degrees=True))
        assert np.array_equal(found["inclination_std_deg"], est.inclination_std(degrees=True))
        assert np.array_equal(found["rotation_vector"], est.rotation_vector())
    output_of(capsys, "run", path, "--filter", "madgwick", "--outputs", "heading,gravity", "-o", tmp_path / "c.csv")
    header = (tmp_path / "c.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header.endswith("heading,gravity_x,gravity_y,gravity_z,status")
    said = error_of(capsys, "run", path, "--filter", "madgwick", "--outputs", "heading_std", "-o", tmp_path / "d.csv")
    assert said == "--outputs: heading_std: expected a filter with a covariance, got Madgwick"
