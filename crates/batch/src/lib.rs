//! Whole recordings through the filters of [`ahrs_rs`]: every registered filter behind one type, on all cores.
//!
//! - [`registry`]: the filters by name, each as a [`Stream`] of `f32` or `f64`;
//! - [`stream`]: a filter that takes one sample after the other, or a tile of them;
//! - [`recording`]: arrays in, arrays out, cut into tiles;
//! - [`threads`]: many recordings at once.

pub mod recording;
pub mod registry;
pub mod stream;
pub mod threads;

pub use recording::{Outputs, Recording, Time};
pub use registry::{Entry, Number, entries, entry};
pub use stream::{Stream, Tile};
