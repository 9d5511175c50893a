//! A simulated sensor with faults, and what the filter finds of them.

use ahrs_rs::filters::SelfCalKF;
use ahrs_rs::filters::selfcal::state::{DELAY, DISTURBANCE, HORIZONTAL, IRON, MATRIX, N, State, VELOCITY};
use ahrs_rs::params::ParamSet;
use ahrs_rs::so3::rotate_by;
use ahrs_rs::{Estimator, Filter, Quat, Real, Settings, Vec3};

use crate::params;
use crate::random::Random;

/// What is wrong with the simulated sensors.
#[derive(Clone, Copy, Default)]
struct Faults {
    bias: [f64; 3],
    matrix: [f64; 9],
    delay: f64,
    iron: [f64; 3],
    /// The gyroscope's range in rad/s; 0: without end.
    range: f64,
    /// What the filter is told of it.
    told: f64,
    /// From when to when in s another field is there, and what is added to the field (earth frame).
    magnet: (f64, f64, [f64; 3]),
}

/// How the simulated sensor turns, in rad/s.
trait Motion: FnMut(&mut Random, f64) -> [f64; 3] {}
impl<F: FnMut(&mut Random, f64) -> [f64; 3]> Motion for F {}

/// Three seconds of rest, then turns to and fro, each angle bounded.
fn swinging(seed: u64) -> impl Motion {
    let phase = Random(seed + 1000).normal3();
    move |_, time| {
        if time < 3.0 {
            return [0.0; 3];
        }
        [2.5 * (0.9 * time + phase[0]).sin(), 3.0 * (0.7 * time + phase[1]).cos(), 2.0 * (0.5 * time + phase[2]).sin()]
    }
}

/// Three seconds of rest, then a tumble whose axis changes every second: no error of the gyroscope turns back by itself.
fn tumbling() -> impl Motion {
    let (mut from, mut to, mut start) = ([0.0; 3], [0.0; 3], 3.0);
    move |random: &mut Random, time: f64| {
        if time >= start {
            (from, to, start) = (to, random.normal3().map(|x| 2.5 * x), start + 1.0);
        }
        let share = (time - start + 1.0).clamp(0.0, 1.0);
        [0, 1, 2].map(|i| from[i] + share * (to[i] - from[i]))
    }
}

/// Runs the filter on a sensor that turns about in one place, at 100 Hz; `each` sees truth and filter at every sample.
fn simulate<S: Real>(
    seed: u64,
    seconds: u32,
    mut motion: impl Motion,
    faults: Faults,
    nine: bool,
    each: &mut impl FnMut(f64, Quat<f64>, Quat<S>),
) -> Estimator<S, SelfCalKF<S>> {
    let mut random = Random(seed);
    let mut params = <SelfCalKF<S> as Filter<S>>::Params::from_values(&[]).unwrap();
    params.gyr_range = S::from_f64(faults.told);
    let mut estimator = Estimator::<S, SelfCalKF<S>>::new(&params, Settings::default());
    let mut q = Quat::<f64>::of(random.rotation());
    let dt = 0.01;
    let of = |v: [f64; 3]| Vec3::<S>::of(v);
    for k in 0..100 * seconds {
        let time = f64::from(k) * dt;
        let rate = Vec3::of(motion(&mut random, time));
        q = rotate_by(q, rate, dt);
        let m = faults.matrix;
        // ω = (I + M)⁻¹ rate + b, M being small.
        let turned = |v: Vec3<f64>| {
            Vec3::new(
                m[0] * v.x + m[1] * v.y + m[2] * v.z,
                m[3] * v.x + m[4] * v.y + m[5] * v.z,
                m[6] * v.x + m[7] * v.y + m[8] * v.z,
            )
        };
        let mut noise = |size: f64| Vec3::of([0.0; 3].map(|_: f64| size * random.normal()));
        let first = turned(rate);
        let gyr = rate - first + turned(first) + Vec3::of(faults.bias) + noise(2e-3);
        let end = if faults.range > 0.0 { faults.range } else { 1e9 };
        let gyr = Vec3::new(gyr.x.clamp(-end, end), gyr.y.clamp(-end, end), gyr.z.clamp(-end, end));
        let acc = q.conj().rotate(Vec3::of([0.0, 0.0, 9.80665])) + noise(0.05);
        let late = rotate_by(q, rate, -faults.delay);
        let (from, to, magnet) = faults.magnet;
        let magnet = if (from..to).contains(&time) { magnet } else { [0.0; 3] };
        let mag =
            late.conj().rotate(Vec3::of([0.0, 20.0, -40.0]) + Vec3::of(magnet)) + Vec3::of(faults.iron) + noise(0.3);
        let array = |v: Vec3<f64>| of([v.x, v.y, v.z]);
        let output = estimator.step(array(gyr), Some(array(acc)), nine.then_some(array(mag)), S::from_f64(dt));
        each(time, q, output.quat);
    }
    estimator
}

fn angle(a: Quat<f64>, b: Quat<f64>) -> f64 {
    2.0 * (a.conj() * b).vector().norm2().sqrt().min(1.0).asin()
}

#[test]
fn it_finds_planted_delays_and_matrices_to_what_it_says() {
    for (seed, delay) in [(1, 0.0), (2, 0.01), (3, 0.02), (4, 0.04)] {
        let mut random = Random(100 + seed);
        let faults = Faults {
            bias: random.normal3().map(|b| 0.005 * b),
            matrix: [0; 9].map(|_| 0.003 * random.normal()),
            delay,
            ..Faults::default()
        };
        let mut worst: f64 = 0.0;
        let estimator = simulate::<f64>(seed, 900, tumbling(), faults, true, &mut |time, truth, q| {
            if time > 450.0 {
                worst = worst.max(angle(truth, q));
            }
        });
        let state = estimator.filter().state();
        let found = state.mean[DELAY];
        println!("delay {delay}: {found:.4} ± {:.4}; worst angle {worst:.4}", state.p[(DELAY, DELAY)].sqrt());
        // The issue asks for 2 ms and 0.1 %. The filter says 0.5 ms, 0.2e-3 for the scales, and 0.9e-3 for the others: as a turn of
        // the gyroscope against the other sensors they show only in how these move within a turn.
        assert!((found - delay).abs() < 2e-3, "delay {delay}: found {found}");
        assert!(state.p[(DELAY, DELAY)] < 1e-6, "the delay is known to 1 ms");
        for i in 0..9 {
            let error = (state.mean[MATRIX + i] - faults.matrix[i]).abs();
            let bound = if i % 4 == 0 { 3e-4 } else { 1e-3 };
            assert!(error < bound, "entry {i} of the matrix is off by {error}");
        }
        // A disturbance as assumed, 0.018 of a field whose horizontal half is 0.45 of it, would be 0.04 rad.
        assert!(worst < 0.02, "the attitude is off by {worst} rad");
    }
}

#[test]
fn a_clipped_gyroscope_teaches_nothing_wrong() {
    // 2.5 rad/s (1 σ) an axis beyond 5 rad/s in a twentieth of the time: what is lost must not become a matrix, which it would
    // to 6e-3 if it went unnoticed.
    for told in [0.0, 5.0] {
        let faults = Faults { range: 5.0, told, ..Faults::default() };
        let estimator = simulate::<f64>(31, 300, tumbling(), faults, true, &mut |_, _, _| {});
        let mean = &estimator.filter().state().mean;
        let worst = (MATRIX..VELOCITY).map(|i| mean[i].abs()).fold(0.0, f64::max);
        assert!(worst < 1.5e-3, "told {told}: the matrix is off by {worst}");
    }
}

#[test]
fn a_reference_is_given_up_after_as_long_as_it_was_seen() {
    // The field with a magnet has another norm, inclination and heading.
    let magnet = [40.0, -10.0, -60.0];
    let turned = 40.0_f64.atan2(10.0);
    // Started near the magnet and turning there for 4 s, it takes 5 s away from it. Having turned for 17 s in the field, it
    // believes a magnet after 17 s, not after 12.
    for (from, to, time, expected) in
        [(0.0, 7.0, 6.9, turned), (0.0, 7.0, 14.0, 0.0), (20.0, 60.0, 32.0, 0.0), (20.0, 60.0, 42.0, turned)]
    {
        let faults = Faults { magnet: (from, to, magnet), ..Faults::default() };
        let mut off: f64 = 9.0;
        simulate::<f64>(41, 60, swinging(41), faults, true, &mut |now, truth, q| {
            if (now - time).abs() < 5e-3 {
                off = (angle(q, truth) - expected).abs();
            }
        });
        // Which of two headings 1.3 rad apart it believes; without a field it drifts by up to 0.1 rad in these times.
        assert!(off < 0.2, "a magnet from {from} to {to} s: {off} rad off at {time} s");
    }
}

#[test]
fn it_says_what_it_cannot_know() {
    let still = |_: &mut Random, _: f64| [0.0; 3];
    let faults = Faults { delay: 0.02, matrix: [0.003; 9], ..Faults::default() };
    let estimator = simulate::<f64>(21, 60, still, faults, true, &mut |_, _, _| {});
    let (state, before) = (estimator.filter().state(), State::new(&params()));
    for i in (MATRIX..VELOCITY).chain([DELAY]) {
        let (now, before) = (state.p[(i, i)].sqrt(), before.p[(i, i)].sqrt());
        // What the noise of the gyroscope and of its bias shows as turning is some 1e-2 rad in a minute.
        assert!(now > 0.95 * before, "state {i}: {now} of {before}");
        assert!(state.mean[i].abs() < 0.5 * before, "state {i} is {}", state.mean[i]);
    }
}

#[test]
fn ten_minutes_in_single_precision_are_those_in_double() {
    let faults = Faults { bias: [0.004, -0.003, 0.002], delay: 0.013, ..Faults::default() };
    let mut doubles = Vec::new();
    simulate::<f64>(9, 600, swinging(9), faults, true, &mut |_, _, q| doubles.push(q));
    let mut worst: f64 = 0.0;
    let mut k = 0;
    simulate::<f32>(9, 600, swinging(9), faults, true, &mut |time, _, q| {
        let q = Quat::of([q.w, q.x, q.y, q.z].map(f64::from));
        if time > 1.0 {
            worst = worst.max(angle(doubles[k], q));
        }
        k += 1;
    });
    println!("{worst:e} rad");
    // The variances of both differ by some 60 epsilon a block (the spare for rounding), 0.4 % a minute for what has no
    // noise of its own; a weight that differs so much moves the estimate by a small share of its error of 0.01 rad.
    assert!(worst < 2e-3, "{worst} rad");
}

#[test]
fn without_a_magnetometer_nothing_of_it_moves() {
    let estimator = simulate::<f64>(11, 60, swinging(11), Faults::default(), false, &mut |_, _, _| {});
    let state = estimator.filter().state();
    for i in (IRON..DISTURBANCE + 3).chain([HORIZONTAL, HORIZONTAL + 1, DELAY]) {
        assert!(state.mean[i].abs() <= 0.0, "state {i} is {}", state.mean[i]);
    }
}

#[test]
fn the_covariance_stays_one_in_motion_at_rest_and_over_gaps() {
    fn check<S: Real>() {
        let params = <SelfCalKF<S> as Filter<S>>::Params::from_values(&[]).unwrap();
        let mut estimator = Estimator::<S, SelfCalKF<S>>::new(&params, Settings::default());
        let mut random = Random(3);
        let mut q = Quat::<f64>::identity();
        for k in 0..60_000 {
            let dt = if random.chance(1e-3) { random.uniform(0.0, 2.0) } else { 0.01 };
            let rests = (k / 10_000) % 2 == 1;
            let rate = if rests { [0.0; 3] } else { [2.0 * (0.01 * f64::from(k)).sin(), 1.0, -0.5] };
            q = rotate_by(q, Vec3::of(rate), dt);
            let acc = q.conj().rotate(Vec3::of([0.0, 0.0, 9.81]));
            let mag = q.conj().rotate(Vec3::of([0.0, 20.0, -40.0]));
            let of = |v: Vec3<f64>| Vec3::<S>::of([v.x, v.y, v.z]);
            let acc = if random.chance(0.05) { of(Vec3::of([f64::NAN; 3])) } else { of(acc) };
            estimator.step(Vec3::of(rate), Some(acc), Some(of(mag)), S::from_f64(dt));
            if k % 500 == 499 {
                let p = &estimator.filter().state().p;
                let mut l = [[0.0; N]; N];
                for i in 0..N {
                    for j in 0..=i {
                        assert!((p[(i, j)].to_f64() - p[(j, i)].to_f64()).abs() <= 0.0, "symmetric at ({i}, {j})");
                        let rest = p[(i, j)].to_f64() - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
                        if i == j {
                            assert!(rest > 0.0, "sample {k}: pivot {i} of {} bits is {rest:e}", 8 * size_of::<S>());
                            l[i][i] = rest.sqrt();
                        } else {
                            l[i][j] = rest / l[j][j];
                        }
                    }
                }
            }
        }
    }
    check::<f64>();
    check::<f32>();
}
