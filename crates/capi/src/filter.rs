//! The filters of the registry behind functions that know a filter by its memory.

use core::ffi::c_void;

use ahrs_rs::params::ParamSet;
use ahrs_rs::{Estimator, Filter, FilterSpec, Quat, Settings, Vec3};

use crate::{AHRS_OK, AHRS_PARAMETER, AHRS_TOO_MANY, AhrsSettings};

type Update = unsafe fn(*mut c_void, Vec3<f32>, Option<Vec3<f32>>, Option<Vec3<f32>>, f32) -> Quat<f32>;

/// What a filter is: named where one is made, and nowhere else.
#[derive(Debug)]
pub struct AhrsFilter {
    /// The description.
    pub spec: fn() -> &'static FilterSpec,
    /// The bytes of its memory.
    pub size: usize,
    pub(crate) init: unsafe fn(*mut c_void, &[f32], Settings, &AhrsSettings) -> i32,
    pub(crate) start_from: unsafe fn(*mut c_void, Quat<f32>),
    pub(crate) update: Update,
    pub(crate) quat: unsafe fn(*const c_void) -> Quat<f32>,
    pub(crate) gyr_bias: unsafe fn(*const c_void) -> Vec3<f32>,
    pub(crate) status: unsafe fn(*const c_void) -> u16,
}

/// What every memory begins with: whose it is.
pub(crate) type Head = Option<&'static AhrsFilter>;

/// The memory of a filter.
#[repr(C)]
struct Instance<F> {
    head: Head,
    estimator: Estimator<f32, F>,
    status: u16,
}

/// The functions of one filter.
///
/// # Safety
///
/// Those that are not safe ask for the memory of an `Instance<F>`: aligned and large enough in `init`, made by it in the others.
impl<F: Filter<f32>> Instance<F>
where
    F::Params: Default,
{
    unsafe fn init(
        memory: *mut c_void,
        values: &[f32],
        settings: Settings,
        given: &AhrsSettings,
        whose: &'static AhrsFilter,
    ) -> i32 {
        let mut params = F::Params::default();
        if values.len() > F::SPEC.params.len() {
            return AHRS_TOO_MANY;
        }
        for ((index, &value), code) in values.iter().enumerate().zip((i32::MIN..=AHRS_PARAMETER).rev()) {
            if !params.set(index, value) {
                return code;
            }
        }
        let estimator = Estimator::without_numbers(&params, settings);
        // Numbers in `f32`, which is all that the microcontroller has a unit for.
        let estimator = estimator.with_declination(given.declination).with_gyr_range(given.gyr_range);
        // SAFETY: the caller has checked size and alignment.
        unsafe { memory.cast::<Self>().write(Instance { head: Some(whose), estimator, status: 0 }) };
        AHRS_OK
    }
    unsafe fn start_from(memory: *mut c_void, quat: Quat<f32>) {
        // SAFETY: an instance was written there.
        unsafe { &mut *memory.cast::<Self>() }.estimator.start_from(quat);
    }
    unsafe fn update(
        memory: *mut c_void,
        gyr: Vec3<f32>,
        acc: Option<Vec3<f32>>,
        mag: Option<Vec3<f32>>,
        dt: f32,
    ) -> Quat<f32> {
        // SAFETY: an instance was written there.
        let instance = unsafe { &mut *memory.cast::<Self>() };
        let output = instance.estimator.step(gyr, acc, mag, dt);
        instance.status = output.flags.bits(0);
        output.quat
    }
    unsafe fn quat(memory: *const c_void) -> Quat<f32> {
        // SAFETY: an instance was written there.
        unsafe { &*memory.cast::<Self>() }.estimator.quat()
    }
    unsafe fn gyr_bias(memory: *const c_void) -> Vec3<f32> {
        // SAFETY: an instance was written there.
        unsafe { &*memory.cast::<Self>() }.estimator.filter().gyr_bias()
    }
    unsafe fn status(memory: *const c_void) -> u16 {
        // SAFETY: an instance was written there.
        unsafe { &*memory.cast::<Self>() }.status
    }
}

macro_rules! filters {
    ($($krate:tt :: filters :: $name:ident),+) => {
        $(
            #[allow(non_upper_case_globals, reason = "the name of the filter in C is that of the registry")]
            #[unsafe(export_name = concat!("ahrs_", stringify!($name)))]
            static $name: AhrsFilter = {
                type This = Instance<$krate::filters::$name<f32>>;
                AhrsFilter {
                    spec: || <$krate::filters::$name<f32> as Filter<f32>>::SPEC,
                    size: size_of::<This>(),
                    // SAFETY: the same demands.
                    init: |memory, values, settings, given| unsafe {
                        This::init(memory, values, settings, given, &$name)
                    },
                    start_from: This::start_from,
                    update: This::update,
                    quat: This::quat,
                    gyr_bias: This::gyr_bias,
                    status: This::status,
                }
            };
        )+

        /// The filters, in the order of the registry.
        pub static FILTERS: &[&AhrsFilter] = &[$(&$name),+];
    };
}
ahrs_rs::for_each_filter!(filters);
