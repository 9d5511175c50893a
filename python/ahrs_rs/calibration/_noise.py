"""The noise of a sensor, from a recording in which it rests, and what it makes of the parameters of filters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._constants import GRAVITY
from ahrs_rs._recording import Recording
from ahrs_rs._typing import FloatArray
from ahrs_rs.calibration._allan import FEWEST_SAMPLES, Allan, allan
from ahrs_rs.calibration._rest import GyroscopeBias, Rest, find_rest, gyroscope_bias
from ahrs_rs.filters import FILTERS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Noise", "SensorNoise", "noise"]


#: By which Cirillo's EKF divides the specific force, m/s².
AXES = "xyz"
UNITS = {"gyr": "rad/s", "acc": "m/s²", "mag": "µT"}
#: Of the rows of a sensor at its own rate, as many may be missing; they are interpolated, which takes as much of the
#: noise.
MISSING_SHARE = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class SensorNoise:
    """The noise of one sensor of three axes.

    Parameters
    ----------
    unit : str
        Of the samples.
    rate : float
        Of its measurements, Hz.
    samples : int
        How many measurements were at rest.
    deviation : ndarray
        (3,) standard deviation of a sample about the mean of its phase.
    norm : float
        Of the mean over the phases: g for the accelerometer, the field's strength for the
        magnetometer.
    horizontal : float
        The part of that norm that is across the mean specific force; NaN without an accelerometer.
    axes : tuple
        The Allan deviations of x, y and z.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.record(ar.simulate.still(), rate=100.0, duration=60.0, sensor=ar.simulate.SENSORS["mpu9250"])
    >>> gyr = ar.calibration.noise(rec).sensors["gyr"]
    >>> gyr.unit, round(gyr.rate)
    ('rad/s', 100)
    """

    unit: str
    rate: float
    samples: int
    deviation: FloatArray
    norm: float
    horizontal: float
    axes: tuple[Allan, Allan, Allan]

    def mean(self, coefficient: str) -> float:
        """The root mean square over the axes of a coefficient, of those that are known; NaN where none is.

        Parameters
        ----------
        coefficient : str
            The name of a field of `Allan`: "quantisation", "random_walk", "bias_instability" or
            "rate_random_walk".

        Returns
        -------
        float
            NaN where none is known.
        """
        values = [getattr(one, coefficient).value for one in self.axes]
        known = [value for value in values if not math.isnan(value)]
        return math.sqrt(sum(value**2 for value in known) / len(known)) if known else math.nan


@dataclass(frozen=True, slots=True, eq=False)
class Noise:
    """The noise of all sensors of a recording at rest.

    Parameters
    ----------
    sensors : dict
        By name: "gyr", "acc", "mag", those that the recording has.
    covariance : ndarray
        Cirillo's V with all its elements, in the order ω, a, m: (9, 9), or (6, 6) without a
        magnetometer. ω in rad²/s², the specific force over g, the field over the norm of its mean.
    bias : GyroscopeBias
        Of the gyroscope.
    rest : Rest
        Where the sensor rests.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.record(ar.simulate.still(), rate=100.0, duration=60.0, sensor=ar.simulate.SENSORS["mpu9250"])
    >>> found = ar.calibration.noise(rec)
    >>> sorted(found.sensors)
    ['acc', 'gyr', 'mag']
    """

    sensors: dict[str, SensorNoise]
    covariance: FloatArray
    bias: GyroscopeBias
    rest: Rest

    @property
    def variances(self) -> FloatArray:
        """(9,) or (6,): the diagonal of V, which is what the `EKF` takes."""
        return np.diagonal(self.covariance).copy()

    def ekf_parameters(self) -> dict[str, float]:
        """Parameters of `EKF`: the variances of a sample of each axis. Process noises keep their defaults.

        Returns
        -------
        dict
            Keywords of `EKF`.
        """
        names = [f"{sensor}_variance_{axis}" for sensor in self.sensors for axis in AXES]
        return _allowed("EKF", dict(zip(names, self.variances.tolist(), strict=True)))

    def mekf_parameters(self) -> dict[str, float]:
        """Parameters of `MEKF`: densities as means over the axes. What the recording does not determine is left out.

        gyr_noise is the angle random walk N, bias_noise the rate random walk K, acc_noise the N of the accelerometer,
        and heading_noise that of the magnetometer over the field's horizontal part. In motion, acceleration is a larger
        error of the specific force than this noise, and the defaults of `MEKF` are set for that: of acc_noise and
        heading_noise these values are lower bounds.

        Returns
        -------
        dict
            Keywords of `MEKF`.
        """
        gyr = self.sensors["gyr"]
        found = {"gyr_noise": gyr.mean("random_walk"), "bias_noise": gyr.mean("rate_random_walk")}
        if "acc" in self.sensors:
            found["acc_noise"] = self.sensors["acc"].mean("random_walk")
        if "mag" in self.sensors:
            mag = self.sensors["mag"]
            found["heading_noise"] = mag.mean("random_walk") / mag.horizontal if mag.horizontal > 0.0 else math.nan
        return _allowed("MEKF", {name: value for name, value in found.items() if not math.isnan(value)})

    def to_dict(self) -> dict[str, Any]:
        """Everything but the curves' intervals, as JSON knows it; what is not known is None.

        Returns
        -------
        dict
            What JSON knows.
        """
        return {
            "format": "ahrs_rs.noise",
            "version": 1,
            "rest": [list(one) for one in self.rest.seconds],
            "gyr_bias": {
                "unit": "rad/s",
                "value": self.bias.value.tolist(),
                "standard_error": self.bias.standard_error.tolist(),
            },
            "sensors": {name: _sensor_dict(one) for name, one in self.sensors.items()},
            "covariance": self.covariance.tolist(),
            "parameters": {"MEKF": self.mekf_parameters(), "EKF": self.ekf_parameters()},
        }

    def figure(self) -> Figure:
        """The Allan deviations of all axes with their confidence, and the fitted models; needs matplotlib.

        Returns
        -------
        Figure
            One panel a sensor.
        """
        from ahrs_rs import plots  # for drawing only

        plots.require_matplotlib()
        from matplotlib.figure import Figure

        figure = Figure(figsize=(4.6 * len(self.sensors) + 0.4, 4.4), layout="constrained")
        plots.noise(self, ax=figure.subplots(1, len(self.sensors), squeeze=False)[0])
        return figure

    def plot(self, *, ax: Any = None) -> NDArray[Any]:
        """Draw the Allan deviations of all sensors, side by side.

        Parameters
        ----------
        ax : Axes or sequence of Axes, optional
            As many as there are sensors; by default on a new figure.

        Returns
        -------
        ndarray
            (n,) of axes.

        Raises
        ------
        ImportError
            Matplotlib is not installed (``pip install ahrs-rs[plot]``).
        ValueError
            Another number of axes.
        """
        from ahrs_rs import plots  # for drawing only

        return plots.noise(self, ax=ax)


def noise(recording: Recording, rest: Rest | None = None, *, confidence: float = 0.95) -> Noise:
    """The noise of the sensors of a recording while they rest.

    All phases are taken together: variances and Allan deviations are means over them, each about its own mean. A sensor
    that is slower than the recording (rows of NaN between its measurements) has its own rate.

    Parameters
    ----------
    recording : Recording
        A longer rest shows slower noises: coefficients are known up to a fifth of the longest
        phase.
    rest : Rest, optional
        From `find_rest`, which is called where None is given.
    confidence : float, optional
        Of the intervals, and by which a coefficient must be above zero to be given.

    Returns
    -------
    Noise
        Of all sensors.

    Raises
    ------
    ImportError
        scipy is not installed.
    ValueError
        No rest, too few samples, or samples that are all equal; the message names the sensor.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.record(ar.simulate.still(), rate=100.0, duration=60.0, sensor=ar.simulate.SENSORS["mpu9250"])
    >>> sorted(ar.calibration.noise(rec).mekf_parameters())[:2]
    ['acc_noise', 'gyr_noise']
    """
    rest = find_rest(recording) if rest is None else rest
    if rest.mask.shape != (len(recording),):
        raise ValueError(f"rest: expected one of {len(recording)} samples, got shape {rest.mask.shape}")
    arrays = {name: array for name in UNITS if (array := getattr(recording, name)) is not None}
    means = {name: _phase_mean(name, array, rest.longest) for name, array in arrays.items()}
    up = means["acc"] / np.linalg.norm(means["acc"]) if "acc" in means else np.full(3, np.nan)
    sensors = {}
    for name, array in arrays.items():
        series, stride = _series(name, array, rest.phases)
        rate = recording.rate / stride
        axes = []
        for index, axis in enumerate(AXES):
            try:
                axes.append(allan([one[:, index] for one in series], rate, unit=UNITS[name], confidence=confidence))
            except ValueError as error:
                raise ValueError(f"{name}, axis {axis}: {error}") from None
        count = sum(map(len, series))
        freedom = max(count - len(series), 1)
        deviation = np.sqrt(sum(((one - one.mean(axis=0)) ** 2).sum(axis=0) for one in series) / freedom)
        norm = float(np.linalg.norm(means[name]))
        across = float(np.linalg.norm(np.cross(means[name], up)))
        sensors[name] = SensorNoise(UNITS[name], rate, count, deviation, norm, across, (axes[0], axes[1], axes[2]))
    scales = {"gyr": 1.0, "acc": GRAVITY, "mag": sensors["mag"].norm if "mag" in sensors else 1.0}
    covariance = _covariance([array / scales[name] for name, array in arrays.items()], rest.phases)
    return Noise(sensors, covariance, gyroscope_bias(recording, rest), rest)


def _covariance(arrays: Sequence[FloatArray], phases: Sequence[slice]) -> FloatArray:
    """Covariance of rows in which every sensor measures, each phase about its own mean."""
    rows = np.concatenate(arrays, axis=1)
    total, freedom = np.zeros((rows.shape[1], rows.shape[1])), 0
    for phase in phases:
        own = rows[phase]
        own = own[~np.isnan(own).any(axis=1)]
        if len(own) > 1:
            own = own - own.mean(axis=0)
            total += own.T @ own
            freedom += len(own) - 1
    if freedom < rows.shape[1]:
        raise ValueError(f"recording: expected more rows at rest in which all sensors measure, got {freedom + 1}")
    covariance: FloatArray = total / freedom
    return covariance


def _phase_mean(name: str, array: FloatArray, phase: slice) -> FloatArray:
    rows = array[phase]
    rows = rows[~np.isnan(rows).any(axis=1)]
    if not len(rows):
        raise ValueError(f"{name}: expected measurements at rest, got only rows with NaN")
    mean: FloatArray = rows.mean(axis=0)
    return mean


def _series(name: str, array: FloatArray, phases: Sequence[slice]) -> tuple[list[FloatArray], int]:
    """The measurements of each phase at the sensor's own rate, and that rate's share: every how many rows it
    measures."""
    known = [np.flatnonzero(~np.isnan(array[phase]).any(axis=1)) for phase in phases]
    steps = np.concatenate([np.diff(one) for one in known])
    if not len(steps):
        raise ValueError(f"{name}: expected at least {FEWEST_SAMPLES} measurements in a rest, got {len(known[0])}")
    stride = max(1, int(np.median(steps)))
    series = []
    for phase, rows in zip(phases, known, strict=True):
        if len(rows) < 2:
            continue
        grid = np.arange(rows[0], rows[-1] + 1, stride)
        missing = len(grid) - len(np.intersect1d(grid, rows, assume_unique=True))
        if missing > MISSING_SHARE * len(grid):
            raise ValueError(
                f"{name}: expected measurements at a constant rate, but {missing} of {len(grid)} are missing"
            )
        own = array[phase]
        series.append(np.stack([np.interp(grid, rows, own[rows, axis]) for axis in range(3)], axis=1))
    return series, stride


def _allowed(name: str, values: dict[str, float]) -> dict[str, float]:
    """The values within the ranges of the filter's parameters."""
    ranges = {key: FILTERS[name].PARAMS[key].range or (-math.inf, math.inf) for key in values}
    return {key: min(max(value, ranges[key][0]), ranges[key][1]) for key, value in values.items()}


def _sensor_dict(sensor: SensorNoise) -> dict[str, Any]:
    axes = []
    for one in sensor.axes:
        coefficients = {
            name: {
                "value": coefficient.value if coefficient.known else None,
                "interval": [coefficient.low, coefficient.high],
                "unit": coefficient.unit,
                "reason": coefficient.reason,
            }
            for name, coefficient in one.coefficients.items()
        }
        tau, deviation = one.minimum
        axes.append(
            {
                **coefficients,
                "minimum": {"tau": tau, "deviation": deviation},
                "fitted_from": one.fitted_from,
                "misfit": one.misfit,
                "tau": one.tau.tolist(),
                "deviation": one.deviation.tolist(),
            }
        )
    return {
        "unit": sensor.unit,
        "rate": sensor.rate,
        "samples": sensor.samples,
        "deviation": sensor.deviation.tolist(),
        "norm": sensor.norm,
        "axes": dict(zip(AXES, axes, strict=True)),
    }
