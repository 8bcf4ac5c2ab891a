"""Stiffness and strength of sand by its relative density D_r, per cent, at the reference stress 100 kPa."""

from __future__ import annotations

from collections.abc import Callable

from geoswarm.solver.correlations.correlation import Correlation

__all__ = ["SAND"]

_SOURCE = "Brinkgreve, Engin & Engin (2010), 7th NUMGE Trondheim, 137-142"


def _of_sand(quantity: str, unit: str, equation: str, of: Callable[[float], float]) -> Correlation:
    return Correlation(quantity, unit, equation, ("D_r",), of, ((25.0, 100.0),), "sand", _SOURCE)


SAND = (
    _of_sand("E₅₀ʳᵉᶠ", "kPa", "600 D_r", lambda D_r: 600.0 * D_r),
    _of_sand("E_oedʳᵉᶠ", "kPa", "600 D_r", lambda D_r: 600.0 * D_r),
    _of_sand("E_urʳᵉᶠ", "kPa", "1800 D_r", lambda D_r: 1800.0 * D_r),
    _of_sand("m", "", "0.7 - D_r/320", lambda D_r: 0.7 - D_r / 320.0),
    _of_sand("φ", "degree", "28 + D_r/8", lambda D_r: 28.0 + D_r / 8.0),
    _of_sand("ψ", "degree", "-2 + D_r/8", lambda D_r: -2.0 + D_r / 8.0),
    _of_sand("R_f", "", "1 - D_r/800", lambda D_r: 1.0 - D_r / 800.0),
)
