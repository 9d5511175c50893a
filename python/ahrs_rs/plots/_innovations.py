"""What the measurements say against the prediction, with the gates beyond which they are doubted."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ahrs_rs._optional import require
from ahrs_rs._typing import FloatArray
from ahrs_rs.plots._figure import finish, gap_bands, line, one, time_axis
from ahrs_rs.plots._picked import picked

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ahrs_rs._estimate import Estimate

#: The least one that is shown.
LEAST_NIS = 1e-3


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
#: The outputs that are drawn, the first one that is there.
OUTPUTS = ("nis", *ANGLE_ERRORS, "innovation")


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
    pick = picked(estimate, recording)
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
        raise ValueError(
            f"estimate: expected one of the outputs {', '.join(OUTPUTS)}, got {', '.join(estimate.extra) or 'none'}"
        )
    gap_bands(ax, t)
    time_axis(ax)
    return ax


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
