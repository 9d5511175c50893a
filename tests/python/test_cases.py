"""The list of cases is complete, so that the laws of the other files hold for the whole registry."""

from __future__ import annotations

import math

import pytest

import ahrs_rs as ar
from cases import CASES, STREAMING, Case, each_case, each_streaming_filter
from oracle import ORACLES


def test_the_registry_and_the_list_of_cases_are_not_empty() -> None:
    assert ar.FILTERS
    assert CASES


@each_streaming_filter
def test_every_filter_has_a_row_at_its_defaults(name: str) -> None:
    assert any(case.name == name and not case.params for case in CASES)


@each_streaming_filter
def test_every_option_of_every_filter_has_a_row(name: str) -> None:
    rows = [case.make() for case in CASES if case.name == name]
    for spec in ar.FILTERS[name].PARAMS.values():
        for option in spec.options or ():
            assert any(row.params[spec.name] == option for row in rows), f"{spec.name}={option!r} has no row"


def test_every_row_is_of_a_filter_of_the_registry_and_has_its_own_label() -> None:
    assert {case.name for case in CASES} <= set(STREAMING)
    assert len({case.label for case in CASES}) == len(CASES)


@each_streaming_filter
def test_every_filter_has_an_oracle(name: str) -> None:
    assert name in ORACLES


@each_streaming_filter
def test_a_filter_with_feedback_has_a_row_that_says_how_fast_it_settles(name: str) -> None:
    settles = [case for case in CASES if case.name == name and case.settling is not None]
    assert bool(settles) == ar.FILTERS[name].FEEDBACK


@each_case
def test_what_a_row_expects_is_a_number(case: Case) -> None:
    assert 0.0 < case.float32 < 0.5
    if case.settling is not None:
        for dip in (None, math.radians(60.0)):
            time, left = case.settling(dip, 0.01)
            assert math.isfinite(time)
            assert 0.0 < left < 0.1


@each_case
def test_the_sensor_rotation_law_is_one_that_the_registry_knows(case: Case) -> None:
    law, _, reason = case.cls.EQUIVARIANCE.partition(": ")
    assert law in ("exact", "heading", "no")
    assert bool(reason) == (law == "no"), "a filter without the law says why, one with it has nothing to say"


@each_streaming_filter
def test_an_oracle_follows_what_its_filter_follows(name: str) -> None:
    assert ORACLES[name].follows_field == ar.FILTERS[name].MAGNETOMETER
    reports = "covariance" in ar.FILTERS[name].OUTPUTS and name != "EKF"  # which is not told of losses
    assert ORACLES[name].has_covariance == reports


def test_the_oracles_are_those_of_the_registry() -> None:
    if set(ORACLES) != set(STREAMING):
        pytest.fail(f"oracles without a filter: {sorted(set(ORACLES) - set(STREAMING))}")
