//! Filters of signals: what attitude filters and the preparation of recordings share.

pub mod butterworth;
pub mod low_pass;
pub mod section;
pub mod sum;

pub use butterworth::{Butterworth, DesignError};
pub use low_pass::{Coefficients, Gain, LowPass};
pub use section::Section;
pub use sum::Sum;
