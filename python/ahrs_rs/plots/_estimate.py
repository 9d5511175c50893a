"""Orientations over time: angles, quaternion, bias, status."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _display, _native
from ahrs_rs._status import Status
from ahrs_rs._typing import FloatArray
from ahrs_rs.plots import _figure
from ahrs_rs.plots._figure import COLOURS, as_array, column, finish, gap_bands, line, one, time_axis
from ahrs_rs.plots._innovations import OUTPUTS, innovations
from ahrs_rs.plots._picked import picked

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ahrs_rs._estimate import Estimate

ANGLES = ("roll", "pitch", "yaw")


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
    pick = picked(estimate, recording)
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
    pick = picked(estimate, recording)
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
    pick = picked(estimate, recording)
    which: dict[str, Any] = {"recording": recording}
    drawn: list[Any] = [lambda ax: angles(estimate, ref=ref, ax=ax, **which)]
    if estimate.gyr_bias is not None:
        drawn.append(lambda ax: bias(estimate, ax=ax, **which))
    if any(name in estimate.extra for name in OUTPUTS):
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
        pick = picked(given, recording)
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
