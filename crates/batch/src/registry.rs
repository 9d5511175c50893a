//! The filters of the core's registry, each ready to be made for `f32` and `f64`.

use ahrs_rs::params::{ParamError, ParamSet};
use ahrs_rs::{Estimator, Filter, FilterSpec, Real, Settings};

use crate::stream::Stream;

type Make<T> = fn(&[f64], Settings) -> Result<Box<dyn Stream<T>>, ParamError>;

/// One filter of the registry.
pub struct Entry {
    /// Its description.
    pub spec: &'static FilterSpec,
    make_f32: Make<f32>,
    make_f64: Make<f64>,
}

/// The floating-point types in which recordings are computed.
pub trait Number: Real + Default {
    /// The name of the numpy dtype.
    const DTYPE: &'static str;
    /// A filter of this type with the values of its parameters.
    fn stream(entry: &Entry, values: &[f64], settings: Settings) -> Result<Box<dyn Stream<Self>>, ParamError>;
}

impl Number for f32 {
    const DTYPE: &'static str = "float32";
    fn stream(entry: &Entry, values: &[f64], settings: Settings) -> Result<Box<dyn Stream<f32>>, ParamError> {
        (entry.make_f32)(values, settings)
    }
}

impl Number for f64 {
    const DTYPE: &'static str = "float64";
    fn stream(entry: &Entry, values: &[f64], settings: Settings) -> Result<Box<dyn Stream<f64>>, ParamError> {
        (entry.make_f64)(values, settings)
    }
}

fn make<T: Real, F>(values: &[f64], settings: Settings) -> Result<Box<dyn Stream<T>>, ParamError>
where
    F: Filter<T> + Send + Sync + 'static,
{
    Ok(Box::new(Estimator::<T, F>::new(&F::Params::from_values(values)?, settings)))
}

macro_rules! entries {
    ($($filter:path),+) => {
        /// The filters, in the order of the registry.
        pub fn entries() -> &'static [Entry] {
            &[$({
                use $filter as F;
                Entry {
                    spec: <F<f64> as Filter<f64>>::SPEC,
                    make_f32: make::<f32, F<f32>>,
                    make_f64: make::<f64, F<f64>>,
                }
            }),+]
        }
    };
}
ahrs_rs::for_each_filter!(entries);

/// The filter of a name.
pub fn entry(name: &str) -> Option<&'static Entry> {
    entries().iter().find(|entry| entry.spec.name == name)
}
