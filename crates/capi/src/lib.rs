//! The filters of `ahrs-rs` for C, in `f32`: state in memory of the caller, no allocation, return codes, no panics.
//!
//! One interface of a few functions for all filters. What a filter is stands in a constant of its own (`ahrs_Madgwick`), which
//! is named once, at [`ahrs_init`]: so another filter is another name, and the linker leaves out those that nobody names.
//! `include/ahrs_rs.h` is made from this file and from the registry; see `tests/header.rs`.

#![no_std]
#![allow(unsafe_code, reason = "C hands over pointers; each function says what it asks of them")]

#[cfg(feature = "std")]
extern crate std;

mod filter;

use core::ffi::c_void;
use core::slice;

use ahrs_rs::{Frame, GyrHold, Quat, Repeated, Settings, Vec3};

use filter::Head;
pub use filter::{AhrsFilter, FILTERS};

/// Done.
pub const AHRS_OK: i32 = 0;
/// A pointer is NULL that must not be.
pub const AHRS_NULL: i32 = -1;
/// The memory is too small, or not aligned to 8 bytes.
pub const AHRS_MEMORY: i32 = -2;
/// There is no filter in the memory: ahrs_init has not been called, or has refused.
pub const AHRS_NO_FILTER: i32 = -3;
/// A setting is none of its constants, or not finite.
pub const AHRS_SETTING: i32 = -4;
/// There are more values than parameters.
pub const AHRS_TOO_MANY: i32 = -5;
/// A parameter is out of its range: this less its index, so −1002 for the third.
pub const AHRS_PARAMETER: i32 = -1000;

/// x east, y north, z up.
pub const AHRS_ENU: u8 = 0;
/// x north, y east, z down.
pub const AHRS_NED: u8 = 1;
/// x north, y west, z up.
pub const AHRS_NWU: u8 = 2;

/// The angular rate of a sample holds over the whole step that ends with it.
pub const AHRS_ZERO_ORDER: u8 = 0;
/// The angular rate over a step is the mean of those at both ends.
pub const AHRS_LINEAR: u8 = 1;

/// A repeated row is a measurement as any other.
pub const AHRS_NEW: u8 = 0;
/// A repeated row is none, while the gyroscope's differs, for 1 s at most.
pub const AHRS_MISSING: u8 = 1;

/// There was no usable accelerometer sample.
pub const AHRS_ACC_MISSING: u16 = 1;
/// There was no usable magnetometer sample.
pub const AHRS_MAG_MISSING: u16 = 2;
/// There was no usable gyroscope sample: the last angular rate was held.
pub const AHRS_GYR_HELD: u16 = 4;
/// The filter did not trust the accelerometer.
pub const AHRS_ACC_REJECTED: u16 = 8;
/// The filter did not trust the magnetometer.
pub const AHRS_MAG_REJECTED: u16 = 16;
/// The sensor rests.
pub const AHRS_REST: u16 = 32;
/// No accelerometer sample has come yet.
pub const AHRS_NOT_ALIGNED: u16 = 64;
/// The filter recovers from a long rejection, or from a rotation that was lost.
pub const AHRS_RECOVERING: u16 = 128;
/// The step was much longer than usual.
pub const AHRS_GAP: u16 = 256;
/// A row repeats its sensor's last one and was taken for missing, as the settings ask.
pub const AHRS_REPEATED: u16 = 512;

/// What is chosen beside a filter's own parameters. All zero is the default.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct AhrsSettings {
    /// Magnetic declination in rad, positive east.
    pub declination: f32,
    /// The earth frame of the quaternions: AHRS_ENU, AHRS_NED or AHRS_NWU.
    pub frame: u8,
    /// How the angular rate runs between samples: AHRS_ZERO_ORDER or AHRS_LINEAR.
    pub gyr_hold: u8,
    /// What a row is that repeats its sensor's last one: AHRS_NEW or AHRS_MISSING.
    pub repeated: u8,
    /// The largest rate in rad/s that an axis of the gyroscope shows: what is beyond it is lost. 0 where it is not known.
    pub gyr_range: f32,
}

impl AhrsSettings {
    /// The settings, without the numbers; `None` where one is not allowed.
    fn read(self) -> Option<Settings> {
        let &(_, frame) = Frame::ALL.get(usize::from(self.frame))?;
        let &(_, gyr_hold) = GyrHold::ALL.get(usize::from(self.gyr_hold))?;
        let &(_, repeated) = Repeated::ALL.get(usize::from(self.repeated))?;
        let allowed = self.declination.is_finite() && self.gyr_range.is_finite() && self.gyr_range >= 0.0;
        allowed.then_some(Settings { frame, gyr_hold, repeated, ..Settings::default() })
    }
}

/// How many bytes a filter needs on this machine; never more than the header's constant for it. 0 for NULL.
///
/// # Safety
///
/// `filter` is NULL or one of the filters of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ahrs_size(filter: *const AhrsFilter) -> usize {
    // SAFETY: as the caller promises.
    unsafe { filter.as_ref() }.map_or(0, |filter| filter.size)
}

/// Makes a filter in `memory` of `size` bytes, aligned to 8: an object of the filter's type in the header is just that. It
/// may be called again to start anew.
///
/// `values` are the first `count` parameters in the header's order, the others have their defaults; NULL with 0 for all of
/// them. `settings` may be NULL for the defaults.
///
/// # Safety
///
/// Pointers are NULL or valid: `memory` for writing `size` bytes, `values` for reading `count` numbers; `filter` is one of the
/// filters of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ahrs_init(
    memory: *mut c_void,
    size: usize,
    filter: *const AhrsFilter,
    values: *const f32,
    count: usize,
    settings: *const AhrsSettings,
) -> i32 {
    // SAFETY: as the caller promises.
    let (filter, settings) = unsafe { (filter.as_ref(), settings.as_ref()) };
    let Some(filter) = filter else { return AHRS_NULL };
    if memory.is_null() || (values.is_null() && count > 0) {
        return AHRS_NULL;
    }
    if size < filter.size || !memory.addr().is_multiple_of(8) {
        return AHRS_MEMORY;
    }
    // SAFETY: the memory is large enough for a filter, and so for its head. What stood there is no filter any more.
    unsafe { memory.cast::<Head>().write(None) };
    let given = settings.copied().unwrap_or_default();
    let Some(settings) = given.read() else { return AHRS_SETTING };
    let values = match count {
        0 => &[],
        // SAFETY: as the caller promises.
        _ => unsafe { slice::from_raw_parts(values, count) },
    };
    // SAFETY: the memory is large enough and aligned.
    unsafe { (filter.init)(memory, values, settings, &given) }
}

/// The filter in a memory.
///
/// # Safety
///
/// `memory` is NULL, or was given to `ahrs_init`, or is zero.
unsafe fn filter_in(memory: *const c_void) -> Result<&'static AhrsFilter, i32> {
    if memory.is_null() {
        return Err(AHRS_NULL);
    }
    // SAFETY: a filter begins with its head, as `ahrs_init` wrote it; zero is none.
    unsafe { memory.cast::<Head>().read() }.ok_or(AHRS_NO_FILTER)
}

/// Sets the attitude one step before the first sample: scalar first, from the sensor's frame to the chosen earth frame.
/// Without it the first samples give the attitude.
///
/// # Safety
///
/// `memory` was given to `ahrs_init`, or is zero; `quat` has four numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ahrs_start_from(memory: *mut c_void, quat: *const f32) -> i32 {
    // SAFETY: as the caller promises.
    let (filter, quat) = unsafe { (filter_in(memory), quat.cast::<[f32; 4]>().as_ref()) };
    match (filter, quat) {
        (Err(error), _) => error,
        (_, None) => AHRS_NULL,
        (Ok(filter), Some(&[w, x, y, z])) => {
            // SAFETY: it is this filter's memory.
            unsafe { (filter.start_from)(memory, Quat::new(w, x, y, z)) };
            AHRS_OK
        }
    }
}

/// Goes on by `dt` seconds to a new sample and writes the attitude: scalar first, from the sensor's frame to the chosen earth
/// frame.
///
/// `gyr` in rad/s, `acc` (specific force) in m/s², `mag` in any unit, three numbers each in one right-handed frame. NULL, or
/// a NaN in it, is a sensor that has nothing new: a magnetometer that is slower, a sensor that is not there. `quat` has room
/// for four numbers, or is NULL.
///
/// # Safety
///
/// `memory` was given to `ahrs_init`, or is zero; the other pointers are NULL or valid for as many numbers as said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ahrs_update(
    memory: *mut c_void,
    gyr: *const f32,
    acc: *const f32,
    mag: *const f32,
    dt: f32,
    quat: *mut f32,
) -> i32 {
    // SAFETY: as the caller promises.
    let (filter, gyr, acc, mag) = unsafe { (filter_in(memory), vector(gyr), vector(acc), vector(mag)) };
    let filter = match filter {
        Ok(filter) => filter,
        Err(error) => return error,
    };
    let gyr = gyr.unwrap_or(Vec3 { x: f32::NAN, y: f32::NAN, z: f32::NAN });
    // SAFETY: it is this filter's memory.
    let q = unsafe { (filter.update)(memory, gyr, acc, mag, dt) };
    // SAFETY: as the caller promises.
    if let Some(quat) = unsafe { quat.cast::<[f32; 4]>().as_mut() } {
        *quat = [q.w, q.x, q.y, q.z];
    }
    AHRS_OK
}

/// The vector at an address, if there is one.
///
/// # Safety
///
/// The address is NULL or valid for reading three numbers.
unsafe fn vector(address: *const f32) -> Option<Vec3<f32>> {
    // SAFETY: as the caller promises.
    unsafe { address.cast::<[f32; 3]>().as_ref() }.map(|&[x, y, z]| Vec3 { x, y, z })
}

/// Writes the last attitude; before the first sample the given one, or the earth frame's identity.
///
/// # Safety
///
/// `memory` was given to `ahrs_init`, or is zero; `quat` is NULL or has room for four numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ahrs_quat(memory: *const c_void, quat: *mut f32) -> i32 {
    // SAFETY: as the caller promises.
    let (filter, quat) = unsafe { (filter_in(memory), quat.cast::<[f32; 4]>().as_mut()) };
    match (filter, quat) {
        (Err(error), _) => error,
        (_, None) => AHRS_NULL,
        (Ok(filter), Some(quat)) => {
            // SAFETY: it is this filter's memory.
            let q = unsafe { (filter.quat)(memory) };
            *quat = [q.w, q.x, q.y, q.z];
            AHRS_OK
        }
    }
}

/// Writes the estimated bias of the gyroscope in rad/s; zero for a filter that estimates none.
///
/// # Safety
///
/// `memory` was given to `ahrs_init`, or is zero; `bias` is NULL or has room for three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ahrs_gyr_bias(memory: *const c_void, bias: *mut f32) -> i32 {
    // SAFETY: as the caller promises.
    let (filter, bias) = unsafe { (filter_in(memory), bias.cast::<[f32; 3]>().as_mut()) };
    match (filter, bias) {
        (Err(error), _) => error,
        (_, None) => AHRS_NULL,
        (Ok(filter), Some(bias)) => {
            // SAFETY: it is this filter's memory.
            let b = unsafe { (filter.gyr_bias)(memory) };
            *bias = [b.x, b.y, b.z];
            AHRS_OK
        }
    }
}

/// What the last update says beside the attitude: the sum of AHRS_ACC_MISSING and the constants after it, or a negative error.
/// 0 before the first update.
///
/// # Safety
///
/// `memory` was given to `ahrs_init`, or is zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ahrs_status(memory: *const c_void) -> i32 {
    // SAFETY: as the caller promises.
    match unsafe { filter_in(memory) } {
        Err(error) => error,
        // SAFETY: it is this filter's memory.
        Ok(filter) => i32::from(unsafe { (filter.status)(memory) }),
    }
}

/// Nothing here panics; the compiler asks for it all the same.
#[cfg(not(feature = "std"))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    #[allow(clippy::empty_loop, reason = "there is nobody to tell")]
    loop {}
}
