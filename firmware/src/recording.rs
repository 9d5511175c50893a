//! A recording that needs no memory: each row is computed from the one before.
//!
//! A sensor turns and is shaken in the earth's fields; noise is a generator of whole numbers, angles of the motion are whole
//! numbers of 2⁻³² turns, and all else is the core's arithmetic, so that every machine makes the same rows to the last bit.
//! In it are a slower magnetometer, missing rows, steps of changing length, gaps, rests and a disturbed field.

use ahrs_rs::trig::sin_cos;
use ahrs_rs::{Quat, Vec3, so3};

/// What the sensors say at one time, as the driver would give it: not calibrated. A row with a NaN is missing.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Angular rate in rad/s.
    pub gyr: Vec3<f32>,
    /// Specific force in m/s².
    pub acc: Vec3<f32>,
    /// Magnetic field in µT.
    pub mag: Vec3<f32>,
    /// The time since the row before, in s.
    pub dt: f32,
}

const MISSING: Vec3<f32> = Vec3 { x: f32::NAN, y: f32::NAN, z: f32::NAN };

/// How far the phases of motion and acceleration go in one sample of 10 ms, in 2⁻³² turns: from 0.05 to 4 Hz.
const SPEEDS: [u32; 6] = [0x0021_1e6a, 0x0053_4b1d, 0x0091_c8a3, 0x0150_77d1, 0x02b3_3c67, 0x0a3d_1f2b];

/// The rows, one after the other, for ever.
#[derive(Clone, Debug)]
pub struct Recording {
    random: u32,
    phases: [u32; 6],
    k: u32,
    q: Quat<f32>,
}

impl Default for Recording {
    fn default() -> Self {
        Recording { random: 0x2026_0801, phases: [0; 6], k: 0, q: Quat::of([0.8, 0.4, -0.2, 0.4]) }
    }
}

impl Recording {
    /// A whole number that looks random: the linear congruential generator of Numerical Recipes (Press et al., 2nd ed., 7.1).
    fn random(&mut self) -> u32 {
        self.random = self.random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.random >> 8
    }

    /// A number in [−½, ½), of 24 bits: exact in `f32`.
    #[allow(clippy::cast_precision_loss, reason = "24 bits")]
    fn uniform(&mut self) -> f32 {
        self.random() as f32 * (1.0 / 16_777_216.0) - 0.5
    }

    fn noise(&mut self, size: f32) -> Vec3<f32> {
        Vec3::new(self.uniform() * size, self.uniform() * size, self.uniform() * size)
    }

    /// True once in 2^`power` times.
    fn rarely(&mut self, power: u32) -> bool {
        self.random() >> (24 - power) == 0
    }

    /// The next row.
    #[inline(never)]
    pub fn row(&mut self) -> Row {
        let k = self.k;
        self.k = k.wrapping_add(1);
        // Ten seconds of every forty the sensor lies still; five of every forty a magnet is near.
        let rests = k & 0x0fff >= 0x0c00;
        let disturbed = k & 0x0e00 == 0x0400;
        // Whole milliseconds in binary, 8/1024 to 11/1024 s; a gap of 2 s once in a while.
        #[allow(clippy::cast_precision_loss, reason = "a small whole number")]
        let steps = if self.rarely(12) { 2048.0 } else { (8 + (self.random() >> 22)) as f32 };
        let dt = steps * (1.0 / 1024.0);

        let mut waves = [0.0; 6];
        if !rests {
            for ((wave, phase), speed) in waves.iter_mut().zip(&mut self.phases).zip(SPEEDS) {
                *phase = phase.wrapping_add(speed);
                #[allow(clippy::cast_precision_loss, reason = "24 bits")]
                let angle = (*phase >> 8) as f32 * (core::f32::consts::TAU / 16_777_216.0);
                *wave = sin_cos(angle).0;
            }
        }
        let [a, b, c, d, e, f] = waves;
        let rate = Vec3::new(1.5 * a + 0.6 * e, 1.2 * b - 0.5 * d, 0.9 * c + 0.3 * f);
        self.q = so3::rotate_by(self.q, rate, dt);
        let up = Vec3::new(0.8 * d * a, 0.7 * e, 9.81 + 0.5 * f);
        let magnet = if disturbed { Vec3::new(12.0, -9.0, 6.0) } else { Vec3::zero() };
        let field = Vec3::new(0.0, 20.0, -43.0) + magnet;

        let (gyr_noise, acc_noise, mag_noise) = (self.noise(0.004), self.noise(0.05), self.noise(0.4));
        let mut gyr = rate + Vec3::new(0.01, -0.006, 0.004) + gyr_noise;
        let mut acc = self.q.conj().rotate(up) + acc_noise;
        // Hard iron; the scale is in the calibration.
        let mut mag = self.q.conj().rotate(field) + Vec3::new(14.0, -22.0, 31.0) + mag_noise;
        if self.rarely(8) {
            gyr = MISSING;
        }
        if self.rarely(6) {
            acc = MISSING;
        }
        // A magnetometer of a quarter of the rate.
        if k & 3 != 0 || self.rarely(6) {
            mag = MISSING;
        }
        Row { gyr, acc, mag, dt }
    }
}
