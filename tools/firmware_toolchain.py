"""What `make firmware` needs beside cargo: compilers for the microcontroller and an emulator.

What is installed is used; what is not comes from Debian's packages (`debian`).
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from debian import ROOT, TREE, Program, fresh_lists, installed, run, unpack, unpacked_env

TARGET = ROOT / "target" / "firmware"

#: With a unit for f32, and without any.
HARD, SOFT = "thumbv7em-none-eabihf", "thumbv6m-none-eabi"

#: Programs, and the Debian package that has each.
PACKAGES = {
    "qemu-system-arm": "qemu-system-arm",
    "arm-none-eabi-gcc": "gcc-arm-none-eabi",
    "arm-none-eabi-nm": "binutils-arm-none-eabi",
    "arm-none-eabi-size": "binutils-arm-none-eabi",
    "arm-none-eabi-ld": "binutils-arm-none-eabi",
}
#: Debian's compiler with the sources of its libraries, for machines where rustup has no target.
RUST_PACKAGES = ("rustc-web", "cargo-web", "rust-web-src")


def programs() -> dict[str, Program]:
    """The programs of PACKAGES."""
    return installed(PACKAGES)


@dataclass(frozen=True)
class Rust:
    """A compiler with the libraries of both targets."""

    version: str
    env: Mapping[str, str]
    flags: Mapping[str, str]

    def cargo(self, *arguments: str | Path, target: str | None = None, env: Mapping[str, str] | None = None) -> None:
        """Runs cargo for a target; for the host with the ordinary compiler."""
        words: list[str | Path] = ["cargo", *arguments, "--quiet"]
        settings = {"CARGO_TARGET_DIR": str(TARGET / "build"), **(env or {})}
        if target:
            words += ["--target", target]
            settings |= {**self.env, "RUSTFLAGS": self.flags[target]}
        run(words, settings)


def rust(programs: Mapping[str, Program]) -> Rust:
    """Rust with the targets: rustup's where it has or gets them, else (or if AHRS_FIRMWARE_RUST=debian) Debian's."""
    if os.environ.get("AHRS_FIRMWARE_RUST") != "debian" and shutil.which("rustup"):
        installed = run(["rustup", "target", "list", "--installed"], check=False).stdout.split()
        missing = [target for target in (HARD, SOFT) if target not in installed]
        try:
            done = run(["rustup", "target", "add", *missing], timeout=300, check=False) if missing else None
        except subprocess.TimeoutExpired:
            done = subprocess.CompletedProcess([], 1)
        if not done or done.returncode == 0:
            version = run(["rustc", "--version"]).stdout.strip()
            return Rust(version, {}, {HARD: "", SOFT: ""})
        print("firmware: rustup cannot get the targets; Debian's compiler and sources are used", flush=True)
    return debian_rust(programs)


def debian_rust(programs: Mapping[str, Program]) -> Rust:
    """Debian's compiler, and the libraries built from its sources once for each target."""
    # The machine's lists may have one that is too old for the crates.
    unpack(RUST_PACKAGES, fresh_lists())
    compiler = Program(TREE / "usr" / "bin" / "rustc", unpacked_env())
    cargo = TREE / "usr" / "bin" / "cargo"
    env = {"RUSTC": str(compiler.path), **compiler.env}
    version = compiler.version()
    sysroots = TARGET / "sysroot" / version.split()[1]
    linker = programs["arm-none-eabi-ld"]
    flags = {}
    for target in (HARD, SOFT):
        sysroot = sysroots / target
        if not (sysroot / "made").exists():
            print(f"firmware: building core for {target} with Debian's {version}", flush=True)
            build_sysroot(sysroot, target, cargo, env)
        flags[target] = f"--sysroot {sysroot} -Clinker={linker.path} -Clinker-flavor=ld"
    return Rust(f"{version} (Debian)", env, flags)


def build_sysroot(sysroot: Path, target: str, cargo: Path, env: Mapping[str, str]) -> None:
    """Builds core and alloc by an empty crate, and copies what comes out."""
    empty = TARGET / "sysroot" / "empty"
    (empty / "src").mkdir(parents=True, exist_ok=True)
    (empty / "src" / "lib.rs").write_text("#![no_std]\n")
    (empty / "Cargo.toml").write_text('[package]\nname = "empty"\nedition = "2021"\n[workspace]\n')
    # The sources bring what they depend on; cargo does not look there by itself.
    sources = next(TREE.glob("usr/src/rustc-*"))
    vendored = next(folder for folder in (sources / "library" / "vendor", sources / "vendor") if folder.is_dir())
    (empty / ".cargo").mkdir(exist_ok=True)
    (empty / ".cargo" / "config.toml").write_text(
        f'[source.crates-io]\nreplace-with = "vendored"\n[source.vendored]\ndirectory = "{vendored}"\n'
    )
    library = Path(run([env["RUSTC"], "--print", "sysroot"], env).stdout.strip()) / "lib" / "rustlib" / "src" / "rust"
    if not library.exists():
        library.parent.mkdir(parents=True, exist_ok=True)
        library.symlink_to(sources)
    out = TARGET / "sysroot" / "build"
    build: list[str | Path] = [cargo, "build", "--release", "--target", target]
    unstable = ["-Z", "build-std=core,alloc", "-Z", "build-std-features=compiler-builtins-mem"]
    settings = {"RUSTC_BOOTSTRAP": "1", "RUSTFLAGS": "-Cembed-bitcode=yes", "CARGO_TARGET_DIR": str(out)}
    run([*build, *unstable], {**env, **settings}, cwd=empty)
    libraries = sysroot / "lib" / "rustlib" / target / "lib"
    libraries.mkdir(parents=True, exist_ok=True)
    for file in (out / target / "release" / "deps").glob("*.rlib"):
        if not file.name.startswith("libempty"):
            shutil.copy(file, libraries)
    (sysroot / "made").touch()
