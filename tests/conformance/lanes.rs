//! Lanes have the bits of the scalar.

use ahrs_rs::Settings;

use crate::bank::{ACC, BOTH, Bank, Case, NONE, Row, Sensors, cases, choices, scalars, settings};
use crate::random::Random;
use crate::recording::broken;

/// A scalar filter in one of the states in which a lane may be: untouched, started from an attitude, without
/// alignment, or under way.
fn at_some_stage(scalar: &Case, params: &[f64], settings: Settings, seed: u64) -> Box<dyn Bank> {
    let mut random = Random(seed);
    let mut bank = scalar.make(params, settings);
    match seed % 4 {
        0 => {}
        1 => bank.start_from(&[random.rotation()]),
        2 => {
            for row in broken(seed, 5) {
                bank.step(&[Row { acc: [f64::NAN; 3], ..row }], BOTH);
            }
        }
        _ => {
            for row in broken(seed, 9) {
                bank.step(&[row], [NONE, ACC, BOTH][random.below(3)]);
            }
        }
    }
    bank
}

/// Runs a recording of its own in each lane and the same in scalar filters beside it.
fn assert_lanes_equal_scalars(case: &Case, scalar: &Case, params: &[f64], settings: Settings, sensors: Sensors) {
    let mut lanes = case.make(params, settings);
    let mut alone: Vec<_> = (0..case.lanes as u64).map(|lane| at_some_stage(scalar, params, settings, lane)).collect();
    for (lane, alone) in alone.iter_mut().enumerate() {
        lanes.load(lane, &alone.save(0));
    }
    let recordings: Vec<_> = (0..case.lanes as u64).map(|lane| broken(100 + lane, 80)).collect();
    for k in 0..80 {
        let rows: Vec<_> = recordings.iter().map(|recording| recording[k]).collect();
        lanes.step(&rows, sensors);
        for (lane, alone) in alone.iter_mut().enumerate() {
            alone.step(&[rows[lane]], sensors);
            let (beside, alone) = (lanes.read(lane), alone.read(0));
            let what = || format!("{} {params:?} {settings:?}, lane {lane}, sample {k}", case.name());
            assert_eq!(beside.bits(), alone.bits(), "{}: {beside:?} is not {alone:?}", what());
        }
    }
    for (lane, alone) in alone.iter_mut().enumerate() {
        let bits = |variables: Vec<f64>| variables.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        assert_eq!(bits(lanes.save(lane)), bits(alone.save(0)), "{}, lane {lane}", case.name());
    }
}

fn scalar_of(case: &Case) -> Case {
    scalars().into_iter().find(|other| other.spec.name == case.spec.name && other.real == case.real).unwrap()
}

#[test]
fn lanes_equal_scalars_bit_for_bit() {
    let lanes: Vec<_> = cases().into_iter().filter(|case| case.lanes > 1).collect();
    assert!(lanes.len() >= 3);
    for case in lanes {
        let scalar = scalar_of(&case);
        for params in choices(case.spec) {
            for sensors in [BOTH, ACC] {
                assert_lanes_equal_scalars(&case, &scalar, &params, Settings::default(), sensors);
            }
        }
    }
}

#[test]
fn lanes_equal_scalars_in_every_frame_and_hold() {
    for case in cases().into_iter().filter(|case| case.lanes == 4) {
        let scalar = scalar_of(&case);
        for settings in settings() {
            assert_lanes_equal_scalars(&case, &scalar, &[], settings, BOTH);
        }
    }
}

#[test]
fn all_lanes_can_start_from_attitudes_of_their_own() {
    for case in cases() {
        let mut random = Random(5);
        let scalar = scalar_of(&case);
        let starts: Vec<_> = (0..case.lanes).map(|_| random.rotation()).collect();
        let mut lanes = case.make(&[], Settings::default());
        lanes.start_from(&starts);
        for (lane, q0) in starts.iter().enumerate() {
            let mut alone = scalar.make(&[], Settings::default());
            alone.start_from(&[*q0]);
            let bits = |variables: Vec<f64>| variables.into_iter().map(f64::to_bits).collect::<Vec<_>>();
            assert_eq!(bits(lanes.save(lane)), bits(alone.save(0)), "{}, lane {lane}", case.name());
        }
    }
}
