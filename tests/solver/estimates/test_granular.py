"""Granulate hardness and exponent: readings by Bauer's law in closed form give them back, of the loosest specimen."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.classical.errors import NoEvaluationError
from geoswarm.solver.estimates.granular import bauer_fit
from geoswarm.solver.estimates.proposal import candidates_of
from geoswarm.solver.problem import Problem, parse_problem

H_S, N, PHI_C = 1.5e6, 0.28, 33.0  # Hochstetten sand (Herle & Gudehus 1999)
LOADS = [12.5, 25.0, 50.0, 100.0, 200.0, 400.0, 800.0, 200.0]


def law(p: np.ndarray, e_0: float) -> np.ndarray:
    """Void ratio of Bauer's law."""
    return e_0 * np.exp(-((3.0 * p / H_S) ** N))


def test_bauers_law_is_found_again() -> None:
    p = np.array([10.0, 40.0, 160.0, 640.0])
    assert bauer_fit(p, law(p, 1.05)) == pytest.approx((H_S, N, 1.05), rel=1e-6)


@pytest.mark.parametrize(
    ("p", "e", "why"),
    [
        ([10.0, 100.0, 1000.0], [1.0, 0.98, 0.95], "first loading has 3 readings"),
        ([10.0, 50.0, 100.0, 1000.0], [0.9, 0.92, 0.94, 0.95], "does not bend"),
    ],
)
def test_readings_that_tell_no_hardness(p: list[float], e: list[float], why: str) -> None:
    with pytest.raises(NoEvaluationError, match=why):
        bauer_fit(np.array(p), np.array(e))


def sand(e_0: dict[str, float]) -> Problem:
    share = (1.0 + 2.0 * (1.0 - math.sin(math.radians(PHI_C)))) / 3.0  # mean over vertical stress, at rest
    parts: dict[str, Any] = {}
    observations = []
    for name, e in e_0.items():
        start, *y = law(share * np.array([5.0, *LOADS]), e).tolist()
        parts[name] = {
            **{"kind": "oedometer", "material": "hypoplastic_sand", "height": 0.02, "initial_stress": 5.0},
            **{"initial_void_ratio": start, "stages": [{"stress": load, "duration": 1.0} for load in LOADS]},
        }
        x = list(range(1, len(LOADS) + 1))
        observations.append({"series": f"{name}.stage_void_ratio", "points": {"x": x, "y": y}})
    fixed = {"phi_c": PHI_C, "e_d0": 0.55, "e_c0": 0.95, "e_i0": 1.05, "alpha": 0.25, "beta": 1.0}
    free = {"h_s": {"lower": 1e5, "upper": 1e8, "scale": "log"}, "n": {"lower": 0.1, "upper": 0.6}}
    return parse_problem(
        {
            "forward_model": {"kind": "combined", "parts": parts},
            "parameters": free | {name: {"value": value} for name, value in fixed.items()},
            "observations": observations,
            "stopping": {"max_evaluations": 10},
        }
    )


def test_the_loosest_specimen_counts_and_its_hardness_is_an_upper_end() -> None:
    found = candidates_of(sand({"dense": 0.7, "loose": 0.95}))
    (h_s,), (n,) = found["h_s"], found["n"]
    assert h_s.value == pytest.approx(H_S, rel=1e-3)
    assert n.value == pytest.approx(N, rel=1e-3)
    assert h_s.source.startswith("loose: Bauer's law through first loading, e = 0.9")
    assert h_s.ends == pytest.approx((0.2 * H_S, H_S), rel=1e-3)
