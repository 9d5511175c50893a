"""The native library holds every filter once for each type and set of instructions.

A second copy costs nobody a wrong result, and everybody who builds a minute and a half: it appears where a crate names
the constructors of the filters in code that the compiler inlines into another crate.
"""

import shutil
import subprocess
from collections import Counter
from pathlib import Path

import pytest

import ahrs_rs as ar
from ahrs_rs import _native

#: What a symbol holds, by what its mangled name contains: the lanes of a filter, and the filter alone.
KERNELS = {"lanes": "ahrs_rs_lanes..bank..Lanes", "alone": "ahrs_rs_lanes..stream..Stream"}

#: f32 and f64, and on x86-64 AVX2 and AVX-512 (elsewhere pairs of numbers alone).
TYPES = 2


def _symbols(path: Path) -> list[str]:
    """What a library defines."""
    nm = shutil.which("nm")
    if nm is None:
        pytest.skip("there is no nm on this machine")
    listed = subprocess.run([nm, "--defined-only", str(path)], capture_output=True, text=True, check=True)
    names = [line.split()[-1] for line in listed.stdout.splitlines() if len(line.split()) == 3]
    if not names:
        pytest.skip("the native library is stripped")
    return names


def test_every_kernel_is_compiled_once() -> None:
    runs = [name for name in _symbols(Path(_native.__file__)) if "3run17h" in name]
    counts = Counter(kind for name in runs for kind, part in KERNELS.items() if part in name)
    streaming = sum(cls.STREAMING for cls in ar.FILTERS.values())
    assert counts["alone"] == TYPES * streaming
    # One for each set of instructions: a portable build has one, x86-64 two, and three with the feature `portable`.
    sets = {1: "portable, or of one machine", 2: "x86-64", 3: "x86-64 with portable lanes"}
    assert counts["lanes"] / (TYPES * streaming) in sets


def test_the_crate_that_calls_the_kernels_compiles_none() -> None:
    """The linker drops a second copy, so that the library does not show it: what is compiled does."""
    built = Path(__file__).parents[2] / "target" / "release" / "deps"
    libraries = sorted(built.glob("libahrs_rs_batch-*.rlib"), key=lambda path: path.stat().st_mtime)
    if not libraries:
        pytest.skip("the package was not built here")
    kernels = [name for name in _symbols(libraries[-1]) if any(part in name for part in KERNELS.values())]
    assert kernels == []
