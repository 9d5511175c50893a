//! What a filter's description claims of it, beside the law of `equivariance.rs`.

use ahrs_rs::filter::Magnetometer;
use ahrs_rs::so3::rotate_by;
use ahrs_rs::{Settings, Vec3};

use crate::bank::{ACC, BOTH, choices, doubles, extremes, run, scalars};
use crate::random::Random;
use crate::recording::{moving, quat, still};
use crate::start::{angle, array};

#[test]
fn filters_without_a_magnetometer_use_it_for_the_first_heading_only() {
    for case in scalars() {
        for params in choices(case.spec) {
            let mut rows = moving(9, 60);
            let given = run(case.make(&params, Settings::default()).as_mut(), &rows, BOTH);
            for row in &mut rows[1..] {
                row.mag = [f64::NAN; 3];
            }
            let first_only = run(case.make(&params, Settings::default()).as_mut(), &rows, BOTH);
            let equal = given.iter().zip(&first_only).all(|(a, b)| a.quat == b.quat && a.gyr_bias == b.gyr_bias);
            let expected = case.spec.magnetometer == Magnetometer::InitialHeading;
            assert_eq!(equal, expected, "{} {params:?}: the magnetometer is used as described", case.name());
        }
    }
}

#[test]
fn a_bias_is_estimated_where_that_is_claimed() {
    for case in scalars() {
        // With some gain or other; without one the bias stays zero.
        let estimated = extremes(case.spec).iter().any(|params| {
            let readings = run(case.make(params, Settings::default()).as_mut(), &moving(10, 20), BOTH);
            readings.iter().any(|reading| reading.gyr_bias != [0.0; 3])
        });
        assert_eq!(estimated, case.spec.gyr_bias, "{}", case.name());
    }
}

#[test]
fn feedback_takes_a_wrong_start_to_the_truth() {
    // Five minutes: the slowest pole of the filters at their defaults, Mahony's heading with its integral, decays with
    // kp cos² dip / 2 = 0.08/s; Madgwick's needs 1.2 rad/2β = 15 s. What stays is a step of the latter, 2β dt = 8e-4.
    let feedback: Vec<_> = doubles().into_iter().filter(|case| case.spec.feedback).collect();
    assert!(!feedback.is_empty());
    for case in feedback {
        let mut random = Random(17);
        for _ in 0..3 {
            let q = quat(random.rotation());
            let wrong = rotate_by(q, Vec3::of(random.direction()), 1.2);
            let rows = still(q, 30_000);
            let mut bank = case.make(&[], Settings::default());
            bank.start_from(&[array(wrong)]);
            let last = run(bank.as_mut(), &rows, ACC).pop().unwrap();
            let up = Vec3::of([0.0, 0.0, 1.0]);
            let inclination = (quat(last.quat).conj().rotate(up) - q.conj().rotate(up)).norm2().sqrt();
            assert!(inclination < 2e-3, "{}: the inclination stays {inclination} rad off", case.name());

            if case.spec.magnetometer == Magnetometer::Feedback {
                let mut bank = case.make(&[], Settings::default());
                bank.start_from(&[array(wrong)]);
                let last = run(bank.as_mut(), &rows, BOTH).pop().unwrap();
                let error = angle(last.quat, array(q));
                assert!(error < 2e-3, "{}: stays {error} rad off", case.name());
            }
        }
    }
}
