"""Nothing in silence: what was assumed, repaired, ignored, lost or doubted is told, and what cannot be is refused."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import _plausible
from commands import Capture, error_of, output_of
from reading import told

G, DEGREE = 9.80665, np.pi / 180.0
N, RATE = 600, 100.0


def motion(speed: float = 3.0) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """t, rad/s, m/s², µT of a sensor that swings about a level axis, as its readings have to agree."""
    t = np.arange(N) / RATE
    angle = 0.6 * np.sin(speed * t)
    gyr = np.column_stack([0.6 * speed * np.cos(speed * t), np.zeros(N), np.zeros(N)])
    acc = G * np.column_stack([np.zeros(N), np.sin(angle), np.cos(angle)])
    mag = 50.0 * np.column_stack([np.full(N, 0.6), 0.8 * -np.sin(angle), 0.8 * -np.cos(angle)])
    return t, gyr, acc, mag


def write(path: Path, header: str, columns: list[np.ndarray], digits: int = 9) -> Path:
    rows = np.column_stack(columns)
    np.savetxt(path, rows, fmt=f"%.{digits}f", delimiter=",", header=header, comments="")
    return path


def plain(path: Path, *, time: float = 1.0, rate: float = 1.0, force: float = 1.0, field: float = 1.0) -> Path:
    """A table without a word on units, with factors."""
    t, gyr, acc, mag = motion()
    return write(path, "t,gx,gy,gz,ax,ay,az,mx,my,mz", [t * time, gyr * rate, acc * force, mag * field])


def test_units_that_are_assumed_are_told_in_one_warning_and_in_meta(tmp_path: Path) -> None:
    rec, said = told(plain(tmp_path / "a.csv"))
    assert said == ["no unit is stated, taken as t in s, gyr in rad/s, acc in m/s², mag in µT"]
    assert rec.meta["assumed_units"] == {"t": "s", "gyr": "rad/s", "acc": "m/s²", "mag": "µT"}


def test_a_file_that_says_all_is_read_without_a_word(tmp_path: Path) -> None:
    t, gyr, acc, _ = motion()
    header = "t (s),gx (rad/s),gy (rad/s),gz (rad/s),ax (m/s2),ay (m/s2),az (m/s2)"
    rec, said = told(write(tmp_path / "a.csv", header, [t, gyr, acc]))
    assert not said
    np.testing.assert_allclose(rec.acc, acc, atol=1e-9)


@pytest.mark.parametrize(
    ("factors", "words", "option"),
    [
        ({"force": 1.0 / G}, "acc: a median norm of 1 m/s²", {"acc": "g"}),
        ({"force": 1e3 / G}, "acc: a median norm of 1000 m/s²", {"acc": "mg"}),
        ({"rate": 100.0 / DEGREE}, "gyr:", None),
        ({"time": 1e3}, "t: a rate of 0.1 Hz", {"t": "ms"}),
        ({"time": 1e6}, "t: a rate of 0.0001 Hz", {"t": "us"}),
        ({"time": 1e9}, "t: a rate of 1e-07 Hz", {"t": "ns"}),
    ],
)
def test_what_no_inertial_sensor_gives_is_refused_with_the_option_that_settles_it(
    tmp_path: Path, factors: dict[str, float], words: str, option: dict[str, str] | None
) -> None:
    path = plain(tmp_path / "a.csv", **factors)
    with pytest.raises(ValueError, match=r"units=\{") as caught:
        ar.read(path)
    message = str(caught.value)
    assert words in message
    assert "\n" not in message
    if option is not None:
        ((quantity, unit),) = option.items()
        assert f"units={{{quantity!r}: {unit!r}}} (--units {quantity}={unit})" in message
        t, gyr, acc, _ = motion()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ar.DataWarning)
            rec = ar.read(path, units=option)
        np.testing.assert_allclose(rec.t, t, atol=1e-9)
        np.testing.assert_allclose(rec.acc, acc, atol=1e-6)
        np.testing.assert_allclose(rec.gyr, gyr, atol=1e-6)


def test_a_quantity_whose_unit_was_said_is_not_judged(tmp_path: Path) -> None:
    """A centrifuge, and a sensor that is read once a minute."""
    path = plain(tmp_path / "a.csv", force=100.0, time=6000.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.DataWarning)
        rec = ar.read(path, units={"acc": "m/s2", "t": "s"})
    assert rec.rate == pytest.approx(1.0 / 60.0)
    assert np.median(np.linalg.norm(rec.acc, axis=1)) == pytest.approx(100.0 * G)


def test_degrees_a_second_below_the_limit_are_doubted_as_gravity_turns_more_slowly(tmp_path: Path) -> None:
    t, gyr, acc, _ = motion(speed=1.5)  # at most 52 deg/s, which as rad/s would be possible
    header = "t,gx,gy,gz,ax,ay,az"
    _, said = told(write(tmp_path / "a.csv", header, [t, gyr / DEGREE, acc]))
    assert any("looks like deg/s" in sentence and "--units gyr=deg/s" in sentence for sentence in said[0].split("; "))
    assert not any("deg/s" in one for one in told(write(tmp_path / "b.csv", header, [t, gyr, acc]))[1])


def test_a_normalised_field_is_taken_as_one_and_told(tmp_path: Path) -> None:
    rec, said = told(plain(tmp_path / "a.csv", field=1.0 / 50.0))
    assert "normalised" in said[0]
    assert rec.meta["units"]["mag"] == "normalised"


def test_a_sensor_that_was_never_read_is_absent(tmp_path: Path) -> None:
    t, gyr, acc, mag = motion()
    rec, said = told(write(tmp_path / "a.csv", "t,gx,gy,gz,ax,ay,az,mx,my,mz", [t, gyr, acc, mag * np.nan]))
    assert rec.mag is None
    assert "mag" in said[0]


def test_columns_that_look_like_a_sensor_and_are_not_read_are_named(tmp_path: Path) -> None:
    t, gyr, acc, _ = motion()
    path = write(tmp_path / "a.csv", "t,gx,gy,gz,ax,ay,az,roll,pitch,yaw,battery", [t, gyr, acc, gyr, t])
    rec, said = told(path)
    assert "'roll', 'pitch', 'yaw'" in said[0]
    assert "battery" not in said[0]
    assert rec.meta["ignored_columns"] == ["roll", "pitch", "yaw", "battery"]


def test_orientation_columns_are_the_truth_only_where_they_are_named_so(tmp_path: Path) -> None:
    t, gyr, acc, _ = motion()
    quat = np.column_stack([np.cos(0.3 * np.sin(3.0 * t)), np.sin(0.3 * np.sin(3.0 * t)), 0.0 * t, 0.0 * t])
    for names, truth in {"qw,qx,qy,qz": False, "ref_w,ref_x,ref_y,ref_z": True,
                         "truth_qw,truth_qx,truth_qy,truth_qz": True,
                         "optical_qw,optical_qx,optical_qy,optical_qz": True,
                         "orientation.w,orientation.x,orientation.y,orientation.z": False}.items():  # fmt: skip
        path = write(tmp_path / "a.csv", f"t,gx,gy,gz,ax,ay,az,{names}", [t, gyr, acc, quat])
        rec, _ = told(path)
        assert (rec.ref is not None) == truth, names
        assert (rec.device_quat is not None) != truth, names
    asked, _ = told(path, columns={"ref": ["orientation.w", "orientation.x", "orientation.y", "orientation.z"]})
    np.testing.assert_allclose(asked.ref, quat, atol=1e-8)


def test_mixed_units_among_the_axes_are_refused(tmp_path: Path) -> None:
    t, gyr, acc, _ = motion()
    path = write(tmp_path / "a.csv", "t,gx (rad/s),gy (deg/s),gz (deg/s),ax,ay,az", [t, gyr, acc])
    with pytest.raises(ValueError, match="gyr: expected one unit for all axes"):
        ar.read(path)


def test_stamps_of_float32_since_1970_are_refused(tmp_path: Path) -> None:
    t, gyr, acc, _ = motion()
    np.savez(tmp_path / "a.npz", t=(1.7e9 + t).astype(np.float32), gyr=gyr, acc=acc)
    with pytest.raises(ValueError, match="float32"):
        ar.read(tmp_path / "a.npz")


def test_late_rows_are_sorted_and_told(tmp_path: Path) -> None:
    t, gyr, acc, _ = motion()
    order = np.arange(N).reshape(-1, 4)[:, [1, 0, 3, 2]].ravel()
    rec, said = told(write(tmp_path / "a.csv", "t,gx,gy,gz,ax,ay,az", [t[order], gyr[order], acc[order]]))
    assert f"{N // 2} rows come late" in said[0]
    np.testing.assert_allclose(rec.gyr, gyr, atol=1e-9)
    assert any("come late" in sentence for sentence in rec.meta["repairs"])


def test_several_clocks_are_named_and_that_of_the_sensor_is_taken(tmp_path: Path) -> None:
    t, gyr, acc, _ = motion()
    received = 1.7e9 + np.floor(t * 10.0) / 10.0  # in packets, by the receiver's clock
    rec, said = told(write(tmp_path / "a.csv", "received_time,sensor_time_ms,gx,gy,gz,ax,ay,az",
                           [received, 1e3 * t, gyr, acc]))  # fmt: skip
    np.testing.assert_allclose(rec.t, t, atol=1e-9)
    assert "'received_time'" in said[0]
    other, _ = told(tmp_path / "a.csv", columns={"t": "received_time"})
    np.testing.assert_allclose(other.t, received - (received[0] if other.t[0] == 0.0 else 0.0), atol=1e-6)


def test_what_was_told_is_told_again_by_the_command_line_in_one_line_each(tmp_path: Path, capsys: Capture) -> None:
    path = plain(tmp_path / "a.csv")
    lines = [one for one in output_of(capsys, "run", path, "--filter", "madgwick").splitlines() if "no unit" in one]
    assert lines == ["assumed    no unit is stated, taken as t in s, gyr in rad/s, acc in m/s², mag in µT"]
    said = error_of(capsys, "run", plain(tmp_path / "b.csv", force=1.0 / G), "--filter", "madgwick")
    assert "--units acc=g" in said


def test_what_was_told_once_is_not_told_again_of_a_saved_recording(tmp_path: Path) -> None:
    rec, _ = told(plain(tmp_path / "a.csv"))
    for name in ("b.npz", "b.parquet", "b.csv"):
        rec.save(tmp_path / name)
        again, said = told(tmp_path / name)
        assert not said, name
        np.testing.assert_allclose(again.gyr, rec.gyr, rtol=1e-15)


def test_a_run_doubts_arrays_that_are_in_degrees(tmp_path: Path) -> None:
    t, gyr, acc, _ = motion()
    with pytest.warns(ar.DataWarning, match="deg/s"):
        ar.VQF(rate=RATE).run(gyr / DEGREE, acc)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ar.VQF(rate=RATE).run(gyr, acc, t=t)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize(("sensor", "limit"), [("acc", 2.0), ("gyr", 100.0)])
def test_a_run_doubts_what_a_file_doubts(sensor: str, limit: float, dtype: type) -> None:
    """Readings of all sizes about a limit, some missing or far beyond: most are judged by their squares alone."""
    rng = np.random.default_rng(11)
    for count in (100, 145):  # looked at are 50 rows and 49: an odd number has one in its middle
        for size in limit * np.array([0.5, 0.99, 1.0 - 1e-12, 1.0, 1.0 + 1e-12, 1.01, 2.0]):
            rows = rng.standard_normal((count, 3))
            rows *= size * rng.choice([0.999, 1.0, 1.001], (count, 1)) / np.linalg.norm(rows, axis=1, keepdims=True)
            rows[rng.random(count) < 0.3] = np.nan
            rows[::7] *= 1e30
            rows = rows.astype(dtype)
            alone = (rows, None) if sensor == "gyr" else (None, rows)
            found = _plausible.doubts_of_run(*alone, None)
            wrong = _plausible.doubt(sensor, rows[:: count // 48])
            told = wrong if wrong and _plausible.likely_unit(sensor, rows[:: count // 48]) else None
            assert [one.split("; ")[0] for one in found] == ([] if told is None else [f"{sensor}: {told}"])


@pytest.mark.parametrize("leap", [3600.0, 1e8])
def test_a_clock_that_leaps_amid_a_run_is_no_unit_of_time(leap: float) -> None:
    t, gyr, acc, _ = motion()
    with pytest.warns(ar.DataWarning, match="t: a rate of 0.1 Hz .*; the stamps look like ms"):
        ar.VQF().run(gyr, acc, t=1000.0 * t)
    t[N // 2 :] += leap
    ar.VQF().run(gyr, acc, t=t)  # a warning would be an error


def test_infinite_readings_are_an_error_and_nothing_else() -> None:
    t, gyr, acc, _ = motion(speed=6.0)  # fast enough to be compared with the accelerometer
    acc[40] = np.inf
    with pytest.raises(ValueError, match="acc: expected finite values"):
        ar.VQF().run(gyr, acc, t=t)
    acc[40] = 1e200  # a missing measurement
    ar.VQF().run(gyr, acc, t=t)
