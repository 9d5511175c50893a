# Made by tools/stubs.py from the registry; do not edit.
from typing import Literal, Self

from numpy.typing import DTypeLike

from ahrs_rs._filter import Filter

FILTERS: dict[str, type[Filter]]
__all__ = ["FILTERS", "Complementary", "Ecompass", "GyroIntegration", "Madgwick", "Mahony", "Tilt", "Trigonometric"]

class GyroIntegration(Filter):
    @property
    def integration(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        integration: Literal["exponential", "first-order"] = "exponential",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        dtype: DTypeLike = ...,
    ) -> Self: ...

class Tilt(Filter):
    def __new__(
        cls,
        *,
        rate: float | None = None,
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        dtype: DTypeLike = ...,
    ) -> Self: ...

class Ecompass(Filter):
    def __new__(
        cls,
        *,
        rate: float | None = None,
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        dtype: DTypeLike = ...,
    ) -> Self: ...

class Trigonometric(Filter):
    @property
    def source(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        source: Literal["acc", "gyr"] = "acc",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        dtype: DTypeLike = ...,
    ) -> Self: ...

class Complementary(Filter):
    @property
    def tau(self) -> float: ...
    @property
    def integration(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        tau: float = 1.6616666666666666,
        integration: Literal["exponential", "first-order"] = "exponential",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        dtype: DTypeLike = ...,
    ) -> Self: ...

class Mahony(Filter):
    @property
    def kp(self) -> float: ...
    @property
    def ki(self) -> float: ...
    @property
    def integration(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        kp: float = 1.0,
        ki: float = 0.3,
        integration: Literal["exponential", "first-order"] = "exponential",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        dtype: DTypeLike = ...,
    ) -> Self: ...

class Madgwick(Filter):
    @property
    def beta(self) -> float: ...
    @property
    def zeta(self) -> float: ...
    @property
    def gradient(self) -> str: ...
    @property
    def integration(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        beta: float = 0.041,
        zeta: float = 0.0,
        gradient: Literal["tangent", "paper"] = "tangent",
        integration: Literal["exponential", "first-order"] = "exponential",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        dtype: DTypeLike = ...,
    ) -> Self: ...
