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
    /// Prefetches the cache line at an address, which need not be one that can be read.
    #[inline(always)]
    fn prefetch(_address: *const u8) {}
}

/// Code to be compiled for a set of vector instructions.
pub trait Kernel {
    /// Runs it. To be inlined: what is not is not compiled for the instructions, and slower by an order of magnitude.
    fn run(self);
}

/// A set of vector instructions that the processor has, for numbers of type `T`.
pub trait Instructions<T: Real>: Copy + Send + Sync + 'static {
    /// A register's numbers.
    type Vector: Vector<Real = T>;
    /// Runs the kernel with these instructions.
    fn run(self, kernel: impl Kernel);
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

/// What every processor has: pairs of numbers, which fill the time in which one number would wait for itself.
#[derive(Clone, Copy, Debug)]
pub struct PortableIsa;

impl Instructions<f32> for PortableIsa {
    type Vector = Pair<Pair<f32>>;
    fn run(self, kernel: impl Kernel) {
        kernel.run();
    }
}

impl Instructions<f64> for PortableIsa {
    type Vector = Pair<f64>;
    fn run(self, kernel: impl Kernel) {
        kernel.run();
    }
}

/// One number at a time.
#[derive(Clone, Copy, Debug)]
pub struct ScalarIsa;

impl<T: Real + Vector> Instructions<T> for ScalarIsa {
    type Vector = T;
    fn run(self, kernel: impl Kernel) {
        kernel.run();
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
    /// [`PortableIsa`].
    Portable,
    /// Registers of 256 bits.
    Avx2,
    /// Registers of 512 bits.
    Avx512,
}

impl Isa {
    /// All of them with their names, the fastest last.
    pub const ALL: [(&'static str, Isa); 3] =
        [("portable", Isa::Portable), ("avx2", Isa::Avx2), ("avx512", Isa::Avx512)];

    /// The set of a name, or `None`.
    pub fn from_name(name: &str) -> Option<Isa> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|&(_, isa)| isa)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|&&(_, isa)| isa == self).map_or("", |(name, _)| name)
    }
}
