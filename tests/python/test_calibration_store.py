"""Calibrations kept by device and date, found again, and made live."""

from __future__ import annotations

import dataclasses
import datetime
import io
import math
import os
import pty
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs.calibration import Calibration, Calibrations, LiveMagnetometer, devices, find, store, stored
from calibrated import FloatArray, directions, sensor
from commands import Capture, error_of, output_of, saved, simulated
from test_calibration_few import ACC_BIAS, ACC_GAIN, BIAS, GYR_GAIN, IRON, RATE, positions, turned


def offset(value: float) -> Calibration:
    return Calibration(np.eye(3), np.full(3, value))


def value(one: object) -> float:
    assert isinstance(one, Calibration)
    return float(one.offset[0])


def test_of_each_sensor_the_last_one_before_the_date_is_found(tmp_path: Path) -> None:
    store(Calibrations(mag=offset(1.0), gyr=offset(10.0)), "imu-7", "2026-01-10", folder=tmp_path)
    store(Calibrations(mag=offset(2.0)), "imu-7", datetime.date(2026, 2, 10), folder=tmp_path)
    moment = datetime.datetime(2026, 3, 10, 12, tzinfo=datetime.timezone(datetime.timedelta(hours=2)))
    store(Calibrations(mag=offset(3.0)), "imu-7", moment, folder=tmp_path)
    store(Calibrations(mag=offset(99.0)), "imu-8", "2026-02-15", folder=tmp_path)
    assert devices(folder=tmp_path) == ("imu-7", "imu-8")
    assert [when.isoformat() for when in stored("imu-7", folder=tmp_path)] == [
        "2026-01-10T00:00:00+00:00",
        "2026-02-10T00:00:00+00:00",
        "2026-03-10T10:00:00+00:00",
    ]
    found = find("imu-7", "2026-02-20", folder=tmp_path)
    assert (value(found.mag), value(found.gyr)) == (2.0, 10.0)
    assert value(find("imu-7", "2026-03-10", folder=tmp_path).mag) == 3.0  # a day is its end
    assert value(find("imu-7", "2026-03-10T09:59", folder=tmp_path).mag) == 2.0
    assert value(find("imu-7", folder=tmp_path).mag) == 3.0
    assert value(find("imu-7", "2026-02-20", which="after", folder=tmp_path).mag) == 3.0
    assert value(find("imu-7", "2025-12-31", which="closest", folder=tmp_path).mag) == 1.0
    with pytest.raises(ValueError, match="date: expected one after a calibration of imu-7, got 2025-12-31: 2026-01-10"):
        find("imu-7", "2025-12-31", folder=tmp_path)


def test_sensors_of_one_device_and_second_are_joined(tmp_path: Path) -> None:
    for cal in (Calibrations(mag=offset(1.0)), Calibrations(acc=offset(2.0)), Calibrations(mag=offset(3.0))):
        path = store(cal, "d", "2026-01-10", folder=tmp_path)
    assert path.read_text(encoding="utf-8").count('"offset"') == 2
    found = find("d", "2026-01-10", folder=tmp_path)
    assert (value(found.mag), value(found.acc)) == (3.0, 2.0)


def test_the_store_is_where_the_environment_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AHRS_RS_CALIBRATIONS", str(tmp_path / "here"))
    assert store(Calibrations(mag=offset(1.0)), "d").parent == tmp_path / "here" / "d"
    monkeypatch.delenv("AHRS_RS_CALIBRATIONS")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    if sys.platform.startswith("linux"):
        assert store(Calibrations(mag=offset(1.0)), "d").parent == tmp_path / "data" / "ahrs_rs" / "calibrations" / "d"
        assert devices() == ("d",)


@pytest.mark.parametrize("name", ["", "../x", "a/b", ".hidden", "a\\b", "end.", "x" * 101, "c:"])
def test_a_name_that_no_folder_can_have_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="device: expected a name of letters"):
        store(Calibrations(mag=offset(1.0)), name, folder=tmp_path / "store")
    assert not (tmp_path / "store").exists()


def test_what_is_not_there_and_what_is_no_date_are_told(tmp_path: Path) -> None:
    store(Calibrations(mag=offset(1.0)), "imu-7", "2026-01-10", folder=tmp_path)
    (tmp_path / "imu-7" / "notes.json").write_text("{}", encoding="utf-8")  # somebody else's
    assert len(stored("imu-7", folder=tmp_path)) == 1
    with pytest.raises(ValueError, match=r"got 'imu-6' \(did you mean imu-7\?\): imu-7"):
        find("imu-6", folder=tmp_path)
    with pytest.raises(ValueError, match="date: expected a date like 2026-03-01 or 2026-03-01T12:00, got 'tomorrow'"):
        find("imu-7", "tomorrow", folder=tmp_path)
    with pytest.raises(ValueError, match="expected at least one sensor"):
        store(Calibrations(), "imu-7", folder=tmp_path)


def test_the_command_keeps_a_calibration_and_a_run_finds_it_by_the_recordings_date(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AHRS_RS_CALIBRATIONS", str(tmp_path / "store"))
    x, _, _ = sensor(0, 9)
    zeros = np.zeros((len(x), 3))
    ar.Recording(t=np.arange(len(x)) / RATE, gyr=zeros, mag=x, rate=RATE).save(tmp_path / "turn.npz")
    shown = output_of(capsys, "calibrate", "mag", tmp_path / "turn.npz", "--device", "imu 7", "--date", "2026-02-01")
    assert f"stored     {tmp_path / 'store' / 'imu 7' / '2026-02-01T000000Z.json'}" in shown
    store(Calibrations(mag=offset(9.0)), "imu 7", "2026-08-01")
    saved(tmp_path / "early.npz", meta={"start": "2026-03-01T10:00:00+00:00"})
    saved(tmp_path / "late.npz", meta={"start": "2026-09-01T10:00:00+00:00"})
    saved(tmp_path / "before.npz", meta={"start": "2025-09-01T10:00:00+00:00"})
    rec = simulated()
    assert rec.mag is not None
    for name, cal in (("early", ar.calibration.magnetometer(x).calibration), ("late", offset(9.0))):
        out = tmp_path / f"{name}-out.npz"
        shown = output_of(
            capsys, "run", tmp_path / f"{name}.npz", "--filter", "madgwick", "--calibration", "@imu 7", "-o", out
        )
        assert "calibrated mag\n" in shown
        expected = ar.FILTERS["Madgwick"](rate=50.0).run(rec.gyr, rec.acc, cal.apply(rec.mag), t=rec.t)
        assert np.array_equal(np.load(out)["quat"], expected.quat)
    common = ("--filter", "madgwick", "--calibration")
    assert "got 'imu'" in error_of(capsys, "run", tmp_path / "early.npz", *common, "@imu")
    assert "expected one after a calibration" in error_of(capsys, "run", tmp_path / "before.npz", *common, "@imu 7")


def test_ferraris_from_one_recording_with_turns_among_other_motions(tmp_path: Path, capsys: Capture) -> None:
    acc, gyr = [], []
    for k, (a, g) in enumerate(positions(3)):
        acc.append(a)
        gyr.append(g)
        flip = 1e-3 * np.random.default_rng(k).standard_normal((100, 3))
        flip[:, (k + 1) % 3] += math.radians(90.0)  # to the next side, by a quarter turn in a second
        acc.append(np.full((100, 3), 3.0 + k) * np.random.default_rng(k).uniform(0.5, 1.5, (100, 3)))
        gyr.append(flip)
    a, g = positions(4)[4]
    for k, axis in enumerate("xyz"):
        turn = turned(axis, 2 * math.pi, k, gain=GYR_GAIN)
        acc += [a, np.tile(a.mean(axis=0), (401, 1))]
        gyr += [g, np.asarray(turn.gyr)]
    acc.append(a)
    gyr.append(g)
    every_acc, every_gyr = np.concatenate(acc), np.concatenate(gyr)
    t = np.arange(len(every_acc)) / RATE
    ar.Recording(t=t, gyr=every_gyr, acc=every_acc, rate=RATE).save(tmp_path / "all.npz")
    told = ("--turns", "x=360,y=360,z=360", "-o", tmp_path / "cal.json")
    shown = output_of(capsys, "calibrate", "ferraris", tmp_path / "all.npz", *told)
    assert "10 positions, 3 turns" in shown
    found = ar.calibration.load(tmp_path / "cal.json")
    assert isinstance(found.acc, Calibration)
    assert isinstance(found.gyr, Calibration)
    assert np.allclose(np.linalg.inv(found.acc.matrix), ACC_GAIN, rtol=0, atol=1e-3)
    assert np.allclose(found.acc.offset, ACC_BIAS, rtol=0, atol=5e-3)
    # The g-sensitivity of 1 mrad/s per m/s² counts for a turn of 4 s: 0.04 rad of 2π in its own column.
    assert np.allclose(np.linalg.inv(found.gyr.matrix), GYR_GAIN, rtol=0, atol=0.01)
    assert np.allclose(found.gyr.offset, BIAS, rtol=0, atol=5e-4)
    said = error_of(capsys, "calibrate", "ferraris", tmp_path / "all.npz", "--turns", "x=360,y=360,z=-360")
    assert said == "--turns: z=-360 is not in the recordings; found before it: 2 turns"


def turning(count: int = 900) -> FloatArray:
    return 48.0 * directions(np.random.default_rng(1), count) + IRON


def lines(x: FloatArray) -> str:
    return "".join(f"{a:.5f}, {b:.5f},{c:.5f}\n" for a, b, c in x)


def test_readings_as_they_come_give_the_fit_of_all_of_them() -> None:
    x, live = turning(), LiveMagnetometer()
    assert (len(live), live.coverage) == (0, 0.0)
    seen = []
    for part in np.array_split(x, 30):
        live.add(part)
        seen.append(live.coverage)
    live.add([np.nan, 1.0, 2.0])
    assert len(live) == 900
    assert seen[0] < seen[-1] == 1.0
    assert live.fit().calibration == ar.calibration.magnetometer(x).calibration
    assert np.allclose(live.centre, IRON, rtol=0, atol=1e-9)


def test_the_map_has_a_cell_where_a_reading_was_and_none_elsewhere() -> None:
    x = turning(3000)
    upper = x[(x - IRON)[:, 2] > 1.0]
    live = LiveMagnetometer(parameters=4)
    live.add(upper)
    assert np.allclose(live.centre, IRON, rtol=0, atol=1e-6)  # a hemisphere has the whole sphere's centre
    rows = live.map().splitlines()
    assert len(rows) == 6
    assert rows[0].startswith("+z ")
    assert set("".join(rows[:3])) <= set("+z #@o")
    assert "".join(row[3:] for row in rows[3:]).replace(" ", "") == "." * 36
    assert live.map().count("@") == 1
    assert live.coverage == 0.5


def test_lines_of_the_standard_input_are_calibrated_live(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    x = turning()
    text = "x,y,z\n" + lines(x[:500]) + "garbage\n\n" + lines(x[500:]).replace(",", "\t")
    monkeypatch.setattr("sys.stdin", io.StringIO(text))
    shown = output_of(capsys, "calibrate", "mag", "--live", "-o", tmp_path / "cal.json")
    assert "900 readings of the standard input" in shown
    assert "2 lines without three numbers were passed over" in shown
    assert "\n+z # # #" in shown
    found = Calibration.load(tmp_path / "cal.json")
    assert found == ar.calibration.magnetometer(np.round(x, 5)).calibration
    monkeypatch.setattr("sys.stdin", io.StringIO("".join(f"17;{a};{b};{c};9\n" for a, b, c in x.tolist())))
    shown = output_of(capsys, "calibrate", "mag", "--live", "--columns", "mag=2,3,4", "--parameters", "4")
    assert "b_x        10 ±" in shown


@pytest.mark.parametrize(
    ("arguments", "text", "message"),
    [
        ((), "", "--live: expected lines of three numbers on the standard input, got 0 without"),
        ((), "a\nb,c\n1,2\nnan,1,2\n", "got 4 without"),
        ((), "1,2,3\n" * 50, "mag: all readings are the same"),
        (("a.npz",), "", "--live: expected no FILE beside it, got a.npz"),
        (("--columns", "gyr=1,2,3"), "", "--columns: expected mag=8,9,10 with --live, counted from 1, got 'gyr=1,2,3'"),
        (("--columns", "mag=0,1,2"), "", "--columns: expected mag=8,9,10"),
        (("--coverage", "2"), "", "--coverage: expected a share of at most 1"),
        (("--plot", "a.png"), "", "--plot: there is none of a live calibration"),
    ],
)
def test_what_is_no_live_calibration_is_told(
    arguments: tuple[str, ...], text: str, message: str, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(text))
    assert message in error_of(capsys, "calibrate", "mag", "--live", *arguments)


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals and SIGINT are those of POSIX")
def test_a_terminal_shows_the_coverage_and_ctrl_c_ends_with_the_calibration(tmp_path: Path) -> None:
    seen, its = pty.openpty()
    cal = tmp_path / "cal.json"
    command = [sys.executable, "-m", "ahrs_rs", "calibrate", "mag", "--live", "-o", str(cal)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=its, text=True) as process:
        os.close(its)
        assert process.stdin is not None
        drawn, x = b"", turning()
        process.stdin.write(lines(x))
        end = time.monotonic() + 30.0
        while b"100% of the directions" not in drawn and time.monotonic() < end:
            process.stdin.write(lines(x[:1]))  # what is drawn is drawn where a reading comes
            process.stdin.flush()
            if select.select([seen], [], [], 0.05)[0]:
                drawn += os.read(seen, 65536)
        assert b"100% of the directions" in drawn
        process.send_signal(signal.SIGINT)
        out = process.communicate(timeout=30.0)[0]
    os.close(seen)
    assert process.returncode == 0
    assert "readings of the standard input" in out
    assert np.allclose(Calibration.load(cal).offset, IRON, rtol=0, atol=1e-3)


def test_a_recording_without_a_date_has_the_newest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AHRS_RS_CALIBRATIONS", str(tmp_path))
    store(Calibrations(mag=offset(1.0)), "d", "2026-01-10")
    store(Calibrations(mag=offset(2.0)), "d", "2026-01-11")
    rec = dataclasses.replace(simulated(), meta={})
    applied = find("d", rec.meta.get("start")).apply(rec)
    assert rec.mag is not None
    assert applied.mag is not None
    assert np.array_equal(applied.mag, rec.mag - 2.0, equal_nan=True)
