//! A filter of any kind as one object that goes on from sample to sample.

use std::iter::Peekable;

use ahrs_rs::params::{ParamError, ParamSet};
use ahrs_rs::{Estimator, Filter, Mask, Quat, Reading, Real, Settings, Vec3};

use crate::is_small;

/// Samples whose readings are computed ahead of the steps.
const AHEAD: usize = 64;

/// A quaternion whose squared norm is further from one was not written by a filter: in `f32` it stays within 1e-6.
const NORM_TOLERANCE: f64 = 1e-5;

/// A run of samples, and room for what comes out.
pub struct Tile<'a, T> {
    /// Angular rates in rad/s.
    pub gyr: &'a [[T; 3]],
    /// Specific forces in m/s², as many, or none.
    pub acc: Option<&'a [[T; 3]]>,
    /// Magnetic fields in µT, as many, or none.
    pub mag: Option<&'a [[T; 3]]>,
    /// The time in s since the sample before, as many.
    pub dt: &'a [T],
    /// Attitudes out.
    pub quat: &'a mut [[T; 4]],
    /// Gyroscope biases out, or none.
    pub gyr_bias: Option<&'a mut [[T; 3]]>,
    /// Status bits out.
    pub status: &'a mut [u16],
    /// Indices of further outputs of the filter, each with the rows' values one after the other.
    pub extra: &'a mut [(usize, Vec<T>)],
}

/// A filter that takes samples in order of time.
pub trait Stream<T>: Send + Sync {
    /// Sets the attitude one step before the first sample.
    fn start_from(&mut self, q0: [T; 4]);
    /// True where nothing has come and no attitude was given, so that the first sample's step does not matter.
    fn is_fresh(&self) -> bool;
    /// Goes on by one sample and gives the status bits.
    fn update(&mut self, gyr: [T; 3], acc: Option<[T; 3]>, mag: Option<[T; 3]>, dt: T) -> u16;
    /// Goes on by the samples of a tile. Stops at the shortest of the slices.
    fn run(&mut self, tile: &mut Tile<'_, T>);
    /// The last attitude.
    fn quat(&self) -> [T; 4];
    /// The gyroscope's bias, or none.
    fn gyr_bias(&self) -> Option<[T; 3]>;
    /// True where the bias is zero at every sample.
    fn bias_stays_zero(&self) -> bool;
    /// The values of output `index` of the filter's description after the last sample.
    fn output(&self, index: usize) -> Vec<T>;
    /// Every variable that the next step depends on.
    fn save(&mut self) -> Vec<f64>;
    /// Takes back what [`Stream::save`] gave; false, and nothing changed, where the number of values is another.
    fn load(&mut self, values: &[f64]) -> bool;
    /// Whether the attitudes among the variables are unit quaternions, which [`Stream::load`] does not look at.
    fn is_unit(&self) -> bool;
}

/// The stream of filter `F` with the values of its parameters.
pub fn stream<T: Real, F>(values: &[f64], settings: Settings) -> Result<Box<dyn Stream<T>>, ParamError>
where
    F: Filter<T> + Send + Sync + 'static,
{
    Ok(Box::new(Estimator::<T, F>::new(&F::Params::from_values(values)?, settings)))
}

fn vec3<T: Real>([x, y, z]: [T; 3]) -> Vec3<T> {
    Vec3 { x, y, z }
}

fn array3<T: Real>(v: Vec3<T>) -> [T; 3] {
    [v.x, v.y, v.z]
}

fn array4<T: Real>(q: Quat<T>) -> [T; 4] {
    [q.w, q.x, q.y, q.z]
}

/// The steps up to the end of the input or to a reading that needs attention first.
#[inline(always)]
fn steps<'a, 'b, T: Real, F: Filter<T>>(
    estimator: &mut Estimator<T, F>,
    input: &mut Peekable<impl Iterator<Item = (&'a Reading<T>, T)>>,
    out: &mut impl Iterator<Item = (&'b mut [T; 4], &'b mut u16)>,
    gyr_bias: &mut Option<impl Iterator<Item = &'b mut [T; 3]>>,
    extra: &mut [(usize, Vec<T>)],
) {
    while let Some((reading, dt)) = input.next_if(|&(reading, dt)| !estimator.needs_attention(reading, dt)) {
        let output = estimator.go_on(reading, dt);
        let Some((quat, status)) = out.next() else { break };
        *quat = array4(output.quat);
        *status = output.flags.bits(0);
        if let Some(row) = gyr_bias.as_mut().and_then(Iterator::next) {
            *row = array3(estimator.filter().gyr_bias());
        }
        for (index, values) in extra.iter_mut() {
            estimator.filter().output(*index, &mut |value| values.push(value));
        }
    }
}

impl<T: Real, F: Filter<T> + Send + Sync> Stream<T> for Estimator<T, F> {
    fn start_from(&mut self, [w, x, y, z]: [T; 4]) {
        Estimator::start_from(self, Quat { w, x, y, z });
    }

    fn is_fresh(&self) -> bool {
        Estimator::is_fresh(self).all()
    }

    fn update(&mut self, gyr: [T; 3], acc: Option<[T; 3]>, mag: Option<[T; 3]>, dt: T) -> u16 {
        self.step(vec3(gyr), acc.map(vec3), mag.map(vec3), dt).flags.bits(0)
    }

    fn run(&mut self, tile: &mut Tile<'_, T>) {
        let mut acc = tile.acc.map(<[_]>::iter);
        let mut mag = tile.mag.map(<[_]>::iter);
        let mut gyr_bias = tile.gyr_bias.as_mut().map(|rows| rows.iter_mut());
        for (_, values) in tile.extra.iter_mut() {
            values.clear();
        }
        // A step waits for the one before it; what does not wait is computed ahead, so that it fills no place in the
        // processor's window among instructions that wait.
        let nothing = Reading::new(Vec3::zero(), None, None);
        let mut readings = [nothing; AHEAD];
        let n = tile.gyr.len().min(tile.dt.len()).min(tile.quat.len()).min(tile.status.len());
        let (gyr, dt) = (tile.gyr.get(..n).unwrap_or_default(), tile.dt.get(..n).unwrap_or_default());
        let mut out = tile.quat.iter_mut().zip(tile.status.iter_mut());
        for (gyr, dt) in gyr.chunks(AHEAD).zip(dt.chunks(AHEAD)) {
            for (reading, &gyr) in readings.iter_mut().zip(gyr) {
                let acc = acc.as_mut().and_then(Iterator::next).map(|&row| vec3(row));
                let mag = mag.as_mut().and_then(Iterator::next).map(|&row| vec3(row));
                *reading = Reading::new(vec3(gyr), acc, mag);
            }
            let mut input = readings.iter().zip(dt.iter().copied()).peekable();
            // What is rare is apart from the steps, so that it costs them nothing.
            while let Some(&(reading, dt)) = input.peek() {
                if self.needs_attention(reading, dt) {
                    self.attend_apart(reading, dt);
                }
                if const { is_small::<Self, T>() } {
                    let mut copy = self.clone();
                    steps(&mut copy, &mut input, &mut out, &mut gyr_bias, tile.extra);
                    *self = copy;
                } else {
                    steps(self, &mut input, &mut out, &mut gyr_bias, tile.extra);
                }
            }
        }
    }

    fn quat(&self) -> [T; 4] {
        array4(Estimator::quat(self))
    }

    fn gyr_bias(&self) -> Option<[T; 3]> {
        F::SPEC.gyr_bias.then(|| array3(self.filter().gyr_bias()))
    }

    fn bias_stays_zero(&self) -> bool {
        let bias = self.filter().gyr_bias();
        self.filter().bias_stays_zero() && bias.norm2().le(T::zero())
    }

    fn output(&self, index: usize) -> Vec<T> {
        let mut values = Vec::new();
        self.filter().output(index, &mut |value| values.push(value));
        values
    }

    fn save(&mut self) -> Vec<f64> {
        let mut values = Vec::new();
        self.each_variable(&mut |value| values.push(value.to_f64()));
        values
    }

    fn load(&mut self, values: &[f64]) -> bool {
        let mut count = 0;
        self.each_variable(&mut |_| count += 1);
        if count != values.len() {
            return false;
        }
        let mut values = values.iter();
        self.each_variable(&mut |value| {
            if let Some(&saved) = values.next() {
                *value = T::from_f64(saved);
            }
        });
        true
    }

    fn is_unit(&self) -> bool {
        [Estimator::quat(self), self.filter().attitude()]
            .iter()
            .all(|q| (q.dot(*q) - T::one()).abs().le(T::of(NORM_TOLERANCE)))
    }
}
