"""The page that plays recordings: what it holds, and what a browser makes of it."""

from __future__ import annotations

import base64
import dataclasses
import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import _quat
from commands import Capture, error_of, output_of, saved, without

pytest.importorskip("plotly")

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
BROWSER = next(filter(None, map(shutil.which, BROWSERS)), None)
needs_browser = pytest.mark.skipif(BROWSER is None, reason="no browser (make browser installs chromium)")


def scenes(page: str) -> list[dict[str, Any]]:
    found = re.search(r'<script type="application/json" id="scenes">(.*?)</script>', page, flags=re.DOTALL)
    assert found is not None
    made: list[dict[str, Any]] = json.loads(found[1])
    return made


def numbers(text: str, dtype: str, columns: int = 0) -> np.ndarray:
    array = np.frombuffer(base64.b64decode(text), dtype=dtype)
    return array.reshape(-1, columns) if columns else array


@pytest.fixture(scope="module")
def rec() -> ar.Recording:
    return ar.simulate.demo(duration=10.0)


def test_frames_are_the_orientations_and_readings(rec: ar.Recording) -> None:
    est = ar.VQF(rate=100.0).run(rec)
    (scene,) = scenes(ar.view(rec, {"vqf": est, "other": ar.Madgwick().run(rec)}).to_html())
    rows = np.searchsorted(rec.t, numbers(scene["t"], "<f4") + rec.t[0] - 1e-5)
    assert len(rows) == pytest.approx(601, abs=2), "60 of 100 frames a second"
    assert [body["name"] for body in scene["bodies"]] == ["vqf", "other", "reference"]
    assert [body["reference"] for body in scene["bodies"]] == [False, False, True]
    # Whole numbers of 16 bits: half of one of them.
    for body, quat in zip(scene["bodies"][::2], (est.quat, rec.ref), strict=True):
        assert np.abs(numbers(body["quat"], "<i2", 4) / 32767 - quat[rows]).max() <= 0.5 / 32767 + 1e-12
    for sensor, values in (("acc", rec.acc), ("mag", rec.mag)):
        scale = scene[sensor]["scale"]
        error = numbers(scene[sensor]["values"], "<i2", 3) / 32767 * scale - values[rows]
        assert np.abs(error).max() <= 0.5 * scale / 32767 + 1e-12
    assert np.array_equal(numbers(scene["status"][0]["bits"], "<u2"), est.status[rows])


def test_angles_are_those_of_the_estimate_in_its_own_frame(rec: ar.Recording) -> None:
    est = ar.VQF(rate=100.0, frame="NED").run(rec)
    (scene,) = scenes(ar.view(rec, est).to_html())
    yaw = scene["bodies"][0]["angles"]["yaw"]
    x, y = numbers(yaw["x"], "<f4"), numbers(yaw["y"], "<f4")
    known = ~np.isnan(y)
    # float32 of up to 180°.
    assert np.abs(y[known] - est.euler(degrees=True)[:, 2]).max() < 1e-5
    assert np.abs(x[known] - rec.t).max() < 1e-5
    assert scene["frame"] == "NED"


@pytest.mark.parametrize(
    ("frame", "matrix"),
    [("NED", [[0, 1, 0], [1, 0, 0], [0, 0, -1]]), ("NWU", [[0, -1, 0], [1, 0, 0], [0, 0, 1]])],
)
def test_every_earth_frame_is_played_in_east_north_up(frame: str, matrix: Any, rec: ar.Recording) -> None:
    est = ar.VQF(rate=100.0).run(rec)
    # By the matrix from the frame to east-north-up: R_frame = Mᵀ R_enu.
    from scipy.spatial.transform import Rotation

    turned = Rotation.from_matrix(np.asarray(matrix, dtype=float).T @ est.matrix())
    other = dataclasses.replace(est, quat=turned.as_quat(scalar_first=True), frame=frame)
    truth = dataclasses.replace(rec, meta={"ref_frame": "ENU"})
    (scene,) = scenes(ar.view(truth, {"a": other, "b": est}).to_html())
    a, b = (numbers(body["quat"], "<i2", 4) / 32767 for body in scene["bodies"][:2])
    # q and -q are one orientation; 16 bits are 6e-5 rad.
    assert np.abs(_quat.log(_quat.multiply(_quat.conjugate(a), b))).max() < 2e-4
    # Angles of all are in the frame of the first.
    roll = numbers(scene["bodies"][1]["angles"]["roll"]["y"], "<f4")
    expected = np.degrees(ar.metrics.euler(other.quat))[:, 0]
    assert np.abs(roll[~np.isnan(roll)] - expected).max() < 1e-3


def test_gaps_and_what_is_missing_stay_so(rec: ar.Recording) -> None:
    gyr, ref, acc = rec.gyr.copy(), rec.ref.copy(), rec.acc.copy()
    gyr[300:400] = np.nan
    ref[:100] = np.nan
    acc[500:] = np.nan
    keep = (rec.t < 7.0) | (rec.t > 8.0)
    made = dataclasses.replace(rec, gyr=gyr, ref=ref, acc=acc)
    cut = ar.Recording(**{name: getattr(made, name)[keep] for name in ("t", "gyr", "acc", "mag", "ref")})
    (scene,) = scenes(ar.view(cut, {"vqf": ar.VQF().run(cut)}).to_html())
    assert np.allclose(scene["gaps"], [[3.0, 4.0], [6.99, 8.01]], rtol=0, atol=1e-9)
    t = numbers(scene["t"], "<f4")
    unknown = (numbers(scene["bodies"][1]["quat"], "<i2", 4) == 0).all(axis=1)
    assert np.array_equal(unknown, t < 1.0 - 1e-6)
    # The last reading is held for half a second.
    missing = numbers(scene["acc"]["values"], "<i2", 3)[:, 0] == -32768
    assert t[missing].min() == pytest.approx(5.5, abs=0.02)
    yaw = scene["bodies"][0]["angles"]["yaw"]
    x, y = numbers(yaw["x"], "<f4"), numbers(yaw["y"], "<f4")
    assert np.isnan(y[(x > 7.0) & (x < 8.0)]).all()
    assert ((x > 7.0) & (x < 8.0)).sum() == 1


def test_flags_that_flicker_are_told_in_few_spans() -> None:
    rec = ar.simulate.demo(duration=60.0)
    est = ar.Madgwick().run(rec)
    status = np.where(np.arange(len(est)) % 2, ar.Status.MAG_MISSING, 0).astype(np.uint16)
    (scene,) = scenes(ar.view(rec, dataclasses.replace(est, status=status)).to_html())
    ((begin, end),) = scene["status"][0]["spans"]["MAG_MISSING"]
    assert (begin, end) == pytest.approx((0.01, 60.0), abs=0.011)


def test_an_hour_is_below_30_megabytes_and_keeps_its_extremes() -> None:
    count = 3600 * 200
    t = np.arange(count) / 200.0
    half = 0.4 * np.sin(0.3 * t)
    half[400_001] = 1.2  # one sample
    quat = np.stack([np.cos(half), np.sin(half), 0 * t, 0 * t], axis=1)
    rec = ar.Recording(t=t, acc=np.ones((count, 3)), mag=np.ones((count, 3)), ref=quat)
    est = ar.Tilt(rate=200.0).run(None, rec.acc[:2])
    both = {
        name: dataclasses.replace(est, quat=quat, status=np.zeros(count, dtype=np.uint16), t=t) for name in ("a", "b")
    }
    page = ar.view(rec, both).to_html()
    assert len(page) < 30e6
    (scene,) = scenes(page)
    assert scene["note"].startswith("720000 rows at 200 Hz: 120000 of them are played, lines have the extremes")
    roll = numbers(scene["bodies"][0]["angles"]["roll"]["y"], "<f4")
    assert len(roll) <= 12_000
    assert roll.max() == pytest.approx(np.degrees(2.4), rel=1e-6)


def test_names_are_escaped_and_nothing_is_loaded(rec: ar.Recording) -> None:
    evil = "</script><script>alert(1)</script>%%PLAYER%%"
    named = dataclasses.replace(rec, meta={"path": f"x{evil}"})
    page = ar.view(named, {evil: ar.Madgwick().run(rec)}, title=evil).to_html()
    assert "<script>alert(1)" not in page
    assert page.count("function drawBoard") == 1
    assert not re.search(r"<(?:script|link|img)[^>]*(?:src|href)=", page)
    assert scenes(page)[0]["bodies"][0]["name"] == evil
    shown = ar.view(rec)._repr_html_()
    assert shown.startswith("<iframe srcdoc=")
    assert shown.count("<") == 2
    assert 'sandbox="allow-scripts"' in shown


def test_several_recordings_are_one_page(rec: ar.Recording) -> None:
    both = ar.view(rec, title="first") + ar.view(rec[:200], title="second")
    assert [scene["name"] for scene in scenes(both.to_html())] == ["first", "second"]
    assert both.title == "first, second"
    with pytest.raises(TypeError):
        both + 1  # type: ignore[operator]


@pytest.mark.parametrize("count", [1, 2])
def test_short_recordings_are_played(count: int, rec: ar.Recording) -> None:
    (scene,) = scenes(ar.view(rec[:count], ar.VQF(rate=100.0).run(rec[:count])).to_html())
    assert len(numbers(scene["t"], "<f4")) == count


def test_what_cannot_be_played_is_told(rec: ar.Recording) -> None:
    est = ar.Madgwick().run(rec)
    with pytest.raises(ValueError, match="recording: expected at least one sample, got none"):
        ar.view(rec[:0], est)
    with pytest.raises(ValueError, match="estimates: expected at least one, as the recording has no reference"):
        ar.view(dataclasses.replace(rec, ref=None))
    with pytest.raises(ValueError, match=r"estimates: expected shape \(900, 4\) of 'estimate', got \(1000, 4\)"):
        ar.view(rec[:900], est)
    with pytest.raises(ValueError, match="estimates: expected an Estimate of 'a', got ndarray"):
        ar.view(rec, {"a": rec.ref})


def test_the_command_writes_a_page_of_all_files(tmp_path: Path, capsys: Capture) -> None:
    files = [saved(tmp_path / "a.npz", 0), saved(tmp_path / "b.npz", 1)]
    page = tmp_path / "page.html"
    out = output_of(capsys, "view", *files, "--filter", "vqf,Madgwick", "-o", page)
    assert f"wrote      {page} (" in out
    found = scenes(page.read_text(encoding="utf-8"))
    assert [scene["name"] for scene in found] == ["a.npz", "b.npz"]
    assert [body["name"] for body in found[0]["bodies"]] == ["VQF", "Madgwick", "reference"]


def test_mistakes_of_the_command_are_told(tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    file = saved(tmp_path / "a.npz")
    assert "did you mean Madgwick?" in error_of(capsys, "view", file, "--filter", "madgwik", "-o", tmp_path / "a.html")
    assert error_of(capsys, "view", file, "--filter", ",") == "--filter: expected names like vqf,madgwick"
    said = error_of(capsys, "view", file, "--filter", "vqf", "-o", tmp_path / "a.png")
    assert said == "-o: expected a name that ends in .html, got 'a.png'"
    without(monkeypatch, "plotly")
    said = error_of(capsys, "view", file, "--filter", "vqf", "-o", tmp_path / "a.html")
    assert said == "the page needs plotly: pip install ahrs-rs[view]"
    assert not (tmp_path / "a.html").exists()


def told(page: Path, hash: str) -> dict[str, str]:
    """What the page says of itself in a browser, and what its console says."""
    assert BROWSER is not None
    command = [
        BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
        f"--user-data-dir={page.parent / 'profile'}", "--virtual-time-budget=10000", "--enable-logging=stderr",
        "--window-size=1200,1150", "--dump-dom", f"{page.as_uri()}#{hash}",
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    tag = re.search(r"<html[^>]*>", done.stdout)
    assert tag is not None
    console = [
        line for line in done.stderr.splitlines() if "CONSOLE" in line and re.search("error|Uncaught", line, re.I)
    ]
    containers = str(len(re.findall(r'<div class="plot-container plotly"', done.stdout)))
    return dict(re.findall(r'data-(\w+)="([^"]*)"', tag[0])) | {"console": "".join(console), "containers": containers}


@needs_browser
def test_a_browser_plays_the_page(tmp_path: Path, rec: ar.Recording) -> None:
    gyr = rec.gyr.copy()
    gyr[500:700] = np.nan
    made = dataclasses.replace(rec, gyr=gyr)
    page = tmp_path / "page.html"
    ar.view(made, {"vqf": ar.VQF().run(made), "madgwick": ar.Madgwick().run(made)}).save(page)
    played = told(page, "play=1")
    assert (played.get("errors"), played["console"], played["containers"]) == (None, "", "1")
    assert int(played["drawn"]) >= 9, "three angles of three orientations, and status"
    assert float(played["now"]) > 1.0, "time goes on"
    assert int(played["frames"]) > 2
    there = told(page, "at=6")
    assert (there["now"], there["gap"], there["console"]) == ("6.000", "1", "")
