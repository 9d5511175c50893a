"""Faults of gyroscope, accelerometer, magnetometer and reference that `ahrs_rs.check` finds, each planted alone."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import _quat
from check_faults import DEGREE, added, good, grave, times, with_rows
from commands import needs_data


def changed_rows(sensor: str, change: Callable[[np.ndarray], Any], source: ar.Recording | None = None) -> ar.Recording:
    recording = good() if source is None else source
    rows = np.array(getattr(recording, sensor))
    found = change(rows)
    return with_rows(recording, **{sensor: rows if found is None else found})


# -- values --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sensor", ["gyr", "acc", "mag"])
@pytest.mark.parametrize("part", [0.5, 0.7, 0.9])
def test_clipping_is_found_with_its_level(sensor: str, part: float) -> None:
    level = part * float(np.abs(getattr(good(), sensor)).max())
    report = ar.check(changed_rows(sensor, lambda x: np.clip(x, -level, level)))
    assert report[f"{sensor}.clipped"].severity == "warning"
    assert report[f"{sensor}.clipped"].value == pytest.approx(level)
    assert report.fixed() is report.recording


def test_a_count_as_coarse_as_the_noise_at_rest_is_no_clipping() -> None:
    rested_rows = good()[:300]
    quantised = rested_rows.changed(lambda name, x: np.round(x * 500.0) / 500.0 if name == "gyr" else x)
    assert "gyr.clipped" not in ar.check(quantised)


def test_wrapped_readings_are_found() -> None:
    reach = 0.6 * float(np.abs(good().gyr).max())
    report = ar.check(changed_rows("gyr", lambda x: (x + reach) % (2.0 * reach) - reach))
    assert report["gyr.wrapped"].severity == "error"
    assert "gyr.wrapped" not in ar.check(good())


def test_a_dead_axis_is_found() -> None:
    def dead(x: np.ndarray) -> None:
        x[:, 1] = 0.02

    for sensor in ("gyr", "acc", "mag"):
        assert ar.check(changed_rows(sensor, dead))[f"{sensor}.dead"].severity == "error"


def test_an_axis_that_sticks_for_a_while_is_found() -> None:
    def stuck(x: np.ndarray) -> None:
        x[1000:1400, 2] = x[1000, 2]

    finding = ar.check(changed_rows("gyr", stuck))["gyr.stuck"]
    assert finding.value == pytest.approx(4.0, abs=0.05)
    assert finding.evidence["axis"] == "z"


def test_coarse_counts_are_told_with_their_size() -> None:
    step = 2.0 * DEGREE
    report = ar.check(changed_rows("gyr", lambda x: np.round(x / step) * step))
    assert report["gyr.counts"].value == pytest.approx(step, rel=1e-6)
    assert report["gyr.counts"].severity == "note"


def test_vibration_near_the_nyquist_rate_is_told() -> None:
    shake = 3.0 * np.sin(2.0 * np.pi * 46.0 * good().t)[:, np.newaxis]
    assert ar.check(changed_rows("gyr", lambda x: x + shake))["gyr.aliasing"].severity == "warning"
    assert "gyr.aliasing" not in ar.check(good())


# -- gyroscope -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("size", "severity"), [(0.2, "note"), (4.0, "warning")])
def test_the_bias_at_rest_is_found_and_taken_off(size: float, severity: str) -> None:
    vector = size * DEGREE * np.array([0.6, -0.8, 0.0])
    clean = ar.check(good())["gyr.bias"]
    report = ar.check(added(good(), "gyr", vector))
    assert report["gyr.bias"].severity == severity
    assert report["gyr.bias"].evidence["bias"] - clean.evidence["bias"] == pytest.approx(vector, abs=0.05 * DEGREE)
    assert ar.check(report.fixed(notes=True))["gyr.bias"].severity == "ok"
    assert (report.fixed() is report.recording) == (severity == "note")


def test_a_bias_that_drifts_is_found() -> None:
    drift = np.linspace(0.0, 2.0 * DEGREE, len(good()))[:, np.newaxis] * np.array([1.0, 0.0, 0.0])
    assert ar.check(changed_rows("gyr", lambda x: x + drift))["gyr.drift"].severity == "warning"
    assert "gyr.drift" not in ar.check(good())


@pytest.mark.parametrize("scale", [0.9, 1.1])
def test_a_wrong_scale_of_the_gyroscope_is_found(scale: float) -> None:
    finding = ar.check(times(good(), "gyr", scale))["gyr.scale"]
    assert finding.severity == "warning"
    assert finding.value == pytest.approx(1.0 / scale, abs=0.01)
    assert ar.check(good())["gyr.scale"].severity == "ok"


# -- accelerometer and magnetometer --------------------------------------------------------------------------------


def test_a_wrong_scale_of_the_accelerometer_shows_at_rest() -> None:
    assert ar.check(times(good(), "acc", 1.1))["acc.norm"].severity == "warning"
    assert ar.check(good())["acc.norm"].severity == "ok"


@pytest.mark.parametrize("angle", [5.0, 12.0])
def test_a_misaligned_magnetometer_is_found_with_its_angle(angle: float) -> None:
    turn = _quat.about_axis(1, np.array(angle * DEGREE))
    report = ar.check(changed_rows("mag", lambda x: _quat.rotate(turn, x)))
    assert report["axes.mag_misaligned"].severity == ("note" if angle < 8.0 else "warning")
    assert report["axes.mag_misaligned"].value == pytest.approx(angle, abs=1.0)
    assert ar.check(good())["axes.mag_misaligned"].severity == "ok"


@pytest.mark.parametrize("size", [5.0, 20.0, 50.0])
def test_hard_iron_is_found(size: float) -> None:
    offset = size * np.array([0.6, 0.0, -0.8])
    report = ar.check(added(good(), "mag", offset))
    finding = report["mag.iron"]
    assert finding.severity in ("note", "warning")
    assert finding.evidence["offset"] == pytest.approx(offset, abs=1.5)
    if finding.change is not None:
        assert report.fixed(notes=True).mag == pytest.approx(good().mag, abs=2.0)
    assert ar.check(good())["mag.iron"].severity == "ok"


@pytest.mark.parametrize("delay", [0.02, 0.04])
def test_a_late_magnetometer_is_found_and_moved(delay: float) -> None:
    steps = round(delay * good().rate)

    def late(x: np.ndarray) -> np.ndarray:
        return np.vstack([x[:1]] * steps + [x[:-steps]])

    report = ar.check(changed_rows("mag", late))
    assert report["mag.delay"].value == pytest.approx(delay, abs=0.003)
    assert report["mag.delay"].severity == "note"
    assert ar.check(good())["mag.delay"].severity == "ok"
    moved = report.fixed(notes=True)
    assert abs(ar.check(moved)["mag.delay"].value or 0.0) < 0.003


def test_a_magnetometer_slower_than_the_rows_is_told_with_its_rate() -> None:
    def held(x: np.ndarray) -> np.ndarray:
        return x[np.arange(len(x)) // 5 * 5]

    report = ar.check(changed_rows("mag", held))
    assert report["mag.repeated"].value == pytest.approx(20.0, rel=0.01)
    fixed = report.fixed(notes=True)
    assert fixed.mag is not None
    assert np.count_nonzero(np.isnan(fixed.mag[:, 0])) == pytest.approx(0.8 * len(good()), rel=0.01)
    assert not grave(ar.check(fixed))


def test_a_field_that_is_disturbed_for_a_while_is_told() -> None:
    def disturbed(x: np.ndarray) -> None:
        x[2000:2600] += np.array([40.0, 10.0, 0.0])

    finding = ar.check(changed_rows("mag", disturbed))["mag.disturbed"]
    assert finding.value == pytest.approx(0.1, abs=0.04)


# -- reference -----------------------------------------------------------------------------------------------------


def test_a_right_reference_is_told_in_its_frames_and_clock() -> None:
    report = ar.check(good())
    assert report["ref.form"].severity == "ok"
    assert report["ref.earth_frame"].severity == "ok"
    assert report["ref.clock"].severity == "ok"
    assert "ref.sensor_frame" not in report


@pytest.mark.parametrize(
    ("name", "form"),
    [
        ("inverse", _quat.conjugate),
        ("scalar-last", lambda q: q[:, [1, 2, 3, 0]]),
        ("mirrored in y", lambda q: q * np.array([1.0, 1.0, -1.0, 1.0])),
    ],
)
def test_a_reference_of_another_form_is_named_and_put_right(name: str, form: Callable[[Any], Any]) -> None:
    report = ar.check(with_rows(good(), ref=form(good().ref)))
    assert report["ref.form"].severity == "error"
    assert report["ref.form"].evidence["form"] == name
    assert np.abs(np.sum(report.fixed().ref * good().ref, axis=1)) == pytest.approx(np.ones(len(good())))


def test_constant_rotations_of_a_reference_are_no_fault() -> None:
    first, last = (_quat.exp(np.array(one)) for one in ([0.3, -1.1, 0.7], [1.2, 0.2, -0.4]))
    report = ar.check(with_rows(good(), ref=_quat.multiply(first, _quat.multiply(good().ref, last))))
    assert not grave(report)
    assert report["ref.sensor_frame"].value == pytest.approx(np.linalg.norm([1.2, 0.2, -0.4]), abs=0.02)
    assert report["ref.earth_frame"].severity == "note"


@pytest.mark.parametrize("late", [0.05, -0.4])
def test_a_clock_that_is_off_is_found(late: float) -> None:
    steps = round(late * good().rate)
    report = ar.check(with_rows(good(), ref=np.roll(good().ref, steps, axis=0)))
    assert report["ref.clock"].value == pytest.approx(late, abs=0.01)
    assert report["ref.clock"].severity == ("note" if abs(late) < 0.1 else "warning")


def test_a_leap_of_the_reference_is_found() -> None:
    ref = np.array(good().ref)
    ref[3000:] = _quat.multiply(_quat.about_axis(2, np.array(1.2)), ref[3000:])
    finding = ar.check(with_rows(good(), ref=ref))["ref.leaps"]
    assert finding.value == pytest.approx(1.2, abs=0.1)
    assert "ref.leaps" not in ar.check(good())


def test_the_reference_of_another_body_is_an_error() -> None:
    other = ar.simulate.demo(duration=60.0, seed=5)
    rolled = np.roll(other.ref, 1234, axis=0)
    report = ar.check(with_rows(good(), ref=rolled))
    assert report.severity in ("error", "warning")
    assert any(one.code in ("ref.other", "ref.form") for one in report.findings if one.severity in ("warning", "error"))


# -- real recordings ------------------------------------------------------------------------------------------------


@needs_data
def test_real_recordings_have_no_error(recordings: list[Any]) -> None:
    told = 0
    for path in recordings:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ar.DataWarning)
            report = ar.check(ar.read(path))
        assert not report.of("error"), (path.name, [one.message for one in report.of("error")])
        told += len(report.of("warning"))
    assert told == 0
