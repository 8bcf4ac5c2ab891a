"""Symmetric second-order tensors as vectors of six components, and the small dense algebra that material laws need.

Order of components: xx, yy, zz, xy, yz, zx. Stress holds tensor components; strain holds engineering shear strains
(twice the tensor components), so that stress times strain increment is work.
"""

from __future__ import annotations

import math

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.local_arrays import local_matrix
from geoswarm.solver.kernels.jit import kernel

__all__ = [
    "fill_principal_axes",
    "fill_rotation_matrix",
    "flip_sign",
    "principal_axes",
    "rotation_matrix",
    "solve_dense",
    "turned",
]

_FIRST = (0, 1, 2, 0, 1, 2)
_SECOND = (0, 1, 2, 1, 2, 0)
_SWEEPS = 12


def flip_sign(tensor: FloatArray) -> FloatArray:
    """Convert stress or strain between compression positive (laboratory) and tension positive (finite elements).

    Any shape; a new array. Tangents are the same in both conventions.
    """
    return -tensor


@kernel
def principal_axes(tensor: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Principal values, shape (3,), largest first, and axes, the columns of a (3, 3) array, of tensor components (6,).

    Cyclic Jacobi rotations: accurate to rounding for equal values too.
    """
    values, axes = np.empty(3), np.empty((3, 3))
    fill_principal_axes(tensor, values, axes)
    return values, axes


@kernel
def fill_principal_axes(tensor: FloatArray, values: FloatArray, axes: FloatArray) -> None:
    """Fill what :func:`principal_axes` returns."""
    if tensor[3] == 0.0 and tensor[4] == 0.0 and tensor[5] == 0.0:
        _sort_unturned(tensor[0], tensor[1], tensor[2], values, axes)
        return
    for i in range(3):
        values[i] = tensor[i]
        for j in range(3):
            axes[i, j] = 1.0 if i == j else 0.0
    if tensor[4] != 0.0 or tensor[5] != 0.0:
        _turn_until_diagonal(tensor, values, axes)
    else:  # one rotation
        ratio = 0.5 * (tensor[1] - tensor[0]) / tensor[3]
        t = 1.0 / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
        if ratio < 0.0:
            t = -t
        cosine = 1.0 / math.sqrt(1.0 + t * t)
        values[0], values[1] = tensor[0] - t * tensor[3], tensor[1] + t * tensor[3]
        axes[0, 0], axes[0, 1], axes[1, 0], axes[1, 1] = cosine, t * cosine, -t * cosine, cosine
    for i in range(2):
        for j in range(2 - i):
            if values[j] < values[j + 1]:
                values[j], values[j + 1] = values[j + 1], values[j]
                for m in range(3):
                    axes[m, j], axes[m, j + 1] = axes[m, j + 1], axes[m, j]


@kernel
def _sort_unturned(a: float, b: float, c: float, values: FloatArray, axes: FloatArray) -> None:
    """Fill sorted values and their axes, which are the coordinates; of equal ones the first stays first."""
    i, j, k = 0, 1, 2
    if a < b:
        a, b, i, j = b, a, j, i
    if b < c:
        b, c, j, k = c, b, k, j
        if a < b:
            a, b, i, j = b, a, j, i
    values[0], values[1], values[2] = a, b, c
    for m in range(3):
        axes[m, 0] = 1.0 if m == i else 0.0
        axes[m, 1] = 1.0 if m == j else 0.0
        axes[m, 2] = 1.0 if m == k else 0.0


@kernel
def _turn_until_diagonal(tensor: FloatArray, values: FloatArray, axes: FloatArray) -> None:
    """Fill values and axes, which are those of no rotation, in the order in which rotations leave them."""
    a = local_matrix(3, 3)
    for k in range(6):
        a[_FIRST[k], _SECOND[k]] = tensor[k]
        a[_SECOND[k], _FIRST[k]] = tensor[k]
    size = 0.0
    for k in range(6):
        size = max(size, abs(tensor[k]))
    for _ in range(_SWEEPS):
        off = max(abs(a[0, 1]), abs(a[1, 2]), abs(a[2, 0]))
        if off <= 1.0e-16 * size:
            break
        for k in range(3, 6):
            i, j = _FIRST[k], _SECOND[k]
            if a[i, j] == 0.0:
                continue
            ratio = 0.5 * (a[j, j] - a[i, i]) / a[i, j]
            t = 1.0 / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
            if ratio < 0.0:
                t = -t
            cosine = 1.0 / math.sqrt(1.0 + t * t)
            sine = t * cosine
            for m in range(3):
                left, right = a[m, i], a[m, j]
                a[m, i], a[m, j] = cosine * left - sine * right, sine * left + cosine * right
            for m in range(3):
                left, right = a[i, m], a[j, m]
                a[i, m], a[j, m] = cosine * left - sine * right, sine * left + cosine * right
            for m in range(3):
                left, right = axes[m, i], axes[m, j]
                axes[m, i], axes[m, j] = cosine * left - sine * right, sine * left + cosine * right
    for i in range(3):
        values[i] = a[i, i]


@kernel
def rotation_matrix(axes: FloatArray) -> FloatArray:
    """Matrix Q, shape (6, 6), that turns stress components on ``axes`` (columns) into global ones.

    Strains go the other way with the transpose: local = Q^T global. A local tangent D becomes Q D Q^T.
    """
    Q = np.empty((6, 6))
    fill_rotation_matrix(axes, Q)
    return Q


@kernel
def fill_rotation_matrix(axes: FloatArray, Q: FloatArray) -> None:
    """Fill what :func:`rotation_matrix` returns."""
    for row in range(6):
        i, j = _FIRST[row], _SECOND[row]
        for column in range(6):
            k, m = _FIRST[column], _SECOND[column]
            if column < 3:
                Q[row, column] = axes[i, k] * axes[j, k]
            else:
                Q[row, column] = axes[i, k] * axes[j, m] + axes[i, m] * axes[j, k]


@kernel
def turned(Q: FloatArray, local: FloatArray) -> FloatArray:
    """Q local Q^T, shapes (6, 6); term by term, so that the bits are those of every processor."""
    half, result = np.zeros((6, 6)), np.zeros((6, 6))
    for i in range(6):
        for k in range(6):
            for j in range(6):
                half[i, j] += Q[i, k] * local[k, j]
    for i in range(6):
        for j in range(6):
            for k in range(6):
                result[i, j] += half[i, k] * Q[j, k]
    return result


@kernel
def solve_dense(matrix: FloatArray, right: FloatArray) -> bool:
    """Solve ``matrix x = right`` in place for several right-hand sides, shapes (n, n) and (n, m).

    Gaussian elimination with row scaling and partial pivoting; ``matrix`` is destroyed, ``right`` becomes x. False when
    the matrix is singular to rounding.
    """
    n = matrix.shape[0]
    columns = right.shape[1]
    for i in range(n):
        scale = 0.0
        for j in range(n):
            scale = max(scale, abs(matrix[i, j]))
        if not 0.0 < scale < math.inf:
            return False
        for j in range(n):
            matrix[i, j] /= scale
        for j in range(columns):
            right[i, j] /= scale
    for i in range(n):
        pivot = i
        for k in range(i + 1, n):
            if abs(matrix[k, i]) > abs(matrix[pivot, i]):
                pivot = k
        if not abs(matrix[pivot, i]) > 1.0e-300:
            return False
        if pivot != i:
            for j in range(n):
                matrix[i, j], matrix[pivot, j] = matrix[pivot, j], matrix[i, j]
            for j in range(columns):
                right[i, j], right[pivot, j] = right[pivot, j], right[i, j]
        for k in range(i + 1, n):
            factor = matrix[k, i] / matrix[i, i]
            if factor != 0.0:
                for j in range(i, n):
                    matrix[k, j] -= factor * matrix[i, j]
                for j in range(columns):
                    right[k, j] -= factor * right[i, j]
    for j in range(columns):
        for i in range(n - 1, -1, -1):
            total = right[i, j]
            for k in range(i + 1, n):
                total -= matrix[i, k] * right[k, j]
            right[i, j] = total / matrix[i, i]
    return True
