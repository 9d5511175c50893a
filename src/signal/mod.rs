//! Filters of signals: what attitude filters and the preparation of recordings share.

pub mod low_pass;
pub mod sum;

pub use low_pass::{Coefficients, Gain, LowPass};
pub use sum::Sum;
