//! Lanes have the bits of scalars.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::data::{choices, recordings, run};
use crate::isa;
use crate::registry::{ENTRIES, Number};
use crate::threads::in_threads;

fn lanes_equal_scalars<T: Number>() {
    let data = recordings::<T>();
    assert!(!isa::available().is_empty());
    for entry in ENTRIES.iter() {
        for values in choices(entry.spec) {
            let alone = run(entry, &values, &data, None, Some(1));
            for isa in isa::available() {
                for threads in [1, 3] {
                    let beside = run(entry, &values, &data, Some(isa), Some(threads));
                    for (index, (beside, alone)) in beside.iter().zip(&alone).enumerate() {
                        assert!(beside == alone, "{} {values:?} {isa:?} {}, {index}", entry.spec.name, T::DTYPE);
                    }
                }
            }
        }
    }
}

#[test]
fn every_filter_in_lanes_of_f64_equals_itself_alone() {
    lanes_equal_scalars::<f64>();
}

#[test]
fn every_filter_in_lanes_of_f32_equals_itself_alone() {
    lanes_equal_scalars::<f32>();
}

#[test]
fn a_panic_of_a_worker_reaches_the_caller() {
    let done = AtomicUsize::new(0);
    let mut items = [0, 1, 2, 3];
    let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        in_threads(Some(2), &mut items, |item| {
            assert!(*item != 2, "planted");
            done.fetch_add(1, Ordering::Relaxed);
        });
    }));
    assert!(caught.is_err());
}
