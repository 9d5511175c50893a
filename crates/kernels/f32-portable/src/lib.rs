//! Every filter over pairs of numbers in ordinary registers, in `f32`.

/// Without these registers there is nothing to make.
#[cfg(not(any(feature = "force", not(target_arch = "x86_64"))))]
pub static BANKS: &[ahrs_rs_lanes::BankCtor<f32>] = &[];

#[cfg(any(feature = "force", not(target_arch = "x86_64")))]
mod banks {
    use ahrs_rs_lanes::BankCtor;
    use ahrs_rs_lanes::bank::bank;
    use ahrs_rs_lanes::simd::{Instructions, PortableIsa};

    type Register = <PortableIsa as Instructions<f32>>::Vector;

    macro_rules! banks {
        ($($filter:path),+) => {
            /// The constructors, in the order of the registry.
            pub static BANKS: &[BankCtor<f32>] = &[$({
                use $filter as F;
                |sets, settings| Some(bank::<_, _, F<Register>>(Some(PortableIsa)?, sets, settings))
            }),+];
        };
    }
    ahrs_rs::for_each_filter!(banks);
}

#[cfg(any(feature = "force", not(target_arch = "x86_64")))]
pub use banks::BANKS;
