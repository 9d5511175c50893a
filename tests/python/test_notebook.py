"""What notebooks show of objects: short tables, escaped, without scripts."""

from __future__ import annotations

import dataclasses
import re
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar

EVIL = "<script>alert('x')</script>&\n\x1b[2J"


class Tags(HTMLParser):
    """The tags and the text of a fragment; every tag that is opened is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.open: list[str] = []
        self.text = ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.tags.add(tag)
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def shown(value: Any) -> str:
    text = value._repr_html_()
    found = Tags(text)
    assert found.tags <= {"table", "caption", "b", "tr", "td", "th", "p"}
    assert len(text) < 20_000
    assert not re.search(r"[\x00-\x09\x0b-\x1f]", text)
    return found.text


def recording(**changes: Any) -> ar.Recording:
    return dataclasses.replace(ar.simulate.demo(duration=30.0), **changes)


def test_a_recording_tells_its_sensors_and_what_is_missing() -> None:
    mag = recording().mag.copy()
    mag[:5] = np.nan
    gyr = recording().gyr.copy()
    gyr[:7] = np.nan
    text = shown(recording(mag=mag, gyr=gyr, meta={"path": f"/a/{EVIL}", "repairs": [EVIL]}))
    for expected in ("3000, 29.99 s, 100 Hz", "2993 readings, 7 rows missing", "2995 readings", "alert('x')"):
        assert expected in text
    own = ar.Recording.from_streams(
        gyr=(np.arange(100) / 100, np.zeros((100, 3))), acc=(np.arange(50) / 50, np.ones((50, 3)))
    )
    assert "50 readings, 50 Hz" in shown(own)
    assert "0 readings" in shown(recording()[:0])


def test_an_estimate_tells_its_end_and_its_flags() -> None:
    est = ar.MEKF().run(recording(), outputs=("covariance",))
    text = shown(est)
    roll = est.euler(degrees=True)[-1, 0]
    assert f"roll {roll:.1f}°" in text
    share = 100.0 * np.count_nonzero(est.status & ar.Status.REST) / len(est)
    assert f"REST {share:.3g} %" in text
    assert "covariance" in text
    assert "no flag at any sample" in shown(ar.Madgwick().run(recording()[:50]))
    several = ar.VQF(rate=100.0).run(np.zeros((3, 9, 3)), np.ones((3, 9, 3)))
    assert "at the end of the first" in shown(several)
    shown(ar.VQF(rate=100.0).run(np.zeros((0, 3)), np.zeros((0, 3))))
    shown(ar.VQF(rate=100.0).run(np.zeros((0, 4, 3)), np.zeros((0, 4, 3))))


@pytest.mark.parametrize("name", ar.FILTERS)
def test_a_filter_tells_its_parameters_and_what_was_changed(name: str) -> None:
    cls = ar.FILTERS[name]
    text = shown(cls(frame="NED"))
    assert text.startswith(f"\n{name}")
    assert "NED" in text
    for key in cls.PARAMS:
        assert key in text
    numbers = [key for key, param in cls.PARAMS.items() if param.range is not None]
    if numbers:
        key, param = numbers[0], cls.PARAMS[numbers[0]]
        changed = shown(cls(**{key: param.range[0]}))
        assert ("default" in changed) == (param.range[0] != param.default)


def test_a_report_tells_what_is_not_right() -> None:
    report = ar.check(recording(acc=recording().acc / 9.80665))
    text = shown(report)
    worst = report.of("error")
    assert worst
    for one in worst:
        assert one.code in text
    assert f"{len(report.of('ok'))} more are ok." in text


def test_fits_sweeps_and_calibrations_tell_their_numbers() -> None:
    x = np.random.default_rng(0).standard_normal((800, 3))
    x = 48.0 * x / np.linalg.norm(x, axis=1, keepdims=True) + [12.0, -3.0, 5.0]
    fit = ar.calibration.magnetometer(x)
    assert "b_x12 ±" in shown(fit)
    text = shown(ar.calibration.Calibrations(mag=fit.calibration, acc=ar.calibration.Calibration.identity()))
    assert text.index("acc") < text.index("mag")
    assert "12  -3  5" in text
    assert shown(ar.calibration.Calibrations()) == "No sensor is calibrated."
    evil = ar.calibration.Calibration(np.eye(3), np.zeros(3), {EVIL: EVIL})
    assert "alert" in shown(evil)
    lines = ar.calibration.TemperatureCalibration(np.zeros(3), np.ones(3), np.full(3, 0.01), np.zeros(3), (10.0, 40.0))
    assert "10 to 40 °C" in shown(lines)
    held = [sign * 9.80665 * np.eye(3)[axis][None] + 0.1 for axis in range(3) for sign in (1, -1)]
    assert "bias 0.1 m/s²" in shown(ar.calibration.six_positions(held))
    assert "bias 0.01 ±" in shown(ar.calibration.gyroscope(np.full((500, 3), 0.01)))
    allan = ar.calibration.allan(np.random.default_rng(0).standard_normal(10000), 100.0)
    assert f"random walk{allan.random_walk.value:.4g} rad/s/√Hz" in shown(allan)
    assert f"rate random walk{allan.rate_random_walk.reason}" in shown(allan)
    errors = np.array([[2.0], [1.0]])
    found = ar.Sweep("Madgwick", [{"beta": 0.1}, {"beta": 0.2}], "total", errors, errors > 0)
    assert "beta=0.2: 1 (total)" in shown(found)
