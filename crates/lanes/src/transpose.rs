//! Numbers of several recordings into the order of lanes, and back, number by number.
//!
//! [`Instructions`](crate::simd::Instructions) do it for many at once; this is for the rest.

/// Writes rows of lanes, from number `first` of the sources on.
pub fn interleave<E: Copy>(to: &mut [E], from: &[&[E]], first: usize) {
    for (k, row) in to.chunks_exact_mut(from.len().max(1)).enumerate().skip(first) {
        for (place, source) in row.iter_mut().zip(from) {
            if let Some(&value) = source.get(k) {
                *place = value;
            }
        }
    }
}

/// Reads rows of lanes, from row `first` on, into the places of the first lanes.
pub fn deinterleave<E: Copy>(from: &[E], lanes: usize, to: &mut [&mut [E]], first: usize) {
    for (k, row) in from.chunks_exact(lanes.max(1)).enumerate().skip(first) {
        for (&value, places) in row.iter().zip(to.iter_mut()) {
            if let Some(place) = places.get_mut(k) {
                *place = value;
            }
        }
    }
}
