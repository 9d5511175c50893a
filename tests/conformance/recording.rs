//! Recordings of a sensor that turns about, with known attitude, and rows that are no measurement.

use ahrs_rs::so3::rotate_by;
use ahrs_rs::{Quat, Vec3};

use crate::bank::Row;
use crate::random::Random;

pub const GRAVITY: [f64; 3] = [0.0, 0.0, 9.80665];
/// Magnetic north is on y; the field dips by 66°.
pub const FIELD: [f64; 3] = [0.0, 20.0, -45.0];

const NAN3: [f64; 3] = [f64::NAN; 3];

/// Rows that are no measurement: NaN in one place or all, zero, and squares that overflow or vanish, in `f32` too.
pub const NO_MEASUREMENT: [[f64; 3]; 9] = [
    NAN3,
    [1.0, f64::NAN, 2.0],
    [0.0; 3],
    [-0.0, 0.0, -0.0],
    [1e200, 0.0, 0.0],
    [0.0, 1e-170, 0.0],
    [0.0, 1.2e-154, 0.0],
    [f64::INFINITY, 0.0, 1.0],
    [5e-324, 0.0, -5e-324],
];

/// An angular rate that cannot be used: these are not finite or beyond what turns.
pub const NO_RATE: [[f64; 3]; 4] = [NAN3, [0.1, f64::NAN, 0.0], [1e200, 0.0, 0.0], [0.0, 0.0, f64::NEG_INFINITY]];

pub fn quat(q: [f64; 4]) -> Quat<f64> {
    Quat::of(q)
}

pub fn array(v: Vec3<f64>) -> [f64; 3] {
    [v.x, v.y, v.z]
}

/// A vector of the earth as the sensor at attitude `q` sees it.
pub fn seen(q: Quat<f64>, v: [f64; 3]) -> [f64; 3] {
    array(q.conj().rotate(Vec3::of(v)))
}

/// Rows of a sensor that turns at up to some 3 rad/s, with noise, at about 100 Hz.
pub fn moving(seed: u64, samples: usize) -> Vec<Row> {
    let mut random = Random(seed);
    let mut q = quat(random.rotation());
    let speeds = random.normal3();
    let phases = random.normal3();
    let mut time = 0.0;
    (0..samples)
        .map(|_| {
            let dt = 0.01 * random.uniform(0.9, 1.1);
            time += dt;
            let rate = [0, 1, 2].map(|k| 2.0 * speeds[k] * (1.3 * time * speeds[2 - k] + phases[k]).sin());
            q = rotate_by(q, Vec3::of(rate), dt);
            let mut noisy = |v: [f64; 3], size: f64| v.map(|c| c + size * random.normal());
            let (acc, mag) = (noisy(seen(q, GRAVITY), 0.3), noisy(seen(q, FIELD), 0.5));
            Row { gyr: noisy(rate, 0.01).map(|c| c + 0.02), acc, mag, dt }
        })
        .collect()
}

/// The same with rows that are no measurement, repeated stamps, gaps, and vectors along the axes with zeros of both
/// signs.
pub fn broken(seed: u64, samples: usize) -> Vec<Row> {
    let mut random = Random(seed ^ 0xabcd);
    let mut rows = moving(seed, samples);
    for row in &mut rows {
        for v in [&mut row.acc, &mut row.mag] {
            if random.chance(0.25) {
                *v = NO_MEASUREMENT[random.below(NO_MEASUREMENT.len())];
            } else if random.chance(0.1) {
                *v = [0.0, -0.0, [9.8, -9.8][random.below(2)]];
            }
        }
        row.gyr = match random.below(10) {
            0 => NO_RATE[random.below(NO_RATE.len())],
            // Beyond π/4 a step, where the exponential is computed another way.
            1 => row.gyr.map(|c| 200.0 * c),
            _ => row.gyr,
        };
        if random.chance(0.1) {
            row.dt = [0.0, 1.5, 1e-9, 1e7][random.below(4)];
        }
    }
    rows
}

/// The largest difference of components, of either sign of the quaternion.
pub fn distance(a: Quat<f64>, b: Quat<f64>) -> f64 {
    let largest = |q: Quat<f64>| [q.w, q.x, q.y, q.z].iter().fold(0.0_f64, |worst, c| worst.max(c.abs()));
    largest(a.plus(-b)).min(largest(a.plus(b)))
}

/// Rows of a sensor that lies still at the attitude `q`.
pub fn still(q: Quat<f64>, samples: usize) -> Vec<Row> {
    vec![Row { gyr: [0.0; 3], acc: seen(q, GRAVITY), mag: seen(q, FIELD), dt: 0.01 }; samples]
}
