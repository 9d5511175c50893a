"""What the commands tell of what they read, and of the formats there are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from commands import Capture, error_of, output_of


def with_device(path: Path, drift: float) -> ar.Recording:
    """A recording whose device estimated its own orientation, with a heading that is off by `drift` degrees."""
    rec = ar.simulate.demo(duration=10.0, rate=50.0, seed=1)
    off = Rotation.from_euler("z", drift, degrees=True) * Rotation.from_quat(rec.ref, scalar_first=True)
    made = ar.Recording.from_streams(
        gyr=(rec.t, rec.gyr),
        acc=(rec.t, rec.acc),
        mag=(rec.t, rec.mag),
        device_quat=(rec.t, off.as_quat(scalar_first=True)),
    )
    made.save(path)
    return rec


def test_a_devices_own_estimate_is_scored_against_only_when_asked(tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "a.npz"
    with_device(path, 10.0)
    assert "RMSE" not in output_of(capsys, "run", path, "--filter", "vqf")
    line = next(
        one
        for one in output_of(capsys, "run", path, "--filter", "vqf", "--against-device").splitlines()
        if one.startswith("RMSE")
    )
    heading = float(line.partition("heading ")[2].partition("°")[0])
    # The heading of the device is 10° off; the filter's own error of some degrees is left of it.
    assert 5.0 < heading < 15.0
    assert "no orientation of the device" in error_of(
        capsys, "run", _without_device(tmp_path), "--filter", "vqf", "--against-device"
    )


def _without_device(tmp_path: Path) -> Path:
    ar.simulate.demo(duration=2.0, rate=50.0).save(tmp_path / "b.npz")
    return tmp_path / "b.npz"


def test_sensors_lists_names_rates_quantities_and_samples(tmp_path: Path, capsys: Capture) -> None:
    t = np.arange(100) / 50.0
    rows = np.column_stack([t, np.tile([0.1, 0.2, 0.3, 0.0, 0.0, 9.8], (100, 2))])
    names = ",".join(f"{place}_{q}_{axis} ({unit})" for place in ("left", "right")
                     for q, unit in (("gyr", "rad/s"), ("acc", "m/s2")) for axis in "xyz")  # fmt: skip
    np.savetxt(tmp_path / "a.csv", rows, fmt="%.6f", delimiter=",", header=f"t (s),{names}", comments="")
    lines = output_of(capsys, "sensors", tmp_path / "a.csv").splitlines()
    for name in ("left", "right"):
        line = next(one for one in lines if name in one)
        for word in ("gyr", "acc", "50", "100"):
            assert word in line, line
    error = error_of(capsys, "run", tmp_path / "a.csv", "--filter", "madgwick")
    assert "give sensor= (--sensor), one of 'left', 'right'" in error
    assert "gyr acc" in output_of(capsys, "run", tmp_path / "a.csv", "--filter", "madgwick", "--sensor", "left")


def test_formats_lists_every_format_with_what_it_needs(capsys: Capture) -> None:
    out = output_of(capsys, "formats")
    for name, known in ar.io.formats().items():
        line = next(one for one in out.splitlines() if one.split() and one.split()[0] == name)
        assert known.title in line
        assert known.library.partition(" ")[0] in line


def test_a_file_without_a_gyroscope_serves_what_needs_none(tmp_path: Path, capsys: Capture) -> None:
    rng = np.random.default_rng(0)
    field = rng.normal(size=(300, 3))
    field = 48.0 * field / np.linalg.norm(field, axis=1, keepdims=True) + [10.0, -5.0, 3.0]
    table = np.column_stack([np.arange(300) / 50.0, field])
    np.savetxt(
        tmp_path / "mag.csv", table, fmt="%.6f", delimiter=",", header="t (s),mx (uT),my (uT),mz (uT)", comments=""
    )
    out = output_of(capsys, "calibrate", "mag", tmp_path / "mag.csv", "-o", tmp_path / "cal.json")
    assert "mag" in out
    error = error_of(capsys, "run", tmp_path / "mag.csv", "--filter", "vqf")
    assert "gyr" in error
    acc = np.column_stack([np.arange(300) / 50.0, np.tile([0.0, 0.0, 9.8], (300, 1)), field])
    head = "t (s),ax (m/s2),ay (m/s2),az (m/s2),mx (uT),my (uT),mz (uT)"
    np.savetxt(tmp_path / "acc.csv", acc, fmt="%.6f", delimiter=",", header=head, comments="")
    for name in ("tilt", "ecompass"):
        assert "acc mag" in output_of(capsys, "run", tmp_path / "acc.csv", "--filter", name)
