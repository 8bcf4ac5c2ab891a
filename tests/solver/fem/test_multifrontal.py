"""Order of elimination and factorisation by fronts, against a dense solution."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.multifrontal import equations_of, factorise, solve_factorised
from geoswarm.solver.fem.setup import elements_of, fronts_of
from geoswarm.verification.specimens.bodies import block, graded, moved, stacked
from tests.variants import variants


def _assembled(mesh: Mesh) -> tuple[FloatArray, FloatArray]:
    """A non-symmetric matrix as dense array and element by element (e, 12, 12)."""
    random = np.random.default_rng(5)
    elements = elements_of(mesh)
    dense, tangents = np.zeros((mesh.nodes.size, mesh.nodes.size)), np.zeros((elements.shape[0], 12, 12))
    for e, nodes in enumerate(elements):
        part = random.standard_normal((12, 12))
        tangents[e] = part @ part.T + 0.3 * random.standard_normal((12, 12)) + np.eye(12)
        dofs = (2 * nodes[:, np.newaxis] + [0, 1]).ravel()
        dense[np.ix_(dofs, dofs)] += tangents[e]
    return dense, tangents


def _meshes() -> list[Mesh]:
    base = block(graded(0.0, 5.0, 7), graded(0.0, 1.0, 4), distortion=0.2)
    top = moved(block(graded(0.0, 5.0, 7), graded(0.0, 1.0, 3), name="top"), lambda x: x + np.array([0.0, 1.0]))
    fine = block(graded(0.0, 9.0, 40), graded(0.0, 1.0, 32), distortion=0.2)
    return [block(np.array([0.0, 1.0]), np.array([0.0, 1.0])), base, stacked(base, top), fine]


@pytest.mark.parametrize("number", variants(range(4), {0, 1, 2}))
def test_the_solution_is_that_of_the_dense_matrix(number: int) -> None:
    mesh = _meshes()[number]
    plan = fronts_of(mesh)
    equations = equations_of(plan)
    dense, equations.tangents[:] = _assembled(mesh)
    right = np.random.default_rng(6).standard_normal(mesh.nodes.size)
    for _ in range(2):  # buffers are used again
        x = right.copy()
        assert factorise(plan, equations, np.zeros(right.size, dtype=np.bool_))
        solve_factorised(plan, equations, x)
        assert dense @ x == pytest.approx(right, abs=1.0e-10)


def test_prescribed_dofs_have_the_rows_of_the_identity() -> None:
    mesh = _meshes()[1]
    plan = fronts_of(mesh)
    equations = equations_of(plan)
    dense, equations.tangents[:] = _assembled(mesh)
    fixed = np.zeros(mesh.nodes.size, dtype=np.bool_)
    fixed[::7] = True
    dense[fixed] = np.eye(fixed.size)[fixed]
    for e, nodes in enumerate(elements_of(mesh)):
        equations.tangents[e][fixed[(2 * nodes[:, np.newaxis] + [0, 1]).ravel()]] = 0.0
    right = np.random.default_rng(6).standard_normal(fixed.size)
    x = right.copy()
    assert factorise(plan, equations, fixed)
    solve_factorised(plan, equations, x)
    assert dense @ x == pytest.approx(right, abs=1.0e-11)
    assert np.array_equal(x[fixed], right[fixed])


def test_every_dof_is_eliminated_once_and_after_its_children() -> None:
    mesh = _meshes()[2]
    plan = fronts_of(mesh)
    eliminated = [plan.rows[start : start + count] for start, count in zip(plan.start[:-1], plan.pivots, strict=True)]
    assert np.array_equal(np.sort(np.concatenate(eliminated)), np.arange(mesh.nodes.size))
    inner = plan.parent >= 0
    assert (plan.parent[inner] > np.flatnonzero(inner)).all()


def test_a_zero_pivot_is_reported() -> None:
    mesh = _meshes()[1]
    plan = fronts_of(mesh)
    assert not factorise(plan, equations_of(plan), np.zeros(mesh.nodes.size, dtype=np.bool_))


def test_meshes_of_one_topology_share_their_plan() -> None:
    mesh = _meshes()[1]
    assert fronts_of(moved(mesh, lambda x: 2.0 * x)) is fronts_of(mesh)


def test_cuts_do_not_run_zigzag_through_a_column_of_triangles() -> None:
    plan = fronts_of(block(graded(0.0, 9.0, 39), graded(0.0, 1.0, 32)))  # the median is inside the middle column
    assert plan.parent[-1] == -1
    assert plan.pivots[-1] == 2 * (2 * 32 + 1)
