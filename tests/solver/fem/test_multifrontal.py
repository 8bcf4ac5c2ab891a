"""Order of elimination and factorisation by fronts, against a dense solution."""

from __future__ import annotations

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.fem.mesh.mesh import Mesh
from solver.fem.multifrontal import factorise, solve_factorised
from solver.fem.ordering import Fronts
from solver.fem.setup import elements_of, fronts_of
from tests.verification.fem.bodies import block, graded, moved, stacked


def _assembled(mesh: Mesh, plan: Fronts) -> tuple[FloatArray, FloatArray]:
    """A non-symmetric matrix as dense array and as fronts."""
    random = np.random.default_rng(5)
    dense, fronts = np.zeros((mesh.nodes.size, mesh.nodes.size)), np.zeros(plan.length)
    for e, nodes in enumerate(elements_of(mesh)):
        part = random.standard_normal((12, 12))
        part = part @ part.T + 0.3 * random.standard_normal((12, 12)) + np.eye(12)
        dofs = (2 * nodes[:, np.newaxis] + [0, 1]).ravel()
        dense[np.ix_(dofs, dofs)] += part
        front = plan.element_front[e]
        size = plan.size[front]
        own = (2 * plan.element_node[e][:, np.newaxis] + [0, 1]).ravel()
        view = fronts[plan.offset[front] : plan.offset[front] + size**2].reshape(size, size)
        view[np.ix_(own, own)] += part
    return dense, fronts


def _meshes() -> list[Mesh]:
    base = block(graded(0.0, 5.0, 7), graded(0.0, 1.0, 4), distortion=0.2)
    top = moved(block(graded(0.0, 5.0, 7), graded(0.0, 1.0, 3), name="top"), lambda x: x + np.array([0.0, 1.0]))
    return [block(np.array([0.0, 1.0]), np.array([0.0, 1.0])), base, stacked(base, top)]


@pytest.mark.parametrize("number", [0, 1, 2])
def test_the_solution_is_that_of_the_dense_matrix(number: int) -> None:
    mesh = _meshes()[number]
    plan = fronts_of(mesh)
    dense, fronts = _assembled(mesh, plan)
    right = np.random.default_rng(6).standard_normal(mesh.nodes.size)
    x = right.copy()
    assert factorise(plan, fronts)
    solve_factorised(plan, fronts, x)
    assert dense @ x == pytest.approx(right, abs=1.0e-11)


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
    assert not factorise(plan, np.zeros(plan.length))


def test_meshes_of_one_topology_share_their_plan() -> None:
    mesh = _meshes()[1]
    assert fronts_of(moved(mesh, lambda x: 2.0 * x)) is fronts_of(mesh)
