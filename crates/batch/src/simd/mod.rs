//! Numbers side by side in the vector registers of the processor, chosen at run time.

use ahrs_rs::{Pair, Real, Scalar};

#[cfg(target_arch = "x86_64")]
mod x86;

#[cfg(target_arch = "x86_64")]
pub use x86::{Avx2, Avx512};

/// A scalar whose lanes lie next to each other in memory.
pub trait Vector: Scalar {
    /// Reads the lanes; NaN where there are too few numbers.
    fn load(from: &[Self::Real]) -> Self;
    /// Writes the lanes; nothing where there is too little room.
    fn store(self, to: &mut [Self::Real]);
    /// Asks the memory for the line of the cache at an address, which need not be one that can be read.
    #[inline(always)]
    fn ask(_address: *const u8) {}
}

/// What is to be compiled for vector instructions.
pub trait Work {
    /// Does it. To be inlined: what is not is not compiled for the instructions, and slower by an order of magnitude.
    fn run(self);
}

/// A set of vector instructions that the processor has, for numbers of type `T`.
pub trait Instructions<T: Real>: Copy + Send + Sync + 'static {
    /// A register's numbers.
    type Vector: Vector<Real = T>;
    /// Does the work with these instructions.
    fn run(self, work: impl Work);
    /// Writes the first number of every source, then the second of every source, and so on, where it can do so for many at
    /// once; gives how many of each are written. There are as many sources as lanes.
    fn interleave(self, _to: &mut [T], _from: &[&[T]]) -> usize {
        0
    }
    /// Takes apart what `interleave` puts together, for the first lanes, as many as there are places.
    fn deinterleave(self, _from: &[T], _to: &mut [&mut [T]]) -> usize {
        0
    }
}

/// What every processor has: pairs of numbers, which fill the time in which a number alone would wait.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

impl Instructions<f32> for Portable {
    type Vector = Pair<Pair<f32>>;
    fn run(self, work: impl Work) {
        work.run();
    }
}

impl Instructions<f64> for Portable {
    type Vector = Pair<f64>;
    fn run(self, work: impl Work) {
        work.run();
    }
}

/// One number at a time.
#[derive(Clone, Copy, Debug)]
pub struct Alone;

impl<T: Real + Vector> Instructions<T> for Alone {
    type Vector = T;
    fn run(self, work: impl Work) {
        work.run();
    }
}

macro_rules! one_number {
    ($real:ty) => {
        impl Vector for $real {
            #[inline(always)]
            fn load(from: &[$real]) -> Self {
                from.first().copied().unwrap_or(<$real>::NAN)
            }
            #[inline(always)]
            fn store(self, to: &mut [$real]) {
                if let Some(to) = to.first_mut() {
                    *to = self;
                }
            }
        }
    };
}
one_number!(f32);
one_number!(f64);

impl<S: Vector> Vector for Pair<S> {
    #[inline(always)]
    fn load(from: &[S::Real]) -> Self {
        Pair(S::load(from), S::load(from.get(S::LANES..).unwrap_or_default()))
    }
    #[inline(always)]
    fn store(self, to: &mut [S::Real]) {
        self.0.store(to);
        if let Some(rest) = to.get_mut(S::LANES..) {
            self.1.store(rest);
        }
    }
}

/// The sets of instructions by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Isa {
    /// [`Portable`]; not made where the processor's registers are known, to save the compiler's time.
    #[cfg(any(test, not(target_arch = "x86_64")))]
    Portable,
    /// Registers of 256 bits.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// Registers of 512 bits.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Isa {
    /// Those that this processor has, the fastest last.
    pub fn available() -> Vec<Isa> {
        [
            #[cfg(any(test, not(target_arch = "x86_64")))]
            Some(Isa::Portable),
            #[cfg(target_arch = "x86_64")]
            Avx2::detect().map(|_| Isa::Avx2),
            #[cfg(target_arch = "x86_64")]
            Avx512::detect().map(|_| Isa::Avx512),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// The fastest, if there is any.
    pub fn fastest() -> Option<Isa> {
        Self::available().last().copied()
    }
}
