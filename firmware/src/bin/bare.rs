//! The smallest application with one filter: it reads three sensors, updates, and writes the attitude. Its size is what a
//! filter costs in flash. `AHRS_FILTER` names the filter when it is compiled; without it there is none.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod target {
    use ahrs_rs::{Estimator, Filter, Settings, Vec3};
    // Start-up and panic handler.
    use firmware as _;

    /// Where the sensors' drivers would leave a row, and where the attitude is taken from.
    #[unsafe(no_mangle)]
    static mut SENSORS: [f32; 10] = [0.0; 10];
    #[unsafe(no_mangle)]
    static mut ATTITUDE: [f32; 4] = [0.0; 4];

    fn sensors() -> [f32; 10] {
        // SAFETY: one thread, no interrupt.
        unsafe { (&raw const SENSORS).read_volatile() }
    }

    fn put(attitude: [f32; 4]) {
        // SAFETY: one thread, no interrupt.
        unsafe { (&raw mut ATTITUDE).write_volatile(attitude) }
    }

    fn run<F: Filter<f32>>() -> !
    where
        F::Params: Default,
    {
        let mut estimator = Estimator::<f32, F>::new(&F::Params::default(), Settings::default());
        loop {
            let [gx, gy, gz, ax, ay, az, mx, my, mz, dt] = sensors();
            let (gyr, acc, mag) = (Vec3::new(gx, gy, gz), Vec3::new(ax, ay, az), Vec3::new(mx, my, mz));
            let q = estimator.step(gyr, Some(acc), Some(mag), dt).quat;
            put([q.w, q.x, q.y, q.z]);
        }
    }

    /// What the checks of the images have to find, on the word of `AHRS_PLANT`: see tools/firmware.py.
    #[allow(clippy::indexing_slicing, reason = "the panic that is planted")]
    fn planted(sensors: [f32; 10]) -> f32 {
        match option_env!("AHRS_PLANT") {
            Some("panic") => sensors[sensors[0].to_bits() as usize],
            #[allow(clippy::cast_possible_truncation, reason = "the arithmetic that is planted")]
            Some("f64") => (f64::from(sensors[0]) * f64::from(sensors[1]) * 1.1) as f32,
            #[cfg(planted_allocation)]
            Some("allocation") => allocated(&sensors),
            _ => sensors[0],
        }
    }

    /// A copy of numbers on the heap: there is none, so that this does not even link.
    #[cfg(planted_allocation)]
    fn allocated(numbers: &[f32]) -> f32 {
        extern crate alloc;
        let copy = core::hint::black_box(alloc::vec::Vec::from(numbers));
        copy.first().copied().unwrap_or_default()
    }

    #[unsafe(no_mangle)]
    extern "C" fn main() -> ! {
        macro_rules! filters {
            ($($filter:path),+) => {$({
                use $filter as F;
                if option_env!("AHRS_FILTER") == Some(<F<f32> as Filter<f32>>::SPEC.name) {
                    run::<F<f32>>();
                }
            })+};
        }
        ahrs_rs::for_each_filter!(filters);
        loop {
            let [_, x, y, z, ..] = sensors();
            put([planted(sensors()), x, y, z]);
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {}
