"""Hypoplastic laws with intergranular strain in every state: axes, tangent, substeps, components, failures."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.tensors import rotation_matrix
from geoswarm.solver.element_test.boundary_conditions import Stage, strain_change, stress_value
from geoswarm.solver.element_test.load_paths import follow_load_path
from geoswarm.solver.element_test.material_point import follow, point_under
from geoswarm.solver.element_test.setups import isotropic_load
from geoswarm.solver.element_test.specimen import specimen_load_paths
from geoswarm.solver.errors import DivergedError, InfeasibleError
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.hypoplasticity.shared import mobilised_friction
from geoswarm.solver.laws.registry import find_law
from tests.solver.laws.test_laws import GIVEN

KINDS = [kind for kind in GIVEN if kind.startswith("hypoplastic_")]
R = 1.0e-4
STRESS = np.array([60.0, 100.0, 55.0, 8.0, -5.0, 3.0])
STRAIN = np.array([-2.0e-4, 5.0e-4, -1.0e-4, 3.0e-4, -2.0e-4, 1.0e-4])
ALL_ROUND = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])


def soil(kind: str, **changes: float | None) -> Soil:
    """A soil of a hypoplastic law."""
    return find_law(kind).soil({**GIVEN[kind], "R": R, **changes})


def states(of: Soil, stress: FloatArray = STRESS) -> Iterator[FloatArray]:
    """States without intergranular strain, and with some of any direction and size, along the step or against it."""
    fresh = of.law.initial_state(stress, of.constants)
    yield fresh
    random = np.random.default_rng(2)
    directions = [*random.standard_normal((4, 6)), STRAIN, -STRAIN]
    for direction, size in zip(directions, (0.05, 0.5, 0.95, 0.999, 1.0, 0.8), strict=True):
        state = fresh.copy()
        state[1:7] = (
            size * R * direction / math.sqrt(float((direction[:3] ** 2).sum() + 0.5 * (direction[3:] ** 2).sum()))
        )
        yield state


def step(of: Soil, strain: FloatArray, stress: FloatArray, state: FloatArray) -> tuple[FloatArray, ...]:
    """Stress, state and tangent after a strain."""
    new, after, tangent, status = of.law.update(strain, -math.inf, stress, state, of.constants)
    assert status >= 0
    return new, after, tangent


@pytest.mark.parametrize("kind", KINDS)
def test_the_answer_turns_with_the_axes(kind: str) -> None:
    of = soil(kind)
    for axes in Rotation.random(3, rng=np.random.default_rng(5)).as_matrix():
        Q = rotation_matrix(axes)
        back = np.linalg.inv(Q).T
        for state in states(of):
            turned = state.copy()
            turned[1:7] = back @ state[1:7]
            here, there = step(of, STRAIN, STRESS, state), step(of, back @ STRAIN, Q @ STRESS, turned)
            assert there[0] == pytest.approx(Q @ here[0], abs=1.0e-5)
            assert there[1][[0, 7]] == pytest.approx(here[1][[0, 7]], rel=1.0e-7)
            assert there[1][1:7] == pytest.approx(back @ here[1][1:7], abs=1.0e-7 * R)
            assert np.abs(there[2] - Q @ here[2] @ Q.T).max() < 1.0e-5 * np.abs(here[2]).max()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", [0.1, 1.0, 20.0])
@pytest.mark.parametrize("extra", [{}, {"R": 0.0}, {"chi": 1.0, "beta_r": 0.1}], ids=["usual", "plain", "early"])
def test_the_tangent_leaves_a_rest_of_second_order(kind: str, size: float, extra: dict[str, float]) -> None:
    """But for paths straight against h, which have a kink, and straight along it, see the next tests."""
    of, strain = soil(kind, **extra), size * STRAIN
    for state in list(states(of))[:-2]:
        new, _, tangent = step(of, strain, STRESS, state)
        for way in np.random.default_rng(7).uniform(-1.0, 1.0, (4, 6)):
            lengths = np.abs(strain).max() * 1.0e-2 * 0.5 ** np.arange(4)
            rests = []
            for length in lengths.tolist():
                there = step(of, strain + length * way, STRESS, state)[0]
                rests.append(np.abs(there - new - length * tangent @ way).max())
            rounding = 3.0e-8 * np.abs(new).max()  # what another choice of substeps changes
            clear = np.array(rests[1:]) > 10.0 * rounding
            assert rests[-1] < max(3.0e-3 * np.abs(tangent).max() * lengths[-1], 3.0 * rounding)
            assert (np.array(rests[:-1])[clear] > 3.0 * np.array(rests[1:])[clear]).all(), rests


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("place", "accuracy"), [(-1, 1.0e-3), (-2, 0.03)], ids=["back", "on"])
def test_the_tangent_holds_where_strain_goes_straight_back_or_on(kind: str, place: int, accuracy: float) -> None:
    """Straight on, substeps are so long that they pass over what a turn would do within strains of R."""
    of = soil(kind)
    state = list(states(of))[place]
    for size in (0.3, 1.0, 3.0):
        tangent = step(of, size * STRAIN, STRESS, state)[2]
        h = 1.0e-8
        slopes = [
            (step(of, size * STRAIN + h * way, STRESS, state)[0] - step(of, size * STRAIN - h * way, STRESS, state)[0])
            / (2.0 * h)
            for way in np.eye(6)
        ]
        assert np.abs(np.array(slopes).T - tangent).max() < accuracy * np.abs(tangent).max()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("count", [2, 3, 10])
def test_a_straight_path_is_the_same_in_pieces(kind: str, count: int) -> None:
    of = soil(kind)
    for state in states(of):
        whole, after, _ = step(of, 10.0 * STRAIN, STRESS, state)
        stress, part = STRESS, state
        for _ in range(count):
            stress, part, _ = step(of, 10.0 * STRAIN / count, stress, part)
        assert stress == pytest.approx(whole, abs=1.0e-6 * 100.0)
        assert part[0] == pytest.approx(after[0], rel=1.0e-12)
        assert part[1:7] == pytest.approx(after[1:7], abs=1.0e-6 * R)


@pytest.mark.parametrize("kind", KINDS)
def test_four_components_give_what_six_give(kind: str) -> None:
    of, plane = soil(kind), np.array([1.0, 1.0, 1.0, 1.0, 0.0, 0.0])
    for state in states(of, STRESS * plane):
        inside = state.copy()
        inside[5:7] = 0.0
        general = step(of, STRAIN * plane, STRESS * plane, inside)
        planar = step(of, (STRAIN * plane)[:4], (STRESS * plane)[:4], inside)
        assert planar[0] == pytest.approx(general[0][:4], rel=1.0e-9)
        assert planar[1] == pytest.approx(general[1], rel=1.0e-9)
        assert planar[2] == pytest.approx(general[2][:4, :4], abs=1.0e-7 * np.abs(general[2]).max())


@pytest.mark.parametrize("kind", KINDS)
def test_a_step_without_strain_has_the_stiffness_of_a_reversal(kind: str) -> None:
    of = soil(kind)
    stress, state = STRESS, of.law.initial_state(STRESS, of.constants)
    for _ in range(5):
        stress, state, _ = step(of, 2.0 * STRAIN, stress, state)
    here = step(of, np.zeros(6), stress, state)
    assert here[0] == pytest.approx(stress, rel=1.0e-14)
    assert here[1] == pytest.approx(state, rel=1.0e-12)
    tiny = -1.0e-5 * STRAIN
    assert here[2] @ tiny == pytest.approx(step(of, tiny, stress, state)[0] - stress, rel=1.0e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_wild_steps_are_answered_or_refused(kind: str) -> None:
    random = np.random.default_rng(11)
    refused = 0
    for of in (soil(kind), soil(kind, R=0.0), soil(kind, p_t=10.0)):
        for size in 10.0 ** np.arange(-14.0, 4.0):
            for state in states(of):
                new, after, tangent, status = of.law.update(
                    size * random.standard_normal(6), 0.0, STRESS, state, of.constants
                )
                refused += status < 0
                if status >= 0:
                    assert all(np.isfinite(one).all() for one in (new, after, tangent))
    assert refused > 0


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("strain", [-0.5 * ALL_ROUND, np.full(6, math.nan), np.full(6, math.inf), 0.9 * ALL_ROUND])
def test_where_the_law_ends_there_is_no_stress(kind: str, strain: FloatArray) -> None:
    of = soil(kind)
    state = of.law.initial_state(STRESS, of.constants)
    assert of.law.update(strain, 0.0, STRESS, state, of.constants)[3] == -1
    assert of.law.update(STRAIN, 0.0, np.full(6, math.nan), state, of.constants)[3] == -1
    assert of.law.update(STRAIN, 0.0, -STRESS, state, of.constants)[3] == -1


@pytest.mark.parametrize("kind", KINDS)
def test_a_load_that_the_soil_does_not_carry_is_reported(kind: str) -> None:
    of = soil(kind)
    start = point_under(100.0 * ALL_ROUND, of)
    with pytest.raises(DivergedError, match="isotropic load -10 kPa: no solution"):
        follow(of, start, [isotropic_load(-10.0, 0.0)], [[0.0]])
    shear = [strain_change(0.0, **{name: 1}) for name in ("xy", "yz", "zx")]
    controls = (stress_value(100.0, xx=1), stress_value(100.0, yy=1), stress_value(900.0, zz=1), *shear)
    with pytest.raises(DivergedError, match="too much: no solution"):
        follow(of, start, [Stage("too much", 0.0, controls, instant=True)], [[0.0]])


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_mobilised_friction_angle_is_that_of_mohrs_circles_in_triaxial_states(way: float) -> None:
    of = soil("hypoplastic_sand", p_t=2.0)
    low, high = 40.0, 90.0
    stress = np.array([low, low, high, 0.0, 0.0, 0.0]) if way > 0.0 else np.array([high, high, low, 0.0, 0.0, 0.0])
    angle = math.degrees(math.asin((high - low) / (high + low + 4.0)))
    assert float(mobilised_friction(stress, 2.0)) == pytest.approx(angle, rel=1.0e-12)
    state = of.law.initial_state(stress, of.constants)
    assert state[7] == pytest.approx(angle, rel=1.0e-12)
    state[7] = 0.0
    assert step(of, np.zeros(6), stress, state)[1][7] == pytest.approx(angle, rel=1.0e-10)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"e0": 0.5}, "e0 must be above e_d = 0.5.* under a mean stress of 71.6667 kPa, got 0.5"),
        ({"e0": 1.09}, "e0 must be above .* and at most e_i = 1.0.* under a mean stress of 71.6667 kPa, got 1.09"),
    ],
)
def test_a_void_ratio_outside_the_limits_of_the_stress_is_reported(changes: dict[str, float], message: str) -> None:
    of = soil("hypoplastic_sand", **changes)
    with pytest.raises(InfeasibleError, match=message):
        of.law.initial_state(STRESS, of.constants)
    with pytest.raises(InfeasibleError, match=message):
        of.law.initial_state(np.stack([STRESS, STRESS]), of.constants)


@pytest.mark.parametrize(
    ("changes", "stress", "message"),
    [
        (
            {"OCR": 1.0, "e0": 0.9},
            STRESS,
            "e0 = 0.9 under a mean stress of 71.6667 kPa; it must be above 0 and at most 0.6",
        ),
        ({"OCR": 1.0e9}, STRESS, "OCR = 1e.09 gives a void ratio = -0.4.*; it must be above 0 and at most "),
        ({}, -STRESS, "compression only"),
        ({}, np.array([0.0, 50.0, 50.0, 0.0, 0.0, 0.0]), "friction angle of 90 degree: .* compression only"),
    ],
)
def test_a_clay_that_cannot_be_under_its_stress_is_reported(
    changes: dict[str, float], stress: FloatArray, message: str
) -> None:
    of = soil("hypoplastic_clay", **changes)
    with pytest.raises(InfeasibleError, match=message):
        of.law.initial_state(stress, of.constants)
    with pytest.raises(InfeasibleError, match=message):
        of.law.initial_state(np.stack([stress[:4], stress[:4]]), of.constants)


def test_dense_sand_slides_along_its_densest_state_in_few_steps() -> None:
    """Unloading holds e at e_d, where the slope of f_d was infinite: 145 steps of 500 substeps and more, 5 s."""
    values = {"phi_c": 31.17, "h_s": 7.209e6, "n": 0.3672, "e_d0": 0.5971, "e_c0": 1.0931, "e_i0": 1.3314}
    of = find_law("hypoplastic_sand").soil({**values, "alpha": 0.0839, "beta": 1.703, "e0": 0.5834523})
    state = point_under([228.369, 100.0, 228.369, 0.0], of)
    path = follow_load_path(of, specimen_load_paths("unloading", 4, 5.0, None, 0.0, 0.0, False)[0], state, 1.0e-5)
    assert len(path.places) < 20
    stress, e = path.end.stress, path.end.internal[0]
    e_d, e_c = (values[name] * math.exp(-((stress[:3].sum() / 7.209e6) ** 0.3672)) for name in ("e_d0", "e_c0"))
    assert e == pytest.approx(e_d, abs=1.0e-6 * (e_c - e_d))
