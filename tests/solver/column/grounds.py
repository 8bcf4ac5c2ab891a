"""Sections of layered ground for tests."""

from __future__ import annotations

from typing import Any

from geoswarm.solver.column.section import ColumnSpec
from geoswarm.verification.specimens.grounds import WATER, ground

__all__ = ["CLAY", "STIFF", "WATER", "embankment", "ground"]

STIFF = 2.0e3
"""Young's modulus, kPa; with nu = 0 that of the oedometer."""
CLAY = {"M": 1.0, "lambda": 0.2, "kappa": 0.04, "nu": 0.25, "e0": 1.0}


def embankment(material: str, voids: float | None = 1.6, **changes: Any) -> ColumnSpec:
    """A crust on clay of a void ratio under two lifts, of which one is taken off again, for ten years."""
    return ground(
        [("crust", 1.5), ("clay", 8.5)],
        {
            "crust": {"material": "elastic", "unit_weight": 18.0, "initial_ratio": 0.6},
            "clay": {"material": material, "unit_weight": 15.5, "initial_void_ratio": voids},
        },
        [(20.0, 60.0, 10.0), (40.0, 300.0, 10.0), (30.0, 3290.0)],
        **{
            "water_table": 1.5,
            "initial_surcharge": 5.0,
            "points": {"S1": {"depth": 1.5}, "P1": {"depth": 5.0}},
            **changes,
        },
    )
