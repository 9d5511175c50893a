//! What the C example, `crates/capi/examples/replay.c`, has to print: a line for each filter, from the core itself. For the host.

use ahrs_rs::{Estimator, Filter, Settings, Vec3};

const UPDATES: u32 = 10_000;

struct Noise(u32);

impl Noise {
    /// The numbers of `uniform()` in `replay.c`.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_wrap, reason = "24 bits with their sign")]
    fn uniform(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((self.0 as i32) >> 8) as f32 * (1.0 / 8_388_608.0)
    }
}

fn replay<F: Filter<f32>>()
where
    F::Params: Default,
{
    let mut estimator = Estimator::<f32, F>::new(&F::Params::default(), Settings::default());
    let (mut noise, mut hash) = (Noise(12345), 0xcbf2_9ce4_8422_2325_u64);
    for k in 0..UPDATES {
        let rate = if k & 512 == 0 { 0.75 } else { -0.75 };
        let gyr = Vec3::new(rate, rate * 0.5, noise.uniform() * 0.25);
        let acc = Vec3::new(noise.uniform(), 2.0, 9.5);
        let mag = Vec3::new(noise.uniform() * 2.0, 20.0, -43.0);
        let q = estimator.step(gyr, Some(acc), k.is_multiple_of(4).then_some(mag), 0.007_812_5).quat;
        for byte in [q.w, q.x, q.y, q.z].into_iter().flat_map(|number| number.to_bits().to_le_bytes()) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    let q = estimator.quat();
    let [w, x, y, z] = [q.w, q.x, q.y, q.z].map(f32::to_bits);
    println!("{} {hash:016x} {w:08x} {x:08x} {y:08x} {z:08x}", F::SPEC.name);
}

macro_rules! replays {
    ($($filter:path),+) => {
        fn main() {
            $({
                use $filter as F;
                replay::<F<f32>>();
            })+
        }
    };
}
ahrs_rs::for_each_filter!(replays);
