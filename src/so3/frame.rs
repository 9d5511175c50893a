//! The earth frames in which an attitude can be given.

use super::Quat;
use crate::scalar::Scalar;

/// The axes of the earth frame. Filters compute in [`Frame::Enu`]; the frame turns only what goes in and out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Frame {
    /// x east, y north, z up (ROS REP 103).
    #[default]
    Enu,
    /// x north, y east, z down.
    Ned,
    /// x north, y west, z up.
    Nwu,
}

impl Frame {
    /// Every frame with its name.
    pub const ALL: [(&'static str, Frame); 3] = [("ENU", Frame::Enu), ("NED", Frame::Ned), ("NWU", Frame::Nwu)];

    /// The frame of a name, or `None`.
    pub fn from_name(name: &str) -> Option<Frame> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|&(_, frame)| frame)
    }

    /// The rotation c that takes vectors from east-north-up to this frame: an attitude q of ENU is c ⊗ q here.
    pub fn from_enu<S: Scalar>(self) -> Quat<S> {
        const H: f64 = core::f64::consts::FRAC_1_SQRT_2;
        Quat::of(match self {
            Frame::Enu => [1.0, 0.0, 0.0, 0.0],
            Frame::Ned => [0.0, H, H, 0.0],
            Frame::Nwu => [H, 0.0, 0.0, -H],
        })
    }
}
