"""States are checked whatever way they come: given, unpickled, from JSON."""

from __future__ import annotations

import copyreg
import dataclasses
import json
import math
import pickle
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from cases import Case, each_case
from signals import RATE, motion

DTYPES = [np.float64, np.float32]


def mahony() -> ar.State:
    f = ar.Mahony(rate=RATE)
    f.update([0.0, 0.0, 0.1], [0.0, 0.0, 9.8], [0.0, 20.0, -40.0])
    return f.state()


def low_pass() -> ar.signal.LowPassState:
    f = ar.signal.LowPass(3, 5.0, 100.0)
    f.update([1.0, 2.0, 3.0])
    state = f.state()
    assert state is not None
    return state


def forced(state: Any, **changes: Any) -> Any:
    """The state with fields that its constructor would refuse."""
    made = object.__new__(type(state))
    for field in dataclasses.fields(state):
        object.__setattr__(made, field.name, changes.get(field.name, getattr(state, field.name)))
    return made


@pytest.mark.parametrize("dtype", DTYPES)
@each_case
def test_a_state_goes_through_json_bit_for_bit(case: Case, dtype: type) -> None:
    f = case.make(rate=RATE, dtype=dtype)
    signals = motion(40, 3).astype(dtype)
    state = f.run(*signals.sensors(), t=signals.t).state
    again = ar.State.from_json(state.to_json())
    assert again == state
    assert [math.copysign(1.0, x) for x in again.variables] == [math.copysign(1.0, x) for x in state.variables]
    assert ar.State.from_json(state.to_json().encode()) == state
    assert ar.State(**json.loads(json.dumps(dataclasses.asdict(state)))) == state
    f.restore(again)
    assert f.state() == state


@pytest.mark.parametrize("dtype", DTYPES)
def test_a_state_of_a_low_pass_filter_goes_through_json_and_pickle(dtype: type) -> None:
    x = np.random.default_rng(0).normal(size=(2, 30, 4)).astype(dtype)
    f = ar.signal.LowPass(5, 3.0, 100.0)
    whole = f.run(x)
    _, state = f.run(x[:, :11], return_state=True)
    for again in (type(state).from_json(state.to_json()), pickle.loads(pickle.dumps(state))):
        assert again == state
        assert np.array_equal(f.run(x[:, 11:], state=again), whole[:, 11:])


#: A field with a value that is none, and what the error must say.
WRONG: list[tuple[str, Any, str]] = [
    ("variables", (math.nan,) * 20, "variables: expected numbers up to 1.34e\\+154, got nan"),
    ("variables", [math.inf], "variables: expected numbers up to"),
    ("variables", ["1"], r"variables: expected numbers, got \['1'\]"),
    ("variables", 3, "variables: expected numbers, got 3"),
    ("variables", [10**400], "variables: expected numbers, got"),
    ("last_t", math.nan, "last_t: expected a finite stamp or None, got nan"),
    ("last_t", "now", "last_t: expected a finite stamp or None, got 'now'"),
    ("samples", -1, "samples: expected a whole number that is not negative, got -1"),
    ("samples", 2**64, "samples: expected a whole number"),
    ("samples", 1.5, "samples: expected a whole number"),
    ("samples", True, "samples: expected a whole number"),
    ("dtype", "float16", "dtype: expected one of float32, float64, got 'float16'"),
    ("dtype", ["float32"], "dtype: expected one of"),
    ("filter", 7, "filter: expected the name of a filter, got 7"),
    ("settings", {"kp": [1.0]}, "settings: expected pairs of names and values"),
    ("settings", [("kp",)], "settings: expected pairs of names and values"),
    ("settings", "kp", "settings: expected pairs of names and values"),
    ("version", 0, "state: expected version 1 of the format, got 0"),
    ("version", True, "state: expected version 1 of the format, got True"),
    ("version", None, "state: expected version 1 of the format, got none: it is of an earlier version of ahrs_rs"),
]
EVERY_WRONG = pytest.mark.parametrize(("name", "value", "message"), WRONG)


@EVERY_WRONG
def test_a_wrong_field_is_refused_when_given(name: str, value: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(mahony(), **{name: value})


@EVERY_WRONG
def test_a_wrong_field_is_refused_when_unpickled(name: str, value: Any, message: str) -> None:
    stored = pickle.dumps(forced(mahony(), **{name: value}))
    with pytest.raises(ValueError, match=message):
        pickle.loads(stored)


@EVERY_WRONG
def test_a_wrong_field_is_refused_where_a_filter_takes_it(name: str, value: Any, message: str) -> None:
    f = ar.Mahony(rate=RATE)
    before = f.state()
    with pytest.raises(ValueError, match=message):
        f.restore(forced(mahony(), **{name: value}))
    with pytest.raises(ValueError, match=message):
        f.run(np.zeros((3, 3)), state=forced(mahony(), **{name: value}))
    assert f.state() == before


@EVERY_WRONG
def test_a_wrong_field_is_refused_from_json(name: str, value: Any, message: str) -> None:
    text = json.dumps(json.loads(mahony().to_json()) | {name: value})
    with pytest.raises(ValueError, match=message):
        ar.State.from_json(text)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("order", 9, "order: expected a whole number from 1 to 8, got 9"),
        ("cutoff", math.nan, "cutoff: expected a positive"),
        ("shape", 3, "shape: expected a shape, got 3"),
        ("shape", (-1,), "shape: expected a whole number"),
        ("snapshots", ((1.0, 2.0, 3.0),), "snapshots: expected pairs"),
        ("snapshots", (((math.nan,), None),), "variables: expected numbers up to"),
        ("snapshots", (((1.0,), math.inf),), "last_t: expected a finite stamp"),
        ("version", None, "state: expected version 1 of the format, got none"),
    ],
)
def test_states_of_low_pass_filters_are_checked_alike(name: str, value: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(low_pass(), **{name: value})
    stored = pickle.dumps(forced(low_pass(), **{name: value}))
    with pytest.raises(ValueError, match=message):
        pickle.loads(stored)


def test_a_number_whose_square_is_beyond_float32_is_refused_in_a_state_of_float32() -> None:
    f = ar.Mahony(rate=RATE, dtype=np.float32)
    variables = (1e20, *f.state().variables[1:])
    with pytest.raises(ValueError, match=r"variables: expected numbers up to 1\.85e\+19, got 1e"):
        dataclasses.replace(f.state(), variables=variables)


@pytest.mark.parametrize("state", [mahony(), low_pass()], ids=["State", "LowPassState"])
def test_a_pickle_from_before_states_had_a_version_says_so(state: Any) -> None:
    fields = [getattr(state, field.name) for field in dataclasses.fields(state) if field.name != "version"]

    class Old:
        """An object of the class without its constructor, and then its fields, as dataclasses pickle themselves."""

        def __reduce__(self) -> tuple[Any, ...]:
            return copyreg._reconstructor, (type(state), object, None), fields  # type: ignore[attr-defined]

    with pytest.raises(ValueError, match="got none: it is of an earlier version of ahrs_rs"):
        pickle.loads(pickle.dumps(Old()))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        "{}",
        "3",
        '{"format": "ahrs_rs.state"}',
        "[" * 100_000,
        "1" * 10_000,
        b"\xff\xfe\x00",
        '{"a": NaN}',
    ],
    ids=lambda text: repr(text[:12]),
)
def test_text_that_is_no_state_is_a_value_error_of_one_line(text: str | bytes) -> None:
    for cls in (ar.State, ar.signal.LowPassState):
        with pytest.raises(ValueError, match=r"^(text|state): expected [^\n]+$"):
            cls.from_json(text)


def test_a_state_of_a_version_with_other_parameters_names_them() -> None:
    state = ar.VQF(rate=RATE).state()
    fewer = dataclasses.replace(state, settings=tuple(one for one in state.settings if one[0] != "mag_delay"))
    with pytest.raises(ValueError, match="expected the settings of this version of VQF, got none of mag_delay"):
        ar.VQF(rate=RATE).restore(fewer)
    more = dataclasses.replace(state, settings=(*state.settings, ("magic", 1.0)))
    with pytest.raises(ValueError, match="of this version of VQF, got magic, which it has not"):
        ar.VQF(rate=RATE).restore(more)
    renamed = dataclasses.replace(fewer, settings=(*fewer.settings, ("magic", 1.0)))
    with pytest.raises(ValueError, match="got none of mag_delay and magic, which it has not"):
        ar.VQF(rate=RATE).restore(renamed)


@pytest.mark.parametrize("count", [0, 1, 19, 21, 10_000])
def test_a_state_with_another_number_of_variables_is_refused(count: int) -> None:
    f = ar.Mahony(rate=RATE)
    state = dataclasses.replace(f.state(), variables=(0.5,) * count)
    with pytest.raises(ValueError, match=f"state: expected .*, got {count} values"):
        f.restore(state)


def place_of(quat: np.ndarray, state: ar.State) -> int:
    """Where the attitude stands among the variables, for the last time: the filter's own comes before."""
    variables = np.array(state.variables)
    found = [k for k in range(len(variables) - 3) if np.array_equal(variables[k : k + 4], quat)]
    assert found
    return found[-1]


@pytest.mark.parametrize("dtype", DTYPES)
@each_case
def test_a_state_whose_attitude_is_no_unit_quaternion_is_refused(case: Case, dtype: type) -> None:
    f = case.make(rate=RATE, dtype=dtype)
    signals = motion(10, 3).astype(dtype)
    est = f.run(*signals.sensors())
    place = place_of(est.quat[-1], est.state)
    for factor in (0.0, 0.9, 2.0):
        variables = list(est.state.variables)
        variables[place : place + 4] = [factor * x for x in variables[place : place + 4]]
        wrong = dataclasses.replace(est.state, variables=tuple(variables))
        with pytest.raises(ValueError, match=r"state: expected attitudes of unit norm, got \["):
            f.restore(wrong)
        with pytest.raises(ValueError, match="state: expected attitudes of unit norm"):
            f.run(*signals.sensors(), state=wrong)


def test_a_pickled_filter_is_checked_as_its_state_is() -> None:
    f = ar.Mahony(rate=RATE)
    f.update([0.0, 0.0, 0.1], [0.0, 0.0, 9.8])
    rebuild, (cls, keywords, snapshot, version) = f.__reduce__()
    assert rebuild(cls, keywords, snapshot, version).state() == f.state()
    with pytest.raises(ValueError, match="variables: expected numbers up to"):
        rebuild(cls, keywords, ([math.nan] * len(snapshot[0]), None, 0), version)
    with pytest.raises(ValueError, match="got none: it is of an earlier version of ahrs_rs"):
        rebuild(cls, keywords, snapshot)


@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_a_state_that_a_filter_gives_is_checked_as_any_other(dtype: str) -> None:
    f = ar.Mahony(rate=RATE, dtype=dtype)
    variables, settings = list(f.state().variables), f.state().settings
    largest = 1.001 * math.sqrt(float(np.finfo(dtype).max))
    # Each alone is in range, though their norm is not.
    many = [0.99 * largest] * len(variables)
    assert ar.State._of_native("Mahony", dtype, settings, (many, 0.5, 3)) == ar.State(
        "Mahony", dtype, settings, tuple(many), 0.5, 3
    )
    for wrong in (math.nan, math.inf, -1.01 * largest):
        with pytest.raises(ValueError, match="variables: expected numbers up to"):
            ar.State._of_native("Mahony", dtype, settings, ([*variables, wrong], None, 0))
    with pytest.raises(ValueError, match="last_t: expected a finite stamp or None, got inf"):
        ar.State._of_native("Mahony", dtype, settings, (variables, math.inf, 0))
    with pytest.raises(ValueError, match="samples: expected a whole number"):
        ar.State._of_native("Mahony", dtype, settings, (variables, None, 2**63))


#: What may stand in a state that somebody else wrote, within the range that is taken.
HOSTILE = [0.0, -0.0, 1.0, -1.0, 1e18, -1e18, 1e10, -1e10, 1e-300, 5e-324, 0.5, 2.0]


@pytest.mark.parametrize("dtype", DTYPES)
@each_case
def test_whatever_a_state_holds_it_is_refused_or_every_attitude_is_a_unit_quaternion(case: Case, dtype: type) -> None:
    rng = np.random.default_rng(1)
    f = case.make(rate=RATE, dtype=dtype)
    signals = motion(60, 3).astype(dtype)
    est = f.run(*signals.sensors())
    state, place = est.state, place_of(est.quat[-1], est.state)
    others = np.delete(np.arange(len(state.variables)), range(place, place + 4))
    taken = 0
    for trial in range(30):
        variables = list(state.variables)
        count = len(others) if trial == 0 else int(rng.integers(1, 6))
        for index in rng.choice(others, size=count, replace=False):
            variables[index] = float(dtype(rng.choice(HOSTILE)))
        try:
            est = f.run(*signals.sensors(), state=dataclasses.replace(state, variables=tuple(variables)))
        except ValueError:
            continue
        taken += 1
        norm2 = (est.quat.astype(np.float64) ** 2).sum(axis=1)
        # Norms are kept to some roundings, and given ones to 1e-5.
        assert np.abs(norm2 - 1.0).max() < 2e-5
        assert est.gyr_bias is None or np.isfinite(est.gyr_bias).all()
    assert taken, "every state was refused: nothing was tried"
