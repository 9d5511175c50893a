//! Filters that look at a whole recording at once: what stands at a sample depends on later ones too.
//!
//! They are computed in `f64` whatever the type of the arrays: nothing of them goes to a microcontroller or into lanes.

mod pieces;
pub mod selfcal;
pub mod vqf;

use ahrs_rs::filters::GyroIntegration;
use ahrs_rs::filters::gyro_integration::Params;
use ahrs_rs::params::ParamError;
use ahrs_rs::status;
use ahrs_rs::{Estimator, FilterSpec, Frame, Measured, Quat, Settings, Vec3};
use ndarray::ArrayView2;

use crate::recording::{Outputs, Recording, sensors_infinite};
use crate::registry::Number;
use crate::threads::{Job, Watch, contained, in_threads, threads};

/// A recording in memory of its own.
pub struct Series {
    /// Angular rates in rad/s.
    pub gyr: Vec<Vec3<f64>>,
    /// Specific forces in m/s².
    pub acc: Option<Vec<Vec3<f64>>>,
    /// Magnetic fields in µT.
    pub mag: Option<Vec<Vec3<f64>>>,
    /// The time in s since the sample before.
    pub dt: Vec<f64>,
}

/// A measurement where it can be used.
pub type Row = Option<Vec3<f64>>;

/// What an offline filter makes of a recording, one entry a sample.
#[derive(Default)]
pub struct Solution {
    /// Attitudes in the frame of the settings.
    pub quat: Vec<Quat<f64>>,
    /// Gyroscope biases in rad/s.
    pub gyr_bias: Vec<Vec3<f64>>,
    /// Status bits.
    pub status: Vec<u16>,
    /// The further outputs that were asked for, each with the rows' values one after the other.
    pub extra: Vec<Vec<f64>>,
}

/// A filter that takes a whole recording.
pub trait Offline: Send + Sync {
    /// The attitudes of a recording, with the outputs of these indices; none where it was told to stop.
    fn solve(&self, series: &Series, outputs: &[usize], watch: &Watch) -> Option<Solution>;
}

/// Samples that pay for a thread: some tenths of a millisecond and more.
const SAMPLES: usize = 1024;

type Make = fn(&[f64], Settings) -> Result<Box<dyn Offline>, ParamError>;

/// One offline filter of the registry.
pub struct OfflineEntry {
    /// Its description.
    pub spec: &'static FilterSpec,
    /// Makes it with the values of its parameters.
    pub make: Make,
}

/// The offline filters: one line a filter.
pub const OFFLINE: &[OfflineEntry] =
    &[OfflineEntry { spec: &vqf::SPEC, make: vqf::make }, OfflineEntry { spec: &selfcal::SPEC, make: selfcal::make }];

/// The bits of the causal filter that are those of the offline one too: what the recording lacks.
const KEPT: u16 = status::ANY_MISSING | status::GAP | status::REPEATED;

/// The settings of the causal filter: those that say what is measured. What is computed with it is in east-north-up.
fn causal_settings(settings: &Settings) -> Settings {
    let Settings { gyr_hold, repeated, gyr_range, .. } = *settings;
    Settings { gyr_hold, repeated, gyr_range, ..Settings::default() }
}

/// The rotation from the causal filter's frame to the chosen one, with the heading of the start that is 0 there where no field has
/// given another one.
fn output_rotation(series: &Series, settings: &Settings, headed: bool) -> Quat<f64> {
    let frame = settings.output_rotation(headed);
    if headed || settings.frame == Frame::Enu {
        return frame;
    }
    let acc = usable(series.acc.as_deref(), series.gyr.len());
    let Some(first) = acc.iter().position(Option::is_some) else { return frame };
    // The rule of the start knows nothing of the filter.
    let start = |frame| {
        let settings = Settings { frame, ..causal_settings(settings) };
        let mut estimator = Estimator::<f64, GyroIntegration<f64>>::new(&Params::default(), settings);
        for ((&gyr, &dt), acc) in series.gyr.iter().zip(&series.dt).zip(&acc).take(first + 1) {
            estimator.step(gyr, *acc, None, dt);
        }
        estimator.quat()
    };
    (start(settings.frame) * start(Frame::Enu).conj()).unit_or(frame)
}

/// Leaves out the rows that the causal filter did not take for measurements; `bit` is that of the sensor.
fn leave_out(rows: &mut [Row], missing: &[u16], bit: u16) {
    for (row, missing) in rows.iter_mut().zip(missing) {
        if missing & bit != 0 {
            *row = None;
        }
    }
}

/// The rows of a sensor that hold a measurement.
fn usable(rows: Option<&[Vec3<f64>]>, samples: usize) -> Vec<Row> {
    let row = |&row: &Vec3<f64>| Some(Measured::new(row)).filter(|measured| measured.valid).map(|_| row);
    rows.map_or_else(|| vec![None; samples], |rows| rows.iter().map(row).collect())
}

/// The attitudes in the frame into which `to` turns, with signs that go on from each other; the first with w ≥ 0.
fn continuous(attitudes: &[Quat<f64>], to: Quat<f64>) -> Vec<Quat<f64>> {
    let mut before = Quat::identity();
    let turns = to.vector().norm2() > 0.0;
    let continued = |&q: &Quat<f64>| {
        let q = if turns { to * q } else { q };
        before = if q.dot(before) < 0.0 { -q } else { q };
        before
    };
    attitudes.iter().map(continued).collect()
}

/// The offline filter of a name.
pub fn offline_entry(name: &str) -> Option<&'static OfflineEntry> {
    OFFLINE.iter().find(|entry| entry.spec.name == name)
}

/// Runs all jobs, one on each thread at a time, until they are done or until it is told to stop.
pub fn run_all<T: Number>(jobs: &mut [Job<'_, T, dyn Offline>], asked: Option<usize>, watch: &Watch) {
    let mut jobs: Vec<_> = jobs.iter_mut().collect();
    // The longest first, so that all threads end at about the same time.
    jobs.sort_by_key(|job| std::cmp::Reverse(job.recording.gyr.nrows()));
    let samples: usize = jobs.iter().map(|job| job.recording.gyr.nrows()).sum();
    in_threads(threads(asked, jobs.len(), samples / SAMPLES), &mut jobs, |job| {
        if watch.go_on() {
            match contained(|| run(job.stream.as_ref(), &job.recording, &mut job.outputs, watch)) {
                Ok(finite) => job.infinite = !finite,
                Err(text) => job.panicked = Some(text),
            }
            watch.done(1);
        }
    });
}

/// Runs the filter over the recording; false where a measurement is infinite.
fn run<T: Number>(
    filter: &dyn Offline,
    recording: &Recording<'_, T>,
    outputs: &mut Outputs<'_, T>,
    watch: &Watch,
) -> bool {
    if sensors_infinite(recording, 0, recording.gyr.nrows()) {
        return false;
    }
    let mut dt = Vec::with_capacity(recording.gyr.nrows());
    recording.time.steps(&mut dt, 0, recording.gyr.nrows());
    let series = Series {
        gyr: vectors(&recording.gyr),
        acc: recording.acc.as_ref().map(vectors),
        mag: recording.mag.as_ref().map(vectors),
        dt,
    };
    let asked: Vec<_> = outputs.extra.iter().map(|(index, _)| *index).collect();
    let Some(solution) = filter.solve(&series, &asked, watch) else { return true };
    for (mut out, q) in outputs.quat.outer_iter_mut().zip(&solution.quat) {
        write(out.iter_mut(), [q.w, q.x, q.y, q.z]);
    }
    if let Some(out) = &mut outputs.gyr_bias {
        for (mut out, bias) in out.outer_iter_mut().zip(&solution.gyr_bias) {
            write(out.iter_mut(), [bias.x, bias.y, bias.z]);
        }
    }
    for (out, status) in outputs.status.iter_mut().zip(&solution.status) {
        *out = *status;
    }
    for ((_, out), values) in outputs.extra.iter_mut().zip(solution.extra) {
        write(out.iter_mut(), values);
    }
    true
}

/// The rows of an array.
fn vectors<T: Number>(view: &ArrayView2<'_, T>) -> Vec<Vec3<f64>> {
    let row = |row: ndarray::ArrayView1<'_, T>| {
        let mut values = row.into_iter().map(|value| value.to_f64());
        let mut next = || values.next().unwrap_or(f64::NAN);
        Vec3::new(next(), next(), next())
    };
    view.outer_iter().map(row).collect()
}

fn write<'a, T: Number>(out: impl Iterator<Item = &'a mut T>, values: impl IntoIterator<Item = f64>) {
    for (out, value) in out.zip(values) {
        *out = T::from_f64(value);
    }
}
