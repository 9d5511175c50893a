"""How a filter's class is made from the registry's description."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any

from ahrs_rs._class_doc import class_doc, property_doc
from ahrs_rs._extra_constructors import SPECIAL, WITHOUT_GYROSCOPE
from ahrs_rs._filter import Filter
from ahrs_rs._param import Param
from ahrs_rs._signature import ShownSignature
from ahrs_rs._validate import did_you_mean

#: What goes on from sample to sample, and so is not there in offline filters.
STREAMED = ("update", "reset", "state", "restore", "quat", "gyr_bias", "status", "covariance")


class Registry(dict[str, type[Filter]]):
    """The classes by name; for another name a ``KeyError`` that says which one it could be.

    Filters of a user's own (`ahrs_rs.register`) are found by their names, but are not among those that loops, lengths
    and comparisons see.
    """

    def __init__(self, classes: Iterable[tuple[str, type[Filter]]]) -> None:
        super().__init__(classes)
        self.own: dict[str, Any] = {}

    def __missing__(self, name: object) -> type[Filter]:
        if name in self.own:
            cls: type[Filter] = self.own[str(name)]
            return cls
        raise UnknownFilterError(f"expected the name of a filter, got {name!r}{did_you_mean(name, [*self, *self.own])}")

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or name in self.own

    def get(self, name: str, default: Any = None) -> Any:
        """The class of a name, or the default."""
        return self[name] if name in self else default  # noqa: SIM401  # which would call itself


class UnknownFilterError(KeyError):
    """A name that no filter has. A ``KeyError`` shows the repr of its message; this one shows the message."""

    def __str__(self) -> str:
        return str(self.args[0])


def make_class(spec: Mapping[str, Any]) -> type[Filter]:
    """The class of a filter, from its description in the registry."""
    params = {entry["name"]: Param(**entry) for entry in spec["params"]}
    outputs = {
        name: f"{doc}; shape ({', '.join(['...', 'T', *map(str, shape)])})"
        for name, (doc, shape) in spec["outputs"].items()
    }
    keyword = inspect.Parameter.KEYWORD_ONLY
    common = [
        p for p in inspect.signature(Filter.__new__).parameters.values() if p.kind is keyword and p.name not in params
    ]
    own = [inspect.Parameter(name, keyword, default=param.default) for name, param in params.items()]
    return type(
        spec["name"],
        (Filter,),
        {
            "__module__": "ahrs_rs",
            "__signature__": ShownSignature([common[0], *own, *common[1:]]),
            **{name: _param_property(param) for name, param in params.items()},
            **({} if spec["streaming"] else {name: _Absent(name) for name in STREAMED}),
            **{method.__name__: classmethod(method) for method in SPECIAL.get(spec["name"], ())},
            "__doc__": class_doc(spec, params, outputs),
            "NAME": spec["name"],
            "PARAMS": MappingProxyType(params),
            "_DEFAULTS": {name: param.encode(param.default) for name, param in params.items()},
            "_SHOWN": MappingProxyType({name: param.default for name, param in params.items()}),
            "OUTPUTS": MappingProxyType(outputs),
            "PRESETS": MappingProxyType({name: MappingProxyType(values) for name, values in spec["presets"].items()}),
            "STREAMING": spec["streaming"],
            "EQUIVARIANCE": spec["equivariance"],
            "SOURCE": spec["source"],
            "GYROSCOPE": spec["name"] not in WITHOUT_GYROSCOPE,
            "MAGNETOMETER": spec["magnetometer"],
            "FEEDBACK": spec["feedback"],
        },
    )


class _Absent:
    """What an offline filter does not have: looking for it is an ``AttributeError`` that says why."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __get__(self, instance: Filter | None, owner: type[Filter]) -> Any:
        raise AttributeError(f"{owner.NAME} is offline and has no {self.name}: it takes whole recordings by run")


def _param_property(param: Param) -> property:
    """The value of a parameter as an attribute."""

    def value(self: Filter) -> float | str | bool:
        return self.params[param.name]

    return property(value, doc=property_doc(param))
