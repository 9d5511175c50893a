//! The functions for C give the bits of the core, and refuse what they cannot take.

#![allow(unsafe_code, reason = "calls what C calls")]
#![allow(clippy::indexing_slicing, clippy::unwrap_used, reason = "a test that fails may panic")]

use std::ffi::c_void;
use std::ptr::{from_mut, from_ref, null, null_mut};

use ahrs_rs::params::{ParamKind, ParamSet};
use ahrs_rs::{Estimator, Filter, Frame, GyrHold, Quat, Repeated, Settings, Vec3};
use ahrs_rs_c::*;

/// Bytes that hold every filter: SelfCalKF in f32 takes 4.8 kB.
const MEMORY: usize = 8192;

/// Memory for any filter.
#[repr(C, align(8))]
struct Memory([u8; MEMORY]);

impl Memory {
    fn new() -> Box<Self> {
        Box::new(Memory([0; MEMORY]))
    }
    fn address(&mut self) -> *mut c_void {
        from_mut(self).cast()
    }
}

fn filter(name: &str) -> &'static AhrsFilter {
    FILTERS.iter().find(|filter| (filter.spec)().name == name).unwrap()
}

/// A sample of a sensor; `None` is one that is not given.
type Given = Option<[f32; 3]>;

/// A sensor that turns and shakes, with missing samples: rate, force, field and step.
fn row(k: u16) -> ([f32; 3], Given, Given, f32) {
    let t = 0.01 * f32::from(k);
    let gyr = [0.5 * (3.0 * t).sin(), 0.4 * (2.0 * t).cos(), if k % 17 == 5 { f32::NAN } else { 0.3 }];
    let acc = (k % 11 != 3).then(|| [0.8 * (2.5 * t).sin(), 0.6 * (1.5 * t).cos(), 9.7]);
    let mag = k.is_multiple_of(3).then(|| [4.0 * t.sin(), 20.0 * t.cos(), -43.0]);
    (gyr, acc, mag, 0.008 + 0.001 * f32::from(k % 4))
}

fn address(row: Option<&[f32; 3]>) -> *const f32 {
    row.map_or(null(), |row| row.as_ptr())
}

/// Runs a filter through both interfaces and compares all that they tell.
fn assert_the_same_bits<F: Filter<f32>>(values: &[f32], settings: AhrsSettings, q0: Option<[f32; 4]>)
where
    F::Params: Default,
{
    let name = F::SPEC.name;
    let mut params = F::Params::default();
    for (index, &value) in values.iter().enumerate() {
        assert!(params.set(index, value), "{name}: {value} as parameter {index}");
    }
    let core_settings = Settings {
        frame: Frame::ALL[usize::from(settings.frame)].1,
        declination: settings.declination.into(),
        gyr_hold: GyrHold::ALL[usize::from(settings.gyr_hold)].1,
        repeated: Repeated::ALL[usize::from(settings.repeated)].1,
        gyr_range: settings.gyr_range.into(),
    };
    let mut estimator = Estimator::<f32, F>::new(&params, core_settings);
    let mut memory = Memory::new();
    let ahrs = memory.address();
    // SAFETY: the memory is large enough, which is checked, and aligned; everything else is a reference.
    unsafe {
        let (count, settings) = (values.len(), from_ref(&settings));
        assert_eq!(ahrs_init(ahrs, MEMORY, filter(name), values.as_ptr(), count, settings), AHRS_OK, "{name}");
        if let Some([w, x, y, z]) = q0 {
            estimator.start_from(Quat::new(w, x, y, z));
            assert_eq!(ahrs_start_from(ahrs, [w, x, y, z].as_ptr()), AHRS_OK);
        }
        for k in 0..400 {
            let (gyr, acc, mag, dt) = row(k);
            let vector = |[x, y, z]: [f32; 3]| Vec3 { x, y, z };
            let expected = estimator.step(vector(gyr), acc.map(vector), mag.map(vector), dt);
            let mut quat = [0.0; 4];
            let error =
                ahrs_update(ahrs, gyr.as_ptr(), address(acc.as_ref()), address(mag.as_ref()), dt, quat.as_mut_ptr());
            assert_eq!(error, AHRS_OK);
            let q = expected.quat;
            assert_eq!(quat.map(f32::to_bits), [q.w, q.x, q.y, q.z].map(f32::to_bits), "{name}, sample {k}");
            assert_eq!(ahrs_status(ahrs), i32::from(expected.flags.bits(0)), "{name}, sample {k}");
            let (mut again, mut bias) = ([0.0; 4], [0.0; 3]);
            assert_eq!((ahrs_quat(ahrs, again.as_mut_ptr()), again), (AHRS_OK, quat));
            assert_eq!(ahrs_gyr_bias(ahrs, bias.as_mut_ptr()), AHRS_OK);
            let b = estimator.filter().gyr_bias();
            assert_eq!(bias.map(f32::to_bits), [b.x, b.y, b.z].map(f32::to_bits), "{name}, sample {k}");
        }
    }
}

macro_rules! each {
    ($($filter:path),+) => {
        #[test]
        fn every_filter_gives_the_bits_of_the_core() {
            $({
                use $filter as F;
                assert_the_same_bits::<F<f32>>(&[], AhrsSettings::default(), None);
                let settings = AhrsSettings {
                    declination: 0.1,
                    frame: AHRS_NED,
                    gyr_hold: AHRS_LINEAR,
                    repeated: AHRS_MISSING,
                    gyr_range: 4.0,
                };
                assert_the_same_bits::<F<f32>>(&[], settings, Some([0.5, -0.5, 0.5, 0.5]));
                // The last choice of each, and every number between its default and its limit.
                #[allow(clippy::cast_precision_loss, reason = "a few options")]
                let values: Vec<f32> = <F<f32> as Filter<f32>>::SPEC.params.iter().map(|param| match param.kind {
                    ParamKind::Real { default, max, .. } => (0.9 * default + 0.1 * max.min(2.0 * default)) as f32,
                    ParamKind::Choice { options } => (options.len() - 1) as f32,
                    ParamKind::Switch { default } => f32::from(u8::from(!default)),
                }).collect();
                assert_the_same_bits::<F<f32>>(&values, AhrsSettings::default(), None);
            })+
        }

        #[test]
        fn a_parameter_takes_the_values_that_the_core_takes() {
            $({
                use $filter as F;
                type Params = <F<f32> as Filter<f32>>::Params;
                let specs = <F<f32> as Filter<f32>>::SPEC.params;
                for (index, spec) in specs.iter().enumerate() {
                    let mut values: Vec<f64> = vec![-1.0, 0.0, 0.25, 1.0, 2.0, 3.0, 1e30, spec.default()];
                    values.extend([f64::NAN, f64::INFINITY, -f64::INFINITY]);
                    if let ParamKind::Real { min, max, .. } = spec.kind {
                        values.extend([min, max, 1.5 * max + 1.0, min - 1.0]);
                    }
                    for value in values {
                        let mut list: Vec<f64> = specs.iter().map(|spec| spec.default()).collect();
                        list[index] = value;
                        let read = Params::from_values(&list);
                        let mut set = Params::default();
                        let taken = set.set(index, value as f32);
                        assert_eq!(taken, read.is_ok(), "{} = {value}", spec.name);
                        let expected = read.unwrap_or_default();
                        assert_eq!(format!("{set:?}"), format!("{expected:?}"), "{} = {value}", spec.name);
                    }
                }
                assert!(!Params::default().set(specs.len(), 0.0));
            })+
        }
    };
}
ahrs_rs::for_each_filter!(each);

#[test]
fn what_cannot_be_done_is_refused_and_changes_nothing() {
    let madgwick = filter("Madgwick");
    let mut memory = Memory::new();
    let ahrs = memory.address();
    let zeros = [0.0_f32; 4];
    let mut quat = [0.0_f32; 4];
    // SAFETY: every pointer is NULL or points to what it says.
    unsafe {
        assert_eq!(ahrs_size(null()), 0);
        assert_eq!(ahrs_size(madgwick), madgwick.size);
        let init = |values: &[f32], settings: *const AhrsSettings| {
            ahrs_init(ahrs, MEMORY, madgwick, values.as_ptr(), values.len(), settings)
        };
        assert_eq!(ahrs_init(null_mut(), MEMORY, madgwick, null(), 0, null()), AHRS_NULL);
        assert_eq!(ahrs_init(ahrs, MEMORY, null(), null(), 0, null()), AHRS_NULL);
        assert_eq!(ahrs_init(ahrs, MEMORY, madgwick, null(), 1, null()), AHRS_NULL);
        assert_eq!(ahrs_init(ahrs, madgwick.size - 1, madgwick, null(), 0, null()), AHRS_MEMORY);
        assert_eq!(ahrs_init(ahrs.byte_add(4), 2000, madgwick, null(), 0, null()), AHRS_MEMORY);
        assert_eq!(init(&[-1.0], null()), AHRS_PARAMETER);
        assert_eq!(init(&[0.1, f32::NAN], null()), AHRS_PARAMETER - 1);
        let specs = (madgwick.spec)().params;
        let choice = specs.iter().position(|spec| matches!(spec.kind, ParamKind::Choice { .. })).unwrap();
        let mut values: Vec<f32> = specs.iter().map(|spec| spec.default() as f32).collect();
        values[choice] = 99.0;
        assert_eq!(init(&values, null()), AHRS_PARAMETER - i32::try_from(choice).unwrap());
        values.push(0.0);
        assert_eq!(init(&values, null()), AHRS_TOO_MANY);
        for settings in [
            AhrsSettings { frame: 3, ..AhrsSettings::default() },
            AhrsSettings { gyr_hold: 2, ..AhrsSettings::default() },
            AhrsSettings { repeated: 2, ..AhrsSettings::default() },
            AhrsSettings { declination: f32::NAN, ..AhrsSettings::default() },
            AhrsSettings { gyr_range: -1.0, ..AhrsSettings::default() },
            AhrsSettings { gyr_range: f32::INFINITY, ..AhrsSettings::default() },
        ] {
            assert_eq!(init(&[], &raw const settings), AHRS_SETTING);
        }
        // After a refusal, and in fresh memory, there is no filter.
        for _ in 0..2 {
            let (gyr, sensor) = (zeros.as_ptr(), zeros.as_ptr());
            assert_eq!(ahrs_update(ahrs, gyr, sensor, sensor, 0.01, quat.as_mut_ptr()), AHRS_NO_FILTER);
            assert_eq!(ahrs_start_from(ahrs, zeros.as_ptr()), AHRS_NO_FILTER);
            assert_eq!(ahrs_quat(ahrs, quat.as_mut_ptr()), AHRS_NO_FILTER);
            assert_eq!(ahrs_gyr_bias(ahrs, quat.as_mut_ptr()), AHRS_NO_FILTER);
            assert_eq!(ahrs_status(ahrs), AHRS_NO_FILTER);
            memory.0 = [0; MEMORY];
        }
        assert_eq!(ahrs_update(null_mut(), null(), null(), null(), 0.01, null_mut()), AHRS_NULL);
        assert_eq!(ahrs_status(null()), AHRS_NULL);
        assert_eq!(init(&[], null()), AHRS_OK);
        assert_eq!(ahrs_status(ahrs), 0);
        assert_eq!(ahrs_quat(ahrs, null_mut()), AHRS_NULL);
        assert_eq!(ahrs_gyr_bias(ahrs, null_mut()), AHRS_NULL);
        assert_eq!(ahrs_start_from(ahrs, null()), AHRS_NULL);
        // Nothing is given: time goes by.
        assert_eq!(ahrs_update(ahrs, null(), null(), null(), 0.01, null_mut()), AHRS_OK);
        assert_eq!(ahrs_status(ahrs), i32::from(AHRS_GYR_HELD | AHRS_NOT_ALIGNED));
    }
}
