//! Products, norms, matrices.

use ahrs_rs::{Quat, Real, Scalar};

use crate::kinds::{
    assert_near, assert_near3, directions, distance, epsilon, lane3, lane4, norm, quaternion, rotations, scalar,
};
use crate::outlined::{multiply, rotate, unit_or};
use crate::random::Random;

/// Each example with the two that follow it.
fn triples<S: Scalar>() -> impl Iterator<Item = (Quat<S>, Quat<S>, Quat<S>)> {
    let all = rotations::<S>();
    (0..all.len() - 2).map(move |k| (all[k], all[k + 1], all[k + 2]))
}

pub fn multiplication_is_associative<S: Scalar>() {
    for (a, b, c) in triples::<S>() {
        // Two products on each side, each rounding by 2 epsilon.
        assert_near(multiply(multiply(a, b), c), multiply(a, multiply(b, c)), 8.0);
        assert_near(multiply(a, Quat::identity()), a, 0.0);
        assert_near(multiply(Quat::identity(), a), a, 0.0);
    }
}

pub fn the_conjugate_is_the_inverse<S: Scalar>() {
    for q in rotations::<S>() {
        // One product, and twice the epsilon by which the norm may differ from one.
        assert_near(multiply(q, q.conj()), Quat::identity(), 4.0);
        assert_near(multiply(q.conj(), q), Quat::identity(), 4.0);
    }
    for (a, b, _) in triples::<S>() {
        assert_near(multiply(a, b).conj(), multiply(b.conj(), a.conj()), 4.0);
    }
}

pub fn the_norm_is_multiplicative<S: Scalar>() {
    let mut random = Random(11);
    for (a, b, _) in triples::<S>() {
        let (a, b) = (a.scale(scalar(|| random.uniform(0.1, 10.0))), b.scale(scalar(|| random.uniform(0.1, 10.0))));
        for lane in 0..S::LANES {
            let expected = norm(lane4(a, lane)) * norm(lane4(b, lane));
            // Four components that each round by 2 epsilon of the product of the norms: at most 4 epsilon of it.
            let error = (norm(lane4(multiply(a, b), lane)) / expected - 1.0).abs();
            assert!(error <= 4.0 * epsilon::<S>(), "lane {lane}: {error:e}");
        }
    }
}

pub fn rotation_is_a_homomorphism<S: Scalar>() {
    for ((a, b, _), v) in triples::<S>().zip(directions::<S>()) {
        // Three rotations of 6 epsilon each and the product, which turns by 4 more.
        assert_near3(rotate(multiply(a, b), v), rotate(a, rotate(b, v)), 24.0);
        assert_near3(rotate(a.conj(), rotate(a, v)), v, 16.0);
    }
}

pub fn the_matrix_is_orthonormal_and_right_handed<S: Scalar>() {
    for q in rotations::<S>() {
        let m = q.matrix();
        let rows = [m.x, m.y, m.z];
        for (i, &a) in rows.iter().enumerate() {
            for (j, &b) in rows.iter().enumerate() {
                for lane in 0..S::LANES {
                    let dot: f64 = lane3(a, lane).iter().zip(lane3(b, lane)).map(|(a, b)| a * b).sum();
                    // Each entry rounds by 2 epsilon and the norm by one, which the entries double.
                    let error = (dot - f64::from(u8::from(i == j))).abs();
                    assert!(error <= 12.0 * epsilon::<S>(), "rows {i} and {j}, lane {lane}: {error:e}");
                }
            }
        }
        assert_near3(m.x.cross(m.y), m.z, 12.0);
    }
}

pub fn the_matrix_rotates_as_the_quaternion<S: Scalar>() {
    for (q, v) in rotations::<S>().into_iter().zip(directions::<S>()) {
        // Two products on one side, three rows on the other.
        let turned = multiply(multiply(q, Quat::from_parts(S::zero(), v)), q.conj()).vector();
        assert_near3(rotate(q, v), turned, 12.0);
        assert_near3(q.matrix().apply(v), rotate(q, v), 0.0);
        assert_near3(q.matrix().transpose_apply(v), rotate(q.conj(), v), 12.0);
    }
}

pub fn a_quaternion_and_its_negative_are_one_rotation<S: Scalar>() {
    for (q, v) in rotations::<S>().into_iter().zip(directions::<S>()) {
        assert_near3(rotate(-q, v), rotate(q, v), 0.0);
    }
}

pub fn selection_is_by_lane<S: Scalar>() {
    let all = rotations::<S>();
    for pair in all.windows(2) {
        let first = pair[0].w.lt(pair[1].w);
        let chosen = Quat::select(first, pair[0], pair[1]);
        for lane in 0..S::LANES {
            let from = if lane4(pair[0], lane)[0] < lane4(pair[1], lane)[0] { pair[0] } else { pair[1] };
            assert_eq!(lane4(chosen, lane), lane4(from, lane));
        }
    }
}

pub fn renormalization_squares_the_error<S: Scalar>() {
    let mut random = Random(12);
    for q in rotations::<S>() {
        for power in [-2.0, -4.0, -8.0] {
            let error = 10.0_f64.powf(power);
            let off = q.scale(scalar(|| 1.0 + random.uniform(-error, error)));
            for lane in 0..S::LANES {
                // Newton's step leaves 3/2 of the square, and half of the cube; the squared norm, the factor and the
                // product round by 3 epsilon together.
                let left = (norm(lane4(off.renormalized(), lane)) - 1.0).abs();
                assert!(left <= 1.6 * error * error + 3.0 * epsilon::<S>(), "{error:e}: {left:e}");
            }
        }
    }
}

pub fn a_quaternion_is_scaled_to_unit_norm_wherever_it_has_a_direction<S: Scalar>() {
    let otherwise = Quat::of([0.5, -0.5, 0.5, -0.5]);
    let none = [0.0, f64::NAN, f64::INFINITY, S::Real::MAX.to_f64(), S::Real::MIN_NORMAL.to_f64()];
    for q in rotations::<S>() {
        for factor in none {
            assert_near(unit_or(q.scale(S::of(factor)), otherwise), otherwise, 0.0);
        }
        // The root of the largest and of the smallest normal number, with a margin of ten.
        for factor in [1.0, 3.0, 0.1 * S::Real::MAX.to_f64().sqrt(), 10.0 * S::Real::MIN_NORMAL.to_f64().sqrt()] {
            // The scaling in and out, the root, the division and the squares: 4 epsilon.
            assert_near(unit_or(q.scale(S::of(factor)), otherwise), q, 4.0);
        }
    }
    // A lane without a direction leaves the others alone.
    let mut count = 0;
    let mixed = quaternion::<S>(|| {
        count += 1;
        if count % 2 == 0 { [f64::NAN; 4] } else { [0.0, 3.0, 4.0, 0.0] }
    });
    for lane in 0..S::LANES {
        let expected = if lane % 2 == 1 { [0.5, -0.5, 0.5, -0.5] } else { [0.0, 0.6, 0.8, 0.0] };
        assert!(distance(lane4(unit_or(mixed, otherwise), lane), expected) <= epsilon::<S>());
    }
}
