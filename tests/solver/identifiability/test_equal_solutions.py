"""Twelve curves that several sets of parameters fit alike: none of these parameters is called identified.

Solutions are known by formula: f and 2 - f give one curve where readings stand half a unit apart, a phase repeats,
terms of one form change places, a sum and a product leave the order open, polynomials have several roots.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.identifiability import Verdict
from geoswarm.solver.report.document.build import report_of_result
from geoswarm.solver.runs.local import calibrate
from tests.solver.identifiability.cases import free, problem_of
from tests.solver.identifiability.zoo import CONFIDENT

GRID = np.arange(0.0, 12.0, 0.5)
WAVE = 2.0 * np.pi


class Curve(NamedTuple):
    """A model, its free parameters, the true curve, the ambiguous parameters, readings, noise over the largest one."""

    expression: str
    parameters: dict[str, Any]
    truth: Callable[[FloatArray], FloatArray]
    ambiguous: str
    x: FloatArray = GRID
    noise: float = 0.05


CURVES = {
    "cosine": Curve(
        "A * cos(2 * pi * f * x)",
        {"A": free(0.1, 5.0), "f": free(0.05, 3.0)},
        lambda x: 2.0 * np.cos(WAVE * 0.3 * x),
        "f",
    ),
    "two exponentials": Curve(
        "c * exp(-a * x) + d * exp(-b * x)",
        {**dict.fromkeys("ab", free(0.05, 5.0)), **dict.fromkeys("cd", free(0.1, 5.0))},
        lambda x: 2.0 * np.exp(-0.3 * x) + 3.0 * np.exp(-2.0 * x),
        "abcd",
        GRID / 2.0,
        0.02,
    ),
    "sine": Curve(
        "A * sin(2 * pi * f * x)",
        {"A": free(-5.0, 5.0), "f": free(0.05, 3.0)},
        lambda x: 2.0 * np.sin(WAVE * 0.4 * x),
        "f",
    ),
    "decaying cosine": Curve(
        "A * exp(-k * x) * cos(2 * pi * f * x)",
        {"A": free(0.1, 5.0), "k": free(0.01, 1.0), "f": free(0.05, 3.0)},
        lambda x: 2.0 * np.exp(-0.1 * x) * np.cos(WAVE * 0.3 * x),
        "f",
    ),
    "cosine about an offset": Curve(
        "A * cos(2 * pi * f * x) + o",
        {"A": free(0.1, 5.0), "f": free(0.05, 1.95), "o": free(-3.0, 3.0)},
        lambda x: 2.0 * np.cos(WAVE * 0.35 * x) + 1.0,
        "f",
    ),
    "phase": Curve("A * sin(x + p)", {"A": free(0.1, 5.0), "p": free(-6.0, 6.0)}, lambda x: 2.0 * np.sin(x + 1.0), "p"),
    "sign of an amplitude": Curve(
        "A * sin(x + p) + o",
        {"A": free(-5.0, 5.0), "p": free(-3.1, 3.1), "o": free(-3.0, 3.0)},
        lambda x: 2.0 * np.sin(x + 1.0) + 1.0,
        "Ap",
    ),
    "square": Curve(
        "b * exp(-0.5 * x) + (a - 3)**2 * x",
        {"a": free(0.1, 5.9), "b": free(0.1, 6.0)},
        lambda x: 4.0 * np.exp(-0.5 * x) + 1.69 * x,
        "a",
        GRID / 3.0,
        0.02,
    ),
    "cubic": Curve(
        "(a - 1) * (a - 3) * (a - 5) * x + b",
        {"a": free(0.0, 6.0), "b": free(0.1, 10.0)},
        lambda x: 5.0 + 0.0 * x,
        "a",
        GRID / 3.0,
        0.02,
    ),
    "sum and product": Curve(
        "(a + b) * x + a * b", dict.fromkeys("ab", free(0.1, 6.0)), lambda x: 4.0 * x + 3.0, "ab", GRID / 3.0, 0.02
    ),
    "two peaks": Curve(
        "exp(-(x - a)**2) + exp(-(x - b)**2)",
        dict.fromkeys("ab", free(0.0, 11.0)),
        lambda x: np.exp(-((x - 3.0) ** 2)) + np.exp(-((x - 7.0) ** 2)),
        "ab",
        GRID,
        0.03,
    ),
    "quartic": Curve(
        "(a**2 - 1) * (a**2 - 9) * x + b",
        {"a": free(-4.0, 4.0), "b": free(0.1, 10.0)},
        lambda x: 5.0 - 15.0 * x,
        "a",
        GRID / 3.0,
    ),
}


def confident(curve: Curve, seed: int) -> list[Verdict]:
    """Confident verdicts on ambiguous parameters, after a search of 1000 runs and its answer."""
    y = curve.truth(curve.x)
    noise = np.random.default_rng([seed, len(curve.expression)]).standard_normal(y.size)
    y = y + curve.noise * float(np.abs(y).max()) * noise
    problem = problem_of(curve.expression, curve.parameters, y, curve.x, stopping={"max_evaluations": 1000}, seed=seed)
    statistics = report_of_result(problem, calibrate(problem, seed=seed)).statistics
    assert statistics is not None
    return [v for v in statistics.verdicts if v.parameter in curve.ambiguous and v.kind in CONFIDENT]


@pytest.mark.slow
@pytest.mark.parametrize("name", CURVES)
def test_a_parameter_with_several_values_is_identified_within_one_basin_at_most(name: str) -> None:
    """In four seeds; where the other solution was not met, the verdict says in how much of the space one could hide."""
    found = [verdict for seed in range(4) for verdict in confident(CURVES[name], seed)]
    assert [verdict.sentence for verdict in found if not verdict.evidence.sparse] == []
