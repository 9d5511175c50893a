"""What the oracles gave, kept in files: their plain loops take minutes, and what they give changes seldom.

Every `STEP`th row and the last one are kept, to 6e-14, and a hash of all status bits, in oracle/results/FILE.npz. Of
which sources each result is (`oracle_sources`) stands in oracle/results/sources.json. A test fails where these have
changed since; `make oracle` then computes all results in full, compares each row with the filter's, and keeps what is
new. A twentieth of what is kept is computed again in every run of the tests, another one at each commit.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from oracle import OracleResult

STEP = 50
#: One result of so many is computed again.
SHARE = 20
#: Results that differ by less (relative to one and to the number) are the same: a tenth of a test's smallest bound.
ROUNDING = 1e-13
HERE = Path(__file__).parent
FOLDER = HERE / "oracle" / "results"
SOURCES = "sources.json"
#: By how much a matrix may differ from its transpose and be kept as symmetric.
SYMMETRY = 1e-11
#: What the key of symmetric matrices ends with, of which the upper half is kept.
UPPER = "upper"
#: Set by `make oracle`: every result is computed, and kept where it is another one.
ALL = os.environ.get("AHRS_RS_ORACLE") == "all"
ADVICE = "`make oracle` computes anew what is kept of the oracles"

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Twin:
    """Some rows of what an oracle gave, or all of them."""

    name: str
    rows: NDArray[np.intp] | slice
    #: Of these rows: quat, gyr_bias where the filter has one, and the further outputs.
    values: Mapping[str, Floats]
    #: A hash of the status bits of all rows.
    status: str
    #: Which bits these are.
    mask: int
    compute: Callable[[], OracleResult]

    @property
    def extra(self) -> dict[str, Floats]:
        return {name: array for name, array in self.values.items() if name not in ("quat", "gyr_bias")}

    def assert_same_status(self, status: NDArray[Any]) -> None:
        """The status bits of all rows are the oracle's; where they are not, it is asked in which row."""
        if status_hash(status, self.mask) != self.status:
            full = self.compute().status.astype(np.int64)
            different = np.flatnonzero((status ^ full) & self.mask)
            assert len(different), f"{self.name}: the oracle gives another status than is kept; {ADVICE}"
            row = different[0]
            raise AssertionError(f"{self.name}: status in row {row}: {status[row]}, of the oracle {full[row]}")


def status_hash(status: NDArray[Any], mask: int) -> str:
    """Of status bits, whatever the width of their dtype."""
    return hashlib.sha256((status.astype("<i8") & mask).tobytes()).hexdigest()[:32]


def twins(
    file: str,
    name: str,
    sources: str,
    compute: Callable[[], OracleResult],
    *,
    mask: int = -1,
    status_only: bool = False,
) -> Iterator[Twin]:
    """What a filter is to agree with: the rows that are kept, all rows of a new computation, or both.

    Parameters
    ----------
    file, name : what it is, for those who read the folder
    sources : what it depends on (`sources_hash`)
    compute : runs the oracle
    mask : the status bits that count
    status_only : nothing but the status is kept
    """
    title = f"{file}: {name}"
    key = hashlib.sha256(f"{sources} {mask} {status_only} {STEP}".encode()).hexdigest()[:16]
    if not ALL:
        assert read_sources().get(title) == key, f"{title}: kept of other sources than the present ones; {ADVICE}"
        kept = read(file)[name]
        yield Twin(title, kept_rows(kept.length), kept.values, kept.status, mask, compute)
    if ALL or chosen(title):
        result = compute()
        values = {} if status_only else values_of(result)
        status = status_hash(result.status, mask)
        if ALL:
            rows = kept_rows(len(result.status))
            some = {output: array[rows] for output, array in values.items()}
            keep(file, name, key, Kept(status, len(result.status), sorted(some), some))
        yield Twin(title, slice(None), values, status, mask, lambda: result)


def values_of(result: OracleResult) -> dict[str, Floats]:
    bias = {} if result.gyr_bias is None else {"gyr_bias": result.gyr_bias}
    return {"quat": result.quat, **bias, **result.extra}


def kept_rows(length: int) -> NDArray[np.intp]:
    """Every `STEP`th and the last one."""
    return np.append(np.arange(0, length - 1, STEP), length - 1)


@cache
def commit() -> str:
    """The commit that is checked out, or nothing where there is none."""
    done = subprocess.run(["git", "rev-parse", "HEAD"], cwd=HERE, capture_output=True, text=True, check=False)
    return done.stdout.strip()


def chosen(title: str) -> bool:
    """Whether a result is one of those that this commit computes again."""
    return int.from_bytes(hashlib.sha256(f"{commit()} {title}".encode()).digest()[:8]) % SHARE == 0


# Files.


@dataclass(frozen=True)
class Kept:
    """What is kept of a result: a hash of all status bits, how many samples there are, and some rows of each output."""

    status: str
    length: int
    outputs: list[str]
    values: dict[str, Floats]


@cache
def read_sources() -> dict[str, str]:
    """The sources of all that is kept."""
    file = FOLDER / SOURCES
    known: dict[str, str] = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    return known


@cache
def read(file: str) -> dict[str, Kept]:
    """What a file holds, by name."""
    path = FOLDER / f"{file}.npz"
    if not path.exists():
        return {}
    with np.load(path) as arrays:
        found = {name: Kept(*status, {}) for name, *status in json.loads(str(arrays["index"]))}
        for key in set(arrays.files) - {"index"}:
            output, whole = unpacked(key, arrays[key])
            owners = [kept for kept in found.values() if output in kept.outputs]
            ends = np.cumsum([len(kept_rows(kept.length)) for kept in owners])
            for kept, array in zip(owners, np.split(whole, ends[:-1]), strict=True):
                kept.values[output] = array
    return found


def packed(output: str, values: Floats) -> dict[str, NDArray[Any]]:
    """An output as it is kept, by a key that says its shape.

    What is below half of `ROUNDING` is dropped, of a symmetric matrix the lower half, and bytes of like weight stand
    side by side, which compresses better.
    """
    key = [output, *map(str, values.shape[1:])]
    if values.ndim == 3 and is_symmetric(values):
        key.append(UPPER)
        values = values[:, *np.triu_indices(values.shape[1])]
    # Multiples of 2⁻⁴⁴, 5.7e-14, of one or of the power of two above the number.
    scale = np.exp2(44 - np.maximum(0, np.frexp(values)[1]))
    values = np.where(np.isfinite(values), np.rint(values * scale) / scale, values)
    return {" ".join(key): np.ascontiguousarray(values.astype("<f8").reshape(-1, 1).view(np.uint8).T)}


def is_symmetric(matrices: Floats) -> bool:
    """Whether all matrices (N, i, j) are, but for a tenth of what tests allow."""
    turned = np.swapaxes(matrices, 1, 2)
    return turned.shape == matrices.shape and np.allclose(matrices, turned, SYMMETRY, SYMMETRY, equal_nan=True)


def unpacked(key: str, weights: NDArray[np.uint8]) -> tuple[str, Floats]:
    """An output and its values, of what is kept."""
    output, *shape = key.split()
    values = np.ascontiguousarray(weights.T).view("<f8").astype(np.float64)
    if shape[-1:] != [UPPER]:
        return output, values.reshape(-1, *map(int, shape))
    size = int(shape[0])
    i, j = np.triu_indices(size)
    upper = values.reshape(-1, len(i))
    whole = np.empty((len(upper), size, size))
    whole[:, i, j] = whole[:, j, i] = upper
    return output, whole


def forget() -> None:
    """What was read: another process may have written since."""
    read_sources.cache_clear()
    read.cache_clear()


def keep(file: str, name: str, key: str, kept: Kept) -> None:
    """Writes a result, unless it is the one that is kept already but for rounding, and of which sources it is."""
    import fcntl  # of POSIX alone, as is `make`

    FOLDER.mkdir(exist_ok=True)
    folder = os.open(FOLDER, os.O_RDONLY)
    try:
        fcntl.flock(folder, fcntl.LOCK_EX)  # workers write into the same files
        forget()
        known, results = read_sources(), read(file)
        if name not in results or not same(results[name], kept):
            results = dict(sorted((results | {name: kept}).items()))
            # An output of all recordings is one array: many small ones take more for their heads.
            outputs = sorted(set().union(*(each.outputs for each in results.values())))
            arrays: dict[str, NDArray[Any]] = {}
            for o in outputs:
                arrays |= packed(o, np.concatenate([each.values[o] for each in results.values() if o in each.outputs]))
            index = json.dumps([[name, each.status, each.length, each.outputs] for name, each in results.items()])
            np.savez_compressed(FOLDER / f"{file}.npz", index=np.array(index), **arrays)
        known[f"{file}: {name}"] = key
        sources = FOLDER / SOURCES
        sources.write_text(json.dumps(known, indent=0, sort_keys=True) + "\n", encoding="utf-8")
    finally:
        os.close(folder)
        forget()


def same(old: Kept, new: Kept) -> bool:
    """Whether two results differ by rounding alone."""
    return (old.status, old.length, old.outputs) == (new.status, new.length, new.outputs) and all(
        old.values[output].shape == array.shape
        and np.allclose(old.values[output], array, rtol=ROUNDING, atol=ROUNDING, equal_nan=True)
        for output, array in new.values.items()
    )
