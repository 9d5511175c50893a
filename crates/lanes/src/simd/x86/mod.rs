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

mod register;
mod transpose;

use core::arch::x86_64::*;
use core::fmt;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use ahrs_rs::{Mask, Scalar};

use super::{Instructions, Kernel, Vector};
use register::register;
use transpose::{transpose_f32x8, transpose_f32x16, transpose_f64x4, transpose_f64x8};

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
fn with_avx2(kernel: impl Kernel) {
    kernel.run();
}

#[target_feature(enable = "avx512f,avx512dq")]
fn with_avx512(kernel: impl Kernel) {
    kernel.run();
}

impl Instructions<f32> for Avx2 {
    type Vector = F32x8;
    fn run(self, kernel: impl Kernel) {
        unsafe { with_avx2(kernel) };
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
    fn run(self, kernel: impl Kernel) {
        unsafe { with_avx2(kernel) };
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
    fn run(self, kernel: impl Kernel) {
        unsafe { with_avx512(kernel) };
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
    fn run(self, kernel: impl Kernel) {
        unsafe { with_avx512(kernel) };
    }
    fn interleave(self, to: &mut [f64], from: &[&[f64]]) -> usize {
        unsafe { into_f64x8(to, from) }
    }
    fn deinterleave(self, from: &[f64], to: &mut [&mut [f64]]) -> usize {
        unsafe { out_of_f64x8(from, to) }
    }
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
