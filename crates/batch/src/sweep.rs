//! Many parameter sets over many recordings: only the errors are kept.

use std::cmp::Ordering;
use std::sync::{Mutex, PoisonError};

use ahrs_rs::Settings;
use ahrs_rs::params::{ParamError, ParamKind};

use crate::recording::Recording;
use crate::registry::{Entry, Number};
use crate::stage::{Input, Stage};
use crate::threads::{Watch, contained, in_threads, threads};
use ahrs_rs_lanes::bank::Bank;
use ahrs_rs_lanes::metric::{Metric, Sums};
use ahrs_rs_lanes::simd::Isa;
use ahrs_rs_lanes::single::Single;

/// Work items for each thread, so that all end at about the same time.
const ITEMS: usize = 8;

/// Samples of a register of sets that pay for a thread: some tenths of a millisecond and more.
const SAMPLES: usize = 1024;

/// A recording with its truth.
pub struct Trial<'a, T> {
    /// What goes in.
    pub recording: Recording<'a, T>,
    /// The true attitude at each sample, east-north-up or in the frame of the settings; none where it does not count.
    pub reference: &'a [Option<[T; 4]>],
}

/// What is swept.
#[derive(Clone, Copy)]
pub struct Sweep<'a> {
    /// The filter.
    pub entry: &'a Entry,
    /// Parameter sets, each in the order of the filter's description.
    pub sets: &'a [Vec<f64>],
    /// The settings of all of them.
    pub settings: Settings,
    /// The error whose root mean square is wanted.
    pub metric: Metric,
    /// The instructions for lanes, or none to compute one set after the other.
    pub isa: Option<Isa>,
    /// On how many threads; by default on one per core.
    pub threads: Option<usize>,
}

/// Some parameter sets over one recording.
struct Item<'a> {
    trial: usize,
    /// Indices of sets; those of a bank have the same choices.
    banks: &'a [Vec<usize>],
}

/// The root-mean-square error in rad of every set over every trial, one row a set; none where it was told to stop before, or
/// where the filter panicked, which the watch tells.
pub fn sweep<T: Number>(
    sweep: &Sweep<'_>,
    trials: &[Trial<'_, T>],
    watch: &Watch,
) -> Result<Vec<Option<f64>>, ParamError> {
    let lanes = bank::<T>(sweep, &[])?.lanes();
    let banks = banks(sweep, lanes);
    // Wrong values are found before anything is computed.
    banks.iter().try_for_each(|indices| bank::<T>(sweep, indices).map(drop))?;
    let samples: usize = trials.iter().map(|trial| trial.reference.len()).sum();
    let threads = threads(sweep.threads, banks.len() * trials.len(), banks.len() * samples / SAMPLES);
    let together = (banks.len() * trials.len()).div_ceil(ITEMS * threads).max(1);
    let mut items: Vec<_> =
        (0..trials.len()).flat_map(|trial| banks.chunks(together).map(move |banks| Item { trial, banks })).collect();
    let errors = Mutex::new(vec![None; sweep.sets.len() * trials.len()]);
    in_threads(threads, &mut items, |item| {
        let Some(trial) = trials.get(item.trial) else { return };
        let found = match contained(|| run(sweep, trial, item.banks, watch)) {
            Ok(Some(found)) => found,
            Ok(None) => return,
            Err(text) => return watch.report(text),
        };
        let mut errors = errors.lock().unwrap_or_else(PoisonError::into_inner);
        for (set, error) in found {
            if let Some(place) = errors.get_mut(set * trials.len() + item.trial) {
                *place = Some(error);
            }
        }
        drop(errors);
        watch.done(item.banks.iter().map(Vec::len).sum());
    });
    Ok(errors.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// The errors of the sets over one recording, which is read once; none where it was told to stop.
fn run<T: Number>(
    sweep: &Sweep<'_>,
    trial: &Trial<'_, T>,
    indices: &[Vec<usize>],
    watch: &Watch,
) -> Option<Vec<(usize, f64)>> {
    let mut banks: Vec<_> = indices.iter().filter_map(|indices| bank::<T>(sweep, indices).ok()).collect();
    let lanes = banks.first()?.lanes();
    let mut sums = vec![Sums::new(lanes); banks.len()];
    let mut stage = Stage::new(lanes);
    let inputs = [Input::new(&trial.recording)];
    for (tile, reference) in trial.reference.chunks(Stage::<T>::capacity()).enumerate() {
        if !watch.go_on() {
            return None;
        }
        let start = tile * Stage::<T>::capacity();
        if let Some(bank) = banks.first() {
            stage.fill(bank.as_ref(), &inputs, start, start + reference.len());
        }
        for (bank, sums) in banks.iter_mut().zip(&mut sums) {
            bank.run(&mut stage.rows(false));
            bank.score(sweep.metric, stage.quat(), reference, sums);
        }
    }
    let errors = indices.iter().zip(&sums);
    Some(errors.flat_map(|(sets, sums)| sets.iter().enumerate().map(|(lane, &set)| (set, sums.rmse(lane)))).collect())
}

/// The filter in lanes with the parameter sets of these indices, or with its defaults.
fn bank<T: Number>(sweep: &Sweep<'_>, indices: &[usize]) -> Result<Box<dyn Bank<T>>, ParamError> {
    let sets: Vec<_> = indices.iter().filter_map(|&index| Some(sweep.sets.get(index)?.as_slice())).collect();
    let lanes = sweep.isa.and_then(|isa| T::bank(sweep.entry, isa, &sets, sweep.settings));
    lanes.unwrap_or_else(|| {
        let values = sets.first().copied().unwrap_or_default();
        Ok(Box::new(Single(T::stream(sweep.entry, values, sweep.settings)?)))
    })
}

/// The indices of the sets, taken together by equal choices, as many to a bank as it has lanes.
fn banks(sweep: &Sweep<'_>, lanes: usize) -> Vec<Vec<usize>> {
    let choices = |index: &usize| {
        let values = sweep.sets.get(*index).map(Vec::as_slice).unwrap_or_default().iter();
        let params = sweep.entry.spec.params.iter();
        let chosen = params.zip(values).filter(|(param, _)| !matches!(param.kind, ParamKind::Real { .. }));
        chosen.map(|(_, value)| *value).collect::<Vec<_>>()
    };
    let mut indices: Vec<_> = (0..sweep.sets.len()).collect();
    indices.sort_by(|a, b| choices(a).partial_cmp(&choices(b)).unwrap_or(Ordering::Equal));
    let alike = indices.chunk_by(|a, b| choices(a) == choices(b));
    alike.flat_map(|alike| alike.chunks(lanes)).map(<[usize]>::to_vec).collect()
}
