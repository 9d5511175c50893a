//! Many recordings at once: side by side in lanes, and on several threads.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use ahrs_rs::Settings;

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
    /// What a filter said that panicked over this recording: a fault of ours, of which no other recording is to know.
    pub panicked: Option<String>,
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
    panicked: Mutex<Option<String>>,
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
    /// Keeps what a part of the work said that panicked; the rest goes on.
    pub fn report(&self, text: String) {
        self.panicked.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(text);
    }
    /// What the first part said that panicked.
    pub fn panicked(&self) -> Option<String> {
        self.panicked.lock().unwrap_or_else(PoisonError::into_inner).clone()
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
    let samples: usize = groups.iter().flat_map(|group| group.iter()).map(|job| job.recording.gyr.nrows()).sum();
    let threads = threads(plan.threads, groups.len(), samples / SAMPLES);
    in_threads(threads, &mut groups, |group| run_group(group, plan, watch));
}

/// What the jobs of a bank have in common: that lanes can compute them, and which sensors there are.
fn kind<T>(job: &Job<'_, T>) -> (bool, bool, bool, bool) {
    let Job { recording, outputs, .. } = job;
    let in_lanes = outputs.extra.is_empty();
    (in_lanes, recording.acc.is_some(), recording.mag.is_some(), outputs.gyr_bias.is_some())
}

fn run_group<T: Number>(group: &mut [&mut Job<'_, T>], plan: &Plan<'_>, watch: &Watch) {
    let isa = plan.isa.filter(|_| group.len() >= WORTH_LANES);
    let bank = isa.and_then(|isa| T::bank(plan.entry, isa, &[plan.values], plan.settings)?.ok());
    match bank {
        Some(mut bank) => side_by_side(group, watch, |group| lanes::run(bank.as_mut(), group, watch)),
        None => group.iter_mut().for_each(|job| alone(job, watch)),
    }
}

/// Runs the jobs together, or, if that panics, each alone from where it began, so that it is known which of them does.
pub(crate) fn side_by_side<T: Number>(
    group: &mut [&mut Job<'_, T>],
    watch: &Watch,
    together: impl FnOnce(&mut [&mut Job<'_, T>]),
) {
    let before: Vec<_> = group.iter_mut().map(|job| job.stream.save()).collect();
    if contained(|| together(group)).is_err() {
        for (job, before) in group.iter_mut().zip(before) {
            job.stream.load(&before);
            alone(job, watch);
        }
    }
}

/// Runs a job by itself.
fn alone<T: Number>(job: &mut Job<'_, T>, watch: &Watch) {
    match contained(|| run_from(job.stream.as_mut(), &job.recording, &mut job.outputs, 0, watch)) {
        Ok(infinite) => job.infinite = infinite,
        Err(text) => job.panicked = Some(text),
    }
    watch.done(1);
}

/// What the work gives, or what it says that panics.
pub fn contained<R>(work: impl FnOnce() -> R) -> Result<R, String> {
    // What the work has written so far is written anew, or refused with its recording.
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        text.unwrap_or("without a message").to_owned()
    })
}

/// Samples that pay for a thread: a third of a millisecond and more, where starting a thread takes 0.02 to 0.05 ms.
const SAMPLES: usize = 4096;

/// The environment's number of threads, where a call does not say it; the second is of the library that did this before.
const VARIABLES: [&str; 2] = ["AHRS_RS_NUM_THREADS", "RAYON_NUM_THREADS"];

/// How many threads there are by default: as the environment says, or one per core that the process may use.
pub fn default_threads() -> usize {
    static KNOWN: AtomicUsize = AtomicUsize::new(0);
    let known = KNOWN.load(Ordering::Relaxed);
    if known > 0 {
        return known;
    }
    let named = VARIABLES.iter().find_map(|name| std::env::var(name).ok()?.trim().parse().ok().filter(|&n| n > 0));
    let count = named.unwrap_or_else(|| {
        // It is asked for once: the system's answer takes as long as a thread.
        thread::available_parallelism().map_or(1, usize::from)
    });
    KNOWN.store(count, Ordering::Relaxed);
    count
}

/// How many threads are started for some items: no more than there are items, nor, where no number is asked for, than the
/// work pays for.
pub fn threads(asked: Option<usize>, items: usize, paid: usize) -> usize {
    asked.unwrap_or_else(|| default_threads().min(paid)).min(items).max(1)
}

/// Does the same to every item, on so many threads, this one among them. Each takes the next item when it has done with one,
/// so the long ones should come first.
///
/// There is no pool that would wait for the next call: a process that is forked has only the thread that forked it, and a
/// pool of its parent's, which would wait for ever.
pub fn in_threads<A: Send>(threads: usize, items: &mut [A], each: impl Fn(&mut A) + Sync) {
    if threads < 2 || items.len() < 2 {
        items.iter_mut().for_each(each);
        return;
    }
    let items = Mutex::new(items.iter_mut());
    let next = || items.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work = || {
        while let Some(item) = next() {
            each(item);
        }
    };
    thread::scope(|scope| {
        for _ in 1..threads {
            // Where the system has no more threads to give, those that are there do the work.
            if thread::Builder::new().spawn_scoped(scope, work).is_err() {
                break;
            }
        }
        work();
    });
}
