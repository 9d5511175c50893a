"""Low-pass filters for the signals of sensors: streaming, whole arrays, and without a delay through scipy.

>>> import numpy as np
>>> import ahrs_rs as ar
>>> acc = np.tile([0.0, 0.0, 9.81], (50, 1))
>>> ar.signal.low_pass(acc, cutoff=5.0, rate=100.0)[-1]
array([0.  , 0.  , 9.81])

`LowPass` and `low_pass` are causal, as firmware is (the core's ``signal::Butterworth`` has the same bits); `zero_phase`
runs forward and backward, for recordings only.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, Self, TypeAlias, cast, overload

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from ahrs_rs import _native, _stored
from ahrs_rs._optional import require
from ahrs_rs._typing import Floats

__all__ = ["LowPass", "LowPassState", "low_pass", "zero_phase"]

Snapshots: TypeAlias = list[tuple[list[float], float | None]]

#: The highest order of a Butterworth filter here.
HIGHEST_ORDER = 8

LOW_PASS_FORMAT = "ahrs_rs.low_pass_state"


@dataclass(frozen=True, slots=True)
class LowPassState:
    """Everything that the next sample depends on; a filter of other settings refuses it.

    It can be pickled, and goes through JSON by `to_json` and `from_json`; whatever way it comes, it is checked.

    Parameters
    ----------
    order : int
        Of the derivative; 0: the value.
    cutoff : float
        Hz.
    dtype : str
        ``"float32"`` or ``"float64"``.
    shape : tuple of int
        Of one sample: () or (C,).
    snapshots : tuple of tuple of tuple of float
        Of each recording, variables and the last stamp in s where stamps were given.
    version : int, optional
        Of the format; states of another one are refused.

    Raises
    ------
    ValueError
        A value of a wrong type, one that is not finite in the dtype, another version of the format.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> f = ar.signal.LowPass(2, 5.0, 100.0)
    >>> y = f.update(1.0)
    >>> ar.signal.LowPassState.from_json(f.state().to_json()) == f.state()
    True
    """

    VERSION: ClassVar[int] = 1
    """Of the format."""

    order: int
    cutoff: float
    dtype: str
    shape: tuple[int, ...]
    snapshots: tuple[tuple[tuple[float, ...], float | None], ...]
    version: int = VERSION

    def __post_init__(self) -> None:
        _stored.check_version(self.VERSION, self.version)
        _stored.dtype(self.dtype)
        object.__setattr__(self, "order", _order(self.order))
        object.__setattr__(self, "cutoff", _frequency("cutoff", self.cutoff))
        shape, snapshots = self.shape, self.snapshots
        if not isinstance(shape, (tuple, list)):
            raise ValueError(f"shape: expected a shape, got {_stored.shown(shape)}")
        if not (
            isinstance(snapshots, (tuple, list))
            and all(isinstance(one, (tuple, list)) and len(one) == 2 for one in snapshots)
        ):
            raise ValueError(f"snapshots: expected pairs, got {_stored.shown(snapshots)}")
        object.__setattr__(self, "shape", tuple(_stored.count("shape", size) for size in shape))
        kept = tuple(
            (_stored.variables(variables, _stored.LARGEST[self.dtype]), _stored.stamp(last))
            for variables, last in snapshots
        )
        object.__setattr__(self, "snapshots", kept)

    def __reduce__(self) -> tuple[Any, ...]:
        # By the constructor, so that an unpickled state is checked as any other one is.
        return type(self), (self.order, self.cutoff, self.dtype, self.shape, self.snapshots, self.version)

    def __setstate__(self, state: object) -> None:
        """What a pickle calls that was written before states had a version."""
        _stored.check_version(self.VERSION, None)

    def to_json(self) -> str:
        """The state as a line of JSON, from which `from_json` makes the same state, bit for bit.

        Returns
        -------
        str
            One line.
        """
        names = ("order", "cutoff", "dtype", "shape", "snapshots")
        return _stored.to_json(LOW_PASS_FORMAT, self.version, {name: getattr(self, name) for name in names})

    @classmethod
    def from_json(cls, text: str | bytes) -> Self:
        """The state that `to_json` wrote; ``ValueError`` where the text is none, or one of another version.

        Parameters
        ----------
        text : str or bytes
            What `to_json` gave.

        Returns
        -------
        LowPassState
            The same state.
        """
        names = ("order", "cutoff", "dtype", "shape", "snapshots")
        return cls(**_stored.from_json(text, LOW_PASS_FORMAT, cls.VERSION, names))


class LowPass:
    """A Butterworth low-pass filter, causal, of order 1 to 8.

    It starts at rest at the first sample, so there is no transient. It takes steps of any length; a repeated stamp
    changes nothing. A row with a NaN in any channel is no measurement: the output holds the last one, and the time
    counts towards the next step (before the first measurement the output is NaN). Channels that are not measured
    together should be filtered apart. A step of half a period of the cut-off or longer passes the sample through: a
    cut-off at or above the Nyquist frequency leaves the signal as it is, and after a long gap the filter starts afresh.

    Parameters
    ----------
    order : int
        1 to 8. Every order takes 20 dB a decade more, and delays more.
    cutoff : float
        Hz, where the gain is −3 dB.
    rate : float, optional
        Hz, for samples without stamps.
    dtype : data-type, optional
        Of `update`; `run` computes in float32 where the array is float32, else in float64.

    Raises
    ------
    ValueError
        An order, cutoff or rate that is not allowed.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> f = ar.signal.LowPass(2, 5.0, 100.0)
    >>> f.run(np.ones(4))
    array([1., 1., 1., 1.])
    """

    def __init__(self, order: int, cutoff: float, rate: float | None = None, *, dtype: DTypeLike = np.float64) -> None:
        self.order, self.cutoff = _order(order), _frequency("cutoff", cutoff)
        self.rate = None if rate is None else _frequency("rate", rate)
        self.dtype = np.dtype(dtype)
        if self.dtype not in (np.float32, np.float64):
            raise ValueError(f"dtype: expected float32 or float64, got {self.dtype}")
        self._state: LowPassState | None = None
        self._lock = threading.Lock()

    def __repr__(self) -> str:
        dtype = "" if self.dtype == np.float64 else f", dtype={self.dtype.name!r}"
        return f"LowPass(order={self.order}, cutoff={self.cutoff:g}, rate={self.rate}{dtype})"

    @overload
    def run(
        self,
        x: ArrayLike,
        t: ArrayLike | None = None,
        *,
        state: LowPassState | None = None,
        return_state: Literal[False] = False,
    ) -> Floats: ...
    @overload
    def run(
        self,
        x: ArrayLike,
        t: ArrayLike | None = None,
        *,
        state: LowPassState | None = None,
        return_state: Literal[True],
    ) -> tuple[Floats, LowPassState]: ...
    def run(
        self,
        x: ArrayLike,
        t: ArrayLike | None = None,
        *,
        state: LowPassState | None = None,
        return_state: bool = False,
    ) -> Floats | tuple[Floats, LowPassState]:
        """Filter whole signals; this object does not change.

        Parameters
        ----------
        x : array_like
            (T,), or (T, C) for C channels, or (N, T, C) for N recordings.
        t : array_like, optional
            (T,) or (N, T), stamps in s that do not decrease; needed where the filter has no `rate`.
        state : LowPassState, optional
            Go on from where another run, or `update`, has ended. Two runs give the bits of one.
        return_state : bool, optional
            Also return the state after the last sample.

        Returns
        -------
        array
            The filtered signal, of the shape of `x`; float32 for float32, else float64.

        Raises
        ------
        ValueError
            A wrong shape, infinite values, decreasing stamps, neither stamps nor rate, a state of another filter.
        """
        if t is None and self.rate is None:
            raise ValueError("t: expected stamps in s, as the filter was made without rate, got None")
        snapshots = None if state is None else self._snapshots(state)
        y, after = _native.low_pass(x, self.order, self.cutoff, self.rate, t, snapshots)
        if state is not None:
            self._check(state, y.dtype.name, y.shape[1:] if y.ndim < 3 else y.shape[2:])
        if not return_state:
            return y
        return y, self._wrap(y.dtype.name, y.shape[1:] if y.ndim < 3 else y.shape[2:], after)

    def update(self, x: ArrayLike, dt: float | None = None) -> Floats:
        """Take the next sample, a number or (C,), and return the filtered one.

        `dt` is the time since the last one in s (default: 1/rate).

        Parameters
        ----------
        x : array_like
            A number or (C,).
        dt : float, optional
            Step in s; by default 1 / rate.

        Returns
        -------
        ndarray
            The filtered sample, of the same shape.
        """
        sample = np.asarray(x, dtype=self.dtype)
        if sample.ndim > 1:
            raise ValueError(f"x: expected a number or shape (C,), got shape {sample.shape}")
        if dt is None:
            if self.rate is None:
                raise ValueError("dt: expected a time step in s, as the filter was made without rate, got None")
            dt = 1.0 / self.rate
        elif not (math.isfinite(dt) and dt >= 0.0):
            raise ValueError(f"dt: expected a finite number of seconds, not negative, got {dt}")
        with self._lock:
            state, stamps = self._state, None
            snapshots: Snapshots | None = None
            if state is not None:
                self._check(state, self.dtype.name, sample.shape)
                # Times are kept only as steps: the last stamp stands for zero.
                ((variables, _),) = state.snapshots
                snapshots = [(list(variables), 0.0)]
                stamps = [dt]
            y, after = _native.low_pass(sample[np.newaxis], self.order, self.cutoff, 1.0, stamps, snapshots)
            last = None if state is None or state.snapshots[0][1] is None else state.snapshots[0][1] + dt
            self._state = self._wrap(self.dtype.name, sample.shape, [(after[0][0], last)])
        return cast(Floats, y[0])

    def reset(self) -> None:
        """Forget all samples of `update`: the next one is what the filter starts at rest at."""
        with self._lock:
            self._state = None

    def state(self) -> LowPassState | None:
        """A snapshot of the streaming state, None before the first sample; for `restore` and ``run(state=...)``.

        Returns
        -------
        LowPassState, optional
            For `restore` and ``run(state=...)``.
        """
        return self._state

    def restore(self, state: LowPassState | None) -> None:
        """Go back to a snapshot; ``ValueError`` if it is of another filter or of many recordings.

        Parameters
        ----------
        state : LowPassState, optional
            Of a filter of the same settings; None: before the first sample.
        """
        if state is not None:
            self._check(state, self.dtype.name, state.shape)
            if len(state.snapshots) != 1:
                raise ValueError(f"state: expected a state of one recording, got one of {len(state.snapshots)}")
        with self._lock:
            self._state = state

    def copy(self) -> Self:
        """A filter with the same settings and the same streaming state that goes its own way.

        Returns
        -------
        LowPass
            It goes its own way.
        """
        twin = type(self)(self.order, self.cutoff, self.rate, dtype=self.dtype)
        twin._state = self._state
        return twin

    __copy__ = copy

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self.copy()

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (self.order, self.cutoff, self.rate, self.dtype.name, self._state)

    def _wrap(self, dtype: str, shape: Sequence[int], snapshots: Snapshots) -> LowPassState:
        kept = tuple((tuple(variables), last) for variables, last in snapshots)
        return LowPassState(self.order, self.cutoff, dtype, tuple(shape), kept)

    def _snapshots(self, state: LowPassState) -> Snapshots:
        if not isinstance(state, LowPassState):
            raise ValueError(f"state: expected a LowPassState, got {type(state).__name__}")
        self._check(state, state.dtype, state.shape)
        return [(list(variables), last) for variables, last in state.snapshots]

    def _check(self, state: LowPassState, dtype: str, shape: tuple[int, ...]) -> None:
        own = {"order": self.order, "cutoff": self.cutoff, "dtype": dtype, "shape": shape}
        for name, expected in own.items():
            if getattr(state, name) != expected:
                raise ValueError(f"state: expected one of {name} {expected}, got {getattr(state, name)}")


def _rebuild(order: int, cutoff: float, rate: float | None, dtype: str, state: LowPassState | None) -> LowPass:
    """The pickled filter."""
    made = LowPass(order, cutoff, rate, dtype=dtype)
    made.restore(state)
    return made


def low_pass(
    x: ArrayLike, cutoff: float, rate: float | None = None, order: int = 4, *, t: ArrayLike | None = None
) -> Floats:
    """Filter signals by a causal Butterworth low-pass, as `LowPass` does.

    Parameters
    ----------
    x : array_like
        (T,), (T, C) or (N, T, C).
    cutoff : float
        Hz, where the gain is −3 dB.
    rate : float, optional
        Hz; or `t`.
    order : int, optional
        1 to 8 (Parikh et al. 2021 use 4).
    t : array_like, optional
        (T,) or (N, T), stamps in s.

    Returns
    -------
    ndarray
        Of the shape of x.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> ar.signal.low_pass(np.ones(4), 5.0, 100.0)
    array([1., 1., 1., 1.])
    """
    return LowPass(order, cutoff, rate).run(x, t)


def zero_phase(x: ArrayLike, cutoff: float, rate: float, order: int = 4) -> NDArray[np.float64]:
    """Filter signals by a Butterworth low-pass forward and backward in time: no delay, for recordings only.

    The gain is that of the filter twice: −6 dB at `cutoff`, falling as of twice the order. Missing rows are
    interpolated linearly before, and missing in the result; at both ends the signal is extended by its odd reflection
    (scipy's ``sosfiltfilt``).

    Parameters
    ----------
    x : array_like
        (T,), (T, C) or (N, T, C), at a constant rate. A row with a NaN is no measurement.
    cutoff : float
        Hz, below half of `rate`.
    rate : float
        Hz.
    order : int, optional
        1 to 8, of the filter that is run twice.

    Returns
    -------
    ndarray
        Of the shape of x.

    Raises
    ------
    ImportError
        scipy is not installed.
    ValueError
        A wrong shape, infinite values, no row that is a measurement, or numbers that are not allowed.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> ar.signal.zero_phase(np.ones(40), 5.0, 100.0)[:2].round(6)
    array([1., 1.])
    """
    order, cutoff, rate = _order(order), _frequency("cutoff", cutoff), _frequency("rate", rate)
    if not cutoff < 0.5 * rate:
        raise ValueError(f"cutoff: expected less than half of rate, {0.5 * rate:g} Hz, got {cutoff:g}")
    try:
        values = np.array(x, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"x: expected an array of real numbers, got {error}") from None
    if values.ndim not in (1, 2, 3):
        raise ValueError(f"x: expected shape (T,), (T, C) or (N, T, C), got {values.shape}")
    if np.isinf(values).any():
        raise ValueError("x: expected finite values or NaN (missing), got an infinite value")
    design = require("scipy.signal", "scipy", "zero_phase needs")
    sections = design.butter(order, cutoff, fs=rate, output="sos")
    recordings = values if values.ndim == 3 else values.reshape(1, len(values), -1)
    for recording in recordings:  # views: the copy is changed in place
        missing = np.isnan(recording).any(axis=1)
        known = np.flatnonzero(~missing)
        if not known.size:
            raise ValueError("x: expected at least one row without NaN, got none")
        gaps = np.flatnonzero(missing)
        for channel in recording.T:
            channel[gaps] = np.interp(gaps, known, channel[known])
        # scipy's own length, or what the recording has.
        length = min(3 * (2 * len(sections) + 1), len(recording) - 1)
        recording[:] = design.sosfiltfilt(sections, recording, axis=0, padlen=length)
        recording[gaps] = np.nan
    return values


def _order(order: object) -> int:
    if isinstance(order, (int, np.integer)) and not isinstance(order, bool) and 1 <= order <= HIGHEST_ORDER:
        return int(order)
    raise ValueError(f"order: expected a whole number from 1 to {HIGHEST_ORDER}, got {order!r}")


def _frequency(name: str, value: object) -> float:
    try:
        number = float(cast(Any, value))
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not (math.isfinite(number) and number > 0.0):
        raise ValueError(f"{name}: expected a positive, finite number of Hz, got {value!r}")
    return number
