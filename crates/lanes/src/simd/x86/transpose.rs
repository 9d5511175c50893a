//! Square blocks of numbers in registers, transposed.

use core::arch::x86_64::*;

/// Rows and columns change places: first within pairs of numbers, then of pairs, then of halves of registers.
#[target_feature(enable = "avx2")]
pub(super) fn transpose_f64x4(rows: &mut [__m256d; 4]) {
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
pub(super) fn transpose_f32x8(rows: &mut [__m256; 8]) {
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
pub(super) fn transpose_f64x8(rows: &mut [__m512d; 8]) {
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
pub(super) fn transpose_f32x16(rows: &mut [__m512; 16]) {
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
