//! What is put into lanes comes out of them.

use ahrs_rs::Settings;

use crate::isa;
use crate::registry::{ENTRIES, Number};

fn every_number_is_in_its_row_and_lane_and_comes_back<T: Number>() {
    for isa in isa::available() {
        let bank = T::bank(&ENTRIES[0], isa, &[], Settings::default()).unwrap().unwrap();
        let lanes = bank.lanes();
        for rows in [0, 1, 7, 8, 9, 16, 64, 100] {
            let number = |row: usize, lane: usize| T::from_f64((100 * row + lane) as f64);
            let sources: Vec<Vec<T>> =
                (0..lanes).map(|lane| (0..rows).map(|row| number(row, lane)).collect()).collect();
            let slices: Vec<_> = sources.iter().map(Vec::as_slice).collect();
            let mut together = vec![T::NAN; lanes * rows];
            bank.interleave(&mut together, &slices);
            for row in 0..rows {
                for lane in 0..lanes {
                    assert_eq!(together[row * lanes + lane], number(row, lane), "{isa:?}");
                }
            }
            // Lanes without a place are left out.
            for places in [lanes, 1] {
                let mut back = vec![vec![T::NAN; rows]; places];
                bank.deinterleave(&together, &mut back.iter_mut().map(Vec::as_mut_slice).collect::<Vec<_>>());
                assert_eq!(back, sources[..places], "{isa:?}");
            }
        }
    }
}

#[test]
fn numbers_of_f64_come_back() {
    every_number_is_in_its_row_and_lane_and_comes_back::<f64>();
}

#[test]
fn numbers_of_f32_come_back() {
    every_number_is_in_its_row_and_lane_and_comes_back::<f32>();
}
