"""Compile the numerical kernels ahead of the first calibration: ``python -m geoswarm.solver.warm``.

Numba caches what it compiles beside the sources, or in the folder that ``NUMBA_CACHE_DIR`` names. So each installation
pays once, at set-up or when its image is built, and every process after that starts warm.
"""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable
from typing import Any

from geoswarm.solver.problem import parse_problem

__all__ = ["SAMPLES", "warm"]

logger = logging.getLogger(__name__)

MATERIAL: dict[str, Any] = {
    "lambda_star": {"value": 0.1},
    "kappa_star": {"value": 0.02},
    "mu_star": {"value": 1.0e-3},
    "c": {"value": 5.0},
    "phi": {"value": 20.0},
    "psi": {"value": 0.0},
}
STAGES: list[dict[str, float]] = [{"stress": 50.0, "duration": 1.0}, {"stress": 20.0, "duration": 1.0}]


def _sample(forward_model: dict[str, Any], series: str) -> dict[str, Any]:
    """Build a problem around one forward model; nothing of it is calibrated, the free parameter only makes it whole."""
    return {
        "name": "warm",
        "forward_model": {"material": "soft_soil_creep", "stages": STAGES, **forward_model},
        "parameters": {**MATERIAL, "mu_star": {"lower": 1.0e-4, "upper": 1.0e-2}},
        "observations": [{"series": series, "points": {"x": [1.0, 2.0], "y": [0.0, 0.0]}}],
        "method": {"kind": "monte_carlo", "samples": 1},
    }


_STIFF = {"law": "elastic", "E": 1.0e4, "nu": 0.3, "unit_weight": 20.0}
_STRENGTH = {"c": 5.0, "phi": 20.0}
_CLAY = {"law": "soft_soil_creep", "lambda_star": 0.1, "kappa_star": 0.02, "mu_star": "mu_star", **_STRENGTH}
SECTION: dict[str, Any] = {
    "name": "warm",
    "forward_model": {
        "kind": "section",
        "surface": [[0, 4], [4, 4]],
        "layers": [{"name": "clay", "thickness": 2}, {"name": "sand", "thickness": 2}],
        "cuts": [{"name": "crack", "x": 2, "through": "clay"}],
        "points": {"A": {"x": 1}},
        "element_length": 2,
        "materials": {
            "stiff": _STIFF,
            "sand": {**_STIFF, "law": "mohr_coulomb", **_STRENGTH},
            "clay": {**_CLAY, "unit_weight": 18.0},
            "joint": {"law": "interface", "normal_stiffness": 1e5, "shear_stiffness": 1e4, **_STRENGTH},
        },
        "phases": [
            {"name": "weight", "kind": "gravity", "materials": {"clay": "stiff", "sand": "stiff", "crack": "joint"}},
            {"name": "strength", "kind": "plastic", "materials": {"sand": "sand"}},
            {
                **{"name": "creep", "kind": "creep", "duration": 10, "materials": {"clay": "clay"}},
                "loads": [{"boundary": "surface", "pressure": 10, "follows": True}],
                "updated_mesh": True,
            },
        ],
    },
    "parameters": {"mu_star": {"lower": 1.0e-4, "upper": 1.0e-2}},
    "observations": [{"series": "A.uy", "points": {"x": [1.0, 10.0], "y": [0.0, 0.0]}}],
    "method": {"kind": "monte_carlo", "samples": 1},
}
"""A body with every material and an interface, so that all kernels of the finite elements are compiled."""

SAMPLES: dict[str, dict[str, Any]] = {
    "oedometer": _sample({"kind": "oedometer", "height": 0.02, "initial_stress": 1.0}, "settlement"),
    "isotropic_compression": _sample(
        {"kind": "isotropic_compression", "height": 0.1, "diameter": 0.05, "initial_stress": 1.0}, "axial_displacement"
    ),
    "section": SECTION,
}


def warm(report: Callable[[str, float], None] | None = None) -> None:
    """Run every built-in forward model that has compiled kernels once.

    Parameters
    ----------
    report
        Is told the forward model's kind and the wall time of its first run [s].
    """
    for kind, document in SAMPLES.items():
        began = time.perf_counter()
        problem = parse_problem(document)
        run = problem.model.prepare({observation.series: observation.x for observation in problem.observations})
        run(problem.values([MATERIAL["mu_star"]["value"]]))
        if report is not None:
            report(kind, time.perf_counter() - began)


def _main() -> None:
    logging.basicConfig(level=logging.INFO, format="geoswarm: %(message)s", stream=sys.stdout)
    logger.info("compiling the kernels for this machine (a moment the first time)")
    warm(lambda kind, seconds: logger.info("%s is ready (%.1f s)", kind, seconds))


if __name__ == "__main__":
    _main()
