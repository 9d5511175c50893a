"""Kalman filters know how wrong they are: errors and innovations of their own model have the covariances they report.

Data are drawn from the model of a filter, its start from the covariance of its start. Then the squared error over the
reported covariance (NEES) and the squared innovation over its covariance (NIS) are chi-square distributed, and so are
their sums over independent runs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

import ahrs_rs as ar
from signals import (
    FIELD,
    GRAVITY,
    RATE,
    UP,
    Floats,
    about_z,
    conjugate,
    multiply,
    quats,
    random_turns,
    rotation,
    squares,
    turned,
)

RUNS = 200
DT = 1.0 / RATE
OUTPUTS = ("covariance", "nis")
#: Of the steps whose mean over the runs lies within the band of 95 %. Errors outside it stay there for a while.
INSIDE = 0.9
#: Of the means over runs and steps, in units of the degrees of freedom. Innovations are independent: 200 runs of 1000
#: steps of 2 degrees or 1500 of 1 give a standard deviation of 0.26 %, and less with more. Errors are remembered, those
#: of the heading for 4 s, so that 200 runs of 15 s hold 750 independent ones of 3 degrees: 3 %.
NIS_MEAN = 0.01
NEES_MEAN = 0.08


@dataclass(frozen=True)
class Consistency:
    """Chi-square values (RUNS, T) and their degrees of freedom."""

    values: Floats
    degrees: int

    @property
    def mean(self) -> float:
        """Mean over runs and steps in units of the degrees of freedom: 1 if the filter is consistent."""
        return float(self.values.mean()) / self.degrees

    @property
    def inside(self) -> float:
        """Fraction of the steps at which the mean over the runs lies within the 95 % band."""
        low, high = chi2.ppf([0.025, 0.975], self.degrees * RUNS) / RUNS
        means = self.values.mean(axis=0)
        return float(np.mean((low <= means) & (means <= high)))


def seen(q: Floats, vector: Floats) -> Floats:
    """Earth vectors (3,) from sensors with attitudes (N, 4)."""
    return rotation(q).inv().apply(vector)


def attitude_nees(est: ar.Estimate, truth: Floats) -> Consistency:
    """Of the attitude error δθ in the sensor frame, truth = q̂ ⊗ exp(δθ/2)."""
    error = rotation(multiply(conjugate(est.quat), truth)).as_rotvec()
    return Consistency(squares(error, est.covariance), 3)


def inclination_nees(est: ar.Estimate, truth: Floats) -> Consistency:
    """Of the inclination alone, whatever the heading: by where the true vertical stands in the estimate's earth."""
    r = est.matrix()
    up = np.einsum("...ij,...j->...i", r, rotation(truth).inv().apply([0.0, 0.0, 1.0]))
    covariance = r @ est.covariance @ np.swapaxes(r, -1, -2)
    # A turn of the truth by δ about x and y puts its vertical at (-δy, δx, 1) in the estimate's earth.
    return Consistency(squares(np.stack((up[..., 1], -up[..., 0]), axis=-1), covariance[..., :2, :2]), 2)


# MEKF.

#: Without what makes the filter judge its measurements: adaptation, gates and rest.
MEKF: dict[str, float] = {
    "gyr_noise": 5e-3,
    "bias_noise": 5e-4,
    "acc_noise": 0.1,
    "heading_noise": 0.02,
    "acc_adaptation": 0.0,
    "mag_tolerance": 1e6,
    "mag_gate": 1e6,
    "rest_time": 1e9,
    "initial_inclination": 0.05,
    "initial_heading": 0.1,
    "initial_bias": 0.02,
}


def run_mekf(*, nine: bool, steps: int = 1500, **told: float) -> dict[str, Consistency]:
    """The filter, told parameters that differ from the true `MEKF`, over data of the latter."""
    rng = np.random.default_rng(1)
    q0 = quats(random_turns(RUNS, 2))
    # The error of the start stands in the earth frame, first a tilt, then a turn about the vertical.
    tilt = np.zeros((RUNS, 3))
    tilt[:, :2] = MEKF["initial_inclination"] * rng.standard_normal((RUNS, 2))
    heading = MEKF["initial_heading"] * rng.standard_normal(RUNS)
    q = multiply(about_z(heading), multiply(quats(Rotation.from_rotvec(tilt)), q0))
    bias = MEKF["initial_bias"] * rng.standard_normal((RUNS, 3))
    time = DT * np.arange(1, steps + 1)
    rates = np.stack((1.5 * np.sin(0.9 * time), 1.2 * np.cos(0.7 * time + 1.0), np.sin(0.5 * time + 2.0)), axis=1)
    gyr, acc, mag, truth = (np.empty((RUNS, steps, n)) for n in (3, 3, 3, 4))
    for k, rate in enumerate(rates):
        q = turned(q, np.tile(rate * DT, (RUNS, 1)))
        bias += MEKF["bias_noise"] * math.sqrt(DT) * rng.standard_normal((RUNS, 3))
        gyr[:, k] = rate + bias + MEKF["gyr_noise"] / math.sqrt(DT) * rng.standard_normal((RUNS, 3))
        acc[:, k] = seen(q, UP) + MEKF["acc_noise"] / math.sqrt(DT) * rng.standard_normal((RUNS, 3))
        # The noise of the field is one of its heading.
        shift = MEKF["heading_noise"] / math.sqrt(DT) * rng.standard_normal(RUNS)
        mag[:, k] = rotation(q).inv().apply(rotation(about_z(shift)).apply(FIELD))
        truth[:, k] = q
    f = ar.MEKF(rate=RATE, **{**MEKF, **told})
    est = f.run(gyr, acc, mag if nine else None, q0=q0, outputs=OUTPUTS)
    assert not est.status.any(), "a measurement was judged"
    nis = est.extra["nis"]
    found = {"NIS of acc": Consistency(nis[..., 0], 2)}
    if nine:
        found |= {"NEES": attitude_nees(est, truth), "NIS of mag": Consistency(nis[..., 1], 1)}
    else:
        found |= {"NEES": inclination_nees(est, truth)}
    return found


# EKF.


def run_ekf(gyroscope: str, steps: int = 1000, **told: float) -> dict[str, Consistency]:
    """The filter over data of its model at its default variances, told others.

    Its reference field is what the first magnetometer sample shows beside its accelerometer sample, or where there is
    none, from its own attitude: wrong with these, and not part of its state. So data whose first sample is drawn from
    the truth are not those of its model; nor are those whose first sample lacks its noise. Sample 0 therefore is a
    field alone, seen exactly as from the attitude that the filter has, within no time, so that nothing moves: the
    reference is exact, the innovation zero, and whatever this sample does to the covariance, the truth is drawn from
    what the filter reports after it.
    """
    rng = np.random.default_rng(3)
    # A heading known well enough for a first-order filter: the default's 0.09 rad squared is the inclination's 7e-3.
    settings: dict[str, Any] = {"gyroscope": gyroscope, "initial_heading": 0.02, **told}
    q0 = quats(random_turns(RUNS, 4))
    # A sample before it that shows nothing, at the same time: that of one sample alone says no step.
    still = np.zeros((RUNS, 2, 3))
    field = np.stack((np.full((RUNS, 3), np.nan), seen(q0, FIELD)), axis=1)
    f = ar.EKF(**settings)
    start = f.run(still, mag=field, q0=q0, t=np.zeros(2), outputs=OUTPUTS)
    p = ar.EKF().params
    sigma = {s: np.sqrt([p[f"{s}_variance_{axis}"] for axis in "xyz"]) for s in ("gyr", "acc", "mag")}
    noise = {s: lambda s=s: sigma[s] * rng.standard_normal((RUNS, 3)) for s in sigma}
    error = np.einsum("nij,nj->ni", np.linalg.cholesky(start.covariance[:, -1]), rng.standard_normal((RUNS, 3)))
    q = turned(start.quat[:, -1], error)
    # That sample's gyroscope showed zero.
    rate = noise["gyr"]()
    gyr, acc, mag, truth = (np.empty((RUNS, steps, n)) for n in (3, 3, 3, 4))
    wander = math.sqrt(p["rate_process"] * DT)
    for k in range(steps):
        if gyroscope == "input":  # of the step that ends here
            rate = rate + wander * rng.standard_normal((RUNS, 3))
        q = turned(q, rate * DT)
        if gyroscope == "measurement":  # of the end of the step
            rate = rate + wander * rng.standard_normal((RUNS, 3))
        q = q + math.sqrt(p["quat_process"] * DT) * rng.standard_normal((RUNS, 4))
        q /= np.linalg.norm(q, axis=1, keepdims=True)
        gyr[:, k] = rate + noise["gyr"]()
        acc[:, k] = GRAVITY * (seen(q, UP) / GRAVITY + noise["acc"]())
        size = np.linalg.norm(FIELD)
        mag[:, k] = size * (seen(q, FIELD) / size + noise["mag"]())
        truth[:, k] = q
    est = f.run(gyr, acc, mag, t=DT * np.arange(1, steps + 1), state=start.state, outputs=OUTPUTS)
    assert not est.status.any(), "a measurement was judged"
    nis = est.extra["nis"]
    used = {"measurement": ("gyr", "acc", "mag"), "input": ("acc", "mag")}[gyroscope]
    found = {f"NIS of {s}": Consistency(nis[..., ("gyr", "acc", "mag").index(s)], 3) for s in used}
    return found | {"NEES": attitude_nees(est, truth)}


FILTERS = {
    "MEKF in nine axes": lambda **told: run_mekf(nine=True, **told),
    "MEKF in six axes": lambda **told: run_mekf(nine=False, **told),
    "EKF": lambda **told: run_ekf("measurement", **told),
    "EKF with the gyroscope as input": lambda **told: run_ekf("input", **told),
}


@pytest.mark.parametrize("name", FILTERS)
def test_errors_and_innovations_have_the_covariances_that_the_filter_reports(name: str) -> None:
    for what, found in FILTERS[name]().items():
        assert found.mean == pytest.approx(1.0, abs=NEES_MEAN if what == "NEES" else NIS_MEAN), what
        assert found.inside > INSIDE, what


@pytest.mark.parametrize(
    ("name", "told", "what"),
    [
        ("MEKF in nine axes", {"gyr_noise": 0.5 * MEKF["gyr_noise"]}, "NEES"),
        ("MEKF in nine axes", {"heading_noise": 0.9 * MEKF["heading_noise"]}, "NIS of mag"),
        ("MEKF in six axes", {"acc_noise": 0.5 * MEKF["acc_noise"]}, "NEES"),
        ("MEKF in six axes", {"acc_noise": 0.9 * MEKF["acc_noise"]}, "NIS of acc"),
        ("EKF", {"quat_process": 1e-8}, "NEES"),
        ("EKF", {"rate_process": 0.1}, "NIS of gyr"),
        ("EKF with the gyroscope as input", {"quat_process": 1e-8}, "NEES"),
    ],
)
def test_a_filter_that_is_told_too_little_noise_is_found_out(name: str, told: dict[str, float], what: str) -> None:
    found = FILTERS[name](**told)[what]
    assert found.mean > 1.0 + (NEES_MEAN if what == "NEES" else NIS_MEAN)
    assert found.inside < INSIDE
