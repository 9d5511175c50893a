//! Software prefetch of the memory that the next tile needs, while this one is computed.
//!
//! Recordings side by side are many memory streams, a short piece of each at a time: more than the hardware prefetcher tracks.

use crate::simd::Vector;

/// Bytes of a cache line.
pub const CACHE_LINE: usize = 64;

/// Cache lines to prefetch, in order. Addresses only: nothing is read or written through them.
pub struct PrefetchPlan {
    /// The first byte of each part, and how many lines it has.
    parts: Vec<(*const u8, usize)>,
    lines: usize,
}

impl PrefetchPlan {
    /// A plan without any line.
    pub const fn new() -> Self {
        PrefetchPlan { parts: Vec::new(), lines: 0 }
    }

    /// Forgets all parts.
    pub fn clear(&mut self) {
        self.parts.clear();
        self.lines = 0;
    }

    /// Adds values that will be read or written.
    pub fn add<E>(&mut self, values: &[E]) {
        let lines = size_of_val(values).div_ceil(CACHE_LINE);
        self.parts.push((values.as_ptr().cast(), lines));
        self.lines += lines;
    }

    /// Spreads the lines evenly over a number of rows.
    #[inline(always)]
    pub fn spread_over(&self, rows: usize) -> Prefetcher<'_> {
        Prefetcher { parts: &self.parts, line: 0, lines_per_row: self.lines.div_ceil(rows.max(1)) }
    }
}

impl Default for PrefetchPlan {
    fn default() -> Self {
        Self::new()
    }
}

/// The lines of a plan that are not prefetched yet.
pub struct Prefetcher<'a> {
    parts: &'a [(*const u8, usize)],
    /// The next line of the first part.
    line: usize,
    lines_per_row: usize,
}

impl Prefetcher<'_> {
    /// Prefetches the lines of one row.
    #[inline(always)]
    pub fn prefetch_row<S: Vector>(&mut self) {
        for _ in 0..self.lines_per_row {
            let Some(&(start, lines)) = self.parts.first() else { return };
            S::prefetch(start.wrapping_add(CACHE_LINE * self.line));
            self.line += 1;
            if self.line >= lines {
                self.line = 0;
                self.parts = self.parts.get(1..).unwrap_or_default();
            }
        }
    }
}
