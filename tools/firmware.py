"""Runs every filter on an emulated microcontroller and compares it with the host: `make firmware`.

Builds one image for each filter of the registry, replays the same recording in it and on the host, and fails where a
bit differs, where two runs execute different numbers of instructions, where an image holds a panic, an allocation or
arithmetic in f64, or where a goal of size is missed. What it measures is kept as docs/firmware.md. With --check it
replays the first tenth alone, writes nothing, and fails where the document does not have what this run gives (sizes
only with the compilers of its head). Nothing is built again where no source has changed, and no image is replayed again
that has not.
"""

from __future__ import annotations

import argparse
import difflib
import hashlib
import json
import os
import re
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from debian import ROOT, Program, UnavailableError, run
from firmware_report import DOCUMENT, comparable, document
from firmware_toolchain import HARD, SOFT, TARGET, Rust, programs, rust

#: As many as a check replays, and `make firmware`.
SHORT, LONG = 10_000, 100_000
#: Without a floating-point unit every operation is a function; there fewer have to do.
SOFT_UPDATES = 2_000

MODES = ("9D", "6D")

#: Files that compilers and linkers read.
SOURCES = (".rs", ".c", ".h", ".ld", ".toml")

#: What an image must not hold: a name, as nm demangles it, and what it means.
FORBIDDEN = (
    (r"core::panicking|rust_begin_unwind|_fail(ed)?\b|panic", "a panic"),
    (r"__rust_(re)?alloc|__rust_no_alloc|__rg_|__rdl_|alloc::|^(m|c|re)alloc$|^free$", "an allocation"),
    (r"^__aeabi_(d\w+|cd\w+|f2d|i2d|ui2d|l2d|ul2d)$|^__\w*df\d?\w*$", "arithmetic in f64"),
)

#: In bytes.
# Of these 9 KB of flash, 100 bytes of state and 256 of stack are what every filter comes back by after a loss
# (docs/losses.md); without that Mahony's and Madgwick's had to be within 6 KB and 256 bytes.
FLASH_GOALS = {"Mahony": 16 << 10, "Madgwick": 17 << 10, "VQF": 32 << 10, "EKF": 32 << 10}
STATE_GOALS = {"Mahony": 352, "Madgwick": 352}
STACK_GOAL, STACK_WITHOUT_GOAL = 2304, ("EKF",)


class FailedError(Exception):
    """What the check has found."""


class Check:
    """The images, their runs and what they give."""

    def __init__(self, tools: dict[str, Program], compiler: Rust, updates: tuple[int, ...]) -> None:
        self.tools = tools
        self.rust = compiler
        self.updates = updates
        self.images = TARGET / "images"
        self.images.mkdir(parents=True, exist_ok=True)
        self.replays = TARGET / "replays"
        self.replays.mkdir(exist_ok=True)
        self.plugin = TARGET / "count.so"
        self.manifest = ("--manifest-path", ROOT / "firmware" / "Cargo.toml")
        self.failures: list[str] = []

    def fail(self, message: str) -> None:
        print(f"firmware: {message}", file=sys.stderr, flush=True)
        self.failures.append(message)

    # Building

    def image(self, kind: str, target: str, filter_name: str | None, plant: str | None = None) -> Path:
        """Builds the images of a filter, and gives the one of a kind: bare or replay."""
        env = {"AHRS_FILTER": filter_name} if filter_name else {}
        env |= {"AHRS_PLANT": plant} if plant else {}
        self.rust.cargo(
            "build", "--release", "--bin", "bare", "--bin", "replay", *self.manifest, target=target, env=env
        )
        for name in ("bare", "replay"):
            copy = self.images / f"{target}-{filter_name}-{plant}-{name}.elf"
            shutil.copy(TARGET / "build" / target / "release" / name, copy)
        return self.images / f"{target}-{filter_name}-{plant}-{kind}.elf"

    def build_plugin(self) -> None:
        # The interface of plugins was renumbered with QEMU 8.2; what is used here has stayed.
        numbers = re.search(r"version (\d+)\.(\d+)", self.tools["qemu-system-arm"].version())
        new = numbers is not None and (int(numbers[1]), int(numbers[2])) >= (8, 2)
        source = ROOT / "firmware" / "plugin" / "count.c"
        flags = ["-O2", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", f"-DPLUGIN_VERSION={2 if new else 1}"]
        run(["cc", *flags, "-o", self.plugin, source])

    # Looking at images

    def symbols(self, image: Path) -> dict[str, int]:
        """The symbols of an image and their addresses."""
        lines = (line.split(maxsplit=2) for line in self.tools["arm-none-eabi-nm"]("-C", image).splitlines())
        return {name: int(address, 16) for address, _, name in (line for line in lines if len(line) == 3)}

    def forbidden(self, image: Path) -> list[str]:
        """What an image holds and must not."""
        return [
            f"{what} ({symbol})"
            for symbol in self.symbols(image)
            for pattern, what in FORBIDDEN
            if re.search(pattern, symbol)
        ]

    def inspect(self, image: Path) -> None:
        for what in self.forbidden(image):
            self.fail(f"{image.name} holds {what}")

    def flash(self, image: Path) -> int:
        """Bytes of text and data."""
        text, data = self.tools["arm-none-eabi-size"](image).splitlines()[1].split()[:2]
        return int(text) + int(data)

    # Running

    def emulate(self, image: Path, *arguments: str, count: str | None = None) -> tuple[str, dict[str, tuple[int, ...]]]:
        """What an image prints; with `count` (a file's name) also calls, instructions and most instructions."""
        words = ["-M", "mps2-an386", "-nographic", "-monitor", "none", "-serial", "none"]
        semihosting = ["enable=on", "target=native", *(f"arg={word}" for word in ("replay", *arguments))]
        words += ["-semihosting-config", ",".join(semihosting)]
        out = TARGET / f"{count}.counts"
        if count:
            at = self.symbols(image)
            functions = [f"{name}={at['__' + name]}" for name in ("update", "prepare")]
            caller = f"caller={at['__caller_start']}-{at['__caller_end']}"
            words += ["-plugin", ",".join([f"file={self.plugin}", caller, *functions, f"out={out}"])]
        text = self.tools["qemu-system-arm"](*words, "-kernel", image, timeout=900)
        if not count:
            return text, {}
        rows = [line.split() for line in out.read_text().splitlines()]
        out.unlink()
        return text, {name: tuple(map(int, numbers)) for name, *numbers in rows}

    def host(self, updates: int) -> dict[tuple[str, str], list[str]]:
        """The words of the host's replay by filter and mode: updates, hash and last attitude."""
        self.rust.cargo("build", "--release", "--bin", "replay", *self.manifest)
        program = TARGET / "build" / "release" / "replay"
        lines = [line for mode in MODES for line in run([program, mode, f"{updates:x}"]).stdout.splitlines()]
        return {(name, mode): words[:6] for name, mode, *words in (line.split() for line in lines)}

    def twice(self, name: str, mode: str, updates: int, image: Path) -> tuple[str, dict[str, Any]]:
        """What the emulator gives for an image, which two runs agree on; of the same image it is known from then on."""
        parts = (image.read_bytes(), self.plugin.read_bytes(), self.tools["qemu-system-arm"].version().encode())
        digest = hashlib.sha256(f"{mode} {updates}".encode())
        for part in parts:
            digest.update(hashlib.sha256(part).digest())
        kept = self.replays / f"{digest.hexdigest()}.json"
        if kept.exists():
            text, counts = json.loads(kept.read_text())
            return text, counts
        runs = [self.emulate(image, mode, f"{updates:x}", count=f"{name}-{mode}-{i}") for i in range(2)]
        if runs[0] == runs[1]:
            kept.write_text(json.dumps(runs[0]))
        else:
            self.fail(f"{name} {mode}: two runs differ: {runs[0][1]} and {runs[1][1]}")
        return runs[0]

    def replay(self, name: str, mode: str, image: Path, expected: dict[int, list[str]]) -> dict[str, Any]:
        """Replays in the emulator, and compares; what is measured is that of the longest replay."""
        measured: dict[str, Any] = {}
        for updates in self.updates:
            text, counts = self.twice(name, mode, updates, image)
            words = text.split()
            if words[:8] != [name, mode, *expected[updates]]:
                wanted = " ".join(expected[updates])
                self.fail(f"{name} {mode}: the target gives {' '.join(words[2:8])}, the host {wanted}")
            calls, total, most = counts["update"]
            if calls != updates:
                self.fail(f"{name} {mode}: {calls} updates were counted instead of {updates}")
            stack, state = (int(word, 16) for word in words[8:10])
            prepare = [counts["prepare"][1] / counts["prepare"][0], counts["prepare"][2]]
            measured = {"mean": total / calls, "max": most, "stack": stack, "state": state, "prepare": prepare}
        return {"hashes": [expected[updates][1] for updates in (SHORT, LONG)], **measured}

    # The parts of the check

    def filters(self) -> dict[str, Any]:
        """Every filter on the target with a floating-point unit."""
        hosts = {updates: self.host(updates) for updates in (SHORT, LONG)}
        names = list(dict.fromkeys(name for name, _ in hosts[SHORT]))
        results: dict[str, Any] = {}
        with ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
            running = {}
            for name in names:
                image = self.image("replay", HARD, name)
                bare = self.images / image.name.replace("replay", "bare")
                for each in (image, bare):
                    self.inspect(each)
                results[name] = {"flash": self.flash(bare)}
                for mode in MODES:
                    expected = {updates: host[name, mode] for updates, host in hosts.items()}
                    running[name, mode] = pool.submit(self.replay, name, mode, image, expected)
            for (name, mode), replay in running.items():
                results[name][mode] = replay.result()
                if mode == MODES[-1]:
                    print(f"firmware: {name}: {max(self.updates)} updates in 9D and 6D, the host's bits", flush=True)
        for name, result in results.items():
            self.judge(name, result)
        return results

    def judge(self, name: str, result: dict[str, Any]) -> None:
        """The goals."""
        stack = max(result[mode]["stack"] for mode in MODES)
        for what, size, goal in (
            ("flash", result["flash"], FLASH_GOALS.get(name)),
            ("state", result["9D"]["state"], STATE_GOALS.get(name)),
            ("stack", stack, None if name in STACK_WITHOUT_GOAL else STACK_GOAL),
        ):
            if goal is not None and size > goal:
                self.fail(f"{name} takes {size} bytes of {what}, the goal is {goal}")

    def soft(self) -> dict[str, Any]:
        """All filters in one image for a processor without a floating-point unit."""
        image = self.image("replay", SOFT, None)
        self.inspect(image)
        expected = self.host(SOFT_UPDATES)
        text, _ = self.emulate(image, "9D", f"{SOFT_UPDATES:x}")
        given = {(name, mode): words[:6] for name, mode, *words in (line.split() for line in text.splitlines())}
        wanted = {key: words for key, words in expected.items() if key[1] == "9D"}
        for name, mode in wanted:
            if given.get((name, mode)) != wanted[name, mode]:
                self.fail(f"{name} {mode} without a floating-point unit differs from the host")
        return {"updates": SOFT_UPDATES, "filters": len(wanted), "flash": self.flash(image)}

    def planted(self) -> None:
        """The checks find what they are there for."""
        bare = self.image("bare", HARD, None)
        self.inspect(bare)
        for plant, what in (("panic", "a panic"), ("f64", "arithmetic in f64"), ("allocation", "an allocation")):
            try:
                found = self.forbidden(self.image("bare", HARD, None, plant))
            except RuntimeError as error:
                # There is no allocator: the compiler refuses.
                found = [what] if plant == "allocation" and "no global memory allocator" in str(error) else [str(error)]
            if not any(entry.startswith(what) for entry in found):
                self.fail(f"{what} that was planted has not been found, only {found}")

    def c(self) -> dict[str, Any]:
        """The C example with every filter, on the host and on the target, beside the core."""
        capi = ROOT / "crates" / "capi"
        self.rust.cargo("build", "--release", "--package", "ahrs-rs-capi")
        self.rust.cargo("build", "--release", "--example", "c_example", *self.manifest)
        package = ["--package", "ahrs-rs-capi", "--no-default-features", "--features", "libm"]
        # As a static library alone: cargo optimises nothing across crates where a library for Rust is made, too.
        self.rust.cargo("rustc", "--profile", "embedded", *package, "--crate-type", "staticlib", target=HARD)
        build = TARGET / "build"
        sources: list[str | Path] = [
            capi / "examples" / "replay.c",
            "-I",
            capi / "include",
            "-Wall",
            "-Wextra",
            "-Werror",
        ]
        flags = ["-std=c11", "-Os", "-ffp-contract=off", "-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections"]
        core = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-ffreestanding", "-nostdlib"]
        sizes = {}
        for line in run([build / "release" / "examples" / "c_example"]).stdout.splitlines():
            name = line.split()[0]
            host, target = TARGET / "c-host", TARGET / "c-target.elf"
            run(
                [
                    "cc",
                    *flags,
                    f"-DFILTER={name}",
                    *sources,
                    build / "release" / "libahrs_rs_c.a",
                    "-lpthread",
                    "-ldl",
                    "-lm",
                    "-o",
                    host,
                ]
            )
            self.tools["arm-none-eabi-gcc"](
                *flags,
                *core,
                f"-DFILTER={name}",
                *sources,
                ROOT / "firmware" / "c" / "start.c",
                build / HARD / "embedded" / "libahrs_rs_c.a",
                "-T",
                ROOT / "firmware" / "link.ld",
                "-o",
                target,
            )
            self.inspect(target)
            sizes[name] = self.flash(target)
            for what, text in (("the host", run([host]).stdout), ("the target", self.emulate(target)[0])):
                if text.strip() != line:
                    self.fail(f"C on {what} gives {text.strip()}, Rust {line}")
        print(f"firmware: C on host and target gives the core's bits for {len(sizes)} filters", flush=True)
        return sizes


def inputs_hash(versions: dict[str, str]) -> str:
    """Of all that images are made of, and of what judges them: no text, no test, no other crate's dependencies."""
    digest = hashlib.sha256(json.dumps(versions).encode())
    folders = ("src", "firmware", *(f"crates/capi/{folder}" for folder in ("src", "include", "examples")))
    files = [path for folder in folders for path in (ROOT / folder).rglob("*") if path.suffix in SOURCES]
    files += [ROOT / name for name in ("Cargo.toml", "crates/capi/Cargo.toml", "firmware/Cargo.lock")]
    files += [ROOT / "tools" / name for name in ("firmware.py", "firmware_toolchain.py", "debian.py")]
    for path in sorted(set(files)):
        digest.update(str(path.relative_to(ROOT)).encode() + b"\0" + path.read_bytes() + b"\0")
    # The C interface is built by the workspace's lock file, of which that much matters.
    used = re.findall(r'^name = "(.*)"', (ROOT / "firmware" / "Cargo.lock").read_text(), re.MULTILINE)
    for package in (ROOT / "Cargo.lock").read_text().split("[[package]]"):
        if any(f'\nname = "{name}"\n' in package for name in used):
            digest.update(package.encode())
    return digest.hexdigest()


def measure(tools: dict[str, Program], updates: tuple[int, ...]) -> dict[str, Any]:
    """The results, from the last run if nothing has changed since."""
    compiler = rust(tools)
    versions = {"rust": compiler.version}
    versions |= {name: tools[name].version() for name in ("qemu-system-arm", "arm-none-eabi-gcc")}
    key, kept = inputs_hash(versions), TARGET / f"results-{max(updates)}.json"
    if kept.exists():
        results: dict[str, Any] = json.loads(kept.read_text())
        if results["key"] == key:
            print("firmware: nothing has changed since the last run, which passed")
            return results
    check = Check(tools, compiler, updates)
    check.build_plugin()
    check.planted()
    bare = check.flash(check.image("bare", HARD, None))
    results = {"key": key, "versions": versions, "updates": [SHORT, LONG], "bare": bare}
    results |= {"c": check.c(), "filters": check.filters(), "soft": check.soft()}
    if check.failures:
        raise FailedError(f"{len(check.failures)} failures")
    kept.write_text(json.dumps(results, indent=1))
    return results


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--check", action="store_true", help="a tenth of the replay; fail where docs/firmware.md is not current"
    )
    check = parser.parse_args().check
    TARGET.mkdir(parents=True, exist_ok=True)
    try:
        text = document(measure(programs(), (SHORT,) if check else (SHORT, LONG)))
    except UnavailableError as reason:
        print(f"firmware: skipped because {reason}")
        return 0
    except (FailedError, RuntimeError) as error:
        print(f"firmware: {error}", file=sys.stderr)
        return 1
    if not check:
        DOCUMENT.write_text(text, encoding="utf-8")
        print(f"firmware: {DOCUMENT.relative_to(ROOT)} is written")
        return 0
    kept = DOCUMENT.read_text(encoding="utf-8") if DOCUMENT.exists() else ""
    old, new = comparable(kept, text)
    if old != new:
        print("firmware: docs/firmware.md is not current; run `make firmware`", file=sys.stderr)
        sys.stderr.writelines(f"{line}\n" for line in difflib.unified_diff(old, new, "kept", "now", n=0, lineterm=""))
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
