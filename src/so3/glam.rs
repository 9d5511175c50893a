//! Conversions to and from `glam`, whose quaternions are stored vector part first.

use super::{Quat, Vec3};

macro_rules! conversions {
    ($real:ty, $quat:ty, $vec:ty) => {
        impl From<Quat<$real>> for $quat {
            fn from(q: Quat<$real>) -> Self {
                <$quat>::from_xyzw(q.x, q.y, q.z, q.w)
            }
        }
        impl From<$quat> for Quat<$real> {
            fn from(q: $quat) -> Self {
                Quat { w: q.w, x: q.x, y: q.y, z: q.z }
            }
        }
        impl From<Vec3<$real>> for $vec {
            fn from(v: Vec3<$real>) -> Self {
                <$vec>::new(v.x, v.y, v.z)
            }
        }
        impl From<$vec> for Vec3<$real> {
            fn from(v: $vec) -> Self {
                Vec3 { x: v.x, y: v.y, z: v.z }
            }
        }
    };
}
conversions!(f32, ::glam::Quat, ::glam::Vec3);
conversions!(f64, ::glam::DQuat, ::glam::DVec3);
