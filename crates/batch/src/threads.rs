//! Many recordings at once.

use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

use crate::recording::{Outputs, Recording, run};
use crate::registry::Number;
use crate::stream::Stream;

/// One recording with its filter and the room for its results.
pub struct Job<'a, T> {
    /// The filter, in the state from which it goes on.
    pub stream: Box<dyn Stream<T>>,
    /// What goes in.
    pub recording: Recording<'a, T>,
    /// What comes out.
    pub outputs: Outputs<'a, T>,
}

/// Runs all jobs, on as many threads as are asked for; by default on one per core.
pub fn run_all<T: Number>(jobs: &mut [Job<'_, T>], threads: Option<usize>) {
    let run_one = |job: &mut Job<'_, T>| run(job.stream.as_mut(), &job.recording, &mut job.outputs);
    if jobs.len() < 2 || threads == Some(1) {
        jobs.iter_mut().for_each(run_one);
        return;
    }
    let pool = threads.and_then(|threads| ThreadPoolBuilder::new().num_threads(threads).build().ok());
    match pool {
        Some(pool) => pool.install(|| jobs.par_iter_mut().for_each(run_one)),
        None => jobs.par_iter_mut().for_each(run_one),
    }
}
