"""What a report recommends, and what a check costs."""

from __future__ import annotations

import dataclasses
import tracemalloc
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs._check import _chips
from ahrs_rs._check._expected import EXPECTED
from check_faults import added, good, times, turned, with_rows


def advice(recording: ar.Recording, online: bool = False, **keywords: Any) -> Any:
    return ar.check(recording, **keywords).recommend(online=online)


def test_a_good_recording_is_for_a_filter_that_knows_the_future_or_not() -> None:
    assert advice(good()).name == "OfflineVQF"
    online = advice(good(), online=True)
    assert online.name == "VQF"
    assert not online.six_axes
    assert online.expected == EXPECTED[("VQF", "still field")]
    est = online.make().run(good())
    assert ar.metrics.score(est.quat, good().ref, mask=good().mask).total < 2.0
    assert "because" in str(online)


@pytest.mark.parametrize(
    ("left_out", "name"),
    [(("mag",), "OfflineVQF"), (("gyr",), "Ecompass"), (("gyr", "mag"), "Tilt"), (("acc", "mag"), "GyroIntegration")],
)
def test_what_is_missing_decides_which_filter(left_out: tuple[str, ...], name: str) -> None:
    found = advice(with_rows(good(), **dict.fromkeys(left_out)))
    assert found.name == name
    assert found.six_axes == ("mag" in left_out)


def test_a_magnetometer_in_axes_that_are_in_doubt_is_left_out() -> None:
    found = advice(turned(good(), "mag", _chips.matrix_of("-x,y,-z")))
    assert found.six_axes
    assert any("in doubt" in one for one in found.reasons)


def test_sensors_that_need_a_calibration_are_for_a_filter_that_does_it() -> None:
    assert advice(added(good(), "mag", [20.0, 0.0, 0.0])).name == "SelfCalSmoother"
    assert advice(times(good(), "gyr", 1.08), online=True).name == "SelfCalKF"


def test_the_declination_of_the_place_goes_into_the_filter() -> None:
    pytest.importorskip("pygeomag")
    place = (60.0, -140.0, 100.0)
    found = advice(good(), place=place, date=2025.0)
    assert found.keywords["declination"] == pytest.approx(ar.earth.declination(*place, 2025.0))


def test_a_check_needs_less_memory_than_the_recording() -> None:
    source = ar.simulate.demo(duration=60.0, rate=1000.0)
    count = 5
    long = ar.Recording(
        t=np.arange(count * len(source)) / 1000.0,
        **{name: np.tile(getattr(source, name), (count, 1)) for name in ("gyr", "acc", "mag")},
    )
    size = sum(getattr(long, name).nbytes for name in ("t", "gyr", "acc", "mag"))
    ar.check(good())  # what is imported once
    tracemalloc.start()
    ar.check(long)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # The blocks that are worked on take some 20 MB; what grows with the recording is a part of it.
    assert peak < 0.5 * size + 40e6


def test_a_gap_does_not_make_the_reference_that_of_another_body() -> None:
    t = np.array(good().t)
    t[len(t) // 2 :] += 3.0
    assert not ar.check(with_rows(good(), t=t)).of("error")


def test_the_unit_of_an_accelerometer_that_is_whirled_is_told_by_its_rests() -> None:
    acc = np.array(good().acc)
    moving = np.linalg.norm(good().gyr, axis=1) > 0.3
    acc[moving] *= 1.6
    report = ar.check(dataclasses.replace(good(), acc=acc / 9.80665))
    assert report["acc.unit"].evidence["unit"] == "g"
