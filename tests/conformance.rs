//! The laws that every registered filter keeps, over every kind of scalar and every combination of its choices.
//!
//! Nothing here knows a filter by name: a new one in the registry is tested by being there.

#![allow(clippy::indexing_slicing, clippy::unwrap_used, reason = "a test that fails may panic")]
#![allow(clippy::float_cmp, reason = "where a law is exact it is tested exactly")]
#![allow(clippy::cast_precision_loss, reason = "small counters")]

#[path = "conformance/bank.rs"]
mod bank;
#[path = "conformance/claims.rs"]
mod claims;
#[path = "support/double_double.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod double_double;
#[path = "conformance/equivariance.rs"]
mod equivariance;
#[path = "conformance/hostile.rs"]
mod hostile;
#[path = "conformance/lanes.rs"]
mod lanes;
#[path = "conformance/missing.rs"]
mod missing;
#[path = "conformance/norm.rs"]
mod norm;
#[path = "support/random.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod random;
#[path = "conformance/recording.rs"]
mod recording;
#[path = "conformance/settings.rs"]
mod settings;
#[path = "conformance/snapshot.rs"]
mod snapshot;
#[path = "conformance/start.rs"]
mod start;

#[test]
fn the_registry_is_not_empty() {
    assert!(!ahrs_rs::filters::SPECS.is_empty());
    let kinds = 5;
    assert_eq!(bank::cases().len(), kinds * ahrs_rs::filters::SPECS.len());
    assert_eq!(bank::scalars().len(), 2 * ahrs_rs::filters::SPECS.len());
    for spec in ahrs_rs::filters::SPECS {
        assert!(!bank::choices(spec).is_empty() && bank::extremes(spec).len() >= bank::choices(spec).len());
    }
}
