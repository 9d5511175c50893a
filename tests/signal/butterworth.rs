//! The Butterworth filter of every order beside its difference equation, and at steps, gaps and values of every kind.

use std::f64::consts::PI;

use ahrs_rs::signal::butterworth::HIGHEST_ORDER;
use ahrs_rs::signal::{Butterworth, DesignError};
use ahrs_rs::{Mask, Pair, Real, Scalar, Vec3};

use super::noise;
use super::random::Random;

/// One signal through a filter.
fn filtered<T: Real>(order: usize, cutoff: f64, samples: impl IntoIterator<Item = (f64, f64)>) -> Vec<f64> {
    let mut low_pass = Butterworth::<T>::new(order, T::from_f64(cutoff)).unwrap();
    samples.into_iter().map(|(x, dt)| low_pass.step(T::from_f64(x), T::from_f64(dt)).to_f64()).collect()
}

fn at(dt: f64, x: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    x.iter().map(move |&x| (x, dt))
}

/// The bilinear transform as difference equations in direct form, one for each pole pair, starting at rest at `x[0]`.
fn difference_equations(order: usize, cutoff: f64, dt: f64, x: &[f64]) -> Vec<f64> {
    let c = (PI * cutoff * dt).tan();
    let mut y = x.to_vec();
    if order % 2 == 1 {
        let (mut before, mut value) = (x[0], x[0]);
        for y in &mut y {
            value = (c * (*y + before) + (1.0 - c) * value) / (1.0 + c);
            before = std::mem::replace(y, value);
        }
    }
    for pair in 0..order / 2 {
        // The angle of the poles from the positive imaginary axis.
        let angle = PI * (2 * pair + 1) as f64 / (2 * order) as f64;
        let k = 2.0 * angle.sin();
        let d = 1.0 + k * c + c * c;
        let (mut x1, mut x2, mut y1, mut y2) = (x[0], x[0], x[0], x[0]);
        for y in &mut y {
            let input = *y;
            *y = (c * c * (input + 2.0 * x1 + x2) - 2.0 * (c * c - 1.0) * y1 - (1.0 - k * c + c * c) * y2) / d;
            (x2, x1, y2, y1) = (x1, input, y1, *y);
        }
    }
    y
}

fn each_order() -> std::ops::RangeInclusive<usize> {
    1..=HIGHEST_ORDER
}

#[test]
fn at_a_constant_step_every_order_is_the_butterworth_filter() {
    let (dt, x) = (0.01, noise(11, 3000, 1.0));
    for order in each_order() {
        for cutoff in [1.0, 10.0, 45.0] {
            let expected = difference_equations(order, cutoff, dt, &x);
            for (k, (y, expected)) in filtered::<f64>(order, cutoff, at(dt, &x)).iter().zip(&expected).enumerate() {
                // Near Nyquist (1 − k c + c²)/d and its neighbours cancel: epsilon · c², c = 6.3, times ten of signal and the
                // 1/(k c) samples that an error stays; at the lowest cut-off 1/c² = 1000.
                assert!((y - expected).abs() < 1e-10, "order {order}, {cutoff} Hz: {:e} at {k}", y - expected);
            }
        }
    }
}

#[test]
fn a_constant_passes_every_order_unchanged_at_steps_of_any_length() {
    let mut random = Random(12);
    for order in each_order() {
        let cutoff = random.spread(-3.0, 3.0).abs();
        let steps: Vec<_> = (0..500).map(|_| (7.25, random.spread(-6.0, 3.0).abs())).collect();
        assert!(filtered::<f64>(order, cutoff, steps.clone()).iter().all(|&y| y == 7.25));
        assert!(filtered::<f32>(order, cutoff, steps).iter().all(|&y| y == 7.25));
    }
}

#[test]
fn the_first_order_does_not_overshoot() {
    // Up to a quarter of the rate its pole, (1 − g)/(1 + g), is positive.
    for cutoff in [0.1, 1.0, 10.0, 25.0] {
        let y = filtered::<f64>(1, cutoff, (0..5000).map(|k| (f64::from(u8::from(k > 0)), 0.01)));
        assert!(y.windows(2).all(|pair| pair[0] <= pair[1]), "{cutoff} Hz");
        assert!(y.iter().all(|&y| y <= 1.0), "{cutoff} Hz");
        assert!((y[y.len() - 1] - 1.0).abs() < 1e-12, "{cutoff} Hz");
    }
}

#[test]
fn a_sample_that_is_none_holds_the_output_and_its_time_counts() {
    let mut random = Random(13);
    for order in each_order() {
        let mut gappy = Butterworth::<f64, 3>::new(order, 5.0).unwrap();
        let mut whole = gappy.clone();
        let mut elapsed = 0.0;
        let mut last = [f64::NAN; 3];
        for _ in 0..500 {
            let (v, dt) = (random.normal3(), [0.004, 0.01, 0.0, 0.05][random.below(4)]);
            elapsed += dt;
            if random.chance(0.4) {
                // Any one component is enough.
                let mut broken = v;
                broken[random.below(3)] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200][random.below(4)];
                let held = gappy.step_vector(Vec3::of(broken), dt);
                assert_eq!([held.x, held.y, held.z].map(f64::to_bits), last.map(f64::to_bits));
            } else {
                let y = gappy.step_vector(Vec3::of(v), dt);
                assert_eq!(y, whole.step_vector(Vec3::of(v), elapsed), "order {order}");
                (last, elapsed) = ([y.x, y.y, y.z], 0.0);
            }
        }
    }
}

#[test]
fn before_the_first_measurement_there_is_no_output() {
    let y = filtered::<f32>(4, 5.0, [(f64::NAN, 0.01), (f64::NAN, 0.01), (3.0, 0.01), (f64::NAN, 0.01)]);
    assert!(y[0].is_nan() && y[1].is_nan());
    assert_eq!(y[2..], [3.0, 3.0], "the first measurement is what it starts at rest at");
}

#[test]
fn a_step_of_no_length_changes_no_output() {
    let x = noise(14, 200, 1.0);
    for order in each_order() {
        let mut low_pass = Butterworth::<f64>::new(order, 5.0).unwrap();
        for &x in &x {
            let y = low_pass.step(x, 0.01);
            for dt in [0.0, -0.01, f64::NAN] {
                assert_eq!(low_pass.clone().step(x + 3.0, dt), y, "order {order}, dt {dt}");
            }
        }
    }
}

#[test]
fn a_cut_off_at_or_above_the_nyquist_frequency_passes_through_and_starts_afresh() {
    let x = noise(15, 50, 1.0);
    for order in each_order() {
        for (cutoff, dt) in [(50.0, 0.01), (51.0, 0.01), (1e300, 1e300), (5.0, f64::INFINITY)] {
            assert_eq!(filtered::<f64>(order, cutoff, at(dt, &x)), x, "order {order}");
        }
        let after_a_gap = filtered::<f64>(order, 5.0, at(0.01, &[0.0; 50]).chain([(7.0, 0.1)]).chain(at(0.01, &x)));
        let afresh = filtered::<f64>(order, 5.0, [(7.0, 0.01)].into_iter().chain(at(0.01, &x)));
        assert_eq!(after_a_gap[50..], afresh, "order {order}");
    }
    // Just below: rounding decides, and every way it does the output stays within the signal's size.
    for ulps in -40_i32..=40 {
        for order in each_order() {
            let cutoff = f64::from(f32::from_bits(50.0_f32.to_bits().wrapping_add_signed(ulps)));
            let y = filtered::<f32>(order, cutoff, at(0.01, &x));
            assert!(y.iter().all(|y| y.abs() < 60.0), "order {order}, {cutoff}: {y:?}");
        }
    }
}

#[test]
fn varying_steps_do_not_add_up_and_are_forgotten() {
    // The trapezoidal rule takes from the states' energy at any step, but a step near half a period of the cut-off turns the
    // sign of what is left of it, and short ones in between bring new input: it rings. Measured at most 3.2 times the signal.
    let (mut random, mut worst) = (Random(16), [0.0_f64; HIGHEST_ORDER]);
    for round in 0..160 {
        let (order, cutoff) = (1 + round % 8, 10.0_f64.powf(random.uniform(-1.0, 1.0)));
        let mut low_pass = Butterworth::<f64>::new(order, cutoff).unwrap();
        for _ in 0..2000 {
            let dt = random.spread(-4.0, 0.0).abs() * 0.5 / cutoff;
            worst[round % 8] = worst[round % 8].max(low_pass.step(random.uniform(-1.0, 1.0), dt).abs());
        }
        // 30 periods of steps that are short beside it: the slowest pair of order 8 leaves exp(−2π · 30 · 0.195) = 1e-16.
        let last = (0..600).map(|_| low_pass.step(0.0, 0.05 / cutoff).abs()).last().unwrap();
        assert!(last < 1e-9, "order {order}: {last:e} is left");
    }
    println!("{worst:?} times the signal");
    assert!(worst.iter().all(|&worst| worst < 5.0), "{worst:?}");
}

#[test]
fn single_precision_keeps_the_signal() {
    // An increment of the value below half an ulp is lost: it stalls where 2 g slope is half an ulp, and there the slope
    // k slope = x − value: off by k ulp/(4 g) a section, ulp at most 1.2e-7 of the signal, k at most 2, and rounding of ten
    // more operations. Sections that ring (order 8: k = 0.39, for 1/(2 g k) samples) hold √(1/(2gk)) such errors.
    for cutoff in [0.2, 1.0, 20.0, 90.0] {
        let (dt, x) = (0.005, noise(17, 20_000, 0.5));
        let x: Vec<_> = x.iter().map(|&x| f64::from(x as f32)).collect();
        for order in each_order() {
            let off = filtered::<f32>(order, cutoff, at(dt, &x))
                .iter()
                .zip(filtered::<f64>(order, cutoff, at(dt, &x)))
                .fold(0.0_f64, |worst, (narrow, wide)| worst.max((narrow - wide).abs()));
            let g = (PI * cutoff * dt).tan();
            let sections = order.div_ceil(2) as f64;
            let bound = 11.0 * f64::from(f32::EPSILON) * sections * (2.0 / (4.0 * g) + 10.0);
            println!("order {order}, {cutoff} Hz of 200: off by {off:e}, bound {bound:e}");
            assert!(off < bound, "order {order}, {cutoff} Hz: {off:e}");
        }
    }
}

#[test]
fn lanes_have_the_bits_of_the_scalar_and_a_masked_lane_stands_still() {
    let mut random = Random(18);
    for order in each_order() {
        let cutoffs = [5.0, 12.0];
        let mut lanes = Butterworth::<Pair<f64>, 2>::new(order, Pair(cutoffs[0], cutoffs[1])).unwrap();
        let mut alone = cutoffs.map(|cutoff| Butterworth::<f64, 2>::new(order, cutoff).unwrap());
        for _ in 0..500 {
            let dt = [random.spread(-4.0, 0.0).abs(), 0.01];
            let mut x = [[random.normal(), random.normal()], [random.normal(), random.normal()]];
            if random.chance(0.2) {
                x[random.below(2)][random.below(2)] = f64::NAN;
            }
            let valid = [random.chance(0.8), random.chance(0.5)];
            let mut mask = <Pair<f64> as Scalar>::Mask::splat(false);
            valid.iter().enumerate().for_each(|(lane, &valid)| mask.set_lane(lane, valid));
            let y = lanes.step_lanes(mask, [Pair(x[0][0], x[1][0]), Pair(x[0][1], x[1][1])], Pair(dt[0], dt[1]));
            for lane in 0..2 {
                let before = alone[lane].output();
                let expected = alone[lane].step_lanes(valid[lane], x[lane], dt[lane]);
                for (y, (expected, before)) in y.iter().zip(expected.iter().zip(&before)) {
                    assert_eq!(y.lane(lane).to_bits(), expected.to_bits(), "order {order}");
                    assert!(valid[lane] || expected.to_bits() == before.to_bits());
                }
            }
        }
    }
}

#[test]
fn a_snapshot_is_all_that_the_next_sample_depends_on() {
    let mut random = Random(19);
    for order in each_order() {
        let mut first = Butterworth::<f32, 2>::new(order, 3.0).unwrap();
        let sample = |random: &mut Random| {
            let x = if random.chance(0.1) { f32::NAN } else { random.normal() as f32 };
            ([x, random.normal() as f32], random.uniform(0.0, 0.02) as f32)
        };
        for _ in 0..100 {
            let (x, dt) = sample(&mut random);
            first.step_lanes(true, x, dt);
        }
        let mut variables = Vec::new();
        first.each(&mut |variable| variables.push(*variable));
        let mut second = Butterworth::<f32, 2>::new(order, 3.0).unwrap();
        let mut saved = variables.into_iter();
        second.each(&mut |variable| *variable = saved.next().unwrap());
        assert_eq!(saved.next(), None);
        for _ in 0..100 {
            let (x, dt) = sample(&mut random);
            assert_eq!(first.step_lanes(true, x, dt), second.step_lanes(true, x, dt));
        }
        first.reset();
        assert_eq!(first.step_lanes(true, [1.0, 2.0], 0.01), [1.0, 2.0], "after a reset the next sample is the first");
    }
}

#[test]
fn nothing_poisons_it() {
    fn all<T: Real>() {
        let extremes = [0.0, -0.0, 1.0, -1.0, T::MIN_NORMAL.to_f64(), 1e-320, 1e19, -1e19, 1e154, T::MAX.to_f64()];
        let others = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        let mut random = Random(20);
        for order in each_order() {
            for cutoff in [T::MIN_NORMAL.to_f64(), 1e-6, 1.0, 1e6, T::MAX.to_f64()] {
                let mut low_pass = Butterworth::<T>::new(order, T::from_f64(cutoff)).unwrap();
                let mut started = false;
                for _ in 0..2000 {
                    let mut any = |plain: f64| match random.below(8) {
                        0 => others[random.below(3)],
                        1..4 => extremes[random.below(extremes.len())],
                        _ => plain,
                    };
                    let (x, dt) = (any(0.7), any(0.3 / cutoff));
                    let y = low_pass.step(T::from_f64(x), T::from_f64(dt));
                    started |= !y.to_f64().is_nan();
                    assert!(!started || y.to_f64().is_finite(), "order {order}, {cutoff} Hz: {y:?} after {x}, {dt}");
                    low_pass.each(&mut |variable| assert!(variable.to_f64().is_finite()));
                }
                assert!(started);
            }
        }
    }
    all::<f32>();
    all::<f64>();
}

#[test]
fn what_no_filter_can_be_made_of_is_refused() {
    for order in [0, 9, usize::MAX] {
        assert_eq!(Butterworth::<f32>::new(order, 1.0).err(), Some(DesignError::Order(order)));
    }
    for cutoff in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(Butterworth::<f64>::new(4, cutoff).err(), Some(DesignError::Cutoff(cutoff)));
        assert_eq!(Butterworth::<Pair<f64>>::new(4, Pair(1.0, cutoff)).err(), Some(DesignError::Cutoff(cutoff)));
    }
    let error = Butterworth::<f64>::new(4, f64::NAN).err().unwrap();
    assert_eq!(error.to_string(), "cutoff must be a positive, finite number of Hz, got NaN");
    assert_eq!(DesignError::Order(9).to_string(), "order must be in [1, 8], got 9");
}
