//! How much stack a call takes: what lies below the stack pointer is painted before and looked through after it.

#[cfg(target_os = "none")]
pub use painted::Gauge;

/// The host's stack is not measured.
#[cfg(not(target_os = "none"))]
pub struct Gauge;

#[cfg(not(target_os = "none"))]
#[allow(clippy::unused_self, clippy::new_without_default, reason = "the form of the target's")]
impl Gauge {
    pub fn new() -> Self {
        Gauge
    }
    pub fn paint(&mut self) {}
    pub fn read(&mut self) {}
    pub fn most(&self) -> usize {
        0
    }
}

#[cfg(target_os = "none")]
mod painted {
    use core::arch::asm;
    use core::ptr::addr_of;

    /// What no frame is full of.
    const PAINT: u32 = 0xdead_beef;
    /// Painted anew before every call, because what runs between two calls has a frame too; in bytes. What lies deeper is
    /// painted once, so what runs between the calls must not take more than this.
    const ZONE: usize = 512;

    unsafe extern "C" {
        /// The lowest address of the stack, from the linker.
        static __stack_end: u32;
    }

    /// Measures from the frame of the function that it is inlined into.
    pub struct Gauge {
        most: usize,
    }

    impl Gauge {
        #[inline(always)]
        pub fn new() -> Self {
            paint(addr_of!(__stack_end) as usize);
            Gauge { most: 0 }
        }
        /// Before the call.
        #[inline(always)]
        pub fn paint(&mut self) {
            paint(pointer() - ZONE);
        }
        /// After the call.
        #[inline(always)]
        pub fn read(&mut self) {
            self.most = self.most.max(used(pointer() - ZONE));
        }
        /// The most that any call has taken, in bytes.
        #[inline(always)]
        pub fn most(&self) -> usize {
            let deepest = used(addr_of!(__stack_end) as usize);
            if deepest > ZONE { deepest } else { self.most }
        }
    }

    #[inline(always)]
    fn pointer() -> usize {
        let pointer;
        // SAFETY: reads a register.
        unsafe { asm!("mov {}, sp", out(reg) pointer, options(nomem, nostack, preserves_flags)) };
        pointer
    }

    /// Paints from an address up to the stack pointer.
    #[inline(always)]
    fn paint(from: usize) {
        // SAFETY: what lies below the stack pointer, and above the end of the stack, belongs to nobody: no interrupt is on.
        unsafe {
            asm!(
                "2: cmp {at}, sp",
                "bhs 3f",
                "str {paint}, [{at}]",
                "adds {at}, #4",
                "b 2b",
                "3:",
                at = inout(reg) from => _,
                paint = in(reg) PAINT,
                options(nostack),
            );
        }
    }

    /// The distance from the lowest word that has lost its paint to the stack pointer, in bytes.
    #[inline(always)]
    fn used(from: usize) -> usize {
        let mut at = from;
        // SAFETY: reads memory between the end of the stack and the stack pointer.
        unsafe {
            asm!(
                "2: cmp {at}, sp",
                "bhs 3f",
                "ldr {word}, [{at}]",
                "cmp {word}, {paint}",
                "bne 3f",
                "adds {at}, #4",
                "b 2b",
                "3:",
                at = inout(reg) at,
                word = out(reg) _,
                paint = in(reg) PAINT,
                options(nostack, readonly),
            );
        }
        pointer() - at
    }
}
