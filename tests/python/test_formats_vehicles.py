"""Logs of vehicles and robots: PX4, ArduPilot, ROS."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from devices import dataflash, readings, samples, ulog, written
from reading import needs, told

N = 60


@needs("pyulog")
class TestPX4:
    def test_every_reading_of_a_log_comes_back_to_the_bit_of_float32(self, tmp_path: Path) -> None:
        rec, said = told(samples.px4(tmp_path, N))
        assert said == []
        assert np.array_equal(rec.gyr, readings.gyr(N).astype(np.float32).astype(np.float64))
        acc = readings.acc(N).astype(np.float32).astype(np.float64)
        acc[9::10] = np.nan  # the accelerometer had no new sample
        assert np.array_equal(rec.acc, acc, equal_nan=True)
        assert np.allclose(rec.t, 1.0 + 0.004 * np.arange(N), atol=1e-9, rtol=0)  # µs, summed in float64
        assert rec.meta["axes"] == "front-right-down"

    def test_field_and_attitude_stand_at_their_own_stamps(self, tmp_path: Path) -> None:
        rec, _ = told(samples.px4(tmp_path, N))
        field, attitude = rec.streams["mag"], rec.streams["device_quat"]
        # Gauss in float32 times 100: as µT.
        assert np.array_equal(field.values, (readings.mag(N)[::5] / 100).astype(np.float32).astype(np.float64) * 100)
        assert np.allclose(
            field.t, 0.9995 + 0.02 * np.arange(N // 5), atol=1e-9, rtol=0
        )  # timestamp_sample, not timestamp
        assert np.array_equal(attitude.values, readings.quat(N)[::2].astype(np.float32).astype(np.float64))
        assert rec.ref is None
        assert rec.meta["device_frame"] == "NED"

    def test_samples_of_the_accelerometer_stand_at_their_own_stamps(self, tmp_path: Path) -> None:
        rows = [
            ("sensor_combined", 0, (1_000_000 + 4000 * k, 0.1, 0, 0, 4000, -1500, 0, 0, -9.75, 4000)) for k in range(N)
        ]
        path = tmp_path / "log.ulg"
        path.write_bytes(ulog.log(rows))
        rec, _ = told(path)
        assert np.allclose(rec.streams["acc"].t, rec.streams["gyr"].t - 0.0015, atol=1e-9, rtol=0)

    def test_lost_messages_are_gaps_in_time_and_drop_outs_are_told(self, tmp_path: Path) -> None:
        rows = [row for row in samples.px4_rows(N) if not 1_080_000 <= row[2][0] < 1_160_000]
        path = tmp_path / "log.ulg"
        path.write_bytes(ulog.log(rows, dropouts=[(30, 80)]))
        rec, said = told(path)
        assert len(rec) == N - 20
        assert np.diff(rec.t).max() == pytest.approx(0.084, abs=1e-9)
        assert "1 drop-outs of the logger, 0.08 s" in said[0]

    def test_single_sensors_are_read_by_their_name(self, tmp_path: Path) -> None:
        rows = samples.px4_rows(N)
        for k in range(N):
            for instance in (0, 1):
                t = 1_000_000 + 4000 * k + instance
                rows.append(("sensor_gyro", instance, (t + 100, t, 7, 0.5, instance, 0.0, 30.0)))
                rows.append(("sensor_accel", instance, (t + 100, t, 7, 0.0, 0.0, -9.75, 30.0)))
        path = tmp_path / "log.ulg"
        path.write_bytes(ulog.log(rows))
        assert [one.name for one in ar.sensors(path)] == ["sensor_combined", "sensor_0", "sensor_1"]
        rec, said = told(path)
        assert rec.gyr is not None
        assert rec.gyr[0, 1] != 1.0
        assert "sensor_1: read it by sensor='sensor_1'" in said[0]
        one, said = told(path, sensor="sensor_1")
        assert said == []
        assert np.array_equal(one.gyr, np.tile([0.5, 1.0, 0.0], (N, 1)))
        assert one.t[0] == pytest.approx(1.000001, abs=1e-12)
        with pytest.raises(
            ValueError, match="sensor: expected one of 'sensor_combined', 'sensor_0', 'sensor_1', got 'x'"
        ):
            ar.read(path, sensor="x")

    def test_sensors_are_listed_without_loading_the_log(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        path = samples.px4(tmp_path, N)
        monkeypatch.setitem(sys.modules, "pyulog", None)  # not importable
        info = ar.sensors(path)[0]
        assert info.name == "sensor_combined"
        assert info.samples == {"gyr": N, "acc": N, "mag": N // 5, "device_quat": N // 2}
        assert info.rates["gyr"] == pytest.approx(250.0)

    def test_a_cut_log_gives_what_came_before_and_says_so(self, tmp_path: Path) -> None:
        path = samples.px4(tmp_path, N)
        path.write_bytes(path.read_bytes()[:-30])
        rec, said = told(path)
        assert len(rec) == N - 1
        assert "the file is cut off; what came before was read" in said[0]

    def test_a_whole_log_is_not_called_cut(self, tmp_path: Path) -> None:
        # A log whose last payload has 3 bytes ends as the header of a further message would.
        path = tmp_path / "log.ulg"
        path.write_bytes(ulog.log(samples.px4_rows(N)) + ulog.message("X", bytes(3)))
        assert told(path)[1] == []


@needs("pymavlink")
class TestArduPilot:
    def test_instances_are_sensors_and_read_to_the_bit_of_float32(self, tmp_path: Path) -> None:
        path = samples.ardupilot(tmp_path, N)
        with pytest.raises(ValueError, match=r"has several sensors: give sensor= .*'IMU0', 'IMU1'"):
            ar.read(path)
        for instance in (0, 1):
            rec, said = told(path, sensor=f"IMU{instance}")
            assert said == []
            assert np.array_equal(rec.gyr, (readings.gyr(N) + instance).astype(np.float32).astype(np.float64))
            assert np.array_equal(rec.acc, (-readings.acc(N)).astype(np.float32).astype(np.float64))
            assert np.allclose(rec.t, 1.0 + 0.02 * np.arange(N), atol=1e-9, rtol=0)
            assert np.array_equal(rec.temperature, np.full(N, 35.5))  # T is the temperature, not the time

    def test_field_in_milligauss_and_attitude_in_centidegrees(self, tmp_path: Path) -> None:
        rec, _ = told(samples.ardupilot(tmp_path, N), sensor="IMU0")
        stored = np.rint(readings.mag(N) * 10)[::2]
        assert np.allclose(rec.streams["mag"].values, stored * 0.1, rtol=1e-15)  # one product
        roll, pitch, yaw = np.radians([1.23, -4.56, 359.99])
        q = rec.streams["device_quat"].values[0]
        matrix_z = 2 * (q[1] * q[3] - q[0] * q[2])
        assert matrix_z == pytest.approx(-np.sin(pitch), abs=1e-12)
        assert np.arctan2(2 * (q[0] * q[1] + q[2] * q[3]), 1 - 2 * (q[1] ** 2 + q[2] ** 2)) == pytest.approx(roll)
        heading = np.arctan2(2 * (q[0] * q[3] + q[1] * q[2]), 1 - 2 * (q[2] ** 2 + q[3] ** 2))
        assert heading % (2 * np.pi) == pytest.approx(yaw)

    def test_older_logs_have_a_message_a_sensor(self, tmp_path: Path) -> None:
        rows = []
        for k in range(N):
            t = 1_000_000 + 20_000 * k
            rows.append(("IMU2", (t, 0.0, 0.5, 0.0, 0.0, 0.0, -9.75, 0, 0, 35.0, 1, 1, 1000, 1000)))
        path = tmp_path / "log.bin"
        path.write_bytes(dataflash.log(rows))
        assert [one.name for one in ar.sensors(path)] == ["IMU1"]
        assert np.array_equal(told(path)[0].gyr, np.tile([0.0, 0.5, 0.0], (N, 1)))

    def test_raw_samples_are_sensors_with_the_sensors_time(self, tmp_path: Path) -> None:
        rows = []
        for k in range(N):
            rows.append(("GYR", (2_000_000 + 7 * k, 0, 1_000_000 + 1000 * k, 0.25, 0.0, 0.0)))
            rows.append(("ACC", (2_000_000 + 7 * k, 0, 1_000_400 + 1000 * k, 0.0, 0.0, -9.75)))
        more = {
            "GYR": (20, "QBQfff", "TimeUS,I,SampleUS,GyrX,GyrY,GyrZ"),
            "ACC": (21, "QBQfff", "TimeUS,I,SampleUS,AccX,AccY,AccZ"),
        }
        path = tmp_path / "log.bin"
        path.write_bytes(dataflash.log(rows, more))
        rec, _ = told(path)
        assert rec.rate == pytest.approx(1000.0)
        assert rec.streams["acc"].t[0] == pytest.approx(1.0004, abs=1e-12)

    def test_sensors_are_listed_with_their_samples(self, tmp_path: Path) -> None:
        first = ar.sensors(samples.ardupilot(tmp_path, N))[0]
        assert (first.samples["gyr"], first.samples["mag"]) == (N, N // 2)
        assert first.rates["gyr"] == pytest.approx(50.0)


@needs("rosbags")
@pytest.mark.parametrize("kind", ["ros1", "sqlite3", "mcap"])
class TestROS:
    def path(self, folder: Path, kind: str) -> Path:
        return folder / ("imu.bag" if kind == "ros1" else "bag")

    def test_every_reading_of_a_bag_comes_back_to_the_bit(self, tmp_path: Path, kind: str) -> None:
        rec, said = told(written.ros(self.path(tmp_path, kind), N, kind=kind))
        assert said == []
        assert np.array_equal(rec.gyr, readings.gyr(N))
        assert np.array_equal(rec.acc, readings.acc(N))
        assert np.array_equal(rec.streams["device_quat"].values, readings.quat(N))
        assert np.allclose(rec.streams["mag"].values, readings.mag(N)[::2], rtol=1e-15)  # to tesla and back
        assert rec.ref is None

    def test_times_are_those_of_the_header_to_the_nanosecond(self, tmp_path: Path, kind: str) -> None:
        rec, _ = told(written.ros(self.path(tmp_path, kind), N, kind=kind))
        assert np.array_equal(rec.t, 10_000_000 * np.arange(N) * 1e-9)
        assert rec.meta["start"] == "2023-11-14T22:13:20+00:00"  # the 5 ns are below a microsecond

    def test_an_empty_header_takes_the_time_of_the_recording_and_says_so(self, tmp_path: Path, kind: str) -> None:
        rec, said = told(written.ros(self.path(tmp_path, kind), N, kind=kind, stamped=False, field=False))
        assert np.array_equal(rec.t, 10_000_000 * np.arange(N) * 1e-9)
        assert "header.stamp is empty" in said[0]

    def test_covariance_of_minus_one_is_no_orientation(self, tmp_path: Path, kind: str) -> None:
        rec, _ = told(written.ros(self.path(tmp_path, kind), N, kind=kind, orientation=-1.0))
        assert "device_quat" not in rec.streams

    def test_topics_are_sensors_and_fields_join_by_their_frame(self, tmp_path: Path, kind: str) -> None:
        path = written.ros(self.path(tmp_path, kind), N, kind=kind, namespaces=("/left", "/right"))
        infos = ar.sensors(path)
        assert [one.name for one in infos] == ["/left/data", "/right/data", "/left/mag", "/right/mag"]
        assert infos[0].samples["gyr"] == N
        recs = ar.read_all(path)
        assert list(recs) == ["/left/data", "/right/data"]
        assert np.array_equal(recs["/right/data"].gyr, readings.gyr(N) * 2)
        assert len(recs["/right/data"].streams["mag"]) == N // 2
        assert len(ar.read(path, sensor="/left/data")) == N


@needs("rosbags")
def test_raw_and_filtered_topics_of_one_frame_share_the_magnetometer() -> None:
    from ahrs_rs.io import _ros

    def messages(frame: str) -> _ros._Messages:
        held = _ros._Messages()
        held.frame = frame
        return held

    imus = {"/imu/data_raw": messages("imu"), "/imu/data": messages("imu"), "/other/data": messages("other")}
    assert _ros._owners("/imu/mag", messages("imu"), imus, ["/imu/mag"]) == ["/imu/data_raw", "/imu/data"]
    assert _ros._owners("/other/mag", messages(""), imus, ["/other/mag"]) == ["/other/data"]
    assert _ros._owners("/mag", messages("else"), imus, ["/mag"]) == []


@needs("rosbags")
@pytest.mark.parametrize(
    ("kind", "compression"),
    [
        ("ros1", "LZ4"),
        ("ros1", "BZ2"),
        ("sqlite3", "FILE"),
        ("sqlite3", "MESSAGE"),
        ("mcap", "STORAGE"),
        ("mcap", "FILE"),
    ],
)
def test_a_compressed_bag_gives_the_same(tmp_path: Path, kind: str, compression: str) -> None:
    path = tmp_path / ("imu.bag" if kind == "ros1" else "bag")
    rec, said = told(written.ros(path, N, kind=kind, compression=compression))
    assert said == []
    assert np.array_equal(rec.gyr, readings.gyr(N))
    assert len(rec.streams["mag"]) == N // 2


@needs("rosbags")
def test_a_bare_file_of_a_ros2_bag_is_read_under_any_name(tmp_path: Path) -> None:
    bag = written.ros(tmp_path / "bag", N, kind="mcap")
    plain = tmp_path / "recording"
    plain.write_bytes(next(bag.glob("*.mcap")).read_bytes())
    assert np.array_equal(told(plain)[0].gyr, readings.gyr(N))
