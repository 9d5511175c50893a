"""RMSE in degrees on BROAD's recordings, median and worst: made by tools/check_expected.py, not by hand."""

from __future__ import annotations

#: (filter, what): (median, worst, recordings). Totals; of "6D" the inclination.
EXPECTED: dict[tuple[str, str], tuple[float, float, int]] = {
    ("OfflineVQF", "6D"): (0.40, 0.99, 12),
    ("OfflineVQF", "disturbed"): (1.71, 6.41, 5),
    ("OfflineVQF", "still field"): (0.68, 2.09, 7),
    ("SelfCalKF", "6D"): (0.46, 1.05, 12),
    ("SelfCalKF", "disturbed"): (1.41, 6.57, 5),
    ("SelfCalKF", "still field"): (0.61, 1.35, 7),
    ("SelfCalSmoother", "6D"): (0.41, 0.97, 12),
    ("SelfCalSmoother", "disturbed"): (1.14, 5.55, 5),
    ("SelfCalSmoother", "still field"): (0.53, 1.38, 7),
    ("VQF", "6D"): (0.55, 1.25, 12),
    ("VQF", "disturbed"): (2.57, 7.67, 5),
    ("VQF", "still field"): (0.99, 1.80, 7),
}
