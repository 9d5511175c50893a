//! The exponential map and the steps that integrate an angular rate.

use ahrs_rs::{Quat, Real, Scalar, Vec3};

use crate::double_double::{DoubleDouble, sin_cos};
use crate::kinds::{assert_near, directions, distance, epsilon, lane3, lane4, norm, rotations, scalar, vector};
use crate::outlined::{exp_half, first_order_step, multiply, rotate_by};
use crate::random::Random;

/// Vectors of every length up to the range, small ones first.
fn vectors<S: Scalar>() -> Vec<Vec3<S>> {
    let mut random = Random(21);
    let longest = S::Real::ANGLE_RANGE.log10() - 1e-6;
    // Lengths far below the root of the smallest normal number, where squares vanish; around one; over the range.
    let scales = [(-45.0, -20.0), (-20.0, -1.0), (-1.0, 1.0), (1.0, longest)];
    let lengths = scales.iter().flat_map(|&range| [range; 40]);
    lengths
        .map(|(low, high)| {
            vector(|| {
                let length = random.spread(low, high);
                random.direction().map(|c| c * length)
            })
        })
        .collect()
}

/// exp(v) to 100 bits, rounded.
fn reference(v: [f64; 3]) -> [f64; 4] {
    let square =
        v.iter().map(|&c| DoubleDouble::from(c) * DoubleDouble::from(c)).fold(DoubleDouble::ZERO, |s, c| s + c);
    let angle = square.sqrt();
    let (sin, cos) = sin_cos(angle);
    let sinc = if angle.hi > 0.0 { sin / angle } else { DoubleDouble::ONE };
    let [x, y, z] = v.map(|c| (DoubleDouble::from(c) * sinc).hi);
    [cos.hi, x, y, z]
}

pub fn the_exponential_agrees_with_a_reference_of_100_bits<S: Scalar>() {
    for v in vectors::<S>() {
        for lane in 0..S::LANES {
            let (value, length) = (lane4(exp_half(v), lane), norm(lane3(v, lane)));
            // Sine and cosine are within 3 ulp, the product with v rounds twice more; the length itself, of three
            // squares and a root, rounds by one epsilon of it, and that turns the result.
            let bound = (5.0 + length) * epsilon::<S>();
            let error = distance(value, reference(lane3(v, lane)));
            assert!(error <= bound, "lane {lane}, |v| = {length:e}: {error:e}, more than {bound:e}");
            // The norm does not suffer from the length: 2·3 ulp of sine and cosine, and the length's epsilon.
            let error = (norm(value) - 1.0).abs();
            assert!(error <= 6.0 * epsilon::<S>(), "lane {lane}, |v| = {length:e}: norm off by {error:e}");
        }
    }
}

pub fn exponentials_of_parallel_vectors_add<S: Scalar>() {
    for v in vectors::<S>() {
        // Halves and quarters are exact, and three quarters are one rounding.
        let (half, quarter) = (v * S::of(0.5), v * S::of(0.25));
        let (sum, whole) = (multiply(exp_half(half), exp_half(quarter)), exp_half(half + quarter));
        for lane in 0..S::LANES {
            // Three exponentials as above, whose lengths add up to 1.5 |v|, and a product of 2 epsilon.
            let bound = (17.0 + 1.5 * norm(lane3(v, lane))) * epsilon::<S>();
            let error = distance(lane4(sum, lane), lane4(whole, lane));
            assert!(error <= bound, "lane {lane}: {error:e}, more than {bound:e}");
        }
    }
}

pub fn the_exponential_of_the_negative_is_the_inverse<S: Scalar>() {
    for v in vectors::<S>() {
        assert_near(exp_half(-v), exp_half(v).conj(), 0.0);
    }
    assert_near(exp_half(Vec3::<S>::zero()), Quat::identity(), 0.0);
}

pub fn the_exponential_of_what_is_beyond_its_range_is_the_identity<S: Scalar>() {
    let range = S::Real::ANGLE_RANGE;
    for length in [range * 1.001, range * 1e3, 1e30, 1e200, f64::INFINITY, f64::NAN] {
        for part in 0..3 {
            let mut v = [0.5, -0.5, 0.5];
            v[part] = length;
            assert_near(exp_half(Vec3::<S>::of(v)), Quat::identity(), 0.0);
        }
        // Beside a lane that is in range, which keeps its own.
        let mut count = 0;
        let mixed = vector::<S>(|| {
            count += 1;
            if count % 2 == 0 { [length, 0.0, 0.0] } else { [0.0, 1.0, 0.0] }
        });
        for lane in 0..S::LANES {
            let expected = if lane % 2 == 1 { [1.0, 0.0, 0.0, 0.0] } else { reference([0.0, 1.0, 0.0]) };
            assert!(distance(lane4(exp_half(mixed), lane), expected) <= 5.0 * epsilon::<S>());
        }
    }
}

pub fn rotate_by_turns_by_rate_times_time<S: Scalar>() {
    let mut random = Random(22);
    for (q, axis) in rotations::<S>().into_iter().zip(directions::<S>()) {
        let (speed, dt) = (scalar::<S>(|| random.uniform(0.0, 30.0)), scalar::<S>(|| random.uniform(0.0, 0.2)));
        let turned = rotate_by(q, axis * speed, dt);
        // Half angles up to 3 rad, the renormalization of 3 epsilon, the product, and three roundings of v.
        assert_near(turned, multiply(q, exp_half(axis * (speed * dt * S::of(0.5)))), 20.0);
        // A second of a rate is the rotation by it: back by the negative rate.
        assert_near(rotate_by(turned, axis * -speed, dt), q, 24.0);
        assert_near(rotate_by(q, axis * speed, S::zero()), q, 4.0);
    }
}

pub fn the_first_order_step_is_short_by_a_third_of_the_cube<S: Scalar>() {
    // Normalised, q + ½ q ω dt turns by atan h for the half angle h = |ω| dt/2: short by h³/3 − h⁵/5 …
    let half_angle: f64 = 0.05;
    for (q, axis) in rotations::<S>().into_iter().zip(directions::<S>()) {
        let rate = axis * S::of(2.0 * half_angle);
        let q_dot = multiply(q, Quat::from_parts(S::zero(), axis * S::of(half_angle)));
        let short = multiply(first_order_step(q, q_dot).conj(), rotate_by(q, rate, S::one()));
        for lane in 0..S::LANES {
            let missing = norm(lane3(short.vector(), lane));
            let expected = (half_angle - half_angle.atan()).sin();
            // Products, exponential and normalisation round by some 12 epsilon in all.
            assert!((missing - expected).abs() <= 12.0 * epsilon::<S>(), "lane {lane}: {missing:e}, {expected:e}");
        }
        // Where the sum vanishes there is no direction, and the attitude stays.
        assert_near(first_order_step(q, -q), q, 0.0);
        assert_near(first_order_step(q, q.scale(S::of(f64::NAN))), q, 0.0);
    }
}
