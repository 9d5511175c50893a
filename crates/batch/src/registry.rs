//! The filters of the core's registry, each ready to be made for `f32` and `f64`, for one recording and in lanes.

use ahrs_rs::params::{ParamError, ParamSet};
use ahrs_rs::{Estimator, Filter, FilterSpec, Real, Settings};

use crate::bank::{Bank, bank};
#[cfg(any(test, not(target_arch = "x86_64")))]
use crate::simd::Portable;
#[cfg(target_arch = "x86_64")]
use crate::simd::{Avx2, Avx512};
use crate::simd::{Instructions, Isa, Vector};
use crate::stream::Stream;

type Make<T> = fn(&[f64], Settings) -> Result<Box<dyn Stream<T>>, ParamError>;
/// A filter in lanes, if the processor has the instructions.
pub type Made<T> = Option<Result<Box<dyn Bank<T>>, ParamError>>;
type MakeBank<T> = fn(Isa, &[&[f64]], Settings) -> Made<T>;

/// One filter of the registry.
pub struct Entry {
    /// Its description.
    pub spec: &'static FilterSpec,
    make_f32: Make<f32>,
    make_f64: Make<f64>,
    bank_f32: MakeBank<f32>,
    bank_f64: MakeBank<f64>,
}

/// The floating-point types in which recordings are computed.
pub trait Number: Real + Vector + Default {
    /// The name of the numpy dtype.
    const DTYPE: &'static str;
    /// A filter of this type with the values of its parameters.
    fn stream(entry: &Entry, values: &[f64], settings: Settings) -> Result<Box<dyn Stream<Self>>, ParamError>;
    /// The filter in lanes, with the values of its parameters in each (choices are those of the first lane), or none where
    /// the processor does not have the instructions.
    fn bank(entry: &Entry, isa: Isa, sets: &[&[f64]], settings: Settings) -> Made<Self>;
}

impl Number for f32 {
    const DTYPE: &'static str = "float32";
    fn stream(entry: &Entry, values: &[f64], settings: Settings) -> Result<Box<dyn Stream<f32>>, ParamError> {
        (entry.make_f32)(values, settings)
    }
    fn bank(entry: &Entry, isa: Isa, sets: &[&[f64]], settings: Settings) -> Made<f32> {
        (entry.bank_f32)(isa, sets, settings)
    }
}

impl Number for f64 {
    const DTYPE: &'static str = "float64";
    fn stream(entry: &Entry, values: &[f64], settings: Settings) -> Result<Box<dyn Stream<f64>>, ParamError> {
        (entry.make_f64)(values, settings)
    }
    fn bank(entry: &Entry, isa: Isa, sets: &[&[f64]], settings: Settings) -> Made<f64> {
        (entry.bank_f64)(isa, sets, settings)
    }
}

fn make<T: Real, F>(values: &[f64], settings: Settings) -> Result<Box<dyn Stream<T>>, ParamError>
where
    F: Filter<T> + Send + Sync + 'static,
{
    Ok(Box::new(Estimator::<T, F>::new(&F::Params::from_values(values)?, settings)))
}

/// A register of numbers of a type.
type Register<I, T> = <I as Instructions<T>>::Vector;

/// A function that makes a filter in lanes, if the processor has the instructions asked for.
macro_rules! make_bank {
    ($filter:ident, $real:ty) => {
        |isa, sets, settings| match isa {
            #[cfg(any(test, not(target_arch = "x86_64")))]
            Isa::Portable => Some(bank::<_, _, $filter<Register<Portable, $real>>>(Portable, sets, settings)),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => Some(bank::<_, _, $filter<Register<Avx2, $real>>>(Avx2::detect()?, sets, settings)),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => Some(bank::<_, _, $filter<Register<Avx512, $real>>>(Avx512::detect()?, sets, settings)),
        }
    };
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
                    bank_f32: make_bank!(F, f32),
                    bank_f64: make_bank!(F, f64),
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
