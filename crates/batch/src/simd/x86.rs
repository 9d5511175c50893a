//! The vector registers of AVX2 and AVX-512 as scalars.
//!
//! Every operation here is one IEEE operation in each lane, so a lane has the bits of the scalar. Values of these types are
//! made by [`Instructions::run`] only, for which the processor was asked; there the operations are inlined into a function
//! that is compiled for it, and each becomes one instruction.

#![allow(unsafe_code, reason = "vector instructions; each is allowed where values of its register exist")]
#![allow(unused_unsafe, unused_braces, reason = "masks of AVX-512 are plain numbers")]
#![allow(clippy::indexing_slicing, reason = "indices below the lengths of arrays")]
#![allow(clippy::wildcard_imports, reason = "some seventy instructions")]
#![allow(clippy::undocumented_unsafe_blocks, reason = "one reason holds for all: see above")]

use core::arch::x86_64::*;
use core::fmt;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use ahrs_rs::{Mask, Scalar};

use super::{Instructions, Vector, Work};

/// The instructions of AVX2.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

/// The instructions of AVX-512F and DQ.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

impl Avx2 {
    /// The instructions, if this processor has them.
    pub fn detect() -> Option<Self> {
        is_x86_feature_detected!("avx2").then_some(Avx2(()))
    }
}

impl Avx512 {
    /// The instructions, if this processor has them.
    pub fn detect() -> Option<Self> {
        (is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq")).then_some(Avx512(()))
    }
}

#[target_feature(enable = "avx2")]
fn with_avx2(work: impl Work) {
    work.run();
}

#[target_feature(enable = "avx512f,avx512dq")]
fn with_avx512(work: impl Work) {
    work.run();
}

impl Instructions<f32> for Avx2 {
    type Vector = F32x8;
    fn run(self, work: impl Work) {
        unsafe { with_avx2(work) };
    }
    fn interleave(self, to: &mut [f32], from: &[&[f32]]) -> usize {
        unsafe { into_f32x8(to, from) }
    }
    fn deinterleave(self, from: &[f32], to: &mut [&mut [f32]]) -> usize {
        unsafe { out_of_f32x8(from, to) }
    }
}

impl Instructions<f64> for Avx2 {
    type Vector = F64x4;
    fn run(self, work: impl Work) {
        unsafe { with_avx2(work) };
    }
    fn interleave(self, to: &mut [f64], from: &[&[f64]]) -> usize {
        unsafe { into_f64x4(to, from) }
    }
    fn deinterleave(self, from: &[f64], to: &mut [&mut [f64]]) -> usize {
        unsafe { out_of_f64x4(from, to) }
    }
}

impl Instructions<f32> for Avx512 {
    type Vector = F32x16;
    fn run(self, work: impl Work) {
        unsafe { with_avx512(work) };
    }
    fn interleave(self, to: &mut [f32], from: &[&[f32]]) -> usize {
        unsafe { into_f32x16(to, from) }
    }
    fn deinterleave(self, from: &[f32], to: &mut [&mut [f32]]) -> usize {
        unsafe { out_of_f32x16(from, to) }
    }
}

impl Instructions<f64> for Avx512 {
    type Vector = F64x8;
    fn run(self, work: impl Work) {
        unsafe { with_avx512(work) };
    }
    fn interleave(self, to: &mut [f64], from: &[&[f64]]) -> usize {
        unsafe { into_f64x8(to, from) }
    }
    fn deinterleave(self, from: &[f64], to: &mut [&mut [f64]]) -> usize {
        unsafe { out_of_f64x8(from, to) }
    }
}

/// Defines a register of numbers and the mask that comparing them gives.
macro_rules! register {
    (
        $(#[doc = $doc:literal])+
        $name:ident($inner:ty), [$real:ty; $lanes:literal], $mask:ident($mask_inner:ty),
        add $add:ident, sub $sub:ident, mul $mul:ident, div $div:ident, sqrt $sqrt:ident, splat $splat:ident,
        load $load:ident, store $store:ident,
        abs |$abs_x:ident| $abs:expr, neg |$neg_x:ident| $neg:expr,
        lt |$lt_a:ident, $lt_b:ident| $lt:expr, le |$le_a:ident, $le_b:ident| $le:expr,
        select |$m:ident, $yes:ident, $no:ident| $select:expr,
        bits |$bits_m:ident| $bits:expr, from_bits |$from:ident| $from_bits:expr,
        and |$and_a:ident, $and_b:ident| $and:expr, or |$or_a:ident, $or_b:ident| $or:expr, not |$not_a:ident| $not:expr,
        feature $feature:literal, transpose $transpose:ident, into $into:ident, out_of $out_of:ident
    ) => {
        $(#[doc = $doc])+
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub struct $name($inner);

        /// The outcome of a comparison of the lanes.
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub struct $mask($mask_inner);

        impl $name {
            #[inline(always)]
            fn array(self) -> [$real; $lanes] {
                let mut out = [0.0; $lanes];
                unsafe { $store(out.as_mut_ptr(), self.0) };
                out
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.array().fmt(f)
            }
        }

        impl PartialEq for $name {
            fn eq(&self, other: &Self) -> bool {
                self.array() == other.array()
            }
        }

        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                $name(unsafe { $add(self.0, other.0) })
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                $name(unsafe { $sub(self.0, other.0) })
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                $name(unsafe { $mul(self.0, other.0) })
            }
        }
        impl Div for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                $name(unsafe { $div(self.0, other.0) })
            }
        }
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                let $neg_x = self.0;
                $name(unsafe { $neg })
            }
        }

        impl Scalar for $name {
            type Real = $real;
            type Mask = $mask;
            const LANES: usize = $lanes;

            #[inline(always)]
            fn splat(value: $real) -> Self {
                $name(unsafe { $splat(value) })
            }
            #[inline(always)]
            fn lane(self, index: usize) -> $real {
                self.array().get(index).copied().unwrap_or(<$real>::NAN)
            }
            #[inline(always)]
            fn set_lane(&mut self, index: usize, value: $real) {
                let mut array = self.array();
                if let Some(lane) = array.get_mut(index) {
                    *lane = value;
                }
                *self = Self::load(&array);
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $name(unsafe { $sqrt(self.0) })
            }
            #[inline(always)]
            fn abs(self) -> Self {
                let $abs_x = self.0;
                $name(unsafe { $abs })
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask {
                let ($lt_a, $lt_b) = (self.0, other.0);
                $mask(unsafe { $lt })
            }
            #[inline(always)]
            fn le(self, other: Self) -> $mask {
                let ($le_a, $le_b) = (self.0, other.0);
                $mask(unsafe { $le })
            }
            #[inline(always)]
            fn select(mask: $mask, yes: Self, no: Self) -> Self {
                let ($m, $yes, $no) = (mask.0, yes.0, no.0);
                $name(unsafe { $select })
            }
        }

        impl Vector for $name {
            #[inline(always)]
            fn load(from: &[$real]) -> Self {
                match from.first_chunk::<$lanes>() {
                    Some(lanes) => $name(unsafe { $load(lanes.as_ptr()) }),
                    None => Self::splat(<$real>::NAN),
                }
            }
            #[inline(always)]
            fn store(self, to: &mut [$real]) {
                if let Some(lanes) = to.first_chunk_mut::<$lanes>() {
                    unsafe { $store(lanes.as_mut_ptr(), self.0) };
                }
            }
            #[inline(always)]
            fn ask(address: *const u8) {
                // Into the second level: a tile is larger than the first.
                unsafe { _mm_prefetch::<_MM_HINT_T1>(address.cast()) };
            }
        }

        /// Numbers of sources, one for each lane, into the order of the lanes; how many of each are done.
        #[target_feature(enable = $feature)]
        fn $into(to: &mut [$real], from: &[&[$real]]) -> usize {
            let Some(from) = from.first_chunk::<$lanes>() else { return 0 };
            let len = from.iter().fold(to.len() / $lanes, |len, source| len.min(source.len()));
            let mut rows = [$splat(0.0); $lanes];
            let mut start = 0;
            while start + $lanes <= len {
                for k in 0..$lanes {
                    rows[k] = unsafe { $load(from[k].as_ptr().add(start)) };
                }
                $transpose(&mut rows);
                for k in 0..$lanes {
                    unsafe { $store(to.as_mut_ptr().add((start + k) * $lanes), rows[k]) };
                }
                start += $lanes;
            }
            start
        }

        /// Numbers in the order of the lanes to places, one for each of the first lanes; how many of each are done.
        #[target_feature(enable = $feature)]
        fn $out_of(from: &[$real], to: &mut [&mut [$real]]) -> usize {
            let lanes = to.len().min($lanes);
            let len = to.iter().fold(from.len() / $lanes, |len, places| len.min(places.len()));
            let mut rows = [$splat(0.0); $lanes];
            let mut start = 0;
            while start + $lanes <= len {
                for k in 0..$lanes {
                    rows[k] = unsafe { $load(from.as_ptr().add((start + k) * $lanes)) };
                }
                $transpose(&mut rows);
                for k in 0..lanes {
                    unsafe { $store(to[k].as_mut_ptr().add(start), rows[k]) };
                }
                start += $lanes;
            }
            start
        }

        impl $mask {
            /// One bit a lane, the first the lowest.
            #[inline(always)]
            fn bits(self) -> u32 {
                let $bits_m = self.0;
                unsafe { $bits }
            }
            #[inline(always)]
            fn from_bits($from: u32) -> Self {
                $mask(unsafe { $from_bits })
            }
        }

        impl fmt::Debug for $mask {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{:#b}", self.bits())
            }
        }
        impl BitAnd for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                let ($and_a, $and_b) = (self.0, other.0);
                $mask(unsafe { $and })
            }
        }
        impl BitOr for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                let ($or_a, $or_b) = (self.0, other.0);
                $mask(unsafe { $or })
            }
        }
        impl Not for $mask {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                let $not_a = self.0;
                $mask(unsafe { $not })
            }
        }
        impl Mask for $mask {
            #[inline(always)]
            fn splat(value: bool) -> Self {
                Self::from_bits(if value { u32::MAX } else { 0 })
            }
            #[inline(always)]
            fn all(self) -> bool {
                self.bits() == (1 << $lanes) - 1
            }
            #[inline(always)]
            fn any(self) -> bool {
                self.bits() != 0
            }
            #[inline(always)]
            fn lane(self, index: usize) -> bool {
                index < $lanes && self.bits() >> index & 1 == 1
            }
            #[inline(always)]
            fn set_lane(&mut self, index: usize, value: bool) {
                if index < $lanes {
                    let others = self.bits() & !(1 << index);
                    *self = Self::from_bits(others | u32::from(value) << index);
                }
            }
        }
    };
}

/// All bits of an element where bit `index` is set.
#[inline(always)]
fn element64(bits: u32, index: u32) -> i64 {
    -i64::from(bits >> index & 1)
}

/// All bits of an element where bit `index` is set.
#[inline(always)]
fn element32(bits: u32, index: u32) -> i32 {
    -(bits >> index & 1).cast_signed()
}

register! {
    /// Four numbers of `f64`; needs AVX2.
    F64x4(__m256d), [f64; 4], Mask64x4(__m256d),
    add _mm256_add_pd, sub _mm256_sub_pd, mul _mm256_mul_pd, div _mm256_div_pd, sqrt _mm256_sqrt_pd,
    splat _mm256_set1_pd, load _mm256_loadu_pd, store _mm256_storeu_pd,
    abs |x| _mm256_andnot_pd(_mm256_set1_pd(-0.0), x), neg |x| _mm256_xor_pd(_mm256_set1_pd(-0.0), x),
    lt |a, b| _mm256_cmp_pd::<_CMP_LT_OQ>(a, b), le |a, b| _mm256_cmp_pd::<_CMP_LE_OQ>(a, b),
    select |m, yes, no| _mm256_blendv_pd(no, yes, m),
    bits |m| _mm256_movemask_pd(m).cast_unsigned(),
    from_bits |b| _mm256_castsi256_pd(_mm256_set_epi64x(
        element64(b, 3), element64(b, 2), element64(b, 1), element64(b, 0)
    )),
    and |a, b| _mm256_and_pd(a, b), or |a, b| _mm256_or_pd(a, b),
    not |a| _mm256_xor_pd(a, _mm256_castsi256_pd(_mm256_set1_epi64x(-1))),
    feature "avx2", transpose transpose_f64x4, into into_f64x4, out_of out_of_f64x4
}

register! {
    /// Eight numbers of `f32`; needs AVX2.
    F32x8(__m256), [f32; 8], Mask32x8(__m256),
    add _mm256_add_ps, sub _mm256_sub_ps, mul _mm256_mul_ps, div _mm256_div_ps, sqrt _mm256_sqrt_ps,
    splat _mm256_set1_ps, load _mm256_loadu_ps, store _mm256_storeu_ps,
    abs |x| _mm256_andnot_ps(_mm256_set1_ps(-0.0), x), neg |x| _mm256_xor_ps(_mm256_set1_ps(-0.0), x),
    lt |a, b| _mm256_cmp_ps::<_CMP_LT_OQ>(a, b), le |a, b| _mm256_cmp_ps::<_CMP_LE_OQ>(a, b),
    select |m, yes, no| _mm256_blendv_ps(no, yes, m),
    bits |m| _mm256_movemask_ps(m).cast_unsigned(),
    from_bits |b| _mm256_castsi256_ps(_mm256_set_epi32(
        element32(b, 7), element32(b, 6), element32(b, 5), element32(b, 4),
        element32(b, 3), element32(b, 2), element32(b, 1), element32(b, 0)
    )),
    and |a, b| _mm256_and_ps(a, b), or |a, b| _mm256_or_ps(a, b),
    not |a| _mm256_xor_ps(a, _mm256_castsi256_ps(_mm256_set1_epi32(-1))),
    feature "avx2", transpose transpose_f32x8, into into_f32x8, out_of out_of_f32x8
}

register! {
    /// Eight numbers of `f64`; needs AVX-512F and DQ.
    F64x8(__m512d), [f64; 8], Mask64x8(__mmask8),
    add _mm512_add_pd, sub _mm512_sub_pd, mul _mm512_mul_pd, div _mm512_div_pd, sqrt _mm512_sqrt_pd,
    splat _mm512_set1_pd, load _mm512_loadu_pd, store _mm512_storeu_pd,
    abs |x| _mm512_andnot_pd(_mm512_set1_pd(-0.0), x), neg |x| _mm512_xor_pd(_mm512_set1_pd(-0.0), x),
    lt |a, b| _mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b), le |a, b| _mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b),
    select |m, yes, no| _mm512_mask_blend_pd(m, no, yes),
    bits |m| { u32::from(m) }, from_bits |b| b as __mmask8,
    and |a, b| { a & b }, or |a, b| { a | b }, not |a| { !a },
    feature "avx512f,avx512dq", transpose transpose_f64x8, into into_f64x8, out_of out_of_f64x8
}

register! {
    /// Sixteen numbers of `f32`; needs AVX-512F and DQ.
    F32x16(__m512), [f32; 16], Mask32x16(__mmask16),
    add _mm512_add_ps, sub _mm512_sub_ps, mul _mm512_mul_ps, div _mm512_div_ps, sqrt _mm512_sqrt_ps,
    splat _mm512_set1_ps, load _mm512_loadu_ps, store _mm512_storeu_ps,
    abs |x| _mm512_andnot_ps(_mm512_set1_ps(-0.0), x), neg |x| _mm512_xor_ps(_mm512_set1_ps(-0.0), x),
    lt |a, b| _mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b), le |a, b| _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b),
    select |m, yes, no| _mm512_mask_blend_ps(m, no, yes),
    bits |m| { u32::from(m) }, from_bits |b| b as __mmask16,
    and |a, b| { a & b }, or |a, b| { a | b }, not |a| { !a },
    feature "avx512f,avx512dq", transpose transpose_f32x16, into into_f32x16, out_of out_of_f32x16
}

/// Rows and columns change places: first within pairs of numbers, then of pairs, then of halves of registers.
#[target_feature(enable = "avx2")]
fn transpose_f64x4(rows: &mut [__m256d; 4]) {
    let r = *rows;
    let (a, b) = (_mm256_unpacklo_pd(r[0], r[1]), _mm256_unpackhi_pd(r[0], r[1]));
    let (c, d) = (_mm256_unpacklo_pd(r[2], r[3]), _mm256_unpackhi_pd(r[2], r[3]));
    *rows = [
        _mm256_permute2f128_pd::<0x20>(a, c),
        _mm256_permute2f128_pd::<0x20>(b, d),
        _mm256_permute2f128_pd::<0x31>(a, c),
        _mm256_permute2f128_pd::<0x31>(b, d),
    ];
}

/// As [`transpose_f64x4`].
#[target_feature(enable = "avx2")]
fn transpose_f32x8(rows: &mut [__m256; 8]) {
    let r = *rows;
    let mut q = r;
    for half in 0..2 {
        let [a, b, c, d] = [r[4 * half], r[4 * half + 1], r[4 * half + 2], r[4 * half + 3]];
        let (ab, ab2) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
        let (cd, cd2) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
        q[4 * half] = _mm256_shuffle_ps::<0x44>(ab, cd);
        q[4 * half + 1] = _mm256_shuffle_ps::<0xee>(ab, cd);
        q[4 * half + 2] = _mm256_shuffle_ps::<0x44>(ab2, cd2);
        q[4 * half + 3] = _mm256_shuffle_ps::<0xee>(ab2, cd2);
    }
    let mut out = q;
    for k in 0..4 {
        out[k] = _mm256_permute2f128_ps::<0x20>(q[k], q[k + 4]);
        out[k + 4] = _mm256_permute2f128_ps::<0x31>(q[k], q[k + 4]);
    }
    *rows = out;
}

/// As [`transpose_f64x4`].
#[target_feature(enable = "avx512f,avx512dq")]
fn transpose_f64x8(rows: &mut [__m512d; 8]) {
    let r = *rows;
    let mut out = r;
    for odd in 0..2 {
        let mut pairs = [r[0]; 4];
        for (k, pair) in pairs.iter_mut().enumerate() {
            let (a, b) = (r[2 * k], r[2 * k + 1]);
            *pair = if odd == 0 { _mm512_unpacklo_pd(a, b) } else { _mm512_unpackhi_pd(a, b) };
        }
        let [a, b, c, d] = pairs;
        let (ab, ab2) = (_mm512_shuffle_f64x2::<0x88>(a, b), _mm512_shuffle_f64x2::<0xdd>(a, b));
        let (cd, cd2) = (_mm512_shuffle_f64x2::<0x88>(c, d), _mm512_shuffle_f64x2::<0xdd>(c, d));
        out[odd] = _mm512_shuffle_f64x2::<0x88>(ab, cd);
        out[odd + 2] = _mm512_shuffle_f64x2::<0x88>(ab2, cd2);
        out[odd + 4] = _mm512_shuffle_f64x2::<0xdd>(ab, cd);
        out[odd + 6] = _mm512_shuffle_f64x2::<0xdd>(ab2, cd2);
    }
    *rows = out;
}

/// As [`transpose_f64x4`].
#[target_feature(enable = "avx512f,avx512dq")]
fn transpose_f32x16(rows: &mut [__m512; 16]) {
    let r = *rows;
    // Columns 4 j + c of rows 4 g to 4 g + 3 stand in part j of q[c][g].
    let mut q = [[r[0]; 4]; 4];
    for g in 0..4 {
        let [a, b, c, d] = [r[4 * g], r[4 * g + 1], r[4 * g + 2], r[4 * g + 3]];
        let (ab, ab2) = (_mm512_unpacklo_ps(a, b), _mm512_unpackhi_ps(a, b));
        let (cd, cd2) = (_mm512_unpacklo_ps(c, d), _mm512_unpackhi_ps(c, d));
        q[0][g] = _mm512_shuffle_ps::<0x44>(ab, cd);
        q[1][g] = _mm512_shuffle_ps::<0xee>(ab, cd);
        q[2][g] = _mm512_shuffle_ps::<0x44>(ab2, cd2);
        q[3][g] = _mm512_shuffle_ps::<0xee>(ab2, cd2);
    }
    let mut out = r;
    for c in 0..4 {
        let [a, b, e, f] = q[c];
        let (ab, ab2) = (_mm512_shuffle_f32x4::<0x88>(a, b), _mm512_shuffle_f32x4::<0xdd>(a, b));
        let (ef, ef2) = (_mm512_shuffle_f32x4::<0x88>(e, f), _mm512_shuffle_f32x4::<0xdd>(e, f));
        out[c] = _mm512_shuffle_f32x4::<0x88>(ab, ef);
        out[c + 4] = _mm512_shuffle_f32x4::<0x88>(ab2, ef2);
        out[c + 8] = _mm512_shuffle_f32x4::<0xdd>(ab, ef);
        out[c + 12] = _mm512_shuffle_f32x4::<0xdd>(ab2, ef2);
    }
    *rows = out;
}
