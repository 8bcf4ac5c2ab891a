"""The Mohr-Coulomb limit with dilatancy and tension cut-off, as planes in principal stress.

Compression positive, principal stresses sorted, largest first. A plane is ``normal . sigma <= offset``; plastic strain
is a non-negative multiple of ``flow``::

    sigma_i (1 - sin phi) - sigma_j (1 + sin phi) <= 2 c cos phi    shear, (i, j) = (1, 3), (1, 2), (2, 3); flow: psi
    -sigma_i <= tension                                             tension cut-off, i = 3, 2, 1; associated flow

Where several planes meet (edges, apex, cut-off corners) up to three are active at once. :func:`active_planes` lists the
sets in the order in which an update should try them; the first whose multipliers are non-negative and whose stress
violates no plane is the solution.
"""

from __future__ import annotations

from itertools import combinations
from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.kernels.jit import inlined

__all__ = ["ACTIVE_SETS", "PLANES", "principal_planes"]

PLANES: Final = 6

_SHEAR_MAJOR = (0, 0, 1)
_SHEAR_MINOR = (2, 1, 2)
_TENSION_AXIS = (2, 1, 0)


def _active_sets() -> IntArray:
    """Sets of planes to try, shape (n, 3), filled up with -1: the usual ones first."""
    usual: list[tuple[int, ...]] = [
        (),
        (0,),
        (0, 1),
        (0, 2),
        (3,),
        (0, 3),
        (3, 4),
        (0, 3, 4),
        (0, 2, 3),
        (3, 4, 5),
        (0, 1, 2),
    ]
    every = [planes for count in range(4) for planes in combinations(range(PLANES), count)]
    ordered = usual + [planes for planes in every if planes not in usual]
    return np.array([(*planes, -1, -1, -1)[:3] for planes in ordered], dtype=np.int64)


ACTIVE_SETS: Final = _active_sets()


@inlined
def principal_planes(
    cohesion: float, sin_phi: float, cos_phi: float, sin_psi: float, tension: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Normals (6, 3), flows (6, 3) and offsets (6,), kPa, of all planes; ``tension`` inf switches the cut-off off."""
    normals, flows, offsets = np.zeros((PLANES, 3)), np.zeros((PLANES, 3)), np.empty(PLANES)
    for k in range(3):
        i, j, axis = _SHEAR_MAJOR[k], _SHEAR_MINOR[k], _TENSION_AXIS[k]
        normals[k, i], normals[k, j] = 1.0 - sin_phi, -1.0 - sin_phi
        flows[k, i], flows[k, j] = 1.0 - sin_psi, -1.0 - sin_psi
        offsets[k] = 2.0 * cohesion * cos_phi
        normals[3 + k, axis] = -1.0
        flows[3 + k, axis] = -1.0
        offsets[3 + k] = tension
    return normals, flows, offsets
