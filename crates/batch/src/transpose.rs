//! Numbers of several recordings into the order of lanes, and back.

/// Numbers of each recording that are moved together.
const BLOCK: usize = 8;

/// Writes the first number of every source, then the second of every source, and so on; as many sources as lanes.
///
/// All sources hold as many numbers as there is room for in a lane.
pub fn interleave<T: Copy>(to: &mut [T], from: &[&[T]]) {
    match from.len() {
        2 => interleave_in::<T, 2>(to, from),
        4 => interleave_in::<T, 4>(to, from),
        8 => interleave_in::<T, 8>(to, from),
        16 => interleave_in::<T, 16>(to, from),
        32 => interleave_in::<T, 32>(to, from),
        lanes => interleave_rest(to, from, lanes, 0),
    }
}

/// Takes apart what [`interleave`] put together, for the first lanes, as many as there are places.
pub fn deinterleave<T: Copy>(from: &[T], lanes: usize, to: &mut [&mut [T]]) {
    match lanes {
        2 => deinterleave_in::<T, 2>(from, to),
        4 => deinterleave_in::<T, 4>(from, to),
        8 => deinterleave_in::<T, 8>(from, to),
        16 => deinterleave_in::<T, 16>(from, to),
        32 => deinterleave_in::<T, 32>(from, to),
        _ => deinterleave_rest(from, lanes, to, 0),
    }
}

/// Blocks of known size, in which no index is checked.
#[allow(clippy::indexing_slicing, reason = "indices below the lengths of arrays")]
fn interleave_in<T: Copy, const L: usize>(to: &mut [T], from: &[&[T]]) {
    let rows = to.as_chunks_mut::<L>().0;
    let (blocks, _) = rows.as_chunks_mut::<BLOCK>();
    let whole = blocks.len();
    for (index, block) in blocks.iter_mut().enumerate() {
        for (lane, source) in from.iter().enumerate().take(L) {
            let Some(values) = source.as_chunks::<BLOCK>().0.get(index) else { continue };
            for k in 0..BLOCK {
                block[k][lane] = values[k];
            }
        }
    }
    interleave_rest(to, from, L, whole * BLOCK);
}

fn interleave_rest<T: Copy>(to: &mut [T], from: &[&[T]], lanes: usize, first: usize) {
    for (k, row) in to.chunks_exact_mut(lanes.max(1)).enumerate().skip(first) {
        for (place, source) in row.iter_mut().zip(from) {
            if let Some(&value) = source.get(k) {
                *place = value;
            }
        }
    }
}

#[allow(clippy::indexing_slicing, reason = "indices below the lengths of arrays")]
fn deinterleave_in<T: Copy, const L: usize>(from: &[T], to: &mut [&mut [T]]) {
    let rows = from.as_chunks::<L>().0;
    let (blocks, _) = rows.as_chunks::<BLOCK>();
    for (index, block) in blocks.iter().enumerate() {
        for (lane, places) in to.iter_mut().enumerate().take(L) {
            let Some(values) = places.as_chunks_mut::<BLOCK>().0.get_mut(index) else { continue };
            for k in 0..BLOCK {
                values[k] = block[k][lane];
            }
        }
    }
    deinterleave_rest(from, L, to, blocks.len() * BLOCK);
}

fn deinterleave_rest<T: Copy>(from: &[T], lanes: usize, to: &mut [&mut [T]], first: usize) {
    for (k, row) in from.chunks_exact(lanes.max(1)).enumerate().skip(first) {
        for (&value, places) in row.iter().zip(to.iter_mut()) {
            if let Some(place) = places.get_mut(k) {
                *place = value;
            }
        }
    }
}
