//! Conversions to and from `glam`: nothing is lost, and both rotate alike.

use ahrs_rs::{Quat, Vec3};

use crate::kinds::{directions, rotations};

#[test]
fn glam_quaternions_and_vectors_come_back_bit_for_bit() {
    for (q, v) in rotations::<f64>().into_iter().zip(directions::<f64>()) {
        assert_eq!(Quat::from(::glam::DQuat::from(q)), q);
        assert_eq!(Vec3::from(::glam::DVec3::from(v)), v);
    }
    for (q, v) in rotations::<f32>().into_iter().zip(directions::<f32>()) {
        assert_eq!(Quat::from(::glam::Quat::from(q)), q);
        assert_eq!(Vec3::from(::glam::Vec3::from(v)), v);
    }
}

#[test]
fn glam_rotates_and_multiplies_as_we_do() {
    // Either side rounds by 6 epsilon a rotation and 2 a product.
    for (pair, v) in rotations::<f64>().windows(2).zip(directions::<f64>()) {
        let (a, b) = (::glam::DQuat::from(pair[0]), ::glam::DQuat::from(pair[1]));
        let turned = ::glam::DVec3::from((pair[0] * pair[1]).rotate(v));
        assert!((turned - (a * b) * ::glam::DVec3::from(v)).abs().max_element() <= 16.0 * f64::EPSILON);
    }
    for (pair, v) in rotations::<f32>().windows(2).zip(directions::<f32>()) {
        let (a, b) = (::glam::Quat::from(pair[0]), ::glam::Quat::from(pair[1]));
        let turned = ::glam::Vec3::from((pair[0] * pair[1]).rotate(v));
        assert!((turned - (a * b) * ::glam::Vec3::from(v)).abs().max_element() <= 16.0 * f32::EPSILON);
    }
}
