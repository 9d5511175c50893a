//! `SelfCalKF`: its derivatives, what it finds of planted faults, and whether it knows how wrong it is.

#![allow(clippy::indexing_slicing, clippy::unwrap_used, reason = "a test that fails may panic")]
#![allow(clippy::cast_precision_loss, reason = "small counters")]
#![allow(clippy::needless_range_loop, reason = "indices of states, of several arrays at once")]

#[path = "selfcal/consistency.rs"]
mod consistency;
#[path = "selfcal/derivatives.rs"]
mod derivatives;
#[path = "selfcal/planted.rs"]
mod planted;
#[path = "support/random.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod random;

use ahrs_rs::Filter;
use ahrs_rs::filters::{SelfCalKF, selfcal};
use ahrs_rs::params::{ParamSet, ParamSpec};

type Params = <SelfCalKF<f64> as Filter<f64>>::Params;

fn params() -> Params {
    with(&[])
}

/// The defaults with other values.
fn with(changes: &[(&str, f64)]) -> Params {
    let specs = selfcal::SPEC.params;
    let mut values: Vec<_> = specs.iter().map(ParamSpec::default).collect();
    for (name, value) in changes {
        values[specs.iter().position(|spec| spec.name == *name).unwrap()] = *value;
    }
    Params::from_values(&values).unwrap()
}
