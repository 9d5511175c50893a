"""What a filter does with its arguments: how its calls reach the native side, and come back."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from functools import cached_property, partial
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from ahrs_rs import _inputs, _native, _validate
from ahrs_rs._estimate import Estimate
from ahrs_rs._param import Param
from ahrs_rs._recording import Recording
from ahrs_rs._signature import in_lines
from ahrs_rs._state import Snapshot, State
from ahrs_rs._typing import Floats

FRAMES: tuple[str, ...] = tuple(_native.frames())
GYR_HOLDS: tuple[str, ...] = tuple(_native.gyr_holds())
REPEATED: tuple[str, ...] = tuple(_native.repeated_rules())

#: What every filter alike is asked for beside its rate and dtype, with the defaults.
SETTINGS: Mapping[str, str | float] = MappingProxyType(
    {
        "frame": FRAMES[0],
        "declination": 0.0,
        "gyr_hold": GYR_HOLDS[0],
        "repeated": REPEATED[0],
        "gyr_range": 0.0,
    }
)


#: The dtypes that are computed in, by themselves: `numpy.dtype.name` is made up at every look.
_DTYPES = {np.dtype(name): name for name in ("float64", "float32")}
#: The further outputs of a run that asks for none.
_NO_EXTRA: Mapping[str, Floats] = MappingProxyType({})


class Call(NamedTuple):
    """A run that is about to be made."""

    native: tuple[Any, ...]
    """gyr, acc, mag, t, q0, snapshots, indices of outputs, out."""
    dtype: str
    names: tuple[str, ...]
    """Those of the outputs."""
    states: list[State]


class Engine(_native.NativeFilter):
    """The private part of `ahrs_rs.Filter`."""

    NAME: ClassVar[str]
    PARAMS: ClassVar[Mapping[str, Param]]
    OUTPUTS: ClassVar[Mapping[str, str]]
    PRESETS: ClassVar[Mapping[str, Mapping[str, float | str | bool]]]
    STREAMING: ClassVar[bool]
    EQUIVARIANCE: ClassVar[str]
    SOURCE: ClassVar[str]
    _DEFAULTS: ClassVar[dict[str, float]]
    _SHOWN: ClassVar[Mapping[str, float | str | bool]]
    __signature__: ClassVar[inspect.Signature]
    GYROSCOPE: ClassVar[bool]
    """Whether it cannot do without a gyroscope."""
    MAGNETOMETER: ClassVar[bool]
    """Whether a magnetometer is used beyond the initial heading."""
    FEEDBACK: ClassVar[bool]
    """Whether an attitude error decays while the measurements are good."""

    rate: float | None
    frame: str
    declination: float
    gyr_hold: str
    repeated: str
    gyr_range: float
    dtype: np.dtype[Any]
    params: Mapping[str, float | str | bool]
    """The value of each parameter; also attributes of their own names."""

    @in_lines
    def __new__(
        cls,
        *positional: Any,
        rate: float | None = None,
        frame: str = "ENU",
        declination: float = 0.0,
        gyr_hold: str = "zero-order",
        repeated: str = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = np.float64,
        **params: Any,
    ) -> Self:
        if positional or not hasattr(cls, "NAME"):
            raise TypeError(cls._wrong_call(positional))
        if "gyr_range" in cls.PARAMS:  # a filter that has its own use for it
            params["gyr_range"], gyr_range = gyr_range, 0.0
        gyr_range = _validate.number("gyr_range", gyr_range)
        values = cls._encoded(params)
        kind = np.dtype(dtype)
        rate = None if rate is None else _validate.number("rate", rate)
        declination = _validate.number("declination", declination)
        frame, gyr_hold = _validate.choice("frame", frame, FRAMES), _validate.choice("gyr_hold", gyr_hold, GYR_HOLDS)
        repeated = _validate.choice("repeated", repeated, REPEATED)
        self = super().__new__(
            cls, cls.NAME, values, rate, frame, declination, gyr_hold, repeated, gyr_range, dtype_name(kind)
        )
        own = self.__dict__  # past `__setattr__`, which lets nothing be changed
        own["rate"], own["frame"], own["declination"], own["gyr_hold"] = rate, frame, declination, gyr_hold
        own["repeated"], own["dtype"] = repeated, kind
        if "gyr_range" not in cls.PARAMS:
            own["gyr_range"] = gyr_range
        own["params"] = cls._shown(values) if params else cls._SHOWN
        return self

    @classmethod
    def _wrong_call(cls, positional: tuple[Any, ...]) -> str:
        """What is wrong with a call that has arguments without names, or is of the base class."""
        if not hasattr(cls, "NAME"):
            return (
                f"{cls.__name__}: expected one of the classes in ar.FILTERS, as ar.Madgwick, got the base class of all"
            )
        got = ", ".join(type(each).__name__ if np.ndim(each) else repr(each) for each in positional)
        return f"{cls.NAME}: expected keywords, as {cls.NAME}(rate=100.0), got {got} as a positional argument"

    @classmethod
    def _shown(cls, values: Sequence[float]) -> Mapping[str, float | str | bool]:
        """The parameters whose numbers these are, as they are written."""
        numbers = zip(cls.PARAMS.items(), values, strict=True)
        return MappingProxyType(
            {name: value if spec.options is None else spec.options[int(value)] for (name, spec), value in numbers}
        )

    @classmethod
    def _encoded(cls, params: Mapping[str, Any]) -> list[float]:
        """The numbers of all parameters, those that are not given having their defaults; checked."""
        if not params.keys() <= cls.PARAMS.keys():
            unknown = next(name for name in params if name not in cls.PARAMS)
            known = list(dict.fromkeys([*cls.PARAMS, "rate", *SETTINGS, "dtype"]))
            hint = _validate.did_you_mean(unknown, known)
            raise TypeError(f"{cls.NAME} has no parameter {unknown!r}{hint}; it takes {', '.join(known)}")
        values = cls._DEFAULTS.copy()
        for name, value in params.items():
            values[name] = cls.PARAMS[name].encode(value)
        return list(values.values())

    def _keywords(self) -> dict[str, Any]:
        settings = {name: getattr(self, name) for name in SETTINGS}
        return {"rate": self.rate, **self.params, **settings, "dtype": self.dtype}

    @cached_property
    def _settings(self) -> tuple[tuple[str, float | str | bool], ...]:
        return tuple({**self.params, **{name: getattr(self, name) for name in SETTINGS}}.items())

    def _call(
        self,
        gyr: ArrayLike | Recording | None,
        acc: ArrayLike | None = None,
        mag: ArrayLike | None = None,
        *,
        t: ArrayLike | None = None,
        q0: ArrayLike | None = None,
        state: State | Sequence[State] | None = None,
        outputs: Sequence[str] = (),
        out: Floats | None = None,
    ) -> Call:
        """The arguments of `run` for the native side; ``ValueError`` where they are wrong."""
        gyr, acc, mag, t = _inputs.inputs(self.NAME, self.GYROSCOPE, gyr, acc, mag, t, goes_on=state is not None)
        dtype = "float32" if _native.all_float32(gyr, acc, mag) else "float64"
        if q0 is not None and state is not None:
            raise ValueError("q0: expected None where a state is given, got an attitude")
        names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
        indices = [self._output_index(name) for name in names]
        states = self._given_states(state, dtype)
        snapshots = None if states is None else [(list(s.variables), s.last_t, s.samples) for s in states]
        start = _inputs.attitude(q0)
        return Call((gyr, acc, mag, t, start, snapshots, indices, out), dtype, names, states or [])

    def _estimate(self, call: Call, result: Any) -> Estimate:
        """What the native side gave for a call."""
        quat, gyr_bias, status, extra, after = result
        t, out = call.native[3], call.native[7]
        if out is not None:
            quat = out
        further = MappingProxyType(dict(zip(call.names, extra, strict=True))) if extra else _NO_EXTRA
        # What comes later knows nothing of the call, whose arrays it would keep alive.
        later = partial(self._later, status.shape, call.dtype, after, call.states)
        est = Estimate._of_run(quat, gyr_bias, status, further, self.frame, later)
        if t is not None:
            object.__setattr__(est, "t", np.asarray(t, dtype=np.float64))
        return est

    def _later(
        self, shape: tuple[int, ...], dtype: str, after: list[Snapshot], before: list[State], name: str
    ) -> NDArray[np.float64] | State | list[State] | None:
        """The stamps (``"t"``) or the states after a run over arrays of a shape, from the states before it."""
        if name == "t":
            return self._stamps(shape[-1], before)
        if not self.STREAMING:
            return None
        states = [State._of_native(self.NAME, dtype, self._settings, snapshot) for snapshot in after]
        return states[0] if len(shape) == 1 else states

    def _given_states(self, state: State | Sequence[State] | None, dtype: str) -> list[State] | None:
        if state is None:
            return None
        states = [state] if isinstance(state, State) else list(state)
        return [self._checked(one, dtype) for one in states]

    def _checked(self, state: State, dtype: str) -> State:
        if not self.STREAMING:
            raise ValueError(f"state: expected None, as {self.NAME} is offline, got {type(state).__name__}")
        if not isinstance(state, State):
            raise ValueError(f"state: expected a State or a list of them, got {type(state).__name__}")
        state.check(self.NAME, dtype, self._settings)
        return state

    def _stamps(self, samples: int, before: list[State]) -> NDArray[np.float64]:
        """The stamps of a run at a constant rate, going on from the states."""
        rate = self.rate or 1.0  # without a rate there are no samples
        steps = np.arange(samples, dtype=np.float64)
        if not before:
            return np.divide(steps, rate, out=steps)
        rows = [(s.samples + steps) / rate if s.last_t is None else s.last_t + (steps + 1.0) / rate for s in before]
        same = all(np.array_equal(row, rows[0]) for row in rows[1:])
        return rows[0] if same else np.stack(rows)

    def _output_index(self, name: str) -> int:
        names = list(self.OUTPUTS)
        if name not in names:
            hint = _validate.did_you_mean(name, names)
            raise ValueError(f"outputs: expected names from {names} for {self.NAME}, got {name!r}{hint}")
        return names.index(name)


def dtype_name(dtype: np.dtype[Any]) -> str:
    return _DTYPES.get(dtype) or dtype.name
