//! The transcendental functions, written once for every scalar as branch-free polynomials.
//!
//! Platform libraries differ in their last bits, have no lanes, and compute in `f64` what is asked in `f32`. Errors
//! stated here are in units in the last place of the result (ulp) and are checked by `tests/trig.rs`.

use core::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI, TAU};

use crate::scalar::{Real, Scalar};

/// Evaluates a polynomial given as pairs of coefficients of neighbouring powers, lowest first: half the latency of
/// Horner's scheme.
#[cfg_attr(not(debug_assertions), inline(always))]
fn polynomial<S: Scalar>(x: S, pairs: &[(S::Real, S::Real)]) -> S {
    let x2 = x * x;
    match *pairs {
        // Up to three pairs side by side.
        [low, middle, high] => (pair(x, low) + x2 * pair(x, middle)) + (x2 * x2) * pair(x, high),
        [low, ref rest @ ..] => {
            let mut sum = S::zero();
            for &next in rest.iter().rev() {
                sum = sum * x2 + pair(x, next);
            }
            if rest.is_empty() { pair(x, low) } else { sum * x2 + pair(x, low) }
        }
        [] => S::zero(),
    }
}

/// Two neighbouring terms of a polynomial.
#[cfg_attr(not(debug_assertions), inline(always))]
fn pair<S: Scalar>(x: S, (even, odd): (S::Real, S::Real)) -> S {
    S::splat(even) + S::splat(odd) * x
}

/// (sin x)/x and cos x from x², for |x| ≤ π/4.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn sinc_cos_kernel<S: Scalar>(x2: S) -> (S, S) {
    let sinc = S::one() + x2 * polynomial(x2, S::Real::SIN);
    let cos = (S::one() - S::of(0.5) * x2) + (x2 * x2) * polynomial(x2, S::Real::COS);
    (sinc, cos)
}

/// Sine and cosine: in `f64` within 2 ulp of the exact value, in `f32` within 2 ulp up to |x| = π and beyond it within
/// 3 ulp and 1e-14·|x|.
///
/// The argument may be as large as [`Real::ANGLE_RANGE`]; beyond it, and for NaN, the angle counts as zero, so that
/// no argument gives anything but a point on the unit circle.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn sin_cos<S: Scalar>(angle: S) -> (S, S) {
    let in_range = angle.abs().le(S::of(S::Real::ANGLE_RANGE));
    let angle = S::select(in_range, angle, S::zero());

    // Quarter turns, and what is left after taking them away in three parts.
    let turns = (angle * S::of(FRAC_2_PI)).round();
    let [high, middle, low] = S::Real::HALF_PI_PARTS;
    let coarse = angle - turns * S::of(high);
    let fine = coarse - turns * S::of(middle);
    let rest = ((coarse - fine) - turns * S::of(middle)) - turns * S::of(low);
    let x = fine + rest;

    let (sinc, cos) = sinc_cos_kernel(x * x);
    let sin = x * sinc;

    // The quadrant as one of −2, −1, 0, 1, 2, where −2 and 2 are the same.
    let quadrant = turns - S::of(4.0) * (turns * S::of(0.25)).round();
    let half = S::of(0.5);
    let far = S::of(1.5).lt(quadrant.abs());
    let odd = half.lt(quadrant.abs()) & !far;
    let negative_sin = far | quadrant.lt(-half);
    let negative_cos = far | half.lt(quadrant);
    let (s, c) = (S::select(odd, cos, sin), S::select(odd, sin, cos));
    (S::select(negative_sin, -s, s), S::select(negative_cos, -c, c))
}

/// The angle of the point (x, y) from the x axis, in [−π, π], within 3 ulp where |x| + |y| is finite; zero at
/// the origin.
///
/// Unlike the platform's function it takes −0 for 0: `atan2(-0, -1)` is π.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn atan2<S: Scalar>(y: S, x: S) -> S {
    let (across, along) = (y.abs(), x.abs());
    let steep = along.lt(across);
    let (small, large) = (S::select(steep, along, across), S::select(steep, across, along));

    // atan(s/l) = π/4 + atan((s − l)/(s + l)) keeps the polynomial's argument below tan π/8.
    let beyond = (large * S::of(0.41421356237309503)).lt(small);
    let numerator = S::select(beyond, small - large, small);
    let denominator = S::select(beyond, small + large, large);
    let ratio = numerator / S::select(denominator.le(S::zero()), S::one(), denominator);
    let r2 = ratio * ratio;
    let kernel = ratio - ratio * (r2 * polynomial(r2, S::Real::ATAN));
    let octant = S::select(beyond, S::of(FRAC_PI_4) + kernel, kernel);

    let quadrant = S::select(steep, S::of(FRAC_PI_2) - octant, octant);
    let half_plane = S::select(x.lt(S::zero()), S::of(PI) - quadrant, quadrant);
    S::select(y.lt(S::zero()), -half_plane, half_plane)
}

/// The same angle in [−π, π], within ε|x|.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn wrap<S: Scalar>(angle: S) -> S {
    angle - S::of(TAU) * (angle * S::of(1.0 / TAU)).round()
}

/// How often the argument of [`one_minus_exp`] is halved, and where it stops counting: there the result is one.
const HALVINGS: i32 = 8;
const LARGEST_EXPONENT: f64 = 64.0;

/// 1 − exp(−x) for x ≥ 0 within 8 ulp (each doubling rounds twice), without the cancellation of small x; zero below, one for NaN.
///
/// From a 256th of the argument, doubled: 1 − e^(−2y) = r (2 − r) with r = 1 − e^(−y).
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn one_minus_exp<S: Scalar>(x: S) -> S {
    let y = x.min(S::of(LARGEST_EXPONENT)).max(S::zero()) * S::of(1.0 / 256.0);
    let mut r = y * polynomial(y, S::Real::ONE_MINUS_EXP);
    for _ in 0..HALVINGS {
        r = r * (S::of(2.0) - r);
    }
    r
}
