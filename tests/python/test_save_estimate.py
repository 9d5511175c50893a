"""What `Estimate.save` writes is what other programs read, and gives the estimate back."""

from __future__ import annotations

import dataclasses
import warnings
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from commands import Capture, error_of, output_of, saved
from reading import needs


def angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Between two orientations, rad."""
    one, other = (Rotation.from_quat(quat, scalar_first=True) for quat in (a, b))
    found: np.ndarray = (one.inv() * other).magnitude()
    return found


def recording(duration: float = 4.0) -> ar.Recording:
    return ar.simulate.demo(duration=duration, rate=50.0, seed=5)


def estimate(rec: ar.Recording, **options: object) -> ar.Estimate:
    return ar.MEKF(rate=rec.rate, **options).run(rec, outputs=("covariance",))


def table(path: Path) -> dict[str, np.ndarray]:
    names = path.read_text(encoding="utf-8").splitlines()[0].split(",")
    rows = np.genfromtxt(path, delimiter=",", skip_header=1)
    return dict(zip(names, rows.T, strict=True))


def test_a_table_has_all_that_was_asked_for_and_gives_every_number_back(tmp_path: Path) -> None:
    rec = recording()
    est = estimate(rec)
    est.save(tmp_path / "a.csv", recording=rec)
    columns = table(tmp_path / "a.csv")
    assert_array_equal(np.column_stack([columns[f"q{one}"] for one in "wxyz"]), est.quat)
    assert_array_equal(columns["yaw"], est.euler()[:, 2])
    assert_array_equal(columns["bias_y"], est.gyr_bias[:, 1])
    assert_array_equal(columns["status"], est.status)
    covariance = est.extra["covariance"]
    assert_array_equal(columns["covariance_0_1"], covariance[:, 0, 1])
    assert sum(name.startswith("covariance_") for name in columns) == covariance[0].size
    force = Rotation.from_quat(est.quat, scalar_first=True).apply(rec.acc)
    np.testing.assert_allclose(columns["lin_acc_x"], force[:, 0], atol=1e-12)
    np.testing.assert_allclose(columns["lin_acc_z"], force[:, 2] - 9.80665, atol=1e-12)


def test_angles_are_in_degrees_on_request_and_their_names_say_so(tmp_path: Path) -> None:
    est = estimate(recording())
    est.save(tmp_path / "a.csv", degrees=True)
    columns = table(tmp_path / "a.csv")
    assert "yaw" not in columns
    np.testing.assert_allclose(columns["yaw_deg"], np.rad2deg(est.euler()[:, 2]), rtol=1e-14)
    np.testing.assert_allclose(columns["bias_x_deg_s"], np.rad2deg(est.gyr_bias[:, 0]), rtol=1e-14)
    est.save(tmp_path / "a.npz", degrees=True)
    with np.load(tmp_path / "a.npz") as arrays:
        assert {"euler_deg", "gyr_bias_deg", "covariance"} <= set(arrays)


@needs("pyarrow")
def test_parquet_holds_what_csv_holds(tmp_path: Path) -> None:
    rec = recording()
    est = estimate(rec)
    est.save(tmp_path / "a.csv", recording=rec)
    est.save(tmp_path / "a.parquet", recording=rec)
    import pyarrow.parquet as pq  # here: the package is optional

    written = pq.read_table(tmp_path / "a.parquet")
    for name, values in table(tmp_path / "a.csv").items():
        assert_array_equal(written[name].to_numpy(), values, err_msg=name)


def test_linear_acceleration_is_zero_at_rest_in_either_frame() -> None:
    acc = np.tile([0.0, 0.0, 9.80665], (50, 1))
    for frame, sign in (("ENU", 1.0), ("NED", -1.0)):
        est = ar.Tilt(rate=50.0, frame=frame).run(None, sign * acc)
        np.testing.assert_allclose(est.linear_acceleration(sign * acc), 0.0, atol=1e-12)
        up = est.linear_acceleration(1.1 * sign * acc)[0]
        np.testing.assert_allclose(up, [0.0, 0.0, sign * 0.980665], atol=1e-12)


def test_orientations_for_opensim_are_read_back(tmp_path: Path) -> None:
    recs = {"pelvis_imu": recording(), "femur_r_imu": recording()}
    ests = {name: estimate(rec) for name, rec in recs.items()}
    ar.io.write_sto(tmp_path / "model.sto", ests)
    lines = (tmp_path / "model.sto").read_text(encoding="ascii").splitlines()
    assert "DataType=Quaternion" in lines
    assert "DataRate=50.000000" in lines
    head = lines.index("endheader") + 1
    assert lines[head].split("\t") == ["time", "pelvis_imu", "femur_r_imu"]
    rows = [line.split("\t") for line in lines[head + 1 :]]
    assert all(len(row) == 3 and row[1].count(",") == 3 for row in rows)
    every = ar.read_all(tmp_path / "model.sto")
    for name, est in ests.items():
        back = every[name].device_quat if every[name].ref is None else every[name].ref
        assert np.max(angle(back, est.quat)) < 1e-6
        np.testing.assert_allclose(every[name].t, est.t, atol=1e-9)


def test_sensors_for_opensim_need_the_same_stamps_or_get_them(tmp_path: Path) -> None:
    first = estimate(recording())
    rec = recording()
    second = ar.MEKF(rate=40.0).run(rec.aligned(rate=40.0))
    ar.io.write_sto(tmp_path / "model.sto", {"a": first, "b": second})
    every = ar.read_all(tmp_path / "model.sto")
    assert_array_equal(every["a"].t, every["b"].t)
    late = dataclasses.replace(first, t=first.t + 100.0)
    with pytest.raises(ValueError, match="time in common"):
        ar.io.write_sto(tmp_path / "b.sto", {"a": first, "b": late})
    with pytest.raises(ValueError, match="at least one"):
        ar.io.write_sto(tmp_path / "b.sto", {})
    with pytest.raises(ValueError, match="a b"):
        ar.io.write_sto(tmp_path / "b.sto", {"a b": first})


def test_a_trajectory_text_is_scalar_last(tmp_path: Path) -> None:
    est = estimate(recording())
    est.save(tmp_path / "a.tum")
    rows = np.loadtxt(tmp_path / "a.tum")
    assert_array_equal(rows[:, 1:4], 0.0)
    np.testing.assert_allclose(rows[:, 4:7], est.quat[:, 1:], atol=1e-9)
    np.testing.assert_allclose(rows[:, 7], est.quat[:, 0], atol=1e-9)
    back = ar.read(tmp_path / "a.tum")
    assert np.max(angle(back.device_quat if back.ref is None else back.ref, est.quat)) < 1e-6


@needs("rosbags")
@pytest.mark.parametrize("ending", [".mcap", ".ros2"])
def test_messages_of_ros_hold_attitude_and_readings(tmp_path: Path, ending: str) -> None:
    rec = recording(2.0)
    est = estimate(rec)
    path = tmp_path / f"a{ending}"
    est.save(path, recording=rec)
    from rosbags.highlevel import AnyReader  # here: the package is optional

    kinds: dict[str, list[object]] = {}
    with AnyReader([path]) as reader:
        for connection, _, raw in reader.messages():
            kinds.setdefault(connection.msgtype, []).append(reader.deserialize(raw, connection.msgtype))
    assert set(kinds) >= {"sensor_msgs/msg/Imu", "geometry_msgs/msg/QuaternionStamped"}
    for k, message in enumerate(kinds["sensor_msgs/msg/Imu"]):
        assert_array_equal([getattr(message.angular_velocity, axis) for axis in "xyz"], rec.gyr[k])
        assert_array_equal([getattr(message.linear_acceleration, axis) for axis in "xyz"], rec.acc[k])
        assert_array_equal([getattr(message.orientation, axis) for axis in "wxyz"], est.quat[k])
    for k, message in enumerate(kinds["geometry_msgs/msg/QuaternionStamped"]):
        assert message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec == pytest.approx(est.t[k], abs=1e-9)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.DataWarning)
        back = ar.read(path)
    np.testing.assert_allclose(back.gyr, rec.gyr, rtol=1e-15)


def test_what_cannot_be_saved_is_refused_and_leaves_no_file(tmp_path: Path) -> None:
    rec = recording()
    est = estimate(rec)
    with pytest.raises(ValueError, match=r"path: expected a name that ends in \.csv"):
        est.save(tmp_path / "a.xlsx")
    with pytest.raises(ValueError, match="recording: expected the 200 rows"):
        est.save(tmp_path / "a.csv", recording=rec[:-1])
    many = ar.VQF(rate=50.0).run(np.zeros((2, 50, 3)), np.tile([0.0, 0.0, 9.81], (2, 50, 1)))
    with pytest.raises(ValueError, match="2 side by side"):
        many.save(tmp_path / "a.csv")
    assert not list(tmp_path.iterdir())


def test_recordings_come_back_from_every_format_they_are_saved_in(tmp_path: Path) -> None:
    rec = recording()
    own = ar.Recording.from_streams(
        gyr=(rec.t, rec.gyr),
        acc=(rec.t[::2] + 0.003, rec.acc[::2]),
        mag=(rec.t[::5], rec.mag[::5]),
        ref=(rec.t, rec.ref),
        temperature=(rec.t[::50], np.linspace(20.0, 21.0, 4)),
        pressure=(rec.t[::10], rec.t[::10]),
    )
    own.save(tmp_path / "a.npz")
    back = ar.read(tmp_path / "a.npz")
    assert set(back.streams) == set(own.streams)
    for name, stream in own.streams.items():
        assert_array_equal(back.streams[name].t, stream.t, err_msg=name)
        assert_array_equal(back.streams[name].values, stream.values, err_msg=name)
    for ending in (".csv", ".parquet"):
        own.save(tmp_path / f"a{ending}")
        back = ar.read(tmp_path / f"a{ending}")
        for name in ("t", "gyr", "acc", "mag", "ref", "temperature"):
            assert_array_equal(getattr(back, name), getattr(own, name), err_msg=f"{ending} {name}")


# -- on the command line -------------------------------------------------------------------------------------------


def test_run_writes_degrees_outputs_and_linear_acceleration(tmp_path: Path, capsys: Capture) -> None:
    path = saved(tmp_path / "a.npz")
    options = ["--degrees", "--outputs", "covariance", "--linear-acceleration"]
    output_of(capsys, "run", path, "--filter", "mekf", "-o", tmp_path / "b.csv", *options)
    assert {"yaw_deg", "bias_x_deg_s", "covariance_2_2", "lin_acc_y"} <= set(table(tmp_path / "b.csv"))
    assert "-o" in error_of(capsys, "run", path, "--filter", "mekf", "--degrees")
    assert "has no output 'nope'" in error_of(
        capsys, "run", path, "--filter", "mekf", "-o", tmp_path / "b.csv", "--outputs", "nope"
    )


def test_heading_and_q0_are_the_start_of_a_run(tmp_path: Path, capsys: Capture) -> None:
    rec = ar.Recording(t=np.arange(100) / 50.0, gyr=np.zeros((100, 3)), acc=np.tile([1.0, 2.0, 9.5], (100, 1)))
    rec.save(tmp_path / "a.npz")
    start = ["run", tmp_path / "a.npz", "--filter", "vqf"]
    output_of(capsys, *start, "--heading", 40, "-o", tmp_path / "b.csv", "--degrees")
    yaw = table(tmp_path / "b.csv")["yaw_deg"]
    np.testing.assert_allclose(yaw, 40.0, atol=1e-6)
    output_of(capsys, "run", tmp_path / "a.npz", "--filter", "vqf", "--q0", "0.6,0,0,0.8", "-o", tmp_path / "c.npz")
    with np.load(tmp_path / "c.npz") as arrays:
        first = ar.VQF(rate=50.0).run(rec, q0=[0.6, 0.0, 0.0, 0.8]).quat
        assert_array_equal(arrays["quat"], first)
    assert "four numbers" in error_of(capsys, "run", tmp_path / "a.npz", "--filter", "vqf", "--q0", "1,0,0")
    both = error_of(capsys, "run", tmp_path / "a.npz", "--filter", "vqf", "--q0", "1,0,0,0", "--heading", 0)
    assert both == "--heading and --q0: expected one of them"


# -- a truth from another file -------------------------------------------------------------------------------------


def test_a_truth_of_another_clock_and_rate_is_joined(tmp_path: Path, capsys: Capture) -> None:
    rec = ar.simulate.demo(duration=30.0, rate=100.0, seed=2)
    bare = ar.Recording(t=rec.t, gyr=rec.gyr, acc=rec.acc, mag=rec.mag)
    truth = ar.Recording.from_streams(ref=(rec.t[::3] + 4.237, rec.ref[::3]))
    joined = ar.join_reference(bare, truth)
    # A hundredth of a second of a motion of some rad/s: what the clocks of such files agree to.
    assert joined.meta["reference"]["offset"] == pytest.approx(-4.237, abs=0.01)
    known = ~np.isnan(joined.ref[:, 0])
    assert known.mean() > 0.95
    assert np.rad2deg(np.sqrt(np.mean(angle(joined.ref[known], rec.ref[known]) ** 2))) < 1.0
    given = ar.join_reference(bare, truth, offset=-4.237)
    known = ~np.isnan(given.ref[:, 0])
    # Slerp over three samples of a smooth motion.
    assert np.rad2deg(np.max(angle(given.ref[known], rec.ref[known]))) < 0.2
    bare.save(tmp_path / "imu.npz")
    truth.save(tmp_path / "optical.npz")
    out = output_of(
        capsys, "compare", tmp_path / "imu.npz", "--filters", "vqf", "--reference", tmp_path / "optical.npz"
    )
    assert "VQF" in out


def test_a_truth_that_is_none_of_this_motion_is_refused() -> None:
    rec = ar.simulate.demo(duration=20.0, rate=100.0, seed=2)
    other = ar.simulate.demo(duration=20.0, rate=100.0, seed=9)
    still = np.tile([1.0, 0.0, 0.0, 0.0], (200, 1))
    with pytest.raises(ValueError, match="other: expected a recording with ref"):
        ar.join_reference(rec, ar.Recording(t=rec.t, gyr=rec.gyr))
    with pytest.raises(ValueError, match="other:"):
        ar.join_reference(rec, ar.Recording.from_streams(ref=(rec.t[:200], still)))
    with pytest.raises(ValueError, match="no orientation at the times"):
        ar.join_reference(rec, ar.Recording.from_streams(ref=(other.t + 1e3, other.ref)), offset=0.0)
