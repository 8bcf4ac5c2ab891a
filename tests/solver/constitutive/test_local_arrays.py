"""Arrays in the frame of a kernel, and principal axes of a stress with shear in one plane."""

from __future__ import annotations

import numpy as np
import pytest
from numba.core.errors import TypingError

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.local_arrays import local_matrix, local_vector
from geoswarm.solver.constitutive.tensors import principal_axes
from geoswarm.solver.kernels.jit import kernel


@kernel
def _filled(first: float) -> float:
    vector, matrix = local_vector(3), local_matrix(3, 2)
    for i in range(matrix.shape[0]):
        vector[i] = first + i
        for j in range(matrix.shape[1]):
            matrix[i, j] = 10.0 * i + j
    total: float = vector[0] + vector[1] + vector[2] + 100.0 * matrix[2, 1]
    return total


@kernel
def nested(count: int) -> float:
    """Sum of arrays that a kernel below fills while one of its own waits."""
    kept, total = local_vector(4), 0.0
    for i in range(4):
        kept[i] = 1.0
    for i in range(count):
        total += _filled(float(i))
    whole: float = total + kept[0] + kept[1] + kept[2] + kept[3]
    return whole


@kernel
def of_any_length(count: int) -> float:
    """An array whose length is not written out."""
    return local_vector(count)[0]  # type: ignore[no-any-return]  # Numba's arrays


def test_arrays_of_nested_kernels_do_not_meet() -> None:
    assert nested(3) == sum(3.0 * i + 3.0 + 2100.0 for i in range(3)) + 4.0


def test_a_length_has_to_be_written_out() -> None:
    with pytest.raises(TypingError, match="numbers that are written out"):
        of_any_length(3)


@pytest.mark.parametrize("shear", [5.0, -5.0, 1.0e-12, 1.0e-200, 0.0])
@pytest.mark.parametrize("normal", [(60.0, 50.0, 100.0), (50.0, 60.0, 55.0), (50.0, 50.0, 50.0)])
def test_shear_in_one_plane_is_one_rotation(normal: tuple[float, float, float], shear: float) -> None:
    tensor: FloatArray = np.array([*normal, shear, 0.0, 0.0])
    values, axes = principal_axes(tensor)
    matrix = np.diag(normal)
    matrix[0, 1] = matrix[1, 0] = shear
    assert values == pytest.approx(np.linalg.eigvalsh(matrix)[::-1], abs=1.0e-12)
    assert axes @ np.diag(values) @ axes.T == pytest.approx(matrix, abs=1.0e-12)
    assert axes.T @ axes == pytest.approx(np.eye(3), abs=1.0e-15)
