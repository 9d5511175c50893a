//! What `each_variable` shows is all that the next step depends on.

use ahrs_rs::Settings;

use crate::bank::{ACC, BOTH, Bank, Case, Row, Sensors, cases, choices, scalars, settings};
use crate::random::Random;
use crate::recording::broken;

const SAMPLES: usize = 40;

/// The rows of sample `k`, one for each lane.
fn rows(recordings: &[Vec<Row>], k: usize) -> Vec<Row> {
    recordings.iter().map(|recording| recording[k]).collect()
}

/// A run that is cut at a sample and goes on in a fresh estimator, and again some samples later.
fn assert_a_cut_changes_nothing(case: &Case, params: &[f64], settings: Settings, sensors: Sensors, q0: bool) {
    let recordings: Vec<_> = (0..case.lanes as u64).map(|lane| broken(200 + lane, SAMPLES)).collect();
    let mut random = Random(6);
    let starts: Vec<_> = (0..case.lanes).map(|_| random.rotation()).collect();
    for cut in [0, 1, 2, 11, 27] {
        let start = || {
            let mut bank = case.make(params, settings);
            if q0 {
                bank.start_from(&starts);
            }
            bank
        };
        let (mut whole, mut part) = (start(), start());
        for k in 0..SAMPLES {
            if k == cut || k == cut + 3 {
                part = copy(case, part, params, settings);
            }
            whole.step(&rows(&recordings, k), sensors);
            part.step(&rows(&recordings, k), sensors);
            for lane in 0..case.lanes {
                let (whole, part) = (whole.read(lane), part.read(lane));
                let what = format!("{} {params:?} {settings:?}, cut at {cut}, sample {k}", case.name());
                assert_eq!(whole.bits(), part.bits(), "{what}: {whole:?} is not {part:?}");
            }
        }
    }
}

/// A fresh bank with the variables of another.
fn copy(case: &Case, mut from: Box<dyn Bank>, params: &[f64], settings: Settings) -> Box<dyn Bank> {
    let mut fresh = case.make(params, settings);
    for lane in 0..case.lanes {
        fresh.load(lane, &from.save(lane));
    }
    fresh
}

#[test]
fn a_run_that_goes_on_from_a_snapshot_equals_the_whole_bit_for_bit() {
    for case in cases() {
        for params in choices(case.spec) {
            for q0 in [false, true] {
                assert_a_cut_changes_nothing(&case, &params, Settings::default(), BOTH, q0);
            }
        }
    }
}

#[test]
fn a_snapshot_holds_what_every_frame_and_hold_needs() {
    for case in scalars() {
        for settings in settings() {
            for sensors in [BOTH, ACC] {
                assert_a_cut_changes_nothing(&case, &[], settings, sensors, false);
                assert_a_cut_changes_nothing(&case, &[], settings, sensors, true);
            }
        }
    }
}

#[test]
fn reading_a_snapshot_changes_nothing() {
    for case in cases() {
        let mut bank = case.make(&[], Settings::default());
        let recordings: Vec<_> = (0..case.lanes as u64).map(|lane| broken(lane, SAMPLES)).collect();
        for k in 0..SAMPLES {
            bank.step(&rows(&recordings, k), BOTH);
            for lane in 0..case.lanes {
                let bits = |variables: Vec<f64>| variables.into_iter().map(f64::to_bits).collect::<Vec<_>>();
                let first = bits(bank.save(lane));
                assert_eq!(first, bits(bank.save(lane)), "{}", case.name());
            }
        }
    }
}
