//! Madgwick's gradient-descent filter.

use super::Integration;
use super::adaptive::trust;
use super::vector::{DirectionError, direction_error};
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, OutputSpec, Preset, Sample, Weights};
use crate::scalar::{Mask, Real, Scalar};
use crate::so3::{Frame, Quat, Vec3, first_order_step};
use crate::status::Flags;

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "Madgwick",
    doc: "The attitude follows the gyroscope and descends at a constant rate along the gradient of the squared error \
          between measured and predicted directions of gravity and magnetic field. A step that would turn by more \
          than 0.1 rad is a gap in the data, and turns no further than the error.",
    source: "Madgwick et al., ICORR 2011; Ludwig & Burnham 2018, Alg. 2; Çoçoli & Badia 2023, Alg. 2 with (17) \
             divided by the norm of the gradient",
    magnetometer: Magnetometer::Feedback,
    feedback: true,
    gyr_bias: true,
    equivariance: Equivariance::Exact,
    params: PARAMS,
    presets: &[
        Preset { name: "cirillo2014", values: &[("beta", 0.041)] },
        Preset { name: "parikh2021", values: &[("beta", 0.00921)] },
        Preset { name: "ludwig2018", values: &[("beta", 0.011765)] },
        Preset { name: "cocoli2023", values: &[("beta", 0.05)] },
        Preset { name: "hyyti2015", values: &[("beta", 0.1)] },
    ],
    outputs: &[OutputSpec {
        name: "innovation",
        doc: "the rotation rate 2 q* ⊗ ∇f/‖∇f‖ that the normalised gradient stands for, sensor frame, rad/s per unit β",
        shape: &[3],
    }],
};

choice! {
    /// The gradient that is normalised: its part along rotations, which does not depend on the choice of axes, or
    /// the published one, computed with north on x, whose part along q does.
    pub enum Gradient { Tangent = "tangent", Paper = "paper" }
}

params! {
    /// Rate β of the descent: the attitude's correction turns at 2β.
    real beta: "rad/s" = 0.041 in [0.0, 1e6];
    /// Gain ζ with which the direction of the descent changes the estimate of the gyroscope's bias (0: no estimate).
    real zeta: "rad/s²" = 0.0 in [0.0, 1e6];
    /// Deviation of the specific force's norm from gravity above which the accelerometer's part of the gradient falls, linearly to none at
    /// twice as much (Valenti et al. 2015; the adaptive gain that Parikh et al. 2021 propose); 0: never.
    real acc_threshold: "m/s²" = 0.0 in [0.0, 1e6];
    choice gradient: Gradient;
    choice integration: Integration;
}

/// A correction of one step in rad above which the step is a gap, not a sampling interval.
const LARGE_TURN: f64 = 0.1;

/// Madgwick's gradient-descent filter.
#[derive(Clone, Debug)]
pub struct Madgwick<S: Scalar> {
    params: Params<S>,
    q: Quat<S>,
    bias: Vec3<S>,
    descent: Descent<S>,
    acc_rejected: S::Mask,
}

impl<S: Scalar> Filter<S> for Madgwick<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;

    fn new(params: &Params<S>) -> Self {
        Madgwick {
            params: params.clone(),
            q: Quat::identity(),
            bias: Vec3::zero(),
            descent: Descent { along_q: S::zero(), error: Vec3::zero(), norm2: S::zero() },
            acc_rejected: S::Mask::splat(false),
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attitude(&self) -> Quat<S> {
        self.q
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        self.q = Quat::select(lanes, q, self.q);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, sample: &Sample<S>, dt: S) {
        let weights = sample.weights(dt);
        let share = trust(sample, self.params.acc_threshold);
        self.acc_rejected = share.le(S::zero());
        let descent = match self.params.gradient {
            Gradient::Tangent => tangent_descent(self.q, sample, share, &weights),
            Gradient::Paper => paper_descent(self.q, sample, share, &weights),
        };
        self.descent = descent;
        // After a gap one sample's gradient stands for the whole of it: it may reach the minimum, not pass it.
        let time = weights.time;
        let turn = S::of(2.0) * self.params.beta * time;
        let gap = S::of(LARGE_TURN).lt(turn);
        let mut feedback = time;
        if gap.any() {
            let share = descent.norm2.sqrt().max(S::of(LARGE_TURN)).min(turn) / turn;
            feedback = S::select(gap, time * share, time);
        }
        // ω_b = ζ ∫ ω_e dt (Ludwig Alg. 2, line 6)
        if !self.bias_stays_zero() {
            // An attitude that was lost is no error of the gyroscope.
            let learns = S::select(sample.recovering, S::zero(), feedback);
            self.bias = self.bias + descent.error * descent.over_norm(S::of(-2.0) * self.params.zeta * learns);
        }
        // ½ (ω − ω_b − β ω_e) dt (Ludwig Alg. 2, lines 5, 7 and 8, with the conjugate that line 5 lacks; Çoçoli eqs
        // 17-19)
        let correction = descent.over_norm(self.params.beta * feedback);
        let half_turn = (sample.gyr - self.bias) * (S::of(0.5) * dt) + descent.error * correction;
        self.q = match self.params.integration {
            Integration::Exponential => Integration::Exponential.step(self.q, half_turn),
            Integration::FirstOrder => {
                let change = Quat::from_parts(descent.along_q * correction, half_turn);
                first_order_step(self.q, self.q * change)
            }
        };
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gyr_bias(&self) -> Vec3<S> {
        self.bias
    }
    fn bias_stays_zero(&self) -> bool {
        self.params.zeta.le(S::zero()).all()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn flag(&self, flags: &mut Flags<S::Mask>) {
        flags.acc_rejected = self.acc_rejected;
    }
    fn output(&self, _index: usize, put: &mut impl FnMut(S)) {
        (self.descent.error * self.descent.over_norm(S::of(-2.0))).each(&mut |value| put(*value));
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.q.each(visit);
        self.bias.each(visit);
    }
}

/// The gradient ∇f = −2 q ⊗ (c, e).
#[derive(Clone, Copy, Debug)]
struct Descent<S> {
    /// c: the part along q, which turns nothing.
    along_q: S,
    /// e: the part along rotations.
    error: Vec3<S>,
    /// ¼ ‖∇f‖², in rad² the squared angle to the minimum where that is near. Where less than the whole of the
    /// accelerometer's part counts, that of the whole gradient if it is larger: the step gets shorter, not only another
    /// direction.
    norm2: S,
}

impl<S: Scalar> Descent<S> {
    /// 2 `x`/‖∇f‖, zero where the gradient is too small to have a direction. With it ω_e = 2 q* ⊗ ∇f/‖∇f‖ is e times
    /// `over_norm(-2)`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn over_norm(&self, x: S) -> S {
        let norm = self.norm2.sqrt();
        let known = S::of(0.5 * S::Real::GRADIENT_FLOOR).le(norm);
        // A root and a quotient that the processor computes side by side, not one after the other.
        let quotient = norm * (x / self.norm2);
        if known.all() { quotient } else { S::select(known, quotient, S::zero()) }
    }
}

/// The gradient's part along rotations. For f = (v̂ − a, m̂ − m) that part of ½‖f‖² is −(a × v̂ + m × m̂) for a small
/// rotation of the sensor.
#[cfg_attr(not(debug_assertions), inline(always))]
fn tangent_descent<S: Scalar>(q: Quat<S>, sample: &Sample<S>, share: S, weights: &Weights<S>) -> Descent<S> {
    let DirectionError { sensor, norm2 } = direction_error(q.matrix(), sample, share, weights);
    Descent { along_q: S::zero(), error: sensor, norm2 }
}

/// The published gradient.
#[cfg_attr(not(debug_assertions), inline(always))]
fn paper_descent<S: Scalar>(q: Quat<S>, sample: &Sample<S>, share: S, weights: &Weights<S>) -> Descent<S> {
    // With north on x, as the published Jacobians have it.
    let q = Frame::Nwu.from_enu::<S>() * q;
    let zero = Quat::of([0.0; 4]);
    let mut whole = Quat::select(sample.acc.valid, gravity_gradient(q, sample.acc.unit), zero).scale(weights.acc);
    let counts_whole = S::one().le(share).all();
    let mut gradient = if counts_whole { whole } else { whole.scale(share) };
    if sample.mag.valid.any() {
        let field = Quat::select(sample.mag.valid, field_gradient(q, sample.mag.unit), zero).scale(weights.mag);
        whole = whole.plus(field);
        gradient = gradient.plus(field);
    }
    let norm2 = gradient.dot(gradient);
    let norm2 = if counts_whole { norm2 } else { norm2.max(whole.dot(whole)) };
    let halved = (q.conj() * gradient).scale(S::of(-0.5));
    Descent { along_q: halved.w, error: halved.vector(), norm2: S::of(0.25) * norm2 }
}

/// Jᵀf of gravity (Çoçoli eqs 14-16), a the unit specific force.
#[cfg_attr(not(debug_assertions), inline(always))]
fn gravity_gradient<S: Scalar>(q: Quat<S>, a: Vec3<S>) -> Quat<S> {
    let (one, two, four) = (S::one(), S::of(2.0), S::of(4.0));
    let Quat { w, x, y, z } = q;
    // eq. 15
    let f1 = two * (x * z - w * y) - a.x;
    let f2 = two * (w * x + y * z) - a.y;
    let f3 = (one - two * (x * x + y * y)) - a.z;
    // eq. 16, transposed
    Quat::new(
        two * (x * f2 - y * f1),
        two * (z * f1 + w * f2) - four * x * f3,
        two * (z * f2 - w * f1) - four * y * f3,
        two * (x * f1 + y * f2),
    )
}

/// Jᵀf of the magnetic field (Madgwick 2011, the field's objective and its Jacobian), m the unit field; the earth's
/// field b = (b_x, 0, b_z) has the inclination that is measured now.
#[cfg_attr(not(debug_assertions), inline(always))]
fn field_gradient<S: Scalar>(q: Quat<S>, m: Vec3<S>) -> Quat<S> {
    let (half, two, four) = (S::of(0.5), S::of(2.0), S::of(4.0));
    let Quat { w, x, y, z } = q;
    let h = q.rotate(m);
    let (bx, bz) = ((h.x * h.x + h.y * h.y).sqrt(), h.z);
    let f1 = two * (bx * (half - y * y - z * z) + bz * (x * z - w * y)) - m.x;
    let f2 = two * (bx * (x * y - w * z) + bz * (w * x + y * z)) - m.y;
    let f3 = two * (bx * (w * y + x * z) + bz * (half - x * x - y * y)) - m.z;
    Quat::new(
        two * (-(bz * y) * f1 + (bz * x - bx * z) * f2 + bx * y * f3),
        two * (bz * z * f1 + (bx * y + bz * w) * f2 + bx * z * f3) - four * bz * x * f3,
        two * (-(bz * w) * f1 + (bx * x + bz * z) * f2 + bx * w * f3) - four * (bx * y * f1 + bz * y * f3),
        two * (bz * x * f1 + (bz * y - bx * w) * f2 + bx * x * f3) - four * bx * z * f1,
    )
}
