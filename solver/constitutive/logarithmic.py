"""Functions of elasticity whose bulk modulus grows with pressure, eps_v = kappa ln p."""

from __future__ import annotations

import math

from geoswarm.solver.kernels.jit import kernel_in_place

__all__ = ["log_ratio"]

_SERIES_LIMIT = 1.0e-3


@kernel_in_place
def log_ratio(d: float) -> tuple[float, float]:
    """ln(1 + d)/d and its derivative by d, without loss of digits near 0.

    With d = (p - p_old)/p_old, p_old over it is the logarithmic mean of both pressures, (p - p_old)/ln(p/p_old).
    """
    if abs(d) < _SERIES_LIMIT:
        ratio = 1.0 + d * (-1 / 2 + d * (1 / 3 + d * (-1 / 4 + d * (1 / 5 - d / 6))))
        slope = -1 / 2 + d * (2 / 3 + d * (-3 / 4 + d * (4 / 5 + d * (-5 / 6 + d * 6 / 7))))
    else:
        ratio = math.log1p(d) / d
        slope = (1.0 / (1.0 + d) - ratio) / d
    return ratio, slope
