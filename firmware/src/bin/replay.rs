//! Replays the recording and prints a line for each filter: name, 6D or 9D, updates, hash, last quaternion, bytes of stack,
//! bytes of state; numbers in hexadecimal. `replay 9D 186a0` on the host, the same words through semihosting on the target.
//!
//! With the environment variable `AHRS_FILTER` set when it is compiled, that filter is the only one in the image.

#![cfg_attr(target_os = "none", no_std, no_main)]

use firmware::replay::{Report, each_filter};

const CHOSEN: Option<&str> = option_env!("AHRS_FILTER");

/// Prints what a replay tells; `hex` prints a number in so many digits.
fn line(name: &str, mode: &str, updates: u32, report: &Report, text: impl Fn(&str), hex: impl Fn(u64, u32)) {
    text(name);
    text(" ");
    text(mode);
    let q = report.quat;
    let [w, x, y, z] = [q.w, q.x, q.y, q.z].map(f32::to_bits);
    for (number, digits) in
        [(updates.into(), 8), (report.hash, 16), (w.into(), 8), (x.into(), 8), (y.into(), 8), (z.into(), 8)]
    {
        text(" ");
        hex(number, digits);
    }
    for number in [report.stack, report.state] {
        text(" ");
        hex(number as u64, 4);
    }
    text("\n");
}

/// Runs the words of the command line: the sensors, and how many updates (hexadecimal).
fn run<'a>(mut words: impl Iterator<Item = &'a str>, text: impl Fn(&str), hex: impl Fn(u64, u32)) -> bool {
    let (Some(mode @ ("6D" | "9D")), Some(updates)) = (words.next(), words.next()) else { return false };
    let Ok(updates) = u32::from_str_radix(updates, 16) else { return false };
    each_filter(CHOSEN, updates, mode == "9D", |name, report| line(name, mode, updates, report, &text, &hex)).is_ok()
}

#[cfg(target_os = "none")]
#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    use firmware::target::{arguments, exit, print, print_hex};
    let mut buffer = [0; 64];
    exit(usize::from(!run(arguments(&mut buffer), print, print_hex)) * 2)
}

#[cfg(not(target_os = "none"))]
fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let hex = |number: u64, digits: u32| print!("{number:0width$x}", width = digits as usize);
    if !run(words.iter().map(String::as_str), |text| print!("{text}"), hex) {
        eprintln!("replay 6D|9D UPDATES (hexadecimal)");
        std::process::exit(2);
    }
}
