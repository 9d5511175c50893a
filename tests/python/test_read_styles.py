"""Tables as programs that are public write them are read rightly, or refused with the reason."""

from __future__ import annotations

import re
import warnings
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import ahrs_rs as ar
from _header_styles import STYLES, Style

N, RATE, START = 240, 100.0, 1_700_000_000
DEGREE, GRAVITY = np.pi / 180.0, 9.80665
#: One of the unit in that of the test.
UNITS = {
    "": 1.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "ticks": 1e-4, "dps": DEGREE, "tenth_dps": 0.1 * DEGREE,
    "mrad": 1e-3, "g": GRAVITY, "mg": 1e-3 * GRAVITY, "mG": 0.1, "gauss": 100.0, "unit": 50.0, "tesla": 1e6,
}  # fmt: skip
AXES = {"g": "xyz", "a": "xyz", "m": "xyz", "l": "xyz", "v": "xyz", "q": "wxyz", "r": "wxyz"}


def truth() -> dict[str, NDArray[np.float64]]:
    """What a sensor read that is turned by hand: rad/s, m/s², µT."""
    t = np.arange(N) / RATE
    phase = np.arange(3)
    down = np.stack([0.4 * np.sin(3.0 * t), 0.3 * np.cos(2.0 * t), np.ones(N)], axis=1)
    turn = np.stack([0.3 * np.sin(t), 0.2 * np.cos(t), 0.1 * np.sin(2.0 * t)], axis=1)
    quat = np.concatenate([np.ones((N, 1)), turn], axis=1)
    return {
        "t": t,
        "g": 1.5 * np.sin(4.0 * t[:, None] + phase),
        "a": GRAVITY * down / np.linalg.norm(down, axis=1, keepdims=True),
        "m": 50.0 * np.stack([np.cos(t), np.sin(t), -np.ones(N)], axis=1) / np.sqrt(2.0),
        "l": 0.5 * np.sin(5.0 * t[:, None] + phase),
        "v": GRAVITY * down / np.linalg.norm(down, axis=1, keepdims=True),
        "q": quat / np.linalg.norm(quat, axis=1, keepdims=True),
        "r": quat / np.linalg.norm(quat, axis=1, keepdims=True),
    }


def cells(token: str) -> list[list[str]]:
    """The columns that a word of `Style.columns` stands for."""
    t = truth()["t"]
    micros = np.rint(1e6 * t).astype(np.int64)
    match token:
        case "0":
            return [["0"] * N]
        case "n":
            return [[str(k) for k in range(N)]]
        case "text":
            return [["imu"] * N]
        case "hz":
            return [[f"{RATE:.1f}"] * N]
        case "day":
            return [["14/11/2023"] * N]
        case "clock":
            return [[f"22:13:{20 + m // 1_000_000:02d}.{m % 1_000_000 // 10_000:02d}" for m in micros]]
        case "iso":
            whole = np.datetime64(START, "s").astype("datetime64[us]")
            return [[f"{whole + np.timedelta64(m, 'us')}" for m in micros]]
    name, _, unit = token.partition("/")
    if name[0] == "t":
        shift = 0.3 if name.endswith("+0.3") else 0.0
        start = START if "1970" in name or unit in ("whole", "nanos") else 0
        nanos = start * 10**9 + 1000 * micros + round(1e9 * shift)
        if unit in ("whole", "nanos"):
            return [[str(n // 10**9 if unit == "whole" else n % 10**9) for n in nanos.tolist()]]
        size = round(1e9 * UNITS[unit])
        if size == 10**9:
            return [[f"{n // 10**9}.{n % 10**9:09d}" for n in nanos.tolist()]]
        return [[str(n // size) if n % size == 0 else repr(n / size) for n in nanos.tolist()]]
    labels = AXES[name[0]]
    values = truth()[name[0]] / UNITS[unit]
    return [[f"{value:.9f}" for value in values[:, labels.index(axis)]] for axis in name[1:] or labels]


def table(style: Style) -> str:
    """The table of a style."""
    columns = [column for token in style.columns.split() for column in cells(token)]
    width = len(next(line for line in reversed(style.header.splitlines()) if line.strip()).split(style.separator))
    assert len(columns) == width, "the test's own words say as many columns as the header has"
    rows = (style.separator.join(cell.replace(".", style.decimal) if style.decimal == "," else cell for cell in row)
            for row in zip(*columns, strict=True))  # fmt: skip
    return "\n".join([style.header, *rows]) + "\n"


def read(style: Style, path: Any, **options: Any) -> ar.Recording:
    file = path / style.name
    file.write_text(table(style), encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.DataWarning)
        return ar.read(file, **{**style.options, **options})


RIGHT = [pytest.param(style, id=f"{style.program}, {style.version}: {style.source}"[:80]) for style in STYLES]


def test_there_are_sixty_styles_with_program_version_and_source() -> None:
    known = {(style.program, style.header) for style in STYLES if style.program and style.version and style.source}
    assert len(known) >= 60


@pytest.mark.parametrize("style", RIGHT)
def test_a_table_of_a_public_program_is_read_rightly_or_refused(style: Style, tmp_path: Any) -> None:
    if style.error:
        with pytest.raises(ValueError, match=re.escape(style.error)):
            read(style, tmp_path)
        return
    rec = read(style, tmp_path)
    wanted, tokens = truth(), style.columns.split()
    present = {token[0] for token in tokens if token[0] in "gamlvqr" and token != "text"}
    # Nine decimals in the unit of the table.
    for key, name in {"g": "gyr", "a": "acc", "m": "mag", "r": "ref"}.items():
        values = getattr(rec, name)
        assert (values is not None) == (key in present), name
        if values is not None:
            units = [token.partition("/")[2] for token in tokens if token[0] == key]
            size = 1.0 if units[0] == "unit" else UNITS[units[0]]
            expected = wanted[key] / UNITS["unit"] if units[0] == "unit" else wanted[key]
            np.testing.assert_allclose(values, expected, rtol=0.0, atol=1e-8 * max(size, 1.0), err_msg=name)
    # Stamps are the sensor's; a tenth of a millisecond is what a clock of 1970 in float64 resolves 400 times over.
    resolution = 0.006 if "clock" in tokens else 1e-6
    np.testing.assert_allclose(rec.t - rec.t[0], wanted["t"], rtol=0.0, atol=resolution)
    if "q" in present:
        assert rec.ref is None, "a device's own estimate is no truth"
    if "l" in present:
        np.testing.assert_allclose(rec.streams["linear_acceleration"].values, wanted["l"], rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("style", [p for p in RIGHT if "units" in p.values[0].options and not p.values[0].error])
def test_a_unit_that_no_header_tells_is_refused_or_told_of(style: Style, tmp_path: Any) -> None:
    (tmp_path / style.name).write_text(table(style), encoding="utf-8")
    options = {key: value for key, value in style.options.items() if key != "units"}
    refusal = ""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            rec = ar.read(tmp_path / style.name, **options)
        except ValueError as error:
            refusal = str(error)
    if refusal:
        assert "units={" in refusal, "the refusal names the option that settles it"
    else:
        assert rec.meta["assumed_units"]
        assert [one.category for one in caught] == [ar.DataWarning]
