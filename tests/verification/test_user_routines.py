"""User routines of Abaqus, written for the tests, against closed forms and our own laws, at a point and in elements."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.boundary_conditions import Stage, strain_change, stress_value
from geoswarm.solver.element_test.consolidation import Column
from geoswarm.solver.element_test.material_point import History, follow, point_under
from geoswarm.solver.element_test.setups import (
    confined_load,
    drained_triaxial,
    isotropic_load,
    relaxation,
    simple_shear,
    undrained_triaxial,
)
from geoswarm.solver.fem.materials import Material
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.results import PhaseResult
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.solver.laboratory.flow.crs_record import Flow, lead
from geoswarm.solver.laboratory.record import Voids
from geoswarm.solver.laboratory.shear_stages import ShearStage
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.verification.specimens.bodies import block, graded, node_at
from geoswarm.verification.specimens.soils import elastic, mohr_coulomb
from tests.solver.user_laws.routines import DRUCKER_PRAGER, ELASTIC, NORTON, soil

STRENGTH = {"c": 5.0, "phi": 25.0, "psi": 5.0}
MODULI = {"E": 1.0e4, "nu": 0.3}
BULK, SHEAR = 1.0e4 / 1.2, 1.0e4 / 2.6
CELL = [100.0, 100.0, 100.0, 0.0, 0.0, 0.0]
STEPS = np.linspace(0.1, 1.0, 10)
CLOSE = Control(tolerance=1.0e-9)
ONE = block(np.array([0.0, 1.0]), np.array([0.0, 1.0]))


def prandtl(**given: float) -> Soil:
    """Drucker and Prager without friction: von Mises; q at yield is ``k``."""
    return soil(
        {**DRUCKER_PRAGER, "parameters": {"E": {}, "nu": {}, "k": {}}, "props": ["E", "nu", 0, 0, "k"], "K0": 1}, given
    )


def assert_same(found: History, expected: History, size: float = 1.0e-6) -> None:
    """Stress, axial and volumetric strain agree; how the edge of Mohr-Coulomb shares out lateral strain is open."""
    assert found.stress == pytest.approx(expected.stress, rel=size, abs=size * np.abs(expected.stress).max())
    for rows in (np.array([0, 0, 1, 0, 0, 0]), np.array([1, 1, 1, 0, 0, 0])):
        assert found.strain @ rows == pytest.approx(expected.strain @ rows, abs=size * np.abs(expected.strain).max())


def test_an_elastic_routine_follows_our_elasticity_through_element_tests() -> None:
    stages = [
        isotropic_load(150.0, 0.5),
        drained_triaxial(0.01, 150.0, 1.0),
        simple_shear(0.02, 200.0, 1.0),
        confined_load(90.0, 1.0),
    ]
    times = [[0.5], STEPS, STEPS, [1.0]]
    histories = [
        follow(one, point_under(CELL, one), stages, times)
        for one in (soil(ELASTIC, MODULI), find_law("elastic").soil(MODULI))
    ]
    assert_same(*histories, size=1.0e-9)


@pytest.mark.parametrize("tangent", ["routine", "differences"])
def test_drucker_prager_is_mohr_coulomb_in_triaxial_compression(tangent: str) -> None:
    ours = find_law("mohr_coulomb").soil({**MODULI, **STRENGTH})
    routine = soil(DRUCKER_PRAGER, {**MODULI, **STRENGTH}, tangent=tangent)
    for stage in (drained_triaxial(0.05, 100.0, 1.0), undrained_triaxial(0.02, 1.0)):
        found, expected = (
            follow(one, point_under(CELL, one), [stage], [STEPS], tolerance=1.0e-7) for one in (routine, ours)
        )
        assert_same(found, expected)
    drained = follow(routine, point_under(CELL, routine), [drained_triaxial(0.05, 100.0, 1.0)], [STEPS])
    assert drained.q[-1] == pytest.approx(162.0881, abs=1.0e-3)
    assert drained.internal[:, 0].tolist() == [*[0.0] * 3, *[1.0] * 7]  # yields at 1.62 %
    # Beyond yield volume grows by M_psi a unit of plastic deviatoric strain.
    sine = math.sin(math.radians(5.0))
    volume, plastic = drained.strain[:, :3].sum(axis=1), drained.internal[:, 1]
    assert np.diff(volume[3:]) == pytest.approx(-6.0 * sine / (3.0 - sine) * np.diff(plastic[3:]), rel=1.0e-6)


def test_a_consolidating_column_keeps_flags_whole_and_agrees_with_our_cone() -> None:
    """In one-dimensional compression with nu = 0.2 it yields from its drained end on; flags have no means."""
    values = {"E": 1.0e4, "nu": 0.2, "c": 5.0, "phi": 20.0, "psi": 0.0}
    stages = [ShearStage("load", "strain", (0.02,), (0.1,)), ShearStage("unload", "strain", (0.018,), (0.01,))]
    flow = Flow(2.0e-4, 0.0, 0.02, large=False)
    found = []
    for one in (soil(DRUCKER_PRAGER, values), find_law("drucker_prager").soil(values)):
        column = Column.of([(one, point_under([60.0, 100.0, 60.0, 0.0], one))] * 9)
        _, paths = lead(column, flow, stages, Voids(None, fixed=True, water_modulus=None), 1.0e-7)
        found.append(np.array([path.ends[-1] for path in paths]))
        if not column.internal.size:
            continue
        assert set(column.internal[:, 0].tolist()) <= {0.0, 1.0}
        assert column.internal[:, 1].min() > 0.0  # all have yielded on the way
    assert found[0] == pytest.approx(found[1], rel=1.0e-6, abs=1.0e-3)


def test_the_apex_of_the_cone_holds_the_tension_that_it_should() -> None:
    of = soil(DRUCKER_PRAGER, {**MODULI, **STRENGTH})
    strain = np.array([-2.0e-2, -2.1e-2, -1.9e-2, 1.0e-3, 0.0, 0.0])
    stress, state, _, status = of.law.update(
        strain, 0.0, np.array(CELL), of.law.initial_state(np.array(CELL), of.constants), of.constants
    )
    assert (status, state[0]) == (1, 2.0)
    assert stress == pytest.approx([-5.0 / math.tan(math.radians(25.0))] * 3 + [0.0] * 3)


def test_a_von_mises_tube_reaches_its_limit_pressure() -> None:
    # Plane strain at the limit: shear strength k/sqrt(3) all around, p = 2 k/sqrt(3) ln(b/a).
    material = Material(prandtl(E=1.0e4, nu=0.3, k=50.0 * math.sqrt(3.0)))
    mesh = block(graded(1.0, 2.0, 24), np.array([0.0, 0.1]))
    held = (Fixity("bottom", y=0.0), Fixity("top", y=0.0))
    phase = Phase(
        "widening",
        materials={"soil": material},
        fixities=(*held, Fixity("left", x=0.06)),
        load_step=0.02,
        largest_load_step=0.02,
    )
    result = solve_phases(mesh, [phase], geometry="axisymmetric", control=CLOSE)[0]
    pressure = float(result.reactions[np.unique(mesh.boundaries["left"]), 0].sum()) / 0.1
    assert result.plastic.all()
    assert pressure == pytest.approx(100.0 * math.log(2.0), rel=0.005)


def triaxial_in_elements(material: Material, widening: float) -> PhaseResult:
    """An axisymmetric specimen under a cell pressure of 100 kPa, shortened."""
    cell = Phase(
        "cell",
        "K0",
        materials={"soil": material},
        initial_stress=lambda x: np.tile([-100.0, -100.0, -100.0, 0.0], (x.shape[0], 1)),
        fixities=(Fixity("bottom", y=0.0), Fixity("left", x=0.0)),
        tractions=(Traction("right", normal=-100.0), Traction("top", normal=-100.0)),
    )
    shear = Phase(
        "shear",
        fixities=(Fixity("bottom", y=0.0), Fixity("left", x=0.0), Fixity("top", y=-widening)),
        tractions=(Traction("right", normal=-100.0),),
        load_step=0.05,
        largest_load_step=0.05,
    )
    return solve_phases(ONE, [cell, shear], geometry="axisymmetric", control=CLOSE)[-1]


@pytest.mark.parametrize("name", ["elastic", "drucker_prager"])
def test_elements_give_what_the_element_test_gives(name: str) -> None:
    given, values = (ELASTIC, MODULI) if name == "elastic" else (DRUCKER_PRAGER, {**MODULI, **STRENGTH})
    of = soil(given, values)
    result = triaxial_in_elements(Material(of), 0.03)
    point = follow(of, point_under(CELL, of), [drained_triaxial(0.03, 100.0, 1.0)], [[1.0]], tolerance=1.0e-9)
    expected = -point.stress[0, [0, 2, 1, 3]]
    assert result.stress == pytest.approx(np.broadcast_to(expected, result.stress.shape), rel=1.0e-6, abs=1.0e-4)
    width = result.displacements[np.unique(ONE.boundaries["right"]), 0]
    assert width == pytest.approx(np.full(width.shape, -point.strain[0, 0]), rel=1.0e-6)
    ours = elastic(**{"young": 1.0e4, "poisson": 0.3}) if name == "elastic" else mohr_coulomb(1.0e4, 0.3, **STRENGTH)
    other = triaxial_in_elements(ours, 0.03)
    assert result.displacements == pytest.approx(other.displacements, abs=1.0e-8)


def norton(m: float, **changes: object) -> Soil:
    """Creep with the power m; the rate at q = 100 kPa is 1e-3 a day."""
    return soil(NORTON, {**MODULI, "A": 1.0e-3 / 100.0**m, "m": m}, **changes)


@pytest.mark.parametrize("m", [1.0, 3.0, 5.0])
def test_creep_under_constant_stress_has_the_rate_of_norton(m: float) -> None:
    of = norton(m)
    start = [100.0, 100.0, 220.0, 0.0, 0.0, 0.0]
    times = np.array([1.0, 5.0, 20.0])
    shear = (strain_change(0.0, xy=1), strain_change(0.0, yz=1), strain_change(0.0, zx=1))
    constant = (stress_value(100.0, xx=1), stress_value(100.0, yy=1), stress_value(220.0, zz=1), *shear)
    stage = Stage("constant", 20.0, constant, instant=True)
    history = follow(of, point_under(start, of), [stage], [times], tolerance=1.0e-9)
    rate = 1.0e-3 * 1.2**m
    assert history.strain[:, 2] == pytest.approx(rate * times, rel=1.0e-7, abs=1.0e-9)
    assert history.strain[:, 0] == pytest.approx(-0.5 * rate * times, rel=1.0e-7, abs=1.0e-9)
    assert history.internal[:, 0] == pytest.approx(rate * times, rel=1.0e-7, abs=1.0e-9)
    assert history.internal[:, 1] == pytest.approx(times, rel=1.0e-6)


def relaxed(m: float, times: FloatArray) -> FloatArray:
    """q at times: q' = -3 G A q**m from 120 kPa."""
    A = 1.0e-3 / 100.0**m
    if m == 1.0:
        return 120.0 * np.exp(-3.0 * SHEAR * A * times)
    found: FloatArray = (120.0 ** (1.0 - m) + (m - 1.0) * 3.0 * SHEAR * A * times) ** (1.0 / (1.0 - m))
    return found


@pytest.mark.parametrize("m", [1.0, 3.0, 5.0])
def test_relaxation_follows_the_closed_form(m: float) -> None:
    of = norton(m)
    times = np.array([1.0, 5.0, 20.0])
    start = point_under([100.0, 100.0, 220.0, 0.0, 0.0, 0.0], of)
    errors = []
    for tolerance in (1.0e-5, 5.0e-6, 1.0e-8):
        history = follow(of, start, [relaxation(20.0)], [times], tolerance=tolerance)
        errors.append(float(np.abs(history.q - relaxed(m, times)).max()))
        assert errors[-1] <= 3.0 * SHEAR * tolerance
        assert history.p == pytest.approx([140.0] * 3, rel=1.0e-9)
    assert errors[2] < 0.01 * errors[0]


def test_creep_in_elements_has_the_rate_of_norton() -> None:
    times = (1.0, 5.0, 20.0)
    start = Phase(
        "start",
        "K0",
        materials={"soil": Material(norton(3.0))},
        initial_stress=lambda x: np.tile([-100.0, -220.0, -100.0, 0.0], (x.shape[0], 1)),
        fixities=(Fixity("bottom", y=0.0), Fixity("left", x=0.0)),
        tractions=(Traction("right", normal=-100.0), Traction("top", normal=-220.0)),
    )
    loaded = Phase("loaded", "creep", duration=20.0, output_times=times)
    result = solve_phases(
        ONE, [start, loaded], geometry="axisymmetric", observe=[node_at(ONE, 1.0, 1.0)], control=CLOSE
    )[-1]
    rate = 1.0e-3 * 1.2**3
    assert result.history.displacements[:, 0, 1] == pytest.approx(-rate * np.array(times), rel=1.0e-6)
    assert result.history.displacements[:, 0, 0] == pytest.approx(0.5 * rate * np.array(times), rel=1.0e-6)
    assert result.internal[..., 1] == pytest.approx(np.full((2, 3), 20.0))


def test_a_closed_elastic_loop_gives_and_takes_no_energy() -> None:
    of = soil(DRUCKER_PRAGER, {**MODULI, **STRENGTH})
    stress, state = np.array(CELL), of.law.initial_state(np.array(CELL), of.constants)
    corners = np.array(
        [[0, 0, 0, 0, 0, 0], [2, 1, 3, 2, 0, 1], [-1, 2, 1, 3, 2, -2], [0, -1, 2, 0, 1, 1], [0, 0, 0, 0, 0, 0]]
    )
    work = 0.0
    for before, after in pairwise(corners):
        for _ in range(20):
            step = 1.0e-3 * (after - before) / 20.0
            new, state, _, status = of.law.update(step, 0.0, stress, state, of.constants)
            assert status == 0
            work += float(0.5 * (stress + new) @ step)
            stress = new
    assert stress == pytest.approx(CELL)
    assert work == pytest.approx(0.0, abs=1.0e-12)
