"""Text and HDF5 exports of sensors that are worn: Xsens, Movella, Shimmer, APDM."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from devices import readings, texts, written
from reading import needs, told

N = 80
#: Text with 6 decimals: half of the last one.
SIX = 0.5e-6


def file(folder: Path, name: str, text: str, encoding: str = "utf-8") -> Path:
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path


class TestXsens:
    @pytest.mark.parametrize("separator", ["\t", ",", ";", " "])
    def test_readings_come_back_with_any_separator(self, tmp_path: Path, separator: str) -> None:
        text = texts.xsens(N, separator=separator)
        if separator == " ":  # empty cells cannot be told from blanks
            text = re.sub(" +", " ", text.replace(" Year Month Day Second", ""))
        rec, said = told(file(tmp_path, "MT_1.txt", text))
        assert said == []
        for found, expected in (
            (rec.gyr, readings.gyr(N)),
            (rec.acc, readings.acc(N)),
            (rec.mag, readings.mag(N) / 50),
        ):
            assert np.allclose(found, expected, atol=SIX, rtol=0)
        assert np.allclose(rec.streams["device_quat"].values, readings.quat(N), atol=SIX, rtol=0)
        assert rec.meta["device_frame"] == "ENU"
        assert rec.meta["units"]["mag"] == "normalised"

    def test_a_comma_as_decimal_sign_is_found(self, tmp_path: Path) -> None:
        rec, _ = told(file(tmp_path, "MT.txt", texts.xsens(N, separator=";", decimal=",")))
        assert np.allclose(rec.gyr, readings.gyr(N), atol=SIX, rtol=0)

    def test_counters_that_wrap_go_on_and_lost_packets_are_gaps(self, tmp_path: Path) -> None:
        lost = [*range(20, 25), 47]  # SampleTimeFine wraps at 50, PacketCounter at 36
        rec, said = told(file(tmp_path, "MT.txt", texts.xsens(N, lost=lost)))
        kept = np.setdiff1d(np.arange(N), lost)
        assert np.allclose(rec.t, 0.01 * kept, atol=1e-9, rtol=0)
        assert said == [f"6 of {N} packets by PacketCounter; they are gaps in time"]

    def test_a_packet_without_fine_time_stands_where_its_number_says(self, tmp_path: Path) -> None:
        lost = [20, 21, 22]
        lines = texts.xsens(N, lost=lost).splitlines()
        header = next(i for i, line in enumerate(lines) if line.startswith("PacketCounter"))
        for row in (19, 20):  # those beside the gap
            cells = lines[header + 1 + row].split("\t")
            lines[header + 1 + row] = "\t".join([cells[0], "", *cells[2:]])
        rec, _ = told(file(tmp_path, "MT.txt", "\n".join([*lines, ""])))
        assert np.allclose(rec.t, 0.01 * np.setdiff1d(np.arange(N), lost), atol=1e-9, rtol=0)

    def test_without_fine_times_the_counter_and_the_stated_rate_are_the_clock(self, tmp_path: Path) -> None:
        lost = [10, 11]
        rec, _ = told(file(tmp_path, "MT.txt", texts.xsens(N, fine=False, lost=lost, rate="100.0Hz")))
        assert np.allclose(rec.t, 0.01 * np.setdiff1d(np.arange(N), lost), atol=1e-9, rtol=0)
        assert rec.meta["clock"] == "PacketCounter at 100 Hz"

    def test_without_any_rate_it_is_asked_for_and_then_gaps_stay(self, tmp_path: Path) -> None:
        path = file(tmp_path, "MT.txt", texts.xsens(N, fine=False, lost=[10, 11]))
        with pytest.raises(ValueError, match=r"neither SampleTimeFine nor an update rate: give rate="):
            ar.read(path)
        rec, _ = told(path, rate=50.0)
        assert np.allclose(rec.t, 0.02 * np.setdiff1d(np.arange(N), [10, 11]), atol=1e-9, rtol=0)

    def test_a_matrix_is_read_by_its_names_whatever_their_order(self, tmp_path: Path) -> None:
        q = readings.quat(N)
        w, x, y, z = q.T
        m = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        names = [f"Mat[{row}][{column}]" for column in (1, 2, 3) for row in (1, 2, 3)]
        lines = texts.xsens(N, quat="").splitlines()
        header = next(i for i, line in enumerate(lines) if line.startswith("PacketCounter"))
        lines[header] += "\t" + "\t".join(reversed(names))
        for k in range(N):
            cells = [f"{m[int(name[4]) - 1, int(name[7]) - 1, k]:.9f}" for name in reversed(names)]
            lines[header + 1 + k] += "\t" + "\t".join(cells)
        found = told(file(tmp_path, "MT.txt", "\n".join(lines)))[0].streams["device_quat"].values
        found *= np.sign((found * q).sum(axis=1, keepdims=True))
        assert np.allclose(found, q, atol=2e-9, rtol=0)  # nine decimals of a matrix

    def test_increments_are_named_as_ignored(self, tmp_path: Path) -> None:
        text = texts.xsens(N).replace("Year", "FreeAcc_E")
        assert told(file(tmp_path, "MT.txt", text))[1] == ["columns FreeAcc_E"]


class TestDOT:
    @pytest.mark.parametrize("preamble", [True, False])
    def test_angular_rates_are_deg_per_s_though_the_file_does_not_say_so(self, tmp_path: Path, preamble: bool) -> None:
        rec, said = told(file(tmp_path, "dot.csv", texts.dot(N, preamble=preamble)))
        assert said == []
        assert np.allclose(rec.gyr, readings.gyr(N), atol=np.radians(SIX), rtol=0)
        assert np.allclose(rec.acc, readings.acc(N), atol=SIX, rtol=0)
        assert rec.meta["units"] == {"gyr": "deg/s", "acc": "m/s²", "mag": "normalised"}

    def test_the_orientation_is_the_devices_and_never_the_truth(self, tmp_path: Path) -> None:
        rec, _ = told(file(tmp_path, "dot.csv", texts.dot(N)))
        assert rec.ref is None
        assert np.allclose(rec.device_quat, readings.quat(N), atol=SIX, rtol=0)

    def test_microseconds_of_32_bits_wrap_and_lost_packets_are_gaps(self, tmp_path: Path) -> None:
        lost = [5, 6, 7, 40]  # the clock wraps at 30
        rec, said = told(file(tmp_path, "dot.csv", texts.dot(N, lost=lost)))
        assert np.allclose(rec.t, 0.016667 * np.setdiff1d(np.arange(N), lost), atol=1e-9, rtol=0)
        assert said == [f"4 of {N} packets by PacketCounter; they are gaps in time"]

    def test_euler_angles_are_turned_into_quaternions(self, tmp_path: Path) -> None:
        rec, _ = told(file(tmp_path, "dot.csv", texts.dot(N, orientation="Euler")))
        assert rec.device_quat is not None
        w, x, y, z = rec.device_quat[0]
        assert np.degrees(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))) == pytest.approx(30.0)
        assert np.degrees(np.arcsin(2 * (w * y - x * z))) == pytest.approx(20.0)

    def test_a_mode_without_inertial_data_is_refused_with_what_to_do(self, tmp_path: Path) -> None:
        text = re.sub("(Acc|Gyr|Mag)_", r"Free\1_", texts.dot(N))
        with pytest.raises(ValueError, match=r"dot.csv: has no columns Acc_X, Gyr_X or Mag_X, .*record inertial data"):
            ar.read(file(tmp_path, "dot.csv", text))


class TestShimmer:
    @pytest.mark.parametrize("separator", [",", "\t", ";"])
    def test_calibrated_signals_come_back(self, tmp_path: Path, separator: str) -> None:
        rec, said = told(file(tmp_path, "shimmer.csv", texts.shimmer(N, separator=separator)))
        assert said == []
        assert np.allclose(rec.gyr, readings.gyr(N), atol=1e-9, rtol=0)  # nine decimals
        assert np.allclose(rec.acc, readings.acc(N), atol=1e-9, rtol=0)
        assert rec.meta["units"]["mag"] == "normalised"
        assert rec.rate == pytest.approx(32768 / 328, rel=1e-6)  # "100 Hz"

    def test_of_two_accelerometers_the_low_noise_one_is_taken_unless_it_clips(self, tmp_path: Path) -> None:
        rec, said = told(file(tmp_path, "a.csv", texts.shimmer(N, two=True)))
        assert "acc is Shimmer_5E90_Accel_LN_X_CAL" in said[0]
        assert np.allclose(rec.streams["acc_accel_wr"].values, readings.acc(N), atol=1e-9, rtol=0)
        rec, said = told(file(tmp_path, "b.csv", texts.shimmer(N, two=True, clip=True)))
        assert "has clipped" in said[0]
        assert np.allclose(rec.acc, readings.acc(N), atol=1e-9, rtol=0)
        assert rec.streams["acc_low_noise"].values.max() == 20.0

    def test_the_older_export_has_its_header_in_four_lines(self, tmp_path: Path) -> None:
        rec, said = told(file(tmp_path, "old.csv", texts.shimmer_four_lines(N)))
        assert said == []
        assert np.allclose(rec.gyr, readings.gyr(N), atol=1e-9, rtol=0)
        assert np.allclose(rec.t, 1.0 + 0.01 * np.arange(N), atol=1e-9, rtol=0)

    def test_raw_counts_alone_are_refused_with_what_to_do(self, tmp_path: Path) -> None:
        text = texts.shimmer(N, raw=False).replace("_CAL", "_RAW").replace("Timestamp_Unix_RAW", "Timestamp_Unix_CAL")
        with pytest.raises(ValueError, match=r"export calibrated data from Consensys"):
            ar.read(file(tmp_path, "raw.csv", text))

    def test_units_that_differ_among_axes_are_an_error(self, tmp_path: Path) -> None:
        text = texts.shimmer(N).replace("deg/s,deg/s,deg/s", "deg/s,deg/s,rad/s")
        with pytest.raises(ValueError, match=r"units differ among axes"):
            ar.read(file(tmp_path, "mixed.csv", text))

    def test_two_devices_side_by_side_are_two_sensors(self, tmp_path: Path) -> None:
        one, two = texts.shimmer(N).splitlines(), texts.shimmer(N, device="Shimmer_7F01").splitlines()
        text = "\n".join([one[0], *(a + b for a, b in zip(one[1:], two[1:], strict=True))])
        assert [info.name for info in ar.sensors(file(tmp_path, "both.csv", text))] == ["Shimmer_5E90", "Shimmer_7F01"]


class TestAPDM:
    def test_sensors_side_by_side_are_read_by_their_labels(self, tmp_path: Path) -> None:
        path = file(tmp_path, "apdm.csv", texts.apdm_format_7(N))
        assert [info.name for info in ar.sensors(path)] == ["Lumbar", "Right Foot"]
        rec, said = told(path, sensor="Right Foot")
        assert said == []
        assert np.allclose(rec.gyr, 2 * readings.gyr(N), atol=SIX, rtol=0)
        assert np.allclose(rec.mag, readings.mag(N), atol=SIX, rtol=0)
        assert np.allclose(rec.t, 0.007812 * np.arange(N), atol=1e-9, rtol=0)
        assert rec.meta["start"] == "2019-02-22T23:51:44.438281+00:00"
        assert rec.streams["pressure"].values[0] == pytest.approx(101300.0)

    def test_pressures_written_as_their_bytes_are_read_as_numbers(self, tmp_path: Path) -> None:
        bits = int(np.float64(101.3).view(np.int64))
        text = texts.apdm_format_7(N).replace(",101.300000,", f",{bits}.000000,")
        rec, said = told(file(tmp_path, "apdm.csv", text), sensor="Lumbar")
        # The integer went through a float64 of 53 bits: it is known to 2^10 of the last place.
        assert np.allclose(rec.streams["pressure"].values, 101300.0, rtol=2.0**-42)
        assert "bytes of a float64" in said[0]

    def test_named_columns_over_units_are_read_and_other_units_refused(self, tmp_path: Path) -> None:
        text = texts.apdm_named(N)
        recs = ar.read_all(file(tmp_path, "named.csv", text))
        assert list(recs) == ["Lumbar", "Chest"]
        assert np.allclose(recs["Chest"].acc, readings.acc(N), atol=SIX, rtol=0)
        with pytest.raises(ValueError, match=r"'Lumbar/Acceleration/X': expected unit m/s\^2, got 'g'"):
            ar.read_all(file(tmp_path, "g.csv", text.replace("m/s^2", "g")))

    @needs("h5py")
    @pytest.mark.parametrize("old", [False, True])
    def test_hdf5_comes_back_to_the_bit(self, tmp_path: Path, old: bool) -> None:
        path = written.apdm(tmp_path / "apdm.h5", N, old=old)
        infos = ar.sensors(path)
        assert [one.name for one in infos] == (["SI-005718", "SI-005778"] if old else ["Lumbar", "Chest"])
        assert infos[0].samples == {"gyr": N, "acc": N, "mag": N}
        rec, said = told(path, sensor=infos[1].name)
        assert said == []
        assert np.array_equal(rec.gyr, readings.gyr(N))
        assert np.array_equal(rec.acc, readings.acc(N))
        assert np.array_equal(rec.mag, readings.mag(N))
        assert np.array_equal(rec.device_quat, readings.quat(N))
        assert np.array_equal(rec.t, 7812 * np.arange(N) * 1e-6)  # exact steps since 1970


class TestAnyExport:
    @pytest.mark.parametrize("text", [texts.xsens(N), texts.dot(N), texts.shimmer(N), texts.apdm_named(N, ("Lumbar",))])
    def test_line_ends_byte_order_marks_and_utf_16_make_no_difference(self, tmp_path: Path, text: str) -> None:
        plain = ar.read(file(tmp_path, "plain.csv", text.replace("\r\n", "\n")))
        for name, other, encoding in (
            ("crlf.csv", text.replace("\r\n", "\n").replace("\n", "\r\n"), "utf-8"),
            ("bom.csv", text, "utf-8-sig"),
            ("wide.csv", text, "utf-16"),
        ):
            rec = ar.read(file(tmp_path, name, other, encoding))
            assert np.array_equal(rec.gyr, plain.gyr), name
            assert np.array_equal(rec.t, plain.t), name

    @pytest.mark.parametrize("text", [texts.xsens(N), texts.dot(N), texts.shimmer(N)])
    def test_a_row_that_is_cut_off_is_left_out_and_told(self, tmp_path: Path, text: str) -> None:
        rec, said = told(file(tmp_path, "cut.csv", text[: text.rindex("\n", 0, -2) + 20]))
        assert len(rec) == N - 1
        assert "the last one, which is cut off" in said[0]

    @pytest.mark.parametrize("text", [texts.xsens(N), texts.dot(N), texts.shimmer(N)])
    def test_a_cell_that_is_no_number_is_missing_and_told(self, tmp_path: Path, text: str) -> None:
        value = f"{readings.acc(N)[10, 1]:.6f}"
        rec, said = told(file(tmp_path, "odd.csv", text.replace(value, "#1F", 1)))
        assert np.isnan(rec.acc[10, 1])
        assert np.isnan(rec.acc).sum() == 1
        assert "cells that are no numbers taken for missing, first in row 11" in said[0]
