"""Calibration of the magnetometers of real recordings; docs/calibration.md has all of them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs.calibration import CalibrationError, magnetometer


@pytest.fixture(scope="module")
def by_name(broad: list[ar.Recording]) -> dict[str, ar.Recording]:
    return {str(one.meta["path"]).rsplit("/", 1)[-1][:2]: one for one in broad}


def heading(recording: ar.Recording) -> float:
    f = ar.FILTERS["VQF"](rate=recording.rate)
    est = f.run(recording.gyr, recording.acc, recording.mag, t=recording.t)
    return float(ar.metrics.score(est.quat, recording.ref, recording.mask).heading)


@pytest.mark.parametrize("name", ["02", "05", "24", "30"])
def test_the_norm_varies_less_after_calibration(name: str, by_name: dict[str, ar.Recording]) -> None:
    for parameters in (6, 9):
        fit = magnetometer(by_name[name].mag, parameters=parameters)
        assert fit.deviation_after < fit.deviation_before
        assert 40.0 < fit.norm < 50.0
        # What varies is the room's field, at the pace of the motion: readings are far from independent.
        assert fit.correlation > 20


@pytest.mark.parametrize("name", ["10", "14", "16", "18", "27", "32", "35"])
def test_recordings_without_rotation_and_with_moved_magnets_are_refused(
    name: str, by_name: dict[str, ar.Recording]
) -> None:
    for parameters in (6, 9):
        with pytest.raises(CalibrationError, match=r"^mag: the (readings|parameters)"):
            magnetometer(by_name[name].mag, parameters=parameters)


def test_hard_iron_is_taken_off_again(by_name: dict[str, ar.Recording]) -> None:
    rec = by_name["05"]
    assert rec.mag is not None
    iron = np.array([10.0, 10.0, 10.0])
    shifted = dataclasses.replace(rec, mag=rec.mag + iron)
    own, found = magnetometer(rec.mag), magnetometer(shifted.mag)
    # The fit of the same readings, moved.
    assert np.allclose(found.calibration.offset - iron, own.calibration.offset, rtol=0, atol=1e-6)
    mended = dataclasses.replace(shifted, mag=found.calibration.apply(shifted.mag))
    raw, bad, good = heading(rec), heading(shifted), heading(mended)
    print(f"VQF's heading: {raw:.2f}°, with iron {bad:.2f}°, calibrated {good:.2f}°")
    assert bad > 10.0
    assert good < raw + 0.5
