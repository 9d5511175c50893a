"""The docstring and the signature of a filter's class, from the registry's description."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping
from typing import Any

from ahrs_rs._param import Param

#: What `help` shows is indented by four columns, and is to fit 100.
WIDTH = 92

RATE = ("rate : float, optional", "Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.")
#: What every filter takes beside its rate and its own parameters.
COMMON = {
    "frame": ('frame : {"ENU", "NED", "NWU"}, default "ENU"', "Earth frame of the attitude."),
    "declination": (
        "declination : float, default 0.0",
        "Magnetic declination in rad, positive east. With a magnetometer, the attitude is then from true north.",
    ),
    "gyr_hold": (
        'gyr_hold : {"zero-order", "linear"}, default "zero-order"',
        "The angular rate between two samples: that of the sample that ends the step, or linear between both.",
    ),
    "repeated": (
        'repeated : {"new", "missing"}, default "new"',
        "A row of the accelerometer or magnetometer that equals the sensor's last one bit for bit, while the "
        "gyroscope's row does not: a measurement as any other, or none, for 1 s at most (the logger repeats the last "
        "row of a slower sensor).",
    ),
    "gyr_range": (
        "gyr_range : float, default 0.0",
        "Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation beyond it is lost, and "
        "the attitude is found again from the accelerometer and magnetometer.",
    ),
    "dtype": (
        "dtype : data-type, default numpy.float64",
        "Of ``update``: float32 or float64. ``run`` computes in float32 where all its measurements are float32.",
    ),
}
#: What is said of the law under a rotation of the sensor frame; another one is an answer to the question below.
LAWS = {
    "exact": "Mounting: another mounting of the sensor gives the same attitude, exactly.",
}

EXAMPLE = """\
>>> import numpy as np
>>> import ahrs_rs as ar
>>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
>>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
>>> est = ar.{call}.run(gyr, acc, mag)
>>> est.quat.shape
(50, 4)"""


def class_doc(spec: Mapping[str, Any], params: Mapping[str, Param], outputs: Mapping[str, str]) -> str:
    """The docstring of a filter's class."""
    summary, dot, more = spec["doc"].partition(". ")
    parts = [_filled(summary + dot.strip())]
    if more:
        parts.append(_filled(more))
    own = [(_type_line(param), param.doc) for param in params.values()]
    common = [entry for name, entry in COMMON.items() if name not in params]
    parts.append(_section("Parameters", [RATE, *own, *common]))
    parts.append(_heading("Notes") + "\n" + "\n\n".join(map(_filled, _notes(spec, outputs))))
    parts.append(_heading("References") + "\n" + _filled(f"{spec['source']}."))
    parts.append(_heading("Examples") + "\n" + EXAMPLE.format(call=_call(spec["name"], params)))
    return "\n\n".join(parts)


def _notes(spec: Mapping[str, Any], outputs: Mapping[str, str]) -> Iterable[str]:
    if spec["magnetometer"]:
        yield "Sensors: gyroscope and accelerometer (6D), or with a magnetometer (9D)."
    else:
        yield "Sensors: gyroscope and accelerometer (6D); a magnetometer gives the initial heading only."
    law = spec["equivariance"]
    yield LAWS.get(
        law, f"Mounting: does another mounting of the sensor give the same attitude? {law[:1].upper()}{law[1:]}."
    )
    if spec["presets"]:
        shown = (
            f"{name} ({', '.join(f'{key}={value}' for key, value in values.items())})"
            for name, values in spec["presets"].items()
        )
        yield f"Presets (``{spec['name']}.preset(name)``): {'; '.join(shown)}."
    for name, doc in outputs.items():
        yield f"Output ``{name}``: {doc}."


def property_doc(param: Param) -> str:
    """The docstring of a parameter as an attribute."""
    unit = f" ({param.unit})" if param.unit else ""
    return _filled(param.doc.rstrip(".") + f"{unit}.")


def _type_line(param: Param) -> str:
    if isinstance(param.default, bool):
        return f"{param.name} : bool, default {param.default}"
    if param.options is not None:
        options = ", ".join(f'"{option}"' for option in param.options)
        return f'{param.name} : {{{options}}}, default "{param.default}"'
    low, high = param.range or (0.0, 0.0)
    unit = f" {param.unit}" if param.unit not in ("", "1") else ""
    return f"{param.name} : float, default {param.default!r}, in [{low:g}, {high:g}]{unit}"


def _call(name: str, params: Mapping[str, Param]) -> str:
    first = next((param for param in params.values() if param.options is None), None)
    return f"{name}(rate=100.0{'' if first is None else f', {first.name}={first.default!r}'})"


def _section(title: str, entries: Iterable[tuple[str, str]]) -> str:
    lines = [f"{head}\n{textwrap.indent(textwrap.fill(text, WIDTH - 4), '    ')}" for head, text in entries]
    return "\n".join([_heading(title), *lines])


def _heading(title: str) -> str:
    return f"{title}\n{'-' * len(title)}"


def _filled(text: str) -> str:
    return textwrap.fill(text, WIDTH)
