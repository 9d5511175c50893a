"""Axes, signs and units that `ahrs_rs.check` tells from what turns with what."""

from __future__ import annotations

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs._check import _chips, _ties
from check_faults import DEGREE, added, good, grave, times, turned, vqf_error, with_rows

SIGNED = [sign * one for sign in (1.0, -1.0) for one in _ties.ROTATIONS]
#: Some of all 48, half of them mirrored.
SOME = SIGNED[1::5]


def test_the_rotations_are_all_24_and_the_identity_is_the_first() -> None:
    assert len({one.tobytes() for one in _ties.ROTATIONS + 0.0}) == 24
    assert np.linalg.det(_ties.ROTATIONS) == pytest.approx(np.ones(24))
    assert np.array_equal(_ties.ROTATIONS[0], np.eye(3))


def test_a_right_recording_has_no_warning_and_its_axes_are_tied() -> None:
    report = ar.check(good())
    assert not grave(report)
    assert report["axes.gyr_acc"].severity == "ok"
    assert report["axes.gyr_mag"].severity == "ok"
    assert report["gyr.unit"].severity == "ok"
    assert report.fixed() is report.recording


@pytest.mark.parametrize("matrix", SOME, ids=_chips.axes_of)
def test_a_gyroscope_in_other_axes_is_found_and_put_right(matrix: np.ndarray) -> None:
    report = ar.check(turned(good(), "gyr", matrix))
    finding = report["axes.gyr"]
    assert finding.severity == "error"
    assert np.array_equal(_chips.matrix_of(finding.evidence["axes"].replace(" ", "")), np.linalg.inv(matrix))
    fixed = report.fixed()
    assert np.array_equal(fixed.gyr, good().gyr)
    assert fixed.meta["fixed"] == [f"gyr: axes {finding.evidence['axes']}"]


@pytest.mark.parametrize("sensor", ["acc", "mag"])
@pytest.mark.parametrize("matrix", SOME, ids=_chips.axes_of)
def test_a_vector_in_other_axes_is_found_up_to_its_sign(sensor: str, matrix: np.ndarray) -> None:
    report = ar.check(turned(good(), sensor, matrix))
    finding = report[f"axes.{sensor}"]
    assert finding.severity == "error"
    named = _chips.matrix_of(finding.evidence["axes"].replace(" ", ""))
    inverse = np.linalg.inv(matrix)
    assert np.array_equal(named, inverse) or np.array_equal(named, -inverse)
    if not finding.evidence["sign_known"]:
        assert finding.change is None
        assert np.array_equal(getattr(report.fixed(), sensor), getattr(report.recording, sensor))


def test_the_magnetometer_of_an_mpu_9250_is_named_and_put_right() -> None:
    report = ar.check(turned(good(), "mag", _chips.matrix_of("y,x,-z")))
    assert "AK8963" in report["axes.mag"].message
    assert np.allclose(report.fixed().mag, good().mag)


def test_of_an_accelerometer_in_other_axes_the_axis_that_was_up_tells_the_sign() -> None:
    mirrored = turned(good(), "acc", np.diag([1.0, 1.0, -1.0]))
    assert np.array_equal(ar.check(mirrored).fixed().acc, mirrored.acc)
    report = ar.check(mirrored, up="y")
    assert np.allclose(report.fixed().acc, good().acc)


def test_a_negated_accelerometer_shows_only_where_up_is_known() -> None:
    negated = times(good(), "acc", -1.0)
    assert not grave(ar.check(negated))
    report = ar.check(negated, up="y")
    assert report["acc.sign"].severity == "error"
    assert np.array_equal(report.fixed().acc, good().acc)
    assert ar.check(good(), up="y")["acc.sign"].severity == "ok"
    assert ar.check(good(), up="x")["acc.sign"].severity == "warning"


def test_a_negated_magnetometer_shows_only_where_the_place_is_known() -> None:
    negated = times(good(), "mag", -1.0)
    place = (52.5, 13.4, 40.0)
    assert not grave(ar.check(negated))
    assert ar.check(negated, place=place)["mag.sign"].severity == "error"
    assert ar.check(negated, place=place)["mag.sign"].change is None  # or it is the accelerometer
    assert np.array_equal(ar.check(negated, place=place, up="y").fixed().mag, good().mag)
    assert ar.check(good(), place=place)["mag.sign"].severity == "ok"


@pytest.mark.parametrize("factor", [180.0 / np.pi, np.pi / 180.0])
def test_the_unit_of_the_gyroscope_is_told_by_how_far_the_others_turn(factor: float) -> None:
    slow = times(good(), "gyr", factor)
    report = ar.check(slow)
    assert report["gyr.unit"].severity == "error"
    assert np.allclose(report.fixed().gyr, good().gyr)


def test_a_gyroscope_in_degrees_and_other_axes_is_put_right_in_both() -> None:
    matrix = _chips.matrix_of("y,x,z")
    report = ar.check(times(turned(good(), "gyr", matrix), "gyr", 180.0 / np.pi))
    assert {"gyr.unit", "axes.gyr"} <= grave(report)
    assert np.allclose(report.fixed().gyr, good().gyr)


def test_hard_iron_as_large_as_the_field_does_not_hide_the_axes() -> None:
    report = ar.check(added(good(), "mag", [30.0, -40.0, 10.0]))
    assert report["axes.gyr_mag"].severity == "ok"
    assert not any(one.code.startswith("axes") for one in report.of("error"))


def test_what_turns_about_one_axis_alone_tells_no_axes() -> None:
    t = np.arange(6000) / 100.0
    angle = np.sin(0.7 * t)
    gyr = np.zeros((6000, 3))
    gyr[1:, 2] = np.diff(angle) * 100.0
    acc = np.tile([0.0, 0.0, 9.81], (6000, 1))
    mag = np.column_stack([20.0 * np.cos(angle), -20.0 * np.sin(angle), np.full(6000, -40.0)])
    right = ar.Recording(t=t, gyr=gyr, acc=acc, mag=mag)
    for matrix in ("y,x,z", "-x,-y,z", "x,y,z"):
        report = ar.check(turned(right, "gyr", _chips.matrix_of(matrix)))
        assert not any(one.code.startswith("axes") for one in report.of("error"))
    assert report["axes.gyr_acc"].message.startswith("cannot tell")


def test_two_sensors_that_do_not_fit_are_an_error_that_nothing_is_changed_for() -> None:
    alone = with_rows(good(), acc=None)
    report = ar.check(turned(alone, "mag", _chips.matrix_of("z,x,y")))
    assert report["axes.gyr_mag"].severity == "error"
    assert report["axes.gyr_mag"].change is None


@pytest.mark.parametrize(
    ("plant", "keywords"),
    [
        (lambda r: times(r, "acc", -1.0), {"up": "y"}),
        (lambda r: turned(r, "mag", _chips.matrix_of("y,x,-z")), {}),
        (lambda r: times(r, "gyr", [1.0, 1.0, -1.0]), {}),
        (lambda r: times(r, "acc", 1.0 / 9.80665), {}),
        (lambda r: times(r, "gyr", 1.0 / DEGREE), {}),
        (lambda r: with_rows(r, t=1e3 * r.t), {}),
    ],
    ids=["acc negated", "AK8963", "gyr z negated", "g", "deg/s", "ms"],
)
def test_vqf_is_as_good_on_the_fixed_recording_as_on_the_right_one(plant, keywords) -> None:  # type: ignore[no-untyped-def]
    wrong = plant(good())
    report = ar.check(wrong, **keywords)
    assert report.severity == "error"
    assert vqf_error(report.fixed(), good()) == pytest.approx(vqf_error(good(), good()), rel=0.01)


def test_an_axis_or_a_place_that_is_none_is_an_error() -> None:
    with pytest.raises(ValueError, match="up: expected one of x, y, z"):
        ar.check(good(), up="north")
    with pytest.raises(ValueError, match="latitude within"):
        ar.check(good(), place=(152.5, 13.4, 40.0))
