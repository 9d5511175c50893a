//! What is said of one sample beside the attitude: the bits of `ahrs_rs.Status`.

use crate::scalar::Mask;

/// The accelerometer's row was unusable.
pub const ACC_MISSING: u16 = 1;
/// The magnetometer's row was unusable.
pub const MAG_MISSING: u16 = 1 << 1;
/// The gyroscope's row was unusable; the last angular rate was held.
pub const GYR_HELD: u16 = 1 << 2;
/// The filter did not trust the accelerometer.
pub const ACC_REJECTED: u16 = 1 << 3;
/// The filter did not trust the magnetometer.
pub const MAG_REJECTED: u16 = 1 << 4;
/// The sensor rests.
pub const REST: u16 = 1 << 5;
/// No accelerometer sample has come yet.
pub const NOT_ALIGNED: u16 = 1 << 6;
/// The filter recovers: from a long rejection, or from a rotation that was lost.
pub const RECOVERING: u16 = 1 << 7;
/// The step was much longer than usual: samples are missing, or the clock leapt.
pub const GAP: u16 = 1 << 8;
/// A row repeats its sensor's last one and was taken for missing, as the settings ask.
pub const REPEATED: u16 = 1 << 9;

/// The bits of a measurement that the filters take for missing: an infinite value is among them.
pub const ANY_MISSING: u16 = ACC_MISSING | MAG_MISSING | GYR_HELD;

/// Every bit with its name and what it says, in the order of the bits.
pub const ALL: [(&str, u16, &str); 10] = [
    ("ACC_MISSING", ACC_MISSING, "the accelerometer's row was unusable"),
    ("MAG_MISSING", MAG_MISSING, "the magnetometer's row was unusable"),
    ("GYR_HELD", GYR_HELD, "the gyroscope's row was unusable; the last angular rate was held"),
    ("ACC_REJECTED", ACC_REJECTED, "the filter did not trust the accelerometer"),
    ("MAG_REJECTED", MAG_REJECTED, "the filter did not trust the magnetometer"),
    ("REST", REST, "the sensor rests"),
    ("NOT_ALIGNED", NOT_ALIGNED, "no accelerometer sample has come yet"),
    ("RECOVERING", RECOVERING, "the filter recovers from a long rejection, or from a rotation that was lost"),
    ("GAP", GAP, "the step was much longer than usual: samples are missing, or the clock leapt"),
    ("REPEATED", REPEATED, "a row repeats its sensor's last one and was taken for missing, as asked"),
];

/// The bits as masks, one lane for each recording.
#[derive(Clone, Copy, Debug)]
pub struct Flags<M> {
    /// [`ACC_MISSING`].
    pub acc_missing: M,
    /// [`MAG_MISSING`].
    pub mag_missing: M,
    /// [`GYR_HELD`].
    pub gyr_held: M,
    /// [`ACC_REJECTED`].
    pub acc_rejected: M,
    /// [`MAG_REJECTED`].
    pub mag_rejected: M,
    /// [`REST`].
    pub rest: M,
    /// [`NOT_ALIGNED`].
    pub not_aligned: M,
    /// [`RECOVERING`].
    pub recovering: M,
    /// [`GAP`].
    pub gap: M,
    /// [`REPEATED`].
    pub repeated: M,
}

impl<M: Mask> Flags<M> {
    /// No bit set.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn none() -> Self {
        let no = M::splat(false);
        Flags {
            acc_missing: no,
            mag_missing: no,
            gyr_held: no,
            acc_rejected: no,
            mag_rejected: no,
            rest: no,
            not_aligned: no,
            recovering: no,
            gap: no,
            repeated: no,
        }
    }

    /// The bits of one lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn bits(&self, lane: usize) -> u16 {
        let bit = |mask: M, bit: u16| if mask.lane(lane) { bit } else { 0 };
        let missing = bit(self.acc_missing, ACC_MISSING) | bit(self.mag_missing, MAG_MISSING);
        let held = bit(self.gyr_held, GYR_HELD) | bit(self.gap, GAP) | bit(self.repeated, REPEATED);
        let rejected = bit(self.acc_rejected, ACC_REJECTED) | bit(self.mag_rejected, MAG_REJECTED);
        let state = bit(self.rest, REST) | bit(self.not_aligned, NOT_ALIGNED) | bit(self.recovering, RECOVERING);
        missing | held | rejected | state
    }

    /// Where any bit is set.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn any(&self) -> M {
        let missing = self.acc_missing | self.mag_missing | self.gyr_held | self.not_aligned;
        let filter = self.acc_rejected | self.mag_rejected | self.rest | self.recovering;
        missing | filter | self.gap | self.repeated
    }
}
