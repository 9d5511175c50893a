"""Orientations over time: angles, quaternion, bias, status, innovations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _display, _native
from ahrs_rs._optional import require
from ahrs_rs._status import Status
from ahrs_rs._typing import FloatArray
from ahrs_rs.plots import _figure
from ahrs_rs.plots._figure import COLOURS, as_array, column, finish, gap_bands, line, one, time_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ahrs_rs._estimate import Estimate

#: The least one that is shown.
LEAST_NIS = 1e-3
ANGLES = ("roll", "pitch", "yaw")


class Nis(NamedTuple):
    """A column of the normalised innovations squared of a filter."""

    label: str
    dof: int
    gate: str = ""
    """The parameter beyond whose square the filter rejects the measurement; empty where it rejects none."""


#: Of each filter with the output ``nis``: its columns.
NIS: dict[str, tuple[Nis, ...]] = {
    "LinearKalman": (Nis("roll", 1), Nis("pitch", 1)),
    "EKF": (Nis("gyroscope", 3), Nis("accelerometer", 3), Nis("magnetometer", 3)),
    "DcmImu": (Nis("accelerometer", 3),),
    "MEKF": (Nis("accelerometer", 2), Nis("magnetometer", 1, "mag_gate")),
}
#: Errors in degrees that a filter gives in place of innovations, and the parameter beyond which it rejects.
ANGLE_ERRORS = {"acceleration_error": "acceleration_rejection", "magnetic_error": "magnetic_rejection"}


def angles(
    estimate: Estimate | ArrayLike,
    t: ArrayLike | None = None,
    *,
    ref: ArrayLike | None = None,
    recording: int | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Roll, pitch and yaw over time, in degrees; lines are cut where an angle goes on at the other end of its range.

    Parameters
    ----------
    estimate : Estimate or array_like
        Of one recording; or quaternions (T, 4).
    t : array_like, optional
        (T,) stamps in s, for quaternions; their indices where None is given.
    ref : array_like, optional
        (T, 4) the truth, drawn dashed.
    recording : int, optional
        Which one, of an estimate of several.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        With a line for each angle.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        A wrong shape, or several recordings.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> est = ar.VQF().run(ar.simulate.demo(duration=5.0))
    >>> [line.get_label() for line in ar.plots.angles(est).lines]
    ['roll', 'pitch', 'yaw']
    """
    stamps, quat = _attitudes(estimate, t, recording)
    ax = one(ax)
    gap_bands(ax, stamps)
    _angle_lines(ax, stamps, quat, {})
    if ref is not None:
        truth = _quaternions("ref", ref)
        if len(truth) != len(stamps):
            raise ValueError(f"ref: expected shape {(len(stamps), 4)}, got {truth.shape}")
        _angle_lines(ax, stamps, truth, {"linestyle": (0, (4, 2)), "linewidth": 0.8, "alpha": 0.8}, " (truth)")
    finish(ax, "angle [°]")
    time_axis(ax)
    return ax


def quaternion(
    estimate: Estimate | ArrayLike, t: ArrayLike | None = None, *, recording: int | None = None, ax: Axes | None = None
) -> Axes:
    """The components w, x, y, z of the orientations over time.

    Parameters
    ----------
    estimate : Estimate or array_like
        Of one recording; or quaternions (T, 4).
    t : array_like, optional
        (T,) stamps in s, for quaternions; their indices where None is given.
    recording : int, optional
        Which one, of an estimate of several.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        With a line for each component.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        A wrong shape, or several recordings.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> len(ar.plots.quaternion(rec.ref, rec.t).lines)
    4
    """
    stamps, quat = _attitudes(estimate, t, recording)
    ax = one(ax)
    gap_bands(ax, stamps)
    for name, values, colour in zip("wxyz", quat.T, ("0.3", *COLOURS), strict=True):
        line(ax, stamps, values, label=name, color=colour)
    finish(ax, "quaternion")
    time_axis(ax)
    return ax


def bias(estimate: Estimate, *, recording: int | None = None, ax: Axes | None = None) -> Axes:
    """The gyroscope's bias over time, in degrees a second, with a band of one standard deviation where it is known.

    Parameters
    ----------
    estimate : Estimate
        Of a filter that estimates the bias. The band takes the output ``bias_sigma``.
    recording : int, optional
        Which one, of an estimate of several.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        With a line for each axis of the sensor.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        An estimate without a bias, or of several recordings.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> est = ar.VQF().run(ar.simulate.demo(duration=5.0), outputs="bias_sigma")
    >>> ax = ar.plots.bias(est)
    >>> len(ax.lines), len(ax.collections)
    (3, 3)
    """
    pick = _picked(estimate, recording)
    if estimate.gyr_bias is None:
        raise ValueError("estimate: expected one with a bias of the gyroscope, got gyr_bias None")
    ax = one(ax)
    t = pick(estimate.t, 1)
    values = np.degrees(pick(estimate.gyr_bias, 2))
    sigma = estimate.extra.get("bias_sigma")
    for name, each, colour in zip(_figure.AXES, values.T, COLOURS, strict=True):
        line(ax, t, each, label=name, color=colour)
        if sigma is not None:
            both = np.stack([each, np.degrees(pick(sigma, 1))], axis=1)
            at, shown = _display.thinned(*_display.broken(t, both, _display.gaps(t)), _figure.POINTS)
            low, high = shown[:, 0] - shown[:, 1], shown[:, 0] + shown[:, 1]
            ax.fill_between(at, low, high, color=colour, alpha=0.15, linewidth=0, label=f"{name} ± σ")
    if sigma is not None and values.size:
        # The band begins with what is not known at all: it shall not take the scale from the bias itself.
        _scale_to(ax, values)
    gap_bands(ax, t)
    finish(ax, "gyroscope's bias [°/s]")
    time_axis(ax)
    return ax


def status(estimate: Estimate, *, recording: int | None = None, ax: Axes | None = None) -> Axes:
    """The status bits as bands over time, a row for each bit that is set anywhere.

    Parameters
    ----------
    estimate : Estimate
        Of one recording.
    recording : int, optional
        Which one, of an estimate of several.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        With a row of bands for each bit.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        An estimate of several recordings.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> rec.acc[100:200] = float("nan")
    >>> ax = ar.plots.status(ar.Madgwick().run(rec))
    >>> [label.get_text() for label in ax.get_yticklabels()]
    ['ACC_MISSING']
    """
    pick = _picked(estimate, recording)
    ax = one(ax, size=(_figure.WIDTH, 2.2))
    t, bits = pick(estimate.t, 1), pick(estimate.status, 1)
    names = _set_bits(bits)
    for row, flag in enumerate(names):
        found = _display.spans(t, (bits & flag.value) != 0)
        ax.broken_barh([(begin, end - begin) for begin, end in found], (row - 0.4, 0.8), facecolor=f"C{row % 10}")
    ax.set_yticks(range(len(names)), [flag.name or "" for flag in names])
    ax.set_ylim(max(len(names), 1) - 0.4, -0.6)
    if len(t) > 1:
        ax.set_xlim(float(t[0]), float(t[-1]))
    if not names:
        ax.text(0.5, 0.5, "no flag at any sample", transform=ax.transAxes, ha="center", va="center", color="0.4")
    ax.grid(True, axis="x", color="0.9", linewidth=0.6)
    time_axis(ax)
    return ax


def innovations(
    estimate: Estimate, *, confidence: float = 0.997, recording: int | None = None, ax: Axes | None = None
) -> Axes:
    """What the measurements say against the prediction, over time, with the gates beyond which they are doubted.

    Where the estimate has ``nis``, the normalised innovations squared, which of an honest filter are below the dashed
    lines in the given share of samples (χ² of as many degrees of freedom); a dotted line is the filter's own gate,
    beyond which it rejects. ``Fusion``'s errors in degrees have its thresholds. Else the components of ``innovation``.

    Parameters
    ----------
    estimate : Estimate
        With one of the outputs ``nis``, ``acceleration_error``, ``magnetic_error``, ``innovation``.
    confidence : float, optional
        Share of the samples that is below a dashed line.
    recording : int, optional
        Which one, of an estimate of several.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        With a line for each measurement.

    Raises
    ------
    ImportError
        Matplotlib is not installed; for the gates of ``nis``, scipy.
    ValueError
        None of these outputs, several recordings, a confidence that is none.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> est = ar.MEKF().run(ar.simulate.demo(duration=5.0), outputs="nis")
    >>> ar.plots.innovations(est).get_ylabel()
    'normalised innovation squared'
    """
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence: expected a number between 0 and 1, got {confidence}")
    pick = _picked(estimate, recording)
    t = pick(estimate.t, 1)
    found = [name for name in ANGLE_ERRORS if name in estimate.extra]
    if "nis" in estimate.extra:
        ax = one(ax)
        values = pick(estimate.extra["nis"], 1)
        _nis(ax, t, _columns(values), _filter_of(estimate, recording), confidence)
    elif found:
        ax = one(ax)
        settings = _filter_of(estimate, recording)[1]
        for number, name in enumerate(found):
            line(ax, t, pick(estimate.extra[name], 1), label=name.replace("_", " "), color=f"C{number}")
            gate = float(settings.get(ANGLE_ERRORS[name], 0.0))
            if gate > 0.0:
                ax.axhline(gate, color=f"C{number}", linestyle=":", label=f"rejected above {gate:g}°")
        finish(ax, "error [°]")
    elif "innovation" in estimate.extra:
        ax = one(ax)
        values = _columns(pick(estimate.extra["innovation"], 1))
        for number, each in enumerate(values.T):
            line(ax, t, each, label=str(number), color=f"C{number}", linewidth=0.8)
        finish(ax, "innovation")
    else:
        wanted = ", ".join(["nis", *ANGLE_ERRORS, "innovation"])
        raise ValueError(f"estimate: expected one of the outputs {wanted}, got {', '.join(estimate.extra) or 'none'}")
    gap_bands(ax, t)
    time_axis(ax)
    return ax


def estimate(
    estimate: Estimate,
    *,
    ref: ArrayLike | None = None,
    recording: int | None = None,
    ax: Any = None,
) -> NDArray[Any]:
    """An estimate at a glance: angles, then bias, innovations and status where there is something of them.

    Parameters
    ----------
    estimate : Estimate
        Of one recording.
    ref : array_like, optional
        (T, 4) the truth, drawn dashed.
    recording : int, optional
        Which one, of an estimate of several.
    ax : Axes or sequence of Axes, optional
        As many as there are panels; by default on a new figure.

    Returns
    -------
    ndarray
        (n,) of axes, from top to bottom.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        Several recordings, or another number of axes.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> est = ar.VQF().run(ar.simulate.demo(duration=5.0))
    >>> [ax.get_ylabel() for ax in ar.plots.estimate(est)]
    ['angle [°]', "gyroscope's bias [°/s]"]
    """
    pick = _picked(estimate, recording)
    which: dict[str, Any] = {"recording": recording}
    drawn: list[Any] = [lambda ax: angles(estimate, ref=ref, ax=ax, **which)]
    if estimate.gyr_bias is not None:
        drawn.append(lambda ax: bias(estimate, ax=ax, **which))
    if any(name in estimate.extra for name in ("nis", *ANGLE_ERRORS, "innovation")):
        drawn.append(lambda ax: innovations(estimate, ax=ax, **which))
    if _set_bits(pick(estimate.status, 1)):
        drawn.append(lambda ax: status(estimate, ax=ax, **which))
    axes = column(ax, len(drawn))
    for each, draw in zip(axes, drawn, strict=True):
        draw(each)
        if each is not axes[-1]:
            each.set_xlabel("")
    return as_array(axes)


def _angle_lines(ax: Axes, t: FloatArray, quat: FloatArray, style: Mapping[str, Any], more: str = "") -> None:
    values = np.degrees(_native.euler_angles(quat))
    for name, each, colour in zip(ANGLES, values.T, COLOURS, strict=True):
        cut = _display.broken(t, each, _display.wraps(each, 360.0))
        # Gaps are looked for in the stamps themselves, before a cut adds some of its own.
        both = _display.broken(*cut, _after_gaps(cut[0], t))
        at, shown = _display.thinned(*both, _figure.POINTS)
        marker = {"marker": "o"} if np.count_nonzero(~np.isnan(shown)) == 1 else {}
        ax.plot(at, shown, **{"linewidth": 1.0, "label": f"{name}{more}", "color": colour, **marker, **style})


def _after_gaps(cut: FloatArray, t: FloatArray) -> NDArray[np.intp]:
    """The rows of the stamps with cuts that stand before the gaps of the stamps without."""
    return np.searchsorted(cut, t[_display.gaps(t)], side="right") - 1


def _nis(ax: Axes, t: FloatArray, values: FloatArray, of: tuple[str, Mapping[str, Any]], confidence: float) -> None:
    name, settings = of
    columns = NIS.get(name, tuple(Nis(str(number), 0) for number in range(values.shape[1])))
    for number, (each, about) in enumerate(zip(values.T, columns, strict=True)):
        colour = f"C{number}"
        # A vector of the field has three degrees of freedom, its heading has one.
        dof = 3 if about.gate and settings.get("magnetometer") == "vector" else about.dof
        shown = np.where(each > 0.0, each, np.nan)  # on a logarithmic axis
        line(ax, t, shown, label=about.label, color=colour, linewidth=0.7)
        if dof:
            chi2 = require("scipy.special", "scipy", "gates need").chdtri
            ax.axhline(
                float(chi2(dof, 1.0 - confidence)),
                color=colour,
                linestyle="--",
                linewidth=1.0,
                zorder=4,
                label=f"χ² of {dof}, {100.0 * confidence:g} %",
            )
        if about.gate in settings:
            gate = float(settings[about.gate]) ** 2
            ax.axhline(gate, color=colour, linestyle=":", linewidth=1.6, zorder=4, label=f"rejected above {gate:g}")
    ax.set_yscale("log")
    # Innovations come as close to zero as one likes; what matters is how large they are.
    ax.set_ylim(bottom=LEAST_NIS)
    finish(ax, "normalised innovation squared")


def _filter_of(estimate: Estimate, recording: int | None) -> tuple[str, Mapping[str, Any]]:
    """Name and settings of the filter that an estimate is of, as far as its state tells them."""
    state = estimate.state
    if isinstance(state, list):
        state = state[recording or 0] if state else None
    return ("", {}) if state is None else (state.filter, dict(state.settings))


def _columns(values: FloatArray) -> FloatArray:
    """(T, k) of values (T, ...), of no samples too."""
    return values.reshape(len(values), math.prod(values.shape[1:]))


def _set_bits(bits: NDArray[Any]) -> list[Status]:
    union = int(np.bitwise_or.reduce(bits)) if bits.size else 0
    return [flag for flag in Status if union & flag.value]


def _scale_to(ax: Axes, values: FloatArray) -> None:
    known = values[~np.isnan(values)]
    if known.size:
        low, high = float(known.min()), float(known.max())
        room = max(0.5 * (high - low), 0.02)
        ax.set_ylim(low - room, high + room)


def _attitudes(
    estimate: Estimate | ArrayLike, t: ArrayLike | None, recording: int | None
) -> tuple[FloatArray, FloatArray]:
    """Stamps (T,) and quaternions (T, 4)."""
    if hasattr(estimate, "quat") and hasattr(estimate, "status"):
        if t is not None:
            raise ValueError("t: expected None, as an estimate has stamps of its own")
        given = cast("Estimate", estimate)
        pick = _picked(given, recording)
        return pick(given.t, 1), pick(given.quat, 2)
    quat = _quaternions("estimate", estimate)
    stamps: FloatArray = np.arange(len(quat), dtype=np.float64) if t is None else np.asarray(t, dtype=np.float64)
    if stamps.shape != (len(quat),):
        raise ValueError(f"t: expected shape {(len(quat),)}, got {stamps.shape}")
    return stamps, quat


def _quaternions(name: str, value: Any) -> FloatArray:
    quat: FloatArray = np.asarray(value, dtype=np.float64)
    if quat.ndim != 2 or quat.shape[1] != 4:
        raise ValueError(f"{name}: expected shape (T, 4), got {quat.shape}")
    return quat


def _picked(estimate: Estimate, recording: int | None) -> Any:
    """A function that gives an array of one recording: called with the array and how many axes it has then."""
    several = estimate.quat.ndim == 3
    count = len(estimate.quat) if several else 1
    if recording is None and several:
        raise ValueError(f"recording: expected which of the {count} recordings is to be drawn, got None")
    if recording is not None and not 0 <= recording < count:
        raise ValueError(f"recording: expected a number from 0 to {count - 1}, got {recording}")

    def pick(array: NDArray[Any], axes: int) -> NDArray[Any]:
        return array[recording] if several and array.shape[:1] == (count,) and array.ndim > axes else array

    return pick
