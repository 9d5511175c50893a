//! The inclination at the start: that of the mean specific force.

use super::Params;
use super::block::Block;
use super::magnetic::SETTLED;
use super::state::{State, THETA, TURN, VELOCITY, initial_variance};
use crate::scalar::{Mask, Scalar};
use crate::so3::{Quat, Vec3};

/// The time in s over which the specific force is averaged. A velocity that changes by 1 m/s in it is 0.1 rad.
const LEVEL_TIME: f64 = 1.0;

/// The specific force since the start, earth frame.
///
/// One sample of a sensor that is moved, or knocked, may be wrong by a right angle, where no linear model holds and bias and
/// matrix would take over what is left. So until there is a mean, nothing else is learnt of the specific force.
#[derive(Clone, Debug)]
pub struct Level<S> {
    sum: Vec3<S>,
    time: S,
}

impl<S: Scalar> Default for Level<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> Level<S> {
    /// Before the first sample.
    pub fn new() -> Self {
        Level { sum: Vec3::zero(), time: S::zero() }
    }

    /// Starts afresh where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn restart(&mut self, lanes: S::Mask) {
        self.sum = Vec3::select(lanes, Vec3::zero(), self.sum);
        self.time = S::select(lanes, S::zero(), self.time);
    }

    /// Levels the attitude, and the field of the block, where the start goes on: gives where, and the turn.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn take(
        &mut self,
        lanes: S::Mask,
        state: &mut State<S>,
        block: &mut Block<S>,
        params: &Params<S>,
    ) -> (S::Mask, Quat<S>) {
        let early = self.time.lt(S::of(LEVEL_TIME)) & S::zero().lt(block.force_time);
        let going = lanes & early & S::of(SETTLED * SETTLED).lt(state.tilt_variance());
        let mut turn = Quat::identity();
        if going.any() {
            let sum = self.sum + block.force;
            let norm2 = sum.norm2();
            let turns = going & norm2.is_normal_norm2();
            let up = Vec3::select(turns, sum * (S::one() / norm2.sqrt()), Vec3::of([0.0, 0.0, 1.0]));
            turn = Quat::shortest_to_up(up);
            state.turn(turns, turn);
            block.field = turn.rotate(block.field);
            self.sum = Vec3::select(going, turn.rotate(sum), self.sum);
            self.time = S::select(going, self.time + block.force_time, self.time);
            for i in [THETA, THETA + 1, TURN, VELOCITY, VELOCITY + 1, VELOCITY + 2] {
                state.forget(going, i, initial_variance(params, i));
            }
            state.put(going, VELOCITY, Vec3::zero());
        }
        (going, turn)
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.sum.each(visit);
        visit(&mut self.time);
    }
}
