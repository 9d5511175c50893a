"""What other libraries hold is taken as arrays are, without a copy where the memory allows it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import _arrays
from calibrated import FloatArray

RATE = 100.0
Make = Callable[[Any, Any], Any]


def signals(dtype: Any = np.float64) -> tuple[Any, Any]:
    rec = ar.simulate.demo(duration=2.0, rate=RATE)
    assert rec.gyr is not None
    assert rec.acc is not None
    return rec.gyr.astype(dtype), rec.acc.astype(dtype)


def address(array: Any) -> int:
    return int(array.__array_interface__["data"][0])


def shares(array: Any, buffers: list[Any]) -> bool:
    """Whether an array begins within one of the buffers of Arrow."""
    return any(one is not None and one.address <= address(array) < one.address + one.size for one in buffers)


class Dlpack:
    """What a library has that exchanges memory by DLPack alone."""

    def __init__(self, array: Any) -> None:
        self.array = array

    def __dlpack__(self, **keywords: Any) -> Any:
        return self.array.__dlpack__(**keywords)

    def __dlpack_device__(self) -> Any:
        return self.array.__dlpack_device__()


def frame_of(pd: Any, array: Any, dtype: str) -> Any:
    return pd.DataFrame(array, columns=list("xyz")).astype(dtype)


def lists_of(pa: Any, array: Any) -> Any:
    return pa.FixedSizeListArray.from_arrays(pa.array(array.ravel()), 3)


#: Name -> (package, how it is made, whether float32 stays, whether it is free of copies).
KINDS: dict[str, tuple[str, Make, bool, bool]] = {
    "pandas": ("pandas", lambda pd, a: pd.DataFrame(a), True, False),
    "pandas nullable": (
        "pandas",
        lambda pd, a: frame_of(pd, a, "Float32" if a.itemsize == 4 else "Float64"),
        True,
        False,
    ),
    "pandas Arrow": (
        "pandas",
        lambda pd, a: frame_of(pd, a, "float[pyarrow]" if a.itemsize == 4 else "double[pyarrow]"),
        True,
        False,
    ),
    "pandas convert_dtypes": ("pandas", lambda pd, a: pd.DataFrame(a).convert_dtypes(), True, False),
    "pandas Arrow lists": (
        "pandas",
        lambda pd, a: pd.Series(pyarrow_list(a), dtype=pd.ArrowDtype(pyarrow_list(a).type)),
        True,
        True,
    ),
    "pandas Arrow lists of fixed size": (
        "pandas",
        lambda pd, a: pd.Series(lists_of(pyarrow(), a), dtype=pd.ArrowDtype(lists_of(pyarrow(), a).type)),
        True,
        True,
    ),
    "polars DataFrame": ("polars", lambda pl, a: pl.DataFrame(a), True, False),
    "polars Array": (
        "polars",
        lambda pl, a: pl.Series(a, dtype=pl.Array(pl.Float32 if a.itemsize == 4 else pl.Float64, 3)),
        True,
        True,
    ),
    "polars List": (
        "polars",
        lambda pl, a: pl.Series(a.tolist(), dtype=pl.List(pl.Float32 if a.itemsize == 4 else pl.Float64)),
        True,
        False,
    ),
    "pyarrow FixedSizeList": ("pyarrow", lists_of, True, True),
    "pyarrow ChunkedArray": ("pyarrow", lambda pa, a: pa.chunked_array([lists_of(pa, a)]), True, True),
    "pyarrow two chunks": (
        "pyarrow",
        lambda pa, a: pa.chunked_array([lists_of(pa, a[:50]), lists_of(pa, a[50:])]),
        True,
        False,
    ),
    "pyarrow tensor": ("pyarrow", lambda pa, a: pa.FixedShapeTensorArray.from_numpy_ndarray(a), True, True),
    "pyarrow List": ("pyarrow", lambda pa, a: pyarrow_list(a), True, True),
    "pyarrow Table": ("pyarrow", lambda pa, a: pa.table({c: a[:, k] for k, c in enumerate("xyz")}), True, False),
    "xarray": ("xarray", lambda xr, a: xr.DataArray(a, dims=("t", "axis")), True, True),
    "xarray, axes first": (
        "xarray",
        lambda xr, a: xr.DataArray(np.ascontiguousarray(a.T), dims=("axis", "t")),
        True,
        True,
    ),
    "DLPack": ("numpy", lambda np_, a: Dlpack(a), True, True),
    "array_api_strict": ("array_api_strict", lambda xp, a: xp.asarray(a), True, True),
    "torch": ("torch", lambda torch, a: torch.from_numpy(a), True, True),
}


def pyarrow() -> Any:
    return pytest.importorskip("pyarrow")


def pyarrow_list(array: FloatArray) -> Any:
    pa = pyarrow()
    offsets = pa.array(np.arange(0, 3 * len(array) + 1, 3), type=pa.int32())
    return pa.ListArray.from_arrays(offsets, pa.array(array.ravel()))


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("kind", KINDS)
def test_a_run_takes_it_bit_for_bit(kind: str, dtype: type) -> None:
    package, make, narrow, _ = KINDS[kind]
    library = pytest.importorskip(package)
    gyr, acc = signals(dtype)
    expected = ar.MEKF(rate=RATE).run(gyr, acc)
    found = ar.MEKF(rate=RATE).run(make(library, gyr), make(library, acc))
    assert found.quat.dtype == (dtype if narrow else np.float64)
    assert np.array_equal(found.quat, expected.quat)


@pytest.mark.parametrize("kind", [name for name, (*_, free) in KINDS.items() if free])
def test_what_lies_as_an_array_does_is_not_copied(kind: str) -> None:
    package, make, _, _ = KINDS[kind]
    library = pytest.importorskip(package)
    gyr, _ = signals()
    given = make(library, gyr)
    found = np.asarray(_arrays.vectors("gyr", given))
    assert np.array_equal(found, gyr)
    if package == "pyarrow":
        chunk = given.chunk(0) if hasattr(given, "chunk") else given
        chunk = getattr(chunk, "storage", chunk)
        assert shares(found, chunk.buffers() + chunk.flatten().buffers())
    elif package == "pandas":
        chunk = given.array.__arrow_array__().chunk(0)
        assert shares(found, chunk.buffers() + chunk.flatten().buffers())
    elif package == "polars":
        pyarrow()
        assert shares(found, given.to_arrow().flatten().buffers())
    elif kind.startswith("xarray"):
        assert address(found) == address(given.values)
        assert np.shares_memory(found, given.values)
    else:
        assert np.shares_memory(found, gyr)


@pytest.mark.parametrize(
    "kind", ["pandas nullable", "pandas Arrow", "polars Array", "polars List", "pyarrow FixedSizeList"]
)
def test_a_missing_row_is_one_of_nan(kind: str) -> None:
    package, _, _, _ = KINDS[kind]
    library = pytest.importorskip(package)
    gyr, acc = signals()
    expected = acc.copy()
    expected[7] = np.nan
    rows: list[Any] = acc.tolist()
    rows[7] = None
    if package == "pandas":
        columns = {c: [None if row is None else row[k] for row in rows] for k, c in enumerate("xyz")}
        given = library.DataFrame(columns).astype("Float64" if kind.endswith("nullable") else "double[pyarrow]")
    elif package == "polars":
        kinds = {"polars Array": library.Array(library.Float64, 3), "polars List": library.List(library.Float64)}
        given = library.Series(rows, dtype=kinds[kind])
    else:
        given = library.array(rows, type=library.list_(library.float64(), 3))
    found = ar.MEKF(rate=RATE).run(gyr, given)
    assert np.array_equal(found.quat, ar.MEKF(rate=RATE).run(gyr, expected).quat)
    assert found.status[7] & ar.Status.ACC_MISSING


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int64])
def test_a_masked_row_is_missing_wherever_readings_are_taken(dtype: type) -> None:
    gyr, acc = (np.round(10.0 * one).astype(dtype) for one in signals())
    masked = np.ma.masked_array(acc, mask=np.zeros(acc.shape, dtype=bool))
    masked[7] = np.ma.masked
    expected = acc.astype(np.float64 if dtype is np.int64 else dtype)
    expected[7] = np.nan
    t = np.arange(len(gyr)) / RATE
    found = ar.Mahony(rate=RATE).run(gyr, masked)
    assert found.status[7] & ar.Status.ACC_MISSING
    np.testing.assert_array_equal(ar.Recording(t=t, gyr=gyr, acc=masked).acc, expected)
    np.testing.assert_array_equal(
        ar.Recording.from_streams(gyr=(t, gyr), acc=(t, masked)).streams["acc"].values, expected
    )
    rotated = ar.rotation.rotate([1.0, 0.0, 0.0, 0.0], masked)
    np.testing.assert_array_equal(np.isnan(rotated), np.isnan(expected))
    assert np.isnan(ar.attitude.fqa(masked)[7]).all()
    assert not np.isnan(ar.attitude.fqa(masked)[8]).any()


def test_a_masked_stamp_is_no_stamp() -> None:
    t = np.ma.masked_array([0.0, 0.01, 0.02], mask=[False, True, False])
    with pytest.raises(ValueError, match=r"^t: expected finite stamps, got NaN at index 1"):
        ar.Mahony().run(np.zeros((3, 3)), t=t)
    with pytest.raises(ValueError, match=r"^t: expected finite times, got nan at index 1"):
        ar.Recording(t=t, gyr=np.zeros((3, 3)))
    dates = np.ma.masked_array(np.arange(3).astype("datetime64[ms]"), mask=[False, True, False])
    with pytest.raises(ValueError, match=r"^t: expected finite stamps, got NaN at index 1"):
        ar.Mahony().run(np.zeros((3, 3)), t=dates)


def test_rotations_take_missing_values_of_pandas() -> None:
    pd = pytest.importorskip("pandas")
    frame = pd.DataFrame([[1.0, 2.0, 3.0], [None, 5.0, 6.0]], columns=list("xyz")).astype("Float64")
    found = ar.rotation.rotate([1.0, 0.0, 0.0, 0.0], frame)
    np.testing.assert_array_equal(found, [[1.0, 2.0, 3.0], [np.nan] * 3])


@pytest.mark.parametrize("package", ["polars", "pyarrow"])
def test_rows_of_different_lengths_are_told(package: str) -> None:
    library = pytest.importorskip(package)
    rows = [[1.0, 2.0, 3.0], [1.0, 2.0]]
    given = library.Series(rows) if package == "polars" else library.array(rows)
    with pytest.raises(ValueError, match=r"gyr: expected an array of real numbers, got .*rows of \[2, 3\] values"):
        ar.Mahony(rate=RATE).run(given)


def test_a_tensor_that_numpy_cannot_have_is_told() -> None:
    class Elsewhere(Dlpack):
        def __dlpack_device__(self) -> Any:
            return (2, 0)  # CUDA

        def __dlpack__(self, **keywords: Any) -> Any:
            raise BufferError("the memory is on another device")

    with pytest.raises(ValueError, match="gyr: expected an array of real numbers, got Elsewhere: "):
        ar.Mahony(rate=RATE).run(Elsewhere(np.zeros((5, 3))))


def test_an_estimate_is_a_dataset_without_a_copy() -> None:
    pytest.importorskip("xarray")
    rec = ar.simulate.demo(duration=2.0, rate=RATE)
    est = ar.MEKF(rate=RATE).run(rec, outputs=["covariance"])
    found = est.to_xarray()
    assert found.sizes == {"t": 200, "component": 4, "angle": 3, "axis": 3, "covariance_0": 3, "covariance_1": 3}
    assert np.array_equal(found["t"], rec.t)
    assert np.array_equal(found["quat"].sel(component="w"), est.quat[:, 0])
    assert np.array_equal(found["euler"].sel(angle="yaw"), est.euler()[:, 2])
    assert np.array_equal(found["gyr_bias"], est.gyr_bias)
    assert np.array_equal(found["covariance"], est.extra["covariance"])
    assert np.array_equal(found["status"], est.status)
    assert (found.attrs["frame"], found["gyr_bias"].attrs["units"]) == ("ENU", "rad/s")
    assert np.shares_memory(found["quat"].values, est.quat)
    assert np.shares_memory(found["covariance"].values, est.extra["covariance"])


def test_several_recordings_are_a_dimension_of_the_dataset() -> None:
    pytest.importorskip("xarray")
    gyr, acc = (np.stack([one, one]) for one in signals())
    one_clock = ar.MEKF(rate=RATE).run(gyr, acc).to_xarray()
    assert one_clock["quat"].dims == ("recording", "t", "component")
    t = np.arange(200) / RATE
    own = ar.MEKF().run(gyr, acc, t=np.stack([t, t + 5.0])).to_xarray()
    assert own["quat"].dims == ("recording", "sample", "component")
    assert np.array_equal(own["t"].isel(recording=1), t + 5.0)


def test_a_dataset_is_a_recording_and_goes_into_a_run_by_its_arrays() -> None:
    xr = pytest.importorskip("xarray")
    gyr, acc = signals()
    t = np.arange(200) / RATE
    dataset = xr.Dataset(
        {"gyr (rad/s)": (("t", "axis"), gyr), "acc (m/s²)": (("axis", "t"), acc.T)},
        {"t": ("t", t, {"units": "s"}), "axis": list("xyz")},
    ).rename({"t": "t (s)"})
    rec = ar.Recording.from_frame(dataset)
    assert np.array_equal(rec.gyr, gyr)
    assert np.array_equal(rec.acc, acc)
    assert np.array_equal(rec.t, t)
    dated = xr.DataArray(np.datetime64("2026-01-01", "ns") + (t * 1e9).astype("timedelta64[ns]"), dims="t")
    est = ar.MEKF().run(xr.DataArray(gyr, dims=("t", "axis")), xr.DataArray(acc.T, dims=("axis", "t")), t=dated)
    assert np.allclose(est.quat, ar.MEKF(rate=RATE).run(gyr, acc).quat, rtol=0, atol=1e-7)
    with pytest.raises(ValueError, match="gyr: expected an array or a Recording, got a Dataset of"):
        ar.MEKF(rate=RATE).run(dataset)
    with pytest.raises(ValueError, match="frame: expected a Dataset with variables, got an empty one"):
        ar.Recording.from_frame(xr.Dataset())


def test_results_are_given_on_by_dlpack_without_a_copy() -> None:
    gyr, acc = signals()
    est = ar.MEKF(rate=RATE).run(gyr, acc)
    assert np.shares_memory(np.from_dlpack(est.quat), est.quat)
    torch = pytest.importorskip("torch")
    assert torch.from_dlpack(est.quat).data_ptr() == address(est.quat)
