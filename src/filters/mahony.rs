//! Mahony's nonlinear complementary filter.

use super::Integration;
use super::adaptive::trust;
use super::vector::direction_error;
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, OutputSpec, Preset, Sample};
use crate::scalar::{Mask, Scalar};
use crate::so3::{Quat, Vec3};
use crate::status::Flags;

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "Mahony",
    doc: "The angular rate is corrected in proportion to the error between measured and predicted directions of \
          gravity and magnetic field, and by its integral, which is the gyroscope's bias. In a gap of more than \
          1/(2 kp) the feedback counts for that long only: two directions pull with up to 2 kp.",
    source: "Mahony et al., IEEE TAC 53(5), 2008 (explicit complementary filter); Ludwig & Burnham 2018, Alg. 1; \
             Çoçoli & Badia 2023, Alg. 1",
    magnetometer: Magnetometer::Feedback,
    feedback: true,
    gyr_bias: true,
    equivariance: Equivariance::Exact,
    params: PARAMS,
    presets: &[
        Preset { name: "cirillo2014", values: &[("kp", 2.0), ("ki", 0.6)] },
        Preset { name: "parikh2021", values: &[("kp", 0.89), ("ki", 0.01)] },
        Preset { name: "ludwig2018", values: &[("kp", 0.0039216), ("ki", 0.001)] },
        Preset { name: "cocoli2023", values: &[("kp", 10.0), ("ki", 0.0)] },
        Preset { name: "hyyti2015", values: &[("kp", 0.5), ("ki", 0.0)] },
    ],
    outputs: &[OutputSpec {
        name: "innovation",
        doc: "the error a × v̂ + m × m̂ between measured and predicted directions, sensor frame, rad for small errors",
        shape: &[3],
    }],
};

params! {
    /// Proportional gain kp of the direction error: the inclination's error decays at kp.
    real kp: "rad/s" = 1.0 in [0.0, 1e6];
    /// Integral gain ki of the direction error, which estimates the gyroscope's bias.
    real ki: "rad/s²" = 0.3 in [0.0, 1e6];
    /// Deviation of the specific force's norm from gravity above which the accelerometer's share of the error falls, linearly to none at
    /// twice as much (Valenti et al. 2015; the adaptive gain that Parikh et al. 2021 propose); 0: never.
    real acc_threshold: "m/s²" = 0.0 in [0.0, 1e6];
    choice integration: Integration;
}

/// Mahony's nonlinear complementary filter.
#[derive(Clone, Debug)]
pub struct Mahony<S: Scalar> {
    params: Params<S>,
    q: Quat<S>,
    bias: Vec3<S>,
    error: Vec3<S>,
    acc_rejected: S::Mask,
}

impl<S: Scalar> Filter<S> for Mahony<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;

    fn new(params: &Params<S>) -> Self {
        Mahony {
            params: params.clone(),
            q: Quat::identity(),
            bias: Vec3::zero(),
            error: Vec3::zero(),
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
        // Ludwig Alg. 1, lines 1-3; Çoçoli eq. 9 with the accelerometer normalised
        let weights = sample.weights(dt);
        let share = trust(sample, self.params.acc_threshold);
        self.acc_rejected = share.le(S::zero());
        self.error = direction_error(self.q.matrix(), sample, share, &weights).sensor;
        // After a gap one sample's error stands for the whole of it: it may be corrected, not overshot.
        let mut kp = self.params.kp;
        let time = weights.time;
        let mut feedback = time;
        let gap = S::of(0.5).lt(kp * time);
        if gap.any() {
            feedback = S::select(gap, S::of(0.5) / kp, time);
            kp = S::select(gap, S::of(0.5) / time, kp);
        }
        // An attitude that was lost is no error of the gyroscope.
        if sample.recovering.any() {
            feedback = S::select(sample.recovering, S::zero(), feedback);
        }
        // Ludwig Alg. 1, line 4; Çoçoli eq. 10 (their integral error is −bias/ki)
        self.bias = self.bias - self.error * (self.params.ki * feedback);
        // Ludwig Alg. 1, lines 5-6; Çoçoli eqs 11-13, with ½ dt taken into each term of ω
        let half_dt = S::of(0.5) * dt;
        let half_turn = (sample.gyr - self.bias) * half_dt + self.error * (kp * (S::of(0.5) * time));
        self.q = self.params.integration.step(self.q, half_turn);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gyr_bias(&self) -> Vec3<S> {
        self.bias
    }
    fn bias_stays_zero(&self) -> bool {
        self.params.ki.le(S::zero()).all()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn flag(&self, flags: &mut Flags<S::Mask>) {
        flags.acc_rejected = self.acc_rejected;
    }
    fn output(&self, _index: usize, put: &mut impl FnMut(S)) {
        self.error.clone().each(&mut |value| put(*value));
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.q.each(visit);
        self.bias.each(visit);
    }
}
