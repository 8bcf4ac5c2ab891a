"""Sections of layered ground, and mud that settles under its own weight."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from geoswarm.solver.column.section import ColumnSpec

__all__ = ["MUD", "WATER", "ground", "slurry"]

WATER = 9.81
"""kN/m3."""
MUD = {
    **{"mud.lambda_star": 0.12, "mud.kappa_star": 0.01, "mud.c": 1.0e-6, "mud.phi": 25.0, "mud.k": 2.0e-3},
    "mud.C_k": 1.5,
}
"""Soft soil that loses permeability with its voids."""


def ground(
    order: Sequence[tuple[str, float]],
    soils: dict[str, dict[str, Any]],
    loads: Sequence[tuple[float, ...]],
    **changes: Any,
) -> ColumnSpec:
    """Layers (soil, thickness); soils as heavy as water unless they say more; loads (stress, duration[, growing])."""
    section = {
        "soils": {name: {"unit_weight": WATER, **soil} for name, soil in soils.items()},
        "layers": [{"soil": soil, "thickness": thickness} for soil, thickness in order],
        "stages": [dict(zip(("stress", "duration", "loading_time"), stage, strict=False)) for stage in loads],
        "initial_surcharge": 100.0,
        **changes,
    }
    return ColumnSpec.model_validate(section)


def slurry(duration: float, points: Any) -> ColumnSpec:
    """Sediment of 5 m, fully suspended at the beginning but for 1 kPa."""
    mud = {"material": "soft_soil", "unit_weight": 13.0, "initial_void_ratio": 4.0, "consolidated": 0.0}
    return ground(
        [("mud", 5.0)],
        {"mud": mud},
        [(0.0, duration)],
        initial_surcharge=1.0,
        tolerance=1.0e-6,
        cells=60,
        points=points,
    )
