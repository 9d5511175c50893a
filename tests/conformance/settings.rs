//! Frame, declination and the gyroscope's hold.

use ahrs_rs::{Frame, GyrHold, Quat, Settings};

use crate::bank::{ACC, BOTH, Reading, choices, run, scalars};
use crate::random::Random;
use crate::recording::{broken, distance, moving, quat};
use crate::start::rounding;

fn about_z(angle: f64) -> Quat<f64> {
    let (sin, cos) = (0.5 * angle).sin_cos();
    Quat::new(cos, 0.0, 0.0, sin)
}

#[test]
fn a_frame_rotates_the_output_and_nothing_else() {
    for case in scalars() {
        for params in choices(case.spec) {
            // Once inclination and heading are known: what the state holds knows of no frame then.
            let mut first = case.make(&params, Settings::default());
            run(first.as_mut(), &moving(21, 2), BOTH);
            let state = first.save(0);
            let rows = broken(21, 100);
            let run = |frame| {
                let mut bank = case.make(&params, Settings { frame, ..Settings::default() });
                bank.load(0, &state);
                run(bank.as_mut(), &rows, BOTH)
            };
            let enu = run(Frame::Enu);
            for (_, frame) in Frame::ALL {
                for (turned, enu) in run(frame).iter().zip(&enu) {
                    let expected = frame.from_enu::<f64>() * quat(enu.quat);
                    // One product in the scalar, with √½ rounded to it.
                    let error = distance(quat(turned.quat), expected);
                    assert!(error <= 4.0 * case.epsilon, "{} {params:?} {frame:?}: {error:e}", case.name());
                    assert_eq!((turned.status, turned.gyr_bias), (enu.status, enu.gyr_bias), "{}", case.name());
                    assert_eq!(turned.output_bits(), enu.output_bits(), "{}", case.name());
                }
            }
        }
    }
}

#[test]
fn with_a_field_the_start_is_the_same_in_all_frames() {
    for case in scalars() {
        for params in choices(case.spec) {
            for seed in 0..20 {
                let start = |frame| {
                    let mut bank = case.make(&params, Settings { frame, ..Settings::default() });
                    quat(run(bank.as_mut(), &moving(30 + seed, 1), BOTH)[0].quat)
                };
                let enu = start(Frame::Enu);
                for (_, frame) in Frame::ALL {
                    let error = distance(start(frame), frame.from_enu::<f64>() * enu);
                    // Two shortest rotations and the turn to the field, from another pose: alignment rounds by 80 epsilon.
                    assert!(error <= 160.0 * case.epsilon, "{} {params:?} {frame:?}: {error:e}", case.name());
                }
            }
        }
    }
}

#[test]
fn without_a_field_frames_differ_by_a_turn_about_the_vertical() {
    for case in scalars() {
        for params in choices(case.spec) {
            let rows = moving(22, 50);
            let run = |frame| {
                let mut bank = case.make(&params, Settings { frame, ..Settings::default() });
                run(bank.as_mut(), &rows, ACC)
            };
            let enu = run(Frame::Enu);
            for (_, frame) in Frame::ALL {
                let turns: Vec<_> = run(frame)
                    .iter()
                    .zip(&enu)
                    .map(|(turned, enu)| frame.from_enu::<f64>().conj() * quat(turned.quat) * quat(enu.quat).conj())
                    .collect();
                for turn in &turns {
                    let leaning = turn.x.hypot(turn.y);
                    let error = leaning.max(distance(*turn, turns[0]));
                    // Of an unknown heading a covariance is up to 1e4 times that of a measurement, and so is the gain by which
                    // rounding comes back.
                    let bound = if case.has_covariance { 1e4 * case.epsilon } else { rounding(&case) };
                    assert!(error <= bound, "{} {params:?} {frame:?}: {error:e}", case.name());
                }
            }
        }
    }
}

#[test]
fn declination_turns_from_magnetic_to_true_north() {
    let declination = 0.3;
    for case in scalars() {
        for params in choices(case.spec) {
            for (_, frame) in Frame::ALL {
                let run = |declination| {
                    let settings = Settings { frame, declination, ..Settings::default() };
                    run(case.make(&params, settings).as_mut(), &moving(22, 100), BOTH)
                };
                // Positive east: about an axis that points up the frame turns by −D, in north-east-down by +D.
                let turn = about_z(if frame == Frame::Ned { declination } else { -declination });
                for (geographic, magnetic) in run(declination).iter().zip(run(0.0)) {
                    // Two products in the scalar, and the rounding of the turn itself.
                    let error = distance(quat(geographic.quat), turn * quat(magnetic.quat));
                    assert!(error <= 10.0 * case.epsilon, "{} {params:?} {frame:?}: {error:e}", case.name());
                    assert_eq!(geographic.gyr_bias, magnetic.gyr_bias, "{}", case.name());
                }
            }
        }
    }
}

#[test]
fn declination_has_no_meaning_without_a_magnetometer() {
    for case in scalars() {
        for params in choices(case.spec) {
            for (_, frame) in Frame::ALL {
                let run = |declination| {
                    let settings = Settings { frame, declination, ..Settings::default() };
                    let mut bank = case.make(&params, settings);
                    bank.start_from(&[Random(23).rotation()]);
                    let readings = run(bank.as_mut(), &broken(24, 60), ACC);
                    readings.into_iter().map(|reading| reading.quat).collect::<Vec<_>>()
                };
                assert_eq!(run(0.3), run(0.0), "{} {params:?}", case.name());
            }
        }
    }
}

#[test]
fn an_attitude_from_true_north_is_turned_to_magnetic_north_and_back() {
    // With the declination D a start from q0 is one without it from Rz(D) q0, seen from Rz(−D).
    let declination = 0.3;
    for case in scalars() {
        for params in choices(case.spec) {
            let q0 = quat(Random(25).rotation());
            let run = |declination, q0: Quat<f64>| {
                let settings = Settings { declination, ..Settings::default() };
                let mut bank = case.make(&params, settings);
                bank.start_from(&[[q0.w, q0.x, q0.y, q0.z]]);
                run(bank.as_mut(), &moving(26, 50), BOTH)
            };
            let geographic = run(declination, q0);
            for (geographic, magnetic) in geographic.iter().zip(run(0.0, about_z(declination) * q0)) {
                let error = distance(quat(geographic.quat), about_z(-declination) * quat(magnetic.quat));
                // The two starts differ by rounding, and 50 steps keep the difference: products of 4 epsilon each,
                // and at most twice as much where a normalised gradient leans on it.
                assert!(error <= 400.0 * case.epsilon, "{} {params:?}: {error:e}", case.name());
            }
        }
    }
}

#[test]
fn a_linear_hold_is_a_zero_order_hold_of_the_means() {
    for case in scalars() {
        for params in choices(case.spec) {
            // Rates with few bits, so that their means are exact.
            let mut rows = moving(27, 60);
            for row in &mut rows {
                row.gyr = row.gyr.map(|c| (c * 64.0).round() / 64.0);
            }
            let run = |gyr_hold, rows: &[_]| {
                let settings = Settings { gyr_hold, ..Settings::default() };
                let readings = run(case.make(&params, settings).as_mut(), rows, BOTH);
                readings.iter().map(Reading::bits).collect::<Vec<_>>()
            };
            let linear = run(GyrHold::Linear, &rows);
            let ends: Vec<_> = rows.iter().map(|row| row.gyr).collect();
            for (row, pair) in rows[1..].iter_mut().zip(ends.windows(2)) {
                row.gyr = [0, 1, 2].map(|k| 0.5 * (pair[0][k] + pair[1][k]));
            }
            assert_eq!(linear, run(GyrHold::ZeroOrder, &rows), "{} {params:?}", case.name());
        }
    }
}
