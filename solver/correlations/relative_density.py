"""Sand: stiffness and strength by its relative density D_r, per cent, at 100 kPa; limits of its void ratio."""

from __future__ import annotations

from collections.abc import Callable

from geoswarm.solver.correlations.correlation import Correlation

__all__ = ["SAND"]

_LIMITS = "Herle & Gudehus (1999), Mech. Cohesive-Frict. Materials 4, 461-486"
_SOURCE = "Brinkgreve, Engin & Engin (2010), 7th NUMGE Trondheim, 137-142"


def _of_sand(quantity: str, unit: str, equation: str, of: Callable[[float], float]) -> Correlation:
    return Correlation(quantity, unit, equation, ("D_r",), of, ((25.0, 100.0),), "sand", _SOURCE)


def _of_voids(quantity: str, equation: str, needs: str, of: Callable[[float], float]) -> Correlation:
    soils = "sand and gravel without cohesion, at zero pressure"
    return Correlation(quantity, "", equation, (needs,), of, ((0.25, 1.5),), soils, _LIMITS)


SAND = (
    _of_sand("E₅₀ʳᵉᶠ", "kPa", "600 D_r", lambda D_r: 600.0 * D_r),
    _of_sand("E_oedʳᵉᶠ", "kPa", "600 D_r", lambda D_r: 600.0 * D_r),
    _of_sand("E_urʳᵉᶠ", "kPa", "1800 D_r", lambda D_r: 1800.0 * D_r),
    _of_sand("m", "", "0.7 - D_r/320", lambda D_r: 0.7 - D_r / 320.0),
    _of_sand("φ", "degree", "28 + D_r/8", lambda D_r: 28.0 + D_r / 8.0),
    _of_sand("ψ", "degree", "-2 + D_r/8", lambda D_r: -2.0 + D_r / 8.0),
    _of_sand("R_f", "", "1 - D_r/800", lambda D_r: 1.0 - D_r / 800.0),
    _of_voids("e_d0", "e_min", "e_min", lambda e_min: e_min),
    _of_voids("e_c0", "e_max", "e_max", lambda e_max: e_max),
    _of_voids("e_i0", "1.15 e_max", "e_max", lambda e_max: 1.15 * e_max),
)
