//! The errors of a sweep are those of runs.

use ahrs_rs::params::ParamKind;
use ahrs_rs::{FilterSpec, Quat, Settings};

use super::data::{Data, recording, run};
use super::random::Random;
use crate::isa;
use crate::recording::{Recording, Time};
use crate::registry::{ENTRIES, Number};
use crate::sweep::{Sweep, Trial, sweep};
use crate::threads::Watch;
use ahrs_rs_lanes::metric::Metric;

/// More sets than any bank has lanes, numbers between the default and a neighbour, choices in turn.
fn sets(spec: &FilterSpec) -> Vec<Vec<f64>> {
    let mut random = Random(3);
    (0..40)
        .map(|_| {
            let value = |kind: &ParamKind, random: &mut Random| match *kind {
                ParamKind::Real { default, min, max, .. } => (default * random.uniform(0.5, 1.0)).clamp(min, max),
                ParamKind::Choice { options } => random.below(options.len()) as f64,
                ParamKind::Switch { .. } => random.below(2) as f64,
            };
            spec.params.iter().map(|param| value(&param.kind, &mut random)).collect()
        })
        .collect()
}

/// The truth at each sample that counts.
type Truth<T> = Vec<Option<[T; 4]>>;

/// Recordings of one start, and truth that does not count everywhere.
fn trials<T: Number>() -> Vec<(Data<T>, Truth<T>)> {
    let mut random = Random(8);
    // Without an attitude that is given: those of another index than 1 modulo 4.
    [(8, 300), (12, 64)]
        .map(|(seed, samples)| {
            let mut counts = || !random.chance(0.3);
            let mut rotations = Random(seed);
            let truth = (0..samples).map(|_| counts().then(|| rotations.rotation().map(T::from_f64))).collect();
            (recording(seed, samples), truth)
        })
        .into()
}

fn angle(metric: Metric, q: [f64; 4], truth: [f64; 4]) -> f64 {
    let quat = |[w, x, y, z]: [f64; 4]| Quat { w, x, y, z };
    let e = quat(q) * quat(truth).conj();
    2.0 * match metric {
        Metric::Total => e.x.hypot(e.y).hypot(e.z).atan2(e.w.abs()),
        Metric::Heading => e.z.abs().atan2(e.w.abs()),
        Metric::Inclination => e.x.hypot(e.y).atan2(e.w.hypot(e.z)),
    }
}

fn errors_are_those_of_runs<T: Number>(tolerance: f64) {
    let trials = trials::<T>();
    let views: Vec<_> = trials
        .iter()
        .map(|(data, reference)| Trial {
            recording: Recording {
                gyr: data.gyr.view(),
                acc: data.acc.as_ref().map(|acc| acc.view()),
                mag: data.mag.as_ref().map(|mag| mag.view()),
                time: Time { stamps: data.t.as_ref().map(|t| t.view()), first: 0.01, step: 0.01 },
            },
            reference,
        })
        .collect();
    for entry in ENTRIES.iter() {
        let sets = sets(entry.spec);
        for (_, metric) in Metric::ALL {
            let plan = |isa| Sweep { entry, sets: &sets, settings: Settings::default(), metric, isa, threads: Some(2) };
            let alone = sweep(&plan(None), &views, &Watch::default()).unwrap();
            for isa in isa::available() {
                let watch = Watch::default();
                let beside = sweep(&plan(Some(isa)), &views, &watch).unwrap();
                assert_eq!(watch.count(), sets.len() * trials.len());
                assert_eq!(beside, alone, "{} {metric:?} {isa:?}", entry.spec.name);
            }
            for (index, values) in sets.iter().enumerate().take(3) {
                for (trial, (data, reference)) in trials.iter().enumerate() {
                    let data = std::slice::from_ref(data);
                    let bits = &run(entry, values, data, None, Some(1))[0];
                    let quats: Vec<f64> = bits.quat.iter().copied().map(f64::from_bits).collect();
                    let counted = quats.as_chunks::<4>().0.iter().zip(reference);
                    let squares: Vec<f64> = counted
                        .filter_map(|(q, truth)| {
                            Some(angle(metric, *q, truth.map(|truth| truth.map(T::to_f64))?).powi(2))
                        })
                        .collect();
                    let expected = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
                    let found = alone[index * trials.len() + trial].unwrap();
                    let off = (found - expected).abs();
                    assert!(off < tolerance, "{} {metric:?}: {found} for {expected}", entry.spec.name);
                }
            }
        }
    }
}

/// Rounding of 1e-16 in each of some operations, in rad.
#[test]
fn the_errors_of_a_sweep_in_f64_are_those_of_runs() {
    errors_are_those_of_runs::<f64>(1e-13);
}

/// Rounding of 6e-8 in each of some operations, in rad: the truth is rounded too.
#[test]
fn the_errors_of_a_sweep_in_f32_are_those_of_runs() {
    errors_are_those_of_runs::<f32>(1e-5);
}

#[test]
fn a_sweep_that_is_stopped_says_what_is_not_done() {
    let trials = trials::<f64>();
    let (data, reference) = &trials[0];
    let time = Time { stamps: None, first: 0.01, step: 0.01 };
    let recording = Recording { gyr: data.gyr.view(), acc: None, mag: None, time };
    let entry = &ENTRIES[0];
    let sets = sets(entry.spec);
    let watch = Watch::default();
    watch.stop();
    let plan = Sweep {
        entry,
        sets: &sets,
        settings: Settings::default(),
        metric: Metric::Total,
        isa: isa::available().last().copied(),
        threads: None,
    };
    let errors = sweep(&plan, &[Trial { recording, reference }], &watch).unwrap();
    assert_eq!(errors, vec![None; sets.len()]);
    assert_eq!(watch.count(), 0);
}

#[test]
fn a_sweep_over_a_value_that_is_not_allowed_is_refused() {
    let entry = crate::registry::entry("Madgwick").unwrap();
    let sets = [vec![0.1], vec![-1.0]];
    let plan = Sweep {
        entry,
        sets: &sets,
        settings: Settings::default(),
        metric: Metric::Total,
        isa: isa::available().last().copied(),
        threads: None,
    };
    assert!(sweep::<f64>(&plan, &[], &Watch::default()).is_err());
}
