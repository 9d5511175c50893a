"""Programs that the machine may lack, from Debian's packages, unpacked under target/.

Nothing of the machine changes, and no rights are needed. The packages themselves are kept in the user's cache, so that
another checkout fetches nothing again.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DEBIAN = ROOT / "target" / "debian"
TREE = DEBIAN / "root"
#: Where packages are kept when they were fetched.
ARCHIVES = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "ahrs-rs" / "debian"


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
    """Unpacks Debian packages, with all that they need and the machine lacks, into `TREE`."""
    missing = [package for package in packages if not (DEBIAN / "unpacked" / package).exists()]
    if not missing:
        return
    if not (shutil.which("apt-get") and shutil.which("dpkg-deb")):
        raise UnavailableError(f"there is no {', no '.join(missing)}, and no apt-get to fetch them with")
    for archive in fetched(missing):
        run(["dpkg-deb", "-x", archive, TREE])
    (DEBIAN / "unpacked").mkdir(exist_ok=True)
    for package in missing:
        (DEBIAN / "unpacked" / package).touch()


def fetched(packages: Sequence[str]) -> list[Path]:
    """The archives of packages and of what they need: those that are kept, and the others from Debian."""
    (ARCHIVES / "partial").mkdir(parents=True, exist_ok=True)
    empty = DEBIAN / "empty"
    (empty / "partial").mkdir(parents=True, exist_ok=True)
    # Into an empty folder everything would have to be fetched: these are the names.
    listed = apt_get(["--print-uris", "-qq"], empty, packages)
    words = [line.split() for line in listed.splitlines() if line.startswith("'")]
    archives = [ARCHIVES / name for _, name, *_ in words]
    if not all(archive.exists() for archive in archives):
        print(f"fetching {', '.join(packages)} from Debian", flush=True)
        apt_get(["--download-only", "-q"], ARCHIVES, packages)
    return archives


def apt_get(options: Sequence[str], archives: Path, packages: Sequence[str]) -> str:
    """What `apt-get install` prints, with a folder of archives of our own."""
    settings = [f"Dir::Cache::archives={archives}", "Debug::NoLocking=1", "APT::Sandbox::User="]
    words = ["apt-get", "install", "--no-install-recommends", "-y", *options]
    command = [*words, *(word for setting in settings for word in ("-o", setting)), *packages]
    done = run(command, check=False)
    if done.returncode != 0 and os.geteuid() == 0:
        # The lists of packages may be too old, or missing.
        run(["apt-get", "update", "-q"], check=False)
        done = run(command, check=False)
    if done.returncode != 0:
        reason = (done.stderr.strip().splitlines() or ["apt-get failed"])[-1]
        raise UnavailableError(f"the packages {', '.join(packages)} cannot be fetched ({reason})")
    return done.stdout


def unpacked_env() -> dict[str, str]:
    """The libraries of unpacked programs."""
    folders = sorted({file.parent for file in TREE.glob("**/lib/*-linux-gnu/*.so*")})
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


def installed(packages: Mapping[str, str]) -> dict[str, Program]:
    """Programs by name, each from the machine or out of the package that has it."""
    found = {name: shutil.which(name) for name in packages}
    unpack(sorted({packages[name] for name, path in found.items() if path is None}))
    env = unpacked_env()
    return {
        name: Program(Path(path)) if path else Program(TREE / "usr" / "bin" / name, env) for name, path in found.items()
    }
