"""What the classes say of themselves, and the parameters that they take."""

from __future__ import annotations

import enum
import inspect
import pickle
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import _native
from cases import STREAMING, each_filter
from settling import DEGREE2
from signals import RATE, motion

# Metadata.


def test_filters_are_the_native_registry_by_name_and_attributes_of_the_package() -> None:
    assert list(ar.FILTERS) == [spec["name"] for spec in _native.registry()]
    for name, cls in ar.FILTERS.items():
        assert getattr(ar, name) is cls
        assert name in ar.__all__
        assert (cls.__name__, cls.__qualname__, cls.__module__, cls.NAME) == (name, name, "ahrs_rs", name)


def test_every_name_of_the_package_is_there_and_documented() -> None:
    for name in ar.__all__:
        assert inspect.getdoc(getattr(ar, name)), name


def test_every_native_name_has_a_counterpart_in_its_stub_and_is_used_by_the_package() -> None:
    from pathlib import Path

    package = Path(ar.__file__).parent
    stub = (package / "_native.pyi").read_text(encoding="utf-8")
    sources = "".join(path.read_text(encoding="utf-8") for path in package.rglob("*.py"))
    names = [name for name in vars(_native) if not name.startswith("__")]
    methods = [name for name in vars(_native.NativeFilter) if not name.startswith("__")]
    assert names
    assert methods
    for name in [*names, *methods]:
        assert name in stub, f"{name} is not in the stub"
    for name in names:
        assert f"_native.{name}" in sources, f"{name} is used by no module"
    for name in methods:
        public = not name.startswith("_")
        assert public or f"self.{name}(" in sources or f"made.{name}(" in sources, f"{name} is used by no module"


@each_filter
def test_metadata_is_complete_and_cannot_be_changed(name: str) -> None:
    cls = ar.FILTERS[name]
    assert isinstance(cls.STREAMING, bool)
    assert isinstance(cls.MAGNETOMETER, bool)
    assert isinstance(cls.FEEDBACK, bool)
    assert len(cls.SOURCE) > 10
    for mapping in (cls.PARAMS, cls.OUTPUTS, cls.PRESETS):
        with pytest.raises(TypeError, match="does not support item assignment"):
            mapping["x"] = None
    for key, doc in cls.OUTPUTS.items():
        assert key.isidentifier()
        assert "shape (..., T" in doc


@each_filter
def test_every_parameter_is_documented_with_unit_range_and_default(name: str) -> None:
    cls = ar.FILTERS[name]
    doc = " ".join((inspect.getdoc(cls) or "").split())  # without the ends of its lines
    signature = inspect.signature(cls)
    assert {"rate", "frame", "declination", "gyr_hold", "dtype"} <= set(signature.parameters)
    assert all(p.kind is inspect.Parameter.KEYWORD_ONLY for p in signature.parameters.values())
    for key, spec in cls.PARAMS.items():
        assert spec.name == key
        assert len(spec.doc) > 10
        assert f"{key} : " in doc
        assert spec.doc in doc
        assert signature.parameters[key].default == spec.default
        if spec.options is None:
            low, high = spec.range
            assert low <= spec.default <= high
            assert spec.unit
            assert spec.unit in doc
        else:
            assert spec.default in spec.options
            assert spec.range is None
            if isinstance(spec.default, bool):
                assert f"{key} : bool, default {spec.default}" in doc
            else:
                assert all(f'"{option}"' in doc for option in spec.options)


@each_filter
def test_the_docstring_says_source_sensors_presets_outputs_and_law(name: str) -> None:
    cls = ar.FILTERS[name]
    doc = " ".join((inspect.getdoc(cls) or "").split())
    assert cls.SOURCE in doc
    assert ("9D" in doc) == cls.MAGNETOMETER
    assert cls.EQUIVARIANCE.lower() in doc.lower()
    assert all(f"{preset} (" in doc for preset in cls.PRESETS)
    assert all(f"Output ``{output}``: " in doc for output in cls.OUTPUTS)


@pytest.mark.parametrize("method", ["run", "update", "reset", "state", "restore", "copy", "preset"])
def test_every_public_method_is_documented(method: str) -> None:
    assert len(inspect.getdoc(getattr(ar.Madgwick, method)) or "") > 20


#: DESIGN section 3, and the defaults of its table. τ = 0.997/0.003/200 s; process noises of a step of 5 ms (Parikh, in
#: deg²) and of 2 ms (Cirillo) are given per second.
PRESETS: dict[str, dict[str, dict[str, float]]] = {
    "Complementary": {"parikh2021": {"tau": 0.997 / 0.003 / 200.0}},
    "LinearKalman": {
        "parikh2021": {
            "angle_process": 0.01181 * DEGREE2 / 0.005,
            "bias_process": 4.28e-6 * DEGREE2 / 0.005,
            "angle_variance": 2650.0 * DEGREE2,
        }
    },
    "EKF": {
        "cirillo2014": {
            **dict(zip(("gyr_variance_x", "gyr_variance_y", "gyr_variance_z"), (2.9e-5, 2.3e-5, 3.2e-5), strict=True)),
            **dict(zip(("acc_variance_x", "acc_variance_y", "acc_variance_z"), (3.1e-5, 4.5e-5, 5.5e-5), strict=True)),
            **dict(zip(("mag_variance_x", "mag_variance_y", "mag_variance_z"), (2.0e-3, 2.1e-3, 2.0e-3), strict=True)),
            "quat_process": 1e-10 / 0.002,
            "rate_process": 1e-3 / 0.002,
        }
    },
    "DcmImu": {
        "hyyti2015": {
            "dcm_process": 0.1,
            "bias_process": 1e-4,
            "acc_std": 0.5,
            "acc_motion": 10.0,
            "initial_dcm": 1.0,
            "initial_bias": 0.1,
            "gravity": 9.8189,
        }
    },
    "Mahony": {
        "cirillo2014": {"kp": 2.0, "ki": 0.6},
        "parikh2021": {"kp": 0.89, "ki": 0.01},
        "ludwig2018": {"kp": 0.0039216, "ki": 0.001},
        "cocoli2023": {"kp": 10.0, "ki": 0.0},
        "hyyti2015": {"kp": 0.5, "ki": 0.0},
    },
    "Madgwick": {
        "cirillo2014": {"beta": 0.041},
        "parikh2021": {"beta": 0.00921},
        "ludwig2018": {"beta": 0.011765},
        "cocoli2023": {"beta": 0.05},
        "hyyti2015": {"beta": 0.1},
    },
}
DEFAULTS = {
    "Complementary": {"tau": 0.997 / 0.003 / 200.0},
    "Mahony": {"kp": 1.0, "ki": 0.3},
    "Madgwick": {"beta": 0.041, "zeta": 0.0, "gradient": "tangent"},
    "Trigonometric": {"source": "acc"},
    "LinearKalman": PRESETS["LinearKalman"]["parikh2021"],
    "EKF": PRESETS["EKF"]["cirillo2014"] | {"gyroscope": "measurement", "reference_time": 0.0},
    "DcmImu": PRESETS["DcmImu"]["hyyti2015"] | {"gravity": 9.80665, "prediction": "exponential"},
}


@pytest.mark.parametrize("name", DEFAULTS)
def test_defaults_are_those_of_the_papers(name: str) -> None:
    f = ar.FILTERS[name]()
    assert {key: f.params[key] for key in DEFAULTS[name]} == DEFAULTS[name]
    assert f.params.get("integration", "exponential") == "exponential"


@pytest.mark.parametrize("name", PRESETS)
def test_presets_have_the_values_of_the_papers(name: str) -> None:
    cls = ar.FILTERS[name]
    assert set(cls.PRESETS) == set(PRESETS[name])
    for preset, values in PRESETS[name].items():
        f = cls.preset(preset, rate=RATE, frame="NED")
        assert (f.rate, f.frame) == (RATE, "NED")
        assert dict(f.params) == dict(cls().params) | values


def test_a_preset_takes_other_parameters_and_knows_its_names() -> None:
    assert ar.Mahony.preset("cirillo2014", ki=0.0).params["ki"] == 0.0
    with pytest.raises(ValueError, match=r"name: expected one of \['cirillo2014'.*got 'nobody1999'"):
        ar.Mahony.preset("nobody1999")
    with pytest.raises(ValueError, match="name: expected one of"):
        ar.Tilt.preset("cirillo2014")


# The constructor.


@each_filter
def test_parameters_are_attributes_and_cannot_be_changed(name: str) -> None:
    f = ar.FILTERS[name](rate=RATE)
    for key, value in f.params.items():
        assert getattr(f, key) == value
        with pytest.raises(AttributeError, match=f"{key} cannot be changed"):
            setattr(f, key, value)
    with pytest.raises(AttributeError, match="rate cannot be changed"):
        f.rate = 50.0
    with pytest.raises(AttributeError, match="has no attribute 'unknown'"):
        _ = f.unknown


@each_filter
def test_numbers_of_a_parameter_end_at_its_range(name: str) -> None:
    cls = ar.FILTERS[name]
    for key, spec in cls.PARAMS.items():
        if spec.range is None:
            continue
        for inside in (*spec.range, np.float32(spec.range[1]), int(spec.range[1])):
            assert cls(**{key: inside}).params[key] == inside
        beyond = (np.nextafter(spec.range[0], -np.inf), np.nextafter(spec.range[1], np.inf), -np.inf, np.inf, np.nan)
        for outside in beyond:
            with pytest.raises(ValueError, match=rf"^{key}: expected a number in \[.*\].*, got"):
                cls(**{key: outside})


@pytest.mark.parametrize("value", ["1", b"1", None, True, [1.0], np.ones(1), 1 + 0j, {}], ids=repr)
@each_filter
def test_what_is_no_number_is_a_value_error_that_names_the_parameter(name: str, value: Any) -> None:
    cls = ar.FILTERS[name]
    for key, spec in cls.PARAMS.items():
        if isinstance(spec.default, bool) and value is True:
            continue  # a switch is on
        message = f"^{key}: expected a number" if spec.options is None else f"^{key}: expected one of"
        with pytest.raises(ValueError, match=message):
            cls(**{key: value})
    for key in ("rate", "declination"):
        if value is not None or key != "rate":
            with pytest.raises(ValueError, match=f"^{key}: expected a number"):
                cls(**{key: value})


@each_filter
def test_an_unknown_keyword_is_a_type_error_that_says_what_there_is(name: str) -> None:
    with pytest.raises(
        TypeError, match=f"{name} has no parameter 'betta'( \\(did you mean beta\\?\\))?; it takes .*rate, frame"
    ):
        ar.FILTERS[name](betta=1.0)
    with pytest.raises(TypeError, match="positional"):
        ar.FILTERS[name](100.0)


@pytest.mark.parametrize(
    ("keyword", "value"),
    [
        ("rate", 0.0),
        ("rate", -100.0),
        ("rate", np.nan),
        ("rate", np.inf),
        ("frame", "ned"),
        ("frame", "END"),
        ("declination", np.nan),
        ("declination", 13.5),  # degrees
        ("gyr_hold", "first-order"),
        ("dtype", np.float16),
        ("dtype", np.int32),
        ("dtype", complex),
    ],
)
def test_a_setting_out_of_range_is_a_value_error_that_names_it(keyword: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"^{keyword}: expected"):
        ar.Madgwick(**{keyword: value})


@each_filter
def test_repr_makes_the_same_filter_again(name: str) -> None:
    cls = ar.FILTERS[name]
    for f in (cls(), cls(rate=RATE, frame="NED", declination=0.1, gyr_hold="linear", dtype=np.float32)):
        again = eval(repr(f), vars(ar))
        assert repr(again) == repr(f)
        if cls.STREAMING:
            assert again.state() == f.state()
        assert (again.rate, again.dtype) == (f.rate, f.dtype)


# Status.


def test_status_has_the_bits_of_the_documentation() -> None:
    expected = {
        "ACC_MISSING": 1,
        "MAG_MISSING": 2,
        "GYR_HELD": 4,
        "ACC_REJECTED": 8,
        "MAG_REJECTED": 16,
        "REST": 32,
        "NOT_ALIGNED": 64,
        "RECOVERING": 128,
        "GAP": 256,
        "REPEATED": 512,
    }
    assert issubclass(ar.Status, enum.IntFlag)
    assert {bit.name: int(bit) for bit in ar.Status} == expected
    f = ar.Tilt(rate=RATE)
    f.update([0.0, 0.0, 0.0], [np.nan] * 3)
    assert f.status is ar.Status.ACC_MISSING | ar.Status.NOT_ALIGNED


def test_streaming_gives_one_row_of_what_run_gives() -> None:
    signals = motion(5, 1)
    for name in STREAMING:
        f = ar.FILTERS[name](rate=RATE)
        assert np.array_equal(f.quat, [1.0, 0.0, 0.0, 0.0])
        quat = f.update(*(array[0] for array in signals.sensors()))
        assert quat.shape == (4,)
        assert f.gyr_bias is None or f.gyr_bias.shape == (3,)
        assert isinstance(f.status, ar.Status)
        assert f.covariance is None or f.covariance.shape == (3, 3)


def test_pickles_do_not_grow_with_the_package() -> None:
    # A filter is its class, its parameters and its state: no code, no registry. A state of n variables has a covariance
    # of n² numbers in it, of 9 bytes each: 49 of the EKF.
    # SelfCalKF's has 496, beside some 260 other variables; every filter has 40 of its measurements, losses and
    # recovery.
    for name, cls in ar.FILTERS.items():
        assert len(pickle.dumps(cls(rate=RATE))) < (8500 if name == "SelfCalKF" else 2500)


# Importing.

HEAVY = ("pandas", "polars", "pyarrow", "scipy", "matplotlib", "h5py")


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = f"import sys, ahrs_rs; print([name for name in {HEAVY!r} if name in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert (result.stdout, result.stderr) == ("[]\n", "")


def test_running_a_filter_imports_nothing_heavy() -> None:
    code = (
        "import sys, numpy as np, ahrs_rs as ar\n"
        "est = ar.Madgwick(rate=100.0).run(np.ones((5, 3)), np.ones((5, 3)), np.ones((5, 3)))\n"
        "est.euler(), est.matrix(), ar.run_many(ar.Tilt(rate=1.0), [(np.ones((5, 3)),)])\n"
        f"print([name for name in {HEAVY!r} if name in sys.modules])"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert (result.stdout, result.stderr) == ("[]\n", "")
