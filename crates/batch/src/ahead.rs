//! Memory that the next tile needs, asked for while this one is computed.
//!
//! Recordings side by side are many streams through memory, a short piece of each at a time: more than the processor
//! foresees by itself.

use crate::simd::Vector;

/// A line of the cache in bytes.
pub const LINE: usize = 64;

/// Lines of memory that are asked for one after the other. Addresses only: nothing is read or written through them.
pub struct Ahead {
    /// The first byte of each part, and how many lines it has.
    parts: Vec<(*const u8, usize)>,
    lines: usize,
}

impl Ahead {
    /// Nothing to ask for.
    pub const fn none() -> Self {
        Ahead { parts: Vec::new(), lines: 0 }
    }

    /// Forgets all parts.
    pub fn clear(&mut self) {
        self.parts.clear();
        self.lines = 0;
    }

    /// Values that will be read or written.
    pub fn add<E>(&mut self, values: &[E]) {
        let lines = size_of_val(values).div_ceil(LINE);
        self.parts.push((values.as_ptr().cast(), lines));
        self.lines += lines;
    }

    /// Spreads the lines over as many rows.
    #[inline(always)]
    pub fn over(&self, rows: usize) -> Asking<'_> {
        Asking { parts: &self.parts, line: 0, share: self.lines.div_ceil(rows.max(1)) }
    }
}

/// The lines that have not been asked for.
pub struct Asking<'a> {
    parts: &'a [(*const u8, usize)],
    /// The next one of the first part.
    line: usize,
    /// How many belong to a row.
    share: usize,
}

impl Asking<'_> {
    /// Asks for the lines of a row.
    #[inline(always)]
    pub fn next_row<S: Vector>(&mut self) {
        for _ in 0..self.share {
            let Some(&(start, lines)) = self.parts.first() else { return };
            S::ask(start.wrapping_add(LINE * self.line));
            self.line += 1;
            if self.line >= lines {
                self.line = 0;
                self.parts = self.parts.get(1..).unwrap_or_default();
            }
        }
    }
}
