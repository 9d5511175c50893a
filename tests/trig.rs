//! The transcendental functions: their largest errors, their totality and their symmetries.
//!
//! Errors are in units in the last place (ulp) of the exact value. For `f32` the reference is the standard library in
//! `f64`, whose own error of at most one of its ulp is 2⁻²⁹ of those measured; for `f64` it is `double_double`, which
//! keeps some 100 bits.

#![allow(clippy::float_cmp, reason = "axis values and symmetries hold exactly")]
#![allow(clippy::cast_precision_loss, reason = "counters below 2⁵³")]

#[path = "support/double_double.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod double_double;
#[path = "support/random.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod random;

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use ahrs_rs::trig::{atan2, one_minus_exp, sin_cos, wrap};
use ahrs_rs::{Pair, Real, Scalar};
use double_double::{DoubleDouble, ulps};
use random::Random;

/// The largest error that was seen, and where.
struct Worst {
    error: f64,
    at: (f64, f64),
}

impl Worst {
    fn none() -> Self {
        Worst { error: 0.0, at: (0.0, 0.0) }
    }
    fn see(&mut self, error: f64, at: (f64, f64)) {
        // An error of NaN is the worst, and stays.
        if error.is_nan() || error > self.error {
            *self = Worst { error, at };
        }
    }
    fn assert_within(&self, bound: f64, what: &str) {
        println!("{what}: {} ulp at {:?}", self.error, self.at);
        assert!(self.error <= bound, "{what}: {} ulp at {:?}, more than {bound}", self.error, self.at);
    }
}

/// The unit in the last place of an `f32` near `exact`.
fn ulp_f32(exact: f64) -> f64 {
    let power = f32::from_bits((exact.abs() as f32).max(f32::MIN_POSITIVE).to_bits() & 0xff80_0000);
    f64::from(power) * f64::from(f32::EPSILON)
}

fn see_sin_cos_f64(worst: &mut Worst, angle: f64) {
    let (sin, cos) = sin_cos(angle);
    let (exact_sin, exact_cos) = double_double::sin_cos(DoubleDouble::from(angle));
    worst.see(ulps(sin, exact_sin), (angle, 0.0));
    worst.see(ulps(cos, exact_cos), (angle, 0.0));
}

/// In ulp, after taking off what the reduction's three parts of π/2 may leave: see `sin_cos_f32_...`.
fn see_sin_cos_f32(worst: &mut Worst, angle: f32) {
    let (sin, cos) = sin_cos(angle);
    let exact = f64::from(angle);
    let reduction = if exact.abs() < FRAC_PI_4 { 0.0 } else { 1e-14 * exact.abs() };
    for (value, exact_value) in [(sin, exact.sin()), (cos, exact.cos())] {
        let error = (f64::from(value) - exact_value).abs();
        worst.see((error - reduction) / ulp_f32(exact_value), (exact, 0.0));
    }
}

#[test]
fn sin_cos_f64_is_within_2_ulp_over_its_range() {
    let mut worst = Worst::none();
    let mut random = Random(1);
    for k in -60_000..=60_000 {
        see_sin_cos_f64(&mut worst, f64::from(k) * 2e-4);
    }
    for _ in 0..80_000 {
        see_sin_cos_f64(&mut worst, random.uniform(-f64::ANGLE_RANGE, f64::ANGLE_RANGE));
        see_sin_cos_f64(&mut worst, random.spread(-320.0, 6.0));
        see_sin_cos_f64(&mut worst, random.uniform(-PI, PI));
    }
    for angle in [0.0, 5e-324, f64::MIN_POSITIVE, 1e-160, f64::ANGLE_RANGE, -f64::ANGLE_RANGE] {
        see_sin_cos_f64(&mut worst, angle);
    }
    worst.assert_within(2.0, "sin_cos f64");
}

#[test]
fn sin_cos_f64_keeps_its_ulp_next_to_multiples_of_a_quarter_turn() {
    // Where the result is as small as 1e-17 after a cancellation of 20 bits: the test of the reduction.
    let mut worst = Worst::none();
    for turns in (1..636_619_u32).step_by(11) {
        let nearest = (DoubleDouble::from(f64::from(turns)) * DoubleDouble::QUARTER_TURN).hi;
        for angle in [nearest.next_down(), nearest, nearest.next_up()] {
            see_sin_cos_f64(&mut worst, angle);
        }
    }
    worst.assert_within(2.0, "sin_cos f64 near multiples of π/2");
}

#[test]
fn sin_cos_f32_is_within_3_ulp_and_the_reductions_error() {
    // Every 997th number of the range; 997 is prime, so that all patterns of the last bits are met.
    //
    // The three parts of π/2 in f32 lack 5.4e-15, and products and sum with the last part round by at most 2⁻²⁴ of
    // 7.5e-8 a quarter turn each: together less than 1.5e-14 a quarter turn, that is 1e-14 of the angle. Only next to
    // multiples of π/2, where the result is that small, is this more than an ulp.
    let mut worst = Worst::none();
    let last = (f32::ANGLE_RANGE as f32).to_bits();
    for bits in (0..=last).step_by(997) {
        see_sin_cos_f32(&mut worst, f32::from_bits(bits));
        see_sin_cos_f32(&mut worst, -f32::from_bits(bits));
    }
    for turns in 1..2608_u32 {
        let nearest = (f64::from(turns) * FRAC_PI_2) as f32;
        for offset in 0..16 {
            see_sin_cos_f32(&mut worst, f32::from_bits(nearest.to_bits() + offset));
            see_sin_cos_f32(&mut worst, f32::from_bits(nearest.to_bits() - offset));
        }
    }
    worst.assert_within(3.0, "sin_cos f32");
}

#[test]
fn sin_cos_f32_is_within_3_ulp_up_to_half_a_turn() {
    // So for every angle that Euler's angles or a wrapped difference give. What the parts of π/2 lack, 5.4e-15 a
    // quarter turn, is 1.5 ulp of the smallest results there are: cos 1.5707964 = −4.4e-8 and sin 3.1415927 = −8.7e-8.
    let mut worst = Worst::none();
    for bits in (0..=std::f32::consts::PI.to_bits()).rev().step_by(127).chain(0x3fc9_0fd0..=0x3fc9_0fe0) {
        let angle = f32::from_bits(bits);
        let (sin, cos) = sin_cos(angle);
        for (value, exact) in [(sin, f64::from(angle).sin()), (cos, f64::from(angle).cos())] {
            worst.see((f64::from(value) - exact).abs() / ulp_f32(exact), (f64::from(angle), 0.0));
        }
    }
    worst.assert_within(3.0, "sin_cos f32 up to π");
}

fn every_argument_gives_a_point_on_the_circle<T: Real>() {
    // Sine and cosine within 3 ulp of the exact ones: s² + c² is within 2·3 epsilon of one.
    let on_circle = |angle: f64| {
        let (sin, cos) = sin_cos(T::from_f64(angle));
        let (sin, cos) = (sin.to_f64(), cos.to_f64());
        let error = (sin * sin + cos * cos - 1.0).abs();
        assert!(error <= 6.0 * T::EPSILON.to_f64(), "sin_cos({angle:e}) = {sin}, {cos}");
        (sin, cos)
    };
    for angle in [f64::NAN, f64::INFINITY, -f64::INFINITY, f64::MAX, -1e300, T::ANGLE_RANGE * 1.001, 1e30] {
        assert_eq!(on_circle(angle), (0.0, 1.0), "sin_cos({angle:e})");
    }
    let mut random = Random(2);
    for _ in 0..20_000 {
        on_circle(f64::from_bits(random.bits()));
        on_circle(random.spread(-45.0, 7.0));
    }
}

#[test]
fn sin_cos_is_total() {
    every_argument_gives_a_point_on_the_circle::<f32>();
    every_argument_gives_a_point_on_the_circle::<f64>();
}

#[test]
fn sine_is_odd_and_cosine_even() {
    let mut random = Random(3);
    for _ in 0..20_000 {
        let angle = random.spread(-20.0, 6.0);
        let ((sin, cos), (minus_sin, minus_cos)) = (sin_cos(angle), sin_cos(-angle));
        assert_eq!((sin, cos), (-minus_sin, minus_cos), "at {angle:e}");
        let angle = angle as f32;
        let ((sin, cos), (minus_sin, minus_cos)) = (sin_cos(angle), sin_cos(-angle));
        assert_eq!((sin, cos), (-minus_sin, minus_cos), "at {angle:e}");
    }
}

#[test]
fn atan2_f64_is_within_3_ulp() {
    let mut worst = Worst::none();
    let mut random = Random(4);
    for k in 1..100_000 {
        let ratio = f64::from(k) * 1e-5;
        worst.see(ulps(atan2(ratio, 1.0), double_double::atan2(ratio, 1.0)), (ratio, 1.0));
    }
    for _ in 0..80_000 {
        let angle = random.uniform(-PI, PI);
        let points = [
            (random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)),
            (random.spread(-100.0, 100.0), random.spread(-100.0, 100.0)),
            (angle.sin(), angle.cos()),
        ];
        for (y, x) in points {
            worst.see(ulps(atan2(y, x), double_double::atan2(y, x)), (y, x));
        }
    }
    worst.assert_within(3.0, "atan2 f64");
}

#[test]
fn atan2_f32_is_within_3_ulp() {
    let mut worst = Worst::none();
    let mut see = |y: f32, x: f32| {
        let exact = f64::from(y).atan2(f64::from(x));
        worst.see((f64::from(atan2(y, x)) - exact).abs() / ulp_f32(exact), (f64::from(y), f64::from(x)));
    };
    // Every 61st ratio from 1e-6 to 1 in all octants.
    for bits in (1e-6_f32.to_bits()..=1.0_f32.to_bits()).step_by(61) {
        let ratio = f32::from_bits(bits);
        for (y, x) in [(ratio, 1.0), (1.0, ratio), (ratio, -1.0), (-1.0, -ratio)] {
            see(y, x);
        }
    }
    let mut random = Random(5);
    for _ in 0..200_000 {
        // Both components well inside f32's range, so that neither the ratio's terms nor the sum leave it.
        see(random.spread(-37.0, 37.0) as f32, random.spread(-37.0, 37.0) as f32);
    }
    worst.assert_within(3.0, "atan2 f32");
}

#[test]
fn atan2_is_exact_on_the_axes_and_diagonals() {
    for (y, x, expected) in [
        (0.0, 1.0, 0.0),
        (0.0, 0.0, 0.0),
        (-0.0, 0.0, 0.0),
        (0.0, -0.0, 0.0),
        (1.0, 0.0, FRAC_PI_2),
        (-1.0, 0.0, -FRAC_PI_2),
        (1.0, -0.0, FRAC_PI_2),
        (0.0, -1.0, PI),
        (-0.0, -1.0, PI),
        (1.0, 1.0, FRAC_PI_4),
        (-1.0, 1.0, -FRAC_PI_4),
        (1.0, -1.0, 3.0 * FRAC_PI_4),
        (-1.0, -1.0, -3.0 * FRAC_PI_4),
    ] {
        assert_eq!(atan2(y, x), expected, "atan2({y}, {x})");
        // One ulp at π, which is two epsilon: the constants are rounded to f32.
        let error = f64::from(atan2(y as f32, x as f32)) - expected;
        assert!(error.abs() <= 2.0 * f64::from(f32::EPSILON), "atan2({y}, {x}) in f32: {error:e}");
    }
}

#[test]
fn atan2_of_finite_numbers_is_an_angle() {
    // Also where the sum of the components overflows or a product is subnormal and the error is not bounded.
    let mut random = Random(6);
    let extreme = [0.0, -0.0, 5e-324, -1e-310, f64::MIN_POSITIVE, 1.0, -1.0, 1e300, f64::MAX, -f64::MAX];
    let check = |y: f64, x: f64| {
        assert!(atan2(y, x).abs() <= PI, "atan2({y:e}, {x:e}) = {}", atan2(y, x));
        let (y, x) = (y as f32, x as f32);
        if y.is_finite() && x.is_finite() {
            assert!(atan2(y, x).abs() <= std::f32::consts::PI, "atan2({y:e}, {x:e}) = {}", atan2(y, x));
        }
    };
    for y in extreme {
        for x in extreme {
            check(y, x);
        }
    }
    for _ in 0..20_000 {
        let (y, x) = (f64::from_bits(random.bits()), f64::from_bits(random.bits()));
        if y.is_finite() && x.is_finite() {
            check(y, x);
        }
    }
}

#[test]
fn atan2_is_odd_in_y_and_grows_along_the_circle() {
    // Neighbouring points are 6e-5 rad apart, far more than the error.
    let mut last = -4.0;
    for k in -50_000..50_000 {
        let angle = PI * (f64::from(k) + 0.5) / 50_000.0;
        let (y, x) = angle.sin_cos();
        let value = atan2(y, x);
        assert!(value > last, "at {angle}");
        assert_eq!(value, -atan2(-y, x), "at {angle}");
        last = value;
    }
}

fn wrap_gives_the_same_angle<T: Real>(largest: f64) {
    // The product of the turns with the rounded 2π and the difference round once each: an error of at most epsilon
    // times the angle, by which the result may also leave [−π, π].
    let mut random = Random(7);
    for k in 0..60_000 {
        let angle = T::from_f64(if k % 2 == 0 { random.uniform(-largest, largest) } else { random.uniform(-7.0, 7.0) });
        let wrapped = wrap(angle).to_f64();
        let angle = angle.to_f64();
        let slack = T::EPSILON.to_f64() * angle.abs().max(PI);
        assert!(wrapped.abs() <= PI + slack, "wrap({angle}) = {wrapped}");
        let turns = ((angle - wrapped) / TAU).round();
        let exact = DoubleDouble::from(angle)
            - DoubleDouble::from(4.0 * turns) * DoubleDouble::QUARTER_TURN
            - DoubleDouble::from(wrapped);
        assert!(exact.hi.abs() <= slack, "wrap({angle}) = {wrapped}, off by {:e}", exact.hi);
    }
}

#[test]
fn wrap_keeps_the_angle_to_its_rounding() {
    // Up to twice the range of sin_cos, which is what a difference or a step of Euler's angles can reach, times π.
    wrap_gives_the_same_angle::<f32>(PI * f32::ANGLE_RANGE);
    wrap_gives_the_same_angle::<f64>(PI * f64::ANGLE_RANGE);
}

#[test]
fn wrap_leaves_angles_within_half_a_turn_alone() {
    let mut random = Random(8);
    for _ in 0..20_000 {
        let angle = random.uniform(-PI, PI);
        assert_eq!(wrap(angle), angle);
        let angle = random.uniform(-3.1, 3.1) as f32;
        assert_eq!(wrap(angle), angle);
    }
}

/// 1 − e^(−x) to some 100 bits: the Taylor series of a 1024th of the argument, doubled ten times.
fn exact_one_minus_exp(x: f64) -> DoubleDouble {
    let y = DoubleDouble::from(x / 1024.0);
    let (mut term, mut sum) = (y, y);
    for k in 2..20_u32 {
        term = -(term * y / DoubleDouble::from(f64::from(k)));
        sum = sum + term;
    }
    (0..10).fold(sum, |r, _| r * (DoubleDouble::from(2.0) - r))
}

#[test]
fn one_minus_exp_f64_is_within_8_ulp() {
    let mut worst = Worst::none();
    let mut random = Random(10);
    let mut see = |x: f64| worst.see(ulps(one_minus_exp(x), exact_one_minus_exp(x)), (x, 0.0));
    for k in 1..100_000 {
        see(f64::from(k) * 5e-4);
    }
    for _ in 0..80_000 {
        see(random.spread(-290.0, 1.7).abs());
    }
    worst.assert_within(8.0, "one_minus_exp f64");
}

#[test]
fn one_minus_exp_f32_is_within_8_ulp() {
    let mut worst = Worst::none();
    // Every 61st number up to 100; below 1e-30 a term of the series is subnormal.
    for bits in (1e-30_f32.to_bits()..100.0_f32.to_bits()).step_by(61) {
        let x = f32::from_bits(bits);
        let exact = -(-f64::from(x)).exp_m1();
        worst.see((f64::from(one_minus_exp(x)) - exact).abs() / ulp_f32(exact), (f64::from(x), 0.0));
    }
    worst.assert_within(8.0, "one_minus_exp f32");
}

#[test]
fn one_minus_exp_is_total_and_never_above_one() {
    for (x, expected) in [(0.0, 0.0), (-0.0, 0.0), (-1.0, 0.0), (f64::INFINITY, 1.0), (1e300, 1.0), (f64::NAN, 1.0)] {
        assert_eq!(one_minus_exp(x), expected, "at {x}");
        assert_eq!(f64::from(one_minus_exp(x as f32)), expected, "at {x} in f32");
    }
    let mut random = Random(11);
    for _ in 0..20_000 {
        let x = random.spread(-320.0, 3.0);
        assert!((0.0..=1.0).contains(&one_minus_exp(x)) && (0.0..=1.0).contains(&one_minus_exp(x as f32)), "at {x}");
    }
}

#[test]
fn lanes_have_the_bits_of_the_scalar() {
    let mut random = Random(9);
    for _ in 0..5_000 {
        let mut number = || if random.chance(0.1) { f64::from_bits(random.bits()) } else { random.spread(-9.0, 7.0) };
        let (a, b) = ([number(), number()], [number(), number()]);
        let (x, y) = (Pair(b[0], b[1]), Pair(a[0], a[1]));
        let (sin, cos) = sin_cos(y);
        let (angle, wrapped, risen) = (atan2(y, x), wrap(y), one_minus_exp(y));
        for (lane, (&a, &b)) in a.iter().zip(&b).enumerate() {
            let (scalar_sin, scalar_cos) = sin_cos(a);
            let pairs = [
                (sin, scalar_sin),
                (cos, scalar_cos),
                (angle, atan2(a, b)),
                (wrapped, wrap(a)),
                (risen, one_minus_exp(a)),
            ];
            for (lanes, scalar) in pairs {
                let value = lanes.lane(lane);
                // The bits of a NaN are the machine's choice.
                assert!(value.to_bits() == scalar.to_bits() || (value.is_nan() && scalar.is_nan()), "at {a:e}, {b:e}");
            }
        }
    }
}
