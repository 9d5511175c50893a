//! Euler angles: both ways, everywhere, and their rates.

use std::f64::consts::{FRAC_PI_2, PI};

use ahrs_rs::so3::euler_rates;
use ahrs_rs::{Euler, Quat, Real, Scalar, Vec3};

use crate::kinds::{assert_near, distance, epsilon, lane4, rotations, scalar};
use crate::outlined::{euler_angles, exp_half, from_euler_angles, rotate_by};
use crate::random::Random;

/// The quaternion of angles in `f64`, from three turns about axes.
fn three_turns(roll: f64, pitch: f64, yaw: f64) -> Quat<f64> {
    let turn = |v: [f64; 3]| exp_half(Vec3::of(v));
    turn([0.0, 0.0, yaw / 2.0]) * turn([0.0, pitch / 2.0, 0.0]) * turn([roll / 2.0, 0.0, 0.0])
}

fn angle<S: Scalar>(value: S, lane: usize) -> f64 {
    value.lane(lane).to_f64()
}

#[track_caller]
fn assert_round_trip<S: Scalar>(q: Quat<S>) {
    let euler = euler_angles(q);
    let back = from_euler_angles(euler);
    for lane in 0..S::LANES {
        let (roll, pitch, yaw) = (angle(euler.roll, lane), angle(euler.pitch, lane), angle(euler.yaw, lane));
        let largest = 2.0 * epsilon::<S>(); // an ulp of π
        assert!(roll.abs() <= PI + largest && yaw.abs() <= PI + largest, "{roll}, {yaw}");
        assert!(pitch.abs() <= FRAC_PI_2 + largest, "{pitch}");
        // Each angle is within 3 ulp, that is up to 6 epsilon at π, plus as much for the sum of two; halved on the
        // way back, and both outer ones count: 12. Sines and cosines of halves add 4; at a pole up to 8 epsilon of the
        // direction that is lost are left out by intention.
        let (q, back) = (lane4(q, lane), lane4(back, lane));
        let error = distance(q, back).min(distance(q, back.map(|c| -c))) / epsilon::<S>();
        assert!(error <= 24.0, "lane {lane}: {q:?} became {back:?}, {error} epsilon off");
    }
}

pub fn a_quaternion_comes_back_from_its_euler_angles_everywhere<S: Scalar>() {
    for q in rotations::<S>() {
        assert_round_trip(q);
    }
    let mut random = Random(31);
    // At the poles, and at distances from 1e-3 to 1e-16 of both.
    let distances = (3..=16).map(|power| 10.0_f64.powi(-power)).chain([0.0]);
    for away in distances.flat_map(|away| [away; 12]) {
        let mut draw = || {
            let pole = if random.chance(0.5) { FRAC_PI_2 } else { -FRAC_PI_2 };
            let pitch = pole * (1.0 - away / FRAC_PI_2);
            three_turns(random.uniform(-PI, PI), pitch, random.uniform(-PI, PI))
        };
        let lanes: Vec<_> = (0..S::LANES).map(|_| draw()).collect();
        let part = |of: fn(&Quat<f64>) -> f64| {
            let mut lane = lanes.iter();
            scalar(|| lane.next().map_or(f64::NAN, of))
        };
        assert_round_trip(Quat::<S>::new(part(|q| q.w), part(|q| q.x), part(|q| q.y), part(|q| q.z)));
    }
}

pub fn euler_angles_come_back_from_their_quaternion<S: Scalar>() {
    let mut random = Random(32);
    for _ in 0..100 {
        let given = Euler::<S> {
            roll: scalar(|| random.uniform(-3.0, 3.0)),
            pitch: scalar(|| random.uniform(-1.5, 1.5)),
            yaw: scalar(|| random.uniform(-3.0, 3.0)),
        };
        let back = euler_angles(from_euler_angles(given));
        for lane in 0..S::LANES {
            // The quaternion is off by some 8 epsilon; the outer angles see that over cos pitch.
            let bound = 24.0 * epsilon::<S>() / angle(given.pitch, lane).cos();
            for (a, b) in [(given.roll, back.roll), (given.pitch, back.pitch), (given.yaw, back.yaw)] {
                let error = (angle(a, lane) - angle(b, lane)).abs();
                assert!(error <= bound, "lane {lane}: {given:?}: {error:e}, more than {bound:e}");
            }
        }
    }
}

pub fn euler_angles_are_yaw_then_pitch_then_roll<S: Scalar>() {
    let mut random = Random(33);
    for _ in 0..20 {
        let (roll, pitch, yaw) = (random.uniform(-PI, PI), random.uniform(-1.5, 1.5), random.uniform(-PI, PI));
        let q = from_euler_angles(Euler::<S> { roll: S::of(roll), pitch: S::of(pitch), yaw: S::of(yaw) });
        let expected = three_turns(roll, pitch, yaw);
        // The angles round to the scalar (π by 2 epsilon, halved), sines and cosines by 3 ulp, and the sums.
        assert_near(q, Quat::of([expected.w, expected.x, expected.y, expected.z]), 8.0);
    }
}

pub fn at_the_poles_roll_is_zero<S: Scalar>() {
    const H: f64 = std::f64::consts::FRAC_1_SQRT_2;
    for (q, pitch) in
        [([H, 0.0, H, 0.0], FRAC_PI_2), ([H, 0.0, -H, 0.0], -FRAC_PI_2), ([0.5, -0.5, 0.5, 0.5], FRAC_PI_2)]
    {
        let euler = euler_angles(Quat::<S>::of(q));
        for lane in 0..S::LANES {
            assert_eq!(angle(euler.roll, lane), 0.0);
            // An ulp of π/2, rounded to the scalar.
            assert!((angle(euler.pitch, lane) - pitch).abs() <= 2.0 * epsilon::<S>());
        }
    }
    // Yaw 2·atan2(0.5, 0.5) = π/2 stays defined there.
    let yaw = euler_angles(Quat::<S>::of([0.5, -0.5, 0.5, 0.5])).yaw;
    assert!((angle(yaw, 0) - FRAC_PI_2).abs() <= 4.0 * epsilon::<S>());
}

#[test]
fn euler_rates_are_the_derivatives_of_the_angles() {
    let mut random = Random(34);
    let step = 1e-5;
    for _ in 0..200 {
        let (roll, pitch, yaw) = (random.uniform(-3.0, 3.0), random.uniform(-1.2, 1.2), random.uniform(-3.0, 3.0));
        let e = Euler { roll, pitch, yaw };
        let rate = Vec3::of(random.normal3());
        let rates = euler_rates(e, rate);
        let after = euler_angles(rotate_by(from_euler_angles(e), rate, step));
        let before = euler_angles(rotate_by(from_euler_angles(e), rate, -step));
        for (a, b, expected) in [
            (after.roll, before.roll, rates.roll),
            (after.pitch, before.pitch, rates.pitch),
            (after.yaw, before.yaw, rates.yaw),
        ] {
            // A central difference: the third derivative is below 100 |ω|³/cos³ pitch, and |ω| < 6, times step²/6;
            // rounding 1e-15/cos pitch/step.
            let error = ((a - b) / (2.0 * step) - expected).abs();
            assert!(error <= 1e-6, "{e:?}, {rate:?}: {error:e}");
        }
    }
}

#[test]
fn euler_rates_stay_finite_at_the_poles() {
    // There the cosine of the pitch counts as its floor, with its sign.
    for pitch in [FRAC_PI_2, -FRAC_PI_2, FRAC_PI_2 + 1e-9, FRAC_PI_2 - 1e-9] {
        let rates = euler_rates(Euler { roll: 0.3, pitch, yaw: 0.0 }, Vec3::of([1.0, 2.0, 3.0]));
        let turning = 2.0 * 0.3_f64.sin() + 3.0 * 0.3_f64.cos();
        let sign = if pitch > FRAC_PI_2 { -1.0 } else { 1.0 };
        // The sine and cosine of the roll are within 2 ulp.
        assert!((rates.yaw * f64::COS_PITCH_FLOOR * sign - turning).abs() < 1e-14, "{rates:?}");
        assert!(rates.roll.is_finite() && rates.pitch.is_finite());
    }
}
