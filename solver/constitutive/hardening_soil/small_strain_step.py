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

import math
from typing import Final

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
from geoswarm.solver.constitutive.local_arrays import local_vector
from geoswarm.solver.kernels.jit import kernel

__all__ = ["small_strain_step"]

HISTORY: Final = 2
"""Where the history begins in the state, after gamma and p_p."""


@kernel
def _stiffer(k: float, h: float, growth: float, soil: HardeningSoil) -> HardeningSoil:
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
        growth,
        True,
    )


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
    whole, slope, by = local_vector(6), local_vector(6), local_vector(6)
    for i in range(6):
        whole[i] = strain[i] if i < n else 0.0
        by[i] = 0.0
    of_step = mean_stiffness(whole, state[HISTORY:], small, new_state[HISTORY:])
    k = of_step[0]
    if not k >= 1.0:  # of strains that are no numbers; rounding of a mean at the cut-off
        k = 1.0
    softest = state[HISTORY + SOFTEST]
    least = max(min(k, softest), 1.0)
    h, growth = math.exp(small.power * math.log(least)), small.power if 1.0 < k < softest else 0.0
    gamma, new_state[1], status = hardening_soil_step(
        stress, strain, state[0] / h, state[1], _stiffer(k, h, growth, soil), new, tangent, by
    )
    new_state[0] = gamma * h if status > 0 and status & SHEAR else state[0]
    if status < 0 or k == 1.0:
        return status
    stiffness_slope(whole, state[HISTORY:], small, of_step, slope)
    for i in range(n):
        for j in range(n):
            tangent[i, j] += by[i] * slope[j] / k
    return status
