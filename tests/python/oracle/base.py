"""What an oracle is to the driver, and what the driver tells it of a sample beside the measurements."""

from dataclasses import dataclass
from typing import NamedTuple

from .so3 import IDENTITY, Quat, Vec3


class Weights(NamedTuple):
    """How much accelerometer and magnetometer count beside each other, and the time in s for which both count."""

    acc: float
    mag: float
    time: float


@dataclass(frozen=True)
class Told:
    """Of one sample: the times in s that its measurements stand for; the step where there is none.

    `lost` is true where the rate is not that of the whole step, `recovering` while the attitude has not been found
    again since a loss; `usual` is the usual step in s, or this one where it is longer.
    """

    acc_interval: float
    mag_interval: float
    lost: bool = False
    recovering: bool = False
    usual: float = 0.0

    def weights(self, dt: float) -> Weights:
        """Those of docs/losses.md: T_a/T, T_m/T and T, the longer one of the two."""
        time = max(self.acc_interval, self.mag_interval)
        if time <= dt:
            return Weights(1.0, 1.0, dt)
        return Weights(self.acc_interval / time, self.mag_interval / time, time)


def steps(interval: float, usual: float) -> float:
    """How many usual steps (s) of the gyroscope a measurement stands for."""
    return interval / usual if 0.0 < usual < interval else 1.0


class Filter:
    """A filter, which computes in east-north-up.

    Attributes that it may have: `bias`, those of `OUTPUTS` and what a method `outputs` gives are reported after every
    sample, `flags` are the status bits of its last step.
    """

    #: It takes its start from the first measurements, with the time step of the rate.
    starts_itself = False
    #: It follows the magnetometer; else that gives the heading of the start.
    follows_field = False
    #: It is aligned again after a rotation that was lost.
    realigned = True
    #: It is told the variance of a rotation that was lost, by `lose_rotation`.
    has_covariance = False
    #: It expects to be switched on in motion.
    starts_in_motion = False
    #: It says how sure it is, by `claimed`, and starts anew, by `reopen`, where that is wrong.
    watched = False

    q: Quat = IDENTITY
    flags = 0

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude; everything else in the filter stays as it is."""
        raise NotImplementedError

    def start_from(self, q: Quat) -> None:
        """Start from an attitude that is given, one step before the first sample."""
        self.set_attitude(q)

    def realign(self, q: Quat) -> None:
        """Take over the attitude that was found after a loss."""
        self.set_attitude(q)

    def lose_rotation(self, variance: float) -> None:
        """A rotation was lost: its angle about each axis has this variance in rad²."""
        raise NotImplementedError

    def claimed(self) -> tuple[float, float]:
        """Variances of inclination (the larger one of two) and heading, in rad²."""
        raise NotImplementedError

    def known_mag_delay(self) -> float:
        """Delay in s of the magnetometer behind the gyroscope, as far as it is known."""
        return 0.0

    def reopen(self, bias: Vec3) -> None:
        """Start anew from the present attitude, with this bias of the gyroscope (rad/s)."""
        raise NotImplementedError

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample: angular rate (rad/s), specific force or None, magnetic field or None, time step (s)."""
        raise NotImplementedError
