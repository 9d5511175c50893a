"""OpenSim's .sto of orientations: key=value lines, "endheader", then a time and a cell w,x,y,z a sensor."""

from __future__ import annotations

import numpy as np

from ahrs_rs.io import _attitude
from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._lines import head_lines, is_text
from ahrs_rs.io._source import Source

END = "endheader"
#: Numbers of a unit quaternion in text differ by no more than this.
ROUNDING = 1e-3


def sniff(source: Source) -> bool:
    """Whether the first lines have OpenSim's header of a table of quaternions."""
    if not is_text(source.head):
        return False
    lines = [line.strip().lower() for line in head_lines(source.head)[:30]]
    return END in lines and any(line.replace(" ", "") == "datatype=quaternion" for line in lines)


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read the sensors' orientations; there is nothing else in the file."""
    lines = [line for line in source.read().decode("utf-8", errors="replace").splitlines() if line.strip()]
    end = next((index for index, line in enumerate(lines) if line.strip().lower() == END), None)
    if end is None or len(lines) < end + 3:
        raise ValueError("has a header of OpenSim, but no rows")
    names = [name.strip() for name in lines[end + 1].split("\t")]
    rows = [line.split("\t") for line in lines[end + 2 :]]
    repairs = []
    if len(rows[-1]) < len(names) or rows[-1][-1].count(",") < 3:
        rows.pop()
        repairs.append("the last row is cut off and left out")
    try:
        t = np.array([float(row[0]) for row in rows])
        quats = np.array([[[float(one) for one in cell.split(",")] for cell in row[1 : len(names)]] for row in rows])
    except (ValueError, IndexError) as error:
        raise ValueError(f"is not a table of quaternions: {error}") from None
    if quats.shape != (len(rows), len(names) - 1, 4) or not len(rows):
        raise ValueError(f"is not a table of quaternions: expected {len(names) - 1} cells of w,x,y,z in each row")
    sensors = {}
    for index, name in enumerate(names[1:]):
        data = SensorData({}, meta={"repairs": list(repairs), "device_frame": "of OpenSim"})
        unit = _attitude.normalised(quats[:, index])
        if np.nanmax(np.abs(unit - quats[:, index]), initial=0.0) > ROUNDING:
            data.say("repairs", "quaternions are not of unit norm and normalised, as OpenSim does")
        data.streams["device_quat"] = (t, unit)
        sensors[name] = data
    return sensors
