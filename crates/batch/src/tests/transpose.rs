//! What is put into lanes comes out of them.

use crate::transpose::{deinterleave, interleave};

#[test]
fn every_number_is_in_its_row_and_lane_and_comes_back() {
    for lanes in [1, 2, 3, 4, 8, 16, 32] {
        for rows in [0, 1, 7, 8, 9, 64, 100] {
            let sources: Vec<Vec<usize>> =
                (0..lanes).map(|lane| (0..rows).map(|row| 1000 * row + lane).collect()).collect();
            let slices: Vec<_> = sources.iter().map(Vec::as_slice).collect();
            let mut together = vec![usize::MAX; lanes * rows];
            interleave(&mut together, &slices);
            for row in 0..rows {
                for lane in 0..lanes {
                    assert_eq!(together[row * lanes + lane], 1000 * row + lane);
                }
            }
            let mut back = vec![vec![usize::MAX; rows]; lanes];
            let mut places: Vec<_> = back.iter_mut().map(Vec::as_mut_slice).collect();
            deinterleave(&together, lanes, &mut places);
            assert_eq!(back, sources);
        }
    }
}

#[test]
fn lanes_without_a_place_are_left_out() {
    let together: Vec<usize> = (0..8 * 20).collect();
    let mut back = vec![vec![usize::MAX; 20]; 3];
    let mut places: Vec<_> = back.iter_mut().map(Vec::as_mut_slice).collect();
    let mut none: [usize; 0] = [];
    places.push(&mut none);
    deinterleave(&together, 8, &mut places);
    for (lane, back) in back.iter().enumerate() {
        assert_eq!(*back, (0..20).map(|row| 8 * row + lane).collect::<Vec<_>>());
    }
}
