"""Axes, headings and clocks of simulated chains, found from what two sensors read."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from chains import Chain, Floats, waves
from signals import quats

RATE = 100.0
T = np.arange(3000) / RATE
HINGE = Chain("Y", waves(5, 0.8, channels=1))
AXES = HINGE.axis(0, [0.0, 1.0, 0.0]), HINGE.axis(1, [0.0, 1.0, 0.0])
GYR, ACC = HINGE.gyr(T), HINGE.acc(T)
SADDLE = Chain("ZX", waves(6, 0.7, channels=2))
BALL = Chain("ZXY", lambda t: waves(7, 1.0)(t) * [0.3, 0.2, 0.6])


def noisy(arrays: tuple[Floats, Floats], seed: int, noise: float, bias: float) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(seed)
    return tuple(  # type: ignore[return-value]
        each + noise * rng.normal(size=each.shape) + bias * rng.normal(size=3) for each in arrays
    )


def errors(found: ar.chain.HingeAxis, axes: tuple[Floats, Floats] = AXES) -> Floats:
    """Angles between the axes and the true ones, rad; π of the second where their signs do not belong together."""
    sign = np.sign(found.first @ axes[0])
    return np.array(
        [
            2.0 * np.arcsin(0.5 * np.linalg.norm(sign * one - other))
            for one, other in zip((found.first, found.second), axes, strict=True)
        ]
    )


# -- axes ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("forces", [False, True])
def test_the_axis_of_a_hinge_is_found_whatever_the_mounting(forces: bool) -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        turns = [np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in range(2)]
        turns = [turn * np.sign(np.linalg.det(turn)) for turn in turns]
        gyr, acc = ([each @ turn.T for each, turn in zip(both, turns, strict=True)] for both in (GYR, ACC))
        found = ar.chain.hinge_axis(*gyr, *(acc if forces else ()), rate=RATE)
        # Rates by differences are exact to 1e-7 rad/s.
        assert errors(found, (turns[0] @ AXES[0], turns[1] @ AXES[1])).max() < 1e-6
        assert found.first[np.argmax(np.abs(found.first))] > 0.0
        assert found.residual < 1e-6
        assert found.sign_agreement > 0.5


@pytest.mark.parametrize("forces", [False, True])
def test_the_deviation_of_the_axis_is_that_of_the_errors(forces: bool) -> None:
    ratios = []
    for seed in range(12):
        gyr, acc = noisy(GYR, seed, 0.05, 0.0), noisy(ACC, seed + 100, 0.2, 0.0)
        found = ar.chain.hinge_axis(*gyr, *(acc if forces else ()), rate=RATE)
        ratios.append(errors(found) / found.std)
    # 48 squares: the root of their mean scatters by 0.1, and the deviations of 30 blocks are low by some 10 %.
    assert 0.7 < np.sqrt(np.mean(np.square(ratios))) < 1.4


def test_forces_find_the_axis_of_a_slow_motion_that_rates_leave_in_noise() -> None:
    t = np.arange(6000) / RATE
    slow = Chain(
        "Y", waves(5, 0.4, 0.02, 0.05, channels=1), body=waves(1, 0.5, 0.02, 0.05), path=waves(2, 0.1, 0.02, 0.05)
    )
    gyr, acc = noisy(slow.gyr(t), 1, 0.02, 0.005), noisy(slow.acc(t), 2, 0.05, 0.02)
    without = errors(ar.chain.hinge_axis(*gyr, rate=RATE)).max()
    found = errors(ar.chain.hinge_axis(*gyr, *acc, rate=RATE)).max()
    assert found < np.radians(1.0)
    assert found < 0.2 * without


def test_lever_arms_in_fast_turns_make_forces_no_worse_than_none() -> None:
    # Slow for 12 s, then fast, half a metre and more from the axis: there the forces along it differ by a lot.
    body = waves(21, 0.5, 0.02, 0.05), waves(22, 0.3, 1.0, 2.5)
    bend = waves(23, 0.4, 0.02, 0.05, channels=1), waves(24, 0.3, 1.0, 2.5, channels=1)

    def both(slow_and_fast: Any) -> Any:
        slow, fast = slow_and_fast
        return lambda t: slow(t) + (0.5 + 0.5 * np.tanh(2.0 * (t - 12.0)))[:, np.newaxis] * fast(t)

    arms = Chain("Y", both(bend), body=both(body), levers=((0.5, 0.1, -0.6), (-0.3, 0.4, 0.5)))
    for seed in range(2):
        gyr, acc = noisy(arms.gyr(T), seed, 0.3, 0.0), noisy(arms.acc(T), seed + 9, 0.1, 0.0)
        with_forces, without = (errors(ar.chain.hinge_axis(*gyr, *each, rate=RATE)).max() for each in (acc, ()))
        assert with_forces < 1.1 * without < np.radians(1.0)


def test_knocks_do_not_move_the_axis() -> None:
    gyr, acc = noisy(GYR, 1, 0.01, 0.0), noisy(ACC, 2, 0.1, 0.0)
    rng = np.random.default_rng(3)
    knocks = rng.choice(len(T), 60, replace=False)
    gyr[1][knocks] += 10.0 * rng.normal(size=(60, 3))
    acc[0][knocks] += 50.0 * rng.normal(size=(60, 3))
    assert errors(ar.chain.hinge_axis(*gyr, *acc, rate=RATE)).max() < np.radians(0.3)
    # Rows are missing, and an accelerometer has a third of the rate.
    gyr[0][5:9] = acc[0][1::3] = acc[0][2::3] = np.nan
    assert errors(ar.chain.hinge_axis(*gyr, *acc, rate=RATE)).max() < np.radians(0.3)
    # Without any force that both have it is as without accelerometers.
    acc[0][:] = np.nan
    with_none, without = (ar.chain.hinge_axis(*gyr, *each, rate=RATE) for each in (acc, ()))
    np.testing.assert_array_equal(with_none.first, without.first)


def test_signs_belong_together_with_biases_and_either_way_round() -> None:
    for seed in range(4):
        gyr = noisy(GYR, seed, 0.02, 0.02)
        for pair, axes in ((gyr, AXES), (gyr[::-1], AXES[::-1])):
            assert errors(ar.chain.hinge_axis(*pair, t=T), axes).max() < np.radians(2.0)  # π where they are not


@pytest.mark.parametrize(
    ("gyr", "message"),
    [
        ((GYR[0], GYR[1][1:]), "^gyr2: expected the shape of gyr1"),
        ((GYR[0][:10], GYR[1][:10]), "^gyr1, gyr2: expected at least 20 rows without NaN, got 10"),
        ((GYR[0], 0.0 * GYR[1]), "^gyr2: expected a motion, got none"),
        (
            tuple(np.outer(np.sin(T), axis) for axis in AXES),
            "^gyr1, gyr2: expected a motion that is not about one axis",
        ),
        # The second segment turns about the hinge alone, the first one rests but for noise.
        ((1e-9 * GYR[0], np.outer(np.sin(T), AXES[1]) + 1e-9 * GYR[1]), "^gyr1: expected a motion that determines"),
    ],
)
def test_motions_that_leave_the_axis_open_are_refused(gyr: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ar.chain.hinge_axis(*gyr, rate=RATE)


def test_forces_come_in_pairs_and_times_are_needed() -> None:
    with pytest.raises(ValueError, match=r"^acc2: expected specific forces of both sensors, got None"):
        ar.chain.hinge_axis(*GYR, ACC[0], rate=RATE)
    with pytest.raises(ValueError, match=r"^t: expected stamps in s, or a positive rate in Hz"):
        ar.chain.hinge_axis(*GYR)


# -- headings --------------------------------------------------------------------------------------------------------


def joint(chain: Chain) -> ar.chain.Joint:
    if chain is HINGE:
        return ar.chain.Hinge(*AXES)
    if chain is SADDLE:
        return ar.chain.Universal(chain.axis(0, [0.0, 0.0, 1.0]), chain.axis(1, [1.0, 0.0, 0.0]))
    angles = chain.angles(T)
    limits = np.stack([angles.min(axis=0), angles.max(axis=0)], axis=1)
    return ar.chain.Ball(limits, "ZXY", quats(chain.mounts[0]), quats(chain.mounts[1]))


def drifted(chain: Chain, delta: Floats) -> tuple[Floats, Floats]:
    first, second = chain.quats(T)
    return first, ar.rotation.product(ar.rotation.about_axis("z", -delta), second)


@pytest.mark.parametrize("chain", [HINGE, SADDLE, BALL], ids=["hinge", "saddle", "ball"])
@pytest.mark.parametrize("start", [0.3, 3.0, -1.5])
def test_the_heading_of_a_joint_is_found_and_its_drift(chain: Chain, start: float) -> None:
    delta = start + np.radians(0.2) * T + np.radians(1.0) * np.sin(0.3 * T)
    first, second = drifted(chain, delta)
    found = ar.chain.correct_heading(first, second, joint(chain), rate=RATE)
    off = found.delta - delta - 2.0 * np.pi * np.round((found.delta - delta).mean() / (2.0 * np.pi))
    # Within two of its own standard deviations. These follow from the settings, as the attitudes are exact: at the
    # ends, where only one side tells, they are 2° (hinge), 5° (saddle) and 9° (ball).
    assert (np.abs(off) < 2.0 * found.std).all()
    assert found.std.max() < np.radians(2.5 if chain is HINGE else 6.0 if chain is SADDLE else 10.0)
    assert ar.rotation.distance(found.quat, chain.quats(T)[1]) == pytest.approx(np.abs(off), abs=1e-12)
    assert found.residual < np.radians(2.0)


@pytest.mark.parametrize(
    ("chain", "error"), [(HINGE, 1.0), (SADDLE, 2.5), (BALL, 7.0)], ids=["hinge", "saddle", "ball"]
)
def test_headings_of_two_filters_drift_apart_and_are_found(chain: Chain, error: float) -> None:
    estimates, headings = [], []
    for k in range(2):
        gyr = noisy((chain.gyr(T)[k],) * 2, k + 4, 0.005, np.radians(0.3))[0]
        acc = noisy((chain.acc(T)[k],) * 2, k + 6, 0.05, 0.03)[0]
        estimates.append(ar.OfflineVQF(rate=RATE).run(gyr, acc, t=T))
        turn = ar.metrics.error_quat(estimates[k].quat, chain.quats(T)[k])
        headings.append(ar.rotation.unwrap(2.0 * np.arctan2(turn[:, 3], turn[:, 0])))
    apart = headings[0] - headings[1]
    assert np.ptp(apart) > np.radians(1.5)
    found = ar.chain.correct_heading(*estimates, joint(chain))
    off = (found.delta - apart + np.pi) % (2.0 * np.pi) - np.pi
    # Three times what ten chains of a minute had (docs/design/chain.md), and within its own deviations.
    assert np.sqrt(np.mean(off**2)) < np.radians(error)
    assert (np.abs(off) < 2.0 * found.std).all()


def test_an_upright_axis_says_nothing_of_the_heading_and_that_is_told() -> None:
    upright = Chain("Z", waves(5, 0.8, channels=1), body=lambda t: waves(1, 0.5)(t) * [0.0, 0.0, 1.0])
    first, second = drifted(upright, np.zeros_like(T))
    axes = upright.axis(0, [0.0, 0.0, 1.0]), upright.axis(1, [0.0, 0.0, 1.0])
    found = ar.chain.correct_heading(first, second, ar.chain.Hinge(*axes), rate=RATE)
    assert found.std == pytest.approx(np.pi / np.sqrt(3.0))
    # For 10 s the axis leans: then it is known, and before and after less and less.
    body = lambda t: np.column_stack([np.where((t > 10) & (t < 20), 0.7, 0.0), 0.0 * t, 0.0 * t])  # noqa: E731
    first, second = drifted(Chain("Z", upright.angles, body=body), np.full_like(T, 0.4))
    found = ar.chain.correct_heading(first, second, ar.chain.Hinge(*axes), rate=RATE)
    assert found.std[1500] < np.radians(3.0)
    assert found.std[0] > 1.2 * found.std[1500]
    assert np.abs(found.delta - 0.4).max() < np.radians(0.5)


def test_missing_rows_say_nothing_and_the_heading_goes_on() -> None:
    delta = 0.5 + np.radians(0.1) * T
    first, second = drifted(HINGE, delta)
    first[800:1400], second[1300:1500] = np.nan, np.nan
    found = ar.chain.correct_heading(first, second, joint(HINGE), rate=RATE)
    assert np.abs(found.delta - delta).max() < np.radians(1.0)
    assert np.isnan(found.quat[1300:1500]).all()
    with pytest.raises(ValueError, match=r"^first, second: expected a row in which both have an attitude, got none"):
        ar.chain.correct_heading(np.full((5, 4), np.nan), second[:5], joint(HINGE), rate=RATE)
    with pytest.raises(ValueError, match=r"^drift: expected a positive number, got 0.0"):
        ar.chain.correct_heading(first, second, joint(HINGE), rate=RATE, drift=0.0)


def test_the_errors_of_joints_are_angles() -> None:
    first, second = (each[:300] for each in SADDLE.quats(T))
    saddle = joint(SADDLE)
    assert saddle.square_error(first, second, np.zeros(1))[0] < 1e-28
    # One sample each, by the definition: the angle between the axes, to first order from a right angle.
    axes = SADDLE.axis(0, [0.0, 0.0, 1.0]), SADDLE.axis(1, [1.0, 0.0, 0.0])
    turned = ar.rotation.product(ar.rotation.about_axis("z", 0.02), second)
    a, b = ar.rotation.rotate(first, axes[0]), ar.rotation.rotate(turned, axes[1])
    angles = np.arccos(np.sum(a * b, axis=1)) - np.pi / 2.0
    assert saddle.square_error(first, second, np.array([0.02]))[0] == pytest.approx(np.mean(angles**2), rel=1e-3)


# -- clocks ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("offset", "rate", "skew"), [(0.0, 100.0, 0.0), (3.2137, 100.0, 0.0), (-7.777, 57.0, 0.0), (1.5, 200.0, 5e-5)]
)
def test_clocks_are_found_to_a_part_of_a_sample(offset: float, rate: float, skew: float) -> None:
    rng = np.random.default_rng(1)
    t = np.arange(6000) / RATE
    own = 2.0 + np.arange(int(50 * rate)) / rate
    shown = own + offset + skew * (own - own.mean())  # by the first clock
    begin = offset - 3.0
    gyr1 = HINGE.gyr(t)[0] + 0.01 * rng.normal(size=(len(t), 3))
    gyr2 = HINGE.gyr(shown - begin)[0] @ HINGE.mounts[1].as_matrix() + 0.01 * rng.normal(size=(len(own), 3))
    found = ar.chain.synchronise((t + begin, gyr1), (own, gyr2), skew=skew > 0.0)
    # 1/50 of the first sensor's sample; of 57 Hz linear interpolation of 1 Hz motions is exact to less.
    assert np.abs(found.apply(own) - shown).max() < 2e-4
    assert abs(found.offset - offset) < 5.0 * found.std + 1e-5
    assert found.correlation > 0.95
    assert found.skew == pytest.approx(skew, abs=5e-6)


def test_across_a_hinge_its_axis_makes_the_clocks_exact() -> None:
    later = 2.3456
    gyr2 = HINGE.gyr(T + later)[1]
    axis = ar.chain.hinge_axis(*GYR, rate=RATE)
    rough = ar.chain.synchronise((T, GYR[0]), (T, gyr2)).offset
    exact = ar.chain.synchronise((T, GYR[0]), (T, gyr2), axis=axis).offset
    assert rough == pytest.approx(later, abs=0.05)
    assert exact == pytest.approx(later, abs=1e-4)


def test_a_recording_comes_onto_other_stamps_with_nothing_over_its_gaps() -> None:
    rec = ar.simulate.demo(duration=20.0, noise=False)
    kept = np.r_[0:700, 900:2000]
    other = ar.Recording(t=rec.t[kept] + 5.0, gyr=rec.gyr[kept], acc=rec.acc[kept], mag=rec.mag[kept])
    clock = ar.chain.ClockOffset(-5.0, 0.0, 0.0, 0.0, 1.0)
    stamps = rec.t[::2] + 0.004
    moved = clock.onto(other, stamps)
    assert moved.t.tolist() == stamps.tolist()
    inside = (stamps < 6.9) | (stamps > 9.1)
    inside[0] = inside[-1] = False
    for name in ("acc", "mag"):
        lines = np.column_stack([np.interp(stamps, rec.t, column) for column in getattr(rec, name).T])
        np.testing.assert_allclose(getattr(moved, name)[inside], lines[inside], rtol=0.0, atol=1e-9)
        assert np.isnan(getattr(moved, name)[(stamps > 7.0) & (stamps < 8.9)]).all()
    assert np.isnan(moved.gyr[(stamps > 7.1) & (stamps < 8.9)]).all()


def test_motions_that_do_not_agree_are_refused() -> None:
    other = Chain("Y", waves(50, 0.8, channels=1), body=waves(51, 0.6)).gyr(T)[0]
    with pytest.raises(ValueError, match=r"^second: its rates of turn agree with those of the first at no offset"):
        ar.chain.synchronise((T, GYR[0]), (T, other))
    with pytest.raises(ValueError, match=r"^second: too little overlaps, or nothing turns"):
        ar.chain.synchronise((T, GYR[0]), (T, np.zeros((len(T), 3))))
    with pytest.raises(ValueError, match=r"^first: expected at least 2 s of angular rates"):
        ar.chain.synchronise((T[:50], GYR[0][:50]), (T, other))
    with pytest.raises(ValueError, match=r"^first: expected a Recording, or times and angular rates, got list"):
        ar.chain.synchronise([1.0], (T, other))  # type: ignore[arg-type]


# -- all of it -------------------------------------------------------------------------------------------------------


def two_phones() -> tuple[ar.Recording, ar.Recording, Floats]:
    """Two minutes of a knee: sensors with noise, biases and clocks of their own."""
    t = np.arange(12000) / RATE
    recordings = []
    for k, (shift, clock) in enumerate(((0.0, 0.0), (4.3217, 100.0))):
        gyr = noisy((HINGE.gyr(t + shift)[k],) * 2, k, 0.005, np.radians(0.3))[0]
        acc = noisy((HINGE.acc(t + shift)[k],) * 2, k + 10, 0.05, 0.03)[0]
        recordings.append(ar.Recording(t=t + clock, gyr=gyr, acc=acc))
    return recordings[0], recordings[1], HINGE.angles(t)[:, 0]


def test_the_angle_of_a_hinge_from_two_phones_in_fifteen_lines() -> None:
    thigh, shank_alone, truth = two_phones()

    clock = ar.chain.synchronise(thigh, shank_alone)
    shank = clock.onto(shank_alone, thigh.t)
    axis = ar.chain.hinge_axis(thigh.gyr, shank.gyr, thigh.acc, shank.acc, t=thigh.t)
    clock = ar.chain.synchronise(thigh, shank_alone, axis=axis)  # once more, as the axis is known now
    shank = clock.onto(shank_alone, thigh.t)
    axis = ar.chain.hinge_axis(thigh.gyr, shank.gyr, thigh.acc, shank.acc, t=thigh.t)
    f = ar.OfflineVQF(rate=100.0)
    first, second = f.run(thigh), f.run(shank)
    heading = ar.chain.correct_heading(first, second, ar.chain.Hinge(axis))
    knee = ar.chain.joint_angle(ar.chain.relative(first, second, heading=heading), axis)

    assert clock.offset == pytest.approx(-95.6783, abs=2e-3)
    assert errors(axis).max() < np.radians(0.2)
    both = slice(500, 11900)  # what the second one has recorded
    sign = np.sign(axis.first @ AXES[0])
    off = knee.angle[both] - sign * truth[both]
    # What the inclinations of the filter are off by, in motion all the time: 0.7° and 0.8° (RMS).
    assert np.sqrt(np.mean((off - off.mean()) ** 2)) < np.radians(1.0)
    # Without the heading the two filters are tens of degrees apart.
    raw = ar.chain.joint_angle(ar.chain.relative(first, second), axis)
    off = raw.angle[both] - sign * truth[both]
    assert np.sqrt(np.mean((off - off.mean()) ** 2)) > np.radians(5.0)
