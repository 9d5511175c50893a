//! Lanes have the bits of scalars.

use super::data::{choices, recordings, run};
use crate::isa;
use crate::registry::{ENTRIES, Number};

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
