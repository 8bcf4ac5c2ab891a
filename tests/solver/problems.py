"""Small problems shared by the tests: quick to run, with known answers."""

from __future__ import annotations

from typing import Any

import numpy as np

from geoswarm.solver.problem import Problem, parse_problem

__all__ = ["decay_document", "decay_problem"]


def decay_document(**changes: Any) -> dict[str, Any]:
    """An exponential decay with amplitude 3, rate 0.7 and exact data, by the search alone.

    ``changes`` replace whole sections.
    """
    x = np.linspace(0.0, 5.0, 21)
    document: dict[str, Any] = {
        "name": "decay",
        "forward_model": {"kind": "formula", "series": {"y": "amplitude * exp(-rate * x)"}},
        "parameters": {
            "amplitude": {"lower": 0.1, "upper": 10.0},
            "rate": {"lower": 0.01, "upper": 10.0, "scale": "log"},
        },
        "observations": [{"series": "y", "points": {"x": x.tolist(), "y": (3.0 * np.exp(-0.7 * x)).tolist()}}],
        "method": {"kind": "particle_swarm", "particles": 8, "acceleration": "none"},
        "stopping": {"max_evaluations": 800, "target_objective": 1e-8},
        "answer": {"max_evaluations": "off"},
        "seed": 11,
    }
    return {key: value for key, value in (document | changes).items() if value is not None}


def decay_problem(**changes: Any) -> Problem:
    """The problem of :func:`decay_document`."""
    return parse_problem(decay_document(**changes))
