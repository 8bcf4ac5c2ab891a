"""Linear isotropic elasticity."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.jit import kernel

__all__ = ["isotropic_stiffness", "linear_elastic"]


@kernel
def isotropic_stiffness(bulk: float, shear: float) -> FloatArray:
    """Stiffness, shape (6, 6), kPa, from bulk and shear modulus; strains with engineering shear."""
    D = np.zeros((6, 6))
    for i in range(3):
        for j in range(3):
            D[i, j] = bulk - 2.0 / 3.0 * shear
        D[i, i] += 2.0 * shear
        D[i + 3, i + 3] = shear
    return D


@kernel
def linear_elastic(
    stress: FloatArray, strain_increment: FloatArray, young: float, poisson: float
) -> tuple[FloatArray, FloatArray]:
    """Stress (6,) after a strain increment (6,), and the tangent (6, 6); same sign convention for both.

    ``young`` in kPa above 0, ``poisson`` above -1 and below 0.5.
    """
    D = isotropic_stiffness(young / (3.0 * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson)))
    new = stress.copy()
    for i in range(6):
        for j in range(6):
            new[i] += D[i, j] * strain_increment[j]
    return new, D
