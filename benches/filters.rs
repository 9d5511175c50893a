//! The cost of one step of every registered filter: `cargo bench`.
//!
//! One recording is computed step after step, so these are latencies: each step waits for the one before.

use std::hint::black_box;

use ahrs_rs::filter::Filter;
use ahrs_rs::params::ParamSet;
use ahrs_rs::{Estimator, Quat, Real, Settings, Vec3};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

/// Samples in a recording: few enough for the first-level cache.
const SAMPLES: usize = 256;

/// A sensor that turns slowly about a wandering axis.
fn recording<T: Real>() -> Vec<[Vec3<T>; 3]> {
    let mut q = Quat::<f64>::identity();
    (0..SAMPLES)
        .map(|k| {
            let phase = 0.1 * k as f64;
            let gyr = Vec3::new(0.5 * phase.sin(), 0.4 * phase.cos(), 0.3);
            q = ahrs_rs::so3::rotate_by(q, gyr, 0.01);
            let acc = q.conj().rotate(Vec3::new(0.3 * phase.sin(), 0.2 * phase.cos(), 9.8));
            let mag = q.conj().rotate(Vec3::new(0.0, 20.0, -43.0));
            [gyr, acc, mag].map(|v| Vec3::new(T::from_f64(v.x), T::from_f64(v.y), T::from_f64(v.z)))
        })
        .collect()
}

fn bench_filter<T: Real, F: Filter<T>>(criterion: &mut Criterion, scalar: &str) {
    let Ok(params) = F::Params::from_values(&[]) else { return };
    let samples = recording::<T>();
    let dt = T::from_f64(0.01);
    let mut group = criterion.benchmark_group(F::SPEC.name);
    group.throughput(Throughput::Elements(SAMPLES as u64));
    for (sensors, with_mag) in [("9D", true), ("6D", false)] {
        let mut estimator = Estimator::<T, F>::new(&params, Settings::default());
        group.bench_function(BenchmarkId::new(sensors, scalar), |bencher| {
            bencher.iter(|| {
                for &[gyr, acc, mag] in black_box(&samples) {
                    black_box(estimator.step(gyr, Some(acc), with_mag.then_some(mag), dt));
                }
            });
        });
    }
    group.finish();
}

macro_rules! benches {
    ($($filter:path),+) => {
        fn filters(criterion: &mut Criterion) {
            $({
                use $filter as F;
                bench_filter::<f64, F<f64>>(criterion, "f64");
                bench_filter::<f32, F<f32>>(criterion, "f32");
            })+
        }
    };
}
ahrs_rs::for_each_filter!(benches);

criterion_group!(registry, filters);
criterion_main!(registry);
