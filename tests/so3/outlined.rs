//! The functions under test, each compiled once for a kind of scalar.
//!
//! In the library they are inlined wherever they are called; so many copies of lane code would take minutes to compile.

use ahrs_rs::{Euler, Quat, Scalar, Vec3, so3};

#[inline(never)]
pub fn rotate<S: Scalar>(q: Quat<S>, v: Vec3<S>) -> Vec3<S> {
    q.rotate(v)
}
#[inline(never)]
pub fn multiply<S: Scalar>(a: Quat<S>, b: Quat<S>) -> Quat<S> {
    a * b
}
#[inline(never)]
pub fn unit_or<S: Scalar>(q: Quat<S>, otherwise: Quat<S>) -> Quat<S> {
    q.unit_or(otherwise)
}
#[inline(never)]
pub fn exp_half<S: Scalar>(v: Vec3<S>) -> Quat<S> {
    so3::exp_half(v)
}
#[inline(never)]
pub fn rotate_by<S: Scalar>(q: Quat<S>, rate: Vec3<S>, dt: S) -> Quat<S> {
    so3::rotate_by(q, rate, dt)
}
#[inline(never)]
pub fn first_order_step<S: Scalar>(q: Quat<S>, change: Quat<S>) -> Quat<S> {
    so3::first_order_step(q, change)
}
#[inline(never)]
pub fn euler_angles<S: Scalar>(q: Quat<S>) -> Euler<S> {
    Euler::from_quat(q)
}
#[inline(never)]
pub fn from_euler_angles<S: Scalar>(e: Euler<S>) -> Quat<S> {
    e.to_quat()
}
#[inline(never)]
pub fn shortest_to_up<S: Scalar>(u: Vec3<S>) -> Quat<S> {
    Quat::shortest_to_up(u)
}
#[inline(never)]
pub fn turn_to_north<S: Scalar>(x: S, y: S, n: S) -> Quat<S> {
    Quat::turn_to_north(x, y, n)
}
