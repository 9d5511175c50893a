"""Laws of `metrics.align`: planted rotations and offsets come back, and what motion does not show is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import ahrs_rs as ar
from ahrs_rs import metrics
from commands import DATA, needs_data
from signals import about_z, angle_between, conjugate, multiply, quats, random_turns, turns_by

FloatArray = NDArray[np.float64]

RATE = 100.0
#: Gauss-Newton ends where the mean square falls by 1e-9 of itself: without noise that is at rounding, some 1e-8 rad.
EXACT = 1e-7


def motion(seed: int = 0, duration: float = 30.0) -> ar.Recording:
    return ar.simulate.demo(duration, RATE, seed, noise=False)


def truth(seed: int = 0, duration: float = 30.0) -> FloatArray:
    ref = motion(seed, duration).ref
    assert ref is not None
    return ref


def shifted(recording_seed: int, samples: float) -> tuple[FloatArray, FloatArray]:
    """Reference and the estimate of the same motion that is late by a part of samples: both at the same stamps."""
    fine = ar.simulate.demo(30.0, 40.0 * RATE, recording_seed, noise=False).ref
    assert fine is not None
    late = round(40 * samples)
    first = max(late, 0)
    ref, est = fine[first::40], fine[first - late :: 40]
    count = min(len(ref), len(est))
    return ref[:count], est[:count]


@pytest.mark.parametrize("seed", range(5))
def test_planted_rotations_come_back(seed: int) -> None:
    ref = truth(seed)
    earth, sensor = quats(random_turns(2, seed))
    est = multiply(multiply(conjugate(earth), ref), conjugate(sensor))
    found = metrics.align(est, ref, rate=RATE)
    assert found.determined
    assert angle_between(found.q_earth, earth) < EXACT
    assert angle_between(found.q_sensor, sensor) < EXACT
    assert abs(found.time_offset) < EXACT  # the rates are about 1 rad/s
    assert found.largest < 10 * EXACT
    assert angle_between(found.apply(est), ref)[1:-1].max() < 10 * EXACT


@pytest.mark.parametrize("samples", [-37.5, -3.25, 0.5, 2.75, 60.0])
def test_planted_offset_comes_back_to_a_part_of_a_sample(samples: float) -> None:
    ref, est = shifted(1, samples)
    earth, sensor = quats(random_turns(2, 7))
    est = multiply(multiply(earth, est), sensor)
    found = metrics.align(est, ref, rate=RATE)
    # Between samples the rate changes by up to 20 rad/s² · 0.01 s, which slerp does not know: 3e-4 rad at the worst
    # place, of both signs, against rates of 1 rad/s.
    assert found.time_offset == pytest.approx(samples / RATE, abs=1e-4)
    assert found.rms < 3e-4
    assert angle_between(found.q_sensor, conjugate(sensor)) < 1e-3
    aligned = found.apply(est)
    known = ~np.isnan(aligned).any(axis=1)
    assert len(ref) - known.sum() == pytest.approx(abs(samples), abs=1.0)
    assert angle_between(aligned[known], ref[known]).max() == pytest.approx(found.largest, abs=EXACT)


@pytest.mark.parametrize("seed", range(3))
def test_noise_moves_the_result_by_its_mean_only(seed: int) -> None:
    ref = truth(seed)
    earth, sensor = quats(random_turns(2, seed + 10))
    noise = 0.02 * np.random.default_rng(seed).standard_normal((len(ref), 3))
    est = multiply(multiply(multiply(conjugate(earth), ref), quats_of(noise)), conjugate(sensor))
    found = metrics.align(est, ref, time=False)
    # 0.02 rad per axis over 3000 samples is 4e-4; excursions of 0.5 rad and more between the frames: five of that.
    assert angle_between(found.q_earth, earth) < 2e-3
    assert angle_between(found.q_sensor, sensor) < 2e-3
    assert found.rms == pytest.approx(0.02 * math.sqrt(3), rel=0.03)  # 9000 numbers: 1 % and a little
    assert found.median < found.rms < found.largest
    assert found.samples == len(ref)


def quats_of(vector: FloatArray) -> FloatArray:
    angle = np.linalg.norm(vector, axis=1, keepdims=True)
    return np.concatenate((np.cos(angle / 2), np.sin(angle / 2) * vector / angle), axis=1)


@pytest.mark.parametrize("seed", range(3))
def test_turned_frames_turn_the_result_and_leave_the_residuals(seed: int) -> None:
    """align(p ⊗ q ⊗ s, p' ⊗ ref ⊗ s') is p' ⊗ earth ⊗ p* and s* ⊗ sensor ⊗ s'."""
    recording = ar.simulate.demo(30.0, RATE, seed)
    est = ar.Mahony(rate=RATE).run(recording.gyr, recording.acc, recording.mag).quat
    assert recording.ref is not None
    plain = metrics.align(est, recording.ref, recording.mask, rate=RATE)
    p, s, other_p, other_s = quats(random_turns(4, seed + 20))
    turned = metrics.align(
        multiply(multiply(p, est), s),
        multiply(multiply(other_p, recording.ref), other_s),
        recording.mask,
        rate=RATE,
    )
    # Both end where the mean square changes by less than 1e-9 of itself: 3e-5 of an error of some hundredths of a rad.
    assert turned.rms == pytest.approx(plain.rms, rel=1e-8)
    assert turned.time_offset == pytest.approx(plain.time_offset, abs=1e-5)
    assert angle_between(turned.q_earth, multiply(multiply(other_p, plain.q_earth), conjugate(p))) < 1e-5
    assert angle_between(turned.q_sensor, multiply(multiply(conjugate(s), plain.q_sensor), other_s)) < 1e-5


def test_no_other_rotation_or_offset_leaves_less() -> None:
    recording = ar.simulate.demo(30.0, RATE, 3)
    est = ar.Madgwick(rate=RATE).run(recording.gyr, recording.acc, recording.mag).quat
    assert recording.ref is not None
    found = metrics.align(est, recording.ref, time=False)
    for turn in quats(turns_by(1e-3, 20, 0)):
        for earth, sensor in ((turn, None), (None, turn)):
            q = found.apply(est)
            moved = multiply(earth, q) if sensor is None else multiply(q, sensor)
            assert metrics.rmse(metrics.total_error(moved, recording.ref)) > found.rms


@pytest.mark.parametrize("seed", range(3))
def test_heading_between_earth_frames_is_enough_where_both_have_z_up(seed: int) -> None:
    ref = truth(seed)
    heading = about_z(2.0 + seed)
    (sensor,) = quats(random_turns(1, seed))
    est = multiply(multiply(conjugate(heading), ref), conjugate(sensor))
    found = metrics.align(est, ref, rate=RATE, earth="heading")
    assert found.q_earth[1:3] == pytest.approx([0.0, 0.0], abs=0)
    assert angle_between(found.q_earth, heading) < EXACT
    assert angle_between(found.q_sensor, sensor) < EXACT


def test_what_is_not_asked_for_is_the_identity() -> None:
    ref = truth()
    (turn,) = quats(turns_by(0.1, 1, 0))
    identity = [1.0, 0.0, 0.0, 0.0]
    earth = metrics.align(multiply(conjugate(turn), ref), ref, sensor=False, time=False)
    assert angle_between(earth.q_earth, turn) < EXACT
    assert earth.q_sensor.tolist() == identity
    sensor = metrics.align(multiply(ref, conjugate(turn)), ref, earth="none", time=False)
    assert angle_between(sensor.q_sensor, turn) < EXACT
    assert sensor.q_earth.tolist() == identity
    nothing = metrics.align(multiply(ref, turn), ref, earth="none", sensor=False, time=False)
    assert nothing.rms == pytest.approx(0.1, abs=EXACT)
    assert nothing.time_offset == 0.0


def test_tilting_to_and_fro_gives_the_sensor_frame_where_the_vertical_is_shared() -> None:
    angle = np.sin(np.arange(1000) * 0.03)
    ref = quats_of(np.stack((angle + 1e-9, 0 * angle, 0 * angle), axis=1))
    (sensor,) = quats(random_turns(1, 4))
    est = multiply(multiply(about_z(-1.0), ref), conjugate(sensor))
    with pytest.raises(ValueError, match="the sensor turns about one axis only"):
        metrics.align(est, ref, time=False)
    found = metrics.align(est, ref, time=False, earth="heading")
    assert angle_between(found.q_sensor, sensor) < EXACT
    free = metrics.align(est, ref, time=False, check=False)
    assert not free.determined
    assert free.rms < EXACT


def test_missing_and_masked_rows_do_not_count() -> None:
    ref = truth()
    earth, sensor = quats(random_turns(2, 5))
    est = multiply(multiply(conjugate(earth), ref), conjugate(sensor))
    spoilt = ref.copy()
    spoilt[100:300] = np.nan
    spoilt[500:700] = quats(random_turns(200, 1))
    est[1000] = np.nan
    mask = np.ones(len(ref), dtype=bool)
    mask[500:700] = False
    found = metrics.align(est, spoilt, mask, rate=RATE)
    assert found.samples == pytest.approx(len(ref) - 400, abs=4)
    assert angle_between(found.q_earth, earth) < EXACT
    assert angle_between(found.q_sensor, sensor) < EXACT


def test_stamps_may_be_uneven_and_repeated() -> None:
    fine = ar.simulate.demo(30.0, 1000.0, 2, noise=False)
    assert fine.ref is not None
    kept = np.sort(np.random.default_rng(0).choice(len(fine), 3000, replace=False))
    kept[50] = kept[51]
    found = metrics.align(multiply(fine.ref[kept], quats(random_turns(1, 3))[0]), fine.ref[kept], t=fine.t[kept])
    assert found.largest < EXACT * 10
    assert abs(found.time_offset) < EXACT


def test_pair_is_scored_about_the_vertical_of_the_estimate() -> None:
    """An error of the heading stays one where the reference's earth frame has its z axis somewhere else."""
    ref = truth(1)
    drift = about_z(np.linspace(-0.1, 0.1, len(ref)))
    est = multiply(drift, ref)
    (earth,) = quats(random_turns(1, 9))
    turned = multiply(earth, ref)
    found = metrics.align(est, turned, sensor=False, time=False)
    score = metrics.score(*found.pair(est, turned))
    assert score.heading == pytest.approx(math.degrees(0.1 / math.sqrt(3)), rel=1e-3)  # RMS of a ramp
    assert score.inclination < 1e-6
    assert score.total == pytest.approx(math.degrees(found.rms), rel=1e-9)


def test_apply_takes_other_times_and_any_shape_where_there_is_no_offset() -> None:
    ref = truth()
    (earth,) = quats(random_turns(1, 2))
    found = metrics.align(multiply(conjugate(earth), ref), ref, sensor=False, time=False)
    assert found.apply(ref.reshape(2, -1, 4)).shape == (2, len(ref) // 2, 4)
    ref, est = shifted(1, 2.0)
    late = metrics.align(est, ref, rate=RATE)
    half = late.apply(est[:1000], t=np.arange(1000) / RATE)
    assert np.allclose(half[:990], late.apply(est)[:990], rtol=0, atol=0)
    with pytest.raises(ValueError, match=r"q: expected shape \(\d+, 4\), one for each time"):
        late.apply(est[:1000])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"q": np.full((3, 5, 4), 0.5)}, r"expected shape \(T, 4\) for both"),
        ({"earth": "flat"}, "earth: expected one of full, heading, none"),
        ({"largest_offset": 0.0}, "largest_offset: expected a positive number"),
        ({"rate": None}, "t: expected stamps, or rate"),
        ({"rate": -1.0}, "rate: expected a positive number"),
        ({"rate": None, "t": np.zeros(3)}, "t: expected shape"),
        ({"mask": np.arange(3000) < 5}, "expected at least 10 samples with an estimate and a reference, got 5"),
    ],
)
def test_wrong_arguments_are_named(changes: dict[str, object], message: str) -> None:
    ref = truth()
    given = {"q": ref, "ref": ref, "rate": RATE} | changes
    with pytest.raises(ValueError, match=message):
        metrics.align(**given)  # type: ignore[arg-type]


def test_rest_is_refused_and_the_message_says_what_to_do() -> None:
    still = np.tile([1.0, 0.0, 0.0, 0.0], (500, 1))
    with pytest.raises(ValueError, match=r"turns by 0 rad/s \(RMS\) only.*time=False"):
        metrics.align(still, still, rate=RATE)
    with pytest.raises(ValueError, match=r"the rotation of the sensor frame is not observable.*sensor=False"):
        metrics.align(still, still, time=False)
    spin = about_z(np.arange(500) * 0.02)
    with pytest.raises(ValueError, match="the sensor turns about the vertical only"):
        metrics.align(spin, spin, time=False, earth="heading")
    with pytest.raises(ValueError, match=r"turns at a constant rate.*time=False"):
        metrics.align(spin, spin, rate=RATE, sensor=False)


@needs_data
@pytest.mark.parametrize("name", ["TStick_Test06_Trial2.csv", "TStick_Test02_Trial1.csv"])
def test_real_recording_fits_to_a_degree_and_its_frames_are_the_same_for_every_filter(name: str) -> None:
    recording = ar.read(Path(DATA) / "repoimu" / name)
    assert recording.ref is not None
    found = []
    for cls in (ar.VQF, ar.MEKF):
        est = cls(rate=recording.rate).run(recording.gyr, recording.acc, recording.mag, t=recording.t)
        found.append(metrics.align(est.quat, recording.ref, recording.mask, t=recording.t, check=False))
    assert max(math.degrees(one.rms) for one in found) < 1.6  # 1.48 and less
    if found[0].determined:
        # Errors of a degree and a half in all directions over some hundred independent stretches, half a degree.
        assert math.degrees(float(angle_between(found[0].q_sensor, found[1].q_sensor))) < 1.0
        assert abs(found[0].time_offset) < 5e-3
