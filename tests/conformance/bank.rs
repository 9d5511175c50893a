//! Every registered filter over every kind of scalar, behind one interface in `f64`.
//!
//! Numbers of `f32` are exact in `f64`, so comparing the bits of what a bank gives compares the bits of its lanes.

use ahrs_rs::params::{ParamKind, ParamSet, ParamSpec};
use ahrs_rs::{Estimator, Filter, FilterSpec, Flags, Frame, GyrHold, Pair, Quat, Real, Scalar, Settings, Vec3};

use crate::random::Random;

/// One sample of one recording.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    pub gyr: [f64; 3],
    pub acc: [f64; 3],
    pub mag: [f64; 3],
    pub dt: f64,
}

/// Which sensors there are at all; a missing row of one that is there is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors {
    pub acc: bool,
    pub mag: bool,
}

pub const NONE: Sensors = Sensors { acc: false, mag: false };
pub const ACC: Sensors = Sensors { acc: true, mag: false };
pub const BOTH: Sensors = Sensors { acc: true, mag: true };

/// What one lane shows after a sample.
#[derive(Clone, Debug)]
pub struct Reading {
    pub quat: [f64; 4],
    pub gyr_bias: [f64; 3],
    pub status: u16,
    pub outputs: Vec<f64>,
}

impl Reading {
    /// The outputs, for comparisons to the last bit: NaN equals NaN.
    pub fn output_bits(&self) -> Vec<u64> {
        self.outputs.iter().map(|value| value.to_bits()).collect()
    }
    /// Everything, for comparisons to the last bit.
    pub fn bits(&self) -> Vec<u64> {
        let values = self.quat.iter().chain(&self.gyr_bias).chain(&self.outputs);
        values.map(|value| value.to_bits()).chain([u64::from(self.status)]).collect()
    }
}

/// A filter with one or more lanes.
pub trait Bank {
    fn start_from(&mut self, q0: &[[f64; 4]]);
    /// One sample; a row for each lane.
    fn step(&mut self, rows: &[Row], sensors: Sensors);
    fn read(&self, lane: usize) -> Reading;
    /// Every variable of a lane that the next step depends on.
    fn save(&mut self, lane: usize) -> Vec<f64>;
    fn load(&mut self, lane: usize, variables: &[f64]);
}

struct Running<S: Scalar, F> {
    estimator: Estimator<S, F>,
    quat: Quat<S>,
    flags: Flags<S::Mask>,
}

/// A scalar whose lanes are given one by one.
fn gathered<S: Scalar>(lane: impl Fn(usize) -> f64) -> S {
    let mut value = S::zero();
    for index in 0..S::LANES {
        value.set_lane(index, S::Real::from_f64(lane(index)));
    }
    value
}

fn gathered3<S: Scalar>(lane: impl Fn(usize) -> [f64; 3]) -> Vec3<S> {
    let [x, y, z] = [0, 1, 2].map(|part| gathered(|index| lane(index)[part]));
    Vec3::new(x, y, z)
}

impl<S: Scalar, F: Filter<S>> Bank for Running<S, F> {
    fn start_from(&mut self, q0: &[[f64; 4]]) {
        let [w, x, y, z] = [0, 1, 2, 3].map(|part| gathered(|lane| q0[lane][part]));
        self.estimator.start_from(Quat::new(w, x, y, z));
    }

    fn step(&mut self, rows: &[Row], sensors: Sensors) {
        assert_eq!(rows.len(), S::LANES);
        let acc = sensors.acc.then(|| gathered3(|lane| rows[lane].acc));
        let mag = sensors.mag.then(|| gathered3(|lane| rows[lane].mag));
        let output = self.estimator.step(gathered3(|lane| rows[lane].gyr), acc, mag, gathered(|lane| rows[lane].dt));
        (self.quat, self.flags) = (output.quat, output.flags);
    }

    fn read(&self, lane: usize) -> Reading {
        let of = |value: S| value.lane(lane).to_f64();
        let (quat, bias) = (self.quat, self.estimator.filter().gyr_bias());
        let mut outputs = Vec::new();
        for (index, output) in F::SPEC.outputs.iter().enumerate() {
            let before = outputs.len();
            self.estimator.filter().output(index, &mut |value| outputs.push(of(value)));
            assert_eq!(outputs.len() - before, output.len(), "the row of {} has its shape", output.name);
        }
        Reading {
            quat: [of(quat.w), of(quat.x), of(quat.y), of(quat.z)],
            gyr_bias: [of(bias.x), of(bias.y), of(bias.z)],
            status: self.flags.bits(lane),
            outputs,
        }
    }

    fn save(&mut self, lane: usize) -> Vec<f64> {
        let mut variables = Vec::new();
        self.estimator.each_variable(&mut |value| variables.push(value.lane(lane).to_f64()));
        variables
    }

    fn load(&mut self, lane: usize, variables: &[f64]) {
        let mut saved = variables.iter();
        self.estimator.each_variable(&mut |value| {
            value.set_lane(lane, S::Real::from_f64(*saved.next().unwrap()));
        });
        assert!(saved.next().is_none());
    }
}

/// One filter over one kind of scalar.
pub struct Case {
    pub spec: &'static FilterSpec,
    pub lanes: usize,
    pub real: &'static str,
    pub epsilon: f64,
    /// Whether the first sample is a step like any other.
    pub starts_itself: bool,
    /// Whether it weighs by a covariance, so that a loss of any length counts.
    pub has_covariance: bool,
    make: fn(&[f64], Settings) -> Box<dyn Bank>,
}

impl Case {
    pub fn make(&self, params: &[f64], settings: Settings) -> Box<dyn Bank> {
        (self.make)(params, settings)
    }
    pub fn name(&self) -> String {
        format!("{} over {} x {}", self.spec.name, self.real, self.lanes)
    }
}

fn case<S: Scalar, F: Filter<S> + 'static>() -> Case {
    Case {
        spec: F::SPEC,
        lanes: S::LANES,
        real: if S::Real::EPSILON.to_f64() > 1e-10 { "f32" } else { "f64" },
        epsilon: S::Real::EPSILON.to_f64(),
        starts_itself: F::STARTS_ITSELF,
        has_covariance: F::HAS_COVARIANCE || F::WATCHED,
        make: |params, settings| {
            let estimator = Estimator::<S, F>::new(&F::Params::from_values(params).unwrap(), settings);
            Box::new(Running { quat: estimator.quat(), flags: Flags::none(), estimator })
        },
    }
}

macro_rules! cases {
    ($($filter:path),+) => {
        /// Every filter of the registry over every kind of scalar.
        pub fn cases() -> Vec<Case> {
            let mut all = Vec::new();
            $({
                use $filter as F;
                all.extend([
                    case::<f32, F<f32>>(),
                    case::<f64, F<f64>>(),
                    case::<Pair<f64>, F<Pair<f64>>>(),
                    case::<Pair<Pair<f64>>, F<Pair<Pair<f64>>>>(),
                    case::<Pair<Pair<f32>>, F<Pair<Pair<f32>>>>(),
                ]);
            })+
            assert!(!all.is_empty(), "the registry is empty");
            all
        }
    };
}
ahrs_rs::for_each_filter!(cases);

/// The filters over one number at a time: `f32` and `f64`.
pub fn scalars() -> Vec<Case> {
    cases().into_iter().filter(|case| case.lanes == 1).collect()
}

/// The filters over `f64`, for laws that are about the mathematics.
pub fn doubles() -> Vec<Case> {
    scalars().into_iter().filter(|case| case.real == "f64").collect()
}

/// Every combination of values that `of` gives for each parameter.
fn combinations(spec: &FilterSpec, of: impl Fn(&ParamKind) -> Vec<f64>) -> Vec<Vec<f64>> {
    spec.params.iter().fold(vec![Vec::new()], |sets, param| {
        let values = of(&param.kind);
        let extended = |set: &Vec<f64>| {
            let set = set.clone();
            values.iter().map(move |&value| [set.as_slice(), &[value]].concat()).collect::<Vec<_>>()
        };
        sets.iter().flat_map(extended).collect()
    })
}

fn indices(options: &[&str]) -> Vec<f64> {
    (0..options.len()).map(|index| index as f64).collect()
}

/// Both values of a switch, the default first.
fn switched(default: bool) -> Vec<f64> {
    [default, !default].map(|on| f64::from(u8::from(on))).to_vec()
}

/// Every combination of choices and switches, numbers at their defaults; the defaults come first.
pub fn choices(spec: &FilterSpec) -> Vec<Vec<f64>> {
    combinations(spec, |kind| match *kind {
        ParamKind::Real { default, .. } => vec![default],
        ParamKind::Choice { options } => indices(options),
        ParamKind::Switch { default } => switched(default),
    })
}

/// Combinations of the defaults and both ends of every number with every choice: all of them where they are few, else
/// each end alone, all ends together and a hundred at random.
pub fn extremes(spec: &FilterSpec) -> Vec<Vec<f64>> {
    let of = |kind: &ParamKind| match *kind {
        ParamKind::Real { default, min, max, .. } => vec![default, min, max],
        ParamKind::Choice { options } => indices(options),
        ParamKind::Switch { default } => switched(default),
    };
    if spec.params.iter().map(|param| of(&param.kind).len()).product::<usize>() <= 500 {
        return combinations(spec, of);
    }
    let mut sets = choices(spec);
    for (index, param) in spec.params.iter().enumerate() {
        for value in of(&param.kind) {
            let mut set: Vec<_> = spec.params.iter().map(ParamSpec::default).collect();
            set[index] = value;
            sets.push(set);
        }
    }
    for end in [1, 2] {
        sets.push(spec.params.iter().map(|param| *of(&param.kind).get(end).unwrap_or(&0.0)).collect());
    }
    let mut random = Random(31);
    let mut any = |param: &ParamSpec| {
        let values = of(&param.kind);
        values[random.below(values.len())]
    };
    sets.extend((0..100).map(|_| spec.params.iter().map(&mut any).collect::<Vec<_>>()));
    sets
}

/// Every frame and hold, with and without declination.
pub fn settings() -> Vec<Settings> {
    let mut all = Vec::new();
    for (_, frame) in Frame::ALL {
        for (_, gyr_hold) in GyrHold::ALL {
            all.extend([0.0, -0.2].map(|declination| Settings { frame, declination, gyr_hold, ..Settings::default() }));
        }
    }
    all
}

/// A bank of one lane over the rows: what it shows after each.
pub fn run(bank: &mut dyn Bank, rows: &[Row], sensors: Sensors) -> Vec<Reading> {
    let step = |row: &Row| {
        bank.step(&[*row], sensors);
        bank.read(0)
    };
    rows.iter().map(step).collect()
}
