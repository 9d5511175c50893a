"""Arrays of every layout give the same numbers, results go where they are asked to, and errors say what is wrong."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import pandas as pd
import polars as pl
import pytest
from numpy.typing import NDArray

import ahrs_rs as ar
from cases import COMMON, Case, assert_same_attitudes, each_case
from signals import RATE, angle_between, gappy, motion

Layout = Callable[[NDArray[Any]], Any]


def unaligned(array: NDArray[Any]) -> NDArray[Any]:
    """A copy that begins one byte beside an address that its dtype asks for."""
    raw = np.zeros(array.nbytes + 1, np.uint8)
    copy = raw[1:].view(array.dtype).reshape(array.shape)
    copy[...] = array
    assert not copy.flags.aligned
    return copy


def wide(array: NDArray[Any]) -> NDArray[Any]:
    """The same values between others, three apart along samples and two along axes."""
    room = np.full((3 * array.shape[0], 2 * array.shape[1]), 77, array.dtype)
    room[1::3, ::2] = array
    return room[1::3, ::2]


def field(array: NDArray[Any]) -> NDArray[Any]:
    """A field of records of 25 bytes or so."""
    records = np.zeros(len(array), [("flag", np.uint8), ("v", array.dtype, 3)])
    records["v"] = array
    return records["v"]


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    copy = array.copy()
    copy.flags.writeable = False
    return copy


LAYOUTS: dict[str, Layout] = {
    "C": np.ascontiguousarray,
    "Fortran": np.asfortranarray,
    "reversed along samples": lambda a: a[::-1].copy()[::-1],
    "reversed along axes": lambda a: a[:, ::-1].copy()[:, ::-1],
    "strided": wide,
    "transposed": lambda a: np.ascontiguousarray(a.T).T,
    "columns of a table": lambda a: np.hstack((a, a, a))[:, 3:6],
    "field of records": field,
    "other byte order": lambda a: a.astype(a.dtype.newbyteorder()),
    "other byte order, strided": lambda a: wide(a.astype(a.dtype.newbyteorder())),
    "unaligned": unaligned,
    "read-only": read_only,
    "subclass": lambda a: a.view(np.recarray),
}
#: Those that lose the dtype float32: they are computed in float64.
WIDENED: dict[str, Layout] = {
    "lists": lambda a: a.tolist(),
    "tuples of rows": lambda a: tuple(map(tuple, a.tolist())),
    "list of arrays": lambda a: list(a),
    "longdouble": lambda a: a.astype(np.longdouble),
    "pandas": pd.DataFrame,
    "polars": pl.DataFrame,
}


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("layout", LAYOUTS)
@each_case
def test_the_layout_of_the_inputs_changes_no_bit(case: Case, layout: str, dtype: type) -> None:
    signals = gappy(motion(300, 1), 2).astype(dtype)
    plain = case.run(signals)
    est = case.make(rate=RATE).run(*map(LAYOUTS[layout], signals.sensors()))
    assert est.quat.dtype == dtype
    assert_same_attitudes(est, plain)
    assert np.array_equal(est.status, plain.status)


@pytest.mark.parametrize("container", WIDENED)
def test_other_containers_of_numbers_are_arrays_too(container: str) -> None:
    signals = gappy(motion(300, 1), 2)
    f = ar.Madgwick(rate=RATE)
    assert_same_attitudes(f.run(*map(WIDENED[container], signals.sensors())), f.run(*signals.sensors()))


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_layout_of_stamps_and_q0_changes_no_bit(layout: str) -> None:
    signals = motion(300, 3, jitter=True)
    f = ar.Mahony()
    plain = f.run(*signals.sensors(), t=signals.t, q0=signals.before)
    columns = LAYOUTS[layout](np.column_stack((signals.t, signals.t, signals.t)))
    q0 = LAYOUTS[layout](np.tile(signals.before[1:], (2, 1)))
    est = f.run(*signals.sensors(), t=columns[:, 1], q0=[signals.before[0], *q0[1]])
    assert_same_attitudes(est, plain)
    assert_same_attitudes(f.run(*signals.sensors(), t=signals.t.tolist(), q0=signals.before.tolist()), plain)


@pytest.mark.parametrize("dtype", [np.int8, np.int32, np.uint16, np.int64, np.float16, np.bool_])
def test_whole_numbers_and_half_precision_are_computed_in_float64(dtype: type) -> None:
    rng = np.random.default_rng(4)
    arrays = [rng.integers(0, 2 if dtype is np.bool_ else 50, (90, 3)).astype(dtype) for _ in range(3)]
    f = ar.Madgwick(rate=RATE)
    est = f.run(*arrays)
    assert est.quat.dtype == np.float64
    assert_same_attitudes(est, f.run(*(array.astype(np.float64) for array in arrays)))


@pytest.mark.parametrize("wide_one", [0, 1, 2])
def test_one_float64_array_makes_the_run_float64(wide_one: int) -> None:
    signals = motion(50, 5).astype(np.float32)
    arrays = list(signals.sensors())
    arrays[wide_one] = arrays[wide_one].astype(np.float64)
    f = ar.Mahony(rate=RATE)
    est = f.run(*arrays)
    assert est.quat.dtype == np.float64
    assert_same_attitudes(est, f.run(*signals.astype(np.float64).sensors()))


def test_stamps_and_q0_do_not_decide_the_dtype() -> None:
    signals = motion(50, 5).astype(np.float32)
    est = ar.Mahony().run(*signals.sensors(), t=signals.t, q0=signals.before, outputs=("innovation",))
    assert {est.quat.dtype, est.gyr_bias.dtype, est.extra["innovation"].dtype} == {np.dtype(np.float32)}
    assert est.t.dtype == np.float64


def test_stamps_are_subtracted_in_float64_before_they_are_rounded() -> None:
    # At 1.7e9 s (a date) float32 stamps are 128 s apart, and float64 ones 2e-7 s.
    signals = motion(500, 6).astype(np.float32)
    f = ar.GyroIntegration()
    late = f.run(*signals.sensors(), t=signals.t + 2.0**31)
    early = f.run(*signals.sensors(), t=(signals.t + 2.0**31) - 2.0**31)
    assert_same_attitudes(late, early)


@pytest.mark.parametrize("nine", [True, False], ids=["9D", "6D"])
@each_case
def test_float32_stays_within_its_bound_of_float64(case: Case, nine: bool) -> None:
    for seed, jitter in ((0, False), (1, True)):
        signals = motion(10_000, seed, level=case.euler_rates, jitter=jitter).astype(np.float32)
        f = case.make(rate=RATE)
        narrow = f.run(*signals.sensors(nine=nine), t=signals.t)
        exact = f.run(*signals.astype(np.float64).sensors(nine=nine), t=signals.t)
        assert narrow.quat.dtype == np.float32
        # What a filter judges by a threshold, rounding may judge one sample later.
        assert np.array_equal(narrow.status & COMMON, exact.status & COMMON)
        assert angle_between(narrow.quat, exact.quat).max() < case.float32


# Three dimensions.


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@each_case
def test_three_dimensions_are_a_loop_bit_for_bit(case: Case, dtype: type) -> None:
    recordings = [gappy(motion(150, seed), seed + 10).astype(dtype) for seed in range(5)]
    stacked = [np.stack([r.sensors()[i] for r in recordings]) for i in range(3)]
    t = np.stack([r.t * (1.0 + 0.1 * i) for i, r in enumerate(recordings)])
    q0 = np.stack([r.before for r in recordings])
    f = case.make(rate=RATE, frame="NED")
    names = tuple(f.OUTPUTS)
    for each, common in (({"t": t, "q0": q0}, {}), ({"t": t}, {"q0": q0[2]}), ({}, {"t": t[1]}), ({}, {})):
        whole = f.run(*stacked, **each, **common, outputs=names)
        for i, recording in enumerate(recordings):
            own = {name: values[i] for name, values in each.items()}
            one = f.run(*recording.sensors(), **own, **common, outputs=names)
            assert np.array_equal(whole.quat[i], one.quat)
            assert np.array_equal(whole.status[i], one.status)
            assert one.gyr_bias is None or np.array_equal(whole.gyr_bias[i], one.gyr_bias)
            assert whole.state[i] == one.state
            # NaN is an innovation that there is not.
            assert all(np.array_equal(whole.extra[name][i], one.extra[name], equal_nan=True) for name in names)


@pytest.mark.parametrize("axes", [(0, 1, 2), (1, 0, 2), (2, 1, 0), (0, 2, 1), (1, 2, 0), (2, 0, 1)])
def test_three_dimensions_in_any_order_of_axes_in_memory(axes: tuple[int, int, int]) -> None:
    data = np.random.default_rng(7).standard_normal((3, 4, 300, 3))
    f = ar.Madgwick(rate=RATE)
    moved = [np.ascontiguousarray(a.transpose(axes)).transpose(np.argsort(axes)) for a in data]
    assert_same_attitudes(f.run(*moved), f.run(*data))
    one = f.run(*(np.broadcast_to(a[0], a.shape) for a in data))
    assert all(np.array_equal(one.quat[0], quat) for quat in one.quat)


# Where results go.


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize(
    "room",
    [
        lambda shape, dtype: np.empty(shape, dtype),
        lambda shape, dtype: np.empty(shape, dtype, order="F"),
        lambda shape, dtype: np.empty(shape, dtype)[::-1, ::-1],
        lambda shape, dtype: np.empty((2 * shape[0], 8), dtype)[::2, 1:8:2],
        lambda shape, dtype: np.empty(shape[::-1], dtype).T,
    ],
    ids=["C", "Fortran", "reversed", "strided", "transposed"],
)
def test_out_of_any_layout_gets_the_attitudes(room: Callable[..., NDArray[Any]], dtype: type) -> None:
    signals = motion(600, 8).astype(dtype)
    f = ar.Madgwick(rate=RATE)
    plain = f.run(*signals.sensors())
    out = room((600, 4), dtype)
    est = f.run(*signals.sensors(), out=out)
    assert est.quat is out
    assert_same_attitudes(est, plain)


def test_out_of_three_dimensions_may_be_strided() -> None:
    data = np.random.default_rng(9).standard_normal((3, 5, 300, 3))
    f = ar.Madgwick(rate=RATE)
    room = np.zeros((300, 11, 4))
    est = f.run(*data, out=room[:, ::2].transpose(1, 0, 2)[:5])
    assert_same_attitudes(est, f.run(*data))
    assert not room[:, 1::2].any(), "rows between those asked for are written"
    assert not room[:, 10].any()


@pytest.mark.parametrize(
    ("out", "came"),
    [
        (np.zeros((10, 3)), r"\(10, 3\)"),
        (np.zeros((9, 4)), r"\(9, 4\)"),
        (np.zeros((1, 10, 4)), r"\(1, 10, 4\)"),
        (np.zeros((10, 4), np.float32), "float32"),
        (np.zeros((10, 4), ">f8"), ">f8"),
        (np.zeros((10, 4), np.complex128), "complex128"),
        (unaligned(np.zeros((10, 4))), "not aligned"),
        (read_only(np.zeros((10, 4))), "not writeable"),
        ([[0.0] * 4] * 10, "list"),
    ],
    ids=str,
)
def test_an_out_that_cannot_take_the_attitudes_is_a_value_error(out: Any, came: str) -> None:
    with pytest.raises(ValueError, match=f"out: expected a writeable .*got .*{came}"):
        ar.Tilt(rate=RATE).run(np.zeros((10, 3)), out=out)


def overlapping_views() -> tuple[NDArray[Any], NDArray[Any]]:
    room = np.empty((600, 4))
    return room[:, :3], room


def overlapping_buffers() -> tuple[NDArray[Any], NDArray[Any]]:
    memory = bytearray(600 * 4 * 8)
    return np.frombuffer(memory)[:1800].reshape(600, 3), np.frombuffer(memory).reshape(600, 4)


@pytest.mark.parametrize("overlapping", [overlapping_views, overlapping_buffers])
@pytest.mark.parametrize("place", [0, 1, 2])
def test_an_out_that_overlaps_an_input_is_a_value_error(
    place: int, overlapping: Callable[[], tuple[NDArray[Any], NDArray[Any]]]
) -> None:
    arrays = list(motion(600, 10).sensors())
    view, out = overlapping()
    view[...] = arrays[place]
    arrays[place] = view
    with pytest.raises(ValueError, match="out: expected a writeable array that is no input"):
        ar.Madgwick(rate=RATE).run(*arrays, out=out)


def test_an_out_that_overlaps_the_stamps_is_a_value_error() -> None:
    room = np.zeros((100, 4))
    with pytest.raises(ValueError, match="out: expected a writeable array"):
        ar.Tilt().run(np.zeros((100, 3)), t=room[:, 0], out=room)


def table_of(signals: Any, dtype: type = np.float64) -> NDArray[Any]:
    """Measurements and room for attitudes as columns of one table."""
    table = np.full((len(signals), 15), -7.0, dtype)
    table[:, :9] = np.hstack(signals.sensors())
    return table


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_columns_of_the_table_of_the_inputs_may_be_out(dtype: type, order: Literal["C", "F"]) -> None:
    signals = motion(600, 8).astype(dtype)
    f = ar.Madgwick(rate=RATE)
    plain = f.run(*signals.sensors())
    table = np.asarray(table_of(signals, dtype), order=order)
    before = table.copy()
    out = table[:, 10:14]
    est = f.run(table[:, :3], table[:, 3:6], table[:, 6:9], out=out)
    assert est.quat is out
    assert_same_attitudes(est, plain)
    assert np.array_equal(np.delete(table, range(10, 14), axis=1), np.delete(before, range(10, 14), axis=1))


def test_columns_of_one_table_of_many_recordings_may_be_out() -> None:
    signals = motion(600, 8)
    f = ar.Madgwick(rate=RATE)
    table = table_of(signals)
    parts = [slice(0, 200), slice(200, 350), slice(350, 600)]
    plain = ar.run_many(f, [tuple(array[part] for array in signals.sensors()) for part in parts])
    recordings = [
        {"gyr": rows[:, :3], "acc": rows[:, 3:6], "mag": rows[:, 6:9], "out": rows[:, 10:14]}
        for rows in (table[part] for part in parts)
    ]
    for est, one, recording in zip(ar.run_many(f, recordings), plain, recordings, strict=True):
        assert est.quat is recording["out"]
        assert_same_attitudes(est, one)


def test_an_out_that_overlaps_the_input_or_the_out_of_another_recording_is_a_value_error() -> None:
    signals = motion(600, 8)
    f = ar.Madgwick(rate=RATE)
    table = table_of(signals)

    def one(rows: slice, out: NDArray[Any]) -> dict[str, Any]:
        return {"gyr": table[rows, :3], "acc": table[rows, 3:6], "mag": table[rows, 6:9], "out": out}

    first, second = slice(0, 300), slice(300, 600)
    for wrong in (table[first, 5:9], table[first, 10:14], table[150:450, 10:14]):
        before = table.copy()
        with pytest.raises(ValueError, match="out: expected a writeable array that is no input"):
            ar.run_many(f, [one(first, table[first, 10:14]), one(second, wrong)])
        assert np.array_equal(table[:, :9], before[:, :9])
        found = ar.run_many(f, [one(first, table[first, 10:14]), one(second, wrong)], errors="return")
        assert any(isinstance(est, ValueError) for est in found)
        table[...] = before


def test_an_out_whose_rows_share_memory_is_a_value_error() -> None:
    folded = np.lib.stride_tricks.as_strided(np.zeros(4), (100, 4), (0, 8))
    with pytest.raises(ValueError, match="out: expected"):
        ar.Tilt(rate=RATE).run(np.zeros((100, 3)), out=folded)


# Errors.


@pytest.mark.parametrize("name", ["gyr", "acc", "mag"])
@pytest.mark.parametrize(
    ("wrong", "came"),
    [
        (np.zeros((5, 4)), r"\(5, 4\)"),
        (np.zeros((4, 3)), r"\(4, 3\)|\(5, 3\)"),
        (np.zeros((1, 5, 3)), r"\(1, 5, 3\)|\(5, 3\)"),
        (np.zeros(3), r"\(3,\)"),
        (3.0, r"\(\)"),
        ("text", "dtype <U4|a path"),
        (np.zeros((5, 3), complex), "dtype complex128"),
        (np.zeros((5, 3), object), "dtype object"),
        (np.zeros((5, 3), "M8[s]"), "dtype datetime64"),
        ([[1.0, 2.0, 3.0], [4.0]], "inhomogeneous"),
    ],
    ids=str,
)
def test_what_is_no_array_of_samples_is_a_value_error_that_names_it(name: str, wrong: Any, came: str) -> None:
    arrays = {key: np.zeros((5, 3)) for key in ("gyr", "acc", "mag")} | {name: wrong}
    with pytest.raises(ValueError, match=rf"(?s)^(gyr|acc|mag): expected .*, got .*({came})"):
        ar.Mahony(rate=RATE).run(**arrays)


def test_gyr_cannot_be_none() -> None:
    with pytest.raises(ValueError, match="gyr: expected an array of real numbers"):
        ar.Mahony(rate=RATE).run(None)


def test_without_rate_and_t_there_is_no_time() -> None:
    with pytest.raises(ValueError, match="t: expected stamps in s, as the filter was made without rate, got None"):
        ar.Mahony().run(np.zeros((5, 3)))
    with pytest.raises(ValueError, match="rate: expected a rate in Hz"):
        ar.Mahony().run(np.zeros((1, 3)), t=[0.0], q0=[1.0, 0.0, 0.0, 0.0])


def test_q0_of_many_recordings_is_one_or_one_each() -> None:
    data = np.zeros((3, 5, 3))
    with pytest.raises(ValueError, match=r"q0: expected shape \(4,\) or \(3, 4\), got \(2, 4\)"):
        ar.Tilt(rate=RATE).run(data, q0=np.ones((2, 4)))
    with pytest.raises(ValueError, match=r"t: expected shape \(5,\) or \(3, 5\), got \(2, 5\)"):
        ar.Tilt().run(data, t=np.zeros((2, 5)))


@pytest.mark.parametrize("threads", [0, -1, 1.5, "2", True])
def test_a_number_of_threads_that_is_none_is_a_value_error(threads: Any) -> None:
    with pytest.raises(ValueError, match="threads: expected a positive whole number or None"):
        ar.Tilt(rate=RATE).run(np.zeros((5, 3)), threads=threads)
