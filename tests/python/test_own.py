"""Filters of a user's own in everything that takes a filter."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import _quat
from ahrs_rs.filters import FILTERS
from calibrated import FloatArray
from commands import Capture, error_of, output_of
from test_derived import FROM_ENU

PAGE = Path(__file__).parents[2] / "docs" / "own-filters.md"


@pytest.fixture(autouse=True)
def nothing_registered() -> Iterator[None]:
    yield
    FILTERS.own.clear()


def recordings(count: int = 2) -> list[ar.Recording]:
    return [ar.simulate.demo(duration=3.0, rate=50.0, seed=seed) for seed in range(count)]


class Wrapped:
    """A filter of the package as one of a user's own: what it gives is known."""

    def __init__(self, beta: float = 0.1, rate: float = 1.0) -> None:
        self.f = ar.Madgwick(rate=rate, beta=beta)

    def update(self, gyr: Any, acc: Any, mag: Any, dt: float) -> FloatArray:
        quat: FloatArray = np.asarray(self.f.update(gyr, acc, mag, dt=dt))
        return quat


class WholeRecordings:
    PARAMS = {"beta": (0.0, 5.0)}  # noqa: RUF012  # as a user writes it

    def __init__(self, beta: float = 0.1) -> None:
        self.beta = beta

    def run(self, recording: ar.Recording) -> FloatArray:
        quat: FloatArray = np.asarray(ar.Madgwick(rate=recording.rate, beta=self.beta).run(recording).quat)
        return quat


def function(gyr: Any, acc: Any, mag: Any, t: Any, beta: float = 0.1) -> FloatArray:
    quat: FloatArray = np.asarray(ar.Madgwick(beta=beta, rate=50.0).run(gyr, acc, mag, t=t).quat)
    return quat


def other_names(w: Any, a: Any, m: Any) -> FloatArray:
    quat: FloatArray = np.asarray(ar.Madgwick(rate=50.0, beta=0.1).run(w, a, m).quat)
    return quat


OWN = pytest.mark.parametrize("own", [Wrapped, WholeRecordings, function])


@OWN
def test_a_filter_that_wraps_one_of_the_package_gives_the_same(own: Any) -> None:
    recs = recordings()
    expected = ar.run_many(ar.Madgwick(rate=50.0, beta=0.1), recs)
    for mine, theirs, rec in zip(ar.run_many(own, recs), expected, recs, strict=True):
        # The quaternions are normalised once more: rounding.
        assert np.allclose(mine.quat, theirs.quat, rtol=0, atol=1e-14)
        assert np.array_equal(mine.t, rec.t)
        assert mine.gyr_bias is None
        assert ar.metrics.score(mine.quat, rec.ref).total == pytest.approx(ar.metrics.score(theirs.quat, rec.ref).total)


@OWN
@pytest.mark.parametrize("metric", ["total", "inclination", lambda est, rec: float(est.quat[-1, 0])])
def test_sweeps_and_searches_have_the_errors_of_the_wrapped_one(own: Any, metric: Any, tmp_path: Path) -> None:
    recs, betas = recordings(), [0.01, 0.1, 1.0]
    mine = ar.sweep(own, {"beta": betas}, recs, metric, checkpoint=tmp_path / "kept.jsonl")
    theirs = ar.sweep(ar.Madgwick, {"beta": betas}, recs, metric)
    # Errors come from another sum over the samples: rounding.
    assert np.allclose(mine.errors, theirs.errors, rtol=1e-9, atol=1e-9)
    assert mine.best == theirs.best
    again = ar.sweep(own, {"beta": betas}, recs, metric, checkpoint=tmp_path / "kept.jsonl")
    assert np.array_equal(again.errors, mine.errors)
    found = ar.tuning.grid(own, {"beta": (0.01, 1.0)}, recs, points=4, metric=metric)
    wanted = ar.tuning.grid(ar.Madgwick, {"beta": (0.01, 1.0)}, recs, points=4, metric=metric)
    assert found.params == wanted.params
    assert found.filter == own.__name__


def test_names_that_are_not_known_are_given_by_their_order() -> None:
    (rec,) = recordings(1)
    (mine,) = ar.run_many(other_names, [rec])
    assert np.allclose(mine.quat, ar.Madgwick(rate=50.0, beta=0.1).run(rec.gyr, rec.acc, rec.mag).quat, atol=1e-14)

    class Ordered:
        def update(self, a: Any, b: Any, c: Any, d: float) -> FloatArray:
            seen.append((a.shape, b.shape, c.shape, d))
            return np.array([1.0, 0.0, 0.0, 0.0])

    seen: list[Any] = []
    ar.run_many(Ordered, [rec])
    assert seen[0] == ((3,), (3,), (3,), pytest.approx(0.02))


def test_an_object_is_copied_for_each_recording() -> None:
    recs = recordings(3)
    given = Wrapped(beta=0.05, rate=50.0)
    first = ar.run_many(given, recs)
    again = ar.run_many(given, [recs[2]])
    assert np.array_equal(first[2].quat, again[0].quat)


def test_missing_rows_are_none_and_the_gyroscopes_holds_the_last_rate() -> None:
    (rec,) = recordings(1)
    gyr, acc = np.array(rec.gyr), np.array(rec.acc)
    gyr[[0, 5, 6]], acc[7] = np.nan, np.nan
    seen: list[tuple[Any, Any, Any]] = []

    class Seeing:
        def update(self, gyr: Any, acc: Any, mag: Any, dt: float) -> Any:
            seen.append((gyr.copy(), acc, mag))
            return [1.0, 0.0, 0.0, 0.0]

    (est,) = ar.run_many(Seeing, [{"gyr": gyr, "acc": acc, "t": rec.t}])
    assert np.array_equal(seen[0][0], np.zeros(3))
    assert np.array_equal(seen[6][0], gyr[4])
    assert seen[7][1] is None
    assert all(mag is None for _, _, mag in seen)
    assert np.array_equal(np.flatnonzero(est.status & ar.Status.GYR_HELD), [0, 5, 6])
    assert np.array_equal(np.flatnonzero(est.status & ar.Status.ACC_MISSING), [7])


@pytest.mark.parametrize("own_frame", FROM_ENU)
@pytest.mark.parametrize("frame", FROM_ENU)
def test_orientations_are_turned_from_the_filters_earth_frame_into_the_one_asked_for(
    own_frame: str, frame: str
) -> None:
    (rec,) = recordings(1)

    class Framed:
        FRAME = own_frame

        def run(self, recording: ar.Recording) -> Any:
            return ar.Madgwick(rate=50.0, frame=own_frame).run(recording).quat

    est = ar.register(Framed)(rate=50.0, frame=frame).run(rec)
    expected = ar.Madgwick(rate=50.0, frame=frame).run(rec).quat
    assert est.frame == frame
    # The package's frames are turned by constant rotations too; signs may differ as a whole.
    assert np.allclose(np.abs((est.quat * expected).sum(axis=1)), 1.0, rtol=0, atol=1e-12)


def test_scalar_last_and_the_declination() -> None:
    (rec,) = recordings(1)

    class Last:
        ORDER = "xyzw"

        def run(self, gyr: Any, acc: Any, mag: Any) -> Any:
            return np.roll(ar.MEKF(rate=50.0).run(gyr, acc, mag).quat, -1, axis=1)

    est = ar.register(Last)(rate=50.0, declination=0.2).run(rec)
    expected = ar.MEKF(rate=50.0, declination=0.2).run(rec.gyr, rec.acc, rec.mag).quat
    assert np.allclose(np.abs((est.quat * expected).sum(axis=1)), 1.0, rtol=0, atol=1e-9)


def test_registered_filters_are_found_and_are_in_no_loop() -> None:
    before = list(ar.FILTERS)
    cls = ar.register(Wrapped, name="Mine")
    assert ar.FILTERS["Mine"] is cls
    assert "Mine" in ar.FILTERS
    assert ar.FILTERS.get("Mine") is cls
    assert ar.FILTERS.get("Nobodys") is None
    assert list(ar.FILTERS) == before == list(ar.FILTERS.keys())
    assert len(ar.FILTERS) == len(before)
    assert cls.PARAMS["beta"].default == 0.1
    assert "rate" not in cls.PARAMS
    with pytest.raises(KeyError, match=r"got 'mine' \(did you mean Mine\?\)"):
        ar.FILTERS["mine"]
    with pytest.raises(ValueError, match="name: expected one that no filter of the package has, got 'Madgwick'"):
        ar.register(Wrapped, name="Madgwick")


@pytest.mark.parametrize("thing", [ar.Madgwick, ar.Filter, ar.Madgwick(rate=50.0)])
def test_a_filter_of_the_package_is_none_of_ones_own(thing: Any) -> None:
    with pytest.raises(TypeError, match=r"or a filter of your own .*, got"):
        ar.register(thing, name="Mine")


def test_finished_orientations_are_taken_to_the_recordings_times(tmp_path: Path) -> None:
    recs = recordings(2)
    for k, rec in enumerate(recs):
        rec.meta["path"] = str(tmp_path / f"walk{k}.csv")
        assert rec.ref is not None
        ar.write_estimate(tmp_path / f"walk{k}-x.csv", rec.t[5:-5:2], rec.ref[5:-5:2])
    for files in (tmp_path / "{stem}-x.csv", {f"walk{k}": tmp_path / f"walk{k}-x.csv" for k in range(2)}):
        own = ar.Finished(files, name="Theirs")
        for est, rec in zip(ar.run_many(own, recs), recs, strict=True):
            assert np.isnan(est.quat[:5]).all()
            assert np.isnan(est.quat[-5:]).all()
            assert rec.ref is not None
            # Every second one is the file's own; between them the rate changes by some rad/s² in 20 ms.
            inner = est.quat[5:-6:2]
            assert np.allclose(np.abs((inner * rec.ref[5:-6:2]).sum(axis=1)), 1.0, rtol=0, atol=1e-12)
            assert ar.metrics.score(est.quat, rec.ref).total < 0.1
    found = ar.sweep(own, [{}], recs)
    assert found.errors.shape == (1, 2)
    assert found.errors.max() < 0.1
    with pytest.raises(ValueError, match="files: expected one for 'walk1', got walk0"):
        ar.run_many(ar.Finished({"walk0": "a.csv"}), recs[1:])


@pytest.mark.parametrize(
    ("thing", "error", "message"),
    [
        (lambda gyr: np.ones((3, 4)), ValueError, r"expected quaternions of shape \(150, 4\), got \(3, 4\)"),
        (lambda gyr: np.full((len(gyr), 4), 9.0), ValueError, "expected quaternions of norm 1, got 18 at row 0"),
        (lambda gyr: gyr / 0 if False else 1 // 0, ZeroDivisionError, "division"),
        (object(), TypeError, "filter|f: expected a filter"),
        (int, TypeError, "f: expected a filter"),
    ],
)
def test_what_is_no_filter_is_told(thing: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        ar.run_many(thing, recordings(1))


def test_errors_are_returned_in_their_recordings_place() -> None:
    def fails(gyr: Any, t: Any) -> Any:
        if t[-1] > 4.0:
            raise RuntimeError("too long")
        return np.tile([1.0, 0.0, 0.0, 0.0], (len(gyr), 1))

    long = ar.simulate.demo(duration=6.0, rate=50.0)
    found = ar.run_many(fails, [*recordings(1), long], errors="return")
    assert isinstance(found[0], ar.Estimate)
    assert isinstance(found[1], RuntimeError)


def test_parameters_are_checked() -> None:
    (rec,) = recordings(1)
    with pytest.raises(
        ValueError, match=r"WholeRecordings has no parameter 'bta' \(did you mean beta\?\); it has beta"
    ):
        ar.sweep(WholeRecordings, {"bta": [1.0]}, [rec])
    with pytest.raises(ValueError, match=r"beta: expected a number in \[0, 5\], got 6"):
        ar.sweep(WholeRecordings, {"beta": [6.0]}, [rec])
    with pytest.raises(
        TypeError, match=r"filter: expected a class of ar.FILTERS, as ar.Madgwick, or a filter of your own"
    ):
        ar.sweep(int, {"beta": [6.0]}, [rec])
    with pytest.raises(ValueError, match="q0: expected None, as Wrapped is no filter of the registry"):
        ar.register(Wrapped)(rate=50.0).run(rec, q0=[1, 0, 0, 0])

    def demanding(gyr: Any, stiffness: float) -> Any:
        raise AssertionError

    with pytest.raises(TypeError, match="stiffness: expected an argument with a default, which is a parameter"):
        ar.register(demanding)


def blocks() -> list[str]:
    return re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def test_the_page_runs_and_so_do_its_commands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.chdir(tmp_path)
    space: dict[str, Any] = {"__name__": "page"}
    for block in blocks():
        exec(compile(block, str(PAGE), "exec"), space)
    assert "Score(" in capsys.readouterr().out
    # A small part of the accelerometer is better than none, and than much of it.
    assert space["found"].best == {"gain": 0.01}
    assert 0.001 <= space["tuned"].params["gain"] <= 0.1
    assert ar.metrics.score(space["estimate"].quat, space["recordings"][0].ref).total < 1e-6
    assert space["f"].params == {"gain": 0.02}
    FILTERS.own.clear()

    (tmp_path / "mine.py").write_text(blocks()[0].split("recordings =")[0], encoding="utf-8")
    commands = re.findall(r"^ahrs-rs (.*)$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(commands) == 2
    shown = output_of(capsys, *commands[0].split())
    rows = {line.split()[0]: line for line in shown.splitlines() if line}
    assert rows["Theirs"].split()[2] == "0.00"
    assert "gain=0.02" in rows["Blend"]
    shown = output_of(capsys, *commands[1].split(), "--points", "3", "--method", "grid")
    assert "gain=" in shown
    output_of(capsys, "run", "walk.npz", "--filter", "mine:Blend", "--outputs", "gravity", "-o", "out.npz")
    with np.load("out.npz") as out:
        assert out["gravity"].shape == (1000, 3)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (":X", "--filter :X: expected MODULE:NAME of a filter, got ValueError"),
        ("broken_text:X", "--filter broken_text:X: expected MODULE:NAME of a filter, got SyntaxError"),
        ("Theirs=", "--filter Theirs=: expected NAME=FILES of finished orientations, got an empty part"),
        ("=walk.csv", "--filter =walk.csv: expected NAME=FILES of finished orientations, got an empty part"),
        ("nowhere_at_all:X", "--filter nowhere_at_all:X: expected MODULE:NAME of a filter, got ModuleNotFoundError"),
        ("math:nothing", "got AttributeError"),
        ("math:pi", "expected a class of ar.FILTERS"),
    ],
)
def test_a_module_without_such_a_filter_is_told(
    name: str, message: str, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "broken_text.py").write_text("def f(:", encoding="utf-8")
    recordings(1)[0].save(tmp_path / "a.npz")
    assert message in error_of(capsys, "run", tmp_path / "a.npz", "--filter", name)


def test_quaternions_keep_the_sign_of_the_row_before() -> None:
    (rec,) = recordings(1)
    assert rec.ref is not None
    flipped = rec.ref * np.where(np.arange(len(rec.ref)) % 3 == 0, -1.0, 1.0)[:, None]
    (est,) = ar.run_many(lambda gyr: flipped, [rec])
    assert ((est.quat[1:] * est.quat[:-1]).sum(axis=1) > 0).all()
    assert np.allclose(_quat.log(_quat.multiply(_quat.conjugate(est.quat), rec.ref)), 0.0, atol=1e-7)
