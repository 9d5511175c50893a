//! The start: alignment, a given attitude, and steps of no length.

use ahrs_rs::estimator::LONGEST_STEP;
use ahrs_rs::so3::rotate_by;
use ahrs_rs::{Euler, Quat, Settings, Vec3};

use crate::bank::{ACC, BOTH, Case, NONE, Reading, Row, choices, run, scalars, settings};
use crate::random::Random;
use crate::recording::{moving, quat, still};

pub fn array(q: Quat<f64>) -> [f64; 4] {
    [q.w, q.x, q.y, q.z]
}

/// The angle between two attitudes, in rad.
pub fn angle(a: [f64; 4], b: [f64; 4]) -> f64 {
    let between = quat(a).conj() * quat(b);
    2.0 * between.vector().norm2().sqrt().min(1.0).asin()
}

/// By how much an attitude that fits the measurements may be off, in rad.
///
/// In f64 alignment rounds by up to 80 epsilon (`missing.rs`), 150 steps by less. In f32 the rounding of the predicted
/// directions can exceed the floor below which a normalised gradient counts as none: such a filter then takes a step,
/// Madgwick's of 2β dt = 8e-4 rad.
pub fn rounding(case: &Case) -> f64 {
    if case.real == "f32" { 1e-3 } else { 120.0 * case.epsilon }
}

#[test]
fn the_first_sample_makes_no_step_unless_an_attitude_is_given_or_the_filter_starts_itself() {
    for case in scalars() {
        for params in choices(case.spec) {
            for sensors in [NONE, ACC, BOTH] {
                let first = moving(11, 1)[0];
                let start = |row: Row| {
                    let mut bank = case.make(&params, Settings::default());
                    run(bank.as_mut(), &[row], sensors)[0].bits()
                };
                let turning = start(Row { gyr: [3.0, -2.0, 1.0], dt: 5.0, ..first });
                let still = start(Row { gyr: [0.0; 3], dt: 0.0, ..first });
                assert_eq!(turning == still, !case.starts_itself, "{} {params:?}", case.name());
            }
            let mut bank = case.make(&params, Settings::default());
            bank.start_from(&[[1.0, 0.0, 0.0, 0.0]]);
            let row = Row { gyr: [0.0, 0.0, 2.0], acc: [f64::NAN; 3], mag: [f64::NAN; 3], dt: 0.01 };
            let turned = run(bank.as_mut(), &[row], NONE)[0].quat;
            // By 0.02 rad; a first-order step by 2 (h − atan h) = 6.7e-7 less, and a rate that is a state, of variance 1 at
            // the start and 1.005 after the step, by half a percent less.
            assert!((2.0 * turned[3].asin() - 0.02).abs() < 1.1e-4, "{} {params:?}: {turned:?}", case.name());
        }
    }
}

#[test]
fn without_a_field_the_start_is_the_shortest_rotation_to_up() {
    for case in scalars() {
        for params in choices(case.spec) {
            for seed in 0..20 {
                let row = moving(seed, 1)[0];
                let start = run(case.make(&params, Settings::default()).as_mut(), &[row], ACC)[0].quat;
                let before = if case.starts_itself {
                    rotate_by(Quat::identity(), Vec3::of(row.gyr), row.dt)
                } else {
                    Quat::identity()
                };
                let expected = array(Quat::shortest_to_up(before.rotate(Vec3::of(row.acc)).unit()) * before);
                for (value, expected) in start.iter().zip(expected) {
                    // f32 rounds the vector and the rotation; a filter that keeps Euler angles adds 24: see tests/so3.rs.
                    assert!((value - expected).abs() <= 32.0 * case.epsilon, "{} {params:?}", case.name());
                }
            }
        }
    }
}

#[test]
fn a_still_sensor_keeps_the_attitude_that_it_is_given() {
    for case in scalars() {
        let mut worst: f64 = 0.0;
        for params in choices(case.spec) {
            let mut random = Random(12);
            for settings in settings() {
                // The attitude from magnetic north, and how the user says it: from true north, in the frame.
                let q = quat(random.rotation());
                let (sin, cos) = (-0.5 * settings.declination).sin_cos();
                let q0 = array(settings.frame.from_enu::<f64>() * Quat::new(cos, 0.0, 0.0, sin) * q);
                for sensors in [NONE, ACC, BOTH] {
                    let mut bank = case.make(&params, settings);
                    bank.start_from(&[q0]);
                    for reading in run(bank.as_mut(), &still(q, 150), sensors) {
                        worst = worst.max(angle(reading.quat, q0));
                    }
                }
            }
        }
        println!("{}: {:.2} epsilon", case.name(), worst / case.epsilon);
        assert!(worst <= rounding(&case), "{}: {worst:e} rad", case.name());
    }
}

#[test]
fn the_length_and_sign_of_a_given_attitude_do_not_matter() {
    for case in scalars() {
        let rows = moving(13, 20);
        let start = |q0: [f64; 4]| {
            let mut bank = case.make(&[], Settings::default());
            bank.start_from(&[q0]);
            run(bank.as_mut(), &rows, BOTH).iter().map(Reading::bits).collect::<Vec<_>>()
        };
        let q0 = Random(14).rotation();
        // Powers of two, so that nothing rounds. A start from −q gives the same outputs by the rule of the sign.
        assert_eq!(start(q0.map(|c| 1024.0 * c)), start(q0), "{}", case.name());
        let identity = start([1.0, 0.0, 0.0, 0.0]);
        for none in [[0.0; 4], [f64::NAN, 1.0, 0.0, 0.0], [0.0, f64::INFINITY, 0.0, 0.0], [1e-170, 0.0, 0.0, 1e-170]] {
            assert_eq!(start(none), identity, "{}: {none:?} has no direction", case.name());
        }
    }
}

#[test]
fn a_step_of_no_length_without_measurements_changes_nothing() {
    for case in scalars() {
        let mut worst: f64 = 0.0;
        for params in choices(case.spec) {
            let mut bank = case.make(&params, Settings::default());
            let before = run(bank.as_mut(), &moving(15, 50), BOTH).pop().unwrap();
            let nothing = Row { gyr: [1.0, 2.0, 3.0], acc: [f64::NAN; 3], mag: [f64::NAN; 3], dt: 0.0 };
            for after in run(bank.as_mut(), &[nothing; 100], BOTH) {
                assert_eq!(after.gyr_bias, before.gyr_bias, "{} {params:?}", case.name());
                for (a, b) in after.quat.iter().zip(before.quat) {
                    worst = worst.max((a - b).abs() / case.epsilon);
                }
            }
        }
        println!("{}: {worst} epsilon", case.name());
        // An attitude may be normalised once more, or go to Euler angles and back, and then stays.
        assert!(worst <= 4.0, "{}: {worst} epsilon", case.name());
    }
}

#[test]
fn steps_count_as_none_below_zero_and_as_the_longest_above_it() {
    for case in scalars() {
        for params in choices(case.spec) {
            let with = |dt: f64| {
                let mut rows = moving(16, 20);
                rows[10].dt = dt;
                let readings = run(case.make(&params, Settings::default()).as_mut(), &rows, BOTH);
                readings.iter().map(Reading::bits).collect::<Vec<_>>()
            };
            for dt in [-1.0, -f64::INFINITY, f64::NAN, -0.0] {
                assert_eq!(with(dt), with(0.0), "{} {params:?}: {dt}", case.name());
            }
            for dt in [2.0 * LONGEST_STEP, 1e30, f64::INFINITY] {
                assert_eq!(with(dt), with(LONGEST_STEP), "{} {params:?}: {dt}", case.name());
            }
        }
    }
}

#[test]
fn the_start_finds_the_attitude_at_every_pole_and_half_turn() {
    // Lying on each of the six sides, and next to them.
    let tilts = [0.0, 0.5, 1.0, 1.5, 2.0].map(|quarter| quarter * std::f64::consts::FRAC_PI_2);
    for case in scalars() {
        for params in choices(case.spec) {
            for roll in tilts.iter().flat_map(|&tilt| [tilt, tilt + 1e-8, tilt - 1e-4]) {
                for pitch in tilts {
                    let q = Euler { roll, pitch, yaw: 0.3 }.to_quat();
                    let readings = run(case.make(&params, Settings::default()).as_mut(), &still(q, 3), BOTH);
                    // A filter that starts by itself may take the turn that aligns for one that its bias has made: VQF's is
                    // then 0.0025 (the first gain, (0.5/0.1)² of 10⁴) of 2 °/s, which turns three samples by 2.6e-6 rad.
                    let bound = if case.starts_itself { rounding(&case).max(3e-6) } else { rounding(&case) };
                    for reading in readings {
                        let error = angle(reading.quat, array(q));
                        assert!(error <= bound, "{} {params:?} {q:?}: {error:e}", case.name());
                    }
                }
            }
        }
    }
}
