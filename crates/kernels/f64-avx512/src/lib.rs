//! Every filter over registers of AVX-512, in `f64`.

/// Without these registers there is nothing to make.
#[cfg(not(target_arch = "x86_64"))]
pub static BANKS: &[ahrs_rs_lanes::BankCtor<f64>] = &[];

#[cfg(target_arch = "x86_64")]
mod banks {
    use ahrs_rs_lanes::BankCtor;
    use ahrs_rs_lanes::bank::bank;
    use ahrs_rs_lanes::simd::{Avx512, Instructions};

    type Register = <Avx512 as Instructions<f64>>::Vector;

    macro_rules! banks {
        ($($filter:path),+) => {
            /// The constructors, in the order of the registry.
            pub static BANKS: &[BankCtor<f64>] = &[$({
                use $filter as F;
                |sets, settings| Some(bank::<_, _, F<Register>>(Avx512::detect()?, sets, settings))
            }),+];
        };
    }
    ahrs_rs::for_each_filter!(banks);
}

#[cfg(target_arch = "x86_64")]
pub use banks::BANKS;
