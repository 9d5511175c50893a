//! The low-pass filters beside the filters they are made from, and the sum that loses nothing.

#![allow(clippy::indexing_slicing, clippy::unwrap_used, reason = "a test that fails may panic")]
#![allow(clippy::float_cmp, reason = "where a law is exact it is tested exactly")]
#![allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    reason = "small counters; f32 is what is tested"
)]

#[path = "support/random.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod random;

#[path = "signal/butterworth.rs"]
mod butterworth;

use std::f64::consts::{PI, SQRT_2};

use ahrs_rs::signal::{Coefficients, Gain, LowPass, Sum};
use ahrs_rs::{Mask, Pair, Real, Scalar};
use random::Random;

/// One signal through the filter.
fn filtered<T: Real>(tau: f64, samples: &[(f64, f64)]) -> Vec<f64> {
    let mut coefficients = Coefficients::new(T::from_f64(tau));
    let mut low_pass = LowPass::<T, 1>::default();
    let step = |&(x, dt): &(f64, f64)| {
        coefficients.set_step(true, T::from_f64(dt));
        low_pass.step(true, [T::from_f64(x)], &coefficients)[0].to_f64()
    };
    samples.iter().map(step).collect()
}

/// The second-order Butterworth filter by the bilinear transform, as a difference equation that starts at rest at `x0`.
fn difference_equation(tau: f64, dt: f64, x0: f64, x: &[f64]) -> Vec<f64> {
    let c = (PI * SQRT_2 / (2.0 * PI * tau) * dt).tan();
    let d = c * c + SQRT_2 * c + 1.0;
    let b0 = c * c / d;
    let (a1, a2) = (2.0 * (c * c - 1.0) / d, (1.0 - SQRT_2 * c + c * c) / d);
    let (mut x1, mut x2, mut y1, mut y2) = (x0, x0, x0, x0);
    x.iter()
        .map(|&x| {
            let y = b0 * (x + 2.0 * x1 + x2) - a1 * y1 - a2 * y2;
            (x2, x1, y2, y1) = (x1, x, y1, y);
            y
        })
        .collect()
}

fn noise(seed: u64, samples: usize, size: f64) -> Vec<f64> {
    let mut random = Random(seed);
    (0..samples).map(|k| 9.8 + (k as f64 * 0.01).sin() + size * random.normal()).collect()
}

#[test]
fn at_a_constant_step_it_is_the_butterworth_filter_after_the_mean_of_the_start() {
    for (tau, dt) in [(3.0, 0.01), (3.0, 0.005), (0.5, 0.0035), (0.05, 0.01), (0.02, 0.03)] {
        let x = noise(1, 3000, 1.0);
        let y = filtered::<f64>(tau, &x.iter().map(|&x| (x, dt)).collect::<Vec<_>>());
        // count·dt, not a sum of dt, ends the start.
        let start = (1..x.len()).find(|&count| count as f64 * dt >= tau).unwrap();
        let mut sum = 0.0;
        for k in 0..start {
            sum += x[k];
            assert!((y[k] - sum / (k as f64 + 1.0)).abs() < 1e-12, "tau {tau}, dt {dt}: the mean at {k}");
        }
        let expected = difference_equation(tau, dt, sum / start as f64, &x[start..]);
        for (k, (y, expected)) in y[start..].iter().zip(&expected).enumerate() {
            // The difference equation cancels to 1/(ω dt)² = 1e5 epsilon of the signal.
            assert!((y - expected).abs() < 1e-9, "tau {tau}, dt {dt}: {} at {k}", y - expected);
        }
    }
}

#[test]
fn a_constant_passes_unchanged_at_steps_of_any_length() {
    let mut random = Random(2);
    for _ in 0..50 {
        let tau = random.spread(-3.0, 2.0).abs();
        let steps: Vec<_> = (0..500).map(|_| (7.25, random.spread(-6.0, 3.0).abs())).collect();
        for y in filtered::<f64>(tau, &steps) {
            assert_eq!(y, 7.25);
        }
    }
}

#[test]
fn steps_of_any_length_do_not_add_up() {
    // Between samples the integrators forget at any step (the loop loses energy), but they stand half a step ahead of the
    // output, so that after a long step a short one shows more than the signal: measured at most 2.4 times as much.
    let (mut random, mut worst) = (Random(3), 0.0_f64);
    for _ in 0..100 {
        let tau = random.uniform(0.1, 3.0);
        let samples: Vec<_> = (0..2000).map(|_| (random.uniform(-1.0, 1.0), random.spread(-5.0, 1.0).abs())).collect();
        worst = filtered::<f64>(tau, &samples).iter().fold(worst, |worst, y| worst.max(y.abs()));
    }
    println!("{worst} times the signal");
    assert!(worst < 4.0, "{worst}");
}

#[test]
fn it_reaches_a_new_value_in_the_same_time_at_every_rate() {
    // The step response at τ is 1 − exp(−1)(cos 1 + sin 1) = 0.4917; the trapezoidal rule adds half a step of delay.
    for dt in [0.1, 0.01, 0.001, 0.0003] {
        let mut samples = vec![(0.0, 3.0)];
        samples.extend((1..20_000).map(f64::from).take_while(|k| k * dt < 3.0 + 0.5 * dt).map(|_| (1.0, dt)));
        let y = *filtered::<f64>(3.0, &samples).last().unwrap();
        let exact = 1.0 - (-1.0_f64).exp() * (1.0_f64.cos() + 1.0_f64.sin());
        assert!((y - exact).abs() < 0.3 * dt, "dt {dt}: {y} for {exact}");
    }
}

#[test]
fn a_cut_off_above_the_nyquist_frequency_passes_through() {
    let x = noise(4, 100, 1.0);
    for (tau, dt) in [(0.0, 0.01), (0.004, 0.01), (0.0049, 0.01), (3.0, 7.0)] {
        assert_eq!(filtered::<f64>(tau, &x.iter().map(|&x| (x, dt)).collect::<Vec<_>>()), x);
    }
    // No step without a time constant either.
    assert_eq!(filtered::<f64>(0.0, &[(1.0, 0.0), (2.0, 0.0)]), [1.0, 2.0]);
}

#[test]
fn single_precision_keeps_the_signal_at_high_rates() {
    // The difference equation is off by 1 % of the signal at 286 Hz and useless at 1 kHz. Here rounding of 9.8, at most 4.8e-7
    // in each of the 3000 samples of τ, adds up as a walk of at most 2.6e-5; measured 3.7e-5, which is 4e-6 rad of gravity.
    for dt in [1.0 / 286.0, 1e-3] {
        let x: Vec<_> = noise(5, 60_000, 0.05).iter().map(|&x| (f64::from(x as f32), dt)).collect();
        let off = filtered::<f32>(3.0, &x)
            .iter()
            .zip(filtered::<f64>(3.0, &x))
            .fold(0.0_f64, |worst, (narrow, wide)| worst.max((narrow - wide).abs()));
        println!("f32 at {dt}: off by {off:e}");
        assert!(off < 1e-4, "dt {dt}: {off:e}");
    }
}

#[test]
fn lanes_have_the_bits_of_the_scalar_and_a_masked_lane_stands_still() {
    let mut random = Random(6);
    let mut lanes = LowPass::<Pair<f64>, 2>::default();
    let mut alone = [LowPass::<f64, 2>::default(), LowPass::<f64, 2>::default()];
    let mut coefficients = Coefficients::<Pair<f64>>::new(Pair::of(0.05));
    let mut own = [Coefficients::<f64>::new(0.05), Coefficients::<f64>::new(0.05)];
    for _ in 0..500 {
        let (dt, x) = ([random.spread(-4.0, 0.0).abs(), 0.01], [random.normal(), random.normal()]);
        let valid = [random.chance(0.8), random.chance(0.5)];
        let mut mask = <Pair<f64> as Scalar>::Mask::splat(false);
        valid.iter().enumerate().for_each(|(lane, &valid)| mask.set_lane(lane, valid));
        coefficients.set_step(mask, Pair(dt[0], dt[1]));
        let y = lanes.step(mask, [Pair(x[0], x[1]), Pair(-x[0], f64::NAN)], &coefficients);
        for lane in 0..2 {
            if valid[lane] {
                own[lane].set_step(true, dt[lane]);
                let expected = alone[lane].step(true, [x[lane], if lane == 0 { -x[0] } else { f64::NAN }], &own[lane]);
                assert_eq!(y[0].lane(lane).to_bits(), expected[0].to_bits());
            }
        }
    }
}

#[test]
fn the_weight_of_a_first_order_filter_composes() {
    // Two steps leave what one of both leaves: (1 − w1)(1 − w2) = 1 − w12, to rounding.
    let mut random = Random(7);
    for _ in 0..1000 {
        let (tau, a, b) = (random.uniform(0.1, 20.0), random.uniform(0.0, 5.0), random.uniform(0.0, 5.0));
        let weight = |dt: f64| Gain::new(tau).weight(true, dt);
        assert!(((1.0 - weight(a)) * (1.0 - weight(b)) - (1.0 - weight(a + b))).abs() < 1e-15);
    }
    for dt in [0.0, 1e-9, 1.0] {
        assert_eq!(Gain::new(0.0).weight(true, dt), 1.0, "without a time constant a sample is all that counts");
    }
}

#[test]
fn a_sum_keeps_what_is_below_its_last_place() {
    let mut sum = Sum::new(1.0_f32);
    for _ in 0..10_000_000 {
        sum = sum.plus(1e-9);
    }
    // A plain sum stays at one.
    assert!((sum.value - 1.01).abs() < 2.0 * f32::EPSILON, "{}", sum.value);
}
