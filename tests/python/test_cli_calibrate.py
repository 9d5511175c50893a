"""Laws of `ahrs-rs calibrate` and of the option ``--calibration``."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs.calibration import GRAVITY, Calibration, Calibrations, TemperatureCalibration
from calibrated import FloatArray, directions, sensor
from commands import Capture, error_of, output_of, quat_of, saved, simulated
from late import late, noisy

RATE = 100.0


def recorded(path: Path, **arrays: FloatArray) -> Path:
    count = len(next(iter(arrays.values())))
    arrays = {"gyr": np.zeros((count, 3))} | arrays
    ar.Recording(t=np.arange(count) / RATE, rate=RATE, **arrays).save(path)
    return path


def held(seed: int, poses: FloatArray) -> FloatArray:
    random = np.random.default_rng(seed)
    parts = []
    for up in poses:
        parts += [np.tile(GRAVITY * up, (200, 1)), GRAVITY * up + 5.0 * random.standard_normal((100, 3))]
    clean = np.concatenate(parts) * [1.02, 0.97, 1.0] + [0.2, -0.3, 0.1]
    return clean + 0.03 * random.standard_normal(clean.shape)


def test_a_magnetometer_is_calibrated_into_a_file_that_runs_take(tmp_path: Path, capsys: Capture) -> None:
    x, _, _ = sensor(0, 9)
    file, cal = recorded(tmp_path / "turn.npz", mag=x), tmp_path / "cal.json"
    shown = output_of(capsys, "calibrate", "mag", file, "-o", cal)
    fit = ar.calibration.magnetometer(x)
    assert f"deviation  {fit.deviation_before:.3g} % of the norm before, {fit.deviation_after:.3g} % after" in shown
    assert f"wrote      {cal}" in shown
    assert Calibration.load(cal) == fit.calibration

    walk = saved(tmp_path / "walk.npz")
    shown = output_of(capsys, "run", walk, "--filter", "madgwick", "--calibration", cal, "-o", tmp_path / "out.npz")
    assert "calibrated mag\n" in shown
    rec = simulated()
    assert rec.mag is not None
    expected = ar.FILTERS["Madgwick"](rate=50.0).run(rec.gyr, rec.acc, fit.calibration.apply(rec.mag), t=rec.t)
    assert np.array_equal(quat_of(tmp_path / "out.npz"), expected.quat)
    assert (
        ar.metrics.score(expected.quat, rec.ref, rec.mask).total > 1.0
    )  # which the calibration of another sensor makes


def test_parameters_and_norm_are_those_of_the_function(tmp_path: Path, capsys: Capture) -> None:
    x, _, _ = sensor(1, 6)
    file = recorded(tmp_path / "turn.npz", mag=x)
    output_of(capsys, "calibrate", "mag", file, "--parameters", "6", "--norm", "48", "-o", tmp_path / "cal.json")
    expected = ar.calibration.magnetometer(x, parameters=6, norm=48.0).calibration
    assert Calibration.load(tmp_path / "cal.json") == expected


def test_several_recordings_are_taken_together_and_sensors_join_in_one_file(tmp_path: Path, capsys: Capture) -> None:
    x, _, _ = sensor(2, 9)
    parts = [recorded(tmp_path / f"{k}.npz", mag=part) for k, part in enumerate(np.split(x, 4))]
    cal = tmp_path / "cal.json"
    output_of(capsys, "calibrate", "mag", *parts, "-o", cal)
    acc = held(2, directions(np.random.default_rng(2), 20))
    output_of(capsys, "calibrate", "acc", recorded(tmp_path / "acc.npz", acc=acc), "-o", cal)
    found = ar.calibration.load(cal)
    assert found.mag == ar.calibration.magnetometer(x).calibration
    assert found.acc == ar.calibration.accelerometer(acc, rate=RATE).calibration


@pytest.mark.parametrize("method", ["rest", "robust", "positions"])
def test_an_accelerometer_is_calibrated_by_every_method(method: str, tmp_path: Path, capsys: Capture) -> None:
    poses = np.concatenate((np.eye(3), -np.eye(3))) + 0.15
    poses = np.concatenate((poses, directions(np.random.default_rng(3), 14)))
    acc = held(3, poses / np.linalg.norm(poses, axis=1, keepdims=True))
    file = recorded(tmp_path / "acc.npz", acc=acc)
    output_of(capsys, "calibrate", "acc", file, "--method", method, "-o", tmp_path / "cal.json")
    found = Calibration.load(tmp_path / "cal.json")
    # Motion near 1 g among the readings of the robust method; 0.03 m/s² of noise and quantised choices in the others.
    assert np.allclose(np.diag(found.matrix), [1 / 1.02, 1 / 0.97, 1.0], rtol=0, atol=0.005)
    assert np.allclose(found.offset, [0.2, -0.3, 0.1], rtol=0, atol=0.05)


def test_a_gyroscope_is_calibrated_by_the_turns_between_its_rests(tmp_path: Path, capsys: Capture) -> None:
    t = np.arange(300) / RATE
    way = (1 - np.cos(np.pi * t / t[-1])) / 2
    speed = np.concatenate(([0.0], np.diff(way) * RATE))
    parts = []
    for axis, angle in ((0, 360.0), (1, -360.0), (2, 180.0)):
        turn = np.zeros((300, 3))
        turn[:, axis] = math.radians(angle) * speed
        parts += [np.zeros((200, 3)), turn]
    clean = np.concatenate([*parts, np.zeros((200, 3))])
    bias, gain = np.array([0.02, -0.01, 0.005]), np.array([1.02, 0.99, 0.96])
    gyr = clean * gain + bias + 1e-3 * np.random.default_rng(4).standard_normal(clean.shape)
    file, cal = recorded(tmp_path / "turns.npz", gyr=gyr), tmp_path / "cal.json"
    shown = output_of(capsys, "calibrate", "gyr", file, "--turns", "x=360,y=-360,z=180", "-o", cal)
    found = Calibration.load(cal, "gyr")
    assert "x          gain 1.0" in shown
    # Five deviations: 1e-3/√800 of the bias; that times 5 s over π of the gain, and the noise of a turn.
    assert np.allclose(found.offset, bias, rtol=0, atol=2e-4)
    assert np.allclose(np.diag(found.matrix), 1 / gain, rtol=0, atol=5e-4)
    output_of(capsys, "calibrate", "gyr", file, "-o", tmp_path / "bias.json")
    assert np.array_equal(Calibration.load(tmp_path / "bias.json").matrix, np.eye(3))
    said = error_of(capsys, "calibrate", "gyr", file, "--turns", "x=360,y=360")
    assert said == "--turns: the recording has 3 turns between its rests, got 2"


def test_a_gyroscope_is_calibrated_against_a_reference(tmp_path: Path, capsys: Capture) -> None:
    rec = ar.simulate.demo(duration=60.0, rate=50.0, seed=1, noise=False)
    dataclasses.replace(rec, gyr=rec.gyr * 1.05 + 0.01).save(tmp_path / "a.npz")
    output_of(capsys, "calibrate", "gyr", tmp_path / "a.npz", "--reference", "-o", tmp_path / "cal.json")
    found = Calibration.load(tmp_path / "cal.json")
    assert np.allclose(found.matrix, np.eye(3) / 1.05, rtol=0, atol=1e-9)
    assert np.allclose(found.offset, 0.01, rtol=0, atol=1e-9)


def test_sources_for_firmware_are_written(tmp_path: Path, capsys: Capture) -> None:
    x, _, _ = sensor(5, 9)
    file, cal = recorded(tmp_path / "turn.npz", mag=x), tmp_path / "cal.json"
    output_of(capsys, "calibrate", "mag", file, "-o", cal, "--rust", tmp_path / "a.rs")
    output_of(capsys, "calibrate", "export", cal, "--rust", tmp_path / "b.rs", "--c-header", tmp_path / "b.h")
    found = ar.calibration.load(cal)
    assert (tmp_path / "a.rs").read_text(encoding="utf-8") == found.to_rust()
    assert (tmp_path / "b.rs").read_text(encoding="utf-8") == found.to_rust()
    assert (tmp_path / "b.h").read_text(encoding="utf-8") == found.to_c()


def test_the_plot_is_drawn_beside_the_output_or_where_asked(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("matplotlib")
    x, _, _ = sensor(6, 9)
    file = recorded(tmp_path / "turn.npz", mag=x)
    shown = output_of(capsys, "calibrate", "mag", file, "-o", tmp_path / "cal.json", "--plot")
    assert f"wrote      {tmp_path / 'cal.png'}" in shown
    output_of(capsys, "calibrate", "mag", file, "--plot", tmp_path / "b.svg")
    assert (tmp_path / "cal.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (tmp_path / "b.svg").read_text(encoding="utf-8")


def test_another_unit_is_noted(tmp_path: Path, capsys: Capture) -> None:
    file = recorded(tmp_path / "turn.npz", mag=0.01 * sensor(7, 9)[0])
    assert "it looks like gauss; give units={'mag': 'gauss'}" in error_of(capsys, "calibrate", "mag", file)
    assert "note       mag: the norm is 0.4" in output_of(capsys, "calibrate", "mag", file, "--units", "mag=raw")
    assert "norm is 0.4" not in output_of(capsys, "calibrate", "mag", file, "--units", "mag=gauss")


def test_compare_takes_a_calibration_and_says_what_it_could_not_apply(tmp_path: Path, capsys: Capture) -> None:
    rec = simulated()
    assert rec.acc is not None
    off = dataclasses.replace(rec, acc=rec.acc * 1.1 + 2.0, mag=None)
    off.save(tmp_path / "a.npz")
    Calibrations(acc=Calibration(np.eye(3) / 1.1, np.full(3, 2.0)), mag=Calibration.identity()).save(
        tmp_path / "cal.json"
    )
    options = ("compare", tmp_path / "a.npz", "--filters", "mahony", "--csv", tmp_path / "out.csv")
    output_of(capsys, *options)
    before = float((tmp_path / "out.csv").read_text().splitlines()[1].split(",")[7])
    shown = output_of(capsys, *options, "--calibration", tmp_path / "cal.json")
    after = float((tmp_path / "out.csv").read_text().splitlines()[1].split(",")[7])
    assert after < 0.7 * before
    assert "calibrated, but not in the recording: mag: a.npz" in shown


def test_a_magnetometers_delay_is_shown_for_every_recording_and_for_all(tmp_path: Path, capsys: Capture) -> None:
    files = []
    for seed in (0, 1):
        files.append(tmp_path / f"{seed}.npz")
        noisy(late(0.02, seed, duration=40.0), seed).save(files[-1])
    files.append(saved(tmp_path / "short.npz"))
    found = [ar.calibration.mag_delay(ar.read(file)) for file in files[:2]]
    shown = output_of(capsys, "calibrate", "mag-delay", *files)
    for one in found:
        assert one.summary() in shown
    assert "left out   mag: expected at least 10 windows of 1 s" in shown
    weights = [one.standard_error**-2 for one in found]
    mean = np.average([one.delay for one in found], weights=weights)
    assert f"together   {1e3 * mean:.2f} ± {1e3 / math.sqrt(sum(weights)):.2f} ms" in shown
    assert f"use        --set mag_delay={mean:.4f} (" in shown
    assert "OfflineVQF" in shown.splitlines()[-1]


def test_a_temperature_out_of_range_is_noted(tmp_path: Path, capsys: Capture) -> None:
    one = TemperatureCalibration(np.zeros(3), np.ones(3), np.zeros(3), np.zeros(3), range=(0.0, 10.0))
    one.save(tmp_path / "cal.json", "acc")
    count = len(simulated())
    file = saved(tmp_path / "a.npz", temperature=np.full(count, 25.0))
    shown = output_of(capsys, "run", file, "--filter", "mahony", "--calibration", tmp_path / "cal.json")
    assert f"note       acc was calibrated from 0 to 10 °C; {count} of {count} samples are outside" in shown


#: Arguments, where words in capitals stand for paths, and what the error must say.
MISTAKES = """
calibrate => expected a sensor: mag, acc, gyr, ferraris, mag-delay, or export
calibrate mag-delay NOMAG => mag: the recording has no magnetometer
calibrate mag-delay TURN => mag: expected at least 10 windows of 1 s with 8 readings, got 4
calibrate mag-delay TURN NOMAG => none of the recordings determines the delay
calibrate mag => the following arguments are required: FILE
calibrate mag MISSING => missing.npz: no such file
calibrate mag WALK => mag: the readings
calibrate mag TURN -o cal.txt => -o: expected a name that ends in .json, got 'cal.txt'
calibrate mag TURN -o TEXT => text.json: is not JSON
calibrate mag TURN --plot a.xyz => --plot: expected a name that ends in
calibrate mag TURN --parameters 7 => --parameters: invalid choice: 7
calibrate mag TURN --norm 0.5 => mag: expected readings of about 0.5 µT, got
calibrate mag NOMAG => nomag.npz: has no mag
calibrate acc TURN => turn.npz: has no acc
calibrate acc WALK --method positions => positions: expected at least six, got
calibrate acc WALK --method guess => --method: invalid choice: 'guess'
calibrate gyr WALK --turns w=3 => --turns: expected AXIS=DEG like x=360, got 'w=3'
calibrate gyr WALK --turns x => --turns: expected AXIS=DEG like x=360, got 'x'
calibrate gyr TURN --reference => has no reference
calibrate gyr WALK WALK => expected one recording of a gyroscope, got 2
calibrate export TEXT => expected --rust FILE or --c-header FILE
calibrate export TEXT --rust a.rs => text.json: is not JSON
run WALK --filter mahony --calibration TEXT => text.json: is not JSON
run WALK --filter mahony --calibration MISSING => missing.npz: No such file
compare WALK --filters mahony --calibration TEXT => text.json: is not JSON
""".strip().splitlines()


@pytest.mark.parametrize("line", MISTAKES)
def test_mistakes_are_told_in_one_line(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    arguments, _, expected = line.partition(" => ")
    monkeypatch.chdir(tmp_path)
    rec = simulated()
    dataclasses.replace(rec, mag=None).save(tmp_path / "nomag.npz")
    assert rec.mag is not None
    # A walk that shows one side of the sphere alone.
    level = np.abs(rec.mag) * [0.2, 0.2, 1.0]
    dataclasses.replace(rec, mag=level).save(tmp_path / "walk.npz")
    recorded(tmp_path / "turn.npz", mag=sensor(8, 9)[0])
    (tmp_path / "text.json").write_text("{", encoding="utf-8")
    paths = {
        "WALK": "walk.npz",
        "TURN": "turn.npz",
        "NOMAG": "nomag.npz",
        "TEXT": "text.json",
        "MISSING": "missing.npz",
    }
    before = sorted(tmp_path.iterdir())
    said = error_of(capsys, *(paths.get(word, word) for word in arguments.split()))
    assert expected in said
    assert sorted(tmp_path.iterdir()) == before
