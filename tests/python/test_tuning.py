"""Laws of the search for parameters."""

from __future__ import annotations

import dataclasses
import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import tuning
from ahrs_rs._cells import Cells
from ahrs_rs.cli import main
from commands import Capture, error_of, output_of, without

#: What is planted; not a number that a search tries by itself.
BETA, KP, KI = 0.0731, 0.617, 0.0231


def planted(f: ar.Filter, seed: int = 0, duration: float = 6.0) -> ar.Recording:
    """A recording whose truth is what the filter estimates, so that its parameters have no error."""
    recording = ar.simulate.demo(duration=duration, rate=50.0, seed=seed)
    est = f.run(recording.gyr, recording.acc, recording.mag, t=recording.t)
    return dataclasses.replace(recording, ref=est.quat)


def madgwick(count: int = 3) -> list[ar.Recording]:
    return [planted(ar.Madgwick(rate=50.0, beta=BETA), seed) for seed in range(count)]


def mahony(count: int = 2) -> list[ar.Recording]:
    return [planted(ar.Mahony(rate=50.0, kp=KP, ki=KI), seed) for seed in range(count)]


def same(one: tuning.Tuned, other: tuning.Tuned) -> bool:
    """Bit for bit."""
    return repr(one) == repr(other) and one.train.errors.tobytes() == other.train.errors.tobytes()


def test_a_grid_finds_the_planted_value_among_its_own() -> None:
    found = tuning.grid(ar.Madgwick, {"beta": [0.01, BETA, 0.5], "gradient": None}, madgwick())
    assert found.params == {"beta": BETA, "gradient": "tangent"}
    assert found.evaluated == 6
    # The angle of an error that is none: the square root of the rounding of its squares, in degrees.
    assert found.train.mean < 1e-6
    assert found.train.default_mean > 0.01


def test_a_grid_over_a_range_comes_as_near_as_its_points() -> None:
    found = tuning.grid(ar.Madgwick, {"beta": (1e-3, 1.0)}, madgwick(), points=301)
    # 301 points over three decades: neighbours differ by the factor 10^0.01, and the best one is a neighbour of BETA.
    assert abs(np.log10(float(found.params["beta"]) / BETA)) <= 0.01


def test_a_genetic_search_finds_planted_values() -> None:
    where = {"kp": (0.01, 10.0), "ki": (0.0, 0.5)}
    found = tuning.evolve(ar.Mahony, where, mahony(), generations=40, tolerance=0.0, seed=1)
    # It has converged to 1 % and to no error that could be seen after this many generations, and would go on.
    assert found.params["kp"] == pytest.approx(KP, rel=0.01)
    assert found.params["ki"] == pytest.approx(KI, rel=0.01)
    assert found.train.mean < 1e-2
    assert all(b <= a for a, b in zip(found.history, found.history[1:], strict=False))
    assert min(found.history) == found.train.mean


def test_a_genetic_search_chooses_options_too() -> None:
    recordings = [planted(ar.Madgwick(rate=50.0, beta=BETA, gradient="paper"), seed) for seed in range(2)]
    found = tuning.evolve(ar.Madgwick, ["beta", "gradient"], recordings, generations=25, seed=2)
    assert found.params["gradient"] == "paper"
    assert found.params["beta"] == pytest.approx(BETA, rel=0.02)


def test_any_function_of_estimate_and_recording_can_be_the_metric() -> None:
    def worst_roll(est: ar.Estimate, recording: ar.Recording) -> float:
        assert recording.ref is not None
        return float(np.abs(ar.metrics.euler_error(est.quat, recording.ref)[:, 0]).max())

    found = tuning.grid(ar.Madgwick, {"beta": [0.01, BETA, 0.5]}, madgwick(2), metric=worst_roll)
    assert found.params == {"beta": BETA}
    assert found.metric == "worst_roll"
    found = tuning.evolve(ar.Madgwick, ["beta"], madgwick(1), metric=worst_roll, generations=12)
    assert found.params["beta"] == pytest.approx(BETA, rel=0.05)


def test_a_metric_that_fails_says_its_own_error() -> None:
    def failing(est: ar.Estimate, recording: ar.Recording) -> float:
        if est.quat[-1, 0] != first[0]:
            raise ValueError("this metric has had enough")
        return 1.0

    recording = madgwick(1)[0]
    first = ar.Madgwick(rate=50.0).run(recording.gyr, recording.acc, recording.mag, t=recording.t).quat[-1]
    with pytest.raises(ValueError, match="this metric has had enough"):
        tuning.evolve(ar.Madgwick, ["beta"], [recording], metric=failing)
    with pytest.raises(ValueError, match="recording 0: expected ref"):
        tuning.evolve(ar.Madgwick, ["beta"], [dataclasses.replace(recording, ref=None)])


def test_test_recordings_have_no_part_in_the_choice_and_both_errors_are_those_of_sweeps() -> None:
    recordings = [*madgwick(4), *mahony(2)]
    found = tuning.grid(ar.Madgwick, ["beta"], recordings, test=0.4, seed=3)
    assert found.test is not None
    assert sorted(found.train.recordings + found.test.recordings) == list(range(6))
    assert len(found.test.recordings) == 2
    for part in (found.train, found.test):
        own = [recordings[index] for index in part.recordings]
        swept = ar.sweep(ar.Madgwick, [found.params, {}], own)
        assert np.array_equal(swept.errors[0], part.errors)
        assert np.array_equal(swept.errors[1], part.defaults)
        assert part.mean == part.errors.mean()
    train = [recordings[index] for index in found.train.recordings]
    test = [recordings[index] for index in found.test.recordings]
    alone = tuning.grid(ar.Madgwick, ["beta"], train, test=test)
    assert alone.params == found.params
    assert alone.test is not None
    assert np.array_equal(alone.test.errors, found.test.errors)
    assert tuning.grid(ar.Madgwick, ["beta"], train).test is None


def test_fixed_parameters_are_held_and_the_filter_is_made_of_all() -> None:
    found = tuning.grid(ar.Madgwick, ["beta"], madgwick(1), fixed={"gradient": "paper"})
    f = found.make(rate=50.0)
    assert (f.NAME, f.rate) == ("Madgwick", 50.0)
    assert f.params["gradient"] == "paper"
    assert f.params["beta"] == found.params["beta"]


def test_what_is_saved_is_loaded(tmp_path: Path) -> None:
    found = tuning.grid(ar.Madgwick, ["beta"], madgwick(), test=0.4)
    found.save(tmp_path / "tuned.json", ["a", "b", "c"])
    assert same(tuning.Tuned.load(tmp_path / "tuned.json"), found)
    assert json.loads((tmp_path / "tuned.json").read_text())["train"]["names"]
    (tmp_path / "other.json").write_text("{}")
    for name in ("other.json", __file__):
        with pytest.raises(ValueError, match="path: expected a file of tuned parameters"):
            tuning.Tuned.load(tmp_path / name)


def interrupted_after(sets: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """As if Ctrl-C came when so many sets have been computed, and one more over the first recording."""
    left = [sets]
    compute = Cells._side_by_side

    def some(self: Cells, chosen: list[int], which: list[int], count: Any) -> None:
        now, rest = chosen[: left[0]], chosen[left[0] :]
        left[0] -= len(now)
        if now:
            compute(self, now, which, count)
        if rest:
            compute(self, rest[:1], which[:1], count)
            raise KeyboardInterrupt

    monkeypatch.setattr(Cells, "_side_by_side", some)


def counted(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The numbers of errors that are computed from here on."""
    computed: list[int] = []
    compute = Cells._side_by_side

    def counting(self: Cells, chosen: list[int], which: list[int], count: Any) -> None:
        computed.append(len(chosen) * len(which))
        compute(self, chosen, which, count)

    monkeypatch.setattr(Cells, "_side_by_side", counting)
    return computed


def grid_search(checkpoint: Path | None) -> tuning.Tuned:
    return tuning.grid(ar.Mahony, ["kp", "ki"], mahony(), points=9, checkpoint=checkpoint)


def genetic_search(checkpoint: Path | None) -> tuning.Tuned:
    return tuning.evolve(ar.Mahony, ["kp", "ki"], mahony(), generations=8, seed=5, checkpoint=checkpoint)


@pytest.mark.parametrize("search", [grid_search, genetic_search])
@pytest.mark.parametrize("cut", [0, 10, 50])
def test_an_interrupted_search_goes_on_to_the_same_result_bit_for_bit(
    search: Callable[[Path | None], tuning.Tuned], cut: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = search(None)
    file = tmp_path / "checkpoint.jsonl"
    with monkeypatch.context() as patch:
        interrupted_after(cut, patch)
        with pytest.raises(tuning.TuningInterrupted, match="they are kept in") as caught:
            search(file)
    assert caught.value.evaluated == cut
    computed = counted(monkeypatch)
    assert same(search(file), whole)
    # The defaults are computed for the scores if the grid does not have them. One error of one more set was kept.
    assert sum(computed) == 2 * (whole.evaluated - cut + (search is grid_search)) - 1
    computed.clear()
    assert same(search(file), whole)
    assert not computed


@pytest.mark.parametrize("search", [grid_search, genetic_search])
def test_a_line_that_was_cut_off_is_computed_again(
    search: Callable[[Path | None], tuning.Tuned], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "checkpoint.jsonl"
    whole = search(file)
    text = file.read_text()
    kept = text[: len(text) // 2]
    file.write_text(kept)
    computed = counted(monkeypatch)
    assert same(search(file), whole)
    assert 0 < sum(computed) == 2 * (text.count("\n") - kept.count("\n"))
    computed.clear()
    assert same(search(file), whole)
    assert not computed


def test_a_checkpoint_of_another_search_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "checkpoint.jsonl"
    grid_search(file)
    others: list[tuple[type[ar.Filter], list[ar.Recording], dict[str, Any]]] = [
        (ar.Madgwick, mahony(), {}),
        (ar.Mahony, mahony(1), {}),
        (ar.Mahony, mahony(), {"metric": "heading"}),
        (ar.Mahony, mahony(), {"dtype": np.float32}),
    ]
    for cls, recordings, keywords in others:
        with pytest.raises(ValueError, match=r"checkpoint: .* is of another search"):
            tuning.grid(cls, None, recordings, checkpoint=file, points=2, **keywords)


def test_without_a_checkpoint_an_interruption_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    interrupted_after(3, monkeypatch)
    with pytest.raises(tuning.TuningInterrupted, match="they are lost"):
        grid_search(None)


def test_the_space_is_logarithmic_where_it_spans_decades() -> None:
    (beta,) = tuning.space(ar.Madgwick)
    assert (beta.name, beta.log) == ("beta", True)
    assert (beta.low, beta.high) == pytest.approx((0.041e-3, 41.0))
    assert beta.points(3) == pytest.approx([0.041e-3, 0.041, 41.0])
    by_name = {axis.name: axis for axis in tuning.space(ar.VQF)}
    assert by_name["mag_dip_th"].high == 180.0  # not beyond the registry's range
    near, far, zero = (tuning.space(ar.Mahony, {"kp": where})[0] for where in ((1, 50), (0.1, 50), (0, 50)))
    assert (near.log, far.log, zero.log) == (False, True, False)
    for axis in (near, far, zero):
        assert axis.points(7)[0] == axis.low
        assert axis.points(7)[-1] == axis.high
        assert axis.coordinate(30.0) is not None
        assert axis.value(axis.coordinate(30.0) or 0.0) == pytest.approx(30.0, rel=1e-14)
        assert axis.coordinate(51.0) is None
    (choice,) = tuning.space(ar.Madgwick, "gradient")
    assert choice.points(99) == ["tangent", "paper"]


@pytest.mark.parametrize(
    ("params", "message"),
    [
        ({"gain": (0, 1)}, r"Madgwick has no parameter 'gain'.*; it has beta, zeta"),
        (["zeta"], "zeta has the default 0 and so no scale"),
        ({"beta": (1, 0.5)}, "expected low < high for beta"),
        ({"beta": (-1, 0.5)}, "beta: expected a number in"),
        ({"beta": (1, 2, 3)}, r"beta is a number; expected \(low, high\) or a list"),
        ({"gradient": ("tangent", "paper")}, "gradient is a choice; expected"),
        ({"beta": []}, "expected at least one value for beta"),
        ([], "expected at least one parameter of Madgwick"),
    ],
)
def test_spaces_that_are_none_are_errors(params: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        tuning.space(ar.Madgwick, params)


def test_wrong_arguments_are_errors() -> None:
    recordings = madgwick(2)
    with pytest.raises(ValueError, match="make 10000000000 sets; take fewer, or evolve"):
        tuning.grid(ar.Mahony, ["kp", "ki"], recordings, points=100_000)
    with pytest.raises(ValueError, match="recordings: expected at least one"):
        tuning.grid(ar.Madgwick, None, [])
    with pytest.raises(ValueError, match="test: expected a part between 0 and 1"):
        tuning.grid(ar.Madgwick, None, recordings, test=1.0)
    with pytest.raises(ValueError, match="test: expected two recordings or more"):
        tuning.grid(ar.Madgwick, None, recordings[:1], test=0.5)
    with pytest.raises(TypeError, match="grid has no argument 'rate'"):
        tuning.grid(ar.Madgwick, None, recordings, rate=1.0)
    nothing = dataclasses.replace(recordings[0], mask=np.zeros(len(recordings[0]), dtype=bool))
    with pytest.raises(ValueError, match="expected a sample that counts"):
        tuning.grid(ar.Madgwick, None, [nothing])


def test_a_genetic_search_without_scipy_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    recordings = madgwick(1)
    without(monkeypatch, "scipy")
    with pytest.raises(ImportError, match=r"pip install ahrs-rs\[scipy\]"):
        tuning.evolve(ar.Madgwick, None, recordings)


@pytest.fixture
def files(tmp_path: Path) -> list[Path]:
    paths = [tmp_path / f"walk{index}.npz" for index in range(3)]
    for path, recording in zip(paths, madgwick(), strict=True):
        recording.save(path)
    return paths


def test_the_command_finds_what_the_function_finds(files: list[Path], tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "tuned.json"
    argv = ["tune", *files, "--filter", "madgwick", "--param", "beta=0.001:1", "--param", "gradient", "--test", "0.4"]
    shown = output_of(capsys, *argv, "-o", out)
    where = {"beta": (0.001, 1.0), "gradient": None}
    expected = tuning.grid(ar.Madgwick, where, [ar.read(file) for file in files], test=0.4)
    assert same(tuning.Tuned.load(out), expected)
    assert f"--set beta={expected.params['beta']}" in shown
    assert f"train      total RMSE {expected.train.mean:.3f}° (mean over 2 files" in shown
    output_of(
        capsys, "tune", files[0], "--filter", "mahony", "--set", "ki=0", "--method", "evolve", "--param", "kp",
        "--generations", 2, "--population", 4, "--metric", "inclination", "--6d", "-o", out
    )  # fmt: skip
    recording = dataclasses.replace(ar.read(files[0]), mag=None)
    one = tuning.evolve(
        ar.Mahony, ["kp"], [recording], fixed={"ki": 0.0}, generations=2, population=4, metric="inclination"
    )
    assert same(tuning.Tuned.load(out), one)
    # A file that names no earth frame has its reference in that of the settings.
    shown = output_of(
        capsys, "tune", files[0], "--filter", "madgwick", "--param", "beta=0.1,0.2", "--metric", "heading"
    )
    assert "2 parameter sets" in shown


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--param", "gain"], "Madgwick has no parameter 'gain'"),
        (["--param", "beta="], "--param: expected NAME, NAME=LOW:HIGH or NAME=A,B, got 'beta='"),
        (["--param", "beta=x:1"], "Madgwick.beta: expected a number, got 'x'"),
        (["--param", "beta=1:0"], "params: expected low < high for beta"),
        (["--param", "beta", "--set", "beta=1"], "--param and --set: expected beta in one of them"),
        (["--test", "2"], "argument --test: expected a part between 0 and 1"),
        (["--points", "0"], "argument --points: expected a positive whole number"),
        (["--seed", "-1"], "argument --seed: expected a whole number that is not negative"),
        (["-o", "same", "--checkpoint", "same"], "-o and --checkpoint: expected two files"),
    ],
)
def test_wrong_options_are_told_in_one_line(
    options: list[str],
    message: str,
    files: list[Path],
    capsys: Capture,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert message in error_of(capsys, "tune", *files, "--filter", "madgwick", *options)


def test_a_file_that_is_not_there_is_told(tmp_path: Path, capsys: Capture) -> None:
    assert "absent.npz: no such file" in error_of(capsys, "tune", tmp_path / "absent.npz", "--filter", "madgwick")


def test_recordings_without_truth_or_in_two_frames_are_told(tmp_path: Path, capsys: Capture) -> None:
    recording = madgwick(1)[0]
    dataclasses.replace(recording, ref=None).save(tmp_path / "bare.npz")
    assert "no reference at any sample" in error_of(capsys, "tune", tmp_path / "bare.npz", "--filter", "madgwick")
    paths = [tmp_path / f"{frame}.npz" for frame in ("ENU", "NED")]
    for path in paths:
        dataclasses.replace(recording, meta={"ref_frame": path.stem}).save(path)
    assert "one earth frame, got ENU and NED" in error_of(
        capsys, "tune", *reversed(paths), "--filter", "madgwick"
    ).replace("NED and ENU", "ENU and NED")


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)])
def test_a_signal_ends_the_command_which_goes_on_to_the_same_file(
    number: signal.Signals, status: int, tmp_path: Path, capsys: Capture
) -> None:
    recording = planted(ar.Madgwick(rate=50.0, beta=BETA), duration=60.0)
    recording.save(tmp_path / "walk.npz")
    # Twelve million samples: several portions, long enough that the signal arrives within.
    argv = [
        "tune", tmp_path / "walk.npz", "--filter", "madgwick", "--param", "beta=0.001:10", "--points", 4 * 1024
    ]  # fmt: skip
    checkpoint = tmp_path / "part.jsonl"
    command = [sys.executable, "-m", "ahrs_rs", *map(str, argv), "--checkpoint", str(checkpoint)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        while process.poll() is None and not (checkpoint.exists() and checkpoint.stat().st_size > 1000):
            time.sleep(0.001)
        process.send_signal(number)
        _, told = process.communicate()
    assert process.returncode == status, told
    assert ("tuning interrupted: " in told) == (number != signal.SIGKILL)
    done = len(checkpoint.read_text().splitlines()) - 1
    assert 0 < done < 4 * 1024
    for out, options in (("resumed.json", ["--checkpoint", checkpoint]), ("whole.json", [])):
        assert main([str(one) for one in [*argv, "-o", tmp_path / out, *options]]) == 0
    capsys.readouterr()
    assert (tmp_path / "resumed.json").read_bytes() == (tmp_path / "whole.json").read_bytes()
