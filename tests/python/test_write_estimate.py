"""Laws of `ahrs_rs.io.write_estimate`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ahrs_rs import metrics
from ahrs_rs.io import write_estimate

parquet = pytest.importorskip("pyarrow.parquet")


def estimate(count: int = 20) -> dict[str, Any]:
    random = np.random.default_rng(0)
    quat = random.standard_normal((count, 4))
    return {
        "t": np.arange(count) / 3,
        "quat": quat / np.linalg.norm(quat, axis=1, keepdims=True),
        "gyr_bias": random.standard_normal((count, 3)),
        "status": random.integers(0, 255, count).astype(np.uint16),
    }


COLUMNS = "t,qw,qx,qy,qz,roll,pitch,yaw,bias_x,bias_y,bias_z,status"


def as_table(values: dict[str, Any]) -> np.ndarray:
    euler = metrics.euler(values["quat"])
    return np.column_stack((values["t"], values["quat"], euler, values["gyr_bias"], values["status"]))


def test_estimate_in_csv_and_parquet_holds_the_same_numbers(tmp_path: Path) -> None:
    values = estimate()
    write_estimate(tmp_path / "a.csv", **values)
    write_estimate(tmp_path / "a.parquet", **values)
    lines = (tmp_path / "a.csv").read_text().splitlines()
    assert lines[0] == COLUMNS
    assert np.array_equal(np.array([line.split(",") for line in lines[1:]], float), as_table(values))
    table = parquet.read_table(tmp_path / "a.parquet")
    assert table.column_names == COLUMNS.split(",")
    assert np.array_equal(np.column_stack([column.to_numpy() for column in table.columns]), as_table(values))
    assert table["status"].to_numpy().dtype == np.uint16


def test_estimate_in_npz_holds_the_arrays(tmp_path: Path) -> None:
    values = estimate()
    euler = np.zeros((20, 3))
    write_estimate(tmp_path / "a.npz", **values, euler=euler)
    with np.load(tmp_path / "a.npz") as file:
        assert set(file.files) == {"t", "quat", "euler", "gyr_bias", "status"}
        for name, expected in (values | {"euler": euler}).items():
            assert np.array_equal(file[name], expected)


def test_estimate_without_bias_and_status_has_no_such_columns(tmp_path: Path) -> None:
    values = estimate()
    write_estimate(tmp_path / "a.csv", values["t"], values["quat"])
    assert (tmp_path / "a.csv").read_text().splitlines()[0] == "t,qw,qx,qy,qz,roll,pitch,yaw"


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("a.xlsx", {}, "expected a name that ends in .csv, .parquet, .npz, got 'a.xlsx'"),
        ("a.csv", {"t": np.zeros(19)}, r"t: expected shape \(20,\), got \(19,\)"),
        ("a.csv", {"quat": np.zeros((20, 3))}, r"quat: expected shape \(20, 4\), got \(20, 3\)"),
        ("a.csv", {"quat": np.zeros((2, 20, 4))}, r"quat: expected shape \(T, 4\)"),
        ("a.npz", {"gyr_bias": np.zeros((20, 4))}, r"gyr_bias: expected shape \(20, 3\)"),
        ("a.npz", {"status": np.zeros((20, 1))}, r"status: expected shape \(20,\)"),
        ("a.npz", {"euler": np.zeros((1, 3))}, r"euler: expected shape \(20, 3\)"),
    ],
)
def test_estimates_that_do_not_fit_are_refused_before_a_file_is_made(
    tmp_path: Path, name: str, change: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        write_estimate(tmp_path / name, **(estimate() | change))
    assert not (tmp_path / name).exists()
