"""Filters of a user's own beside those of the registry: classes, functions, and finished orientations of files."""

from __future__ import annotations

import copy
import inspect
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _inputs, _own_calls, _quat
from ahrs_rs._estimate import Estimate
from ahrs_rs._filter import Filter
from ahrs_rs._param import Param
from ahrs_rs._recording import Recording
from ahrs_rs._status import Status
from ahrs_rs._typing import FloatArray
from ahrs_rs._validate import choice, did_you_mean, number
from ahrs_rs.filters import FILTERS

__all__ = ["OwnFilter", "register"]


class OwnFilter:
    """A filter of a user's own, with all that is asked of those in ``FILTERS``: `register` makes such classes.

    Parameters
    ----------
    rate : float, optional
        Hz, for recordings without stamps.
    frame : str, optional
        The earth frame in which orientations are wanted: they are turned from the filter's own
        (its attribute ``FRAME``, "ENU" where it has none).
    declination : float, optional
        Rad; orientations by a magnetometer are turned by it, unless the filter itself asks for it.
    gyr_hold, repeated, gyr_range : object, optional
        Handed on where the filter asks for them.
    **params : object
        The filter's own.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> def still(gyr, acc, mag, t):
    ...     return np.tile([1.0, 0.0, 0.0, 0.0], (len(gyr), 1))
    >>> cls = ar.register(still, name="Still")
    >>> cls(rate=100.0).run(ar.simulate.demo(duration=1.0)).quat.shape
    (100, 4)
    """

    NAME: ClassVar[str] = ""
    PARAMS: ClassVar[Mapping[str, Param]] = MappingProxyType({})
    PRESETS: ClassVar[Mapping[str, Mapping[str, Any]]] = MappingProxyType({})
    OUTPUTS: ClassVar[Mapping[str, str]] = MappingProxyType({})
    STREAMING: ClassVar[bool] = False
    MAGNETOMETER: ClassVar[bool] = True
    #: What the user gave.
    THING: ClassVar[Any] = None
    OWN_FRAME: ClassVar[str] = "ENU"
    ORDER: ClassVar[str] = "wxyz"

    def __init__(
        self,
        rate: float | None = None,
        *,
        frame: str = "ENU",
        declination: float = 0.0,
        gyr_hold: str = "zero-order",
        repeated: str = "new",
        gyr_range: float = 0.0,
        **params: Any,
    ) -> None:
        self.rate = None if rate is None else number("rate", rate)
        self.frame = choice("frame", frame, tuple(_own_calls.TO_ENU))
        self.declination = number("declination", declination)
        self.settings = {
            "rate": self.rate,
            "frame": self.frame,
            "declination": self.declination,
            "gyr_hold": gyr_hold,
            "repeated": repeated,
            "gyr_range": gyr_range,
        }
        self._encoded(params)
        self.params = {name: param.default for name, param in self.PARAMS.items()} | params

    def __repr__(self) -> str:
        given = "".join(f", {name}={value!r}" for name, value in self.params.items())
        return f"{self.NAME}(rate={self.rate}{given})"

    @classmethod
    def _encoded(cls, params: Mapping[str, Any]) -> list[tuple[str, float]]:
        """The numbers of parameters, checked."""
        unknown = [name for name in params if name not in cls.PARAMS]
        if unknown:
            known = ", ".join(cls.PARAMS) or "none"
            raise ValueError(
                f"{cls.NAME} has no parameter {unknown[0]!r}{did_you_mean(unknown[0], cls.PARAMS)}; it has {known}"
            )
        return [(name, cls.PARAMS[name].encode(value)) for name, value in params.items()]

    def run(
        self,
        gyr: ArrayLike | Recording | None,
        acc: ArrayLike | None = None,
        mag: ArrayLike | None = None,
        *,
        t: ArrayLike | None = None,
        outputs: Any = (),
        threads: int | None = None,
        **unknown: Any,
    ) -> Estimate:
        """Attitudes of one recording.

        Parameters
        ----------
        gyr : array_like or Recording
            (T, 3) rad/s; a `Recording` brings acc, mag and t.
        acc, mag : array_like, optional
            (T, 3) m/s² and µT.
        t : array_like, optional
            (T,) s; needed where the filter has no rate.
        outputs : sequence of str, optional
            A filter of one's own has none.
        threads : int, optional
            Not used: it is computed where it is called.
        **unknown : object
            What only filters of the registry have, q0 and state: None.

        Returns
        -------
        Estimate
            Attitudes in `frame`, of unit norm and continuous sign, without bias and state.

        Raises
        ------
        ValueError
            What the filter gave is no orientations of these rows.
        """
        wrong = [name for name, value in unknown.items() if value is not None]
        if wrong:
            raise ValueError(f"{wrong[0]}: expected None, as {self.NAME} is no filter of the registry")
        if outputs:
            raise ValueError(f"outputs: expected none, as {self.NAME} has none, got {outputs!r}")
        recording = gyr if isinstance(gyr, Recording) else self._recording(gyr, acc, mag, t)
        raw = np.asarray(self._quats(recording), dtype=np.float64)
        quat = _own_calls.checked(self.NAME, raw, len(recording), self.ORDER)
        own = _quat.conjugate(np.asarray(_own_calls.TO_ENU[self.frame]))
        turn = _quat.multiply(own, np.asarray(_own_calls.TO_ENU[self.OWN_FRAME]))
        if self.declination and recording.mag is not None and "declination" not in self._asked():
            # Magnetic north is east of true north: what points to it turns clockwise.
            about = _quat.about_axis(2, np.array(-self.declination))
            turn = _quat.multiply(own, _quat.multiply(about, np.asarray(_own_calls.TO_ENU[self.OWN_FRAME])))
        quat = _own_calls.continuous(_quat.multiply(turn, quat))
        status = np.zeros(len(recording), dtype=np.uint16)
        for name, flag in (("gyr", Status.GYR_HELD), ("acc", Status.ACC_MISSING), ("mag", Status.MAG_MISSING)):
            rows = getattr(recording, name)
            if rows is not None:
                status[np.isnan(rows).any(axis=1)] |= flag.value
        return Estimate(quat, None, status, recording.t, None, MappingProxyType({}), self.frame)

    def _recording(self, gyr: Any, acc: Any, mag: Any, t: Any) -> Recording:
        gyr, acc, mag, t = _inputs.inputs(self.NAME, True, gyr, acc, mag, t, goes_on=False)
        arrays: dict[str, Any] = {
            name: None if one is None else np.asarray(one, dtype=np.float64)
            for name, one in (("gyr", gyr), ("acc", acc), ("mag", mag))
        }
        rows = arrays["gyr"]
        if rows is None or rows.ndim != 2:
            shape = None if rows is None else rows.shape
            raise ValueError(f"gyr: expected shape (T, 3), got {shape}: ar.run_many takes several recordings")
        if t is None:
            if self.rate is None:
                raise ValueError("t: expected stamps where the filter has no rate, got None")
            t = np.arange(len(rows)) / self.rate
        rate: dict[str, Any] = {} if self.rate is None else {"rate": self.rate}
        return Recording(t=t, **rate, **arrays)

    def _asked(self) -> tuple[str, ...]:
        """The names that the filter asks for."""
        return ()

    def _quats(self, recording: Recording) -> Any:
        raise NotImplementedError

    def _given(self, recording: Recording) -> dict[str, Any]:
        """What a filter may ask for of a recording as a whole."""
        rows = {name: getattr(recording, name) for name in ("gyr", "acc", "mag")}
        return {**self.settings, **rows, "t": recording.t, "rate": recording.rate, "recording": recording}


class _Object(OwnFilter):
    """A class with update or run, or an object of one, of which each recording has a copy."""

    def _asked(self) -> tuple[str, ...]:
        return _own_calls.names(self.THING) if isinstance(self.THING, type) else ()

    def _quats(self, recording: Recording) -> Any:
        if isinstance(self.THING, type):
            settings = {**self.settings, "rate": recording.rate}
            wanted = {name: value for name, value in settings.items() if name in self._asked()}
            made = self.THING(**wanted, **self.params)
        else:
            made = copy.deepcopy(self.THING)
        if hasattr(made, "run"):
            return _own_calls.called(made.run, self._given(recording), _own_calls.DATA[:4])
        return self._updated(made.update, recording)

    def _updated(self, update: Callable[..., Any], recording: Recording) -> FloatArray:
        """Sample after sample: a row that is missing is None, a gyroscope's keeps the last rate."""
        count = len(recording)
        gyr = recording.require("gyr")
        known = ~np.isnan(gyr).any(axis=1)
        last = np.maximum.accumulate(np.where(known, np.arange(count), -1))
        held = np.where((last >= 0)[:, None], gyr[last], 0.0)
        others = {name: _own_calls.rows_of(getattr(recording, name), count) for name in ("acc", "mag")}
        dt = np.diff(recording.t, prepend=recording.t[:1] - 1.0 / recording.rate)
        by_name = _own_calls.by_name(update, _own_calls.ROWS)
        quat = np.empty((count, 4))
        for k in range(count):
            given = {"gyr": held[k], "acc": others["acc"][k], "mag": others["mag"][k], "dt": float(dt[k])}
            found = np.asarray(
                update(**{name: given[name] for name in by_name}) if by_name else update(*given.values())
            )
            if found.shape != (4,):
                raise ValueError(f"{self.NAME}.update: expected a quaternion (4,), got shape {found.shape} at row {k}")
            quat[k] = found
        return quat


class _Function(OwnFilter):
    """A function of arrays."""

    def _asked(self) -> tuple[str, ...]:
        return _own_calls.names(self.THING)

    def _quats(self, recording: Recording) -> Any:
        found = _own_calls.called(self.THING, self._given(recording), _own_calls.DATA[:4], self.params)
        return found


def own_class(thing: Any, name: str | None = None) -> type[OwnFilter]:
    """The class of a filter of one's own; ``TypeError`` where it is none."""
    if isinstance(thing, type) and issubclass(thing, OwnFilter):
        return thing
    maker: type[OwnFilter]
    if isinstance(thing, Filter) or (isinstance(thing, type) and issubclass(thing, Filter)):
        raise TypeError(f"filter: {EXPECTED}, got {getattr(thing, '__name__', thing)}")
    if callable(getattr(thing, "update", None)) or callable(getattr(thing, "run", None)):
        maker = _Object
    elif callable(thing) and not isinstance(thing, type):
        maker = _Function
    else:
        raise TypeError(f"filter: {EXPECTED}, got {getattr(thing, '__name__', type(thing).__name__)}")
    frame = choice("FRAME", getattr(thing, "FRAME", "ENU"), tuple(_own_calls.TO_ENU))
    order = choice("ORDER", getattr(thing, "ORDER", "wxyz"), _own_calls.ORDERS)
    kind = thing if isinstance(thing, type) or maker is _Function else type(thing)
    called = str(name or getattr(thing, "NAME", None) or getattr(kind, "__name__", type(thing).__name__))
    body = {
        "__doc__": inspect.getdoc(thing),
        "NAME": called,
        "PARAMS": MappingProxyType(
            {} if not (isinstance(thing, type) or maker is _Function) else _own_calls.parameters(thing)
        ),
        "THING": staticmethod(thing) if maker is _Function else thing,
        "OWN_FRAME": frame,
        "ORDER": order,
        "MAGNETOMETER": bool(getattr(thing, "MAGNETOMETER", True)),
    }
    return type(called, (maker,), body)


#: What a filter of one's own is, for messages.
EXPECTED = (
    "expected a class of ar.FILTERS, as ar.Madgwick, or a filter of your own (a class with update or run, a function)"
)


def is_own(thing: Any) -> bool:
    """Whether it is a filter of a user's own, or an object of one."""
    if isinstance(thing, Filter) or (isinstance(thing, type) and issubclass(thing, Filter)):
        return False
    if isinstance(thing, OwnFilter):
        return True
    return (
        callable(getattr(thing, "update", None))
        or callable(getattr(thing, "run", None))
        or (callable(thing) and not isinstance(thing, type))
    )


def made(thing: Any) -> OwnFilter:
    """The object by which recordings are run."""
    return thing if isinstance(thing, OwnFilter) else own_class(thing)()


def register(thing: Any, *, name: str | None = None) -> type[OwnFilter]:
    """Make a filter of your own one of ``FILTERS``: by its name it is found there, on the command line too.

    Loops over ``FILTERS``, and so tables and tests, have only the filters of this package.

    Parameters
    ----------
    thing : type, callable or object
        One of

        - a class with ``update(gyr, acc, mag, dt)``, which gives the quaternion after a sample: vectors (3,), None
          where the recording has no sample, and the step in s
        - a class, or an object, with ``run``: of a ``recording``, or of ``gyr, acc, mag, t``; it gives (T, 4)
        - a function of ``gyr, acc, mag, t``, which gives (T, 4)
        - `Finished`

        Quaternions are scalar-first, sensor to ENU; ``FRAME = "NED"`` (or "NWU") and ``ORDER = "xyzw"`` say
        otherwise. Arguments with a default are parameters, by which `sweep` and `tuning` search. ``PARAMS = {name:
        (low, high)}`` gives their ranges, or a tuple of texts what there is to choose from.
    name : str, optional
        In place of the class's or function's own.

    Returns
    -------
    type
        A class as those of ``FILTERS``.

    Raises
    ------
    TypeError
        It is none of these.
    ValueError
        A filter of this package has the name.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> class Gyroscope:
    ...     def __init__(self, gain=1.0):
    ...         self.gain, self.quat = gain, np.array([1.0, 0.0, 0.0, 0.0])
    ...
    ...     def update(self, gyr, acc, mag, dt):
    ...         w, x, y, z = self.quat
    ...         turn = np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]]) @ gyr
    ...         self.quat = self.quat + 0.5 * self.gain * dt * turn
    ...         self.quat /= np.linalg.norm(self.quat)
    ...         return self.quat
    >>> cls = ar.register(Gyroscope)
    >>> cls is ar.FILTERS["Gyroscope"], "Gyroscope" in list(ar.FILTERS)
    (True, False)
    >>> found = ar.sweep(cls, {"gain": [0.5, 1.0]}, [ar.simulate.demo(duration=2.0)])
    >>> found.best
    {'gain': 1.0}
    """
    cls = own_class(thing, name)
    if dict.__contains__(FILTERS, cls.NAME):
        raise ValueError(f"name: expected one that no filter of the package has, got {cls.NAME!r}")
    FILTERS.own[cls.NAME] = cls
    return cls
