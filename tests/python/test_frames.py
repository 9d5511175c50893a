"""Data frames, dates and missing values of other packages, as recordings and as what filters are given."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import ahrs_rs as ar

pd = pytest.importorskip("pandas")
pl = pytest.importorskip("polars")
pa = pytest.importorskip("pyarrow")

N, RATE = 100, 50.0
T = np.arange(N) / RATE
GYR = np.column_stack([np.sin(T), np.cos(T), np.sin(2.0 * T)])
ACC = np.tile([0.5, -0.5, 9.7], (N, 1))
NAMES = {
    "t (s)": T, **{f"gyr_{axis} (rad/s)": GYR[:, k] for k, axis in enumerate("xyz")},
    **{f"acc_{axis} (m/s2)": ACC[:, k] for k, axis in enumerate("xyz")},
}  # fmt: skip
START = np.datetime64("2024-05-01T12:00:00", "ns")
DATES = START + np.rint(1e9 * T).astype("timedelta64[ns]")


def nullable(frame: Any) -> Any:
    return frame.astype(dict.fromkeys(frame.columns, "Float64"))


FRAMES: dict[str, Callable[[], Any]] = {
    "dict": lambda: NAMES,
    "pandas": lambda: pd.DataFrame(NAMES),
    "pandas, nullable": lambda: nullable(pd.DataFrame(NAMES)),
    "pandas, Arrow": lambda: pd.DataFrame(NAMES).convert_dtypes(dtype_backend="pyarrow"),
    "pandas, DatetimeIndex": lambda: pd.DataFrame({k: v for k, v in NAMES.items() if k != "t (s)"}, index=DATES),
    "pandas, with a time zone": lambda: pd.DataFrame(
        {k: v for k, v in NAMES.items() if k != "t (s)"}, index=pd.DatetimeIndex(DATES).tz_localize("Europe/Berlin")
    ),
    "pandas, TimedeltaIndex": lambda: pd.DataFrame(
        {k: v for k, v in NAMES.items() if k != "t (s)"}, index=pd.to_timedelta(DATES - START)
    ),
    "pandas, a column of dates": lambda: pd.DataFrame(
        {"time": DATES, **{k: v for k, v in NAMES.items() if k != "t (s)"}}
    ),
    "polars": lambda: pl.DataFrame(NAMES),
    "polars, dates": lambda: pl.DataFrame({"time": DATES, **{k: v for k, v in NAMES.items() if k != "t (s)"}}),
    "polars, durations": lambda: pl.DataFrame(
        {"time": DATES - START, **{k: v for k, v in NAMES.items() if k != "t (s)"}}
    ),
    "pyarrow": lambda: pa.table(NAMES),
    "pyarrow, in chunks": lambda: pa.concat_tables([pa.table(NAMES).slice(0, 33), pa.table(NAMES).slice(33)]),
}


@pytest.mark.parametrize("make", FRAMES.values(), ids=FRAMES)
def test_a_frame_of_any_package_is_the_same_recording(make: Callable[[], Any]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rec = ar.Recording.from_frame(make())
    np.testing.assert_allclose(rec.t - rec.t[0], T, atol=1e-9)
    assert_array_equal(rec.gyr, GYR)
    assert_array_equal(rec.acc, ACC)


def test_missing_values_of_every_package_are_no_reading() -> None:
    lost = GYR[:, 0].copy()
    lost[[3, 50]] = np.nan
    columns = {**NAMES, "gyr_x (rad/s)": lost}
    cells = [None if np.isnan(one) else one for one in lost]
    frames = {
        "pandas": pd.DataFrame(columns),
        "nullable": nullable(pd.DataFrame(columns)),
        "Arrow": pd.DataFrame(columns).convert_dtypes(dtype_backend="pyarrow"),
        "polars": pl.DataFrame({**NAMES, "gyr_x (rad/s)": cells}),
        "pyarrow": pa.table({**NAMES, "gyr_x (rad/s)": pa.array(cells)}),
    }
    for name, frame in frames.items():
        rec = ar.Recording.from_frame(frame)
        assert_array_equal(np.flatnonzero(np.isnan(rec.gyr[:, 0])), [3, 50], err_msg=name)
        assert not np.isnan(rec.gyr[:, 1]).any(), name


def test_columns_units_and_axes_are_options_as_of_files() -> None:
    frame = pd.DataFrame(
        {"ms": 1e3 * T, "p": np.rad2deg(GYR[:, 0]), "q": np.rad2deg(GYR[:, 1]), "r": np.rad2deg(GYR[:, 2])}
    )
    rec = ar.Recording.from_frame(frame, columns={"gyr": ["p", "q", "r"]}, units={"gyr": "deg/s"}, axes="x,-y,-z")
    np.testing.assert_allclose(rec.gyr, GYR * [1.0, -1.0, -1.0], atol=1e-12)
    np.testing.assert_allclose(rec.t, T, atol=1e-12)
    with pytest.raises(ValueError, match="columns"):
        ar.Recording.from_frame(frame)
    with pytest.raises(TypeError, match="data frame"):
        ar.Recording.from_frame(3)


def test_columns_of_vectors_are_three_columns() -> None:
    frame = pl.DataFrame({"t (s)": T, "gyr (rad/s)": GYR.tolist(), "acc (m/s2)": ACC.tolist()})
    rec = ar.Recording.from_frame(frame)
    assert_array_equal(rec.gyr, GYR)
    assert_array_equal(rec.acc, ACC)


@pytest.mark.parametrize("kind", ["pandas", "nullable", "Arrow", "polars", "pyarrow"])
def test_filters_take_the_columns_of_frames_as_they_are(kind: str) -> None:
    frame = pd.DataFrame(NAMES)
    gyr, acc = (
        frame[[f"{name}_{axis} ({unit})" for axis in "xyz"]] for name, unit in (("gyr", "rad/s"), ("acc", "m/s2"))
    )
    change: dict[str, Callable[[Any], Any]] = {
        "pandas": lambda one: one,
        "nullable": nullable,
        "Arrow": lambda one: one.convert_dtypes(dtype_backend="pyarrow"),
        "polars": pl.from_pandas,
        "pyarrow": pa.Table.from_pandas,
    }
    wanted = ar.VQF(rate=RATE).run(GYR, ACC).quat
    assert_array_equal(ar.VQF(rate=RATE).run(change[kind](gyr), change[kind](acc)).quat, wanted)


@pytest.mark.parametrize(
    "t",
    [DATES, DATES - START, DATES.astype("datetime64[us]"), pd.Series(DATES), pd.DatetimeIndex(DATES), pl.Series(DATES),
     pd.Series(DATES).dt.tz_localize("UTC")],
    ids=["datetime64", "timedelta64", "microseconds", "Series", "DatetimeIndex", "polars", "with a zone"],
)  # fmt: skip
def test_dates_and_durations_are_times_of_a_run(t: Any) -> None:
    est = ar.VQF(rate=RATE).run(GYR, ACC, t=t)
    assert_array_equal(est.quat, ar.VQF(rate=RATE).run(GYR, ACC, t=T).quat)
    np.testing.assert_allclose(est.t - est.t[0], T, atol=1e-9)


def test_text_and_objects_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match="gyr: expected"):
        ar.VQF().run(np.full((N, 3), "a"), ACC)
    with pytest.raises(ValueError, match="acc: expected"):
        ar.VQF().run(GYR, pd.DataFrame({"x": ["a"] * N, "y": 0.0, "z": 0.0}))
