"""Geometry as a parameter: the depth of a shear zone is found from displacement vectors at the surface."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.runs.local import calibrate

TRUTH = {"depth": 12.0, "mu_star": 0.006}
NOISE = 5.0e-5
POINTS = ["A", "B", "C", "D"]

CLAY = {"c": 5, "phi": 18, "unit_weight": 19}
SLOPE: dict[str, Any] = {
    "kind": "section",
    "surface": [[0, 40], [60, 32], [160, 10], [200, 8]],
    "layers": [
        {"name": "cover", "thickness": "depth", "rows": 2},
        {"name": "shear_zone", "thickness": 1.0},
        {"name": "rock", "thickness": 10},
    ],
    "points": {name: {"x": x} for name, x in zip(POINTS, (30, 80, 120, 170), strict=True)},
    "element_length": 10,
    "nominal": {"depth": 10},
    "materials": {
        "soil": {"law": "elastic", "G": 4000, "nu": 0.35, "unit_weight": 20},
        "rock": {"law": "elastic", "E": 5e5, "nu": 0.25, "unit_weight": 22},
        "strength": {"law": "mohr_coulomb", "G": 4000, "nu": 0.35, **CLAY},
        "clay": {"law": "soft_soil_creep", "lambda_star": 0.15, "kappa_star": 0.03, "mu_star": "mu_star", **CLAY},
    },
    "phases": [
        {"name": "weight", "kind": "gravity", "materials": {"cover": "soil", "shear_zone": "soil", "rock": "rock"}},
        {"name": "strength", "kind": "plastic", "materials": {"shear_zone": "strength"}},
        {"name": "creep", "kind": "creep", "duration": 7300, "materials": {"shear_zone": "clay"}},
    ],
    "control": {"tolerance": 1e-8},
    "vectors": {"gps": {"points": POINTS, "start": 365, "end": 7300}},
}


def problem(vectors: dict[str, list[float]]) -> Problem:
    return parse_problem(
        {
            "name": "depth",
            "forward_model": SLOPE,
            "parameters": {
                "depth": {"lower": 6, "upper": 25},
                "mu_star": {"lower": 0.001, "upper": 0.02, "scale": "log"},
            },
            "observations": [
                {"series": series, "points": {"x": list(range(1, 5)), "y": y}} for series, y in vectors.items()
            ],
            "method": {"kind": "particle_swarm", "particles": 10, "acceleration": "response_surface"},
            "stopping": {"max_evaluations": 100},
            "seed": 7,
        }
    )


@pytest.mark.slow
def test_the_depth_of_the_shear_zone_is_recovered() -> None:
    series = ("gps.ux", "gps.uy")
    blank = problem(dict.fromkeys(series, [0.0] * 4))
    exact = blank.model.prepare(dict.fromkeys(series, np.arange(1.0, 5.0)))(TRUTH)
    random = np.random.default_rng(11)
    vectors = {name: (exact[name] + random.normal(0.0, NOISE, 4)).tolist() for name in series}
    result = calibrate(problem(vectors))
    assert result.parameters is not None
    assert result.parameters["depth"] == pytest.approx(TRUTH["depth"], rel=0.05)
    assert result.parameters["mu_star"] == pytest.approx(TRUTH["mu_star"], rel=0.05)
    assert result.objective == pytest.approx(2.0 * NOISE**2, rel=0.9)
