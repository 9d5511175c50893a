//! Lanes against scalars, sweeps against runs, for every registered filter and every set of instructions of the machine.

#![allow(clippy::indexing_slicing, clippy::unwrap_used, reason = "what is wrong fails the test, as it should")]
#![allow(clippy::panic, reason = "a worker that panics is what is tested")]

mod data;
mod lanes;
#[path = "../../../../tests/support/random.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod random;
mod selfcal;
mod sweep;
mod threads;
mod transpose;
