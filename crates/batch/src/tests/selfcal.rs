//! `SelfCalSmoother`: its smoother against a dense solution, what it finds of planted faults, and recordings of every shape.

#![allow(clippy::cast_sign_loss, reason = "times are not negative")]
#![allow(clippy::needless_range_loop, reason = "indices as in the equations")]

use ahrs_rs::filters::SelfCalKF;
use ahrs_rs::filters::kalman::{Column, zeros};
use ahrs_rs::filters::selfcal::Params;
use ahrs_rs::filters::selfcal::state::{
    BIAS, DELAY, GRAVITY, HORIZONTAL, IRON, MATRIX, N, State, VERTICAL, initial_variance,
};
use ahrs_rs::params::ParamSet;
use ahrs_rs::so3::{exp_half, rotate_by};
use ahrs_rs::{Estimator, Quat, Settings, Vec3};

use super::random::Random;
use crate::offline::selfcal::blocks::{Samples, Summed, Trajectory, rotation_vector};
use crate::offline::selfcal::smoother::{ASKED, Filter, smooth};
use crate::offline::selfcal::{SPEC, make};
use crate::offline::{Series, Solution};
use crate::threads::Watch;

const GRAVITY_HERE: f64 = 9.80665;

/// What is wrong with the simulated sensors.
#[derive(Clone, Copy, Default)]
struct Faults {
    bias: [f64; 3],
    matrix: [f64; 9],
    delay: f64,
    /// The time in s until which it rests.
    rest: f64,
    /// The time in s until which a magnet stands near, and its field (earth frame).
    magnet: (f64, [f64; 3]),
    /// The largest rate that the gyroscope measures.
    range: Option<f64>,
    /// True if it spins about one axis after the other, always the same way round: what a scale does adds up.
    spins: bool,
}

/// A sensor that turns and moves about in one place at 100 Hz, with the noise of a good one; and its true attitudes.
fn simulated(seed: u64, seconds: f64, faults: Faults) -> (Series, Vec<Quat<f64>>) {
    let mut random = Random(seed);
    let mut q = Quat::<f64>::of(random.rotation());
    let phase = random.normal3();
    let dt = 0.01;
    let (mut series, mut truth) = (Series { gyr: vec![], acc: None, mag: None, dt: vec![] }, Vec::new());
    let (mut accs, mut mags) = (Vec::new(), Vec::new());
    let m = faults.matrix;
    let turned = |v: Vec3<f64>| {
        let row = |i: usize| m[i] * v.x + m[i + 1] * v.y + m[i + 2] * v.z;
        Vec3::new(row(0), row(3), row(6))
    };
    for k in 0..(seconds / dt) as usize {
        let time = k as f64 * dt;
        let moves = time >= faults.rest;
        let rate = Vec3::of([
            2.5 * (0.9 * time + phase[0]).sin(),
            3.0 * (0.7 * time + phase[1]).cos(),
            2.0 * (0.5 * time + phase[2]).sin(),
        ]);
        let spin = |axis: usize| if (time / 8.0) as usize % 3 == axis { 2.5 + 2.5 * f64::sin(2.0 * time) } else { 0.1 };
        let rate = if faults.spins { Vec3::of([spin(0), spin(1), spin(2)]) } else { rate };
        let rate = if moves { rate } else { Vec3::zero() };
        q = rotate_by(q, rate, dt);
        // ω = (I + M)⁻¹ rate + b, M being small.
        let first = turned(rate);
        let mut noise = |size: f64| Vec3::of([0.0; 3].map(|_: f64| size * random.normal()));
        let mut gyr = rate - first + turned(first) + Vec3::of(faults.bias) + noise(2e-3);
        if let Some(range) = faults.range {
            gyr = Vec3::of([gyr.x, gyr.y, gyr.z].map(|x| x.clamp(-range, range)));
        }
        // Its velocity is sines, so that it stays in one place.
        let since = time - faults.rest;
        let push = Vec3::of([7.0, 9.0, 11.0].map(|f| if moves { 2.0 * f64::cos(f * since) } else { 0.0 }));
        accs.push(q.conj().rotate(push + Vec3::of([0.0, 0.0, GRAVITY_HERE])) + noise(0.05));
        let late = rotate_by(q, rate, -faults.delay);
        let magnet = if time < faults.magnet.0 { Vec3::of(faults.magnet.1) } else { Vec3::zero() };
        let field = Vec3::of([0.0, 20.0, -40.0]) + magnet;
        mags.push(late.conj().rotate(field) + noise(0.3));
        series.gyr.push(gyr);
        series.dt.push(dt);
        truth.push(q);
    }
    (series.acc, series.mag) = (Some(accs), Some(mags));
    (series, truth)
}

/// The smoother's solution, with the outputs of these names.
fn solved(series: &Series, params: &[(&str, f64)], outputs: &[&str]) -> Solution {
    let given = |name: &str| params.iter().find(|(given, _)| *given == name).map(|(_, value)| *value);
    let values: Vec<_> = SPEC.params.iter().map(|spec| given(spec.name).unwrap_or(spec.default())).collect();
    let index = |name: &&str| SPEC.outputs.iter().position(|output| output.name == *name).unwrap();
    let outputs: Vec<_> = outputs.iter().map(index).collect();
    let filter = make(&values, Settings::default()).unwrap();
    filter.solve(series, &outputs, &Watch::default()).unwrap()
}

fn angle(a: Quat<f64>, b: Quat<f64>) -> f64 {
    rotation_vector((a.conj() * b).unit_or(Quat::identity())).norm2().sqrt()
}

/// The root mean square of the attitude's error over some samples.
fn rms(found: &[Quat<f64>], truth: &[Quat<f64>]) -> f64 {
    let sum: f64 = found.iter().zip(truth).map(|(a, b)| angle(*a, *b).powi(2)).sum();
    (sum / found.len() as f64).sqrt()
}

fn causal(series: &Series) -> Vec<Quat<f64>> {
    let params = Params::from_values(&[]).unwrap();
    let mut estimator = Estimator::<f64, SelfCalKF<f64>>::new(&params, Settings::default());
    let row = |rows: &Option<Vec<Vec3<f64>>>, k: usize| rows.as_ref().map(|rows| rows[k]);
    (0..series.dt.len())
        .map(|k| estimator.step(series.gyr[k], row(&series.acc, k), row(&series.mag, k), series.dt[k]).quat)
        .collect()
}

/// The samples of a simulation, its blocks about a trajectory that is off, the prior, and the parameters.
fn some_blocks(seconds: f64, turn: f64) -> (Samples, Vec<usize>, Trajectory, Column<f64, N>, Params<f64>) {
    let (series, truth) =
        simulated(5, seconds, Faults { bias: [0.003, -0.002, 0.001], rest: 0.35, ..Faults::default() });
    let params = Params::from_values(&[]).unwrap();
    let mut steps = series.dt.clone();
    steps[0] = 0.0;
    let norm = f64::hypot(20.0, 40.0);
    let mut samples = Samples {
        rates: series.gyr.clone(),
        steps,
        acc: series.acc.unwrap().into_iter().map(Some).collect(),
        mag: series.mag.unwrap().into_iter().map(|field| Some(field * (1.0 / norm))).collect(),
        rest: (0..truth.len()).map(|k| k < 30).collect(),
        lost: vec![0.0; truth.len()],
        ..Samples::default()
    };
    samples.find_clipped(0.0);
    let ends = samples.block_ends();
    let mut random = Random(6);
    let north = exp_half(Vec3::of([0.0, 0.0, 0.5 * turn]));
    let mut off = |q: Quat<f64>| north * exp_half(Vec3::of(random.normal3()) * 0.01) * q;
    let quat =
        std::iter::once(truth[0]).chain(ends.iter().map(|&end| truth[end - 1])).map(&mut off).collect::<Vec<_>>();
    let mut mean: Column<f64, N> = zeros();
    let mut prior = mean;
    (prior[GRAVITY], prior[HORIZONTAL], prior[VERTICAL]) = (GRAVITY_HERE, 20.0 / norm, -40.0 / norm);
    for (i, value) in
        [(GRAVITY, 9.81), (HORIZONTAL, 0.44), (VERTICAL, -0.9), (DELAY, 0.002), (IRON, 1e-3), (MATRIX, 1e-3)]
    {
        mean[i] = value;
    }
    let mean = (0..quat.len())
        .map(|k| {
            let mut mean = mean;
            mean[BIAS] = 1e-4 * k as f64;
            mean
        })
        .collect();
    (samples, ends, Trajectory { quat, mean }, prior, params)
}

/// Solves A X = B for a positive definite A, row by row, by Cholesky's decomposition.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let n = a.len();
    for i in 0..n {
        for j in 0..=i {
            let rest = a[i][j] - (0..j).map(|k| a[i][k] * a[j][k]).sum::<f64>();
            a[i][j] = if i == j { rest.sqrt() } else { rest / a[j][j] };
        }
    }
    for column in 0..b[0].len() {
        for i in 0..n {
            b[i][column] = (b[i][column] - (0..i).map(|k| a[i][k] * b[k][column]).sum::<f64>()) / a[i][i];
        }
        for i in (0..n).rev() {
            b[i][column] = (b[i][column] - (i + 1..n).map(|k| a[k][i] * b[k][column]).sum::<f64>()) / a[i][i];
        }
    }
    b
}

#[test]
#[allow(clippy::too_many_lines, reason = "one equation after the other")]
fn the_smoother_is_the_dense_solution_of_all_measurements_at_once() {
    let (mut samples, ends, nominal, prior, params) = some_blocks(0.8, 0.0);
    samples.clipped[55][1] = true;
    samples.lost[67] = 0.04;
    let mut state = State::new(&params);
    let mut blocks = samples.sums(&ends, &nominal, &mut state);
    for (k, block) in blocks.iter_mut().enumerate() {
        block.weight = 0.2 + 0.1 * k as f64;
    }
    let blocks: Vec<Summed> = blocks;
    let mut filter = Filter::new(&nominal, &prior, &params, blocks.len(), false).unwrap();
    for (node, block) in blocks.iter().enumerate() {
        filter.go_on(node, block).unwrap();
    }
    let smoothed = smooth(&blocks, &nominal, &prior, &params, true, &Watch::default()).unwrap();

    // All nodes as one Gaussian vector: mean and covariance without the measurements, from x := F x + noise + moved.
    let nodes = blocks.len() + 1;
    let mut mean = vec![vec![0.0; N]; nodes];
    let mut covariance = vec![vec![0.0; N * nodes]; N * nodes];
    for i in 0..N {
        mean[0][i] = prior[i] - nominal.mean[0][i];
        covariance[i][i] = initial_variance(&params, i);
    }
    for (k, step) in filter.steps.iter().enumerate() {
        let transitioned = |column: Vec<f64>| {
            let mut x: Column<f64, N> = zeros();
            x.iter_mut().zip(&column).for_each(|(x, value)| *x = *value);
            step.transition.apply(&mut x);
            x
        };
        let x = transitioned(mean[k].clone()) + step.moved;
        mean[k + 1] = x.iter().copied().collect();
        // F times the rows of the node before, for all columns so far; then the columns.
        for column in 0..N * (k + 1) {
            let x = transitioned((0..N).map(|i| covariance[N * k + i][column]).collect());
            for i in 0..N {
                covariance[N * (k + 1) + i][column] = x[i];
                covariance[column][N * (k + 1) + i] = x[i];
            }
        }
        for row in N * (k + 1)..N * (k + 2) {
            let x = transitioned((0..N).map(|i| covariance[row][N * k + i]).collect());
            for i in 0..N {
                covariance[row][N * (k + 1) + i] = x[i];
            }
        }
        for (start, noise) in step.noises {
            for i in start..start + 3 {
                covariance[N * (k + 1) + i][N * (k + 1) + i] += noise;
            }
        }
        for i in 0..3 {
            for j in 0..3 {
                covariance[N * (k + 1) + i][N * (k + 1) + j] += step.lost.map_or(0.0, |lost| lost[(i, j)]);
            }
        }
    }
    // Its measurements: they see the error before it is moved.
    let mut seen = Vec::new();
    let mut start = 0;
    for (k, step) in filter.steps.iter().enumerate() {
        for taken in &filter.taken[start..step.taken] {
            let row = taken.row;
            let moved: f64 = row.at.iter().zip(row.h).map(|(&at, h)| step.moved[at] * h).sum();
            let h: Vec<_> = row.at.iter().zip(row.h).map(|(&at, h)| (N * (k + 1) + at, h)).collect();
            let expected: f64 = row.at.iter().zip(row.h).map(|(&at, h)| mean[k + 1][at] * h).sum();
            seen.push((h, row.z + moved - expected, row.r));
        }
        start = step.taken;
    }
    assert_eq!(filter.steps.iter().filter(|step| step.lost.is_some()).count(), 2);
    assert!(seen.len() > 50);
    let ch: Vec<Vec<f64>> = seen
        .iter()
        .map(|(h, _, _)| (0..N * nodes).map(|i| h.iter().map(|(at, h)| covariance[i][*at] * h).sum()).collect())
        .collect();
    let mut s = vec![vec![0.0; seen.len()]; seen.len()];
    for (a, (h, _, r)) in seen.iter().enumerate() {
        for b in 0..seen.len() {
            s[a][b] = h.iter().map(|(at, h)| ch[b][*at] * h).sum();
        }
        s[a][a] += r;
    }
    // S⁻¹ (ν, H C).
    let right = seen.iter().zip(&ch).map(|((_, nu, _), ch)| std::iter::once(*nu).chain(ch.iter().copied()).collect());
    let solution = solve(s, right.collect());
    for k in 0..nodes {
        for i in 0..N {
            let at = N * k + i;
            let change: f64 = ch.iter().zip(&solution).map(|(ch, solution)| ch[at] * solution[0]).sum();
            let expected = mean[k][i] + change;
            let found = if i < 3 {
                let turn = rotation_vector(smoothed.trajectory.quat[k] * nominal.quat[k].conj());
                [turn.x, turn.y, turn.z][i]
            } else {
                smoothed.trajectory.mean[k][i] - nominal.mean[k][i]
            };
            // Numbers up to 10 (gravity), and variances from 1e-8 to 1.
            assert!((found - expected).abs() < 1e-9, "node {k}, state {i}: {found:e}, not {expected:e}");
        }
        for i in 0..if k == 0 { 0 } else { ASKED } {
            for j in 0..ASKED {
                let (a, b) = (N * k + i, N * k + j);
                let less: f64 = ch.iter().zip(&solution).map(|(ch, solution)| ch[a] * solution[1 + b]).sum();
                let expected = covariance[a][b] - less;
                let found = smoothed.covariances[k - 1][(i, j)];
                let scale = (covariance[a][a] * covariance[b][b]).sqrt();
                assert!((found - expected).abs() < 1e-9 * scale, "node {k}, ({i}, {j}): {found:e}, not {expected:e}");
            }
        }
    }
}

#[test]
fn a_turn_of_the_earth_frame_about_the_vertical_turns_the_result() {
    let results = [0.0, 1.0].map(|turn| {
        let (mut samples, ends, nominal, prior, params) = some_blocks(4.0, turn);
        samples.mag = vec![None; samples.rates.len()];
        let blocks = samples.sums(&ends, &nominal, &mut State::new(&params));
        smooth(&blocks, &nominal, &prior, &params, false, &Watch::default()).unwrap().trajectory
    });
    let [plain, turned] = &results;
    let turn = exp_half(Vec3::of([0.0, 0.0, 0.5]));
    for (k, (plain, turned)) in plain.quat.iter().zip(&turned.quat).enumerate() {
        // Rounding of a covariance whose numbers are nine powers of ten apart.
        assert!(angle(turn * *plain, *turned) < 1e-9, "node {k}");
    }
    for (plain, turned) in plain.mean.iter().zip(&turned.mean) {
        assert!((plain[BIAS] - turned[BIAS]).abs() < 1e-10);
    }
}

#[test]
fn a_mounted_sensor_gives_the_mounted_attitude() {
    let (series, _) = simulated(4, 30.0, Faults { delay: 0.01, rest: 2.0, ..Faults::default() });
    let plain = solved(&series, &[], &["covariance"]);
    let mount = Quat::<f64>::of(Random(1).rotation());
    let mounted = |rows: &[Vec3<f64>]| rows.iter().map(|v| mount.rotate(*v)).collect::<Vec<_>>();
    let turned = Series {
        gyr: mounted(&series.gyr),
        acc: series.acc.as_deref().map(mounted),
        mag: series.mag.as_deref().map(mounted),
        dt: series.dt.clone(),
    };
    let turned = solved(&turned, &[], &["covariance"]);
    for (plain, turned) in plain.quat.iter().zip(&turned.quat) {
        // Rounding only; the search for the median of norms takes the same sample.
        assert!(angle(*plain * mount.conj(), *turned) < 1e-8);
    }
}

#[test]
fn it_finds_planted_delays_and_matrices() {
    for (seed, delay) in [(1, 0.0), (2, 0.013), (3, 0.04)] {
        let mut random = Random(100 + seed);
        let faults = Faults {
            bias: random.normal3().map(|b| 0.005 * b),
            matrix: [0; 9].map(|_| 0.003 * random.normal()),
            delay,
            rest: 3.0,
            spins: true,
            ..Faults::default()
        };
        let (series, truth) = simulated(seed, 180.0, faults);
        let found = solved(&series, &[], &["mag_delay", "mag_delay_sigma", "gyr_matrix", "gyr_matrix_sigma"]);
        let [tau, sigma] = [0, 1].map(|i| found.extra[i][0]);
        println!("delay {delay}: {tau:.5} ± {sigma:.5}, attitude off by {:.5} rad", rms(&found.quat, &truth));
        // What the issue asks for: 2 ms and 0.1 %.
        assert!((tau - delay).abs() < 2e-3 && sigma < 2e-3, "delay {delay}: found {tau} ± {sigma}");
        for i in 0..9 {
            let (entry, sigma) = (found.extra[2][i], found.extra[3][i]);
            println!("   {:+.5} {entry:+.5} ± {sigma:.5}", faults.matrix[i]);
            let off = (entry - faults.matrix[i]).abs();
            // A spin adds up what a scale does, and turns a misalignment round until nothing is left of it.
            let scale = i % 4 == 0;
            assert!(!scale || off < 1e-3, "entry {i}: {entry}, not {}", faults.matrix[i]);
            assert!(scale == (sigma < 1e-3) && off < 4.0 * sigma, "entry {i}: {entry} ± {sigma}");
        }
        // At rest for 3 s, with 2e-3 rad/s/√Hz: 1.2e-3 rad/s a component.
        let off = found.gyr_bias[100] - Vec3::of(faults.bias);
        assert!(off.norm2().sqrt() < 5e-3, "the bias is off by {off:?}");
        // Half a degree.
        assert!(rms(&found.quat, &truth) < 9e-3);
    }
}

#[test]
fn it_says_that_rest_shows_neither_delay_nor_matrix() {
    let (series, _) = simulated(8, 60.0, Faults { delay: 0.02, rest: 1e9, ..Faults::default() });
    let found = solved(&series, &[], &["mag_delay_sigma", "gyr_matrix_sigma", "bias_sigma"]);
    let of = |name: &str| SPEC.params.iter().find(|spec| spec.name == name).unwrap().default();
    assert!(found.extra[0][0] > 0.99 * of("initial_delay"));
    assert!(found.extra[1].iter().all(|sigma| *sigma > 0.99 * of("initial_matrix")));
    // The bias, on the other hand, is seen.
    assert!(found.extra[2].iter().all(|sigma| *sigma < 0.1 * of("initial_bias")));
}

#[test]
fn it_repairs_a_start_in_motion_in_a_field_that_is_wrong() {
    let faults =
        Faults { magnet: (15.0, [25.0, -15.0, 15.0]), delay: 0.01, bias: [0.004, 0.0, -0.003], ..Faults::default() };
    let (series, truth) = simulated(21, 120.0, faults);
    let start = 0..1000;
    let before = rms(&causal(&series)[start.clone()], &truth[start.clone()]);
    let found = solved(&series, &[], &["mag_weight"]);
    let after = rms(&found.quat[start.clone()], &truth[start]);
    println!("{before} {after}");
    assert!(before > 0.5, "the causal filter is off by {before} rad: nothing to repair");
    // 2°, the heading's error of a gyroscope over 15 s, and of the field's wandering.
    assert!(after < 0.035, "off by {after} rad");
    assert!(found.extra[0][500] < 0.25, "a field of another direction counts {}", found.extra[0][500]);
}

#[test]
fn it_finds_the_end_of_the_gyroscope_s_range() {
    let (series, truth) = simulated(30, 90.0, Faults { range: Some(2.4), rest: 3.0, ..Faults::default() });
    let off = |params: &[(&str, f64)]| rms(&solved(&series, params, &[]).quat, &truth);
    let [found, given, unknown] = [off(&[]), off(&[("gyr_range", 2.4)]), off(&[("gyr_range", 1000.0)])];
    println!("{found} {given} {unknown}");
    assert!(found < 0.7 * unknown, "{found} rad with the range, {unknown} without");
    assert!((found - given).abs() < 0.1 * given, "{found} rad found, {given} given");
}

#[test]
fn latency_turns_the_output_ahead() {
    let (series, _) = simulated(12, 20.0, Faults::default());
    let [plain, ahead] = [0.0, 0.05].map(|latency| solved(&series, &[("latency", latency)], &["gyr_matrix"]));
    for k in 0..plain.quat.len() {
        let rate = series.gyr[k] - plain.gyr_bias[k];
        let expected = plain.quat[k] * exp_half(rate * 0.025);
        // The matrix, some 0.3 % of 0.2 rad.
        assert!(angle(expected, ahead.quat[k]) < 2e-3);
    }
}

#[test]
fn every_recording_gives_finite_unit_attitudes() {
    let nan = Vec3::of([f64::NAN; 3]);
    let mut random = Random(77);
    let every: Vec<_> = SPEC.outputs.iter().map(|output| output.name).collect();
    for samples in [0, 1, 2, 3, 9, 10, 11, 700] {
        for case in 0..8 {
            let (mut series, _) = simulated(case, 7.0, Faults { rest: 2.0, ..Faults::default() });
            for rows in [Some(&mut series.gyr), series.acc.as_mut(), series.mag.as_mut()].into_iter().flatten() {
                rows.truncate(samples);
                for row in rows.iter_mut() {
                    match case {
                        1 if random.chance(0.3) => *row = nan,
                        2 => *row = nan,
                        3 if random.chance(0.01) => *row = *row * 1e30,
                        4 => *row = Vec3::zero(),
                        _ => (),
                    }
                }
            }
            series.dt.truncate(samples);
            for dt in &mut series.dt {
                match case {
                    5 => *dt = 0.0,
                    6 => *dt = [0.0, 1e-9, 0.01, 0.3, 1e4, 1e9, f64::NAN][random.below(7)],
                    _ => *dt = random.uniform(0.002, 0.02),
                }
            }
            if case == 7 {
                (series.acc, series.mag) = (None, None);
            }
            let found = solved(&series, &[], &every);
            assert_eq!((found.quat.len(), found.status.len(), found.gyr_bias.len()), (samples, samples, samples));
            for q in &found.quat {
                // Products of some thousand unit quaternions, made unit ones at the end.
                assert!((q.dot(*q) - 1.0).abs() < 1e-14, "case {case}, {samples} samples: {q:?}");
            }
            for (values, output) in found.extra.iter().zip(SPEC.outputs) {
                assert_eq!(values.len(), samples * output.len(), "{} of case {case}, {samples} samples", output.name);
                assert!(values.iter().all(|value| value.is_finite()), "{} of case {case}", output.name);
            }
        }
    }
}

#[test]
fn no_parameter_makes_it_lose_the_attitude() {
    let (series, _) = simulated(3, 6.0, Faults { rest: 2.0, ..Faults::default() });
    for spec in SPEC.params {
        let ahrs_rs::params::ParamKind::Real { min, max, .. } = spec.kind else { continue };
        for value in [min, max] {
            let found = solved(&series, &[(spec.name, value)], &["covariance", "mag_weight", "disturbance"]);
            for q in &found.quat {
                assert!((q.dot(*q) - 1.0).abs() < 1e-14, "{} = {value}: {q:?}", spec.name);
            }
            assert!(found.gyr_bias.iter().all(|bias| bias.norm2().is_finite()), "{} = {value}", spec.name);
            assert!(found.extra.iter().flatten().all(|value| value.is_finite()), "{} = {value}", spec.name);
        }
    }
}
