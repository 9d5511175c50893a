//! What a Cortex-M needs before `main`, and semihosting: the debugger's (here the emulator's) services.

use core::arch::{asm, global_asm};
use core::panic::PanicInfo;

// The vector table, and what comes before `main`: the coprocessor switched on where the target has one, variables set.
global_asm!(
    ".section .vectors, \"a\"",
    ".word __stack_start",
    ".word reset",
    ".rept 14",
    ".word fault",
    ".endr",
    ".section .text.reset, \"ax\"",
    ".global reset",
    ".thumb_func",
    "reset:",
    "ldr r0, =0xe000ed88", // CPACR: full access to coprocessors 10 and 11
    "ldr r1, [r0]",
    "movs r2, #0xf",
    "lsls r2, r2, #20",
    "orrs r1, r2",
    "str r1, [r0]",
    "dsb",
    "isb",
    "ldr r0, =__data_start",
    "ldr r1, =__data_end",
    "ldr r2, =__data_load",
    "2: cmp r0, r1",
    "bhs 3f",
    "ldr r3, [r2]",
    "str r3, [r0]",
    "adds r0, #4",
    "adds r2, #4",
    "b 2b",
    "3: ldr r0, =__bss_start",
    "ldr r1, =__bss_end",
    "movs r2, #0",
    "4: cmp r0, r1",
    "bhs 5f",
    "str r2, [r0]",
    "adds r0, #4",
    "b 4b",
    "5: bl main",
    ".global fault",
    ".thumb_func",
    "fault:", // SYS_EXIT_EXTENDED with status 70
    "ldr r1, =6f",
    "movs r0, #0x20",
    "bkpt 0xab",
    "b fault",
    ".align 2",
    "6: .word 0x20026, 70",
    ".ltorg",
);

unsafe extern "C" {
    safe fn fault() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    fault()
}

/// A request to the debugger; `block` is what the operation reads, and writes where it gives something back.
fn request(operation: usize, block: *mut usize) -> usize {
    let result;
    // SAFETY: the debugger reads and writes what the callers below hand over, and nothing else.
    unsafe {
        asm!("bkpt 0xab", inout("r0") operation => result, in("r1") block, options(nostack, preserves_flags));
    }
    result
}

/// Ends the emulator with a status.
pub fn exit(status: usize) -> ! {
    request(0x20, [0x20026, status].as_mut_ptr());
    fault()
}

/// Prints text.
pub fn print(text: &str) {
    for &byte in text.as_bytes() {
        request(0x03, (&raw const byte).cast_mut().cast());
    }
}

/// Prints a number in hexadecimal digits, as many as said.
pub fn print_hex(number: u64, digits: u32) {
    for digit in (0..digits).rev() {
        let nibble = (number >> (4 * digit)) as u8 & 15;
        let letter = if nibble < 10 { b'0' + nibble } else { b'a' - 10 + nibble };
        request(0x03, (&raw const letter).cast_mut().cast());
    }
}

/// The words of the emulator's command line after the program's name.
pub fn arguments(buffer: &mut [u8; 64]) -> impl Iterator<Item = &str> {
    request(0x15, [buffer.as_mut_ptr() as usize, buffer.len()].as_mut_ptr());
    let line = buffer.split(|&byte| byte == 0).next().unwrap_or_default();
    line.split(|&byte| byte == b' ').skip(1).map(|word| str::from_utf8(word).unwrap_or_default())
}
