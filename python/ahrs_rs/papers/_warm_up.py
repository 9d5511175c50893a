"""Hyyti & Visala 2015, section 4.4: a gyroscope whose bias follows its temperature."""

from __future__ import annotations

import dataclasses

import numpy as np

import ahrs_rs as ar
from ahrs_rs._typing import FloatArray
from ahrs_rs.papers._study import Cell, Plot, Table, Verdict, lines

#: Table 4, SparkFun's gyroscope: slope and value at 0 °C of its bias, in °/s.
SLOPES = (-0.01188330, -0.00845710, 0.00542382)
AT_ZERO = (0.24566657, 0.19236960, -0.21682853)
#: Of the warming sensor, Hz; samples of a minute.
WARM_RATE = 10.0
MINUTE = 600
#: Part of the bias that may be left.
LEFT = 0.1


@dataclasses.dataclass(frozen=True, slots=True)
class WarmUp:
    """The gyroscope of a still sensor that warms up, in means of a minute, °/s."""

    temperature: FloatArray
    """(N,) °C"""
    before: FloatArray
    """(N, 3) as it is read."""
    after: FloatArray
    """(N, 3) calibrated."""
    model: ar.calibration.TemperatureCalibration

    @classmethod
    def of(cls, seed: int) -> WarmUp:
        """Simulated with the paper's sensor."""
        recording = ar.simulate.scenario("warm_up", rate=WARM_RATE, seed=seed)
        gyr, temperatures = recording.require("gyr"), recording.require("temperature")
        model = ar.calibration.warm_up_gyroscope((gyr, temperatures))
        calibrated = model.apply(gyr, temperatures)
        temperature, before, after = (
            array[: len(array) // MINUTE * MINUTE].reshape(-1, MINUTE, columns).mean(axis=1)
            for array, columns in ((temperatures, 1), (gyr, 3), (calibrated, 3))
        )
        return cls(temperature[:, 0], np.degrees(before), np.degrees(after), model)

    def verdict(self) -> Verdict:
        """By the range of the minutes' means."""
        before, after = (float(np.ptp(each, axis=0).max()) for each in (self.before, self.after))
        numbers = f"{before:.3g}°/s over {np.ptp(self.temperature):.3g} °C, {after:.2g}°/s left"
        return Verdict(after < LEFT * before, numbers)

    def table(self) -> Table:
        """Beside Table 4."""
        slope, at_zero = (np.degrees(each) for each in (self.model.bias_slope, self.model.bias_at_zero))
        before, after = (np.ptp(each, axis=0) for each in (self.before, self.after))
        rows: list[list[Cell]] = [
            [axis, SLOPES[i], float(slope[i]), AT_ZERO[i], float(at_zero[i]), float(before[i]), float(after[i])]
            for i, axis in enumerate("xyz")
        ]
        columns = ["axis", "slope (paper)", "slope", "at 0 °C (paper)", "at 0 °C", "range before", "range after"]
        note = "The sensor is simulated with the paper's Table 4, which the calibration has to find again."
        return Table("Table 4: bias of the gyroscope by temperature, °/s", columns, rows, note=note, form=".4f")

    def plot(self) -> Plot:
        """As Fig 11."""
        curves = {axis: self.before[:, i] for i, axis in enumerate("xyz")}
        curves |= {f"{axis}, model": self.before[:, i] - self.after[:, i] for i, axis in enumerate("xyz")}
        return lines("Gyroscope of a still, warming sensor", self.temperature, curves, "temperature [°C]", "bias [°/s]")
