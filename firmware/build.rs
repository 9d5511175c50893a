//! Links images for a microcontroller by the memory map of the emulated board.

fn main() {
    println!("cargo::rerun-if-changed=link.ld");
    println!("cargo::rerun-if-changed=build.rs");
    // What uses an allocator is left out before it is compiled: the compiler asks for one before it sees what is not called.
    println!("cargo::rerun-if-env-changed=AHRS_PLANT");
    println!("cargo::rustc-check-cfg=cfg(planted_allocation)");
    if std::env::var("AHRS_PLANT").as_deref() == Ok("allocation") {
        println!("cargo::rustc-cfg=planted_allocation");
    }
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        let folder = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
        println!("cargo::rustc-link-arg-bins=-T{folder}/link.ld");
    }
}
