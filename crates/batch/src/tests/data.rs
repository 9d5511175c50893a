//! Recordings in arrays, and room for their results.

use ahrs_rs::params::{ParamKind, ParamSpec};
use ahrs_rs::{FilterSpec, Settings};
use ndarray::{Array1, Array2, s};

use super::random::Random;
use crate::recording::{Outputs, Recording, Time};
use crate::registry::{Entry, Number};
use crate::threads::{Job, Plan, Watch, run_all};
use ahrs_rs_lanes::simd::Isa;

/// The arrays of a recording.
pub struct Data<T> {
    pub gyr: Array2<T>,
    pub acc: Option<Array2<T>>,
    pub mag: Option<Array2<T>>,
    pub t: Option<Array1<f64>>,
}

/// What a run gave, in bits.
#[derive(Debug, PartialEq)]
pub struct Bits {
    pub quat: Vec<u64>,
    pub gyr_bias: Vec<u64>,
    pub status: Vec<u16>,
    pub state: Vec<u64>,
}

/// A sensor that turns about, with missing rows, gaps and rates that are too large. Every third recording has no
/// magnetometer, every fifth has stamps, every second stands with its columns in reverse in memory.
pub fn recording<T: Number>(seed: u64, samples: usize) -> Data<T> {
    let mut random = Random(seed);
    let rows = |mean: [f64; 3], noise: f64, random: &mut Random| {
        let missing = seed.is_multiple_of(4);
        let mut values = Array2::from_shape_fn((samples, 3), |(_, c)| T::from_f64(mean[c] + noise * random.normal()));
        for mut row in values.outer_iter_mut() {
            match random.below(if missing { 30 } else { 1_000_000 }) {
                0 => row[0] = T::NAN,
                1 => row.fill(T::zero()),
                2 => row[1] = T::from_f64(1e30),
                _ => (),
            }
        }
        if seed % 2 == 1 {
            values.invert_axis(ndarray::Axis(1));
        }
        values
    };
    let gyr = rows([0.2, -0.1, 0.3], 0.5, &mut random);
    let acc = rows([0.0, 0.5, 9.8], 0.5, &mut random);
    let mag = rows([1.0, 20.0, -40.0], 1.0, &mut random);
    let mut time = 0.0;
    let t = (0..samples).map(|_| {
        time += [0.0, 0.01, 0.0103, 0.5][random.below(4)];
        time
    });
    let t = seed.is_multiple_of(5).then(|| t.collect());
    Data { gyr, acc: Some(acc), mag: (!seed.is_multiple_of(3)).then_some(mag), t }
}

/// Recordings of lengths that fill lanes and tiles, and of such that do not.
pub fn recordings<T: Number>() -> Vec<Data<T>> {
    let lengths = [70, 300, 1, 0, 130, 64, 257, 65, 200, 63, 128, 2, 90, 91, 92, 93, 94, 95, 256, 150, 10];
    lengths.iter().enumerate().map(|(index, &samples)| recording(index as u64, samples)).collect()
}

/// Runs the filter over the recordings from where some of them have been before.
pub fn run<T: Number>(
    entry: &Entry,
    values: &[f64],
    data: &[Data<T>],
    isa: Option<Isa>,
    threads: Option<usize>,
) -> Vec<Bits> {
    let settings = Settings::default();
    let mut rooms: Vec<_> = data
        .iter()
        .map(|data| {
            let samples = data.gyr.nrows();
            let zeros = |columns| Array2::from_elem((samples, columns), T::zero());
            (zeros(4), zeros(3), Array1::from_elem(samples, 0_u16))
        })
        .collect();
    let mut jobs: Vec<_> = data
        .iter()
        .zip(&mut rooms)
        .enumerate()
        .map(|(index, (data, (quat, gyr_bias, status)))| {
            let mut stream = T::stream(entry, values, settings).unwrap();
            if index % 4 == 1 {
                stream.start_from(Random(index as u64).rotation().map(T::from_f64));
            }
            let time = Time { stamps: data.t.as_ref().map(|t| t.view()), first: 0.01, step: 0.01 };
            Job {
                stream,
                recording: Recording {
                    gyr: data.gyr.view(),
                    acc: data.acc.as_ref().map(|acc| acc.view()),
                    mag: data.mag.as_ref().map(|mag| mag.view()),
                    time,
                },
                outputs: Outputs {
                    quat: quat.view_mut(),
                    gyr_bias: entry.spec.gyr_bias.then(|| gyr_bias.view_mut()),
                    status: status.slice_mut(s![..]),
                    extra: Vec::new(),
                },
                infinite: false,
                panicked: None,
            }
        })
        .collect();
    let watch = Watch::default();
    run_all(&mut jobs, &Plan { entry, values, settings, isa, threads }, &watch);
    assert!(jobs.iter().all(|job| !job.infinite && job.panicked.is_none()));
    assert_eq!(watch.count(), data.len());
    let states: Vec<Vec<f64>> = jobs.iter_mut().map(|job| job.stream.save()).collect();
    drop(jobs);
    let bits = |values: &Array2<T>| values.iter().map(|value| value.to_f64().to_bits()).collect();
    rooms
        .iter()
        .zip(states)
        .map(|((quat, gyr_bias, status), state)| Bits {
            quat: bits(quat),
            gyr_bias: bits(gyr_bias),
            status: status.to_vec(),
            state: state.into_iter().map(f64::to_bits).collect(),
        })
        .collect()
}

/// The defaults, and each other value of a choice or switch alone.
pub fn choices(spec: &FilterSpec) -> Vec<Vec<f64>> {
    let defaults: Vec<_> = spec.params.iter().map(ParamSpec::default).collect();
    let mut sets = vec![defaults.clone()];
    for (index, param) in spec.params.iter().enumerate() {
        let others = match param.kind {
            ParamKind::Real { .. } => 0,
            ParamKind::Choice { options } => options.len() - 1,
            ParamKind::Switch { .. } => 1,
        };
        for step in 1..=others {
            let mut set = defaults.clone();
            set[index] = (defaults[index] - step as f64).abs();
            sets.push(set);
        }
    }
    sets
}
