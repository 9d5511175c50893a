"""Independent double-precision twins of the filters, written from the papers: plain loops over the samples.

Each line is an equation of its source, and none is rearranged for speed. What the library computes is tested
against them.
"""

from collections.abc import Mapping
from typing import Any

from numpy.typing import ArrayLike

from .complementary import Complementary
from .dcm_imu import DcmImu
from .driver import OracleResult, Settings, drive
from .ekf import EKF
from .fusion import Fusion
from .gyro_integration import GyroIntegration
from .linear_kalman import LinearKalman
from .madgwick import Madgwick
from .mahony import Mahony
from .mekf import MEKF
from .selfcal import SelfCalKF
from .tilt import Ecompass, Tilt
from .trigonometric import Trigonometric
from .vqf import VQF, BasicVQF

ORACLES: dict[str, type[Any]] = {
    "GyroIntegration": GyroIntegration,
    "Tilt": Tilt,
    "Ecompass": Ecompass,
    "Trigonometric": Trigonometric,
    "Complementary": Complementary,
    "Mahony": Mahony,
    "Madgwick": Madgwick,
    "LinearKalman": LinearKalman,
    "EKF": EKF,
    "DcmImu": DcmImu,
    "MEKF": MEKF,
    "VQF": VQF,
    "SelfCalKF": SelfCalKF,
    "BasicVQF": BasicVQF,
    "Fusion": Fusion,
}


def run(
    name: str,
    params: Mapping[str, Any],
    gyr: ArrayLike,
    acc: ArrayLike | None = None,
    mag: ArrayLike | None = None,
    *,
    t: ArrayLike | None = None,
    rate: float | None = None,
    q0: ArrayLike | None = None,
    frame: str = "ENU",
    declination: float = 0.0,
    gyr_hold: str = "zero-order",
    repeated: str = "new",
    gyr_range: float = 0.0,
) -> OracleResult:
    """Run the oracle of one filter over one recording.

    Parameters
    ----------
    name
        Class name of the filter, a key of `ORACLES`.
    params
        Parameters of the filter alone, without rate and what follows it.
    gyr, acc, mag
        (T, 3) arrays: rad/s, m/s² (specific force), µT. NaN rows are missing samples; acc and mag may be
        None.
    t, rate
        Times (T,) in s and/or sampling rate in Hz.
    q0
        Attitude (4,) in `frame`, one time step before sample 0.
    frame, declination, gyr_hold
        Earth frame of the output, magnetic declination in rad (positive east), "zero-order" or "linear".
    repeated, gyr_range
        What a repeated row is, "new" or "missing"; the largest rate (rad/s) of an axis of the gyroscope, 0 where it is
        not known.

    Raises
    ------
    KeyError
        If there is no oracle of that name.
    ValueError
        If an array has the wrong shape or an infinite value, t decreases, or an option is unknown.

    """
    return drive(
        ORACLES[name](**params),
        gyr,
        acc,
        mag,
        t=t,
        rate=rate,
        q0=q0,
        settings=Settings(frame, declination, gyr_hold, repeated, gyr_range),
    )


__all__ = ["ORACLES", "OracleResult", "run"]
