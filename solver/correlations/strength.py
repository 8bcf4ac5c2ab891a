"""Correlations of strength and of the stress ratio at rest."""

from __future__ import annotations

import math

from geoswarm.solver.correlations.correlation import Correlation

__all__ = ["STRENGTH"]

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
