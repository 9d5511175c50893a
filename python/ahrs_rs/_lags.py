"""How alike two signals of turning are at every offset of their clocks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._streams import Stream
from ahrs_rs._typing import FloatArray


def norms_of_rates(gyr: Stream, rate: float) -> FloatArray:
    """Norms of angular rates, rad/s, on a regular clock of so many Hz from the first stamp on; NaN in gaps."""
    grid = np.arange(gyr.t[0], gyr.t[-1], 1.0 / rate)
    rates = gyr.averaged(grid) if len(grid) > 1 else np.zeros((0, 3))
    norms: FloatArray = np.linalg.norm(rates, axis=1)
    return norms


def correlations(sensor: FloatArray, optical: FloatArray, least: int) -> tuple[NDArray[np.int64], FloatArray]:
    """The correlation of the logarithms at every lag, in samples: optical[k] stands at sensor[k + lag].

    NaN where fewer than `least` overlap, or one of them is constant. All sums over the overlaps are convolutions, by
    the fast Fourier transform.
    """
    size = 1 << (sensor.size + optical.size).bit_length()

    def over(a: FloatArray, b: FloatArray) -> FloatArray:
        found = np.fft.irfft(np.fft.rfft(a, size) * np.conj(np.fft.rfft(b, size)), size)
        return np.concatenate([found[size - optical.size + 1 :], found[: sensor.size]])

    there, here = (np.isfinite(one).astype(np.float64) for one in (sensor, optical))
    # Logarithms: a knock of the sensor is not to decide alone.
    x, y = (np.log(np.where(np.isfinite(one), np.maximum(one, 0.01), 1.0)) for one in (sensor, optical))
    x, y = x * there, y * here
    count = np.maximum(over(there, here), 1.0)
    mean_x, mean_y = over(x, here) / count, over(there, y) / count
    var_x = over(x * x, here) / count - mean_x**2
    var_y = over(there, y * y) / count - mean_y**2
    product = over(x, y) / count - mean_x * mean_y
    score = np.full(count.shape, np.nan)
    enough = (count >= least - 0.5) & (var_x > 1e-6) & (var_y > 1e-6)
    score[enough] = product[enough] / np.sqrt(var_x[enough] * var_y[enough])
    lags = np.arange(-(optical.size - 1), sensor.size)
    return lags, score
