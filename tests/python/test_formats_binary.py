"""Axivity, C3D, GoPro, Gyroflow and telemachus."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from devices import cwa, gopro, readings, samples, texts, written
from reading import needs, told

N = 400


@needs("cwa_reader_rs")
class TestAxivity:
    def test_counts_come_back_to_the_bit_of_float32(self, tmp_path: Path) -> None:
        rec, said = told(samples.axivity(tmp_path, N))
        assert said == []
        counts = samples.axivity_values(N).astype(np.float64)
        assert np.array_equal(rec.acc, counts[:, 3:] / 4096 * 9.80665)
        # The library scales in float32.
        assert np.allclose(rec.gyr, np.radians(counts[:, :3] * 2000 / 32768), rtol=2.0**-23)
        assert np.allclose(rec.t, 0.01 * np.arange(N), atol=1e-9, rtol=0)

    @pytest.mark.parametrize("lost", [(4,), (4, 5), (3, 4, 5, 6)])
    def test_lost_blocks_are_gaps_in_time_though_the_library_stretches_over_them(
        self, tmp_path: Path, lost: tuple[int, ...]
    ) -> None:
        path = tmp_path / "device.cwa"
        path.write_bytes(cwa.log(samples.axivity_values(N), 100.0, samples.START, lost=lost))
        rec, said = told(path)
        kept = [k for k in range(N) if k // 40 not in lost]
        assert np.allclose(rec.t, 0.01 * np.array(kept), atol=1.5e-6, rtol=0)  # the library rounds to 1 µs
        assert said == [f"{len(lost)} blocks by their sequence numbers; they are gaps in time"]

    def test_a_file_that_ends_within_a_block_gives_what_came_before(self, tmp_path: Path) -> None:
        path = samples.axivity(tmp_path, N)
        path.write_bytes(path.read_bytes()[:-100])
        rec, said = told(path)
        assert len(rec) == N - 40
        assert said == ["the last block is cut off and left out"]

    def test_wrong_checksums_are_told_as_the_library_does_not(self, tmp_path: Path) -> None:
        path = samples.axivity(tmp_path, N)
        content = bytearray(path.read_bytes())
        content[cwa_block(3) + 100] ^= 1
        content[cwa_block(5)] = 0
        path.write_bytes(content)
        _, said = told(path)
        assert "1 of 10 blocks have a wrong checksum, first 3" in said[0]
        assert "1 of 10 blocks are no data, first block 5; they are gaps in time" in said[0]

    def test_sensors_are_listed_from_header_and_counts(self, tmp_path: Path) -> None:
        info = ar.sensors(samples.axivity(tmp_path, N))[0]
        assert info.samples == {"gyr": N, "acc": N}
        assert info.rates["gyr"] == 100.0


def cwa_block(number: int) -> int:
    """Where a block begins."""
    return 1024 + 512 * number


@needs("ezc3d")
class TestC3D:
    def test_analog_channels_come_back_to_the_bit_of_float32(self, tmp_path: Path) -> None:
        rec, said = told(written.c3d(tmp_path / "walk.c3d", N))
        assert said == []
        stored = (readings.acc(N) / 9.80665).astype(np.float32).astype(np.float64)
        assert np.array_equal(rec.acc, stored * 9.80665)
        assert np.array_equal(rec.mag, readings.mag(N).astype(np.float32).astype(np.float64))
        assert np.allclose(rec.gyr, readings.gyr(N), rtol=2.0**-23)
        assert rec.rate == 1000.0

    def test_units_that_the_file_leaves_empty_are_asked_for(self, tmp_path: Path) -> None:
        path = written.c3d(tmp_path / "walk.c3d", N, units=("", "", ""))
        with pytest.raises(
            ValueError, match=r"state no unit: give it, as units=\{'acc': 'g', 'gyr': 'deg/s', 'mag': 'uT'\}"
        ):
            ar.read(path)
        rec = ar.read(path, units={"acc": "g", "gyr": "deg/s", "mag": "uT"})
        assert np.allclose(rec.gyr, readings.gyr(N), rtol=2.0**-23)
        assert rec.meta["units"]["gyr"] == "deg/s"

    @pytest.mark.parametrize(
        "labels", ["{sensor}: {}.{}", "{sensor}_{}{}", "IM {}{}{sensor}", "{}_{} {sensor}", "{}{sensor}.{}"]
    )
    def test_labels_of_several_sensors_are_told_apart(self, tmp_path: Path, labels: str) -> None:
        path = written.c3d(tmp_path / "walk.c3d", N, labels=labels, sensors=("1", "2"))
        names = [one.name for one in ar.sensors(path)]
        assert len(names) == 2
        assert names[0].endswith("1")
        for name in names:
            assert np.allclose(ar.read(path, sensor=name).gyr, readings.gyr(N), rtol=2.0**-23)

    def test_a_file_that_is_cut_gives_what_came_before_and_says_so(self, tmp_path: Path) -> None:
        path = written.c3d(tmp_path / "walk.c3d", N)
        path.write_bytes(path.read_bytes()[:-3000])
        rec, said = told(path)
        assert 0 < len(rec) < N
        assert said == [f"of {N} samples that the file states or has room for, {len(rec)} were read"]

    def test_frames_beyond_the_16_bits_of_the_header_are_told(self, tmp_path: Path) -> None:
        rec, said = told(written.c3d(tmp_path / "long.c3d", 70_000, a_frame=1))
        # Room is counted in frames of 52 bytes, to the end of a block of 512.
        assert len(rec) == 65_535
        assert re.fullmatch(r"of 7000\d samples that the file states or has room for, 65535 were read", said[0])

    def test_a_text_that_begins_with_gps_is_no_c3d(self, tmp_path: Path) -> None:
        path = tmp_path / "log.csv"
        gyr = readings.gyr(N)
        path.write_text(
            texts.lines(
                ["GPSTime (s),gyr_x (rad/s),gyr_y (rad/s),gyr_z (rad/s)"], np.column_stack([0.01 * np.arange(N), gyr])
            )
        )
        assert ar.read(path, units={"t": "s"}, columns={"t": "GPSTime (s)"}).meta["format"] == "csv"

    def test_other_channels_alone_are_refused_by_name(self, tmp_path: Path) -> None:
        path = written.c3d(tmp_path / "walk.c3d", N, labels="Force{}{}", units=("N", "N", "N"))
        content = path.read_bytes().replace(b"ForceAcc", b"ForceFzz").replace(b"ForceGyr", b"ForceFxx")
        path.write_bytes(content.replace(b"ForceMag", b"ForceFyy"))
        with pytest.raises(ValueError, match=r"no analog channels of an inertial sensor .*ForceFzzX"):
            ar.read(path)

    def test_a_file_that_crashes_the_library_is_an_error(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        from ahrs_rs.io import _child

        path = written.c3d(tmp_path / "walk.c3d", N)
        crash = "import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)"
        monkeypatch.setattr(_child, "_START", crash)
        with pytest.raises(ValueError, match=r"walk.c3d: is not a readable C3D file: the library crashed on it"):
            ar.read(path)
        monkeypatch.setattr(_child, "_START", "import time\ntime.sleep(60)")
        monkeypatch.setattr(_child, "SECONDS", 0.5)
        with pytest.raises(ValueError, match=r"the library did not end within 1 s|did not end within 0 s"):
            ar.read(path)

    @pytest.mark.skipif(sys.platform != "linux", reason="memory is bounded on Linux")
    def test_a_library_that_wants_too_much_memory_is_an_error(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        from ahrs_rs.io import _child

        path = written.c3d(tmp_path / "walk.c3d", N)
        start = _child._START.replace(
            "_child.main", "from ahrs_rs.io import _c3d\n_c3d.in_child = lambda path: bytearray(10**9)\n_child.main"
        )
        monkeypatch.setattr(_child, "_START", start)
        with pytest.raises(ValueError, match=r"the library wanted too much memory"):
            ar.read(path)


@needs("telemetry_parser")
class TestGoPro:
    def test_both_sensors_come_back_at_their_own_rates(self, tmp_path: Path) -> None:
        rec, said = told(samples.video(tmp_path, N))
        assert said == []
        # ORIN YxZ: the channels are y, -x and z of the camera; ORIO ZXY gives the order of the output.
        stored = np.rint(readings.gyr(N) * 1000) / 1000
        assert np.allclose(np.abs(rec.gyr), np.abs(stored[:, [2, 1, 0]]), atol=1e-15)
        assert rec.rate == pytest.approx(200.0)
        assert rec.streams["acc"].rate == pytest.approx(100.0)
        assert len(rec.streams["acc"]) == N // 2

    def test_the_axes_are_a_rotation_of_the_files(self, tmp_path: Path) -> None:
        rec, _ = told(samples.video(tmp_path, N))
        stored = np.rint(readings.gyr(N) * 1000) / 1000
        turn, *_ = np.linalg.lstsq(stored, rec.gyr, rcond=None)
        assert np.linalg.det(turn) == pytest.approx(1.0)
        acc = np.rint(readings.acc(N)[::2] * 100) / 100
        assert np.allclose(acc @ turn, rec.streams["acc"].values, atol=1e-9)

    def test_a_lost_payload_is_a_gap_though_the_library_closes_it(self, tmp_path: Path) -> None:
        path = tmp_path / "video.mp4"
        path.write_bytes(gopro.mp4(*samples.video_payloads(800, lost=(1,))))
        rec, said = told(path)
        assert len(rec) == 600
        assert np.diff(rec.t).max() == pytest.approx(1.005, abs=1e-9)
        assert "200 samples of gyr by TSMP" in said[0]
        assert "100 samples of acc by TSMP" in said[0]
        assert rec.streams["acc"].t[100] == pytest.approx(rec.t[200], abs=1e-9)

    def test_a_video_without_telemetry_is_refused(self, tmp_path: Path) -> None:
        path = tmp_path / "video.mp4"
        path.write_bytes(gopro.mp4([gopro.payload(gopro.nest("STRM", gopro.text("STNM", "nothing")))], [1000]))
        with pytest.raises(ValueError, match=r"video.mp4: is (a video without|not a readable GoPro)"):
            ar.read(path)


class TestGyroflow:
    def test_integers_are_scaled_and_turned(self, tmp_path: Path) -> None:
        path = tmp_path / "video.gcsv"
        path.write_text(texts.gcsv(N))
        rec, said = told(path)
        assert said == []
        raw = np.rint(readings.gyr(N) * 1e4) * 1e-4
        assert np.allclose(rec.gyr, np.column_stack([raw[:, 1], -raw[:, 0], raw[:, 2]]), atol=1e-15)
        assert np.allclose(rec.mag[:, 2], np.rint(readings.mag(N)[:, 2] * 10) * 1e-3 * 100, rtol=1e-15)  # gauss
        assert rec.rate == pytest.approx(1000.0)

    def test_a_mirror_image_is_left_as_it_is_and_told(self, tmp_path: Path) -> None:
        path = tmp_path / "video.gcsv"
        path.write_text(texts.gcsv(N, orientation="YXZ"))
        rec, said = told(path)
        assert said == ["orientation 'YXZ' is no rotation, so axes are left as in the file"]
        assert np.allclose(rec.gyr, np.rint(readings.gyr(N) * 1e4) * 1e-4, atol=1e-15)

    def test_a_scale_that_is_missing_is_named(self, tmp_path: Path) -> None:
        path = tmp_path / "video.gcsv"
        path.write_text(texts.gcsv(N).replace("gscale,0.0001\n", ""))
        with pytest.raises(ValueError, match=r"gscale: expected a positive number, got ''"):
            ar.read(path)


class TestTelemachus:
    def test_columns_come_back_to_the_bit(self, tmp_path: Path) -> None:
        rec, said = told(written.telemachus(tmp_path / "trip.parquet", N))
        assert np.array_equal(rec.gyr, readings.gyr(N))
        assert np.array_equal(rec.acc, readings.acc(N))
        assert np.array_equal(rec.mag, readings.mag(N))
        assert np.array_equal(rec.t, 10_000 * np.arange(N) * 1e-6)
        assert said == ["acceleration is with gravity, by its norm (there is no manifest)"]

    def test_what_is_without_gravity_is_never_the_specific_force(self, tmp_path: Path) -> None:
        rec, said = told(written.telemachus(tmp_path / "trip.parquet", N, gravity=False))
        assert rec.acc is None
        assert "linear_acceleration" in rec.streams
        assert "without gravity" in said[0]

    def test_the_manifest_tells_it_for_each_period(self, tmp_path: Path) -> None:
        folder = tmp_path / "dataset"
        folder.mkdir()
        written.telemachus(folder / "trip.parquet", N)
        periods = (
            "dataset_id: fr_x_2026\nacc_periods:\n  - start: '2026-01-01T00:00:00Z'\n    end: 2026-01-01T00:00:01Z\n"
        )
        periods += (
            "    frame: raw\n  - start: 2026-01-01T00:00:01Z\n    end: 2026-01-02T00:00:00Z\n    frame: compensated\n"
        )
        (folder / "manifest.yaml").write_text(periods)
        rec, said = told(folder)
        assert said == []
        assert rec.acc is not None
        assert np.isfinite(rec.streams["acc"].values).all()
        assert rec.streams["acc"].t[-1] == pytest.approx(0.99)
        assert rec.streams["linear_acceleration"].t[0] == pytest.approx(1.0)
