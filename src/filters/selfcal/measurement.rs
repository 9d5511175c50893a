//! Scalar measurements of a block, taken one after the other.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use super::Params;
use super::block::Block;
use super::state::{BIAS, DELAY, DISTURBANCE, HORIZONTAL, IRON, N, State, THETA, TURN, VELOCITY, VERTICAL, within};
use crate::filters::kalman::{Column, zeros};
use crate::scalar::{Mask, Real, Scalar};
use crate::so3::{Matrix3, Vec3};

/// How much of the old diagonal is added in every correction, in epsilons of the scalar: more than the typical rounding.
const ROUNDING: f64 = 4.0;
/// The largest number of states that a measurement shows.
const SEEN: usize = 9;

/// A scalar measurement z = h x + noise of the error x.
#[derive(Clone, Copy, Debug)]
pub struct Row<S: Scalar> {
    /// Where it is taken.
    pub lanes: S::Mask,
    /// The states that it shows; what is not needed is there with the factor zero.
    pub at: [usize; SEEN],
    /// How each of them enters.
    pub h: [S; SEEN],
    /// The innovation.
    pub z: S,
    /// The variance of the noise.
    pub r: S,
    /// True where it is not to move the inclination.
    pub level: bool,
}

impl<S: Scalar> Row<S> {
    /// One that is never taken.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn none() -> Self {
        Self::of_one(S::Mask::splat(false), 0, S::zero(), S::one())
    }
    /// The measurement of one state.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_one(lanes: S::Mask, state: usize, z: S, r: S) -> Self {
        let o = S::zero();
        Row { lanes, at: [state, 0, 0, 0, 0, 0, 0, 0, 0], h: [S::one(), o, o, o, o, o, o, o, o], z, r, level: false }
    }
}

/// Takes measurements one after the other into the covariance of the state; gives the correction.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn correct<S: Scalar, const ROWS: usize>(state: &mut State<S>, measurements: &[Row<S>; ROWS]) -> Column<S, N> {
    let mut x: Column<S, N> = zeros();
    let p = &mut state.p;
    for row in measurements {
        if !row.lanes.any() {
            continue;
        }
        // v = P hᵀ.
        let mut v: Column<S, N> = zeros();
        let mut known = S::zero();
        for (&at, &h) in row.at.iter().zip(&row.h) {
            let at = within(at);
            for i in 0..N {
                v[i] = v[i] + p[(i, at)] * h;
            }
            known = known + x[at] * h;
        }
        let mut s = row.r;
        for (&at, &h) in row.at.iter().zip(&row.h) {
            s = s + v[within(at)] * h;
        }
        // x + v ν/s and P − v vᵀ/s, the same for (i, j) and (j, i), with a spare for the rounding.
        let lanes = row.lanes & s.is_normal_norm2();
        let over_s = S::select(lanes, S::one() / s, S::zero());
        let nu = S::select(lanes, row.z - known, S::zero());
        let spare = S::select(lanes, S::of(ROUNDING) * S::splat(S::Real::EPSILON), S::zero());
        let nu_over_s = nu * over_s;
        // The gain of the inclination is zero where it is not to move (Schmidt), and its covariance stays.
        let gain = if row.level { TURN } else { 0 };
        let tilt = [p[(0, 0)], p[(0, 1)], p[(1, 1)]];
        for j in 0..N {
            let (vj, grown) = (v[j], p[(j, j)] * spare);
            for i in 0..N {
                p[(i, j)] = p[(i, j)] - (v[i] * vj) * over_s;
            }
            p[(j, j)] = p[(j, j)] + grown;
            if j >= gain {
                x[j] = x[j] + vj * nu_over_s;
            }
        }
        if row.level {
            (p[(0, 0)], p[(0, 1)], p[(1, 0)], p[(1, 1)]) = (tilt[0], tilt[1], tilt[1], tilt[2]);
        }
    }
    x
}

/// The velocity, which is never far from zero for long: a pseudo-measurement, that of rest where the sensor rests.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn velocity<S: Scalar>(
    lanes: S::Mask,
    rest: S::Mask,
    state: &State<S>,
    time: S,
    params: &Params<S>,
) -> [Row<S>; 3] {
    let moving = S::of(2.0) * params.velocity * params.velocity * params.velocity_time / time;
    let variance = S::select(rest, params.rest_velocity * params.rest_velocity, moving);
    let v = state.velocity();
    let row = |i: usize, v: S| Row::of_one(lanes, VELOCITY + i, -v, variance);
    [row(0, v.x), row(1, v.y), row(2, v.z)]
}

/// The gyroscope's bias, which is its rate at rest.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn rest<S: Scalar>(
    lanes: S::Mask,
    mean_rate: Vec3<S>,
    state: &State<S>,
    time: S,
    params: &Params<S>,
) -> [Row<S>; 3] {
    let variance = params.rest_noise * params.rest_noise / time;
    let off = mean_rate - state.bias();
    let row = |i: usize, off: S| Row::of_one(lanes, BIAS + i, off, variance);
    [row(0, off.x), row(1, off.y), row(2, off.z)]
}

/// The mean field of a block, as it is against what is expected.
#[derive(Clone, Copy, Debug)]
pub struct Seen<S: Scalar> {
    /// In the earth frame, less the delay.
    pub field: Vec3<S>,
    /// Its derivative by the delay.
    change: Vec3<S>,
    /// The mean rotation.
    turn: Matrix3<S>,
    /// What is expected of a field without disturbance, and the measured field less it.
    off: Vec3<S>,
    /// The field without the hard iron.
    pub clean: Vec3<S>,
}

impl<S: Scalar> Seen<S> {
    /// The field of a block.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(block: &Block<S>, state: &State<S>) -> Self {
        let over = S::one() / block.fields.max(S::one());
        let turn = Matrix3 { x: block.field_turn.x * over, y: block.field_turn.y * over, z: block.field_turn.z * over };
        let field = block.field * over;
        let clean = field - turn.apply(state.hard_iron());
        let expected = Vec3::new(S::zero(), state.mean[HORIZONTAL], state.mean[VERTICAL]);
        Seen { field, change: block.field_change * over, turn, off: clean - expected, clean }
    }

    /// How far the field is from the reference, squared: its norm across and along the vertical count wholly, the heading
    /// by a share.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn deviation2(&self, share: f64) -> S {
        let Vec3 { x, y, z } = self.off;
        let across = (self.clean.x * self.clean.x + self.clean.y * self.clean.y).sqrt();
        // off.y is clean.y less the horizontal reference.
        let longer = across - (self.clean.y - y);
        let longer2 = longer * longer;
        let turned2 = (x * x + y * y - longer2).max(S::zero());
        longer2 + z * z + S::of(share) * turned2
    }

    /// The measurements: y_x = −θ_z y_y … as derived in the filter's description. `variance` is that of a component, and
    /// the tilt, by which the magnetometer is not to move the inclination, counts as noise.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rows(&self, lanes: S::Mask, state: &State<S>, variance: S) -> [Row<S>; 3] {
        let o = S::zero();
        let one = S::one();
        let Vec3 { x, y, z } = self.field;
        let nu = self.off - state.disturbance();
        let row = |i: usize, [east, north, turn]: [S; 3], iron: Vec3<S>, reference: (usize, S), change: S, z: S| Row {
            lanes,
            at: [THETA, THETA + 1, TURN, IRON, IRON + 1, IRON + 2, DISTURBANCE + i, reference.0, DELAY],
            h: [east, north, turn, iron.x, iron.y, iron.z, one, reference.1, change],
            z,
            r: variance,
            level: true,
        };
        [
            row(0, [o, -z, y], self.turn.x, (HORIZONTAL, o), self.change.x, nu.x),
            row(1, [z, o, -x], self.turn.y, (HORIZONTAL, one), self.change.y, nu.y),
            row(2, [-y, x, o], self.turn.z, (VERTICAL, one), self.change.z, nu.z),
        ]
    }
}
