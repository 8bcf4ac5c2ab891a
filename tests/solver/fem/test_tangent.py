"""The tangent of a whole body is the derivative of its forces: Taylor tests for every material and setting."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.soft_soil_creep.physics import soft_soil_creep
from geoswarm.solver.fem.body import Body, State
from geoswarm.solver.fem.materials import INTERFACE_CONSTANTS, InterfaceMaterial, Material
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.newton import assemble
from geoswarm.solver.fem.setup import edge_owners, elements_of
from geoswarm.verification.specimens.bodies import block, graded, moved, stacked
from geoswarm.verification.specimens.soils import creeping, elastic, mohr_coulomb, soil_arrays

CREEP = creeping(soft_soil_creep(0.1, 0.02, 0.005, 5.0, 25.0, 3.0))
LOAD = np.array([-30.0, 4.0, 7.0, 3.0, 2.0, 5.0, 0.3])


def _remainders(
    mesh: Mesh, material: Material, axisymmetric: bool, updated: bool, log_time: float, step: float = 1.0e-5
) -> list[float]:
    """Relative difference of tangent and central difference for a step, a tenth and a hundredth of it."""
    random = np.random.default_rng(3)
    points = np.einsum("n,enj->ej", np.full(6, 1.0 / 6.0), mesh.nodes[mesh.triangles])[:, np.newaxis, :]
    stress = np.zeros((mesh.triangles.shape[0], 3, 4))
    stress[..., 0], stress[..., 2] = -40.0, -35.0
    stress[..., 1] = -50.0 - 10.0 * points[..., 1]
    stress[..., 3] = 3.0 * points[..., 0]
    traction = np.tile([-20.0, 4.0], (mesh.interfaces.shape[0], 3, 1))
    old = State(
        stress,
        np.full((*stress.shape[:2], 1), math.log(60.0)),
        np.zeros(stress.shape[:2], dtype=np.bool_),
        traction,
        np.zeros(traction.shape[:2]),
    )
    new = State(*(array.copy() for array in old))
    edges = mesh.boundaries["top"]
    owner, places = edge_owners(mesh, edges)
    joint = InterfaceMaterial(1.0e4, 5.0e3, 5.0, 20.0, 5.0).constants().reshape(-1, INTERFACE_CONSTANTS)
    body = Body(
        axisymmetric,
        updated,
        mesh.triangles,
        np.zeros(mesh.triangles.shape[0], dtype=np.int64),
        *soil_arrays(material),
        mesh.interfaces,
        np.zeros(mesh.interfaces.shape[0], dtype=np.int64),
        joint,
        edges,
        owner,
        places,
    )
    dofs = mesh.nodes.size
    elements = elements_of(mesh)
    tangents = np.full((elements.shape[0], 12, 12), math.nan)
    loads = np.tile(LOAD, (edges.shape[0], 1))
    free = np.zeros(dofs, dtype=np.bool_)

    def forces(u: FloatArray, tangent: bool = False) -> FloatArray:
        inner, outer = np.zeros(dofs), np.zeros(dofs)
        status = assemble(
            body, mesh.nodes, u, log_time, old, new, np.zeros(dofs), loads, free, tangent, 0.0, tangents, inner, outer
        )
        assert status == -1
        return inner - outer

    u, way = 3.0e-3 * random.standard_normal(dofs), random.standard_normal(dofs)
    forces(u, True)
    slope = np.zeros(dofs)
    for nodes, tangent in zip(elements, tangents, strict=True):
        own = (2 * nodes[:, np.newaxis] + [0, 1]).ravel()
        slope[own] += tangent @ way[own]
    differences = [(forces(u + h * way) - forces(u - h * way)) / (2.0 * h) for h in (step, 0.1 * step, 0.01 * step)]
    return [float(np.linalg.norm(one - slope) / np.linalg.norm(slope)) for one in differences]


@pytest.mark.parametrize("axisymmetric", [False, True])
@pytest.mark.parametrize("updated", [False, True])
@pytest.mark.parametrize(
    ("material", "log_time"),
    [
        (elastic(1.0e3, 0.3), -math.inf),
        (mohr_coulomb(1.0e3, 0.3, 5.0, 25.0, 5.0), -math.inf),
        (CREEP, 1.0),
        (CREEP, -math.inf),
    ],
    ids=["elastic", "Mohr-Coulomb", "creep", "creep without time"],
)
def test_the_tangent_is_the_derivative_of_the_forces(
    material: Material, log_time: float, updated: bool, axisymmetric: bool
) -> None:
    mesh = moved(block(graded(0.0, 3.0, 3), graded(0.0, 1.0, 2), distortion=0.2), lambda x: x + np.array([1.0, 0.0]))
    remainders = _remainders(mesh, material, axisymmetric, updated, log_time)
    assert min(remainders) < 1.0e-7
    assert remainders[1] < 1.0e-4


@pytest.mark.parametrize("axisymmetric", [False, True])
@pytest.mark.parametrize("updated", [False, True])
def test_the_tangent_with_interfaces(updated: bool, axisymmetric: bool) -> None:
    lower = moved(block(graded(1.0, 3.0, 2), graded(0.0, 1.0, 1), name="lower"), lambda x: x)
    upper = moved(block(graded(1.0, 3.0, 2), graded(0.0, 1.0, 1), name="upper"), lambda x: x + np.array([0.0, 1.0]))
    mesh = moved(stacked(lower, upper), lambda x: x + np.column_stack([0.0 * x[:, 0], 0.1 * x[:, 0] ** 2]))
    remainders = _remainders(mesh, elastic(1.0e3, 0.3), axisymmetric, updated, -math.inf)
    assert min(remainders) < 1.0e-7


def test_the_remainder_is_of_second_order() -> None:
    mesh = block(graded(1.0, 4.0, 3), graded(0.0, 1.0, 2), distortion=0.2)
    first, second, _ = _remainders(mesh, elastic(1.0e3, 0.3), True, True, -math.inf, 1.0e-3)
    assert math.log10(first / second) == pytest.approx(2.0, abs=0.3)
