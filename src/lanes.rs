//! Several independent numbers computed side by side, one per recording or parameter set.

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::scalar::{Mask, Real, Scalar};

/// `N` numbers in lanes; every operation acts on each lane alone, so a lane has the bits that the scalar would have.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Lanes<T, const N: usize>(pub [T; N]);

/// `N` outcomes of a comparison of [`Lanes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct LaneMask<const N: usize>(pub [bool; N]);

/// `f(a, b)` in each lane. A plain loop: iterators compile to the same code, but take the compiler minutes.
#[allow(clippy::indexing_slicing, reason = "the index is below N, the length of all three arrays")]
#[cfg_attr(not(debug_assertions), inline(always))]
fn zip<A: Copy, B: Copy, R: Copy, const N: usize>(a: [A; N], b: [B; N], fill: R, f: impl Fn(A, B) -> R) -> [R; N] {
    let mut out = [fill; N];
    let mut lane = 0;
    while lane < N {
        out[lane] = f(a[lane], b[lane]);
        lane += 1;
    }
    out
}

macro_rules! lane_operator {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl<T: Real, const N: usize> $trait for Lanes<T, N> {
            type Output = Self;
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn $method(self, other: Self) -> Self {
                Lanes(zip(self.0, other.0, T::zero(), |a, b| a $op b))
            }
        }
    )*};
}
lane_operator!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<T: Real, const N: usize> Neg for Lanes<T, N> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn neg(self) -> Self {
        Lanes(zip(self.0, self.0, T::zero(), |a, _| -a))
    }
}

impl<const N: usize> BitAnd for LaneMask<N> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn bitand(self, other: Self) -> Self {
        LaneMask(zip(self.0, other.0, false, |a, b| a & b))
    }
}

impl<const N: usize> BitOr for LaneMask<N> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn bitor(self, other: Self) -> Self {
        LaneMask(zip(self.0, other.0, false, |a, b| a | b))
    }
}

impl<const N: usize> Not for LaneMask<N> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn not(self) -> Self {
        LaneMask(zip(self.0, self.0, false, |a, _| !a))
    }
}

impl<const N: usize> Mask for LaneMask<N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn splat(value: bool) -> Self {
        LaneMask([value; N])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn all(self) -> bool {
        self.0.iter().fold(true, |all, &lane| all & lane)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn any(self) -> bool {
        self.0.iter().fold(false, |any, &lane| any | lane)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane(self, index: usize) -> bool {
        self.0.get(index).is_some_and(|&lane| lane)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_lane(&mut self, index: usize, value: bool) {
        if let Some(lane) = self.0.get_mut(index) {
            *lane = value;
        }
    }
}

impl<T: Real, const N: usize> Scalar for Lanes<T, N> {
    type Real = T;
    type Mask = LaneMask<N>;
    const LANES: usize = N;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn splat(value: T) -> Self {
        Lanes([value; N])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane(self, index: usize) -> T {
        self.0.get(index).copied().unwrap_or(T::from_f64(f64::NAN))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_lane(&mut self, index: usize, value: T) {
        if let Some(lane) = self.0.get_mut(index) {
            *lane = value;
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sqrt(self) -> Self {
        Lanes(zip(self.0, self.0, T::zero(), |a, _| a.sqrt()))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn abs(self) -> Self {
        Lanes(zip(self.0, self.0, T::zero(), |a, _| a.abs()))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lt(self, other: Self) -> LaneMask<N> {
        LaneMask(zip(self.0, other.0, false, T::lt))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn le(self, other: Self) -> LaneMask<N> {
        LaneMask(zip(self.0, other.0, false, T::le))
    }
    #[allow(clippy::indexing_slicing, reason = "the index is below N, the length of all arrays")]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn select(mask: LaneMask<N>, yes: Self, no: Self) -> Self {
        let mut out = no.0;
        let mut lane = 0;
        while lane < N {
            out[lane] = T::select(mask.0[lane], yes.0[lane], no.0[lane]);
            lane += 1;
        }
        Lanes(out)
    }
}
