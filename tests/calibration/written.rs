//! Written by ahrs_rs from a calibration: y = S (x − b).

use ahrs_rs::calibration::Linear;
use ahrs_rs::{Calibration, TemperatureCalibration, Vec3};

/// y = (x - bias(T)) / gain(T), both slope * T + at_zero, T in deg C.
pub const ACC: TemperatureCalibration<f32> = TemperatureCalibration {
    gain: Linear {
        slope: Vec3 { x: -0.00049316, y: 0.00040477, z: 0.00102091 },
        at_zero: Vec3 { x: 1.0673134, y: 1.0386931, z: 0.98073083 },
    },
    bias: Linear {
        slope: Vec3 { x: -0.01551443, y: -0.00457992, z: -0.01929765 },
        at_zero: Vec3 { x: 0.99740195, y: 0.05868846, z: 0.48880422 },
    },
};

/// y = S (x - b).
pub const MAG: Calibration<f32> = Calibration {
    matrix: [
        [1.1, 0.01, -0.02],
        [0.01, 0.9, 0.03],
        [-0.02, 0.03, 0.33333334],
    ],
    offset: Vec3 { x: 12.0, y: -3.5, z: 1e-05 },
};
