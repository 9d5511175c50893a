//! The filters of the core's registry, each ready to be made for `f32` and `f64`, for one recording and in lanes.

use std::sync::LazyLock;

use ahrs_rs::params::ParamError;
use ahrs_rs::{Filter, FilterSpec, Settings};
use ahrs_rs_lanes::bank::Bank;
use ahrs_rs_lanes::simd::Isa;
use ahrs_rs_lanes::stream::Stream;
use ahrs_rs_lanes::{BankCtor, StreamCtor};

/// One filter of the registry.
pub struct Entry {
    /// Its description.
    pub spec: &'static FilterSpec,
    f32: Constructors<f32>,
    f64: Constructors<f64>,
}

/// What makes a filter of one type; compiled in the kernel crates.
struct Constructors<T: 'static> {
    stream: StreamCtor<T>,
    /// In the order of [`Isa::ALL`]; none where the lanes are not compiled.
    banks: [Option<BankCtor<T>>; Isa::ALL.len()],
}

macro_rules! specs {
    ($($filter:path),+) => {
        /// The descriptions of the filters, in the order of the registry.
        static SPECS: &[&FilterSpec] = &[$({
            use $filter as F;
            <F<f64> as Filter<f64>>::SPEC
        }),+];
    };
}
ahrs_rs::for_each_filter!(specs);

/// The filters, in the order of the registry. What makes them is read from statics of the kernel crates: a constructor that was
/// named here would be compiled once more, and so would its filter in every crate into which a function of this one is inlined.
pub static ENTRIES: LazyLock<Box<[Entry]>> = LazyLock::new(|| {
    let singles = ahrs_rs_kernel_f32_scalar::STREAMS.iter().zip(ahrs_rs_kernel_f64_scalar::STREAMS);
    let entries = SPECS.iter().zip(singles).enumerate().map(|(index, (&spec, (&single_f32, &single_f64)))| Entry {
        spec,
        f32: Constructors { stream: single_f32, banks: BANKS_F32.map(|&banks| banks.get(index).copied()) },
        f64: Constructors { stream: single_f64, banks: BANKS_F64.map(|&banks| banks.get(index).copied()) },
    });
    entries.collect()
});

/// The banks over one kind of register, none where they are not compiled.
macro_rules! banks {
    ($name:ident, $feature:literal, $f32:ident, $f64:ident) => {
        mod $name {
            #[cfg(feature = $feature)]
            pub use {$f32::BANKS as F32, $f64::BANKS as F64};
            #[cfg(not(feature = $feature))]
            pub static F32: &[ahrs_rs_lanes::BankCtor<f32>] = &[];
            #[cfg(not(feature = $feature))]
            pub static F64: &[ahrs_rs_lanes::BankCtor<f64>] = &[];
        }
    };
}
banks!(avx2, "avx2", ahrs_rs_kernel_f32_avx2, ahrs_rs_kernel_f64_avx2);
banks!(avx512, "avx512", ahrs_rs_kernel_f32_avx512, ahrs_rs_kernel_f64_avx512);

/// The banks of every filter in `f32`, in the order of [`Isa::ALL`]. Where the statics are, not what they hold: a value that is
/// read while compiling names every constructor, and has all filters compiled here once more.
static BANKS_F32: [&&[BankCtor<f32>]; Isa::ALL.len()] = [&ahrs_rs_kernel_f32_portable::BANKS, &avx2::F32, &avx512::F32];

/// The same in `f64`.
static BANKS_F64: [&&[BankCtor<f64>]; Isa::ALL.len()] = [&ahrs_rs_kernel_f64_portable::BANKS, &avx2::F64, &avx512::F64];

/// The filter of a name.
pub fn entry(name: &str) -> Option<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.spec.name == name)
}

/// The floating-point types for which every filter is compiled.
pub trait Number: ahrs_rs_lanes::Number {
    /// A filter of this type with the values of its parameters.
    fn stream(entry: &Entry, values: &[f64], settings: Settings) -> Result<Box<dyn Stream<Self>>, ParamError>;
    /// The filter in lanes, as [`BankCtor`] makes it; none where the lanes are not compiled.
    fn bank(
        entry: &Entry,
        isa: Isa,
        sets: &[&[f64]],
        settings: Settings,
    ) -> Option<Result<Box<dyn Bank<Self>>, ParamError>>;
}

macro_rules! number {
    ($real:ident) => {
        impl Number for $real {
            fn stream(entry: &Entry, values: &[f64], settings: Settings) -> Result<Box<dyn Stream<$real>>, ParamError> {
                (entry.$real.stream)(values, settings)
            }
            fn bank(
                entry: &Entry,
                isa: Isa,
                sets: &[&[f64]],
                settings: Settings,
            ) -> Option<Result<Box<dyn Bank<$real>>, ParamError>> {
                let index = Isa::ALL.iter().position(|&(_, known)| known == isa)?;
                entry.$real.banks.get(index).copied()??(sets, settings)
            }
        }
    };
}
number!(f32);
number!(f64);
