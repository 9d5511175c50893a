"""Tables by options and by layout files, from any container, and the same on the command line."""

from __future__ import annotations

import gzip
import io
import sys
import warnings
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from commands import Capture, error_of, output_of

G, DEGREE = 9.80665, np.pi / 180.0
N, RATE = 120, 50.0
T = np.arange(N) / RATE
GYR = np.column_stack([np.sin(T), 0.5 * np.cos(2.0 * T), 0.2 * np.sin(3.0 * T)])
ACC = np.tile([0.6, -0.8, 9.75], (N, 1)) + 0.1 * np.sin(5.0 * T)[:, None]
HEADER = "t (s),gx (rad/s),gy (rad/s),gz (rad/s),ax (m/s2),ay (m/s2),az (m/s2)"


def text(header: str = HEADER, columns: Any = (T, GYR, ACC), separator: str = ",", decimal: str = ".") -> str:
    rows = np.column_stack(columns)
    lines = [separator.join(f"{value:.12g}".replace(".", decimal) for value in row) for row in rows]
    return "\n".join([*filter(None, [header.replace(",", separator)]), *lines]) + "\n"


def read(path: Any, **options: Any) -> ar.Recording:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.DataWarning)
        return ar.read(path, **options)


def check(rec: ar.Recording, gyr: np.ndarray = GYR, acc: np.ndarray = ACC, t: np.ndarray = T) -> None:
    np.testing.assert_allclose(rec.t - rec.t[0], t - t[0], atol=1e-9)
    np.testing.assert_allclose(rec.gyr, gyr, atol=1e-9)
    np.testing.assert_allclose(rec.acc, acc, atol=1e-9)


def put(path: Path, content: str, encoding: str = "utf-8") -> Path:
    path.write_bytes(content.encode(encoding))
    return path


LOGGER = "millis,p,q,r,X1,X2,X3,note"
LOGGER_OPTIONS: dict[str, Any] = {
    "columns": {"t": "millis", "gyr": ["p", "q", "r"], "acc": ["X1", "X2", "X3"]},
    "units": {"gyr": "deg/s", "acc": "g", "t": "ms"},
}


def logger() -> str:
    return text(LOGGER, (1e3 * T, GYR / DEGREE, ACC / G, T))


def test_columns_and_units_settle_what_names_do_not_tell(tmp_path: Path) -> None:
    path = put(tmp_path / "a.csv", logger())
    with pytest.raises(ValueError, match=r"a\.csv: .*columns"):
        read(path)
    rec = read(path, **LOGGER_OPTIONS)
    check(rec)
    assert rec.meta["columns"]["gyr"] == ["p", "q", "r"]
    further = {**LOGGER_OPTIONS["columns"], "note": "note"}
    np.testing.assert_allclose(read(path, columns=further, units=LOGGER_OPTIONS["units"]).streams["note"].values, T)


def test_a_layout_file_says_the_same_and_options_go_over_it(tmp_path: Path) -> None:
    path = put(tmp_path / "a.csv", logger())
    layout = put(
        tmp_path / "my_logger.toml",
        'axes = "x,-y,-z"\n[columns]\nt = "millis"\ngyr = ["p", "q", "r"]\nacc = ["X1", "X2", "X3"]\n'
        '[units]\ngyr = "deg/s"\nacc = "g"\nt = "ms"\n',
    )
    flip = np.array([1.0, -1.0, -1.0])
    check(read(path, layout=layout), GYR * flip, ACC * flip)
    check(read(path, layout=layout, axes="x,y,z"))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("columns = 3\n", "columns"),
        ("[columns\n", "my.toml"),
        ('kolumns = "x"\n', "kolumns"),
        ('[units]\ngyr = "furlong"\n', "furlong"),
        ('[units]\nspeed = "m/s"\n', "speed"),
        ('axes = "x,y,y"\n', "axes"),
        ("skip_rows = -1\n", "skip_rows"),
        ('separator = ""\n', "separator"),
    ],
)
def test_a_layout_that_cannot_be_is_refused_in_one_line(tmp_path: Path, content: str, message: str) -> None:
    layout = put(tmp_path / "my.toml", content)
    with pytest.raises(ValueError, match=message) as caught:
        read(put(tmp_path / "a.csv", text()), layout=layout)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("options", [{"columns": {"gyr": ["p", "q"]}}, {"columns": {"gyr": ["p", "q", "nope"]}},
                                     {"units": {"gyr": "m/s"}}, {"axes": "x,y"},
                                     {"sensor": "left"}, {"timezone": "Mars/Base"}, {"decimal": ";"},
                                     {"skip_rows": 1.5}, {"between": (2.0, 1.0)}, {"rate": -1.0},
                                     {"format": "sqlite"}])  # fmt: skip
def test_options_that_cannot_be_are_refused_in_one_line(tmp_path: Path, options: dict[str, Any]) -> None:
    path = put(tmp_path / "a.csv", logger())
    wanted = {**LOGGER_OPTIONS, **options}
    if "columns" in options:
        wanted["columns"] = {**LOGGER_OPTIONS["columns"], **options["columns"]}
    with pytest.raises(ValueError, match=next(iter(options))) as caught:
        read(path, **wanted)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("separator", [",", ";", "\t", " ", "|"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_separators_and_decimal_signs_are_found(tmp_path: Path, separator: str, decimal: str) -> None:
    if separator == decimal:
        return
    header = HEADER.replace(" ", "_") if separator == " " else HEADER
    path = put(tmp_path / "a.txt", text(header, separator=separator, decimal=decimal))
    check(read(path))
    name = {"\t": "tab", " ": "blanks"}.get(separator, separator)
    check(read(path, separator=name, decimal=decimal))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1"])
def test_encodings_are_found(tmp_path: Path, encoding: str) -> None:
    header = "Zeit (s),gx (°/s),gy (°/s),gz (°/s),ax (m/s²),ay (m/s²),az (m/s²)"
    content = text(header.replace("Zeit", "t"), (T, GYR / DEGREE, ACC))
    check(read(put(tmp_path / "a.csv", content, encoding)))


def test_preambles_units_lines_and_comments_are_understood(tmp_path: Path) -> None:
    names = "t,gx,gy,gz,ax,ay,az"
    rows = text("", (T, GYR / DEGREE, ACC / G))
    for head in (
        f"sep=,\n{names}\ns,deg/s,deg/s,deg/s,g,g,g\n",
        f'"sep=,"\n{names}\n[s],[deg/s],[deg/s],[deg/s],[g],[g],[g]\n',
        f"# a logger\n# of mine, with commas, in three, words\n{names}\n(s),(deg/s),(deg/s),(deg/s),(g),(g),(g)\n",
        f"Device: X,Serial: 12\nStart,2024-01-01\n\n{names}\ns,deg/s,deg/s,deg/s,g,g,g\n",
        f"// one\n// two\n#{names}\n# s,deg/s,deg/s,deg/s,g,g,g\n",
    ):
        check(read(put(tmp_path / "a.csv", head + rows)))


def test_skip_rows_and_names_for_a_table_without_a_header(tmp_path: Path) -> None:
    names = ["t", "gx", "gy", "gz", "ax", "ay", "az"]
    check(read(put(tmp_path / "a.csv", text("")), columns=names))
    with pytest.raises(ValueError, match=r"no header line: name its 7 columns by columns="):
        read(tmp_path / "a.csv")
    with pytest.raises(ValueError, match="columns"):
        read(tmp_path / "a.csv", columns=names[:-1])
    check(read(put(tmp_path / "b.csv", "1,2,3,4,5,6,7\n" + text()), skip_rows=1))
    left_out = read(tmp_path / "a.csv", columns=["t", "gx", "gy", "gz", "", "", ""])
    assert left_out.acc is None


def test_iso_dates_seconds_with_nanoseconds_and_time_zones_are_times(tmp_path: Path) -> None:
    start = np.datetime64("2024-03-31T00:59:59.5", "ns")
    stamps = start + np.rint(1e9 * T).astype("timedelta64[ns]")
    cells = ["gx (rad/s),gy (rad/s),gz (rad/s),ax (m/s2),ay (m/s2),az (m/s2)", *text("", (GYR, ACC)).splitlines()]

    def table(names: str, times: list[str]) -> str:
        return "\n".join(f"{time},{row}" for time, row in zip([names, *times], cells, strict=True)) + "\n"

    check(read(put(tmp_path / "a.csv", table("time", [str(one) for one in stamps]))))
    check(read(put(tmp_path / "b.csv", table("time", [f"{one}Z".replace("T", " ") for one in stamps]))))
    nanos = 1_711_846_799_500_000_000 + np.rint(1e9 * T).astype(np.int64)
    pairs = [f"{one // 10**9},{one % 10**9}" for one in nanos.tolist()]
    rec = read(put(tmp_path / "c.csv", table("secs,nsecs", pairs)))
    check(rec)
    assert rec.meta["start"] == "2024-03-31T00:59:59+00:00", "the moment of t = 0"
    assert rec.t[0] == 0.5
    local = read(put(tmp_path / "d.csv", table("time", [str(one) for one in stamps])), timezone="Europe/Berlin")
    assert local.meta["start"].startswith("2024-03-30T23:59:59.5")
    # Clocks go forward at 01:00 UTC: a local time of the hour that does not exist is not an hour late.
    summer = ["2024-03-31T01:59:59.99", "2024-03-31T03:00:00.01", *["2024-03-31T03:00:00.03"] * (N - 2)]
    rec = read(put(tmp_path / "e.csv", table("time", summer)), timezone="Europe/Berlin")
    assert rec.t[1] - rec.t[0] == pytest.approx(0.02)


def test_several_sensors_of_one_table_are_listed_and_read_by_name(tmp_path: Path) -> None:
    names = ",".join(f"{place}_{q}{axis} ({unit})" for place in ("left", "right")
                     for q, unit in (("gyr_", "rad/s"), ("acc_", "m/s2")) for axis in "xyz")  # fmt: skip
    path = put(tmp_path / "a.csv", text(f"t (s),{names}", (T, GYR, ACC, -GYR, -ACC)))
    with pytest.raises(ValueError, match=r"give sensor= \(--sensor\), one of 'left', 'right', or use read_all"):
        read(path)
    check(read(path, sensor="left"))
    check(read(path, sensor="right"), -GYR, -ACC)
    every = ar.read_all(path)
    assert list(every) == ["left", "right"]
    check(every["right"], -GYR, -ACC)
    listed = ar.sensors(path)
    assert [one.name for one in listed] == ["left", "right"]
    with pytest.raises(ValueError, match="sensor: expected one of 'left', 'right'"):
        read(path, sensor="middle")


def test_rows_of_several_sensors_are_told_apart_by_their_number(tmp_path: Path) -> None:
    rows = np.column_stack([np.repeat(T, 2), np.tile([0.0, 1.0], N), np.repeat(GYR, 2, 0), np.repeat(ACC, 2, 0)])
    rows[1::2, 2:] *= -1.0
    header = "t (s),sensor_id,gx (rad/s),gy (rad/s),gz (rad/s),ax (m/s2),ay (m/s2),az (m/s2)"
    path = put(tmp_path / "a.csv", text(header, (rows,)))
    check(read(path, sensor="0"))
    check(read(path, sensor="1"), -GYR, -ACC)


def test_any_container_gives_the_same_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    raw = text().encode()
    (tmp_path / "a.csv.gz").write_bytes(gzip.compress(raw))
    with zipfile.ZipFile(tmp_path / "a.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("deep/in/a.csv", raw)
        archive.writestr("__MACOSX/._a.csv", b"\0\1")
    check(read(tmp_path / "a.csv.gz"))
    check(read(tmp_path / "a.zip"))
    check(read(io.BytesIO(raw)))
    check(read(io.BytesIO(gzip.compress(raw))))
    put(tmp_path / "a.csv", text())
    with (tmp_path / "a.csv").open("rb") as file:
        check(read(file))
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(raw)))
    check(read("-"))


def test_between_takes_a_part_of_the_time(tmp_path: Path) -> None:
    path = put(tmp_path / "a.csv", text())
    rec = read(path, between=(0.5, 1.0))
    assert rec.t[0] == 0.5
    assert rec.t[-1] == 1.0
    check(rec, GYR[25:51], ACC[25:51], T[25:51])


def test_axes_are_turned_as_they_are_read(tmp_path: Path) -> None:
    rec = read(put(tmp_path / "a.csv", text()), axes="-y,x,z")
    check(rec, GYR[:, [1, 0, 2]] * [-1.0, 1.0, 1.0], ACC[:, [1, 0, 2]] * [-1.0, 1.0, 1.0])


@pytest.mark.parametrize("unit", ["rad/s", "deg/s", "°/s", "dps", "mrad/s", "rpm", "0.1 deg/s", "mdps"])
def test_units_by_option_are_those_of_the_page(tmp_path: Path, unit: str) -> None:
    size = {"rad/s": 1.0, "deg/s": DEGREE, "°/s": DEGREE, "dps": DEGREE, "mrad/s": 1e-3, "rpm": np.pi / 30.0,
            "0.1 deg/s": 0.1 * DEGREE, "mdps": 1e-3 * DEGREE}[unit]  # fmt: skip
    path = put(tmp_path / "a.csv", text("t,gx,gy,gz,ax,ay,az", (T, GYR / size, ACC)))
    check(read(path, units={"gyr": unit, "acc": "m/s^2", "t": "s"}))


def test_the_command_line_has_the_same_options(tmp_path: Path, capsys: Capture) -> None:
    path = put(tmp_path / "a.csv", logger())
    options = ["--columns", "t=millis", "--columns", "gyr=p,q,r", "--columns", "acc=X1,X2,X3", "--units",
               "gyr=deg/s,acc=g,t=ms", "--axes", "x,-y,-z", "--between", "0.5:2"]  # fmt: skip
    out = output_of(capsys, "run", path, "--filter", "madgwick", "-o", tmp_path / "b.npz", *options)
    assert "76 in 1.5 s" in out
    python = read(path, **LOGGER_OPTIONS, axes="x,-y,-z", between=(0.5, 2.0))
    with np.load(tmp_path / "b.npz") as file:
        np.testing.assert_array_equal(file["quat"], ar.Madgwick(rate=python.rate).run(python).quat)
    headerless = put(tmp_path / "c.csv", text("", separator=";", decimal=","))
    layout = ["--columns", "t,gx,gy,gz,ax,ay,az", "--separator", ";", "--decimal", ",", "--skip-rows", 0]
    units = ["--units", "t=s,gyr=rad/s,acc=m/s2"]
    out = output_of(capsys, "run", headerless, "--filter", "madgwick", *layout, *units)
    assert "120 in 2.38 s" in out
    assert "no unit" not in out
    error = error_of(capsys, "run", path, "--filter", "madgwick", "--units", "gyr")
    assert error == "--units: expected QUANTITY=UNIT, got 'gyr'"


def test_sensors_and_formats_are_printed(tmp_path: Path, capsys: Capture) -> None:
    path = put(tmp_path / "a.csv", text())
    out = output_of(capsys, "sensors", path)
    assert "gyr" in out
    assert "120" in out
    assert "50" in out
    formats = output_of(capsys, "formats")
    for name in ("csv", "px4", "ros", "euroc", "c3d"):
        assert name in formats
