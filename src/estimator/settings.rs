//! What the user chooses beside a filter's own parameters.

use crate::so3::Frame;

/// How the angular rate runs between two samples of the gyroscope.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GyrHold {
    /// The rate of a sample held over the whole step that ends with it.
    #[default]
    ZeroOrder,
    /// The mean of the rates at both ends of the step.
    Linear,
}

impl GyrHold {
    /// Every rule with its name.
    pub const ALL: [(&'static str, GyrHold); 2] = [("zero-order", GyrHold::ZeroOrder), ("linear", GyrHold::Linear)];

    /// The rule of a name, or `None`.
    pub fn from_name(name: &str) -> Option<GyrHold> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|&(_, hold)| hold)
    }
}

/// What a row of the accelerometer or magnetometer is that repeats the sensor's last one bit for bit, while the gyroscope's
/// row does not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Repeated {
    /// A measurement as any other.
    #[default]
    New,
    /// No measurement: the logger repeats the last row of a slower sensor. For 1 s at most: a sensor that says the same for
    /// longer is one.
    Missing,
}

impl Repeated {
    /// Every rule with its name.
    pub const ALL: [(&'static str, Repeated); 2] = [("new", Repeated::New), ("missing", Repeated::Missing)];

    /// The rule of a name, or `None`.
    pub fn from_name(name: &str) -> Option<Repeated> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|&(_, rule)| rule)
    }
}

/// What the user chooses beside a filter's own parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// The earth frame of the output.
    pub frame: Frame,
    /// Magnetic declination in rad, positive east.
    pub declination: f64,
    /// How the angular rate runs between samples.
    pub gyr_hold: GyrHold,
    /// What a repeated row is.
    pub repeated: Repeated,
    /// The largest angular rate in rad/s that an axis of the gyroscope shows: what is beyond it is lost. Zero where it is not
    /// known.
    pub gyr_range: f64,
}
