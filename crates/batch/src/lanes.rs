//! Recordings side by side in the lanes of one bank.
//!
//! Samples are copied tile by tile into the order of the lanes, computed there, and copied back: what a tile holds stays in
//! the cache, and each array is read and written once, in order.

use crate::recording::run_from;
use crate::registry::Number;
use crate::stage::{Input, Output, Stage};
use crate::threads::{Job, Watch};
use ahrs_rs_lanes::bank::Bank;

/// Fewer recordings than this are computed one after the other: as many lanes take the time of nearly two.
pub const WORTH_LANES: usize = 3;

/// Runs the jobs, sorted by falling length, in the lanes of the bank; all have the same sensors and no further outputs.
pub fn run<T: Number>(bank: &mut dyn Bank<T>, jobs: &mut [&mut Job<'_, T>], watch: &Watch) {
    let mut stage = Stage::new(bank.lanes());
    for (lane, job) in jobs.iter_mut().enumerate() {
        bank.load(lane, &job.stream.save());
    }
    let lengths: Vec<_> = jobs.iter().map(|job| job.recording.gyr.nrows()).collect();
    let inputs: Vec<_> = jobs.iter().map(|job| Input::new(&job.recording)).collect();
    let with_bias = jobs.iter().any(|job| job.outputs.gyr_bias.is_some());
    let (mut streams, mut outputs): (Vec<_>, Vec<_>) =
        jobs.iter_mut().map(|job| (&mut job.stream, Output::new(&mut job.outputs))).unzip();
    let mut refused = Vec::new();
    let mut done = 0;
    let mut active = jobs_with_more(&lengths, done);
    watch.done(lengths.len() - active);
    while active >= WORTH_LANES && watch.go_on() {
        let shortest = lengths.get(active - 1).copied().unwrap_or(done);
        let end = shortest.min(done + Stage::<T>::capacity());
        let current = inputs.get(..active).unwrap_or_default();
        stage.fill(bank, current, done, end);
        stage.plan_prefetch(current, outputs.get(..active).unwrap_or_default(), end);
        bank.run(&mut stage.rows(with_bias));
        refused.extend(stage.infinite(current, done));
        stage.write_back(bank, outputs.get_mut(..active).unwrap_or_default(), done);
        done = end;
        let before = active;
        active = jobs_with_more(&lengths, done);
        for (lane, stream) in streams.iter_mut().enumerate().take(before).skip(active) {
            stream.load(&bank.save(lane));
            watch.done(1);
        }
    }
    drop((streams, outputs));
    // What is left is too little for lanes.
    for (lane, job) in jobs.iter_mut().enumerate().take(active) {
        job.stream.load(&bank.save(lane));
        job.infinite = run_from(job.stream.as_mut(), &job.recording, &mut job.outputs, done, watch);
        watch.done(1);
    }
    for lane in refused {
        if let Some(job) = jobs.get_mut(lane) {
            job.infinite = true;
        }
    }
}

/// How many of the recordings, sorted by falling length, have samples after the first `done`.
fn jobs_with_more(lengths: &[usize], done: usize) -> usize {
    lengths.iter().take_while(|&&length| length > done).count()
}
