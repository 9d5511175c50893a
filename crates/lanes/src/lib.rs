//! One filter over many recordings or parameter sets side by side, written over any vector register.
//!
//! Everything here is generic, so this crate compiles in a second; the crates below `crates/kernels` compile it for every
//! filter, each for one scalar type and one set of instructions, side by side.
//!
//! - [`simd`]: vector registers as scalars, found at run time;
//! - [`stream`]: a filter as one object that takes samples in order of time;
//! - [`bank`], [`single`]: a filter in the lanes of a register, or alone behind the same interface;
//! - [`metric`]: the errors of attitudes in lanes against a reference;
//! - [`transpose`], [`prefetch`]: how samples come into the order of lanes, and their memory into the cache.

pub mod bank;
pub mod metric;
pub mod prefetch;
pub mod simd;
pub mod single;
pub mod stream;
pub mod transpose;

use ahrs_rs::params::ParamError;
use ahrs_rs::{Real, Settings};

use bank::Bank;
use stream::Stream;

/// The floating-point types in which recordings are computed.
pub trait Number: Real + simd::Vector + Default {
    /// The name of the numpy dtype.
    const DTYPE: &'static str;
}

impl Number for f32 {
    const DTYPE: &'static str = "float32";
}

impl Number for f64 {
    const DTYPE: &'static str = "float64";
}

/// Makes a filter with the values of its parameters.
pub type StreamCtor<T> = fn(&[f64], Settings) -> Result<Box<dyn Stream<T>>, ParamError>;

/// Makes a filter in lanes, with the values of its parameters in each (choices are those of the first lane), or none where the
/// processor does not have the instructions.
pub type BankCtor<T> = fn(&[&[f64]], Settings) -> Option<Result<Box<dyn Bank<T>>, ParamError>>;

/// Whether an estimator is small enough to be copied for its steps: a copy of its own can live in registers.
const fn is_small<E, S>() -> bool {
    size_of::<E>() <= SMALL * size_of::<S>()
}

/// In numbers.
const SMALL: usize = 128;
