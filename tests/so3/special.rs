//! The rotations that alignment needs, and the frames.

use ahrs_rs::{Frame, Quat, Scalar, Vec3};

use crate::kinds::{assert_near, assert_near3, directions, epsilon, lane3, lane4, norm, vector};
use crate::outlined::{rotate, shortest_to_up, turn_to_north};
use crate::random::Random;

pub fn the_shortest_rotation_takes_a_direction_up<S: Scalar>() {
    let mut random = Random(41);
    let mut cases = directions::<S>();
    // Close to −z, from where the square of the distance is rounded off to where it vanishes in f64.
    for away in [1e-3, 1e-8, 1e-15, 1e-20, 1e-100, 1e-160, 1e-200, 0.0] {
        cases.push(vector(|| {
            let heading = random.uniform(-3.0, 3.0);
            [away * heading.cos(), away * heading.sin(), -(1.0 - away * away).sqrt()]
        }));
    }
    for u in cases {
        let q = shortest_to_up(u);
        // The direction of u may be an epsilon long or short, which the turn shares; then a rotation of 6.
        assert_near3(rotate(q, u), Vec3::of([0.0, 0.0, 1.0]), 10.0);
        for lane in 0..S::LANES {
            let [w, x, y, z] = lane4(q, lane);
            assert_eq!(z, 0.0, "the axis is horizontal");
            // Shortest: by the angle between u and z, of which w is the half's cosine.
            assert!(w >= 0.0);
            let expected = (0.5 * (1.0 + lane3(u, lane)[2])).max(0.0);
            assert!((w * w - expected).abs() <= 4.0 * epsilon::<S>(), "{w}² is not {expected}");
            // A division, a root and a product after the squares.
            assert!((norm([w, x, y, z]) - 1.0).abs() <= 3.0 * epsilon::<S>());
        }
    }
    assert_near(shortest_to_up(Vec3::<S>::of([0.0, 0.0, 1.0])), Quat::identity(), 0.0);
    assert_near(shortest_to_up(Vec3::<S>::of([0.0, 0.0, -1.0])), Quat::of([0.0, 1.0, 0.0, 0.0]), 0.0);
}

pub fn the_turn_to_north_takes_a_horizontal_vector_to_y<S: Scalar>() {
    let mut random = Random(42);
    let mut cases: Vec<Vec3<S>> = Vec::new();
    for _ in 0..50 {
        cases.push(vector(|| {
            // The horizontal part of a unit vector is at least 1e-6, or there is no heading.
            let (length, heading) = (random.uniform(1e-6, 1.0), random.uniform(-4.0, 4.0));
            [length * heading.sin(), length * heading.cos(), 0.0]
        }));
    }
    // Close to south, where half a turn's sign and its cosine matter.
    for away in [1e-3, 1e-8, 1e-20, 1e-160, 0.0] {
        cases.push(Vec3::of([away, -1.0, 0.0]));
        cases.push(Vec3::of([-away, -1.0, 0.0]));
        cases.push(Vec3::of([away, 1.0, 0.0]));
    }
    for v in cases {
        let length = (v.x * v.x + v.y * v.y).sqrt();
        let q = turn_to_north(v.x, v.y, length);
        for lane in 0..S::LANES {
            let [w, x, y, z] = lane4(q, lane);
            assert_eq!((x, y), (0.0, 0.0), "the axis is vertical");
            assert!((norm([w, z]) - 1.0).abs() <= 3.0 * epsilon::<S>());
        }
        // As for the shortest rotation, relative to the length.
        assert_near3(rotate(q, v * (S::one() / length)), Vec3::of([0.0, 1.0, 0.0]), 12.0);
    }
    let south = turn_to_north(S::zero(), -S::one(), S::one());
    assert_near(south, Quat::of([0.0, 0.0, 0.0, 1.0]), 0.0);
}

pub fn frames_are_rotations_with_the_named_axes<S: Scalar>() {
    let (east, north, up) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let (west, down) = (east.map(|c: f64| -c), up.map(|c: f64| -c));
    let axes = [(Frame::Enu, [east, north, up]), (Frame::Ned, [north, east, down]), (Frame::Nwu, [north, west, up])];
    assert_eq!(axes.map(|(frame, _)| frame), Frame::ALL.map(|(_, frame)| frame), "every frame has its row");
    for (frame, [x, y, z]) in axes {
        let c: Quat<S> = frame.from_enu();
        // The rounding of √½, twice, and a rotation.
        assert_near3(rotate(c, Vec3::of(x)), Vec3::of([1.0, 0.0, 0.0]), 4.0);
        assert_near3(rotate(c, Vec3::of(y)), Vec3::of([0.0, 1.0, 0.0]), 4.0);
        assert_near3(rotate(c, Vec3::of(z)), Vec3::of([0.0, 0.0, 1.0]), 4.0);
        assert!((norm(lane4(c, 0)) - 1.0).abs() <= epsilon::<S>());
    }
    for (name, frame) in Frame::ALL {
        assert_eq!(Frame::from_name(name), Some(frame));
    }
    assert_eq!(Frame::from_name("enu"), None);
}
