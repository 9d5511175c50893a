"""Whatever the names, units, order, separators and gaps of a table: the same readings come out."""

from __future__ import annotations

import warnings
from io import BytesIO
from typing import Any

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import ahrs_rs as ar

G, DEGREE = 9.80665, np.pi / 180.0
UNITS: dict[str, dict[str, float]] = {
    "t": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "sec": 1.0, "µs": 1e-6},
    "gyr": {"rad/s": 1.0, "deg/s": DEGREE, "°/s": DEGREE, "dps": DEGREE, "rad s^-1": 1.0, "mrad/s": 1e-3},
    "acc": {"m/s2": 1.0, "m/s^2": 1.0, "m s-2": 1.0, "g": G, "mg": 1e-3 * G, "m/s²": 1.0},
    "mag": {"uT": 1.0, "µT": 1.0, "mG": 0.1, "gauss": 100.0, "nT": 1e-3, "T": 1e6},
}
NAMES: dict[str, list[str]] = {
    "t": ["t", "time", "Timestamp", "sample time", "elapsed"],
    "gyr": ["gyr_{}", "Gyroscope {}", "gyro{}", "angular_velocity.{}", "omega_{}", "imu_gyro_{}", "w{}", "Gyr{}"],
    "acc": ["acc_{}", "Accelerometer {}", "accel{}", "specific_force.{}", "ACC_{}", "imu_acc_{}", "a{}", "Acc{}"],
    "mag": ["mag_{}", "Magnetometer {}", "magn{}", "magnetic_field.{}", "MAG_{}", "imu_mag_{}", "m{}", "Mag{}"],
}
BRACKETS = [" ({})", " [{}]", "({})"]
EXTRAS = ["battery", "packet counter", "latitude", "label id", "roll (deg)", "heart_rate", "acc_bias_x (m/s2)"]


def readings(n: int, seed: int) -> dict[str, NDArray[np.float64]]:
    rng = np.random.default_rng(seed)
    gravity = rng.normal(size=3)
    return {
        "t": np.arange(n) / 100.0,
        "gyr": rng.normal(0.0, 1.0, (n, 3)),
        "acc": G * gravity / np.linalg.norm(gravity) + rng.normal(0.0, 0.3, (n, 3)),
        "mag": np.array([20.0, 0.0, -45.0]) + rng.normal(0.0, 1.0, (n, 3)),
    }


@st.composite
def tables(draw: st.DrawFn) -> tuple[str, dict[str, NDArray[np.float64]], dict[str, float]]:
    """A table, its readings, and the size of a digit of each in SI units."""
    n = draw(st.integers(12, 60))
    truth = readings(n, draw(st.integers(0, 2**31)))
    present = ["t", "gyr", *draw(st.sampled_from([["acc"], ["acc", "mag"], ["mag"], []]))]
    separator, decimal = draw(
        st.sampled_from([(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), ("|", ".")])
    )
    bracket = draw(st.sampled_from(BRACKETS))
    columns: list[tuple[str, list[str]]] = []
    resolution = {}
    for quantity in present:
        unit, size = draw(st.sampled_from(sorted(UNITS[quantity].items())))
        resolution[quantity] = 1e-8 * size
        name = draw(st.sampled_from(NAMES[quantity])) + bracket.format(unit)
        values = truth[quantity]
        if quantity != "t":  # cells without a value, and whole rows of them: readings that were lost
            lost = np.random.default_rng(n).random(values.shape) < draw(st.sampled_from([0.0, 0.1]))
            lost[draw(st.integers(0, n - 1))] |= draw(st.booleans())
            values = truth[quantity] = np.where(lost, np.nan, values)
        upper = draw(st.booleans())
        for k in range(1 if values.ndim == 1 else 3):
            column = values if values.ndim == 1 else values[:, k]
            axis = "xyz"[k].upper() if upper else "xyz"[k]
            empty = draw(st.sampled_from(["", "nan", "NaN", "NA"]))
            cells = [empty if np.isnan(one) else f"{one / size:.8f}".replace(".", decimal) for one in column]
            columns.append((name.format(axis), cells))
    for extra in draw(st.lists(st.sampled_from(EXTRAS), unique=True, max_size=3)):
        columns.append((extra, [str(k % 7) for k in range(n)]))
    order = draw(st.permutations(range(len(columns))))
    quote = draw(st.sampled_from(["", '"']))
    lines = [separator.join(f"{quote}{columns[k][0]}{quote}" for k in order)]
    lines += [separator.join(columns[k][1][row] for k in order) for row in range(n)]
    end = draw(st.sampled_from(["\n", "\r\n"]))
    preamble = draw(st.sampled_from(["", "# made by a test\n", f"sep={separator}\n"]))
    return preamble + end.join(lines) + end, {name: truth[name] for name in present}, resolution


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large], max_examples=150)
@given(tables())
def test_a_table_is_read_whatever_its_names_units_order_and_separators(
    drawn: tuple[str, dict[str, NDArray[np.float64]], dict[str, float]],
) -> None:
    text, truth, resolution = drawn
    rec = read(text)
    np.testing.assert_allclose(rec.t - rec.t[0], truth["t"], rtol=0.0, atol=max(1e-9, resolution["t"]))
    for name in ("gyr", "acc", "mag"):
        values = getattr(rec, name)
        if name not in truth or np.isnan(truth[name]).all():
            assert values is None or np.isnan(values).all()
        else:
            np.testing.assert_allclose(values, truth[name], rtol=1e-12, atol=resolution[name], err_msg=text[:300])


def read(text: str, **options: Any) -> ar.Recording:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.DataWarning)
        return ar.read(BytesIO(text.encode()), **options)


@settings(deadline=None, max_examples=40)
@given(
    bits=st.sampled_from([16, 32]),
    before=st.integers(1, 60),
    lost=st.lists(st.integers(1, 118), max_size=10, unique=True),
)
def test_a_counter_of_time_that_wraps_goes_on(bits: int, before: int, lost: list[int]) -> None:
    """Milliseconds in 16 bits, microseconds in 32: they start again from zero in the recording."""
    unit, size = ("ms", 1e-3) if bits == 16 else ("us", 1e-6)
    step = 10 if bits == 16 else 10_000
    kept = np.array([k for k in range(120) if k not in lost])
    stamps = (2**bits - before * step + step * kept) % 2**bits
    gyr = np.random.default_rng(before).normal(size=(120, 3))
    rows = [f"{stamp},{','.join(f'{one:.8f}' for one in gyr[k])}" for stamp, k in zip(stamps, kept, strict=True)]
    rec = read("\n".join([f"t ({unit}),gx (rad/s),gy (rad/s),gz (rad/s)", *rows]) + "\n")
    np.testing.assert_allclose(rec.t - rec.t[0], size * step * (kept - kept[0]), rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(rec.gyr, gyr[kept], atol=1e-8)


@settings(deadline=None, max_examples=60)
@given(
    st.text(
        alphabet=st.characters(codec="utf-8", exclude_categories=["Cc"], exclude_characters=",\"'"),
        min_size=1,
        max_size=30,
    )
)
def test_a_column_of_any_name_beside_the_readings_does_no_harm(name: str) -> None:
    head = f"t (s),gx (rad/s),gy (rad/s),gz (rad/s),{name}"
    rows = [f"{k / 100},{k % 3},0.1,0.2,{k % 5}" for k in range(20)]
    refusal = ""
    try:
        rec = read("\n".join([head, *rows]) + "\n")
    except ValueError as error:
        refusal = str(error)
    if refusal:  # the name may say that it is one of the others: refused with the way out
        assert "columns" in refusal or "sensor=" in refusal
    else:
        np.testing.assert_allclose(rec.gyr[:, 1], 0.1)
