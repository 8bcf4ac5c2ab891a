"""All correlations: those of strength, stress at rest and relative density, and what all say about one soil."""

from __future__ import annotations

import math
from collections.abc import Callable

from geoswarm.solver.correlations.compressibility import COMPRESSIBILITY
from geoswarm.solver.correlations.correlation import Correlated, Correlation
from geoswarm.solver.correlations.properties import IndexProperties

__all__ = ["CORRELATIONS", "SAND", "STRENGTH", "correlated"]

STRENGTH = (
    Correlation(
        "φ",
        "degree",
        "sin φ = 0.8 - 0.094 ln I_P",
        ("I_P",),
        lambda I_P: math.degrees(math.asin(min(0.8 - 0.094 * math.log(I_P), 1.0))),
        ((5.0, 100.0),),
        "normally consolidated clays, critical state",
        "data of Kenney (1959), line of Mitchell (1976); Kulhawy & Mayne (1990), EPRI EL-6800",
    ),
    Correlation(
        "K₀",
        "",
        "0.44 + 0.0042 I_P",
        ("I_P",),
        lambda I_P: 0.44 + 0.0042 * I_P,
        ((5.0, 80.0),),
        "normally consolidated clays",
        "Massarsch (1979), 7th ECSMFE Brighton 2, 245-249",
    ),
    Correlation(
        "s_u/σ′v",
        "",
        "0.11 + 0.0037 I_P",
        ("I_P",),
        lambda I_P: 0.11 + 0.0037 * I_P,
        ((10.0, 120.0),),
        "normally consolidated clays, field vane",
        "Skempton (1957), Proc. ICE 7, 305-307",
    ),
)


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


CORRELATIONS: tuple[Correlation, ...] = (*COMPRESSIBILITY, *STRENGTH, *SAND)


def correlated(soil: IndexProperties) -> tuple[Correlated, ...]:
    """What all correlations that its properties allow say about a soil."""
    return tuple(told for one in CORRELATIONS if (told := one.told(soil)) is not None)
