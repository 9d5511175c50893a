//! The way of a row from the sensors' drivers to the filter: calibration, then a low-pass filter.

use ahrs_rs::signal::{Butterworth, DesignError};
use ahrs_rs::{Calibration, Vec3};

use crate::recording::Row;

/// Where gyroscope and accelerometer are cut off, in Hz, and the order of the filter.
const CUTOFF: f32 = 20.0;
const ORDER: usize = 2;

// Constants of the form that the Python package writes from a fit.
const GYR: Calibration<f32> = Calibration {
    matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    offset: Vec3 { x: 0.008, y: -0.005, z: 0.003 },
};
const ACC: Calibration<f32> = Calibration {
    matrix: [[1.002, 0.001, 0.0], [0.001, 0.997, -0.002], [0.0, -0.002, 1.001]],
    offset: Vec3 { x: 0.02, y: -0.03, z: 0.05 },
};
const MAG: Calibration<f32> = Calibration {
    matrix: [[1.01, 0.004, -0.002], [0.004, 0.98, 0.003], [-0.002, 0.003, 1.02]],
    offset: Vec3 { x: 14.0, y: -22.0, z: 31.0 },
};

/// What stands between drivers and filter.
#[derive(Clone, Debug)]
pub struct Pipeline {
    gyr: Butterworth<f32, 3>,
    acc: Butterworth<f32, 3>,
}

impl Pipeline {
    /// Before the first row.
    pub fn new() -> Result<Self, DesignError> {
        Ok(Pipeline { gyr: Butterworth::new(ORDER, CUTOFF)?, acc: Butterworth::new(ORDER, CUTOFF)? })
    }

    /// The row as the filter gets it. What is missing stays missing: the low-pass filters count its time.
    pub fn prepare(&mut self, row: &Row) -> Row {
        let (gyr, acc) = (GYR.apply(row.gyr), ACC.apply(row.acc));
        let missing = |v: Vec3<f32>| v.x.is_nan();
        let (low_gyr, low_acc) = (self.gyr.step_vector(gyr, row.dt), self.acc.step_vector(acc, row.dt));
        Row {
            gyr: if missing(gyr) { gyr } else { low_gyr },
            acc: if missing(acc) { acc } else { low_acc },
            mag: MAG.apply(row.mag),
            dt: row.dt,
        }
    }
}
