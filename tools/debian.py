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


def unpack(packages: Sequence[str], settings: Sequence[str] = ()) -> None:
    """Unpacks Debian packages, with all that they need and the machine lacks, into `TREE`.

    `settings` are apt's: by default it looks into the machine's lists of packages.
    """
    missing = [package for package in packages if not marker(package).exists()]
    if not missing:
        return
    if not (shutil.which("apt-get") and shutil.which("dpkg-deb")):
        raise UnavailableError(f"there is no {', no '.join(missing)}, and no apt-get to fetch them with")
    unpack_archives(missing, fetched(missing, settings))


def unpack_foreign(package: str, architecture: str) -> None:
    """The same for one package of another architecture, without what it needs."""
    name = f"{package}:{architecture}"
    if marker(name).exists():
        return
    settings = fresh_lists(architecture)
    ARCHIVES.mkdir(parents=True, exist_ok=True)
    listed, done = (apt_get(["download", *options, name], settings, ARCHIVES) for options in (["--print-uris"], ["-q"]))
    if done.returncode != 0:
        raise unavailable([name], done)
    unpack_archives([name], archives_of(listed))


def marker(package: str) -> Path:
    """The file that says that a package is unpacked."""
    return DEBIAN / "unpacked" / package


def unpack_archives(packages: Sequence[str], archives: Sequence[Path]) -> None:
    for archive in archives:
        run(["dpkg-deb", "-x", archive, TREE])
    for package in packages:
        marker(package).parent.mkdir(exist_ok=True)
        marker(package).touch()


def fetched(packages: Sequence[str], settings: Sequence[str]) -> list[Path]:
    """The archives of packages and of what they need: those that are kept, and the others from Debian."""
    (ARCHIVES / "partial").mkdir(parents=True, exist_ok=True)
    empty = DEBIAN / "empty"
    (empty / "partial").mkdir(parents=True, exist_ok=True)
    install = ["install", "--no-install-recommends", "-y"]
    # Into an empty folder everything would have to be fetched: these are the names.
    listing = [*install, "--print-uris", *packages]
    done = apt_get(listing, [f"Dir::Cache::archives={empty}", *settings])
    if done.returncode != 0:
        raise unavailable(packages, done)
    archives = archives_of(done)
    if not all(archive.exists() for archive in archives):
        print(f"fetching {', '.join(packages)} from Debian", flush=True)
        done = apt_get([*install, "--download-only", "-q", *packages], [f"Dir::Cache::archives={ARCHIVES}", *settings])
        if done.returncode != 0:
            raise unavailable(packages, done)
    return archives


def archives_of(listed: subprocess.CompletedProcess[str]) -> list[Path]:
    """Where the archives are kept that `--print-uris` lists."""
    return [ARCHIVES / line.split()[1] for line in listed.stdout.splitlines() if line.startswith("'")]


def apt_get(words: Sequence[str], settings: Sequence[str], cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
    """Runs apt-get; a second time where the machine's lists of packages may be too old, or missing."""
    common = ["Debug::NoLocking=1", "APT::Sandbox::User="]
    options = [word for setting in (*common, *settings) for word in ("-o", setting)]
    done = run(["apt-get", *options, *words], cwd=cwd, check=False)
    if done.returncode != 0 and words[0] != "update" and os.geteuid() == 0:
        run(["apt-get", "update", "-q"], check=False)
        done = run(["apt-get", *options, *words], cwd=cwd, check=False)
    return done


def fresh_lists(*architectures: str) -> list[str]:
    """apt's settings for lists of packages of today, beside the machine's: the same versions for all architectures."""
    lists = DEBIAN / "lists"
    own = run(["dpkg", "--print-architecture"]).stdout.strip()
    settings = [f"Dir::State::lists={lists}", *(f"APT::Architectures::={each}" for each in (own, *architectures))]
    done = lists / "-".join(("updated", *architectures))
    if not done.exists():
        (lists / "partial").mkdir(parents=True, exist_ok=True)
        apt_get(["update", "-q"], settings)
        done.touch()
    return settings


def unavailable(packages: Sequence[str], done: subprocess.CompletedProcess[str]) -> UnavailableError:
    """What apt-get says in its last line."""
    reason = (done.stderr.strip().splitlines() or ["apt-get failed"])[-1]
    return UnavailableError(f"the packages {', '.join(packages)} cannot be fetched ({reason})")


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
