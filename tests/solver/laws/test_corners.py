"""Corners and edges of limits: the same stress in a plane as in general, on turned axes, and beside the corner.

Where two or three principal stresses are the same, to rounding or nearly, a return has to choose surfaces and axes;
none of that may be seen in the stress. States are drawn at random; stresses are compared over the size of the trial
stress.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.tensors import rotation_matrix
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from tests.solver.laws.checks import usual_values

KINDS = ("mohr_coulomb", "hardening_soil", "hardening_soil_small")
CHANGES: tuple[dict[str, float], ...] = ({}, {"psi": 0.0}, {"psi": 8.0}, {"c": 0.0}, {"phi": 38.0})
APART = (0.0, 1.0e-12, 1.0e-9, 1.0e-6, 1.0e-3)
"""How far two equal principal values are from each other."""
SAME = 1.0e-8
"""Part of the trial stress that Newton's method and the choice of surfaces may decide."""

Call = tuple[FloatArray, FloatArray, FloatArray]
"""Strain increment (6,), stress (6,), state."""


def soil_of(kind: str, changes: dict[str, float]) -> Soil:
    law = find_law(kind)
    return law.soil({**usual_values(law), **changes})


def answer(soil: Soil, strain: FloatArray, stress: FloatArray, state: FloatArray) -> tuple[Any, ...]:
    return soil.law.update(strain, 0.0, stress, state, soil.constants)


def calls(soil: Soil, count: int) -> Iterator[Call]:
    """Steps from states with equal principal stresses, triaxial, isotropic or any, small to large, with turns."""
    rng, made = np.random.default_rng(5), 0
    while made < count:
        stress, strain = np.zeros(6), np.zeros(6)
        low = rng.uniform(0.25, 1.0)
        stress[:3] = 10.0 ** rng.uniform(0.3, 2.7) * np.array([[1, low, low], [1, 1, low], [1, 1, 1]])[rng.integers(3)]
        stress[:3] *= 1.0 + rng.choice(APART) * rng.normal(size=3)
        stress[:3] = stress[:3][rng.permutation(3)]
        along = [rng.normal(size=3), np.ones(3), np.where(np.arange(3) == rng.integers(3), 1.0, -0.45)][rng.integers(3)]
        along = rng.choice([-1.0, 1.0]) * (along + rng.choice(APART) * rng.normal(size=3))
        strain[:3] = along * 10.0 ** rng.uniform(-5.0, -1.5)
        if rng.random() < 0.3:
            strain[3] = rng.normal() * 10.0 ** rng.uniform(-12.0, -2.0)
        try:
            state = soil.law.initial_state(stress, soil.constants)
        except InfeasibleError:
            continue
        for _ in range(rng.integers(4)):
            new, after, _, status = answer(soil, strain, stress, state)
            if status < 0:
                break
            stress, state = new, after
        made += 1
        yield strain, stress, state


def size_of(soil: Soil, call: Call) -> float:
    """Of the trial stress, kPa."""
    strain, stress, _ = call
    return float(np.abs(stress).max() + soil.law.elastic_moduli(soil.constants, 100.0)[0] * np.abs(strain).max())


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("changes", CHANGES, ids=str)
def test_a_corner_is_the_same_in_a_plane_and_in_general(kind: str, changes: dict[str, float]) -> None:
    soil, differences, refused = soil_of(kind, changes), [], 0
    for call in calls(soil, 50):
        strain, stress, state = call
        general, plane = answer(soil, *call), answer(soil, strain[:4], stress[:4], state)
        assert (general[3] < 0) == (plane[3] < 0), call
        refused += general[3] < 0
        if general[3] >= 0:
            differences.append(np.abs(general[0][:4] - plane[0]).max() / size_of(soil, call))
    assert max(differences) < SAME
    assert refused <= 1


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("changes", CHANGES, ids=str)
def test_a_corner_is_the_same_on_turned_axes_and_has_no_jump_beside_it(kind: str, changes: dict[str, float]) -> None:
    soil, rng, turned, beside = soil_of(kind, changes), np.random.default_rng(6), [], []
    for call in calls(soil, 50):
        strain, stress, state = call
        here, size = answer(soil, *call), size_of(soil, call)
        if here[3] < 0:
            continue
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        axes[:, 0] *= np.linalg.det(axes)
        Q = rotation_matrix(axes)
        back = np.linalg.inv(Q).T
        history = state.copy()
        if kind == "hardening_soil_small":
            history[2:8] = back @ state[2:8]
        there = answer(soil, back @ strain, Q @ stress, history)
        if there[3] >= 0:
            turned.append(np.abs(there[0] - Q @ here[0]).max() / size)
        step = 1.0e-9 * np.abs(strain).max() * rng.normal(size=6)
        moved = answer(soil, strain + step, stress, state)
        if moved[3] >= 0:
            stiffness = np.abs(here[2]).max() + np.abs(moved[2]).max()
            beside.append((np.abs(moved[0] - here[0]).max() - 6.0 * stiffness * np.abs(step).max()) / size)
    assert min(len(turned), len(beside)) >= 49
    assert max(turned) < SAME
    assert max(beside) < SAME


def test_derivatives_that_are_asked_for_change_no_stress_at_corners() -> None:
    """With G0 = Gur the law for small strains is hardening soil, and asks for the derivative by the stiffness, too."""
    given = usual_values(find_law("hardening_soil_small"))
    plain_given = {name: value for name, value in given.items() if name not in ("G0_ref", "gamma_07")}
    plain = find_law("hardening_soil").soil(plain_given)
    small = find_law("hardening_soil_small").soil({**given, "G0_ref": given["Eur_ref"] / 2.4, "nu_ur": 0.2})
    for call in calls(plain, 100):
        strain, stress, state = call
        without = answer(plain, *call)
        asked = answer(small, strain, stress, np.concatenate([state, np.zeros(8), [1.0]]))
        assert without[3] == asked[3]
        if without[3] >= 0:
            assert np.abs(asked[0] - without[0]).max() < 1.0e-12 * size_of(plain, call)
            assert asked[2] == pytest.approx(without[2], rel=1.0e-9, abs=1.0e-9 * np.abs(without[2]).max())
