"""The five papers: that tables, report and command say what the studies found, and that every plot is drawn."""

from __future__ import annotations

import csv
import html
import json
import math
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import papers
from ahrs_rs.papers import STUDIES, Claim, Plot, Study, Table, Verdict, _parikh2021
from ahrs_rs.papers._report import write_report
from ahrs_rs.papers._study import band, boxes, lines, radar
from ahrs_rs.papers._text import claims, claims_with_numbers, comma_separated, markdown, plain
from commands import Capture, error_of, output_of, without

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
BROWSER = next(filter(None, map(shutil.which, BROWSERS)), None)


@pytest.fixture(scope="module")
def studies() -> dict[str, Study]:
    """All of them, simulated."""
    return {name: papers.study(name) for name in STUDIES}


def made_up() -> Study:
    """A study with everything that there is, and with what could break a page."""
    t = np.linspace(0.0, 1.0, 5000)
    curve = lines("Curves", t, {"sine": np.sin(t), "unknown": np.where(t > 0.5, np.nan, t)}, "time [s]", "angle [°]")
    spokes = {"EKF": [1.0, 0.0, 3.0], "Mahony": [2.0, 0.0, 1.0]}
    times = Table(
        "Times", ["method", "ours [ns]", "relative"], [["EKF", 123.0, 1.5]], measured=True, local=["ours [ns]"]
    )
    return Study(
        name="made_up",
        title="An <author>: a title & more",
        protocol="First </script> paragraph.\n\nSecond paragraph.",
        tables=[
            Table("Errors", ["method", "paper", "ours"], [["EKF", 1.0, 0.123456], ["Other", None, math.nan]]),
            times,
        ],
        claims=[
            Claim("It is so", Verdict(True, "EKF 1°"), None),
            Claim("Or not", Verdict(False, "x"), Verdict(True, "y")),
        ],
        plots=[
            curve,
            band(curve, "area", t, t - 1.0, t + 1.0),
            boxes("Boxes", {"EKF": ar.metrics.box(np.arange(10.0)), "Mahony": ar.metrics.box(np.ones(3))}, "error [°]"),
            radar("Spider </script>", ["RMSE", "MAD", "GAE"], spokes),
        ],
    )


def test_a_table_is_the_same_in_every_form() -> None:
    errors, times = made_up().tables
    assert plain(errors).splitlines()[2:] == ["method  paper  ours", "EKF      1.00  0.12", "Other       –     –"]
    assert "| EKF | 1.00 | 0.12 |\n| Other | – | – |" in markdown(errors)
    rows = list(csv.reader(comma_separated(errors).splitlines()))
    assert rows == [["method", "paper", "ours"], ["EKF", "1.0", "0.123456"], ["Other", "", "nan"]]
    # What is of this machine only stays out of documents.
    assert "123" in plain(times)
    assert "123" not in markdown(times)


def test_the_table_of_claims_says_which_hold() -> None:
    assert claims([made_up()]).rows == [
        ["made_up", "It is so", "holds", "–"],
        ["made_up", "Or not", "does not hold", "holds"],
    ]


def test_curves_are_thinned_and_what_is_unknown_is_left_out() -> None:
    plot = made_up().plots[0]
    for trace in plot.data:
        assert len(trace["x"]) == len(trace["y"]) <= 1500
    assert plot.data[1]["y"][-1] is None
    json.dumps([dict(trace) for trace in plot.data], allow_nan=False)


def test_spokes_of_a_spider_chart_are_scaled_by_the_largest() -> None:
    plot = radar("", ["a", "unknown", "b"], {"EKF": [1.0, math.nan, 0.0], "Mahony": [4.0, math.nan, 0.0]})
    assert [trace["r"] for trace in plot.data] == [[0.25, 0.0, 0.25], [1.0, 0.0, 1.0]]
    assert all(trace["theta"] == ["a", "b", "a"] for trace in plot.data)


def test_the_report_is_one_file_and_has_every_table(tmp_path: Path) -> None:
    written = write_report([made_up()], tmp_path / "out", seed=7, recordings=["a.hdf5"])
    assert [path.name for path in written] == ["report.html", "made_up_1.csv", "made_up_2.csv", "claims.csv"]
    page = written[0].read_text(encoding="utf-8")
    assert not re.search(r"<(?:script|link|img)[^>]*(?:src|href)=", page)
    text = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    for expected in ("An <author>: a title & more", "First </script> paragraph.", "Times (measured)"):
        assert html.escape(expected) in text
    assert "a.hdf5" in text
    figures = re.search(r'id="figures">(.*?)</script>', page, flags=re.DOTALL)
    assert figures is not None
    assert len(json.loads(figures[1])) == 4
    # Once more: the same bytes.
    write_report([made_up()], tmp_path / "again", seed=7, recordings=["a.hdf5"])
    for path in written:
        assert (tmp_path / "again" / path.name).read_bytes() == path.read_bytes()


def drawn(page: Path) -> dict[str, Any]:
    """What a browser makes of the report: how many plots there are and were drawn, what went wrong, and the page."""
    assert BROWSER is not None
    command = [
        BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
        f"--user-data-dir={page.parent / 'profile'}", "--virtual-time-budget=60000", "--enable-logging=stderr",
        f"--screenshot={page.parent / 'report.png'}", "--window-size=1200,2000", "--dump-dom", page.as_uri(),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    tag = re.search(r"<html[^>]*>", done.stdout)
    assert tag is not None
    told = dict(re.findall(r'data-(\w+)="([^"]*)"', tag[0]))
    console = [
        line for line in done.stderr.splitlines() if "CONSOLE" in line and re.search("error|Uncaught", line, re.I)
    ]
    # What plotly puts into the page where it has drawn.
    containers = len(re.findall(r'<div class="plot-container plotly"', done.stdout))
    return {"plots": int(told["plots"]), "drawn": int(told["drawn"]), "containers": containers,
            "errors": [*filter(None, [told.get("errors")]), *console]}  # fmt: skip


needs_browser = pytest.mark.skipif(BROWSER is None, reason="no browser (make browser installs chromium)")


@needs_browser
def test_a_browser_draws_every_kind_of_plot(tmp_path: Path) -> None:
    (report, *_) = write_report([made_up()], tmp_path, seed=0, recordings=[])
    assert drawn(report) == {"plots": 4, "drawn": 4, "containers": 4, "errors": []}


@needs_browser
def test_a_browser_draws_every_plot_of_the_papers(studies: dict[str, Study], tmp_path: Path) -> None:
    (report, *_) = write_report(list(studies.values()), tmp_path, seed=0, recordings=[])
    count = sum(len(one.plots) for one in studies.values())
    assert count > 20
    assert drawn(report) == {"plots": count, "drawn": count, "containers": count, "errors": []}
    assert (tmp_path / "report.png").stat().st_size > 10_000


@needs_browser
def test_a_page_that_goes_wrong_is_seen(tmp_path: Path) -> None:
    study = made_up()
    broken = Study(
        study.name, study.title, study.protocol, [], [], [Plot("Broken", [{"type": "scatter"}], {"xaxis": 3})]
    )
    (report, *_) = write_report([broken], tmp_path, seed=0, recordings=[])
    text = report.read_text(encoding="utf-8").replace("figures.forEach", "nothing.forEach")
    report.write_text(text, encoding="utf-8")
    found = drawn(report)
    assert found["errors"]
    assert found["drawn"] == 0


@pytest.mark.parametrize("name", STUDIES)
def test_every_study_has_the_published_numbers_beside_ours_and_claims(name: str, studies: dict[str, Study]) -> None:
    study = studies[name]
    assert study.name == name
    assert len(study.claims) >= 7
    assert all(claim.simulated is not None and claim.real is None for claim in study.claims)
    assert any("paper" in column for table in study.tables for column in table.columns)
    for table in study.tables:
        assert all(len(row) == len(table.columns) for row in table.rows)
        numbers = [cell for row in table.rows for cell in row if isinstance(cell, float)]
        assert numbers
        assert not any(math.isinf(number) for number in numbers)
    assert study.plots


def test_a_study_gives_the_same_numbers_for_the_same_seed_and_others_for_another(studies: dict[str, Study]) -> None:
    def tables(study: Study) -> list[str]:
        return [comma_separated(table) for table in study.tables if not table.measured]

    again, other = papers.study("cocoli2023"), papers.study("cocoli2023", seed=99)
    assert tables(again) == tables(studies["cocoli2023"])
    assert tables(other) != tables(again)
    # Times stand in the measured tables only: the numbers behind the claims are the same too.
    assert comma_separated(claims_with_numbers([again])) == comma_separated(
        claims_with_numbers([studies["cocoli2023"]])
    )
    measured = [table.title for study in studies.values() for table in study.tables if table.measured]
    assert len(measured) == 4  # all papers but Hyyti's have a table of times


def test_what_the_papers_and_the_simulation_agree_on(studies: dict[str, Study]) -> None:
    """Conclusions that follow from how the filters are made, and so hold for every seed."""
    holds = {(study.name, claim.text): claim.simulated for study in studies.values() for claim in study.claims}
    for key in (
        ("hyyti2015", "Only DCM-IMU finds a gyroscope's bias"),
        ("hyyti2015", "Without rotation the vertical bias is not found"),
        ("hyyti2015", "DCM-IMU is the most robust against acceleration"),
        ("cocoli2023", "At rest the matrix method oscillates most"),
        ("parikh2021", "The complementary filter suppresses it least"),
        ("cirillo2014", "The EKF is the slowest"),
    ):
        verdict = holds[key]
        assert verdict is not None
        assert verdict.holds, (key, verdict.numbers)


def test_a_real_recording_is_judged_too(broad: list[ar.Recording]) -> None:
    short = [one[4000:13000] for one in broad]
    study = papers.study("cocoli2023", short)
    assert all(claim.real is not None for claim in study.claims)
    real = [row[3] for row in study.tables[0].rows]
    assert all(isinstance(cell, float) and cell > 0.0 for cell in real)


def test_adaptive_gains_are_studied_where_the_filters_have_a_threshold(monkeypatch: pytest.MonkeyPatch) -> None:
    """The paper's future work, tried with another parameter of a filter in the threshold's place."""
    cases = {name: group[:1] for name, group in _parikh2021.simulated_cases(0).items()}
    params = {"Madgwick": {"beta": 0.01}}
    if not _parikh2021.adaptive():
        assert _parikh2021.threshold_gains(params, cases, {}, {}) == ([], [])
        monkeypatch.setattr(_parikh2021, "ADAPTIVE", "zeta")
    (table,), (claim,) = _parikh2021.threshold_gains(params, cases, {}, {})
    assert len(table.rows) == len(cases) * len(_parikh2021.adaptive())
    assert claim.simulated is not None
    assert claim.real is None
    again = _parikh2021.threshold_gains(params, cases, params, cases)
    assert len(again[0][0].rows) == 2 * len(table.rows)
    assert again[1][0].real == claim.simulated


def test_the_bias_variances_are_where_the_study_looks_for_them() -> None:
    """Fig 10 reads the state's variables; three initial deviations would be one and the same elsewhere."""
    from ahrs_rs.papers._hyyti2015 import VARIANCES

    f = ar.FILTERS["DcmImu"](rate=100.0, **{"initial_bias": 0.123})
    f.update([0.0, 0.0, 0.0], [0.0, 0.0, 9.8])
    found = [place for place, value in enumerate(f.state().variables) if math.isclose(value, 0.123**2, rel_tol=1e-6)]
    assert tuple(found) == VARIANCES


def test_the_command_prints_the_claims_and_writes_the_report(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("AHRS_RS_DATA", raising=False)
    out = tmp_path / "report"
    shown = output_of(capsys, "papers", "cocoli2023", "--out", out, "--seed", 3)
    assert "cocoli2023  Mahony is the fastest" in shown
    assert shown.index("Oscillation at rest") < shown.index("Claims")
    assert f"wrote {out / 'report.html'} and 5 tables beside it" in shown
    assert sorted(path.name for path in out.iterdir()) == [
        "claims.csv", *(f"cocoli2023_{number}.csv" for number in range(1, 5)), "report.html"
    ]  # fmt: skip


def test_mistakes_of_the_command_are_told(tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "unknown paper 'kalman1960'; there are cirillo2014" in error_of(capsys, "papers", "kalman1960")
    assert "--data: " in error_of(capsys, "papers", "--data", tmp_path / "absent")
    assert "has no recording of BROAD" in error_of(capsys, "papers", "--data", tmp_path)
    (tmp_path / "file").write_text("")
    assert "is not a directory" in error_of(capsys, "papers", "--out", tmp_path / "file")
    assert "there is no directory" in error_of(capsys, "papers", "--out", tmp_path / "a" / "b")
    without(monkeypatch, "plotly")
    assert "pip install ahrs-rs[papers]" in error_of(capsys, "papers", "--out", tmp_path / "new")
    assert not (tmp_path / "new").exists()
    with pytest.raises(ValueError, match="name: expected one of cirillo2014"):
        papers.study("kalman1960")
