//! Every filter over registers of AVX2, in `f32`.

/// Without these registers there is nothing to make.
#[cfg(not(target_arch = "x86_64"))]
pub static BANKS: &[ahrs_rs_lanes::BankCtor<f32>] = &[];

#[cfg(target_arch = "x86_64")]
mod banks {
    use ahrs_rs_lanes::BankCtor;
    use ahrs_rs_lanes::bank::bank;
    use ahrs_rs_lanes::simd::{Avx2, Instructions};

    type Register = <Avx2 as Instructions<f32>>::Vector;

    macro_rules! banks {
        ($($filter:path),+) => {
            /// The constructors, in the order of the registry.
            pub static BANKS: &[BankCtor<f32>] = &[$({
                use $filter as F;
                |sets, settings| Some(bank::<_, _, F<Register>>(Avx2::detect()?, sets, settings))
            }),+];
        };
    }
    ahrs_rs::for_each_filter!(banks);
}

#[cfg(target_arch = "x86_64")]
pub use banks::BANKS;
