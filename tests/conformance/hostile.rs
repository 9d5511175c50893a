//! No input makes a filter panic, poisons its state, or gives anything but a unit quaternion.

use ahrs_rs::{Frame, GyrHold, Repeated, Settings};
use proptest::prelude::*;
use proptest::sample::select;
use proptest::test_runner::RngSeed;

use crate::bank::{Row, Sensors, extremes, scalars};
use crate::norm::{NORM_BOUND, norm_error};

/// Numbers of every kind: any bits, the edges of the formats, and what sensors give.
fn number() -> impl Strategy<Value = f64> {
    let edges = [
        0.0,
        -0.0,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        f64::MIN_POSITIVE,
        5e-324,
        -1e-310,
        1.8e19, // squares to the largest f32
        -1.3e154,
        1.1e-19, // squares to the smallest normal f32
        1.5e-154,
        1e-6,
        1e6,
        1e30,
    ];
    prop_oneof![
        2 => any::<u64>().prop_map(f64::from_bits),
        3 => select(edges.to_vec()),
        2 => (-40.0..40.0_f64, any::<bool>()).prop_map(|(power, minus)| {
            if minus { -10.0_f64.powf(power) } else { 10.0_f64.powf(power) }
        }),
        5 => -20.0..20.0_f64,
    ]
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    prop_oneof![
        3 => [number(), number(), number()],
        // Along an axis, where angles have their poles.
        1 => (0..3_usize, number()).prop_map(|(axis, value)| {
            let mut v = [0.0; 3];
            v[axis] = value;
            v
        }),
        3 => [-10.0..10.0_f64, -10.0..10.0, -10.0..10.0],
    ]
}

fn sample() -> impl Strategy<Value = (Row, Sensors)> {
    let dt = prop_oneof![3 => number(), 2 => Just(0.01), 1 => 0.0..1e7_f64];
    let sensors = (any::<bool>(), any::<bool>()).prop_map(|(acc, mag)| Sensors { acc, mag });
    (vector(), vector(), vector(), dt, sensors)
        .prop_map(|(gyr, acc, mag, dt, sensors)| (Row { gyr, acc, mag, dt }, sensors))
}

fn any_settings() -> impl Strategy<Value = Settings> {
    let frame = select(Frame::ALL.to_vec()).prop_map(|(_, frame)| frame);
    let hold = select(GyrHold::ALL.to_vec()).prop_map(|(_, hold)| hold);
    // The declination is checked where it comes in; any angle is one.
    let repeated = select(Repeated::ALL.to_vec()).prop_map(|(_, rule)| rule);
    let range = prop_oneof![Just(0.0), 0.1..40.0_f64];
    (frame, prop_oneof![Just(0.0), -7.0..7.0_f64], hold, repeated, range).prop_map(
        |(frame, declination, gyr_hold, repeated, gyr_range)| Settings {
            frame,
            declination,
            gyr_hold,
            repeated,
            gyr_range,
        },
    )
}

proptest! {
    // The same examples every time, so that no change is blamed for what was there before.
    #![proptest_config(ProptestConfig {
        cases: 300,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn no_input_poisons_a_filter(
        samples in prop::collection::vec(sample(), 1..24),
        q0 in prop::option::of([number(), number(), number(), number()]),
        settings in any_settings(),
    ) {
        for case in scalars() {
            for params in extremes(case.spec) {
                let mut bank = case.make(&params, settings);
                if let Some(q0) = q0 {
                    bank.start_from(&[q0]);
                }
                for (k, (row, sensors)) in samples.iter().enumerate() {
                    bank.step(&[*row], *sensors);
                    let reading = bank.read(0);
                    let what = || format!("{} {params:?}, sample {k}: {reading:?}", case.name());
                    let error = norm_error(reading.quat) / case.epsilon;
                    prop_assert!(error <= NORM_BOUND, "{}, norm off by {error} epsilon", what());
                    prop_assert!(reading.gyr_bias.iter().all(|value| value.is_finite()), "{}", what());
                    // NaN is the innovation of a measurement that is missing.
                    prop_assert!(!reading.outputs.iter().any(|value| value.is_infinite()), "{}", what());
                    prop_assert!(bank.save(0).iter().all(|value| value.is_finite()), "{}: {:?}", what(), bank.save(0));
                }
            }
        }
    }
}
