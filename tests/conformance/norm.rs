//! Unit norm and continuous sign.

use crate::bank::{BOTH, choices, run, scalars, settings};
use crate::double_double::DoubleDouble;
use crate::recording::{broken, moving};

/// By how much the norm of the outputs may differ from one, in epsilon.
///
/// The attitude is normalised (to 1.5 epsilon), or a product of a quaternion that was brought back to unit norm by
/// Newton's step (1.5) and an exponential (1: its sine and cosine are of one angle); a product adds up to one, and the
/// frame's rotation with its rounded constants another. Roundings do not all add up: over a million steps and over
/// hostile inputs the largest was 2.6.
pub const NORM_BOUND: f64 = 4.0;

/// | |q| − 1 | to more digits than q has.
pub fn norm_error(q: [f64; 4]) -> f64 {
    let squares = q.map(|c| DoubleDouble::from(c) * DoubleDouble::from(c));
    let norm2 = squares.into_iter().fold(DoubleDouble::ZERO, |sum, square| sum + square);
    0.5 * (norm2 - DoubleDouble::ONE).hi.abs()
}

pub fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn the_norm_stays_one_over_thousands_of_steps() {
    for case in scalars() {
        let mut worst: f64 = 0.0;
        for params in choices(case.spec) {
            for settings in settings() {
                for rows in [moving(1, 2000), broken(2, 2000)] {
                    for reading in run(case.make(&params, settings).as_mut(), &rows, BOTH) {
                        let error = norm_error(reading.quat) / case.epsilon;
                        assert!(error <= NORM_BOUND, "{} {params:?} {settings:?}: {error} epsilon", case.name());
                        worst = worst.max(error);
                    }
                }
            }
        }
        println!("{}: {worst:.2} epsilon", case.name());
    }
}

#[test]
fn the_sign_starts_positive_and_is_continued() {
    for case in scalars() {
        for params in choices(case.spec) {
            for settings in settings() {
                for seed in 0..8 {
                    let readings = run(case.make(&params, settings).as_mut(), &broken(seed, 60), BOTH);
                    assert!(readings[0].quat[0] >= 0.0, "{}: {:?}", case.name(), readings[0]);
                    for pair in readings.windows(2) {
                        // The filter decides by a sum that rounds by an epsilon.
                        assert!(dot(pair[0].quat, pair[1].quat) >= -case.epsilon, "{}: {pair:?}", case.name());
                    }
                }
            }
        }
    }
}
