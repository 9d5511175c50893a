//! Numbers of some 106 bits as unevaluated sums of two `f64`: the reference that rounding errors are measured against.
//!
//! Sums and products are error-free transformations (Knuth's two-sum; the product's rounding error by a fused
//! multiply-add, which the standard library computes exactly on every machine), so each operation keeps a relative
//! error of a few 2⁻¹⁰⁴: 2⁵⁰ times finer than what is measured.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// `hi + lo` with |lo| at most half a unit in the last place of hi.
#[derive(Clone, Copy, Debug)]
pub struct DoubleDouble {
    pub hi: f64,
    pub lo: f64,
}

/// π/2 to 212 bits, as the sum of four numbers (from Machin's formula in 120 decimal digits).
const HALF_PI: [f64; 4] =
    [std::f64::consts::FRAC_PI_2, 6.123233995736766e-17, -1.4973849048591698e-33, 5.562271104316826e-50];

fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let sum = a + b;
    let from_b = sum - a;
    DoubleDouble { hi: sum, lo: (a - (sum - from_b)) + (b - from_b) }
}

fn two_product(a: f64, b: f64) -> DoubleDouble {
    let product = a * b;
    DoubleDouble { hi: product, lo: a.mul_add(b, -product) }
}

impl DoubleDouble {
    pub const ZERO: Self = DoubleDouble { hi: 0.0, lo: 0.0 };
    pub const ONE: Self = DoubleDouble { hi: 1.0, lo: 0.0 };
    /// π/2.
    pub const QUARTER_TURN: Self = DoubleDouble { hi: HALF_PI[0], lo: HALF_PI[1] };

    pub fn sqrt(self) -> Self {
        if self.hi == 0.0 {
            return Self::ZERO;
        }
        // One step of Newton's method from the root of the leading part doubles its 53 bits.
        let root = Self::from(self.hi.sqrt());
        root + (self - root * root) / (root + root)
    }
}

impl From<f64> for DoubleDouble {
    fn from(value: f64) -> Self {
        DoubleDouble { hi: value, lo: 0.0 }
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    /// Both parts by two-sum: accurate also where the leading parts cancel.
    fn add(self, other: Self) -> Self {
        let (high, low) = (two_sum(self.hi, other.hi), two_sum(self.lo, other.lo));
        let sum = two_sum(high.hi, high.lo + low.hi);
        two_sum(sum.hi, sum.lo + low.lo)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        DoubleDouble { hi: -self.hi, lo: -self.lo }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = two_product(self.hi, other.hi);
        two_sum(product.hi, product.lo + (self.hi * other.lo + self.lo * other.hi))
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    /// Long division in three digits of 53 bits.
    fn div(self, other: Self) -> Self {
        let first = self.hi / other.hi;
        let rest = self - other * Self::from(first);
        let second = rest.hi / other.hi;
        let rest = rest - other * Self::from(second);
        two_sum(first, second) + Self::from(rest.hi / other.hi)
    }
}

/// Sine and cosine of any |angle| up to 2³⁰ or so.
///
/// A whole number of quarter turns is taken away in four parts, each product exact; up to 2³⁰ no `f64` is nearer to a
/// multiple of π/2 than 2⁻⁷⁰, and what is left of π/2 beyond the four parts is 2⁻²¹⁷. The rest is the Taylor series.
#[inline(never)]
pub fn sin_cos(angle: DoubleDouble) -> (DoubleDouble, DoubleDouble) {
    let turns = (angle.hi / HALF_PI[0]).round();
    let rest = HALF_PI.iter().fold(angle, |rest, &part| rest - two_product(turns, part));
    let square = rest * rest;
    let (mut sin, mut cos) = (DoubleDouble::ZERO, DoubleDouble::ZERO);
    let mut term = DoubleDouble::ONE;
    // Terms up to x²⁹/29!: at π/4 the next is 2⁻¹¹⁸.
    for power in 0..30_u32 {
        let sign = if power % 4 < 2 { term } else { -term };
        if power % 2 == 0 {
            cos = cos + sign;
        } else {
            sin = sin + sign;
        }
        // Even powers carry the square's powers alone; the odd ones share them and are multiplied by x at the end.
        if power % 2 == 1 {
            term = term * square;
        }
        term = term / DoubleDouble::from(f64::from(power + 1));
    }
    let sin = sin * rest;
    match turns as i64 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// The angle of the point (x, y), by one step of Newton's method from the standard library's: of an error of 2⁻⁵²
/// its cube is left.
pub fn atan2(y: f64, x: f64) -> DoubleDouble {
    let start = DoubleDouble::from(y.atan2(x));
    let (sin, cos) = sin_cos(start);
    let (y, x) = (DoubleDouble::from(y), DoubleDouble::from(x));
    start + (y * cos - x * sin) / (x * cos + y * sin)
}

/// |value − exact| in units in the last place of the exact value.
pub fn ulps(value: f64, exact: DoubleDouble) -> f64 {
    let ulp = f64::from_bits(exact.hi.abs().max(f64::MIN_POSITIVE).to_bits() & !((1 << 52) - 1)) * f64::EPSILON;
    (((value - exact.hi) - exact.lo) / ulp).abs()
}
