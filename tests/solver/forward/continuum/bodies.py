"""Sections whose displacements are known: level ground under loads over its whole surface."""

from __future__ import annotations

import json
from typing import Any

from geoswarm.solver.forward.cross_section import SectionSpec

ELASTIC = {"law": "elastic", "E": 1.0e4, "nu": 0.3, "unit_weight": 20.0}
OEDOMETER = 1.0e4 * (1.0 - 0.3) / ((1.0 + 0.3) * (1.0 - 2.0 * 0.3))
"""Stiffness of one-dimensional compression, kPa."""

CLAY = {
    "law": "soft_soil_creep",
    **{"lambda_star": 0.1, "kappa_star": 0.02, "mu_star": "mu_star", "c": 0.0, "phi": 25.0, "unit_weight": 18.0},
}


def ground(**changes: Any) -> dict[str, Any]:
    """Sand on rock, 8 m wide, loaded over its whole surface after its own weight."""
    return {
        "kind": "section",
        "surface": [[0, 10], [8, 10]],
        "layers": [{"name": "sand", "thickness": "depth", "rows": 2}, {"name": "rock", "bottom": 0, "rows": 1}],
        "points": {"A": {"x": 4}, "B": {"x": 4, "below": "sand"}},
        "segments": [{"name": "load", "start": 0, "end": 8}],
        "element_length": 4,
        "nominal": {"depth": 6},
        "materials": {"soil": ELASTIC, "rock": {**ELASTIC, "E": "E_rock"}},
        "phases": [
            {"name": "weight", "kind": "gravity", "materials": {"sand": "soil", "rock": "rock"}},
            {"name": "loading", "kind": "plastic", "loads": [{"boundary": "load", "pressure": "q"}]},
        ],
        "zero_at_phase": "loading",
        **changes,
    }


def creeping(**changes: Any) -> dict[str, Any]:
    """Clay under a load of 100 kPa for 1000 days."""
    return (
        ground(
            layers=[{"name": "clay", "thickness": 4, "rows": 2}],
            points={"A": {"x": 4}},
            nominal={},
            materials={"clay": CLAY, "soil": ELASTIC},
            zero_at_phase=None,
            phases=[
                {"name": "weight", "kind": "gravity", "materials": {"clay": "soil"}},
                {
                    **{"name": "creep", "kind": "creep", "duration": 1000, "materials": {"clay": "clay"}},
                    "loads": [{"boundary": "surface", "pressure": 100}],
                },
            ],
        )
        | changes
    )


def spec(section: dict[str, Any]) -> SectionSpec:
    return SectionSpec.model_validate_json(json.dumps(section), strict=True)
