"""The horizontal stress at rest of a soil, and what its strength admits."""

from __future__ import annotations

import math

from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Soil

__all__ = ["horizontal_limits", "horizontal_stress"]


def horizontal_limits(vertical: float, soil: Soil) -> tuple[float, float]:
    """Smallest and largest horizontal stress, kPa, that the strength of a law admits, if it declares one."""
    if soil.law.strength is None:
        return -math.inf, math.inf
    cohesion, sin_phi, cos_phi, _, tension = soil.constants[list(soil.law.strength)].tolist()
    both = 2.0 * cohesion * cos_phi
    lower = ((1.0 - sin_phi) * vertical - both) / (1.0 + sin_phi)
    return max(lower, -tension), ((1.0 + sin_phi) * vertical + both) / (1.0 - sin_phi)


def horizontal_stress(vertical: float, ratio: float | None, soil: Soil) -> float:
    """``ratio`` times the vertical stress, kPa; None: K0 of the law.

    Raises
    ------
    InfeasibleError
        The law knows no K0, or the stress violates its strength.
    """
    K0 = soil.law.K0(soil.constants) if ratio is None else ratio
    if K0 is None:
        raise InfeasibleError(f"material {soil.law.kind} has no K0; give the ratio of horizontal to vertical stress")
    lower, upper = horizontal_limits(vertical, soil)
    if not lower <= K0 * vertical <= upper:
        raise InfeasibleError(
            f"initial horizontal stress = {K0 * vertical:g} kPa (K0 = {K0:g}) violates the strength; K0 must be from "
            f"{max(lower, 0.0) / vertical:g} to {upper / vertical:g}"
        )
    return K0 * vertical
