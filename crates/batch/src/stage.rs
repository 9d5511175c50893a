//! A tile of several recordings in the order of the lanes.

use std::ops::Range;

use ndarray::{ArrayView2, ArrayViewMut2, Axis, s};

use crate::recording::{Outputs, Recording, sensors_infinite};
use crate::registry::Number;
use ahrs_rs::status;
use ahrs_rs_lanes::bank::{Bank, Rows};
use ahrs_rs_lanes::prefetch::{CACHE_LINE, PrefetchPlan};
use ahrs_rs_lanes::transpose::deinterleave;

/// Samples of each recording in a tile.
const TILE: usize = 128;

/// The most numbers that one lane has in a tile of one array.
const ROOM: usize = 4 * TILE;

/// The most lanes of a bank.
const MOST_LANES: usize = 32;

/// Room for a tile: what goes into a bank and what comes out.
pub struct Stage<T> {
    lanes: usize,
    rows: usize,
    gyr: Aligned<T>,
    acc: Aligned<T>,
    mag: Aligned<T>,
    dt: Aligned<T>,
    quat: Aligned<T>,
    gyr_bias: Aligned<T>,
    status: Aligned<u16>,
    has_acc: bool,
    has_mag: bool,
    /// Set where all of the steps in the tile are the same, and the same as before.
    steady: bool,
    steps: Vec<T>,
    /// Rows of arrays whose numbers do not lie next to each other.
    scratch: Vec<T>,
    status_scratch: Vec<u16>,
    prefetch: PrefetchPlan,
}

impl<T: Number> Stage<T> {
    /// Room for as many lanes.
    pub fn new(lanes: usize) -> Self {
        let room = |values: usize| Aligned::new(TILE * lanes * values, T::zero());
        Stage {
            lanes,
            rows: 0,
            gyr: room(3),
            acc: room(3),
            mag: room(3),
            dt: room(1),
            quat: room(4),
            gyr_bias: room(3),
            status: Aligned::new(TILE * lanes, 0),
            has_acc: false,
            has_mag: false,
            steady: false,
            steps: Vec::with_capacity(TILE * lanes),
            scratch: vec![T::zero(); ROOM * lanes],
            status_scratch: vec![0; ROOM * lanes],
            prefetch: PrefetchPlan::new(),
        }
    }

    /// The samples that there is room for in each lane.
    pub fn capacity() -> usize {
        TILE
    }

    /// Takes samples `start..end` of recordings that have the same sensors, at most as many as there is room for. Lanes
    /// beyond the last recording get what the first one does.
    pub fn fill(&mut self, bank: &dyn Bank<T>, inputs: &[Input<'_, T>], start: usize, end: usize) {
        let lanes = self.lanes;
        let Some(first) = inputs.first() else { return };
        self.rows = end.saturating_sub(start).min(TILE);
        let (rows, end) = (self.rows, start + self.rows);
        let each = || (0..lanes).map(|lane| inputs.get(lane).unwrap_or(first));
        let scratch = &mut self.scratch;
        into_lanes(bank, self.gyr.get_mut(3 * lanes * rows), each().map(|r| &r.gyr), start..end, scratch);
        self.has_acc = first.acc.is_some();
        if self.has_acc {
            let acc = each().filter_map(|r| r.acc.as_ref());
            into_lanes(bank, self.acc.get_mut(3 * lanes * rows), acc, start..end, scratch);
        }
        self.has_mag = first.mag.is_some();
        if self.has_mag {
            let mag = each().filter_map(|r| r.mag.as_ref());
            into_lanes(bank, self.mag.get_mut(3 * lanes * rows), mag, start..end, scratch);
        }
        let step = first.recording.time.step;
        let steady = start > 0
            && inputs
                .iter()
                .all(|r| r.recording.time.stamps.is_none() && r.recording.time.step.to_bits() == step.to_bits());
        if !(steady && self.steady) {
            self.steps.clear();
            each().for_each(|r| r.recording.time.steps(&mut self.steps, start, end));
            let mut steps: [&[T]; MOST_LANES] = [&[]; MOST_LANES];
            steps.iter_mut().zip(self.steps.chunks_exact(rows.max(1))).for_each(|(place, steps)| *place = steps);
            bank.interleave(self.dt.get_mut(lanes * rows), steps.get(..lanes).unwrap_or_default());
        }
        // What a whole tile holds need not be written again.
        self.steady = steady && (self.steady || rows == TILE);
    }

    /// Plans to prefetch the memory of the tile from sample `start` on while the next `rows` are computed.
    pub fn plan_prefetch(&mut self, inputs: &[Input<'_, T>], outputs: &[Output<'_, T>], start: usize) {
        self.prefetch.clear();
        let part = start..start + TILE;
        for input in inputs {
            for source in [Some(&input.gyr), input.acc.as_ref(), input.mag.as_ref()].into_iter().flatten() {
                self.prefetch.add(source.flat(part.clone()));
            }
        }
        for output in outputs {
            self.prefetch.add(output.quat.flat(part.clone()));
            self.prefetch.add(output.status.flat(part.clone()));
            if let Some(bias) = &output.gyr_bias {
                self.prefetch.add(bias.flat(part.clone()));
            }
        }
    }

    /// The lanes of the tile, which begins at sample `start`, that hold an infinite value. The filters take it for missing
    /// and say so, so that data in which nothing is missing are not searched.
    pub fn infinite(&self, inputs: &[Input<'_, T>], start: usize) -> Vec<usize> {
        if self.statuses() & status::ANY_MISSING == 0 {
            return Vec::new();
        }
        let lanes = inputs.iter().enumerate();
        lanes.filter(|(_, r)| sensors_infinite(&r.recording, start, start + self.rows)).map(|(lane, _)| lane).collect()
    }

    /// All status bits of the tile.
    fn statuses(&self) -> u16 {
        self.status.get(self.lanes * self.rows).iter().fold(0, |bits, &status| bits | status)
    }

    /// The tile, for a bank to go on by.
    pub fn rows(&mut self, with_bias: bool) -> Rows<'_, T> {
        let (lanes, rows) = (self.lanes, self.rows);
        Rows {
            gyr: self.gyr.get(3 * lanes * rows),
            acc: self.has_acc.then_some(self.acc.get(3 * lanes * rows)),
            mag: self.has_mag.then_some(self.mag.get(3 * lanes * rows)),
            dt: self.dt.get(lanes * rows),
            quat: self.quat.get_mut(4 * lanes * rows),
            gyr_bias: with_bias.then_some(self.gyr_bias.get_mut(3 * lanes * rows)),
            status: self.status.get_mut(lanes * rows),
            prefetch: &self.prefetch,
        }
    }

    /// The attitudes that came out.
    pub fn quat(&self) -> &[T] {
        self.quat.get(4 * self.lanes * self.rows)
    }

    /// Copies the results of the first lanes to samples from `start` on.
    pub fn write_back(&mut self, bank: &dyn Bank<T>, outputs: &mut [Output<'_, T>], start: usize) {
        let (lanes, rows) = (self.lanes, self.rows);
        let part = start..start + rows;
        let quat = outputs.iter_mut().map(|out| &mut out.quat);
        let apart = |from: &[T], to: &mut [&mut [T]]| bank.deinterleave(from, to);
        out_of_lanes(self.quat.get(4 * lanes * rows), quat, part.clone(), &mut self.scratch, apart);
        let gyr_bias = outputs.iter_mut().filter_map(|out| out.gyr_bias.as_mut());
        out_of_lanes(self.gyr_bias.get(3 * lanes * rows), gyr_bias, part.clone(), &mut self.scratch, apart);
        let status = outputs.iter_mut().map(|out| &mut out.status);
        let all_zero = self.statuses() == 0;
        let apart = |from: &[u16], to: &mut [&mut [u16]]| {
            if all_zero {
                for places in to {
                    places.fill(0);
                }
            } else {
                deinterleave(from, lanes, to, 0);
            }
        };
        out_of_lanes(self.status.get(lanes * rows), status, part, &mut self.status_scratch, apart);
    }
}

/// Rows of numbers: next to each other, or anywhere in memory.
pub enum Source<'a, E> {
    Flat(&'a [E], usize),
    Spread(ArrayView2<'a, E>),
}

impl<'a, E: Copy> Source<'a, E> {
    fn new(rows: &ArrayView2<'a, E>) -> Self {
        rows.to_slice().map_or(Source::Spread(*rows), |values| Source::Flat(values, rows.ncols()))
    }

    /// The numbers of the rows that there are, where they lie next to each other.
    fn flat(&self, rows: Range<usize>) -> &[E] {
        match self {
            Source::Flat(values, width) => flat(values, *width, rows),
            Source::Spread(_) => &[],
        }
    }

    fn part<'b>(&'b self, rows: Range<usize>, scratch: &'b mut [E]) -> &'b [E] {
        match self {
            Source::Flat(values, width) => values.get(width * rows.start..width * rows.end).unwrap_or_default(),
            Source::Spread(view) => {
                let len = view.ncols() * rows.len();
                let values = view.slice(s![rows, ..]);
                scratch.iter_mut().zip(values).for_each(|(place, &value)| *place = value);
                scratch.get(..len).unwrap_or_default()
            }
        }
    }
}

/// Room for rows of numbers.
pub enum Sink<'a, E> {
    Flat(&'a mut [E], usize),
    Spread(ArrayViewMut2<'a, E>),
}

impl<'a, E> Sink<'a, E> {
    fn new(rows: ArrayViewMut2<'a, E>) -> Self {
        let width = rows.ncols();
        if rows.is_standard_layout() {
            return Sink::Flat(rows.into_slice().unwrap_or_default(), width);
        }
        Sink::Spread(rows)
    }

    /// As of [`Source`].
    fn flat(&self, rows: Range<usize>) -> &[E] {
        match self {
            Sink::Flat(values, width) => flat(values, *width, rows),
            Sink::Spread(_) => &[],
        }
    }
}

/// The numbers of the rows that there are.
fn flat<E>(values: &[E], width: usize, rows: Range<usize>) -> &[E] {
    values.get(width * rows.start..values.len().min(width * rows.end)).unwrap_or_default()
}

/// What goes into a lane.
pub struct Input<'a, T> {
    gyr: Source<'a, T>,
    acc: Option<Source<'a, T>>,
    mag: Option<Source<'a, T>>,
    recording: Recording<'a, T>,
}

impl<'a, T: Number> Input<'a, T> {
    /// A recording.
    pub fn new(recording: &Recording<'a, T>) -> Self {
        Input {
            gyr: Source::new(&recording.gyr),
            acc: recording.acc.as_ref().map(Source::new),
            mag: recording.mag.as_ref().map(Source::new),
            recording: *recording,
        }
    }
}

/// What comes out of a lane.
pub struct Output<'a, T> {
    quat: Sink<'a, T>,
    gyr_bias: Option<Sink<'a, T>>,
    status: Sink<'a, u16>,
}

impl<'a, T: Number> Output<'a, T> {
    /// The room for the results of a recording.
    pub fn new(outputs: &'a mut Outputs<'_, T>) -> Self {
        Output {
            quat: Sink::new(outputs.quat.view_mut()),
            gyr_bias: outputs.gyr_bias.as_mut().map(|rows| Sink::new(rows.view_mut())),
            status: Sink::new(outputs.status.view_mut().insert_axis(Axis(1))),
        }
    }
}

/// Numbers that begin where a line of the cache does.
struct Aligned<E> {
    values: Vec<E>,
    start: usize,
}

impl<E: Copy> Aligned<E> {
    fn new(len: usize, fill: E) -> Self {
        let spare = CACHE_LINE / size_of::<E>();
        let values = vec![fill; len + spare];
        let start = values.as_ptr().align_offset(CACHE_LINE).min(spare);
        Aligned { values, start }
    }

    fn get(&self, len: usize) -> &[E] {
        self.values.get(self.start..self.start + len).unwrap_or_default()
    }

    fn get_mut(&mut self, len: usize) -> &mut [E] {
        self.values.get_mut(self.start..self.start + len).unwrap_or_default()
    }
}

/// Copies rows, of one source for each lane, into the order of the lanes.
fn into_lanes<'a, 'b: 'a, T: Number>(
    bank: &dyn Bank<T>,
    to: &mut [T],
    sources: impl Iterator<Item = &'a Source<'b, T>>,
    rows: Range<usize>,
    scratch: &mut [T],
) {
    let mut parts: [&[T]; MOST_LANES] = [&[]; MOST_LANES];
    let mut lanes = 0;
    for ((part, source), scratch) in parts.iter_mut().zip(sources).zip(scratch.chunks_mut(ROOM)) {
        *part = source.part(rows.clone(), scratch);
        lanes += 1;
    }
    bank.interleave(to, parts.get(..lanes).unwrap_or_default());
}

/// Copies what stands in the order of the lanes into rows, one sink for each of the first lanes.
fn out_of_lanes<'a, 'b: 'a, E: Copy + 'b>(
    from: &[E],
    sinks: impl Iterator<Item = &'a mut Sink<'b, E>>,
    rows: Range<usize>,
    scratch: &mut [E],
    apart: impl Fn(&[E], &mut [&mut [E]]),
) {
    let mut parts: [&mut [E]; MOST_LANES] = std::array::from_fn(|_| Default::default());
    let mut count = 0;
    let mut spread = Vec::new();
    let mut scratch = scratch.chunks_mut(ROOM);
    for (lane, (part, sink)) in parts.iter_mut().zip(sinks).enumerate() {
        *part = match sink {
            Sink::Flat(values, width) => values.get_mut(*width * rows.start..*width * rows.end),
            Sink::Spread(view) => {
                let len = view.ncols() * rows.len();
                spread.push((lane, view));
                scratch.next().and_then(|room| room.get_mut(..len))
            }
        }
        .unwrap_or_default();
        count += 1;
    }
    apart(from, parts.get_mut(..count).unwrap_or_default());
    for (lane, view) in spread {
        let values = parts.get(lane).map(|part| part.iter()).unwrap_or_default();
        view.slice_mut(s![rows.clone(), ..]).iter_mut().zip(values).for_each(|(place, &value)| *place = value);
    }
}
