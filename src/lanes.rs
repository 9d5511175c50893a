//! Several independent numbers computed side by side, one per recording or parameter set.
//!
//! While one waits for its last result the processor works on the other, and it may compute both in one instruction.

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::scalar::{Mask, Scalar};

/// Two scalars beside each other: twice the lanes. Every operation acts on each lane alone, so a lane has the bits that the
/// scalar would have.
///
/// Written out, and four lanes as pairs of pairs: arrays and a loop in every operation took the compiler minutes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<S>(pub S, pub S);

macro_rules! both {
    ($($trait:ident $method:ident),*) => {$(
        impl<S: $trait<Output = S>> $trait for Pair<S> {
            type Output = Self;
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn $method(self, other: Self) -> Self {
                Pair(self.0.$method(other.0), self.1.$method(other.1))
            }
        }
    )*};
}
both!(Add add, Sub sub, Mul mul, Div div);

impl<S: Neg<Output = S>> Neg for Pair<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn neg(self) -> Self {
        Pair(-self.0, -self.1)
    }
}

impl<S: Scalar> Scalar for Pair<S> {
    type Real = S::Real;
    type Mask = PairMask<S>;
    const LANES: usize = 2 * S::LANES;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn splat(value: S::Real) -> Self {
        Pair(S::splat(value), S::splat(value))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane(self, index: usize) -> S::Real {
        if index < S::LANES { self.0.lane(index) } else { self.1.lane(index - S::LANES) }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_lane(&mut self, index: usize, value: S::Real) {
        if index < S::LANES { self.0.set_lane(index, value) } else { self.1.set_lane(index - S::LANES, value) }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sqrt(self) -> Self {
        Pair(self.0.sqrt(), self.1.sqrt())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn abs(self) -> Self {
        Pair(self.0.abs(), self.1.abs())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lt(self, other: Self) -> PairMask<S> {
        PairMask(self.0.lt(other.0), self.1.lt(other.1))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn le(self, other: Self) -> PairMask<S> {
        PairMask(self.0.le(other.0), self.1.le(other.1))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn select(mask: PairMask<S>, yes: Self, no: Self) -> Self {
        Pair(S::select(mask.0, yes.0, no.0), S::select(mask.1, yes.1, no.1))
    }
}

/// The outcomes of comparing pairs.
#[derive(Clone, Copy, Debug)]
pub struct PairMask<S: Scalar>(pub S::Mask, pub S::Mask);

impl<S: Scalar> BitAnd for PairMask<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn bitand(self, other: Self) -> Self {
        PairMask(self.0 & other.0, self.1 & other.1)
    }
}

impl<S: Scalar> BitOr for PairMask<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn bitor(self, other: Self) -> Self {
        PairMask(self.0 | other.0, self.1 | other.1)
    }
}

impl<S: Scalar> Not for PairMask<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn not(self) -> Self {
        PairMask(!self.0, !self.1)
    }
}

impl<S: Scalar> Mask for PairMask<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn splat(value: bool) -> Self {
        PairMask(S::Mask::splat(value), S::Mask::splat(value))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn all(self) -> bool {
        (self.0 & self.1).all()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn any(self) -> bool {
        (self.0 | self.1).any()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane(self, index: usize) -> bool {
        if index < S::LANES { self.0.lane(index) } else { self.1.lane(index - S::LANES) }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_lane(&mut self, index: usize, value: bool) {
        if index < S::LANES { self.0.set_lane(index, value) } else { self.1.set_lane(index - S::LANES, value) }
    }
}
