//! Rows that are no measurement, and sensors that are not there.

use ahrs_rs::so3::rotate_by;
use ahrs_rs::{GyrHold, Settings, Vec3};

use crate::bank::{ACC, BOTH, NONE, Reading, Row, choices, run, scalars};
use crate::recording::{NO_MEASUREMENT, NO_RATE, array, distance, moving, quat};

pub const ACC_MISSING: u16 = 1;
pub const MAG_MISSING: u16 = 2;
pub const GYR_HELD: u16 = 4;
pub const NOT_ALIGNED: u16 = 64;

/// The largest difference of a quaternion's component by what four rows without a rate hide.
const HIDDEN: f64 = 0.01;

const NAN3: [f64; 3] = [f64::NAN; 3];

fn all_bits(readings: &[Reading]) -> Vec<Vec<u64>> {
    readings.iter().map(Reading::bits).collect()
}

/// The readings with the bit of a held gyroscope taken off.
fn without_held(readings: &[Reading]) -> Vec<Vec<u64>> {
    let unheld = |reading: &Reading| Reading { status: reading.status & !GYR_HELD, ..reading.clone() }.bits();
    readings.iter().map(unheld).collect()
}

#[test]
fn every_form_of_no_measurement_is_one_and_the_status_says_so() {
    for case in scalars() {
        for params in choices(case.spec) {
            let run = |edit: &dyn Fn(&mut Row)| {
                let mut rows = moving(3, 30);
                rows[10..13].iter_mut().for_each(edit);
                run(case.make(&params, Settings::default()).as_mut(), &rows, BOTH)
            };
            let (acc, mag) = (run(&|row| row.acc = NAN3), run(&|row| row.mag = NAN3));
            for k in 0..30 {
                let missing = (10..13).contains(&k);
                assert_eq!(acc[k].status, if missing { ACC_MISSING } else { 0 }, "{}, sample {k}", case.name());
                assert_eq!(mag[k].status, if missing { MAG_MISSING } else { 0 }, "{}, sample {k}", case.name());
            }
            for none in NO_MEASUREMENT {
                assert_eq!(all_bits(&run(&|row| row.acc = none)), all_bits(&acc), "{} acc {none:?}", case.name());
                assert_eq!(all_bits(&run(&|row| row.mag = none)), all_bits(&mag), "{} mag {none:?}", case.name());
            }
        }
    }
}

#[test]
fn a_sensor_that_was_never_there_is_not_missing() {
    for case in scalars() {
        let rows = moving(4, 3);
        let mut bank = case.make(&[], Settings::default());
        let mut status = |row: &Row, sensors| {
            bank.step(&[*row], sensors);
            bank.read(0).status
        };
        assert_eq!(status(&rows[0], NONE), NOT_ALIGNED, "{}", case.name());
        assert_eq!(status(&rows[1], ACC), 0, "{}", case.name());
        // From the first time that it was given, it is.
        assert_eq!(status(&rows[1], BOTH), 0, "{}", case.name());
        assert_eq!(status(&rows[2], ACC), MAG_MISSING, "{}", case.name());
        assert_eq!(status(&rows[2], NONE), ACC_MISSING | MAG_MISSING, "{}", case.name());
    }
}

#[test]
fn a_sensor_that_is_not_there_is_one_without_measurements() {
    for case in scalars() {
        for params in choices(case.spec) {
            let mut rows = moving(5, 40);
            let absent = run(case.make(&params, Settings::default()).as_mut(), &rows, ACC);
            for row in &mut rows {
                row.mag = NAN3;
            }
            let missing = run(case.make(&params, Settings::default()).as_mut(), &rows, BOTH);
            for (absent, missing) in absent.iter().zip(&missing) {
                let missing = Reading { status: missing.status & !MAG_MISSING, ..missing.clone() };
                assert_eq!(absent.bits(), missing.bits(), "{} {params:?}", case.name());
            }
        }
    }
}

#[test]
fn a_rate_that_is_missing_or_too_large_holds_the_last_one() {
    // 1e9 rad/s over 10 ms is beyond the range of both sin_cos: 1e6 and 4096 rad of half angle.
    let too_large = [[0.0, 1e9, 0.0], [-1e9, 1.0, 1e9]];
    for case in scalars() {
        for params in choices(case.spec) {
            for (_, gyr_hold) in GyrHold::ALL {
                let settings = Settings { gyr_hold, ..Settings::default() };
                for gap in [10..13, 0..4] {
                    let run = |rate: &dyn Fn(&[Row]) -> [f64; 3]| {
                        let mut rows = moving(6, 30);
                        let rate = rate(&rows);
                        rows[gap.clone()].iter_mut().for_each(|row| row.gyr = rate);
                        run(case.make(&params, settings).as_mut(), &rows, BOTH)
                    };
                    let held = run(&|rows| if gap.start > 0 { rows[gap.start - 1].gyr } else { [0.0; 3] });
                    // A first sample turns by nothing, so that there no finite rate is too large.
                    let unusable = if gap.start > 0 { too_large.as_slice() } else { &[] };
                    let nan = run(&|_| [f64::NAN; 3]);
                    // Three rows may hide a quarter of a degree, which only a filter with a covariance takes note of.
                    let expected = if case.has_covariance { &nan } else { &held };
                    for rate in NO_RATE.iter().chain(unusable) {
                        let missing = run(&|_| *rate);
                        let what = format!("{} {params:?} {gyr_hold:?}, {rate:?} over {gap:?}", case.name());
                        for (k, reading) in missing.iter().enumerate() {
                            assert_eq!(reading.status, if gap.contains(&k) { GYR_HELD } else { 0 }, "{what}, at {k}");
                        }
                        assert_eq!(without_held(&missing), without_held(expected), "{what}");
                        let last = [&missing, &held].map(|readings| quat(readings[gap.end - 1].quat));
                        // Before the first rate there is none to hold.
                        let hidden = distance(last[0], last[1]);
                        assert!(gap.start == 0 || hidden < HIDDEN, "{what}: {hidden}");
                    }
                }
            }
        }
    }
}

#[test]
fn time_advances_where_everything_is_missing() {
    for case in scalars() {
        for params in choices(case.spec) {
            let mut bank = case.make(&params, Settings::default());
            bank.start_from(&[[1.0, 0.0, 0.0, 0.0]]);
            // Two seconds at half a radian a second about the vertical; the rate itself comes only now and then.
            let row = Row { gyr: [0.0, 0.0, 0.5], acc: NAN3, mag: NAN3, dt: 0.01 };
            let rows: Vec<_> = (0..200).map(|k| if k % 7 == 0 { row } else { Row { gyr: NAN3, ..row } }).collect();
            let last = run(bank.as_mut(), &rows, BOTH).pop().unwrap();
            let yaw = 2.0 * last.quat[3].atan2(last.quat[0]);
            // First-order steps turn by less: 2·(h − atan h) with h = 0.0025, 200 times, is 2.1e-6; f32 rounds by half
            // an epsilon in each of its 200 steps, some 1.2e-5. Where the rate is a state, of variance 1 at the start and
            // measured with 3e-5, it begins short by that share of itself: 0.5·3e-5·2 s.
            assert!((yaw - 1.0).abs() < 5e-5, "{} {params:?}: {yaw}", case.name());
        }
    }
}

#[test]
fn the_first_valid_acceleration_aligns_at_once_and_keeps_the_heading() {
    for case in scalars() {
        for params in choices(case.spec) {
            let mut rows = moving(7, 10);
            rows[..5].iter_mut().for_each(|row| row.acc = NO_MEASUREMENT[2]);
            let readings = run(case.make(&params, Settings::default()).as_mut(), &rows, ACC);
            for (k, reading) in readings.iter().enumerate() {
                let expected = if k < 5 { ACC_MISSING | NOT_ALIGNED } else { 0 };
                assert_eq!(reading.status, expected, "{}, sample {k}", case.name());
            }
            // From the identity, where the first sample is a step like any other from one step before it.
            let turn = rotate_by(quat(readings[0].quat).conj(), Vec3::of(rows[0].gyr), rows[0].dt);
            if case.starts_itself {
                assert!(turn.vector().norm2().sqrt() <= 4.0 * case.epsilon, "{}: {turn:?}", case.name());
            } else {
                assert_eq!(readings[0].quat, [1.0, 0.0, 0.0, 0.0], "{}", case.name());
            }

            let up = array(quat(readings[5].quat).rotate(Vec3::of(rows[5].acc)));
            let length = up.iter().map(|c| c * c).sum::<f64>().sqrt();
            // Shortest rotation, product, and Euler angles where the filter keeps those: some 20 epsilon.
            let error = up[0].hypot(up[1]) / length;
            assert!(error <= 32.0 * case.epsilon, "{} {params:?}: {error:e}", case.name());

            // What it would be without: from there the turn is about a horizontal axis.
            rows[5].acc = NAN3;
            let before = run(case.make(&params, Settings::default()).as_mut(), &rows, ACC)[5].quat;
            let turn = quat(readings[5].quat) * quat(before).conj();
            assert!(turn.z.abs() <= 32.0 * case.epsilon, "{} {params:?}: {turn:?}", case.name());
        }
    }
}

#[test]
fn the_first_valid_field_sets_the_heading_at_once() {
    for case in scalars() {
        for params in choices(case.spec) {
            for (first_acc, first_mag) in [(0, 0), (0, 6), (6, 0), (4, 6), (6, 6)] {
                let mut rows = moving(8, 10);
                rows[..first_acc].iter_mut().for_each(|row| row.acc = NAN3);
                rows[..first_mag].iter_mut().for_each(|row| row.mag = NAN3);
                let readings = run(case.make(&params, Settings::default()).as_mut(), &rows, BOTH);
                let k = first_acc.max(first_mag);
                let north = array(quat(readings[k].quat).rotate(Vec3::of(rows[k].mag)));
                // The horizontal part is 0.4 of the field, so an error of the attitude counts 2.5 times: 32 as above.
                let error = north[0].atan2(north[1]).abs();
                assert!(error <= 80.0 * case.epsilon, "{} {params:?}, sample {k}: {error:e}", case.name());
            }
        }
    }
}

#[test]
fn a_vertical_field_gives_no_heading_and_the_next_one_does() {
    for case in scalars() {
        for params in choices(case.spec) {
            let row = Row { gyr: [0.0; 3], acc: [0.0, 0.0, 9.8], mag: [1e-6, 2e-6, -45.0], dt: 0.01 };
            let rows = [row, row, Row { mag: [20.0, 0.0, -45.0], ..row }];
            let readings = run(case.make(&params, Settings::default()).as_mut(), &rows, BOTH);
            assert_eq!(readings[1].quat, [1.0, 0.0, 0.0, 0.0], "{} {params:?}", case.name());
            assert_eq!(readings[1].status, 0, "the field was measured");
            let half = std::f64::consts::FRAC_1_SQRT_2;
            for (value, expected) in readings[2].quat.iter().zip([half, 0.0, 0.0, half]) {
                // A quarter turn, by way of Euler angles at most.
                assert!((value - expected).abs() <= 8.0 * case.epsilon, "{} {params:?}", case.name());
            }
        }
    }
}
