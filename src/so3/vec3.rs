//! Vectors in space.

use core::ops::{Add, Mul, Neg, Sub};

use crate::scalar::Scalar;

/// A vector in the sensor frame or the earth frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vec3<S> {
    /// First component.
    pub x: S,
    /// Second component.
    pub y: S,
    /// Third component.
    pub z: S,
}

impl<S: Scalar> Vec3<S> {
    /// The vector (x, y, z).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(x: S, y: S, z: S) -> Self {
        Vec3 { x, y, z }
    }
    /// The zero vector.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn zero() -> Self {
        Self::new(S::zero(), S::zero(), S::zero())
    }
    /// The same vector in every lane, rounded to the lane's type.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn of([x, y, z]: [f64; 3]) -> Self {
        Self::new(S::of(x), S::of(y), S::of(z))
    }
    /// The scalar product.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn dot(self, other: Self) -> S {
        (self.x * other.x + self.y * other.y) + self.z * other.z
    }
    /// The vector product.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn cross(self, other: Self) -> Self {
        Self::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }
    /// The squared Euclidean norm.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn norm2(self) -> S {
        self.dot(self)
    }
    /// The vector of unit length in the same direction; NaN or infinite for the zero vector.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn unit(self) -> Self {
        self * (S::one() / self.norm2().sqrt())
    }
    /// `yes` where the mask is true, else `no`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn select(mask: S::Mask, yes: Self, no: Self) -> Self {
        Self::new(S::select(mask, yes.x, no.x), S::select(mask, yes.y, no.y), S::select(mask, yes.z, no.z))
    }
    /// Calls `visit` for each component.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        visit(&mut self.x);
        visit(&mut self.y);
        visit(&mut self.z);
    }
}

impl<S: Scalar> Add for Vec3<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<S: Scalar> Sub for Vec3<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<S: Scalar> Mul<S> for Vec3<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, factor: S) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl<S: Scalar> Neg for Vec3<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}
