"""Reading by a native library that damaged files crash, in a process of its own with limits of time and memory.

The child is a new interpreter, no fork: a forked one would inherit threads that are not there.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from ahrs_rs._typing import FloatArray
from ahrs_rs.io._library import refuse, shortened

#: The child's time: so many s, and so many more for each MB of the file.
SECONDS, SECONDS_A_MB = 60.0, 1.0
#: The child's memory beyond what it has after its imports: so many bytes, and so many times the file.
MEMORY, MEMORY_TIMES = 150_000_000, 9

_START = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from ahrs_rs.io import _child
_child.main(*sys.argv[2:])
"""


def read_in_child(module: str, path: Path, what: str) -> tuple[dict[str, FloatArray], dict[str, Any]]:
    """What `in_child` of the module `ahrs_rs.io.<module>` makes of a file: arrays by name, and what JSON can hold.

    Raises
    ------
    ValueError
        What `in_child` raises, and a child that crashed, took too long or wanted too much memory.
    ImportError
        What `in_child` needs is not installed.
    """
    size = path.stat().st_size
    seconds = SECONDS + SECONDS_A_MB * size / 1e6
    with tempfile.TemporaryDirectory(prefix="ahrs_rs_") as folder:
        out = Path(folder) / "arrays.npz"
        command = [sys.executable, "-c", _START, json.dumps(sys.path), module, str(path), str(out)]
        try:
            done = subprocess.run(command, capture_output=True, timeout=seconds, check=False, stdin=subprocess.DEVNULL)
        except subprocess.TimeoutExpired:
            raise refuse(f"is not a readable {what}: the library did not end within {seconds:.0f} s") from None
        report = Path(folder) / "arrays.json"
        if not report.exists():  # ended by a signal, or by running out of memory
            text = done.stderr.decode(errors="replace").strip().splitlines()
            last = shortened(" ".join(text[-1].split())) if text else "no message"
            raise refuse(f"is not a readable {what}: the library crashed on it (exit status {done.returncode}; {last})")
        told: dict[str, Any] = json.loads(report.read_text(encoding="utf-8"))
        if "missing" in told:
            raise ImportError(told["missing"])
        if "error" in told:
            raise refuse(told["error"])
        with np.load(out) as file:
            arrays = {name: file[name] for name in file.files}
        meta: dict[str, Any] = told["meta"]
        return arrays, meta


def main(module: str, path: str, out: str) -> None:
    """What the child does: read, and write arrays and a report; the report comes last."""
    import importlib

    reader = importlib.import_module(f"ahrs_rs.io.{module}")
    report: dict[str, Any]
    try:
        reader.prepare()
        _limit_memory(Path(path).stat().st_size)
        arrays, meta = reader.in_child(path)
        np.savez(out, **arrays)
        report = {"meta": meta}
    except ImportError as error:
        report = {"missing": str(error)}
    except MemoryError:
        report = {"error": f"is not a readable {reader.WHAT}: the library wanted too much memory"}
    except ValueError as error:
        report = {"error": str(error)}
    except BaseException as error:  # a panic of a Rust library is no Exception
        words = " ".join(str(error).split())
        report = {"error": f"is not a readable {reader.WHAT}: {shortened(words)}"}
    Path(out).with_suffix(".json").write_text(json.dumps(report), encoding="utf-8")


def _limit_memory(size: int) -> None:
    """Bound the data that this process may hold, where the system can (Linux)."""
    try:
        import resource

        status = Path("/proc/self/status").read_text(encoding="ascii")
    except (ImportError, OSError):
        return
    held = next(int(line.split()[1]) * 1024 for line in status.splitlines() if line.startswith("VmData:"))
    limit = held + MEMORY + MEMORY_TIMES * size
    resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
