//! What a filter computes with: `f32`, `f64`, or [`Pair`](crate::Pair)s of either, or of vector registers.
//!
//! Everything above this trait is written once. Comparisons give masks and choices are made by `select`, so the same
//! source runs on one value and on many side by side with the same bits. There is no fused multiply-add: its result
//! would depend on the machine.

use core::fmt::Debug;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// The outcome of a comparison, one per lane.
pub trait Mask:
    Copy + Debug + Send + Sync + 'static + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// The same outcome in every lane.
    fn splat(value: bool) -> Self;
    /// True where every lane is.
    fn all(self) -> bool;
    /// True where at least one lane is.
    fn any(self) -> bool;
    /// The outcome in lane `index`; false beyond the last lane.
    fn lane(self, index: usize) -> bool;
    /// Sets lane `index`; does nothing beyond the last lane.
    fn set_lane(&mut self, index: usize, value: bool);
}

/// A number, or several that are computed side by side.
pub trait Scalar:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The floating-point type of one lane.
    type Real: Real;
    /// What comparisons give.
    type Mask: Mask;
    /// How many numbers are computed side by side.
    const LANES: usize;

    /// The same number in every lane, rounded to the lane's type.
    fn splat(value: Self::Real) -> Self;
    /// The number in lane `index`; NaN beyond the last lane.
    fn lane(self, index: usize) -> Self::Real;
    /// Sets lane `index`; does nothing beyond the last lane.
    fn set_lane(&mut self, index: usize, value: Self::Real);
    /// The correctly rounded square root.
    fn sqrt(self) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
    /// `self < other`, false where either is NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`, false where either is NaN.
    fn le(self, other: Self) -> Self::Mask;
    /// `yes` where the mask is true, else `no`; what is not chosen may be NaN.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// A constant, rounded to the lane's type.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of(value: f64) -> Self {
        Self::splat(Self::Real::from_f64(value))
    }
    /// Zero.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn zero() -> Self {
        Self::of(0.0)
    }
    /// One.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn one() -> Self {
        Self::of(1.0)
    }
    /// The smaller of two numbers; `other` where `self` is NaN.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }
    /// The larger of two numbers; `other` where `self` is NaN.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn max(self, other: Self) -> Self {
        Self::select(other.lt(self), self, other)
    }
    /// The nearest whole number, ties to even, for |x| below a quarter of the largest exactly represented integer.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn round(self) -> Self {
        let magic = Self::splat(Self::Real::ROUND);
        (self + magic) - magic
    }
    /// True where the number is finite and at least the smallest normal number: usable as a squared norm.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_normal_norm2(self) -> Self::Mask {
        Self::splat(Self::Real::MIN_NORMAL).le(self) & self.le(Self::splat(Self::Real::MAX))
    }
}

/// (1 − exp(−y))/y in powers of y: Taylor's series, exact to rounding for y ≤ ¼.
const ONE_MINUS_EXP: [(f64, f64); 6] = [
    (1.0, -1.0 / 2.0),
    (1.0 / 6.0, -1.0 / 24.0),
    (1.0 / 120.0, -1.0 / 720.0),
    (1.0 / 5040.0, -1.0 / 40320.0),
    (1.0 / 362_880.0, -1.0 / 3_628_800.0),
    (1.0 / 39_916_800.0, -1.0 / 479_001_600.0),
];

/// The same in `f32`: rounded by the compiler, so that no program has to do it.
#[allow(clippy::indexing_slicing, reason = "by a counter below the size; a constant is computed")]
const fn narrowed<const N: usize>(pairs: [(f64, f64); N]) -> [(f32, f32); N] {
    let mut rounded = [(0.0, 0.0); N];
    let mut i = 0;
    while i < N {
        rounded[i] = (pairs[i].0 as f32, pairs[i].1 as f32);
        i += 1;
    }
    rounded
}

/// The floating-point type of one lane, with the constants in which `f32` and `f64` differ.
pub trait Real: Scalar<Real = Self, Mask = bool> {
    /// Adding and subtracting it rounds to a whole number.
    const ROUND: Self;
    /// The smallest normal number.
    const MIN_NORMAL: Self;
    /// The largest finite number.
    const MAX: Self;
    /// What stands for a number that there is not.
    const NAN: Self;
    /// The distance from one to the next larger number.
    const EPSILON: Self;
    /// Half-angles up to here are reduced exactly by [`trig::sin_cos`](crate::trig::sin_cos); in rad.
    const ANGLE_RANGE: f64;
    /// The norm of a gradient below which its direction is rounding noise.
    const GRADIENT_FLOOR: f64;
    /// |cos pitch| below which roll and yaw are one angle to rounding: their noise stays at the square root of epsilon.
    const COS_PITCH_FLOOR: f64;
    /// π/2 in three parts; a whole number of quarter turns up to `ANGLE_RANGE` times one of the first two is exact.
    const HALF_PI_PARTS: [f64; 3];
    /// (sin x / x − 1)/x² in powers of x², for |x| ≤ π/4, in pairs of neighbouring powers.
    const SIN: &'static [(Self, Self)];
    /// (cos x − 1 + x²/2)/x⁴ in powers of x², for |x| ≤ π/4, in pairs.
    const COS: &'static [(Self, Self)];
    /// (1 − atan x / x)/x² in powers of x², for |x| ≤ tan π/8, in pairs.
    const ATAN: &'static [(Self, Self)];
    /// (1 − exp(−y))/y in powers of y, for 0 ≤ y ≤ ¼, in pairs.
    const ONE_MINUS_EXP: &'static [(Self, Self)];

    /// Rounds to this type.
    fn from_f64(value: f64) -> Self;
    /// The exact value.
    fn to_f64(self) -> f64;
}

impl Mask for bool {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn splat(value: bool) -> Self {
        value
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn all(self) -> bool {
        self
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn any(self) -> bool {
        self
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane(self, index: usize) -> bool {
        self && index == 0
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_lane(&mut self, index: usize, value: bool) {
        if index == 0 {
            *self = value;
        }
    }
}

/// The only place where the platform's mathematics is used: the square root is exact everywhere.
macro_rules! scalar {
    ($real:ty, $sqrtf:ident) => {
        impl Scalar for $real {
            type Real = $real;
            type Mask = bool;
            const LANES: usize = 1;

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn splat(value: $real) -> Self {
                value
            }
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn lane(self, index: usize) -> $real {
                if index == 0 { self } else { <$real>::NAN }
            }
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn set_lane(&mut self, index: usize, value: $real) {
                if index == 0 {
                    *self = value;
                }
            }
            #[cfg(feature = "std")]
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn sqrt(self) -> Self {
                <$real>::sqrt(self)
            }
            #[cfg(all(feature = "libm", not(feature = "std")))]
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn sqrt(self) -> Self {
                libm::$sqrtf(self)
            }
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn abs(self) -> Self {
                <$real>::abs(self)
            }
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn le(self, other: Self) -> bool {
                self <= other
            }
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
        }
    };
}
scalar!(f32, sqrtf);
scalar!(f64, sqrt);

impl Real for f64 {
    const ROUND: f64 = 6755399441055744.0; // 1.5 · 2^52
    const MIN_NORMAL: f64 = f64::MIN_POSITIVE;
    const MAX: f64 = f64::MAX;
    const NAN: f64 = f64::NAN;
    const EPSILON: f64 = f64::EPSILON;
    const ANGLE_RANGE: f64 = 1.0e6;
    const GRADIENT_FLOOR: f64 = 1e-12;
    const COS_PITCH_FLOOR: f64 = 1e-6;
    const HALF_PI_PARTS: [f64; 3] = [1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21];
    // Minimax coefficients as published with fdlibm (k_sin, k_cos, s_atan).
    const SIN: &'static [(f64, f64)] = &[
        (-1.66666666666666324348e-01, 8.33333333332248946124e-03),
        (-1.98412698298579493134e-04, 2.75573137070700676789e-06),
        (-2.50507602534068634195e-08, 1.58969099521155010221e-10),
    ];
    const COS: &'static [(f64, f64)] = &[
        (4.16666666666666019037e-02, -1.38888888888741095749e-03),
        (2.48015872894767294178e-05, -2.75573143513906633035e-07),
        (2.08757232129817482790e-09, -1.13596475577881948265e-11),
    ];
    const ATAN: &'static [(f64, f64)] = &[
        (3.33333333333329318027e-01, -1.99999999998764832476e-01),
        (1.42857142725034663711e-01, -1.11111104054623557880e-01),
        (9.09088713343650656196e-02, -7.69187620504482999495e-02),
        (6.66107313738753120669e-02, -5.83357013379057348645e-02),
        (4.97687799461593236017e-02, -3.65315727442169155270e-02),
        (1.62858201153657823623e-02, 0.0),
    ];
    const ONE_MINUS_EXP: &'static [(f64, f64)] = &ONE_MINUS_EXP;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn from_f64(value: f64) -> f64 {
        value
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn to_f64(self) -> f64 {
        self
    }
}

impl Real for f32 {
    const ROUND: f32 = 12582912.0; // 1.5 · 2^23
    const MIN_NORMAL: f32 = f32::MIN_POSITIVE;
    const MAX: f32 = f32::MAX;
    const NAN: f32 = f32::NAN;
    const EPSILON: f32 = f32::EPSILON;
    const ANGLE_RANGE: f64 = 4096.0;
    const GRADIENT_FLOOR: f64 = 1e-6;
    const COS_PITCH_FLOOR: f64 = 1e-3;
    const HALF_PI_PARTS: [f64; 3] = [1.5703125, 0.0004837512969970703, 7.549789415861596e-08];
    // Minimax coefficients as published with Cephes (sinf, cosf, atanf).
    const SIN: &'static [(f32, f32)] = &narrowed([(-1.6666654611e-1, 8.3321608736e-3), (-1.9515295891e-4, 0.0)]);
    const COS: &'static [(f32, f32)] =
        &narrowed([(4.166664568298827e-2, -1.388731625493765e-3), (2.443315711809948e-5, 0.0)]);
    const ATAN: &'static [(f32, f32)] =
        &narrowed([(3.33329491539e-1, -1.99777106478e-1), (1.38776856032e-1, -8.05374449538e-2)]);
    const ONE_MINUS_EXP: &'static [(f32, f32)] = &narrowed(ONE_MINUS_EXP);

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn from_f64(value: f64) -> f32 {
        value as f32
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}
