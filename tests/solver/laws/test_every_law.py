"""Every built-in law: what it declares, and what must hold for its stress update whatever it is."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geoswarm.solver.element_test.boundary_conditions import Stage, strain_change, stress_value
from geoswarm.solver.element_test.material_point import follow, point_under
from geoswarm.solver.errors import DivergedError, InfeasibleError
from geoswarm.solver.laws.base import Law
from geoswarm.solver.laws.registry import BUILT_IN, find_law
from tests.solver.laws.checks import (
    LARGE,
    SMALL,
    STRESS,
    UNDETERMINED,
    WITHOUT_ELASTIC_RANGE,
    Case,
    bad_values,
    by_element_test,
    by_finite_element,
    cases,
    cycle_work,
    elastic_loop_work,
    follow_strain,
    followed_back,
    loop_energy,
    shear_depends_on_pressure,
    taylor_rests,
    turned,
    usual_values,
)

CASES = {case.name: case for case in cases()}
ELASTIC = {name: case for name, case in CASES.items() if case.law.kind not in WITHOUT_ELASTIC_RANGE}
PLANE = np.array([1.0, 1.0, 1.0, 1.0, 0.0, 0.0])
PAGES = Path(__file__).parents[3] / "docs" / "laws"


@pytest.fixture(params=CASES.values(), ids=CASES.keys())
def case(request: pytest.FixtureRequest) -> Case:
    """One soil after the other."""
    found: Case = request.param
    return found


@pytest.fixture(params=[find_law(kind) for kind in BUILT_IN], ids=list(BUILT_IN))
def law(request: pytest.FixtureRequest) -> Law:
    """One law after the other."""
    found: Law = request.param
    return found


def test_a_law_declares_what_it_is(law: Law) -> None:
    assert BUILT_IN[law.kind].endswith(f":{type(law).__name__}")
    assert len({info.name for info in law.parameters}) == len(law.parameters)
    assert law.derived <= {info.name for info in law.parameters if info.default == 0.0}
    for info in law.parameters:
        assert info.description.endswith(".")
        assert info.typical is None or all(info.admits(value) for value in info.typical)
    soil = law.soil(usual_values(law))
    assert law.initial_state(STRESS, soil.constants).shape == (len(law.state),)
    assert law.initial_state(np.tile(STRESS, (2, 3, 1)), soil.constants).shape == (2, 3, len(law.state))
    assert law.state_weights(soil.constants).shape == (len(law.state),)
    assert all(modulus > 0.0 for modulus in law.elastic_moduli(soil.constants, 100.0))
    scale = law.log_time_scale(STRESS, law.initial_state(STRESS, soil.constants), soil.constants)
    assert law.depends_on_time == (scale is not None)
    if law.knows_K0:
        assert law.K0(soil.constants) == pytest.approx(0.55, abs=0.3)


def test_tensors_of_the_state_are_those_that_turn(law: Law) -> None:
    names, ends = [one.name for one in law.state], ("xx", "yy", "zz", "xy", "yz", "zx")
    found = [
        n for n in range(len(names) - 5) if all(a.endswith(b) for a, b in zip(names[n : n + 6], ends, strict=True))
    ]
    assert [one.first for one in law.tensors] == found
    assert all(one.shear == 2.0 for one in law.tensors)  # engineering strains


def test_every_usual_range_has_a_source(law: Law) -> None:
    for info in law.parameters:
        assert info.typical is not None, info.name
        assert len(info.source) > 10, info.name


def test_terms_of_laboratories_lead_back_to_the_parameters(law: Law) -> None:
    usual = {**usual_values(law), "e_0": 1.1}
    for term in law.terms:
        value = usual.get(term.parameter) or next(
            0.5 * sum(info.typical or (0.0, 0.0)) for info in law.parameters if info.name == term.parameter
        )
        known = {**usual, term.parameter: value}
        assert term.back(term.of(known), known) == pytest.approx(value, rel=1e-12), term.quantity


def test_a_law_has_its_page(law: Law) -> None:
    page = (PAGES / f"{law.kind.replace('_', '-')}.md").read_text(encoding="utf-8")
    for name in (*(info.name for info in law.parameters), *(one.name for one in law.settings)):
        assert f"`{name}`" in page, name
    assert f"({law.kind.replace('_', '-')}.md)" in (PAGES / "README.md").read_text(encoding="utf-8")
    assert "](../pictures/theory/" in page or "](../verification/figures/" in page


def test_what_is_outside_its_limits_is_reported(law: Law) -> None:
    usual = usual_values(law)
    for info in law.parameters:
        for value in bad_values(info):
            with pytest.raises(InfeasibleError, match=f"^{info.name} must be .*, got "):
                law.soil({**usual, info.name: value})
        if info.default is None:
            with pytest.raises(InfeasibleError, match=f"needs {info.name}, which is not given"):
                law.soil({name: value for name, value in usual.items() if name != info.name})
    for one in law.settings:
        if not one.choices:
            with pytest.raises(InfeasibleError, match=f"^{one.name} must be .*, got "):
                law.soil({**usual, one.name: one.lower - 1.0})


def test_what_excludes_each_other_is_reported(law: Law) -> None:
    """Of parameters that follow from one another, one is enough and two are too many."""
    usual = usual_values(law)
    for name in usual.keys() & law.derived:
        less = {key: value for key, value in usual.items() if key != name}
        assert law.incomplete(frozenset(less)) is not None
        with pytest.raises(InfeasibleError, match=r"^give exactly one of .* and .*, a value above 0"):
            law.soil(less)


@pytest.mark.parametrize("step", [SMALL, LARGE])
def test_the_answer_turns_with_the_axes(case: Case, step: np.ndarray) -> None:
    for axes in Rotation.random(2, rng=np.random.default_rng(5)).as_matrix():
        stress, state, tangent = turned(case, axes, stress=STRESS, strain=step)
        assert stress < 1.0e-9
        assert state < 1.0e-9
        assert tangent < 1.0e-7


@pytest.mark.parametrize("step", [SMALL, LARGE])
@pytest.mark.parametrize("log_time", [-math.inf, 0.0])
def test_the_tangent_leaves_a_rest_of_second_order(case: Case, step: np.ndarray, log_time: float) -> None:
    size = float(np.abs(step).max())
    lengths = size * 1.0e-2 * 0.5 ** np.arange(5)
    for way in np.random.default_rng(7).uniform(-1.0, 1.0, (2, 6)):
        rests = taylor_rests(case, step, way, lengths, log_time)
        rounding = 1.0e-11
        assert rests[-1] < max(rounding, 1.0e-3 * lengths[-1] / lengths[0])
        clear = rests[1:] > 10.0 * rounding
        assert (rests[:-1][clear] > 3.3 * rests[1:][clear]).all(), rests


def test_halving_steps_converges(case: Case) -> None:
    """First order at least: from 8 to 64 steps what a halving changes falls to an eighth."""
    ends = [follow_strain(case, LARGE, count, 0.0)[0] for count in (8, 16, 64, 128)]
    coarse, fine = (np.abs(ends[i + 1] - ends[i]).max() for i in (0, 2))
    assert fine < max(0.2 * coarse, UNDETERMINED.get(case.law.kind, 1.0e-9) * np.abs(ends[-1]).max())


@pytest.mark.parametrize("name", ELASTIC)
def test_elastic_strain_and_back_leaves_no_stress_and_takes_no_work(name: str) -> None:
    case = ELASTIC[name]
    if "OCR" in {info.name for info in case.law.parameters}:
        case = case.changed(OCR=8.0)
    stress, work = followed_back(case, 0.2 * SMALL, 20)
    assert stress == pytest.approx(STRESS, rel=1.0e-9)
    assert abs(work) < 1.0e-9
    if not shear_depends_on_pressure(case):
        stress, coarse = elastic_loop_work(case, 5.0e-5, 10)
        fine = elastic_loop_work(case, 5.0e-5, 20)[1]
        assert stress == pytest.approx(STRESS, rel=1.0e-9)
        assert abs(fine) < max(0.3 * abs(coarse), 1.0e-9)


@pytest.mark.parametrize("name", [name for name, case in ELASTIC.items() if shear_depends_on_pressure(case)])
def test_a_loop_takes_and_gives_what_a_shear_stiffness_that_grows_with_pressure_must(name: str) -> None:
    """Compressed, sheared, and both back: -(G after compression less G before) e:e, and nothing beside it.

    Such elasticity, with one Poisson's ratio at all pressures, has no potential. The shear stiffness of hardening soil
    follows the minor stress, which shear changes: there the energy falls with the cube of the loop, as it does here.
    """
    case = ELASTIC[name]
    if "OCR" in {info.name for info in case.law.parameters}:
        case = case.changed(OCR=8.0)
    energy, growth, square = loop_energy(case, 5.0e-5, 20)
    if case.law.kind != "hardening_soil":
        assert energy == pytest.approx(-growth * square, rel=0.01)
    assert loop_energy(case, 2.5e-5, 20)[0] == pytest.approx(energy / 8.0, rel=0.05)


@pytest.mark.parametrize("name", [name for name in CASES if name not in ELASTIC])
def test_a_cycle_without_an_elastic_range_gives_no_energy(name: str) -> None:
    """Small-strain stiffness takes work in every cycle.

    Within the range of intergranular strain, nothing stays and no work is taken; beyond it, work is taken. Plain
    hypoplasticity has no elastic range: what a cycle takes or gives falls with the cube of its size, faster than the
    energy that goes in and out.
    """
    case = CASES[name]
    ways = np.random.default_rng(3).uniform(-1.0, 1.0, (3, 6))
    if case.law.kind == "hardening_soil_small":
        assert all(cycle_work(case, size * way)[1] > 1.0e-3 for size in (2.0e-6, 2.0e-4) for way in ways)
    elif "R" in case.given:
        for way in ways:
            left, work = cycle_work(case, 0.02 * case.given["R"] * way)
            assert left < 1.0e-9
            assert abs(work) < 1.0e-9
            assert cycle_work(case, 2.0 * case.given["R"] * way)[1] > 0.05
    else:
        for way in ways:
            coarse, fine = (cycle_work(case, size * way)[1] for size in (2.0e-5, 2.0e-6))
            assert fine == pytest.approx(0.1 * coarse, rel=0.05)
            assert abs(coarse) < 0.01


@pytest.mark.parametrize("step", [SMALL, LARGE])
def test_four_components_give_what_six_give(case: Case, step: np.ndarray) -> None:
    if case.law.components != {4, 6}:
        assert case.law.components in ({4}, {6})  # there is nothing to compare
        return
    stress, strain = STRESS * PLANE, step * PLANE
    state = case.state(stress)
    assert case.state(stress[:4]) == pytest.approx(state, rel=1.0e-14)
    general = case.update(strain, stress, state, 0.0)
    planar = case.update(strain[:4], stress[:4], state, 0.0)
    assert general[3] >= 0
    assert (planar[3] > 0) == (general[3] > 0)
    assert planar[0] == pytest.approx(general[0][:4], rel=1.0e-9)
    assert general[0][4:] == pytest.approx([0.0, 0.0], abs=1.0e-12)
    assert planar[1] == pytest.approx(general[1], rel=1.0e-9)
    assert planar[2] == pytest.approx(general[2][:4, :4], rel=1.0e-6, abs=1.0e-7 * np.abs(general[2]).max())


def test_one_finite_element_gives_what_the_element_test_gives(case: Case) -> None:
    if 4 not in case.law.components:
        assert case.law.components == {6}  # for element tests only
        return
    stress, state, lateral = by_element_test(case, 0.02, 20)
    found = by_finite_element(case, 0.02, 20)
    assert found[0] == pytest.approx(stress[:4], rel=1.0e-6, abs=1.0e-6)
    assert found[1] == pytest.approx(state, rel=1.0e-6)
    assert found[2] == pytest.approx(lateral, rel=1.0e-6)


def test_a_step_without_strain_changes_nothing(case: Case) -> None:
    state = case.state()
    stress, after, tangent, status = case.update(np.zeros(6), STRESS, state)
    assert status >= 0
    assert stress == pytest.approx(STRESS, rel=1.0e-12)
    assert after == pytest.approx(state, rel=1.0e-12)
    assert np.isfinite(tangent).all()


def test_wild_steps_are_answered_or_refused(case: Case) -> None:
    """Never with numbers that are none; the same again gives the same bits, and inputs stay as they are."""
    rng = np.random.default_rng(11)
    for size in 10.0 ** np.arange(-12.0, 4.0):
        for _ in range(6):
            strain, state = size * rng.normal(size=6), case.state()
            kept, log_time = (strain.copy(), STRESS.copy(), state.copy()), float(rng.choice([-math.inf, 0.0]))
            first, again = (case.update(strain, STRESS, state, log_time) for _ in range(2))
            assert all((a == b).all() for a, b in zip((strain, STRESS, state), kept, strict=True))
            assert first[3] == again[3]
            if first[3] >= 0:
                assert all(np.isfinite(one).all() for one in first[:3])
                assert all(a.tobytes() == b.tobytes() for a, b in zip(first[:3], again[:3], strict=True))


def test_a_load_without_an_equilibrium_is_reported(case: Case) -> None:
    """Tension of all axes: no law carries it, or it is carried; the driver ends in either case."""
    controls = [stress_value(-1.0e5, **{name: 1}) for name in ("xx", "yy", "zz")]
    fixed = [strain_change(0.0, **{name: 1}) for name in ("xy", "yz", "zx")]
    stage = Stage("pulled", 1.0, (*controls, *fixed))
    try:
        history = follow(case.soil, point_under(STRESS, case.soil), [stage], [[1.0]])
    except DivergedError as error:
        assert "stage pulled: no solution" in str(error)  # noqa: PT017  either answer is right
    else:
        assert history.stress[-1, :3] == pytest.approx(-1.0e5, rel=1.0e-6)
