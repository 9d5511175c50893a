"""Writes docs/names.md, what one quantity is called in each filter: `make names`.

With --check, only says whether the file is current.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

from ahrs_rs import FILTERS, Param

PAGE = Path(__file__).parents[1] / "docs" / "names.md"

#: Quantity -> the parameters that stand for it, in whatever filter has them.
QUANTITIES = {
    "How fast the accelerometer corrects the inclination": (
        "tau", "kp", "beta", "gain", "tau_acc", "acc_noise", "acc_std",
    ),
    "How fast the magnetometer corrects the heading": ("tau_mag", "heading_noise", "mag_noise"),
    "Whether, and how fast, the gyroscope's bias is estimated": (
        "ki", "zeta", "bias", "motion_bias_est_enabled", "rest_bias_est_enabled", "bias_noise", "bias_process",
    ),
    "Standard deviation of the gyroscope's bias at the start": ("initial_bias", "bias_sigma_init"),
    "Noise of the angular rate": ("gyr_noise", "gyr_variance_x", "dcm_process", "angle_process"),
    "Rest: largest angular rate": ("rest_gyr", "rest_th_gyr", "stationary_threshold"),
    "Rest: largest deviation of the specific force": ("rest_acc", "rest_th_acc"),
    "Rest: how long it must last": ("rest_time", "rest_min_t", "stationary_period"),
    "Accelerometer: how acceleration takes away from its weight": (
        "acc_threshold", "acc_adaptation", "acc_motion", "acceleration_rejection",
    ),
    "Magnetometer: from which disturbance on it is rejected": (
        "mag_tolerance", "mag_norm_th", "mag_dip_th", "magnetic_rejection",
    ),
    "Magnetometer: how long it is rejected at most": ("mag_recovery", "mag_max_rejection_time", "rejection_timeout"),
    "Magnetometer: after which time a new field is the reference": ("mag_window", "mag_new_time"),
    "How late the magnetometer is": ("mag_delay", "initial_delay"),
    "How late the whole sensor is": ("latency",),
    "Largest rate that the gyroscope shows": ("gyr_range", "gyroscope_range"),
    "Integration of the angular rate over a step": ("integration", "prediction"),
    "Gravity of the place": ("gravity",),
}  # fmt: skip

HEAD = """# One quantity, many names

Made by `make names` from the registry; do not edit. Parameters keep the names of their papers and packages, so one
quantity is called differently in different filters, and stands in different units. `gyr_range` is
also a setting of every filter.

| quantity | name | unit | filters (default) |
| --- | --- | --- | --- |
"""


def holders(name: str) -> dict[str, Param]:
    """The filters that have a parameter of this name."""
    return {filter_name: cls.PARAMS[name] for filter_name, cls in FILTERS.items() if name in cls.PARAMS}


def rows() -> Iterable[str]:
    """The rows of the table; ``LookupError`` for a name that no filter has."""
    for quantity, names in QUANTITIES.items():
        for index, name in enumerate(names):
            found = holders(name)
            if not found:
                raise LookupError(f"no filter has a parameter {name!r}")
            units = ", ".join(dict.fromkeys(param.unit for param in found.values() if param.unit)) or "–"
            shown = ", ".join(f"`{each}` ({_shown(param)})" for each, param in found.items())
            yield f"| {'' if index else quantity} | `{name}` | {units} | {shown} |"


def _shown(param: Param) -> str:
    return f"{param.default:.4g}" if isinstance(param.default, float) else str(param.default)


def page() -> str:
    """The page."""
    return HEAD + "\n".join(rows()) + "\n"


def main() -> int:
    """Write the page, or check it."""
    text = page()
    if "--check" in sys.argv[1:]:
        current = PAGE.exists() and PAGE.read_text(encoding="utf-8") == text
        if not current:
            print(f"{PAGE.name} is not current: run `make names`", file=sys.stderr)
        return 0 if current else 1
    PAGE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
