//! Butterworth low-pass filters of order 1 to 8 for samples in any distance of time.
//!
//! A filter is a chain of [`Section`]s with the dampings k = 2 cos θ of its pairs of poles, and for an odd order one of first
//! order, all by the trapezoidal rule. At a constant step that is the bilinear transform of the Butterworth filter.
//!
//! A section of a chain is driven by the mean of its input over the step, ½ (x' + x), and gives the new value of its
//! integrator. [`LowPass`](super::LowPass) does the same in the other order: it takes x and gives the mean of the
//! integrator, which therefore stands half a step ahead. At a constant step both have the same transfer function; here the
//! states belong to the time of the sample, so that a step of no length changes nothing. With steps that vary up to half a
//! period of the cut-off both ring for a while: at random ones up to 3.2 times the signal was seen (tests/signal).

#![allow(clippy::indexing_slicing, reason = "arrays with their size as a type; every index is below it")]

use core::f64::consts::PI;
use core::fmt;

use super::Section;
use crate::scalar::{Mask, Real, Scalar};
use crate::so3::Vec3;
use crate::trig::sin_cos;

/// The highest order.
pub const HIGHEST_ORDER: usize = 8;
const SECTIONS: usize = HIGHEST_ORDER / 2;

/// What a filter cannot be made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DesignError {
    /// An order that is not from 1 to [`HIGHEST_ORDER`].
    Order(usize),
    /// A cut-off frequency that is not a positive, finite number of Hz.
    Cutoff(f64),
}

impl fmt::Display for DesignError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DesignError::Order(order) => write!(f, "order must be in [1, {HIGHEST_ORDER}], got {order}"),
            DesignError::Cutoff(cutoff) => write!(f, "cutoff must be a positive, finite number of Hz, got {cutoff}"),
        }
    }
}

impl core::error::Error for DesignError {}

/// A Butterworth low-pass filter of N signals with common samples.
///
/// The first sample is what it starts at rest at, so there is no transient. A sample of which a signal is NaN, infinite, or
/// so large that its square is, is no measurement: the output holds, and the time counts towards the step of the next one.
/// A step of half a period of the cut-off frequency or longer (a cut-off at or above the Nyquist frequency of that step)
/// passes the sample through, and the filter goes on from there: after a long gap it starts afresh.
///
/// ```
/// use ahrs_rs::signal::Butterworth;
///
/// let mut low_pass = Butterworth::<f32>::new(4, 10.0).unwrap(); // order, Hz
/// assert_eq!(low_pass.step(9.81, 0.005), 9.81); // sample, s since the last one
/// ```
#[derive(Clone, Debug)]
pub struct Butterworth<S: Scalar, const N: usize = 1> {
    design: Design<S>,
    /// The last sample.
    input: [S; N],
    /// The section of first order; not used where the order is even.
    single: [S; N],
    /// The sections of second order; as many are used as there are pairs of poles.
    slope: [[S; N]; SECTIONS],
    value: [[S; N]; SECTIONS],
    /// The time in s since the last sample that was a measurement.
    waiting: S,
    /// One from the first measurement on.
    started: S,
}

/// Order and cut-off frequency, and what follows from them at a step: computed anew only where the step changes.
#[derive(Clone, Debug)]
struct Design<S: Scalar> {
    order: usize,
    cutoff: S,
    damping: [S; SECTIONS],
    /// The step in s to which the rest belongs; negative before the first.
    dt: S,
    /// 2g/(1 + g) of the section of first order.
    single: S,
    sections: [Section<S>; SECTIONS],
    /// Set where the step is too long for the cut-off frequency.
    passes: S::Mask,
}

impl<S: Scalar> Design<S> {
    fn new(order: usize, cutoff: S) -> Result<Self, DesignError> {
        if !(1..=HIGHEST_ORDER).contains(&order) {
            return Err(DesignError::Order(order));
        }
        let allowed = |cutoff: &S::Real| <S::Real as Scalar>::zero().lt(*cutoff) && cutoff.le(S::Real::MAX);
        let bad = (0..S::LANES).map(|lane| cutoff.lane(lane)).find(|cutoff| !allowed(cutoff));
        if let Some(bad) = bad {
            return Err(DesignError::Cutoff(bad.to_f64()));
        }
        // The poles stand at θ = (i + ½) π/order from the negative axis for an even order, at (i + 1) π/order for an odd
        // one. The strongly damped ones come first: the peak of the others is then never fed with the bare signal.
        let offset = if order.is_multiple_of(2) { 0.5 } else { 1.0 };
        let mut damping = [S::zero(); SECTIONS];
        for (i, damping) in damping.iter_mut().enumerate().take(order / 2) {
            *damping = S::of(2.0) * sin_cos(S::of((i as f64 + offset) * PI / order as f64)).1;
        }
        let zero = S::zero();
        let (sections, passes) = ([Section::still(); SECTIONS], S::Mask::splat(false));
        Ok(Design { order, cutoff, damping, dt: -S::one(), single: zero, sections, passes })
    }

    /// Goes over to the step `dt` in s where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_step(&mut self, lanes: S::Mask, dt: S) {
        let dt = if lanes.all() { dt } else { S::select(lanes, dt, self.dt) };
        if (dt.lt(self.dt) | self.dt.lt(dt)).any() {
            self.refresh(dt);
        }
    }

    fn refresh(&mut self, dt: S) {
        self.dt = dt;
        let cycles = self.cutoff * dt;
        let beyond = S::of(0.5).le(cycles);
        let (sin, cos) = sin_cos(S::of(PI) * S::select(beyond, S::zero(), cycles));
        // So close to the Nyquist frequency that rounding could make g negative, and the filter unstable.
        self.passes = beyond | cos.le(S::splat(S::Real::EPSILON));
        let g = S::select(self.passes, S::zero(), sin / cos);
        self.single = S::of(2.0) * g / (S::one() + g);
        for (section, damping) in self.sections.iter_mut().zip(self.damping).take(self.order / 2) {
            *section = Section::new(g, damping);
        }
    }
}

impl<S: Scalar, const N: usize> Butterworth<S, N> {
    /// Of the order 1 to 8, with the cut-off frequency (−3 dB) in Hz.
    pub fn new(order: usize, cutoff: S) -> Result<Self, DesignError> {
        let zero = [S::zero(); N];
        Ok(Butterworth {
            design: Design::new(order, cutoff)?,
            input: zero,
            single: zero,
            slope: [zero; SECTIONS],
            value: [zero; SECTIONS],
            waiting: S::zero(),
            started: S::zero(),
        })
    }

    /// Forgets all samples.
    pub fn reset(&mut self) {
        self.each(&mut |variable| *variable = S::zero());
    }

    /// The last filtered sample; NaN before the first measurement.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn output(&self) -> [S; N] {
        let last = self.value.iter().take(self.design.order / 2).next_back().unwrap_or(&self.single);
        let started = S::zero().lt(self.started);
        last.map(|value| S::select(started, value, S::splat(S::Real::NAN)))
    }

    /// Takes a sample `dt` s after the one before, where the mask is true, and gives the filtered one; where the mask is
    /// false nothing changes. A `dt` that is negative or NaN counts as zero.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step_lanes(&mut self, lanes: S::Mask, x: [S; N], dt: S) -> [S; N] {
        let elapsed = (self.waiting + dt.max(S::zero())).min(S::splat(S::Real::MAX));
        let measured = x.iter().fold(lanes, |all, x| all & is_measurement(*x));
        if measured.any() {
            self.design.set_step(measured, elapsed);
            self.take(measured, x);
        }
        let missing = S::select(lanes, elapsed, self.waiting);
        self.waiting = S::select(measured, S::zero(), missing);
        self.started = S::select(measured, S::one(), self.started);
        self.output()
    }

    /// Takes a measurement where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take(&mut self, measured: S::Mask, x: [S; N]) {
        let Design { order, single, ref sections, passes, .. } = self.design;
        let regular = measured & S::zero().lt(self.started) & !passes;
        // What does not go on starts at rest at the sample.
        let chosen = |new: S, start: S, old: S| {
            if regular.all() { new } else { S::select(measured, S::select(regular, new, start), old) }
        };
        for i in 0..N {
            let (mut before, mut after) = (self.input[i], x[i]);
            self.input[i] = chosen(after, after, before);
            if order % 2 == 1 {
                let value = self.single[i];
                let new = value + single * (mean(before, after) - value);
                self.single[i] = chosen(new, x[i], value);
                (before, after) = (value, new);
            }
            for (section, (slopes, values)) in
                sections.iter().zip(self.slope.iter_mut().zip(&mut self.value)).take(order / 2)
            {
                let (slope, value) = (slopes[i], values[i]);
                let (bend, change) = section.changes(slope, value, mean(before, after));
                let new = value + change;
                slopes[i] = chosen(slope + bend, S::zero(), slope);
                values[i] = chosen(new, x[i], value);
                (before, after) = (value, new);
            }
        }
    }

    /// Calls `visit` for each variable: all that the next sample depends on.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        let pairs = self.design.order / 2;
        self.input.iter_mut().for_each(&mut *visit);
        if self.design.order % 2 == 1 {
            self.single.iter_mut().for_each(&mut *visit);
        }
        for state in self.slope.iter_mut().take(pairs).chain(self.value.iter_mut().take(pairs)) {
            state.iter_mut().for_each(&mut *visit);
        }
        visit(&mut self.waiting);
        visit(&mut self.started);
    }
}

impl<S: Scalar> Butterworth<S, 1> {
    /// Takes a sample `dt` s after the one before and gives the filtered one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step(&mut self, x: S, dt: S) -> S {
        let [y] = self.step_lanes(S::Mask::splat(true), [x], dt);
        y
    }
}

impl<S: Scalar> Butterworth<S, 3> {
    /// Takes a vector `dt` s after the one before and gives the filtered one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step_vector(&mut self, v: Vec3<S>, dt: S) -> Vec3<S> {
        let [x, y, z] = self.step_lanes(S::Mask::splat(true), [v.x, v.y, v.z], dt);
        Vec3::new(x, y, z)
    }
}

/// Whether a number is taken as a sample: it is finite, and so is its square.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn is_measurement<S: Scalar>(x: S) -> S::Mask {
    (x * x).le(S::splat(S::Real::MAX))
}

/// The mean of two numbers; halved first, so that it does not overflow.
#[cfg_attr(not(debug_assertions), inline(always))]
fn mean<S: Scalar>(a: S, b: S) -> S {
    let half = S::of(0.5);
    half * a + half * b
}
