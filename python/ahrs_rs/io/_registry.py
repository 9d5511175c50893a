"""Every format that is read, in the order in which they are looked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from . import _broad, _npz, _repoimu, _table
from ._contents import Options, SensorData, SensorInfo
from ._source import Source

#: Options of a table of columns.
TABLE = frozenset({"columns", "units", "separator", "decimal", "skip_rows", "timezone"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Format:
    """A format: what it is, how it is recognised, how it is read.

    Parameters
    ----------
    title : what it is, in a few words.
    sniff : whether a source is of this format, by its first bytes or the names in it.
    load : sensor -> what the source holds of it; a device with one sensor gives one entry of any name. Where
        ``options.sensor`` is given, that one alone is enough.
    sensors : what is in the source, without reading it whole; None counts what `load` gives.
    endings : of file names that only this format has.
    extra, library : what has to be installed, as ``pip install ahrs-rs[extra]``, and the library that reads it.
    options : those of `Options` that it takes beside axes, rate and sensor.
    note : what a user has to know, in one sentence.
    """

    title: str
    sniff: Callable[[Source], bool]
    load: Callable[[Source, Options], dict[str, SensorData]]
    sensors: Callable[[Source, Options], list[SensorInfo]] | None = None
    endings: tuple[str, ...] = ()
    extra: str = ""
    library: str = ""
    options: frozenset[str] = frozenset()
    note: str = ""


#: Name -> format; the first one whose `sniff` agrees is taken, so the general ones come last.
FORMATS: dict[str, Format] = {
    "broad": Format(
        title="BROAD trial (HDF5)",
        sniff=_broad.sniff,
        load=_broad.load,
        endings=(".hdf5", ".h5"),
        extra="io",
        library="h5py",
    ),
    "npz": Format(title="numpy arrays", sniff=_npz.sniff, load=_npz.load, endings=(".npz",), library="numpy"),
    "parquet": Format(
        title="Parquet table",
        sniff=_table.sniff_parquet,
        load=_table.load_parquet,
        endings=(".parquet", ".pq"),
        extra="io",
        library="pyarrow",
        options=TABLE,
    ),
    "repoimu": Format(
        title="RepoIMU recording (CSV)", sniff=_repoimu.sniff, load=_repoimu.load, extra="io", library="pyarrow"
    ),
    "csv": Format(
        title="text table", sniff=_table.sniff, load=_table.load, extra="io", library="pyarrow", options=TABLE
    ),
}
