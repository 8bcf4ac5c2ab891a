"""One step of the hardening soil model with small-strain stiffness, and its tangent.

The step is that of :mod:`geoswarm.solver.constitutive.hardening_soil.step` with the elastic modulus k E_ur, k the mean
of the step by :mod:`geoswarm.solver.constitutive.hardening_soil.small_strain`, and faster hardening of the shear
surface (Benz 2007, from secondary accounts)::

    dgamma = h dlambda,  h = G_m^(1 + E_ur/(2 E_i)),  G_m = least Gt/Gur of the history

dlambda is plastic shear strain, gamma what the surface knows of it. Where stiffness has once fallen to Gur, h = 1 and
nothing but k differs from hardening soil. The cap hardens by its plastic volume strain as in hardening soil: with h, a
specimen that is compressed all-round, whose strain has no deviator, would be as many times too stiff for ever.

With E_i and E_ur of the surface times h and gamma over h, surface and strength are the same and the multiplier counts
h times; so the step of hardening soil needs to know nothing of h.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.hardening_soil.principal_stresses import SHEAR
from geoswarm.solver.constitutive.hardening_soil.small_strain import (
    SOFTEST,
    SmallStrain,
    mean_stiffness,
    stiffness_slope,
)
from geoswarm.solver.constitutive.hardening_soil.step import hardening_soil_step
from geoswarm.solver.constitutive.hardening_soil.surfaces import HardeningSoil
from geoswarm.solver.kernels.jit import kernel

__all__ = ["small_strain_step"]

_AWAY: Final = 1.0e-5
"""Part by which the stiffness is moved to see how stress changes where a surface is active."""

HISTORY: Final = 2
"""Where the history begins in the state, after gamma and p_p."""


@kernel
def _stiffer(k: float, h: float, soil: HardeningSoil) -> HardeningSoil:
    """Constants of a step."""
    return HardeningSoil(
        h * soil.initial,
        h * soil.unloading,
        k * soil.unloading,
        soil.power,
        soil.poisson,
        soil.attraction,
        soil.reference,
        soil.strength,
        soil.sin_phi,
        soil.sin_cs,
        soil.sin_psi,
        soil.least_dilatancy,
        soil.failure_ratio,
        soil.delta,
        soil.alpha,
        soil.hardening,
        soil.tension,
    )


@kernel
def _step(
    k: float,
    stress: FloatArray,
    strain: FloatArray,
    state: FloatArray,
    soil: HardeningSoil,
    small: SmallStrain,
    new: FloatArray,
    tangent: FloatArray,
) -> tuple[float, float, int]:
    """gamma, p_p and status of a step with a stiffness; fills stress and its derivative at that stiffness."""
    h: float = max(min(k, state[HISTORY + SOFTEST]), 1.0) ** small.power
    gamma, pressure, status = hardening_soil_step(
        stress, strain, state[0] / h, state[1], _stiffer(k, h, soil), new, tangent
    )
    return gamma * h if status > 0 and status & SHEAR else state[0], pressure, status


@kernel
def small_strain_step(
    stress: FloatArray,
    strain: FloatArray,
    state: FloatArray,
    soil: HardeningSoil,
    small: SmallStrain,
    new: FloatArray,
    new_state: FloatArray,
    tangent: FloatArray,
) -> int:
    """One step.

    Parameters
    ----------
    stress, strain
        (n,), n = 4 or 6: kPa, and strain increment with engineering shear; they stay as they are.
    state, new_state
        (11,): gamma, p_p (kPa), and the nine numbers of the history; ``new_state`` is filled.
    soil, small
        Constants.
    new, tangent
        Filled: stress (n,), and d stress/d strain of this algorithm (n, n).

    Returns
    -------
    0: elastic, above: what is active, -1: no stress was found.
    """
    n = stress.shape[0]
    whole, slope = np.zeros(6), np.empty(6)
    for i in range(n):
        whole[i] = strain[i]
    k = mean_stiffness(whole, state[HISTORY:], small, new_state[HISTORY:])[0]
    if not k >= 1.0:  # of strains that are no numbers; rounding of a mean at the cut-off
        k = 1.0
    new_state[0], new_state[1], status = _step(k, stress, strain, state, soil, small, new, tangent)
    if status < 0 or k == 1.0:
        return status
    stiffness_slope(whole, state[HISTORY:], small, slope)
    by, found = np.zeros(n), False
    if status > 0:
        high, low, unused = np.empty(n), np.empty(n), np.empty((n, n))
        found = _step((1.0 + _AWAY) * k, stress, strain, state, soil, small, high, unused)[2] >= 0
        found = found and _step((1.0 - _AWAY) * k, stress, strain, state, soil, small, low, unused)[2] >= 0
        for i in range(n):
            by[i] = (high[i] - low[i]) / (2.0 * _AWAY * k)
    if not found:  # elastic stress is a function of k times the strain
        for i in range(n):
            by[i] = 0.0
            for j in range(n):
                by[i] += tangent[i, j] * strain[j] / k
    for i in range(n):
        for j in range(n):
            tangent[i, j] += by[i] * slope[j]
    return status
