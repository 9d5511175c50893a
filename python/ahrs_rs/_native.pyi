from collections.abc import Callable
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import disjoint_base

from ahrs_rs._state import Snapshot

__all__ = [
    "INSTRUCTIONS",
    "NativeFilter",
    "all_float32",
    "calibrate",
    "calibrate_at",
    "euler_angles",
    "frames",
    "gyr_holds",
    "low_pass",
    "registry",
    "repeated_rules",
    "rotation_matrices",
    "status_bits",
]

def registry() -> list[dict[str, Any]]: ...
def frames() -> list[str]: ...
def gyr_holds() -> list[str]: ...
def repeated_rules() -> list[str]: ...
def status_bits() -> list[tuple[str, int]]: ...

INSTRUCTIONS: str

def all_float32(gyr: ArrayLike, acc: ArrayLike | None = None, mag: ArrayLike | None = None) -> bool: ...
def calibrate(x: ArrayLike, matrix: list[list[float]], offset: list[float]) -> NDArray[np.floating[Any]]: ...
def calibrate_at(
    x: ArrayLike,
    temperature: ArrayLike,
    gain: tuple[list[float], list[float]],
    bias: tuple[list[float], list[float]],
) -> NDArray[np.floating[Any]]: ...
def euler_angles(quat: ArrayLike) -> NDArray[np.floating[Any]]: ...
def rotation_matrices(quat: ArrayLike) -> NDArray[np.floating[Any]]: ...
def low_pass(
    x: ArrayLike,
    order: int,
    cutoff: float,
    rate: float | None = None,
    t: ArrayLike | None = None,
    snapshots: list[tuple[list[float], float | None]] | None = None,
) -> tuple[NDArray[np.floating[Any]], list[tuple[list[float], float | None]]]: ...

@disjoint_base
class NativeFilter:
    def __new__(
        cls,
        name: str,
        values: list[float],
        rate: float | None,
        frame: str,
        declination: float,
        gyr_hold: str,
        repeated: str,
        gyr_range: float,
        dtype: str,
    ) -> Self: ...
    def update(
        self,
        gyr: ArrayLike,
        acc: ArrayLike | None = None,
        mag: ArrayLike | None = None,
        dt: float | None = None,
    ) -> NDArray[np.floating[Any]]: ...
    def reset(self, q0: ArrayLike | None = None) -> None: ...
    @property
    def quat(self) -> NDArray[np.floating[Any]]: ...
    @property
    def gyr_bias(self) -> NDArray[np.floating[Any]] | None: ...
    def _status(self) -> int: ...
    def _output(self, index: int) -> NDArray[np.floating[Any]]: ...
    def _snapshot(self) -> Snapshot: ...
    def _restore(self, snapshot: Snapshot) -> None: ...
    def _run(
        self,
        calls: list[tuple[Any, ...]],
        threads: int | None,
        float32: bool,
        progress: Callable[[int], object] | None,
        raising: bool,
    ) -> list[Any]: ...
    def _sweep(
        self,
        sets: list[list[float]],
        trials: list[tuple[Any, ...]],
        metric: str,
        threads: int | None,
        float32: bool,
        progress: Callable[[int], object] | None,
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_], BaseException | None]: ...
