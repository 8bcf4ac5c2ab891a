"""A body that is strained, turned, and strained on: stress and state of every law are those without the turn, turned.

Intergranular strain, histories of strain and other tensors among the state variables turn with the body, as stress
does.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.tensors import rotation_matrix
from geoswarm.solver.fem.materials import Material
from geoswarm.solver.fem.mesh.mesh import Mesh, boundary_edges, midpoints, six_node_triangles
from geoswarm.solver.fem.phases import Control, Fixity, Phase
from geoswarm.solver.fem.solve import Calculation
from geoswarm.solver.laws.base import Law
from tests.solver.laws.checks import Case, cases, turned_state
from tests.solver.user_laws import behaviours, routines

STRESS = -np.array([60.0, 100.0, 55.0, 8.0])
FIRST = np.array([[2.0e-4, 6.0e-4], [1.0e-4, -8.0e-4]])
"""Displacement over position."""
SECOND = np.array([[-3.0e-4, 1.0e-4], [5.0e-4, 4.0e-4]])
PIECES, TURNS = 4, 6
CASES = {case.name: case for case in cases() if 4 in case.law.components}


def triangle() -> Mesh:
    """One triangle, all of whose nodes are led: a node that is free would strain a little while the body turns."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    triangles, ends = six_node_triangles(np.array([[0, 1, 2]], dtype=np.int32), 3)
    edges = boundary_edges(triangles)
    nodes = np.concatenate([corners, midpoints(corners, ends)])
    return Mesh(nodes, triangles, np.zeros(1, dtype=np.int32), ("soil",), boundaries={"around": edges})


def end(material: Material, angle: float) -> tuple[FloatArray, FloatArray]:
    """Stress (4,), compression positive, and state of a body that was turned by an angle between two strains."""
    mesh = triangle()
    calculation = Calculation(mesh, control=Control(tolerance=1.0e-11, load_tolerance=0.0))
    around = np.unique(mesh.boundaries["around"])

    def led(matrix: FloatArray, name: str, step: float) -> None:
        change = calculation.positions @ (matrix - np.eye(2)).T
        held = Fixity("around", x=change[around, 0], y=change[around, 1])
        calculation.run(Phase(name, fixities=(held,), updated_mesh=True, load_step=step, largest_load_step=step))

    calculation.run(
        Phase(
            "placed",
            "K0",
            materials={"soil": material},
            initial_stress=lambda x: np.tile(STRESS, (x.shape[0], 1)),
        )
    )
    led(np.eye(2) + FIRST, "first", 1.0 / PIECES)
    c, s = math.cos(angle / TURNS), math.sin(angle / TURNS)
    for number in range(TURNS):
        led(np.array([[c, -s], [s, c]]), f"turn {number}", 1.0)
    c, s = math.cos(angle), math.sin(angle)
    Q = np.array([[c, -s], [s, c]])
    led(np.eye(2) + Q @ SECOND @ Q.T, "second", 1.0 / PIECES)
    result = calculation._state
    assert np.ptp(result.stress.reshape(-1, 4), axis=0).max() < 1.0e-6
    return -result.stress[0, 0], result.internal[0, 0]


def expected(law: Law, straight: tuple[FloatArray, FloatArray], angle: float) -> tuple[FloatArray, FloatArray]:
    """What a body has that was not turned, on axes that are."""
    c, s = math.cos(angle), math.sin(angle)
    Q = rotation_matrix(np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
    stress = (Q @ np.array([*straight[0], 0.0, 0.0]))[:4]
    return stress, turned_state(law, straight[1], np.linalg.inv(Q).T)


@pytest.mark.parametrize("name", CASES)
def test_what_was_turned_goes_on_as_if_it_was_not(name: str) -> None:
    case: Case = CASES[name]
    material, angle = Material(case.soil), math.radians(70.0)
    found, wanted = end(material, angle), expected(case.law, end(material, 0.0), angle)
    assert found[0] == pytest.approx(wanted[0], abs=1.0e-7 * 100.0)
    assert found[1] == pytest.approx(wanted[1], rel=1.0e-6, abs=1.0e-10)


def test_the_tensor_of_a_user_routine_turns_where_it_is_declared() -> None:
    """Strain so far, in STATEV, with which stress grows; the total strain beside it turns, too."""
    values, angle = {"E": 1.0e4, "nu": 0.3, "B": 2.0e7}, math.radians(70.0)
    material = Material(routines.soil(routines.REMEMBERING, values))
    (stress, state), straight = end(material, angle), end(material, 0.0)
    wanted = expected(material.soil.law, straight, angle)
    assert stress == pytest.approx(wanted[0], abs=1.0e-7 * 100.0)
    # tension positive, as the total strain is not
    assert straight[1][:4] == pytest.approx(-straight[1][6:10], rel=1.0e-12)
    assert state[6:12] == pytest.approx(wanted[1][6:12], abs=1.0e-12)
    assert state[:4] == pytest.approx(-wanted[1][6:10], abs=1.0e-12)
    plain = [{key: value for key, value in one.items() if key != "tensor"} for one in routines.REMEMBERING["state"]]
    still = end(Material(routines.soil(routines.REMEMBERING, values, state=plain)), angle)
    assert np.abs(still[0] - wanted[0]).max() > 0.1


def test_the_elastic_strain_of_a_behaviour_turns() -> None:
    """Its stress is that of the elastic strain among its state variables."""
    angle, values = math.radians(70.0), {"YoungModulus": 1.0e4, "PoissonRatio": 0.3, "RelaxationTime": 5.0}
    material = Material(behaviours.soil(behaviours.MAXWELL, values))
    (stress, state), straight = end(material, angle), end(material, 0.0)
    wanted = expected(material.soil.law, straight, angle)
    assert stress == pytest.approx(wanted[0], abs=1.0e-6)
    assert state[7:] == pytest.approx(wanted[1][7:], abs=1.0e-12)
