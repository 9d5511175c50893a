//! Calibrations on every kind of scalar, and the constants that the Python package writes.

#![allow(clippy::indexing_slicing, clippy::unwrap_used, reason = "a test that fails may panic")]
#![allow(clippy::float_cmp, reason = "where a law is exact it is tested exactly")]
#![allow(missing_docs, reason = "the written constants are described")]

#[path = "support/random.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod random;

/// What `to_rust` writes; tests/python/test_calibration_file.py checks that it still does.
#[path = "calibration/written.rs"]
#[rustfmt::skip]
mod written;

use ahrs_rs::calibration::Linear;
use ahrs_rs::{Calibration, Pair, Real, Scalar, TemperatureCalibration, Vec3};
use random::Random;

fn row(random: &mut Random) -> [f64; 3] {
    random.normal3()
}

fn lines(random: &mut Random) -> [[f64; 3]; 4] {
    let [slope, bias_slope, bias] = [row(random), row(random), row(random)];
    [slope.map(|a| 1e-3 * a), [0.9, 1.0, 1.1], bias_slope.map(|a| 1e-2 * a), bias]
}

fn over_temperature<S: Scalar>([gain_slope, gain, bias_slope, bias]: [[f64; 3]; 4]) -> TemperatureCalibration<S> {
    TemperatureCalibration { gain: Linear::of(gain_slope, gain), bias: Linear::of(bias_slope, bias) }
}

/// y = S (x − b) by its definition, in the order of the operations.
fn by_hand<T: Real>(matrix: [[f64; 3]; 3], offset: [f64; 3], x: [f64; 3]) -> [T; 3] {
    let t = T::from_f64;
    let d = [0, 1, 2].map(|i| t(x[i]) - t(offset[i]));
    matrix.map(|m| (t(m[0]) * d[0] + t(m[1]) * d[1]) + t(m[2]) * d[2])
}

fn bits<T: Real>(v: Vec3<T>) -> [u64; 3] {
    [v.x, v.y, v.z].map(|c| c.to_f64().to_bits())
}

fn it_is_its_definition_in<T: Real>() {
    let mut random = Random(1);
    for _ in 0..1000 {
        let (matrix, offset, x) =
            ([row(&mut random), row(&mut random), row(&mut random)], row(&mut random), row(&mut random));
        let y = Calibration::<T>::of(matrix, offset).apply(Vec3::of(x));
        let [a, b, c] = by_hand::<T>(matrix, offset, x);
        assert_eq!(bits(y), bits(Vec3::new(a, b, c)));
    }
}

#[test]
fn a_calibration_is_y_equal_to_s_times_x_minus_b() {
    it_is_its_definition_in::<f32>();
    it_is_its_definition_in::<f64>();
}

fn lanes_have_the_bits_of_the_scalar_in<T: Real>() {
    let mut random = Random(2);
    for _ in 0..300 {
        let (matrix, offset) = ([row(&mut random), row(&mut random), row(&mut random)], row(&mut random));
        let (lines, x, t) = (lines(&mut random), [row(&mut random), row(&mut random)], [5.0, 60.0]);
        let raw = {
            let [a, b] = x.map(Vec3::<T>::of);
            Vec3::new(Pair(a.x, b.x), Pair(a.y, b.y), Pair(a.z, b.z))
        };
        let y = Calibration::<Pair<T>>::of(matrix, offset).apply(raw);
        let warm = over_temperature::<Pair<T>>(lines).apply(raw, Pair(T::from_f64(t[0]), T::from_f64(t[1])));
        for lane in 0..2 {
            let alone = |v: Vec3<Pair<T>>| Vec3::new(v.x.lane(lane), v.y.lane(lane), v.z.lane(lane));
            assert_eq!(bits(alone(y)), bits(Calibration::<T>::of(matrix, offset).apply(Vec3::of(x[lane]))));
            let expected = over_temperature::<T>(lines).apply(Vec3::of(x[lane]), T::from_f64(t[lane]));
            assert_eq!(bits(alone(warm)), bits(expected));
        }
    }
}

#[test]
fn lanes_have_the_bits_of_the_scalar() {
    lanes_have_the_bits_of_the_scalar_in::<f32>();
    lanes_have_the_bits_of_the_scalar_in::<f64>();
}

#[test]
fn the_identity_changes_no_bit_of_a_reading() {
    let mut random = Random(3);
    for _ in 0..1000 {
        let x = Vec3::new(random.spread(-30.0, 30.0), random.spread(-30.0, 30.0), random.spread(-30.0, 30.0));
        assert_eq!(Calibration::identity().apply(x), x);
    }
}

#[test]
fn a_reading_that_misses_one_axis_misses_all() {
    let calibration = Calibration::<f64>::identity();
    for axis in 0..3 {
        let mut x = [1.0, 2.0, 3.0];
        x[axis] = f64::NAN;
        let y = calibration.apply(Vec3::of(x));
        assert!(y.x.is_nan() && y.y.is_nan() && y.z.is_nan());
    }
}

#[test]
fn over_the_temperature_it_inverts_the_measurement_model() {
    // Eq 16: x = gain(T) y + bias(T). The quotient and the products round: a few epsilon of x and b over a gain near 1.
    let mut random = Random(4);
    for _ in 0..1000 {
        let [gain_slope, gain, bias_slope, bias] = lines(&mut random);
        let (temperature, y) = (random.uniform(-40.0, 85.0), row(&mut random));
        let x =
            [0, 1, 2].map(|i| (gain_slope[i] * temperature + gain[i]) * y[i] + (bias_slope[i] * temperature + bias[i]));
        let back = over_temperature::<f64>([gain_slope, gain, bias_slope, bias]).apply(Vec3::of(x), temperature);
        for (back, y) in [back.x, back.y, back.z].into_iter().zip(y) {
            assert!((back - y).abs() < 1e-14, "{back} for {y}");
        }
    }
}

#[test]
fn an_unknown_temperature_gives_no_measurement() {
    let y = over_temperature::<f64>(lines(&mut Random(5))).apply(Vec3::of([1.0, 2.0, 3.0]), f64::NAN);
    assert!(y.x.is_nan() && y.y.is_nan() && y.z.is_nan());
}

#[test]
fn the_constants_that_python_writes_compile_and_hold_its_numbers() {
    let raw = Vec3::new(30.5_f32, -12.25, 44.0);
    let expected =
        Calibration::<f32>::of([[1.1, 0.01, -0.02], [0.01, 0.9, 0.03], [-0.02, 0.03, 1.0 / 3.0]], [12.0, -3.5, 1e-5]);
    assert_eq!(written::MAG, expected);
    assert_eq!(written::MAG.apply(raw), expected.apply(raw));
    // Table 4 of Hyyti & Visala.
    let expected = TemperatureCalibration::<f32> {
        gain: Linear::of([-0.00049316, 0.00040477, 0.00102091], [1.06731340, 1.03869310, 0.98073082]),
        bias: Linear::of([-0.01551443, -0.00457992, -0.01929765], [0.99740194, 0.05868846, 0.48880423]),
    };
    assert_eq!(written::ACC, expected);
    assert_eq!(written::ACC.apply(raw, 25.0), expected.apply(raw, 25.0));
}
