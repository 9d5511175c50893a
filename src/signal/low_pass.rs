//! Low-pass filters for samples in any distance of time.
//!
//! [`LowPass`] is the second-order Butterworth filter in the form of a trapezoidal state-variable filter (two integrators
//! in a loop, by the trapezoidal rule). At a constant step it equals the bilinear transform of the Butterworth filter;
//! its coefficients depend on the step alone, so the step may vary. The step is that of a [`Section`].

#![allow(clippy::indexing_slicing, reason = "arrays with their size as a type; every index is below it")]

use core::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use super::{Section, Sum};
use crate::scalar::{Mask, Scalar};
use crate::so3::Vec3;
use crate::trig::{one_minus_exp, sin_cos};

/// What a [`LowPass`] needs to know of its time constant τ and the step: computed anew only where the step changes.
#[derive(Clone, Debug)]
pub struct Coefficients<S: Scalar> {
    tau: S,
    /// The step in s to which the rest belongs; negative before the first.
    dt: S,
    section: Section<S>,
    /// Set where the step is too long for the time constant: the signal passes through.
    passes: S::Mask,
}

impl<S: Scalar> Coefficients<S> {
    /// For the time constant τ in s: the cut-off frequency is √2/(2πτ) (Laidig & Seel 2023).
    pub fn new(tau: S) -> Self {
        Coefficients { tau, dt: -S::one(), section: Section::still(), passes: S::Mask::splat(false) }
    }

    /// Goes over to the step `dt` in s where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn set_step(&mut self, lanes: S::Mask, dt: S) {
        let dt = if lanes.all() { dt } else { S::select(lanes, dt, self.dt) };
        if (dt.lt(self.dt) | self.dt.lt(dt)).any() {
            self.dt = dt;
            // A cut-off above the Nyquist frequency; τ = 0 is one at any step.
            self.passes = self.tau.lt(S::of(0.5) * dt) | self.tau.le(S::zero());
            let (sin, cos) = sin_cos(S::select(self.passes, S::zero(), S::of(FRAC_1_SQRT_2) * dt / self.tau));
            self.section = Section::new(sin / cos, S::of(SQRT_2));
        }
    }
}

/// A second-order Butterworth filter of N signals with common steps.
///
/// Until the time constant has gone by it gives the mean of the samples so far (all of them weigh the same), and goes on
/// from there.
#[derive(Clone, Debug)]
pub struct LowPass<S, const N: usize> {
    /// The integrators: the slope and the value, as the trapezoidal rule carries them from step to step.
    slope: [S; N],
    value: [S; N],
    /// How many samples the mean at the start is of, and the time in s that they stand for. A plain sum of steps would
    /// end the start one sample late at some rates.
    count: S,
    time: Sum<S>,
}

impl<S: Scalar, const N: usize> Default for LowPass<S, N> {
    /// Before the first sample.
    fn default() -> Self {
        let zero = S::zero();
        LowPass { slope: [zero; N], value: [zero; N], count: zero, time: Sum::new(zero) }
    }
}

impl<S: Scalar, const N: usize> LowPass<S, N> {
    /// At rest at the values, as after a long time with them.
    pub fn at(values: [S; N], coefficients: &Coefficients<S>) -> Self {
        LowPass { value: values, time: Sum::new(coefficients.tau), ..Self::default() }
    }

    /// The same where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn set(&mut self, lanes: S::Mask, values: [S; N], coefficients: &Coefficients<S>) {
        let at = Self::at(values, coefficients);
        for i in 0..N {
            self.slope[i] = S::select(lanes, at.slope[i], self.slope[i]);
            self.value[i] = S::select(lanes, at.value[i], self.value[i]);
        }
        self.count = S::select(lanes, at.count, self.count);
        self.time = Sum::select(lanes, at.time, self.time);
    }

    /// Takes a sample after the coefficients' step where the mask is true, and gives the filtered one; where the mask is
    /// false that lane of what it gives has no meaning.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step(&mut self, lanes: S::Mask, x: [S; N], coefficients: &Coefficients<S>) -> [S; N] {
        let Coefficients { tau, section, passes, .. } = *coefficients;
        let half = S::of(0.5);
        let starting = self.time.value.lt(tau);
        let regular = lanes & !(starting | passes);
        let count = self.count + S::one();
        let mut y = x;
        for i in 0..N {
            let (slope, value) = (self.slope[i], self.value[i]);
            let (bend, change) = section.changes(slope, value, x[i]);
            let new_slope = slope + bend;
            let new_value = value + change;
            let filtered = value + half * change;
            if regular.all() {
                (self.slope[i], self.value[i], y[i]) = (new_slope, new_value, filtered);
            } else {
                let mean = value + (x[i] - value) / count;
                let otherwise = S::select(starting, mean, x[i]);
                self.slope[i] = S::select(lanes, S::select(regular, new_slope, S::zero()), slope);
                self.value[i] = S::select(lanes, S::select(regular, new_value, otherwise), value);
                y[i] = S::select(regular, filtered, otherwise);
            }
        }
        let counted = lanes & starting;
        if counted.any() {
            self.count = S::select(counted, count, self.count);
            self.time = Sum::select(counted, self.time.plus(coefficients.dt), self.time);
        }
        y
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.slope.iter_mut().chain(&mut self.value).for_each(&mut *visit);
        visit(&mut self.count);
        self.time.each(visit);
    }
}

impl<S: Scalar> LowPass<S, 3> {
    /// [`LowPass::step`] of a vector.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step_vector(&mut self, lanes: S::Mask, v: Vec3<S>, coefficients: &Coefficients<S>) -> Vec3<S> {
        let [x, y, z] = self.step(lanes, [v.x, v.y, v.z], coefficients);
        Vec3::new(x, y, z)
    }
}

/// The weight 1 − exp(−dt/τ) of a new sample in a first-order low-pass filter: computed anew only where the step changes.
#[derive(Clone, Debug)]
pub struct Gain<S> {
    tau: S,
    /// The step in s to which the weight belongs; negative before the first.
    dt: S,
    weight: S,
}

impl<S: Scalar> Gain<S> {
    /// For the time constant τ in s; at zero a new sample is all that counts.
    pub fn new(tau: S) -> Self {
        Gain { tau, dt: -S::one(), weight: S::zero() }
    }

    /// The weight of a sample after the step `dt` in s, where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn weight(&mut self, lanes: S::Mask, dt: S) -> S {
        let dt = if lanes.all() { dt } else { S::select(lanes, dt, self.dt) };
        if (dt.lt(self.dt) | self.dt.lt(dt)).any() {
            self.dt = dt;
            let instant = self.tau.le(S::zero());
            self.weight = S::select(instant, S::one(), one_minus_exp(dt / S::select(instant, S::one(), self.tau)));
        }
        self.weight
    }
}
