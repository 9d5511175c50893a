"""What is applied: y = S (x − b), with the bits of the core, over arrays, recordings, files and firmware."""

from __future__ import annotations

import dataclasses
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs.calibration import Calibration, Calibrations, CalibrationWarning, TemperatureCalibration
from calibrated import DEGREE, TABLE_4_ACC, TABLE_4_GYR, WRITTEN_MAG, FloatArray
from recordings import recording

WRITTEN = Path(__file__).resolve().parents[1] / "calibration" / "written.rs"


def by_hand(matrix: Any, offset: Any, x: Any) -> FloatArray:
    """Sum after sum, as the core computes, in the dtype of x."""
    d = x - offset.astype(x.dtype)
    m = matrix.astype(x.dtype)
    return np.stack([(m[i, 0] * d[..., 0] + m[i, 1] * d[..., 1]) + m[i, 2] * d[..., 2] for i in range(3)], axis=-1)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("shape", [(3,), (5, 3), (2, 4, 3), (0, 3)])
def test_apply_has_the_bits_of_the_core_in_its_dtype(dtype: Any, shape: tuple[int, ...]) -> None:
    # tests/calibration.rs shows that the core has the bits of the same sums.
    random = np.random.default_rng(0)
    x = (50 * random.standard_normal(shape)).astype(dtype)
    cal = Calibration(random.standard_normal((3, 3)), random.standard_normal(3))
    y = cal.apply(x)
    assert y.dtype == dtype
    assert np.array_equal(y, by_hand(cal.matrix, cal.offset, x))
    temperature = random.uniform(10, 40, shape[:-1])
    warm = TABLE_4_ACC.apply(x, temperature)
    t = np.asarray(temperature).astype(dtype)[..., None]
    gain = TABLE_4_ACC.gain_slope.astype(dtype) * t + TABLE_4_ACC.gain_at_zero.astype(dtype)
    bias = TABLE_4_ACC.bias_slope.astype(dtype) * t + TABLE_4_ACC.bias_at_zero.astype(dtype)
    assert warm.dtype == dtype
    # Zero times the other axes adds a signed zero at most, which is equal.
    assert np.array_equal(warm, (dtype(1) / gain) * (x - bias))


def test_layouts_and_integers_are_taken_and_missing_rows_stay_missing() -> None:
    x = np.arange(30.0).reshape(10, 3)
    cal = WRITTEN_MAG
    expected = cal.apply(x)
    assert np.array_equal(cal.apply(x.astype(np.int32)), expected)
    assert np.array_equal(cal.apply(np.asfortranarray(x)), expected)
    assert np.array_equal(cal.apply(x[::-1])[::-1], expected)
    assert np.array_equal(cal.apply(x.tolist()), expected)
    x[3, 1] = np.nan
    assert np.isnan(cal.apply(x)[3]).all()
    assert np.array_equal(np.delete(cal.apply(x), 3, axis=0), np.delete(expected, 3, axis=0))


@pytest.mark.parametrize(
    ("x", "message"),
    [
        (np.zeros(4), r"x: expected shape \(\.\.\., 3\), got \(4,\)"),
        (np.array([1.0, np.inf, 0.0]), "x: expected finite values"),
        (["a", "b", "c"], "x: expected an array of"),
    ],
)
def test_what_is_no_reading_is_refused(x: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        WRITTEN_MAG.apply(x)
    with pytest.raises(ValueError, match=r"temperature: expected shape|x: expected|operands|broadcast"):
        TABLE_4_ACC.apply(np.zeros((4, 3)), np.zeros(5))


def test_inverse_and_composition_are_those_of_maps() -> None:
    random = np.random.default_rng(1)
    first = Calibration(np.eye(3) + 0.1 * random.standard_normal((3, 3)), random.standard_normal(3))
    x = random.standard_normal((20, 3))
    # A few roundings of numbers of order one, times the condition of the matrices.
    assert np.allclose(first.inverse().apply(first.apply(x)), x, rtol=0, atol=1e-14)
    assert np.allclose(WRITTEN_MAG.after(first).apply(x), WRITTEN_MAG.apply(first.apply(x)), rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.eye(2), np.zeros(3)), r"matrix: expected shape \(3, 3\), got \(2, 2\)"),
        ((np.eye(3), np.zeros(2)), r"offset: expected shape \(3,\)"),
        ((np.full((3, 3), np.nan), np.zeros(3)), "matrix: expected finite numbers"),
        ((np.ones((3, 3)), np.zeros(3)), "matrix: expected one that has an inverse"),
        ((np.eye(3), ["x", "y", "z"]), "offset: expected numbers"),
    ],
)
def test_what_is_no_calibration_is_refused(arguments: tuple[Any, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Calibration(*arguments)


def test_a_calibration_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match="read-only"):
        WRITTEN_MAG.matrix[0, 0] = 2.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        WRITTEN_MAG.offset = np.zeros(3)  # type: ignore[misc]


# Table 4 of Hyyti & Visala.


def test_the_values_of_table_4_are_applied_as_equations_16_and_17_say() -> None:
    # By hand at 25 °C: gain x = -0.00049316 · 25 + 1.06731340 = 1.0549844, bias x = -0.01551443 · 25 + 0.99740194 =
    # 0.60954119 m/s²; gain z = 1.00625357, bias z = 0.00636298 m/s². The digits that are given make 1e-8.
    at = TABLE_4_ACC.at(25.0)
    assert np.diag(at.matrix) == pytest.approx([1 / 1.0549844, 1 / 1.04881235, 1 / 1.00625357], abs=1e-8)
    assert at.offset == pytest.approx([0.60954119, -0.05580954, 0.00636298], abs=1e-8)
    raw = np.array([0.60954119, -0.05580954, 0.00636298 + 1.00625357 * 9.80665])
    assert TABLE_4_ACC.apply(raw, 25.0) == pytest.approx([0.0, 0.0, 9.80665], abs=1e-7)


def test_the_gyroscope_of_table_4_drifts_as_the_paper_says_with_biases_in_degrees_per_second() -> None:
    # "the change in gyroscope bias can be as large as 0.5 deg/s" from 15 to 35 °C: the model gives 0.24, 0.17 and 0.11.
    change = (TABLE_4_GYR.at(35.0).offset - TABLE_4_GYR.at(15.0).offset) / DEGREE
    assert change == pytest.approx([-0.237666, -0.169142, 0.1084764], abs=1e-9)
    assert np.abs(change).max() < 0.5


def test_model_and_calibration_undo_each_other_at_every_temperature() -> None:
    random = np.random.default_rng(2)
    y, t = 10 * random.standard_normal((200, 3)), random.uniform(-40, 85, 200)
    for cal in (TABLE_4_ACC, TABLE_4_GYR):
        gain = cal.gain_slope * t[:, None] + cal.gain_at_zero
        x = gain * y + cal.bias_slope * t[:, None] + cal.bias_at_zero
        # Three roundings of numbers below 60.
        assert np.allclose(cal.apply(x, t), y, rtol=0, atol=3e-14)
        assert np.allclose(cal.apply(x[0], t[0]), cal.at(t[0]).apply(x[0]), rtol=0, atol=1e-15)


def test_an_unknown_temperature_is_the_last_known_one() -> None:
    x, t = np.ones((6, 3)), np.array([np.nan, 20.0, np.nan, np.nan, 30.0, np.nan])
    held = np.array([20.0, 20.0, 20.0, 20.0, 30.0, 30.0])
    assert np.array_equal(TABLE_4_ACC.apply(x, t), TABLE_4_ACC.apply(x, held))
    with pytest.raises(ValueError, match="temperature: expected at least one that is known"):
        TABLE_4_ACC.apply(x, np.full(6, np.nan))


def test_a_gain_that_is_not_positive_is_refused() -> None:
    with pytest.raises(ValueError, match="gain: expected positive ones over the range"):
        TemperatureCalibration(-np.ones(3), np.ones(3), np.zeros(3), np.zeros(3), range=(0.0, 2.0))
    with pytest.raises(ValueError, match="every gain is positive"):
        TABLE_4_GYR.at(1000.0)


# Recordings.


def test_recordings_are_calibrated_where_there_is_something_to_calibrate() -> None:
    rec = recording()
    cal = Calibrations(acc=TABLE_4_ACC, mag=WRITTEN_MAG)
    done = cal.apply(rec)
    assert done.meta["calibrated"] == ["acc", "mag"]
    assert np.array_equal(done.gyr, rec.gyr)
    assert rec.temperature is not None
    assert np.array_equal(done.acc, TABLE_4_ACC.apply(rec.acc, rec.temperature))
    assert np.array_equal(done.mag, WRITTEN_MAG.apply(rec.mag))
    assert "calibrated" not in rec.meta
    assert cal.apply(dataclasses.replace(rec, mag=None)).mag is None
    with pytest.raises(ValueError, match="temperature: needed for the calibration of acc"):
        cal.apply(dataclasses.replace(rec, temperature=None))


def test_temperatures_outside_of_the_range_are_told() -> None:
    rec = recording()  # 20 to 30 °C
    narrow = dataclasses.replace(TABLE_4_ACC, range=(15.0, 21.0))
    with pytest.warns(CalibrationWarning, match=r"acc was calibrated from 15 to 21 °C; \d+ of 50 samples are outside"):
        Calibrations(acc=narrow).apply(rec)


# cal.json.


def test_a_file_gives_back_what_was_saved_to_the_last_bit(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    mag = Calibration(random.standard_normal((3, 3)), random.standard_normal(3), {"norm": 48.0, "unit": "µT"})
    acc = dataclasses.replace(TABLE_4_ACC, range=(15.0, 35.0), covariance=np.eye(12) / 3.0)
    Calibrations(acc=acc, mag=mag).save(tmp_path / "cal.json")
    back = ar.calibration.load(tmp_path / "cal.json")
    assert back == Calibrations(acc=acc, mag=mag)
    assert isinstance(back.acc, TemperatureCalibration)
    assert np.array_equal(back.acc.covariance, acc.covariance)
    assert back.mag is not None
    assert back.mag.info == {"norm": 48.0, "unit": "µT"}
    text = (tmp_path / "cal.json").read_text(encoding="utf-8")
    assert json.loads(text)["version"] == 1
    assert max(map(len, text.splitlines())) < 400
    assert text.count("\n") < 80  # rows of a matrix in a line each


def test_saving_one_sensor_keeps_the_others(tmp_path: Path) -> None:
    path = tmp_path / "cal.json"
    WRITTEN_MAG.save(path, "mag")
    assert Calibration.load(path) == WRITTEN_MAG
    TABLE_4_ACC.save(path, "acc")
    assert Calibration.load(path, "mag") == WRITTEN_MAG
    assert TemperatureCalibration.load(path, "acc") == TABLE_4_ACC
    with pytest.raises(ValueError, match=r"sensor: expected a name, as .* holds acc, mag"):
        Calibration.load(path)
    with pytest.raises(ValueError, match="calibrated over the temperature"):
        Calibration.load(path, "acc")
    with pytest.raises(ValueError, match="calibrated for one temperature"):
        TemperatureCalibration.load(path, "mag")
    with pytest.raises(ValueError, match="holds no calibration of gyr, only of acc, mag"):
        Calibration.load(path, "gyr")
    with pytest.raises(ValueError, match="sensor: expected one of gyr, acc, mag, got 'baro'"):
        WRITTEN_MAG.save(path, "baro")


GOOD = {"format": "ahrs_rs.calibration", "version": 1}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("{", "is not JSON"),
        ("[1]", "is not a calibration"),
        ('{"format": "other"}', "is not a calibration"),
        (json.dumps(GOOD | {"version": 2}), "expected version 1 of the format, got 2"),
        (json.dumps(GOOD | {"magn": {}}), "expected the sensors gyr, acc, mag, got 'magn'"),
        (json.dumps(GOOD | {"mag": {}}), "there is no gain_slope"),
        (json.dumps(GOOD | {"mag": 5}), "expected the numbers of a sensor, got 5"),
        (json.dumps(GOOD | {"mag": {"matrix": [[1]], "offset": [0, 0, 0]}}), r"matrix: expected shape \(3, 3\)"),
        (json.dumps(GOOD | {"mag": {"matrix": np.eye(3).tolist()}}), "offset"),
    ],
)
def test_what_is_no_calibration_file_is_a_value_error_that_names_it(content: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "cal.json"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(ValueError, match=rf"cal\.json: .*{message}"):
        ar.calibration.load(path)
    with pytest.raises(ValueError, match=r"cal\.json"):
        WRITTEN_MAG.save(path, "acc")  # what is no calibration is not written over
    assert path.read_text(encoding="utf-8") == content


# Firmware.


def test_the_rust_that_is_written_is_what_the_core_is_tested_with() -> None:
    assert Calibrations(acc=TABLE_4_ACC, mag=WRITTEN_MAG).to_rust() == WRITTEN.read_text(encoding="utf-8")


def test_the_c_header_compiles_and_holds_the_float32_numbers(tmp_path: Path) -> None:
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    (tmp_path / "cal.h").write_text(Calibrations(acc=TABLE_4_ACC, mag=WRITTEN_MAG).to_c())
    show = "".join(f'printf("%.9g\\n", (double)MAG_MATRIX[{i}][{j}]);' for i in range(3) for j in range(3))
    show += "".join(f'printf("%.9g\\n", (double)ACC_BIAS_SLOPE[{i}]);' for i in range(3))
    unused = "(void)MAG_OFFSET; (void)ACC_GAIN_SLOPE; (void)ACC_GAIN_AT_ZERO; (void)ACC_BIAS_AT_ZERO;"
    source = f'#include <stdio.h>\n#include "cal.h"\n#include "cal.h"\nint main(void) {{ {unused} {show} return 0; }}\n'
    (tmp_path / "main.c").write_text(source)
    command = [compiler, "-std=c99", "-Wall", "-Wextra", "-Werror", "-o", "main", "main.c"]
    subprocess.run(command, cwd=tmp_path, check=True, timeout=60)
    out = subprocess.run(["./main"], cwd=tmp_path, check=True, capture_output=True, text=True, timeout=60).stdout
    expected = np.concatenate((WRITTEN_MAG.matrix.ravel(), TABLE_4_ACC.bias_slope)).astype(np.float32)
    assert np.array_equal(np.array(out.split(), dtype=np.float32), expected)


def test_names_of_constants_and_numbers_out_of_range_are_checked() -> None:
    with pytest.raises(ValueError, match="name: expected a name of letters"):
        WRITTEN_MAG.to_rust("1 MAG")
    with pytest.raises(ValueError, match="within the range of float32"):
        Calibration(np.eye(3), np.full(3, 1e39)).to_c()
    with pytest.raises(ValueError, match="at least one"):
        Calibrations().to_rust()
