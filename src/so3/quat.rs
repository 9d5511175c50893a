//! Unit quaternions, scalar first, that rotate vectors from the sensor frame to the earth frame.

use core::ops::{Mul, Neg};

use super::Vec3;
use crate::scalar::Scalar;

/// A quaternion `[w, x, y, z]` with Hamilton's product.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quat<S> {
    /// Scalar part.
    pub w: S,
    /// First component of the vector part.
    pub x: S,
    /// Second component of the vector part.
    pub y: S,
    /// Third component of the vector part.
    pub z: S,
}

/// A rotation matrix as its three rows: the earth axes seen from the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix3<S> {
    /// The first row.
    pub x: Vec3<S>,
    /// The second row.
    pub y: Vec3<S>,
    /// The third row: the direction of up in the sensor frame.
    pub z: Vec3<S>,
}

impl<S: Scalar> Quat<S> {
    /// The quaternion w + xi + yj + zk.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(w: S, x: S, y: S, z: S) -> Self {
        Quat { w, x, y, z }
    }
    /// The same quaternion in every lane, rounded to the lane's type.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn of([w, x, y, z]: [f64; 4]) -> Self {
        Self::new(S::of(w), S::of(x), S::of(y), S::of(z))
    }
    /// The rotation by nothing.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn identity() -> Self {
        Self::of([1.0, 0.0, 0.0, 0.0])
    }
    /// A quaternion of scalar part `w` and vector part `v`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn from_parts(w: S, v: Vec3<S>) -> Self {
        Self::new(w, v.x, v.y, v.z)
    }
    /// The vector part.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn vector(self) -> Vec3<S> {
        Vec3::new(self.x, self.y, self.z)
    }
    /// The inverse rotation.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn conj(self) -> Self {
        Self::new(self.w, -self.x, -self.y, -self.z)
    }
    /// The scalar product of two quaternions.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn dot(self, other: Self) -> S {
        (self.w * other.w + self.x * other.x) + (self.y * other.y + self.z * other.z)
    }
    /// All components times a factor.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn scale(self, factor: S) -> Self {
        Self::new(self.w * factor, self.x * factor, self.y * factor, self.z * factor)
    }
    /// The sum by components.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn plus(self, other: Self) -> Self {
        Self::new(self.w + other.w, self.x + other.x, self.y + other.y, self.z + other.z)
    }
    /// The quaternion of unit norm with the same direction, or `otherwise` where there is none.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn unit_or(self, otherwise: Self) -> Self {
        let n2 = self.dot(self);
        Self::select(n2.is_normal_norm2(), self.scale(S::one() / n2.sqrt()), otherwise)
    }
    /// Brings a norm that differs from one by rounding only back to one: the first step of Newton's method for
    /// 1/√n, whose error is the square of that difference.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn renormalized(self) -> Self {
        self.scale(S::of(1.5) - S::of(0.5) * self.dot(self))
    }
    /// `yes` where the mask is true, else `no`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn select(mask: S::Mask, yes: Self, no: Self) -> Self {
        Self::new(
            S::select(mask, yes.w, no.w),
            S::select(mask, yes.x, no.x),
            S::select(mask, yes.y, no.y),
            S::select(mask, yes.z, no.z),
        )
    }
    /// The rotation matrix R(q): `v_earth = R v_sensor`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn matrix(self) -> Matrix3<S> {
        let (one, two) = (S::one(), S::of(2.0));
        let (x2, y2, z2) = (two * self.x, two * self.y, two * self.z);
        let (wx, wy, wz) = (self.w * x2, self.w * y2, self.w * z2);
        let (xx, xy, xz) = (self.x * x2, self.x * y2, self.x * z2);
        let (yy, yz, zz) = (self.y * y2, self.y * z2, self.z * z2);
        Matrix3 {
            x: Vec3::new(one - (yy + zz), xy - wz, xz + wy),
            y: Vec3::new(xy + wz, one - (xx + zz), yz - wx),
            z: Vec3::new(xz - wy, yz + wx, one - (xx + yy)),
        }
    }
    /// The vector seen from the earth: `q ⊗ v ⊗ q*`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rotate(self, v: Vec3<S>) -> Vec3<S> {
        self.matrix().apply(v)
    }
    /// The shortest rotation that takes the unit vector `u` to +z; by half a turn about x where u = −z.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn shortest_to_up(u: Vec3<S>) -> Self {
        // Proportional to (1 + u·z, u × z); 1 + u_z without cancellation near −z.
        let across2 = u.x * u.x + u.y * u.y;
        let upper = S::one() + u.z;
        let lower = across2 / (S::one() - u.z);
        let w = S::select(u.z.lt(S::zero()), lower, upper);
        Self::new(w, u.y, -u.x, S::zero()).unit_or(Self::of([0.0, 1.0, 0.0, 0.0]))
    }
    /// The rotation about z that takes the horizontal vector (x, y) of norm `n` to +y.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn turn_to_north(x: S, y: S, n: S) -> Self {
        let southern = y.lt(S::zero());
        let w = S::select(southern, x * x / (n - y), n + y);
        Self::new(w, S::zero(), S::zero(), x).unit_or(Self::of([0.0, 0.0, 0.0, 1.0]))
    }
    /// Calls `visit` for each component.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        visit(&mut self.w);
        visit(&mut self.x);
        visit(&mut self.y);
        visit(&mut self.z);
    }
}

/// Hamilton's product: first the rotation on the right, then the one on the left.
impl<S: Scalar> Mul for Quat<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, r: Self) -> Self {
        Self::new(
            (self.w * r.w - self.x * r.x) - (self.y * r.y + self.z * r.z),
            (self.w * r.x + self.x * r.w) + (self.y * r.z - self.z * r.y),
            (self.w * r.y + self.y * r.w) + (self.z * r.x - self.x * r.z),
            (self.w * r.z + self.z * r.w) + (self.x * r.y - self.y * r.x),
        )
    }
}

impl<S: Scalar> Neg for Quat<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn neg(self) -> Self {
        Self::new(-self.w, -self.x, -self.y, -self.z)
    }
}

impl<S: Scalar> Matrix3<S> {
    /// The vector seen from the earth: R v.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn apply(self, v: Vec3<S>) -> Vec3<S> {
        Vec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }
    /// The vector of the earth seen from the sensor: Rᵀ v.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn transpose_apply(self, v: Vec3<S>) -> Vec3<S> {
        (self.x * v.x + self.y * v.y) + self.z * v.z
    }
}

/// Cosine and sine of half the angle in (−π, π] of the vector (x, y) of norm `n`, without cancellation.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn half_angle<S: Scalar>(x: S, y: S, n: S) -> [S; 2] {
    // (n + x, y) points at half the angle; where that cancels, (|y|, n − x) does.
    let wide = x.lt(S::zero());
    let up = n - x;
    let along = S::select(wide, y.abs(), n + x);
    let across = S::select(wide, S::select(y.lt(S::zero()), -up, up), y);
    let over_norm = S::one() / (along * along + across * across).sqrt();
    [along * over_norm, across * over_norm]
}
