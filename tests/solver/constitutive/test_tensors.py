"""Principal axes, rotations, signs, and the small dense solver."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.constitutive.tensors import flip_sign, principal_axes, rotation_matrix, solve_dense


def matrix_of(components: np.ndarray) -> np.ndarray:
    xx, yy, zz, xy, yz, zx = components
    return np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])


@pytest.mark.parametrize(
    "components",
    [
        [60.0, 50.0, 100.0, 5.0, 3.0, -2.0],
        [50.0, 50.0, 50.0, 0.0, 0.0, 0.0],
        [50.0, 50.0, 80.0, 0.0, 0.0, 0.0],
        [1.0, 1.0, 1.0, 1.0, 1.0, 1.0],
        [-3.0, 1.0e-9, 2.0, 1.0e-7, 4.0, 0.0],
    ],
)
def test_principal_axes_diagonalise(components: list[float]) -> None:
    tensor = np.array(components)
    values, axes = principal_axes(tensor)
    assert values == pytest.approx(np.linalg.eigvalsh(matrix_of(tensor))[::-1], abs=1.0e-13 * np.abs(tensor).max())
    assert axes @ np.diag(values) @ axes.T == pytest.approx(matrix_of(tensor), abs=1.0e-13 * np.abs(tensor).max())
    assert axes.T @ axes == pytest.approx(np.eye(3), abs=1.0e-14)


def test_rotation_keeps_work_and_turns_components() -> None:
    rng = np.random.default_rng(3)
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    Q = rotation_matrix(np.ascontiguousarray(axes))
    local = rng.normal(size=6)
    assert matrix_of(Q @ local) == pytest.approx(axes @ matrix_of(local) @ axes.T, abs=1.0e-13)
    strain = rng.normal(size=6)
    assert (Q @ local) @ strain == pytest.approx(local @ (Q.T @ strain), rel=1.0e-12)


def test_solve_dense_solves_badly_scaled_systems_and_reports_singular_ones() -> None:
    rng = np.random.default_rng(5)
    matrix = rng.normal(size=(6, 6)) * 10.0 ** rng.integers(-6, 6, size=(6, 1))
    right = rng.normal(size=(6, 2))
    solution = right.copy()
    assert solve_dense(matrix.copy(), solution)
    assert solution == pytest.approx(np.linalg.solve(matrix, right), rel=1.0e-8)
    assert not solve_dense(np.zeros((3, 3)), np.ones((3, 1)))


def test_flipping_the_sign_twice_changes_nothing() -> None:
    stress = np.array([1.0, -2.0, 3.0, 0.5, 0.0, -4.0])
    assert (flip_sign(stress) == -stress).all()
    assert (flip_sign(flip_sign(stress)) == stress).all()
