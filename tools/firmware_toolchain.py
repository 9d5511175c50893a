"""What `make firmware` needs beside cargo: compilers for the microcontroller and an emulator.

What is installed is used. What is not is taken from Debian's packages, unpacked under target/firmware/debian: nothing
of the machine changes, and no rights are needed.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "target" / "firmware"
DEBIAN = TARGET / "debian"

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


class UnavailableError(Exception):
    """What cannot be had on this machine; the check is skipped, visibly."""


def run(
    command: Sequence[str | Path],
    env: Mapping[str, str] | None = None,
    cwd: Path = ROOT,
    timeout: float = 1200,
    check: bool = True,
) -> subprocess.CompletedProcess[str]:
    """Runs a program; what it printed is part of the error if it fails."""
    words = [str(word) for word in command]
    done = subprocess.run(
        words, env={**os.environ, **(env or {})}, cwd=cwd, timeout=timeout, capture_output=True, text=True, check=False
    )
    if check and done.returncode != 0:
        raise RuntimeError(f"{' '.join(words)}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done


def unpack(packages: Sequence[str]) -> None:
    """Unpacks Debian packages, with all that they need and the machine lacks, under target/."""
    missing = [package for package in packages if not (DEBIAN / "unpacked" / package).exists()]
    if not missing:
        return
    if not (shutil.which("apt-get") and shutil.which("dpkg-deb")):
        raise UnavailableError(f"there is no {', no '.join(missing)}, and no apt-get to fetch them with")
    print(f"firmware: fetching {', '.join(missing)} into {DEBIAN.relative_to(ROOT)}", flush=True)
    archives = DEBIAN / "archives"
    (archives / "partial").mkdir(parents=True, exist_ok=True)
    fetch = ["apt-get", "install", "--download-only", "--no-install-recommends", "-y", "-q"]
    options = [f"Dir::Cache::archives={archives}", "Debug::NoLocking=1", "APT::Sandbox::User="]
    command = [*fetch, *(word for option in options for word in ("-o", option)), *missing]
    done = run(command, check=False)
    if done.returncode != 0 and os.geteuid() == 0:
        # The lists of packages may be too old, or missing.
        run(["apt-get", "update", "-q"], check=False)
        done = run(command, check=False)
    if done.returncode != 0:
        reason = (done.stderr.strip().splitlines() or ["apt-get failed"])[-1]
        raise UnavailableError(f"the packages {', '.join(missing)} cannot be fetched ({reason})")
    for archive in sorted(archives.glob("*.deb")):
        run(["dpkg-deb", "-x", archive, DEBIAN / "root"])
        archive.unlink()
    (DEBIAN / "unpacked").mkdir(exist_ok=True)
    for package in missing:
        (DEBIAN / "unpacked" / package).touch()


def unpacked_env() -> dict[str, str]:
    """The libraries of unpacked programs."""
    folders = sorted({file.parent for file in (DEBIAN / "root").glob("**/lib/*-linux-gnu/*.so*")})
    return {"LD_LIBRARY_PATH": ":".join(map(str, folders))}


@dataclass(frozen=True)
class Program:
    """A program with its environment."""

    path: Path
    env: Mapping[str, str] = field(default_factory=dict)

    def __call__(self, *arguments: str | Path, timeout: float = 600) -> str:
        """What it prints, errors last: the emulator's semihosting prints there."""
        done = run([self.path, *arguments], self.env, timeout=timeout)
        return done.stdout + done.stderr

    def version(self) -> str:
        return self("--version").splitlines()[0]


def programs() -> dict[str, Program]:
    """The programs of PACKAGES, from the machine or unpacked."""
    found = {name: shutil.which(name) for name in PACKAGES}
    unpack(sorted({PACKAGES[name] for name, path in found.items() if path is None}))
    env = unpacked_env()
    return {
        name: Program(Path(path)) if path else Program(DEBIAN / "root" / "usr" / "bin" / name, env)
        for name, path in found.items()
    }


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
    unpack(RUST_PACKAGES)
    root = DEBIAN / "root"
    compiler = Program(root / "usr" / "bin" / "rustc", unpacked_env())
    cargo = root / "usr" / "bin" / "cargo"
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
    sources = next((DEBIAN / "root").glob("usr/src/rustc-*"))
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
