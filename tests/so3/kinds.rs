//! Examples for every kind of scalar, different in each lane, and what is measured on them.

use ahrs_rs::{Quat, Real, Scalar, Vec3};

use crate::random::Random;

/// The epsilon of the lane's type.
pub fn epsilon<S: Scalar>() -> f64 {
    S::Real::EPSILON.to_f64()
}

/// A scalar whose lanes are given one by one.
pub fn scalar<S: Scalar>(mut lane: impl FnMut() -> f64) -> S {
    let mut value = S::zero();
    for index in 0..S::LANES {
        value.set_lane(index, S::Real::from_f64(lane()));
    }
    value
}

/// A vector whose lanes are given one by one.
pub fn vector<S: Scalar>(mut lane: impl FnMut() -> [f64; 3]) -> Vec3<S> {
    let lanes: Vec<_> = (0..S::LANES).map(|_| lane()).collect();
    let [x, y, z] = [0, 1, 2].map(|part| {
        let mut lane = lanes.iter();
        scalar(|| lane.next().map_or(f64::NAN, |v| v[part]))
    });
    Vec3::new(x, y, z)
}

/// A quaternion whose lanes are given one by one.
pub fn quaternion<S: Scalar>(mut lane: impl FnMut() -> [f64; 4]) -> Quat<S> {
    let lanes: Vec<_> = (0..S::LANES).map(|_| lane()).collect();
    let [w, x, y, z] = [0, 1, 2, 3].map(|part| {
        let mut lane = lanes.iter();
        scalar(|| lane.next().map_or(f64::NAN, |q| q[part]))
    });
    Quat::new(w, x, y, z)
}

/// A lane of a vector, exactly.
pub fn lane3<S: Scalar>(v: Vec3<S>, lane: usize) -> [f64; 3] {
    [v.x, v.y, v.z].map(|c| c.lane(lane).to_f64())
}

/// A lane of a quaternion, exactly.
pub fn lane4<S: Scalar>(q: Quat<S>, lane: usize) -> [f64; 4] {
    [q.w, q.x, q.y, q.z].map(|c| c.lane(lane).to_f64())
}

/// The norm.
pub fn norm<const N: usize>(v: [f64; N]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// The largest difference of two components, NaN if one is.
pub fn distance<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, |worst, d| if d <= worst { worst } else { d })
}

/// Asserts that two quaternions agree in every lane to `bound` epsilon.
#[track_caller]
pub fn assert_near<S: Scalar>(a: Quat<S>, b: Quat<S>, bound: f64) {
    for lane in 0..S::LANES {
        let (a, b) = (lane4(a, lane), lane4(b, lane));
        let error = distance(a, b) / epsilon::<S>();
        assert!(error <= bound, "lane {lane}: {a:?} and {b:?} differ by {error} epsilon, more than {bound}");
    }
}

/// Asserts that two vectors agree in every lane to `bound` epsilon.
#[track_caller]
pub fn assert_near3<S: Scalar>(a: Vec3<S>, b: Vec3<S>, bound: f64) {
    for lane in 0..S::LANES {
        let (a, b) = (lane3(a, lane), lane3(b, lane));
        let error = distance(a, b) / epsilon::<S>();
        assert!(error <= bound, "lane {lane}: {a:?} and {b:?} differ by {error} epsilon, more than {bound}");
    }
}

/// Rotations: the identity, half turns about the axes, others about diagonals, and many at random.
pub fn rotations<S: Scalar>() -> Vec<Quat<S>> {
    const H: f64 = std::f64::consts::FRAC_1_SQRT_2;
    let special = [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, -1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [-1.0, 0.0, 0.0, 0.0],
        [H, 0.0, H, 0.0],
        [H, -H, 0.0, 0.0],
        [0.5, 0.5, 0.5, 0.5],
        [1.0, 1e-9, 0.0, 0.0],
    ];
    let mut random = Random(S::LANES as u64);
    (0..60)
        .map(|k| {
            let mut index = k;
            quaternion(|| {
                index += 1;
                special.get(index).copied().unwrap_or_else(|| random.rotation())
            })
        })
        .collect()
}

/// Unit vectors: the axes and many at random.
pub fn directions<S: Scalar>() -> Vec<Vec3<S>> {
    let special = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let mut random = Random(100 + S::LANES as u64);
    (0..60)
        .map(|k| {
            let mut index = k;
            vector(|| {
                index += 1;
                special.get(index).copied().unwrap_or_else(|| random.direction())
            })
        })
        .collect()
}

pub fn there_are_examples_that_differ_from_lane_to_lane<S: Scalar>() {
    assert!(S::LANES > 0);
    assert!(rotations::<S>().len() >= 50 && directions::<S>().len() >= 50);
    for q in rotations::<S>() {
        for lane in 0..S::LANES {
            // The norm of a rounded unit quaternion differs from one by at most an epsilon.
            assert!((norm(lane4(q, lane)) - 1.0).abs() <= epsilon::<S>());
            assert!(lane == 0 || lane4(q, lane) != lane4(q, 0), "lanes 0 and {lane} are one example");
        }
    }
}
