"""Recordings that are folders or zip archives: EuRoC, x-IMU3, NGIMU, Sensor Logger, phyphox."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from devices import readings, texts
from reading import needs, told

N = 60


def zipped(folder: Path) -> Path:
    """An archive with the folder at its top."""
    return Path(shutil.make_archive(str(folder.parent / f"{folder.name}_zip"), "zip", folder.parent, folder.name))


class TestEuRoC:
    def test_readings_and_times_come_back_to_the_bit(self, tmp_path: Path) -> None:
        rec, said = told(texts.euroc(tmp_path / "V1_01", N))
        assert said == []
        assert np.array_equal(rec.gyr, readings.gyr(N))
        assert np.array_equal(rec.acc, readings.acc(N))
        assert np.array_equal(rec.t, 5_000_000 * np.arange(N) * 1e-9)

    def test_the_truth_is_turned_from_its_sensor_to_the_imu(self, tmp_path: Path) -> None:
        # T_BS turns sensor to body: x of the body is y of the sensor, y is -x. A quarter turn by -90° about z.
        rec, _ = told(texts.euroc(tmp_path / "turned", N))
        plain, _ = told(texts.euroc(tmp_path / "plain", N, turn="1, 0, 0, 0, 1, 0, 0, 0, 1"))
        assert np.allclose(plain.streams["ref"].values, readings.quat(N)[: N // 2], atol=1e-15)
        q = rec.streams["ref"].values[0]  # the truth is the identity there
        assert np.allclose(q * np.sign(q[0]), [np.sqrt(0.5), 0, 0, -np.sqrt(0.5)], atol=1e-15)
        assert rec.meta["ref_frame"].startswith("z up")
        assert np.array_equal(rec.streams["velocity"].values[0], [0.1, 0.2, 0.3])
        assert np.array_equal(rec.streams["position"].values[0], [1.0, 2.0, 3.0])

    def test_one_file_of_the_folder_is_read_too(self, tmp_path: Path) -> None:
        folder = texts.euroc(tmp_path / "V1_01", N)
        assert np.array_equal(told(folder / "mav0" / "imu0" / "data.csv")[0].gyr, readings.gyr(N))
        truth = told(folder / "mav0" / "state_groundtruth_estimate0" / "data.csv")[0]
        assert truth.gyr is None
        assert np.array_equal(truth.ref, readings.quat(N)[: N // 2])

    def test_stamps_that_a_spreadsheet_has_rounded_are_refused_until_a_rate_is_given(self, tmp_path: Path) -> None:
        folder = texts.euroc(tmp_path / "rounded", N)
        file = folder / "mav0" / "imu0" / "data.csv"
        header, *rows = file.read_text().splitlines()
        file.write_text(
            "\n".join([header, *(f"{float(row.split(',')[0]):.3E},{row.partition(',')[2]}" for row in rows)])
        )
        with pytest.raises(ValueError, match=r"a spreadsheet has rounded .* rate=200"):
            ar.read(folder)
        rec, said = told(folder, rate=200.0)
        assert np.allclose(rec.t, np.arange(N) / 200.0, atol=1e-15)
        assert "the truth, as a given rate says nothing of its stamps" in said[0]


class TestXIO:
    @needs("ximu3")
    def test_what_the_devices_converter_writes_comes_back_to_its_resolution(self, tmp_path: Path) -> None:
        import ximu3

        lines = ['{"ping":{"interface":"USB","name":"x-IMU3","sn":"01234567"}}']
        gyr, acc, mag, quat = (
            np.degrees(readings.gyr(N)),
            readings.acc(N) / 9.80665,
            readings.mag(N) / 50,
            readings.quat(N),
        )
        for k in range(N):
            t = 1_000_000 + 2500 * k
            lines.append(f"I,{t}," + ",".join(f"{v:.6f}" for v in (*gyr[k], *acc[k])))
            if k % 4 == 0:
                lines.append(f"M,{t + 10}," + ",".join(f"{v:.6f}" for v in mag[k]))
                lines.append(f"Q,{t}," + ",".join(f"{v:.6f}" for v in quat[k]))
                lines.append(f"T,{t},25.5")
        recorded = tmp_path / "log.ximu3"
        recorded.write_bytes("".join(f"{line}\r\n" for line in lines).encode())
        with pytest.raises(ValueError, match="is an x-IMU3 file that is not converted"):
            ar.read(recorded)
        ximu3.FileConverter.convert(str(tmp_path), "converted", [str(recorded)])
        folder = tmp_path / "converted"
        for path in (folder, next(folder.iterdir()), zipped(folder)):
            rec, said = told(path)
            assert said == []
            # The library holds float32 and writes 6 decimals.
            assert np.allclose(rec.gyr, readings.gyr(N), rtol=2.0**-23, atol=np.radians(1e-6))
            assert np.allclose(rec.acc, readings.acc(N), rtol=2.0**-23, atol=1e-5)
            assert np.allclose(rec.t, 1.0 + 0.0025 * np.arange(N), atol=1e-9, rtol=0)
            assert np.allclose(rec.streams["mag"].t, 1.00001 + 0.01 * np.arange(N // 4), atol=1e-9, rtol=0)
            assert np.allclose(rec.streams["device_quat"].values, quat[::4], atol=1.1e-6)
            assert rec.meta["device_frame"] == "NWU"
        assert [one.name for one in ar.sensors(folder)] == ["01234567"]

    def test_ngimu_has_its_units_and_a_slower_quaternion(self, tmp_path: Path) -> None:
        rec, said = told(texts.ngimu(tmp_path / "NGIMU - 0035F6E2", N))
        assert said == []
        nine = 0.5e-9
        assert np.allclose(rec.gyr, readings.gyr(N), atol=np.radians(nine), rtol=1e-15)
        assert np.allclose(rec.acc, readings.acc(N), atol=9.9 * nine, rtol=1e-15)
        assert np.allclose(rec.mag, readings.mag(N), atol=nine, rtol=1e-15)
        assert rec.streams["pressure"].values[0] == pytest.approx(101320.0)
        assert len(rec.streams["device_quat"]) == N // 2
        assert rec.meta["units"]["mag"] == "µT"

    def test_folders_of_several_devices_are_several_sensors(self, tmp_path: Path) -> None:
        for name in ("left", "right"):
            texts.ngimu(tmp_path / "session" / name, N)
        recs = ar.read_all(tmp_path / "session")
        assert list(recs) == ["left", "right"]
        with pytest.raises(ValueError, match=r"has several sensors: .*'left', 'right'"):
            ar.read(tmp_path / "session")

    def test_one_file_of_a_device_is_read_too(self, tmp_path: Path) -> None:
        assert len(ar.read(texts.ngimu(tmp_path / "one", N) / "sensors.csv")) == N


class TestSensorLogger:
    @pytest.mark.parametrize("order", ["zyx", "xyz", "yzx"])
    def test_columns_are_taken_by_their_names_in_any_order(self, tmp_path: Path, order: str) -> None:
        folder = texts.sensorlogger(tmp_path / "walk", N, order=order)
        for path in (folder, zipped(folder)):
            rec, said = told(path)
            assert said == []
            assert np.array_equal(rec.gyr, readings.gyr(N))
            assert np.array_equal(rec.acc, readings.acc(N))
            assert np.array_equal(rec.mag, readings.mag(N))
            assert np.array_equal(rec.t, 10_000_000 * np.arange(N) * 1e-9)

    @pytest.mark.parametrize(("platform", "standard"), [("android", "false"), ("ios", "false"), ("ios", "true")])
    def test_specific_force_has_one_sign_on_all_platforms(self, tmp_path: Path, platform: str, standard: str) -> None:
        folder = texts.sensorlogger(tmp_path / "walk", N, platform=platform, standard=standard, total=False)
        rec, said = told(folder)
        assert said == []
        assert np.allclose(rec.acc, readings.acc(N), atol=1e-14)  # a difference and a sum
        gravity = [0.0, 0.0, 9.80665]
        assert np.allclose(rec.streams["linear_acceleration"].values, readings.acc(N) - gravity, atol=1e-14)

    def test_acceleration_without_gravity_is_never_the_specific_force(self, tmp_path: Path) -> None:
        folder = texts.sensorlogger(tmp_path / "walk", N, total=False)
        (folder / "Gravity.csv").unlink()
        rec, said = told(folder)
        assert rec.acc is None
        assert "linear_acceleration" in rec.streams
        assert "without gravity only" in said[0]

    def test_without_metadata_the_sign_is_assumed_and_told(self, tmp_path: Path) -> None:
        folder = texts.sensorlogger(tmp_path / "walk", N, total=False)
        (folder / "Metadata.csv").unlink()
        assert "have the sign of Android" in told(folder)[1][0]

    def test_one_file_tells_its_quantity_by_its_name(self, tmp_path: Path) -> None:
        folder = texts.sensorlogger(tmp_path / "walk", N)
        for name, stream in (("Gyroscope", "gyr"), ("TotalAcceleration", "acc"), ("Magnetometer", "mag")):
            renamed = folder / f"2025_walk_{name}.csv"
            (folder / f"{name}.csv").rename(renamed)
            assert list(told(renamed)[0].streams) == [stream]

    def test_raw_sensors_are_ignored_beside_calibrated_ones_and_told(self, tmp_path: Path) -> None:
        folder = texts.sensorlogger(tmp_path / "walk", N)
        shutil.copy(folder / "Gyroscope.csv", folder / "GyroscopeUncalibrated.csv")
        assert told(folder)[1] == ["GyroscopeUncalibrated.csv, as gyr is calibrated"]
        (folder / "Gyroscope.csv").unlink()
        rec, said = told(folder)
        assert said == []
        assert np.array_equal(rec.gyr, readings.gyr(N))


class TestPhyphox:
    @pytest.mark.parametrize(("separator", "decimal"), [(",", "."), ("\t", "."), ("\t", ","), (";", "."), (";", ",")])
    def test_all_five_choices_of_separator_and_decimal_sign(self, tmp_path: Path, separator: str, decimal: str) -> None:
        folder = texts.phyphox(tmp_path / "phyphox", N, separator=separator, decimal=decimal)
        for path in (folder, zipped(folder)):
            rec, said = told(path)
            assert said == []
            # Ten digits.
            assert np.allclose(rec.gyr, readings.gyr(N), rtol=1e-9)
            assert np.allclose(rec.acc, readings.acc(N), rtol=1e-9)
            assert np.allclose(rec.streams["linear_acceleration"].values, 0.1 * readings.acc(N), rtol=1e-9)
            assert rec.rate == pytest.approx(100.0)
            assert rec.streams["mag"].rate == pytest.approx(50.0)
            assert rec.meta["start"] == "2025-10-09T08:53:20+00:00"

    def test_columns_that_end_early_are_shorter_streams(self, tmp_path: Path) -> None:
        header = '"Time (s)","Gyroscope x (rad/s)","Gyroscope y (rad/s)","Gyroscope z (rad/s)","Acceleration x (m/s^2)"'
        header += ',"Acceleration y (m/s^2)","Acceleration z (m/s^2)"'
        gyr, acc = readings.gyr(N), readings.acc(N)
        rows = [[0.01 * k, *gyr[k], *(acc[k] if k < N // 2 else ["NaN"] * 3)] for k in range(N)]
        path = tmp_path / "Raw Data.csv"
        path.write_text(texts.lines([header], rows))
        rec, said = told(path)
        assert said == []
        assert len(rec.streams["gyr"]) == N
        assert len(rec.streams["acc"]) == N // 2

    def test_a_table_of_others_with_such_a_time_is_none_of_phyphox(self, tmp_path: Path) -> None:
        path = tmp_path / "log.csv"
        header = "Time (s),Gyroscope x (deg/s),Gyroscope y (deg/s),Gyroscope z (deg/s)"
        path.write_text(texts.lines([header], [[0.01 * k, *np.degrees(readings.gyr(N))[k]] for k in range(N)]))
        rec = ar.read(path)
        assert rec.meta["format"] == "csv"
        assert np.allclose(rec.gyr, readings.gyr(N), rtol=1e-12)

    def test_names_in_german_are_understood(self, tmp_path: Path) -> None:
        header = '"Zeit (s)";"Lineare Beschleunigung x (m/s^2)";"Lineare Beschleunigung y (m/s^2)"'
        header += ';"Lineare Beschleunigung z (m/s^2)"'
        rows = [[f"{v:.6f}".replace(".", ",") for v in (0.01 * k, *readings.acc(N)[k])] for k in range(N)]
        path = tmp_path / "Rohdaten.csv"
        path.write_text(texts.lines([header], rows, ";"))
        rec, said = told(path)
        assert list(rec.streams) == ["linear_acceleration"]
        assert "without gravity only" in said[0]


def test_a_folder_of_no_known_device_is_refused_by_what_is_in_it(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("nothing")
    with pytest.raises(IsADirectoryError, match=r"got a directory of no known device \(with notes.txt\)"):
        ar.read(tmp_path)
