//! The filters, one file each, and the registry from which everything that treats all filters is made.

mod adaptive;
pub mod delay;
mod error_state;
mod field;
mod integration;
pub mod kalman;
mod quaternions;
pub mod rest;
mod stationary;
mod vector;

pub use integration::Integration;

/// Declares the modules of the filters, re-exports them, and defines what iterates over them.
macro_rules! registry {
    ($dollar:tt $($module:ident :: $name:ident),+ $(,)?) => {
        $(
            pub mod $module;
            pub use $module::$name;
        )+

        /// The descriptions of all filters, in the order of the registry.
        pub const SPECS: &[&crate::FilterSpec] = &[$(&$module::SPEC),+];

        /// Calls the macro `$callback` with the types of all filters, each generic over the scalar.
        #[macro_export]
        macro_rules! for_each_filter {
            ($dollar callback:ident) => {
                $dollar callback! { $($crate::filters::$name),+ }
            };
        }
    };
}

// THE registry: one line a filter.
registry! { $
    gyro_integration::GyroIntegration,
    tilt::Tilt,
    ecompass::Ecompass,
    trigonometric::Trigonometric,
    complementary::Complementary,
    linear_kalman::LinearKalman,
    mahony::Mahony,
    madgwick::Madgwick,
    ekf::EKF,
    dcm_imu::DcmImu,
    mekf::MEKF,
    vqf::VQF,
    selfcal::SelfCalKF,
    basic_vqf::BasicVQF,
    fusion::Fusion,
}
