//! The replay of the recording through one filter.

use ahrs_rs::signal::DesignError;
use ahrs_rs::{Estimator, Filter, Output, Quat, Settings};

use crate::pipeline::Pipeline;
use crate::recording::{Recording, Row};
use crate::stack;

/// What a replay tells.
#[derive(Clone, Copy, Debug)]
pub struct Report {
    /// FNV-1a over the bits of every quaternion and bias and over every status, in 64 bits.
    pub hash: u64,
    /// The last attitude.
    pub quat: Quat<f32>,
    /// How many bytes of stack an update took at most; zero on the host.
    pub stack: usize,
    /// How many bytes the estimator takes.
    pub state: usize,
}

/// The hash FNV-1a (Fowler, Noll, Vo) of 64 bits.
struct Hash(u64);

impl Hash {
    fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// One update: what is counted and measured.
#[inline(never)]
#[cfg_attr(target_os = "none", unsafe(link_section = ".text.update"))]
fn update<F: Filter<f32>>(estimator: &mut Estimator<f32, F>, row: &Row, with_mag: bool) -> Output<f32> {
    estimator.step(row.gyr, Some(row.acc), with_mag.then_some(row.mag), row.dt)
}

/// The way from the sensors' drivers to the filter: counted by itself.
#[inline(never)]
#[cfg_attr(target_os = "none", unsafe(link_section = ".text.prepare"))]
fn prepare(pipeline: &mut Pipeline, row: &Row) -> Row {
    pipeline.prepare(row)
}

/// Replays the first rows of the recording through a filter with its defaults.
#[inline(never)]
#[cfg_attr(target_os = "none", unsafe(link_section = ".text.caller"))]
pub fn replay<F: Filter<f32>>(updates: u32, with_mag: bool) -> Result<Report, DesignError>
where
    F::Params: Default,
{
    let mut recording = Recording::default();
    let mut pipeline = Pipeline::new()?;
    let mut estimator = Estimator::<f32, F>::new(&F::Params::default(), Settings::default());
    let mut hash = Hash(0xcbf2_9ce4_8422_2325);
    let mut stack = stack::Gauge::new();
    for _ in 0..updates {
        let row = prepare(&mut pipeline, &recording.row());
        stack.paint();
        let output = update(&mut estimator, &row, with_mag);
        stack.read();
        let (q, bias) = (output.quat, estimator.filter().gyr_bias());
        for number in [q.w, q.x, q.y, q.z, bias.x, bias.y, bias.z] {
            hash.add(&number.to_bits().to_le_bytes());
        }
        hash.add(&output.flags.bits(0).to_le_bytes());
    }
    Ok(Report { hash: hash.0, quat: estimator.quat(), stack: stack.most(), state: size_of::<Estimator<f32, F>>() })
}

/// Calls `report` for each filter of the registry, or for the one of a name that is known to the compiler.
pub fn each_filter(
    chosen: Option<&str>,
    updates: u32,
    with_mag: bool,
    mut report: impl FnMut(&str, &Report),
) -> Result<(), DesignError> {
    macro_rules! filters {
        ($($filter:path),+) => {$({
            use $filter as F;
            let name = <F<f32> as Filter<f32>>::SPEC.name;
            if chosen.is_none_or(|chosen| chosen == name) {
                report(name, &replay::<F<f32>>(updates, with_mag)?);
            }
        })+};
    }
    ahrs_rs::for_each_filter!(filters);
    Ok(())
}
