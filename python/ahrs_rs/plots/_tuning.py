"""The errors of a sweep over its parameters."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ahrs_rs._printable import in_figure
from ahrs_rs._typing import FloatArray
from ahrs_rs.plots._figure import one

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ahrs_rs._sweep import Sweep

#: Values whose largest is more than this many times the smallest are drawn on a logarithmic axis.
LOGARITHMIC = 20.0


def sweep(found: Sweep, params: str | Sequence[str] | None = None, *, ax: Axes | None = None) -> Axes:
    """The errors of a sweep over one parameter, or over two of them.

    Over one parameter: the error of each recording as a thin line, the mean as a thick one. Over two: the mean in
    colours. Of further parameters, those with the smallest mean error are taken at each place. A star is the best set.

    Parameters
    ----------
    found : Sweep
        From `ahrs_rs.sweep`.
    params : str or sequence of str, optional
        One or two parameters; by default the first two that have several values.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        With lines, or with a map and its colour bar.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        Parameters that were not swept, or more than two.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> found = ar.sweep(ar.Madgwick, {"beta": [0.02, 0.05, 0.1]}, [rec])
    >>> ar.plots.sweep(found).get_xlabel()
    'beta'
    """
    names = _chosen(found, params)
    values = {name: _values(found, name) for name in names}
    ax = one(ax, size=(6.5, 4.2))
    if len(names) == 2:
        _surface(ax, found, names, values)
    else:
        _curves(ax, found, names[0], values[names[0]])
    unit = "" if found.metric not in ("total", "heading", "inclination") else " error [°]"
    label = in_figure(f"{found.metric}{unit}")
    if len(names) == 2:
        ax.figure.colorbar(ax.collections[0], ax=ax, label=label)
    else:
        ax.set_ylabel(label)
    ax.set_title(
        f"{found.filter}, {found.errors.shape[1]} recording{'s' * (found.errors.shape[1] != 1)}", fontsize="medium"
    )
    return ax


def _curves(ax: Axes, found: Sweep, name: str, values: list[Any]) -> None:
    places = _places(ax.xaxis, ax.set_xscale, values)
    each = np.array([_smallest(found, {name: value}, found.errors) for value in values])  # (V, R)
    mean = np.array([_smallest(found, {name: value}, found.mean[:, np.newaxis])[0] for value in values])
    for number, column in enumerate(each.T):
        ax.plot(places, column, color="0.6", linewidth=0.6, label="a recording" if not number else None)
    ax.plot(places, mean, color="C0", linewidth=2.0, marker="o", markersize=3, label="mean")
    if not np.isnan(mean).all():
        best = int(np.nanargmin(mean))
        ax.plot(
            places[best], mean[best], "*", color="C3", markersize=12, label=f"best: {_text(values[best])}", zorder=5
        )
    ax.set_xlabel(name)
    ax.grid(True, color="0.9", linewidth=0.6)
    ax.legend(frameon=False, fontsize="small")


def _surface(ax: Axes, found: Sweep, names: list[str], values: dict[str, list[Any]]) -> None:
    x, y = (values[name] for name in names)
    mean = found.mean[:, np.newaxis]
    grid = np.full((len(y), len(x)), np.nan)
    for (row, b), (number, a) in itertools.product(enumerate(y), enumerate(x)):
        grid[row, number] = _smallest(found, {names[0]: a, names[1]: b}, mean)[0]
    along, up = _places(ax.xaxis, ax.set_xscale, x), _places(ax.yaxis, ax.set_yscale, y)
    ax.pcolormesh(along, up, grid, shading="nearest", cmap="viridis_r")
    if not np.isnan(grid).all():
        below, beside = divmod(int(np.nanargmin(grid)), len(x))
        ax.plot(along[beside], up[below], "*", color="C3", markersize=14, markeredgecolor="white", zorder=5)
    ax.set_xlabel(names[0])
    ax.set_ylabel(names[1])


def _chosen(found: Sweep, params: str | Sequence[str] | None) -> list[str]:
    swept = list(dict.fromkeys(name for each in found.params for name in each))
    if params is None:
        several = [name for name in swept if len(_values(found, name)) > 1]
        names = (several or swept)[:2]
    else:
        names = [params] if isinstance(params, str) else list(params)
    if not 1 <= len(names) <= 2 or len(set(names)) != len(names) or not set(names) <= set(swept):
        raise ValueError(f"params: expected one or two of {', '.join(swept) or 'no parameter'}, got {params!r}")
    return names


def _values(found: Sweep, name: str) -> list[Any]:
    """The different values of a parameter, numbers in their order."""
    values = list(dict.fromkeys(each[name] for each in found.params if name in each))
    return sorted(values) if all(_is_number(value) for value in values) else values


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _places(axis: Any, set_scale: Any, values: list[Any]) -> FloatArray:
    """Where values stand on an axis: numbers at themselves, others at 0, 1, 2, ... with their names."""
    if not all(_is_number(value) for value in values):
        axis.set_ticks(range(len(values)), [_text(value) for value in values])
        return np.arange(len(values), dtype=np.float64)
    places: FloatArray = np.asarray(values, dtype=np.float64)
    if places[0] > 0.0 and places[-1] > LOGARITHMIC * places[0]:
        set_scale("log")
    return places


def _text(value: Any) -> str:
    return f"{value:.4g}" if _is_number(value) else in_figure(value)


def _smallest(found: Sweep, wanted: dict[str, Any], errors: FloatArray) -> FloatArray:
    """(R,) the smallest error of each column over the sets that have the wanted values; NaN where there is none."""
    which = [number for number, one in enumerate(found.params) if all(one.get(k) == v for k, v in wanted.items())]
    values = errors[which]
    known = ~np.isnan(values)
    least: FloatArray = np.where(known, values, np.inf).min(axis=0, initial=np.inf)
    return np.where(np.isfinite(least), least, np.nan)
