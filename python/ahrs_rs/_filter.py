"""The base class of all filters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self, cast

from numpy.typing import ArrayLike

from ahrs_rs import _html, _inputs, _validate
from ahrs_rs._engine import SETTINGS, Engine, dtype_name
from ahrs_rs._estimate import Estimate
from ahrs_rs._recording import Recording
from ahrs_rs._signature import in_lines
from ahrs_rs._state import Snapshot, State
from ahrs_rs._status import Status
from ahrs_rs._typing import Floats


class Filter(Engine):
    """An attitude filter with its parameters: the base class of all filters.

    ``run`` takes whole recordings and never changes the filter; ``update`` goes on sample by
    sample from its own state. All arguments are keywords. Filters are equal where class,
    parameters and settings are; the streaming state does not count.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s
        at most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.
    **params : float, str or bool
        The filter's own parameters.

    Raises
    ------
    TypeError
        A parameter that the filter does not have, an argument without a name, or this class
        itself in place of a filter's.
    ValueError
        A value that a parameter does not take.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> f = ar.FILTERS["Madgwick"](rate=100.0, beta=0.1)
    >>> f.rate, f.beta
    (100.0, 0.1)
    >>> isinstance(f, ar.Filter)
    True
    """

    @classmethod
    def preset(cls, name: str, **keywords: Any) -> Self:
        """A filter with the parameters of a paper.

        Parameters
        ----------
        name : str
            Of ``PRESETS``.
        **keywords : float, str or bool
            Further ones of the constructor; they go over those of the preset.

        Returns
        -------
        Filter
            One of this class.

        Raises
        ------
        ValueError
            A name that the filter does not have.

        Examples
        --------
        >>> import ahrs_rs as ar
        >>> ar.Madgwick.preset("ludwig2018", rate=100.0).beta
        0.011765
        """
        if name not in cls.PRESETS:
            hint = _validate.did_you_mean(name, cls.PRESETS)
            raise ValueError(f"name: expected one of {sorted(cls.PRESETS)} for {cls.NAME}, got {name!r}{hint}")
        return cls(**{**cls.PRESETS[name], **keywords})

    def __setattr__(self, name: str, value: object) -> None:
        if name in self.__dict__ or name in type(self).PARAMS:
            raise AttributeError(f"{name} cannot be changed: f.replace({name}=...) gives another {type(self).__name__}")
        super().__setattr__(name, value)

    def __eq__(self, other: object) -> bool:
        """Whether class, parameters and settings are the same; the streaming state does not count."""
        if not isinstance(other, Filter):
            return NotImplemented
        return type(self) is type(other) and self._keywords() == other._keywords()

    def __hash__(self) -> int:
        return hash((type(self), *self._keywords().values()))

    def get_params(self) -> dict[str, Any]:
        """All keywords of the constructor with their values.

        Returns
        -------
        dict
            By name: ``type(f)(**f.get_params()) == f``.
        """
        return self._keywords()

    def replace(self, **changes: Any) -> Self:
        """A new filter with some parameters or settings changed; it starts afresh.

        Parameters
        ----------
        **changes : float, str or bool
            As of the constructor.

        Returns
        -------
        Filter
            One of the same class.

        Raises
        ------
        TypeError
            A parameter that the filter does not have.
        ValueError
            A value that it does not take.

        Examples
        --------
        >>> import ahrs_rs as ar
        >>> ar.Mahony(rate=100.0).replace(kp=0.5).kp
        0.5
        """
        return type(self)(**{**self._keywords(), **changes})

    def __repr__(self) -> str:
        keywords = {**self._keywords(), "dtype": dtype_name(self.dtype)}
        defaults = {"rate": None, **SETTINGS, "dtype": "float64"}
        shown = [f"{key}={value!r}" for key, value in keywords.items() if value != defaults.get(key, ())]
        return f"{type(self).__name__}({', '.join(shown)})"

    def _repr_html_(self) -> str:
        rows: list[tuple[object, ...]] = [("rate", "not given" if self.rate is None else self.rate, "Hz", "")]
        for name, value in self.params.items():
            about = self.PARAMS[name]
            changed = "" if value == about.default else f"default {about.default}"
            rows.append((name, value, about.unit or "", changed))
        defaults = {**SETTINGS, "dtype": "float64"}
        given = {name: getattr(self, name) for name in SETTINGS} | {"dtype": dtype_name(self.dtype)}
        rows += [(name, value, "", "") for name, value in given.items() if value != defaults[name]]
        return _html.table(type(self).__name__, ("parameter", "value", "unit", ""), rows)

    @in_lines
    def run(
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
        threads: int | None = None,
    ) -> Estimate:
        """Attitudes of one recording, or of N recordings of equal length at once.

        Parameters
        ----------
        gyr : array_like, Recording or None
            (T, 3) or (N, T, 3) angular rate in rad/s. A `Recording` brings acc, mag and t. None
            for a filter that uses the gyroscope only where the accelerometer has no sample
            (``Tilt``, ``Ecompass``).
        acc : array_like, optional
            Same shape, specific force in m/s² (at rest, z up, +9.81 on z).
        mag : array_like, optional
            Same shape, magnetic field in µT.
        t : array_like, optional
            (T,) or (N, T) stamps in s that do not decrease; needed where the filter has no
            ``rate``. Also dates and durations of numpy, pandas, polars and Arrow (dates count
            from the first one).
        q0 : array_like or scipy.spatial.transform.Rotation, optional
            (4,) or (N, 4) attitude one step before the first sample; by default the first
            samples align.
        state : State or list of State, optional
            Go on from ``Estimate.state`` or ``Filter.state()``; N of them for N recordings.
        outputs : str or sequence of str, optional
            Names from ``OUTPUTS``, for ``Estimate.extra``.
        out : ndarray, optional
            (..., T, 4), into which the quaternions are written; after an error it holds
            anything.
        threads : int, optional
            How many recordings are computed at once; by default as many as there are cores and
            as the work pays for, or as AHRS_RS_NUM_THREADS says.

        Returns
        -------
        Estimate
            Attitudes, biases, status bits, and the state after the last sample.

        Raises
        ------
        ValueError
            Shapes that do not fit, infinite values, decreasing or non-finite stamps, a state of
            another filter; the message names the argument.

        Warns
        -----
        DataWarning
            Arrays look as if they were in g, in degrees a second, or stamped in ms.

        Notes
        -----
        Rows with a NaN are missing measurements: the filter goes on with what is left, and
        ``Estimate.status`` says so. Computed in float32 if all of gyr, acc and mag are float32,
        else in float64. Data frames and columns of pandas, polars and Arrow are taken as arrays.

        Examples
        --------
        >>> import numpy as np
        >>> import ahrs_rs as ar
        >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
        >>> ar.Mahony(rate=100.0).run(gyr, acc)
        <Estimate quat(50, 4), float64, gyr_bias>
        """
        call = self._call(gyr, acc, mag, t=t, q0=q0, state=state, outputs=outputs, out=out)
        if not isinstance(gyr, Recording):
            _inputs.doubt(call.native[0], call.native[1], call.native[3])
        (result,) = self._run([call.native], _validate.thread_count(threads), call.dtype == "float32", None, True)
        return self._estimate(call, result)

    @property
    def status(self) -> Status:
        """The status bits of the last update."""
        return Status(self._status())

    @property
    def covariance(self) -> Floats | None:
        """(3, 3) covariance of the attitude error in the sensor frame in rad²; None: there is none."""
        return self._output(self._output_index("covariance")) if "covariance" in self.OUTPUTS else None

    def state(self) -> State:
        """A snapshot of the streaming state.

        Returns
        -------
        State
            ``restore`` goes back to it, ``run(state=...)`` goes on from it.
        """
        return State._of_native(self.NAME, dtype_name(self.dtype), self._settings, self._snapshot())

    def restore(self, state: State) -> None:
        """Go back to a snapshot.

        Parameters
        ----------
        state : State
            Of a filter of the same class, dtype, parameters and settings.

        Raises
        ------
        ValueError
            A state of another filter.
        """
        checked = self._checked(state, dtype_name(self.dtype))
        self._restore((list(checked.variables), checked.last_t, checked.samples))

    def copy(self) -> Self:
        """A filter with the same parameters and streaming state, that goes its own way.

        Returns
        -------
        Filter
            One of the same class.
        """
        twin = type(self)(**self._keywords())
        if self.STREAMING:
            twin._restore(self._snapshot())
        return twin

    __copy__ = copy

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self.copy()

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (type(self), self._keywords(), self._snapshot() if self.STREAMING else None, State.VERSION)


def _rebuild(
    cls: type[Filter], keywords: dict[str, Any], snapshot: Snapshot | None, version: int | None = None
) -> Filter:
    """The pickled filter; its state is checked as any other one."""
    made = cls(**keywords)
    if snapshot is not None:
        variables, last_t, samples = snapshot
        own = (cls.NAME, dtype_name(made.dtype), made._settings)
        made.restore(State(*own, tuple(variables), last_t, samples, cast(int, version)))
    return made
