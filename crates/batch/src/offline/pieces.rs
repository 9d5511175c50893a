//! The pieces of a recording between rotations that nobody saw.

use std::ops::Range;

/// A loss cuts a recording where the standard deviation of its rotation is above this many rad (1°): where the estimator looks for
/// the attitude again.
const COUNTING: f64 = 0.017453292519943295;

/// Where a recording is cut.
#[derive(Debug, Default)]
pub struct Pieces {
    /// The samples of each piece: the first one is that at the end of a loss.
    pub ranges: Vec<Range<usize>>,
    /// Set in the samples amid a loss, whose attitude is that of neither piece.
    pub amid: Vec<bool>,
}

/// The pieces of a recording, by the variance in rad² that the step to each sample has lost.
pub fn pieces(lost: &[f64]) -> Pieces {
    let mut pieces = Pieces { ranges: Vec::new(), amid: vec![false; lost.len()] };
    let (mut start, mut at) = (0, 0);
    for run in lost.chunk_by(|a, b| (*a > 0.0) == (*b > 0.0)) {
        let end = at + run.len();
        if run.iter().sum::<f64>() >= COUNTING * COUNTING && end > start + 1 {
            // The last of them stands at the end of the loss.
            let last = end - 1;
            if let Some(amid) = pieces.amid.get_mut(at..last) {
                amid.fill(true);
            }
            if last > start {
                pieces.ranges.push(start..last);
                start = last;
            }
        }
        at = end;
    }
    pieces.ranges.push(start..lost.len());
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the pieces begin and end, and which samples are amid a loss.
    fn of(lost: &[f64]) -> (Vec<[usize; 2]>, Vec<usize>) {
        let Pieces { ranges, amid } = pieces(lost);
        let amid = amid.iter().enumerate().filter(|(_, amid)| **amid).map(|(index, _)| index);
        (ranges.iter().map(|range| [range.start, range.end]).collect(), amid.collect())
    }

    #[test]
    fn a_recording_without_a_loss_is_one_piece() {
        assert_eq!(of(&[0.0; 4]), (vec![[0, 4]], vec![]));
        assert_eq!(of(&[]), (vec![[0, 0]], vec![]));
    }

    #[test]
    fn a_piece_begins_with_the_last_sample_of_a_loss() {
        let lost = [0.0, 0.0, 0.1, 0.1, 0.1, 0.0, 0.5, 0.0];
        assert_eq!(of(&lost), (vec![[0, 4], [4, 6], [6, 8]], vec![2, 3]));
    }

    #[test]
    fn a_loss_at_either_end_leaves_no_empty_piece() {
        assert_eq!(of(&[0.1, 0.0, 0.0]), (vec![[0, 3]], vec![]));
        assert_eq!(of(&[0.1, 0.1, 0.0]), (vec![[0, 1], [1, 3]], vec![0]));
        assert_eq!(of(&[0.0, 0.0, 0.1]), (vec![[0, 2], [2, 3]], vec![]));
    }

    #[test]
    fn a_small_loss_cuts_nothing() {
        assert_eq!(of(&[0.0, 1e-4, 1e-4, 0.0]), (vec![[0, 4]], vec![]));
        // Together they count.
        assert_eq!(of(&[0.0, 2e-4, 2e-4, 0.0]), (vec![[0, 2], [2, 4]], vec![1]));
    }
}
