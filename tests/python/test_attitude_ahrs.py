"""Attitudes of a single moment beside the package `ahrs` 0.4.0, where that is right.

Its gravity is +z, which is the specific force of our NWU. Its SAAM and TRIAD are from earth to sensor, the conjugate of
ours; its FAMC, Davenport, QUEST and FLAE are from sensor to earth, as ours. Its FQA has the specific force of NED, as
ours. Where it differs:

- SAAM is NaN for a level sensor, where its closed form is 0/0.
- FLAE by "symbolic", its default, takes the real part of a complex number too early, and "newton" sets one part of the
  quaternion to -1 that may be zero.
- OLEQ stops after a few steps from a random start, so that two calls differ by degrees, and its reference for
  NED has the sine and the cosine of the dip exchanged.
- Davenport's default reference is in nT and in m/s²: what a sensor weighs depends on its unit.
- QUEST inverts a matrix that is singular for a level sensor that points north.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from signals import Floats, angle_between, conjugate, quats, random_turns, rotation

ahrs = pytest.importorskip("ahrs", reason="the package ahrs is not installed")

DIP = 60.0
#: Rounding, of which the polynomials of both lose some.
AGREEMENT = 1e-12


@pytest.fixture(scope="module")
def truth() -> Floats:
    return quats(random_turns(100, 1))


def measured(truth: Floats, earth: Any, seed: int, noise: float = 0.05) -> Floats:
    """A direction on earth in the sensor frames, with noise."""
    exact = rotation(truth).inv().apply(earth)
    return np.asarray(exact + noise * np.random.default_rng(seed).standard_normal(exact.shape))


def field(up: float) -> Floats:
    """The field with x north, and z up (1) or down (-1)."""
    return np.array([np.cos(np.radians(DIP)), 0.0, -up * np.sin(np.radians(DIP))])


def test_saam_and_famc_are_ours_in_nwu(truth: Floats) -> None:
    acc, mag = measured(truth, [0.0, 0.0, 1.0], 2), measured(truth, field(1.0), 3)
    ours = ar.attitude.saam(acc, mag, frame="NWU")
    assert angle_between(conjugate(ahrs.filters.SAAM(acc=acc, mag=mag).Q), ours).max() < AGREEMENT
    assert (
        angle_between(ahrs.filters.FAMC(acc=acc, mag=mag).Q, ar.attitude.famc(acc, mag, frame="NWU")).max() < AGREEMENT
    )


def test_triad_is_ours(truth: Floats) -> None:
    one, two = measured(truth, [0.0, 0.0, 1.0], 4), measured(truth, field(-1.0), 5)
    earth = np.stack(([0.0, 0.0, 1.0], field(-1.0)))
    peer = ahrs.filters.TRIAD(w1=one, w2=two, v1=earth[0], v2=earth[1]).A
    ours = ar.attitude.triad(np.stack((one, two), axis=1), earth)
    assert np.abs(peer - rotation(ours).inv().as_matrix()).max() < AGREEMENT


@pytest.mark.parametrize("weights", [(0.5, 0.5), (0.8, 0.2)])
def test_the_solutions_of_wahba_are_ours(truth: Floats, weights: tuple[float, float]) -> None:
    one, two = measured(truth, [0.0, 0.0, 1.0], 6), measured(truth, field(-1.0), 7)
    one, two = (each / np.linalg.norm(each, axis=1, keepdims=True) for each in (one, two))
    pairs = np.stack((one, two), axis=1), np.stack(([0.0, 0.0, 1.0], field(-1.0)))
    filters, w = ahrs.filters, np.array(weights)
    # With unit vectors and a gravity of 1, Davenport's weights are weights.
    peer = filters.Davenport(acc=one, mag=two, weights=w, magnetic_dip=DIP, gravity=1.0).Q
    assert angle_between(peer, ar.attitude.davenport(*pairs, weights=w)).max() < AGREEMENT
    peer = filters.QUEST(acc=one, mag=two, weights=w, magnetic_dip=DIP).Q
    assert angle_between(peer, ar.attitude.quest(*pairs, weights=w)).max() < AGREEMENT
    # Its FLAE has the dip upwards.
    peer = filters.FLAE(acc=one, mag=two, weights=w.copy(), magnetic_dip=-DIP, method="eig").Q
    assert angle_between(peer, ar.attitude.flae(*pairs, weights=w)).max() < AGREEMENT


def test_fqa_is_ours_in_ned(truth: Floats) -> None:
    acc, mag = measured(truth, [0.0, 0.0, -1.0], 8), measured(truth, field(-1.0), 9)
    peer = ahrs.filters.FQA(acc=acc, mag=mag, mag_ref=np.array([1.0, 0.0, 0.0])).Q
    # Its half angles lose half of the digits where they are small.
    assert angle_between(peer, ar.attitude.fqa(acc, mag, frame="NED")).max() < 1e-7
