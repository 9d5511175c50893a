//! Whole recordings through the filters of [`ahrs_rs`]: every registered filter behind one type, on all cores.
//!
//! - [`registry`]: the filters by name, each as a [`Stream`] of `f32` or `f64`;
//! - [`stream`]: a filter that takes one sample after the other, or a tile of them;
//! - [`offline`]: filters that take a whole recording, and their registry;
//! - [`recording`]: arrays in, arrays out, cut into tiles;
//! - [`simd`], [`bank`], [`lanes`]: several recordings or parameter sets side by side in vector registers;
//! - [`threads`]: many recordings at once;
//! - [`sweep`], [`metric`]: the errors of many parameter sets against a reference.

mod ahead;
pub mod bank;
pub mod lanes;
pub mod metric;
pub mod offline;
pub mod recording;
pub mod registry;
pub mod simd;
mod stage;
pub mod stream;
pub mod sweep;
#[cfg(test)]
mod tests;
pub mod threads;
mod transpose;

pub use offline::{OFFLINE, Offline, OfflineEntry, offline_entry};
pub use recording::{Outputs, Recording, Time};
pub use registry::{Entry, Number, entries, entry};
pub use stream::{Stream, Tile};
