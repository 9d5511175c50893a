//! Many recordings at once: side by side in lanes, and on several threads.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use ahrs_rs::Settings;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

use crate::lanes::{self, WORTH_LANES};
use crate::recording::{Outputs, Recording, run_from};
use crate::registry::{Entry, Number};
use ahrs_rs_lanes::simd::Isa;
use ahrs_rs_lanes::stream::Stream;

/// One recording with its filter and the room for its results.
pub struct Job<'a, T, F: ?Sized = dyn Stream<T>> {
    /// The filter, in the state from which it goes on.
    pub stream: Box<F>,
    /// What goes in.
    pub recording: Recording<'a, T>,
    /// What comes out.
    pub outputs: Outputs<'a, T>,
    /// Set where a measurement turns out to be infinite, which the filters take for missing.
    pub infinite: bool,
}

/// How jobs are run.
#[derive(Clone, Copy)]
pub struct Plan<'a> {
    /// The filter of all of them.
    pub entry: &'a Entry,
    /// Its parameters.
    pub values: &'a [f64],
    /// Its settings.
    pub settings: Settings,
    /// The instructions for lanes, or none to compute one recording after the other.
    pub isa: Option<Isa>,
    /// On how many threads; by default on one per core.
    pub threads: Option<usize>,
}

/// What the one who waits for a long computation sees of it and says to it.
#[derive(Debug, Default)]
pub struct Watch {
    stopped: AtomicBool,
    done: AtomicUsize,
}

impl Watch {
    /// Tells the work to stop soon: what comes out of it is not wanted any more.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }
    /// False where the work is to stop.
    pub fn go_on(&self) -> bool {
        !self.stopped.load(Ordering::Relaxed)
    }
    /// Counts some that are finished.
    pub fn done(&self, count: usize) {
        self.done.fetch_add(count, Ordering::Relaxed);
    }
    /// How many are finished.
    pub fn count(&self) -> usize {
        self.done.load(Ordering::Relaxed)
    }
}

/// Runs all jobs, until they are done or until it is told to stop.
pub fn run_all<T: Number>(jobs: &mut [Job<'_, T>], plan: &Plan<'_>, watch: &Watch) {
    let isa = plan.isa.filter(|_| jobs.len() >= WORTH_LANES);
    let lanes = isa.and_then(|isa| T::bank(plan.entry, isa, &[plan.values], plan.settings)?.ok());
    let lanes = lanes.map_or(1, |bank| bank.lanes());
    // Neighbours have the same sensors and lengths that are as equal as can be.
    let mut sorted: Vec<_> = jobs.iter_mut().collect();
    sorted.sort_by_key(|job| (kind(job), std::cmp::Reverse(job.recording.gyr.nrows())));
    let mut groups: Vec<_> = sorted
        .chunk_by_mut(|a, b| kind(a) == kind(b))
        .flat_map(|alike| {
            let in_lanes = alike.first().is_some_and(|job| kind(job).0);
            alike.chunks_mut(if in_lanes { lanes } else { 1 })
        })
        .collect();
    in_threads(plan.threads, &mut groups, |group| run_group(group, plan, watch));
}

/// What the jobs of a bank have in common: that lanes can compute them, and which sensors there are.
fn kind<T>(job: &Job<'_, T>) -> (bool, bool, bool, bool) {
    let Job { recording, outputs, .. } = job;
    let in_lanes = outputs.extra.is_empty();
    (in_lanes, recording.acc.is_some(), recording.mag.is_some(), outputs.gyr_bias.is_some())
}

fn run_group<T: Number>(group: &mut [&mut Job<'_, T>], plan: &Plan<'_>, watch: &Watch) {
    let isa = plan.isa.filter(|_| group.len() >= WORTH_LANES);
    match isa.and_then(|isa| T::bank(plan.entry, isa, &[plan.values], plan.settings)) {
        Some(Ok(mut bank)) => lanes::run(bank.as_mut(), group, watch),
        _ => group.iter_mut().for_each(|job| {
            job.infinite = run_from(job.stream.as_mut(), &job.recording, &mut job.outputs, 0, watch);
            watch.done(1);
        }),
    }
}

/// Does the same to every item, on as many threads as are asked for; by default on one per core.
pub fn in_threads<A: Send>(threads: Option<usize>, items: &mut [A], each: impl Fn(&mut A) + Sync) {
    if items.len() < 2 || threads == Some(1) {
        items.iter_mut().for_each(each);
        return;
    }
    let pool = threads.and_then(|threads| ThreadPoolBuilder::new().num_threads(threads).build().ok());
    match pool {
        Some(pool) => pool.install(|| items.par_iter_mut().for_each(&each)),
        None => items.par_iter_mut().for_each(&each),
    }
}
