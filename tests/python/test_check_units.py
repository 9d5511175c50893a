"""Units and times that `ahrs_rs.check` tells, and the model of its findings."""

from __future__ import annotations

import json

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs._check._findings import SEVERITIES
from check_faults import good, grave, times, with_rows


@pytest.mark.parametrize(("unit", "size"), [("g", 9.80665), ("mg", 9.80665e-3)])
def test_the_unit_of_the_accelerometer_is_told_by_gravity(unit: str, size: float) -> None:
    report = ar.check(times(good(), "acc", 1.0 / size))
    assert report["acc.unit"].severity == "error"
    assert report["acc.unit"].evidence["unit"] == unit
    assert np.allclose(report.fixed().acc, good().acc)


def test_counts_of_a_16_bit_accelerometer_are_told() -> None:
    counts = good().changed(lambda name, x: np.round(x * 4096.0 / 9.80665) if name == "acc" else x)
    report = ar.check(counts)
    assert report["acc.unit"].severity == "error"
    assert np.allclose(report.fixed().acc, good().acc, atol=2e-3)


@pytest.mark.parametrize(("unit", "size"), [("T", 1e6), ("mT", 1e3), ("gauss", 100.0), ("nT", 1e-3)])
def test_the_unit_of_the_magnetometer_is_told_by_the_field(unit: str, size: float) -> None:
    report = ar.check(times(good(), "mag", 1.0 / size))
    assert report["mag.unit"].evidence["unit"] == unit
    assert np.allclose(report.fixed().mag, good().mag)


def test_a_normalised_field_is_no_fault() -> None:
    norm = float(np.median(np.linalg.norm(good().mag, axis=1)))
    report = ar.check(times(good(), "mag", 1.0 / norm))
    assert report["mag.unit"].severity == "note"
    assert report["mag.unit"].change is None


def test_gravity_that_was_taken_off_is_an_error() -> None:
    source = good()
    assert source.ref is not None
    w, x, y, z = source.ref.T
    up = np.column_stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])
    report = ar.check(with_rows(source, acc=source.acc - 9.80665 * up))
    assert report["acc.gravity_removed"].severity == "error"
    assert "acc.unit" not in grave(report)


@pytest.mark.parametrize(("unit", "size"), [("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)])
def test_the_unit_of_time_is_told_by_the_rate(unit: str, size: float) -> None:
    report = ar.check(with_rows(good(), t=good().t / size))
    assert report["time.unit"].evidence["unit"] == unit
    assert report["axes.gyr_mag"].severity == "ok"  # the checks after it go on with the right unit
    assert report.fixed().t - report.fixed().t[0] == pytest.approx(good().t, abs=1e-6)


def test_packets_are_found_and_spread() -> None:
    t = np.floor(np.arange(len(good())) / 10) / 10.0
    report = ar.check(with_rows(good(), t=t))
    assert report["time.bursts"].severity == "warning"
    steps = np.diff(report.fixed().t)
    assert steps == pytest.approx(np.full(len(steps), 0.01), rel=0.01)


def test_gaps_are_counted_and_the_longest_is_named() -> None:
    keep = np.ones(len(good()), dtype=bool)
    keep[1000:1100] = keep[3000:3005] = False
    rows = {name: getattr(good(), name)[keep] for name in ("t", "gyr", "acc", "mag", "ref")}
    report = ar.check(with_rows(good(), mask=None, temperature=None, **rows))
    finding = report["time.gaps"]
    assert finding.severity == "warning"
    assert finding.evidence["count"] == 2
    assert finding.value == pytest.approx(1.01)


def test_a_stated_rate_that_the_stamps_contradict_is_told() -> None:
    assert ar.check(with_rows(good(), rate=200.0))["time.stated"].severity == "warning"
    assert "time.stated" not in ar.check(with_rows(good(), rate=100.5))


def test_rows_that_repeat_the_row_before_are_told() -> None:
    gyr, acc = np.array(good().gyr), np.array(good().acc)
    gyr[100:5900:20], acc[100:5900:20] = gyr[99:5899:20], acc[99:5899:20]
    assert ar.check(with_rows(good(), gyr=gyr, acc=acc))["time.repeated_rows"].severity == "warning"


def test_a_report_is_a_table_and_json() -> None:
    report = ar.check(times(good(), "acc", 1.0 / 9.80665))
    order = [SEVERITIES.index(one.severity) for one in report.findings]
    assert order == sorted(order, reverse=True)
    read = json.loads(report.to_json())
    assert read["severity"] == "error"
    assert read["counts"] == {one: len(report.of(one)) for one in SEVERITIES}
    assert [one["code"] for one in read["findings"]] == [one.code for one in report.findings]
    table = str(report)
    assert table.startswith("error    acc.unit")
    assert "do: units={'acc': 'g'}" in table
    assert "time.rate" not in report.table(everything=False)
    with pytest.raises(KeyError):
        report["acc.nothing"]
    with pytest.raises(ValueError, match="severity: expected one of"):
        report.of("fatal")


def test_every_grave_finding_says_what_it_means_and_what_to_do() -> None:
    wrong = times(times(with_rows(good(), t=good().t * 1e3), "mag", 1e-2), "gyr", [1.0, -1.0, 1.0])
    for one in ar.check(wrong).findings:
        assert one.subject in ("time", "gyr", "acc", "mag", "axes", "ref", "file")
        assert 0.0 <= one.confidence <= 1.0
        if one.severity in ("warning", "error"):
            assert one.meaning
            assert one.remedy


@pytest.mark.parametrize("sensors", [("gyr",), ("acc",), ("mag",), ("gyr", "acc"), ("acc", "mag")])
def test_what_is_missing_is_no_fault(sensors: tuple[str, ...]) -> None:
    none = {name: None for name in ("gyr", "acc", "mag", "ref", "temperature") if name not in sensors}
    assert not grave(ar.check(with_rows(good(), **none)))


@pytest.mark.parametrize("value", [0.0, 1e-300, 1e300, np.inf, np.nan])
def test_readings_that_are_none_are_told_without_a_crash(value: float) -> None:
    rows = {name: np.full((len(good()), 3), value) for name in ("gyr", "acc", "mag")}
    report = ar.check(with_rows(good(), **rows), place=(50.0, 10.0, 0.0), up="z")
    json.loads(report.to_json())
    assert str(report)
    assert str(report.recommend())
    assert not any(one.code == "mag.sign" for one in report.of("error"))


@pytest.mark.parametrize("count", [1, 2, 7, 30])
def test_a_short_recording_is_no_fault(count: int) -> None:
    assert not grave(ar.check(good()[:count]))
