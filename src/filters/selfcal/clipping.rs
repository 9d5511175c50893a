//! Where an axis of the gyroscope is at the end of its range.

use crate::scalar::Scalar;
use crate::so3::Vec3;

/// A reading counts as at the range from this share of it on.
const AT_RANGE: f64 = 0.995;
/// The smallest range in rad/s that a sensor has: what is below is not taken for the end of an unknown one.
const SMALLEST_RANGE: f64 = 4.0;
/// An end of the range is this share of the largest reading of its axis, or more: the ends differ by bias and calibration.
const NEAR_LARGEST: f64 = 0.95;
/// A reading stands still where it changes by less than this share of itself in a second, and moved before where it changed by
/// more than that, two samples before. A smooth motion has no such edge: at its peak, ω₀ cos Ωt, it stands still for
/// 0.2 s⁻¹/Ω², and where that is five samples long, the change two samples before is below 0.18 s⁻¹ ω₀.
const STILL: f64 = 0.1;
const MOVED: f64 = 0.5;
/// So many samples have to stand still.
const SAMPLES: f64 = 5.0;
/// A rate that went on as a parabola would enclose slope · T²/6 with the clipped one; half as much again is its deviation. It is
/// that of an error of this many rad/s at most, and for this many s.
const PARABOLA: f64 = 0.25;
const ERROR: f64 = 3.0;
const LONGEST: f64 = 1.0;
/// Where a change stops counting, in rad/s².
const FASTEST: f64 = 1e12;

/// One axis of the gyroscope.
#[derive(Clone, Copy, Debug)]
struct Axis<S> {
    /// The last reading, and the largest one so far, in rad/s.
    last: S,
    largest: S,
    /// How fast it changed in the last two samples, in rad/s².
    change: S,
    before: S,
    /// How many samples it stands still, how fast it changed before, and the deviation of the angle that is lost.
    still: S,
    slope: S,
    time: S,
    lost: S,
}

/// A detector for the three axes.
#[derive(Clone, Debug)]
pub struct Clipping<S> {
    axes: [Axis<S>; 3],
}

/// What of a rate is clipped: for each axis the variance in rad² that the step adds to the angle, zero where it is not.
pub type Clipped<S> = Vec3<S>;

impl<S: Scalar> Default for Clipping<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> Clipping<S> {
    /// Before the first sample.
    pub fn new() -> Self {
        let o = S::zero();
        Clipping { axes: [Axis { last: o, largest: o, change: o, before: o, still: o, slope: o, time: o, lost: o }; 3] }
    }

    /// Goes on by `dt` to a reading; `range` is that of the sensor, zero where it is not known.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn see(&mut self, gyr: Vec3<S>, range: S, dt: S) -> Clipped<S> {
        let [x, y, z] = &mut self.axes;
        let [mx, my, mz] = [x.moved(gyr.x), y.moved(gyr.y), z.moved(gyr.z)];
        let x = x.see(gyr.x, my | mz, range, dt);
        let y = y.see(gyr.y, mz | mx, range, dt);
        Vec3::new(x, y, z.see(gyr.z, mx | my, range, dt))
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        for Axis { last, largest, change, before, still, slope, time, lost } in &mut self.axes {
            for variable in [last, largest, change, before, still, slope, time, lost] {
                visit(variable);
            }
        }
    }
}

impl<S: Scalar> Axis<S> {
    /// Where a reading is not the last one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn moved(&self, rate: S) -> S::Mask {
        S::zero().lt((rate - self.last).abs())
    }

    /// The variance of a step; `others` says whether another axis moves. That of n steps is the square of a sum: the error has one sign.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn see(&mut self, rate: S, others: S::Mask, range: S, dt: S) -> S {
        let size = rate.abs();
        self.largest = self.largest.max(size);
        let moves = S::zero().lt(dt);
        let change = S::select(moves, ((rate - self.last).abs() / dt).min(S::of(FASTEST)), self.change);
        let high = S::of(SMALLEST_RANGE).lt(size) & (S::of(NEAR_LARGEST) * self.largest).le(size);
        let stands = high & change.lt(S::of(STILL) * size);
        // Or where it is the same to the last bit, and others are not.
        let begins = (S::of(MOVED) * size).lt(self.before) | (others & change.le(S::zero()));
        let going = S::zero().lt(self.still);
        let still = (self.still + S::one()).min(S::of(1e6));
        let still = S::select(stands & (begins | going), still, S::zero());
        let at_range = S::zero().lt(range) & (S::of(AT_RANGE) * range).le(size);
        let clipped = at_range | S::of(SAMPLES).le(still);
        let starts = !(going | S::zero().lt(self.time));
        let slope = S::select(moves & starts, self.before.max(self.change), self.slope);
        // When the run is long enough, it has been clipped all the time.
        let since = S::select(S::zero().lt(self.time), self.time + dt, S::select(at_range, dt, still * dt));
        let since = S::select(clipped, since.min(S::of(LONGEST)), S::zero());
        let lost = (S::of(PARABOLA) * slope * since).min(S::of(ERROR)) * since;
        let added = lost * lost - self.lost * self.lost;
        self.before = S::select(moves, self.change, self.before);
        self.change = change;
        self.last = rate;
        self.still = S::select(moves, still, self.still);
        (self.slope, self.time, self.lost) = (slope, since, lost);
        S::select(clipped, added.max(S::zero()), S::zero())
    }
}
