"""Builds the core and the batch engine for aarch64 and runs their Rust tests in an emulator: `make aarch64`.

The target's library is rustup's where rustup has or gets it, else (or if AHRS_AARCH64_RUST=debian) compiler and library
are Debian's; so are the linker, the C library and the emulator. Where they cannot be had, one line says so.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from debian import ROOT, TREE, UnavailableError, fresh_lists, run, unpack, unpack_foreign, unpacked_env

TARGET = "aarch64-unknown-linux-gnu"
BUILD = ROOT / "target" / "aarch64"
PACKAGES = ("gcc-aarch64-linux-gnu", "libc6-dev-arm64-cross", "qemu-user")
#: Debian's compiler, of this machine, and the library of the other one.
RUST_PACKAGES, RUST_LIBRARY = ("rustc-web",), "libstd-rust-web-dev"
#: What is compiled for vector registers, and what that is made of.
CRATES = ("ahrs-rs", "ahrs-rs-lanes", "ahrs-rs-batch")


def script(name: str, program: str, *arguments: str | Path, env: Mapping[str, str] | None = None) -> Path:
    """A file that runs an unpacked program, which finds its libraries in no other way."""
    path = BUILD / name
    settings = "".join(f"export {variable}='{value}'\n" for variable, value in (env or unpacked_env()).items())
    words = " ".join(f"'{word}'" for word in (TREE / "usr" / "bin" / program, *arguments))
    path.write_text(f'#!/bin/sh\n{settings}exec {words} "$@"\n', encoding="utf-8")
    path.chmod(0o755)
    return path


def environment() -> dict[str, str]:
    """What cargo needs to link for the target and to run what it has linked."""
    unpack(PACKAGES)
    BUILD.mkdir(parents=True, exist_ok=True)
    target = TARGET.replace("-", "_")
    name = f"CARGO_TARGET_{target.upper()}"
    # The C library's linker script has absolute paths.
    linker = script("cc", "aarch64-linux-gnu-gcc", f"--sysroot={TREE}")
    emulator = script("run", "qemu-aarch64", "-L", TREE / "usr" / "aarch64-linux-gnu", "-U", "LD_LIBRARY_PATH")
    env = {"CARGO_TARGET_DIR": str(BUILD), f"{name}_LINKER": str(linker), f"{name}_RUNNER": str(emulator)}
    # Of a crate that measurements need.
    env |= {f"CC_{target}": str(linker), f"AR_{target}": str(script("ar", "aarch64-linux-gnu-ar"))}
    return env | rust(name)


def rust(name: str) -> dict[str, str]:
    """Settings by which the compiler finds the target's library."""
    if os.environ.get("AHRS_AARCH64_RUST") != "debian" and shutil.which("rustup"):
        try:
            if run(["rustup", "target", "add", TARGET], timeout=300, check=False).returncode == 0:
                return {}
        except subprocess.TimeoutExpired:
            pass
        print("aarch64: rustup cannot get the target; Debian's compiler and library are used", flush=True)
    unpack(RUST_PACKAGES, fresh_lists("arm64"))
    unpack_foreign(RUST_LIBRARY, "arm64")
    return {"RUSTC": str(script("rustc", "rustc")), f"{name}_RUSTFLAGS": f"--sysroot={TREE / 'usr'}"}


def cargo(words: Sequence[str], env: Mapping[str, str]) -> int:
    """Runs cargo in the open."""
    return subprocess.run(["cargo", *words], cwd=ROOT, env={**os.environ, **env}, check=False).returncode


def main() -> int:
    try:
        env = environment()
    except UnavailableError as reason:
        print(f"aarch64: skipped because {reason}")
        return 0
    except RuntimeError as error:
        print(f"aarch64: {error}", file=sys.stderr)
        return 1
    packages = [word for crate in CRATES for word in ("--package", crate)]
    return cargo(["test", "--quiet", "--target", TARGET, *packages, "--lib", "--tests"], env)


if __name__ == "__main__":
    sys.exit(main())
