"""The suite: calibration problems with a target that counts as solved; everything in unit coordinates for the peers."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.problem import load_problem, parse_problem

__all__ = ["PROBLEMS", "Task"]

EXAMPLES = Path(__file__).parents[2] / "examples"
GOLDEN = 43758.5453


@dataclass
class Task:
    """One problem: ``residuals`` maps a point of the unit box to the weighted residuals, None when the run fails."""

    name: str
    document: dict[str, Any]
    target: float
    rough: float = 0.0
    failing: float = 0.0
    scalar: bool = False
    bias: float = 0.0
    calibration: Calibration = field(init=False)

    def __post_init__(self) -> None:
        self.calibration = Calibration(parse_problem(self.document), 1)
        space = self.calibration.space
        self.dimension = space.dimension
        self.lower, self.width = space.search_lower, space.search_upper - space.search_lower
        self.outputs = sum(o.y.size for o in self.calibration.objective.observed)

    def feasible(self, unit: FloatArray) -> bool:
        """Whether a point satisfies the constraints."""
        return self.calibration.space.is_feasible(self.lower + unit * self.width)

    def residuals(self, unit: FloatArray) -> FloatArray | None:
        """Weighted residuals at a point of the unit box, shape (m,)."""
        if self.failing:
            hashed = math.sin(1e5 * float(unit @ np.arange(1, unit.size + 1))) * GOLDEN
            if hashed - math.floor(hashed) < self.failing:
                return None
        natural = self.calibration.space.to_natural(self.lower + unit * self.width)
        evaluation: Evaluation = self.calibration.evaluate(natural)
        if evaluation.objective is None:
            return None
        responses = evaluation.responses
        if self.rough or self.bias:
            number = np.arange(self.outputs)
            noise = self.rough * np.sin(1e5 * unit.sum() + 2.3 * number)
            responses = {
                name: values * (1.0 + self.bias * np.sin(number / 20.0)) + noise for name, values in responses.items()
            }
        r = self.calibration.objective.weighted_residuals(responses)
        return np.array([math.sqrt(float(r @ r))]) if self.scalar else r


def example(name: str, **sections: Any) -> dict[str, Any]:
    """Document of a published example with some sections replaced."""
    return load_problem(EXAMPLES / name / "problem.yaml").document() | sections


def linear(lower: float, upper: float) -> dict[str, Any]:
    return {"lower": lower, "upper": upper}


def log(lower: float, upper: float) -> dict[str, Any]:
    return {"lower": lower, "upper": upper, "scale": "log"}


def curve(
    expression: str, parameters: dict[str, Any], truth: dict[str, float], x: FloatArray, noise: float
) -> dict[str, Any]:
    """A formula with data made from ``truth`` and normally distributed noise."""
    document: dict[str, Any] = {
        "forward_model": {"kind": "formula", "series": {"y": expression}},
        "parameters": parameters,
        "observations": [{"series": "y", "points": {"x": x.tolist(), "y": (0.0 * x).tolist()}}],
        "stopping": {"max_evaluations": 1590},
    }
    exact = Calibration(parse_problem(document), 1).evaluate_values(truth).responses["y"]
    y = exact + noise * np.random.default_rng(3).standard_normal(x.size)
    document["observations"][0]["points"]["y"] = y.tolist()
    return document


def equations(
    expressions: list[str], parameters: dict[str, Any], constraints: list[str] | None = None
) -> dict[str, Any]:
    """Residuals given one by one, all wanted to be zero."""
    series = {f"y{i}": f"{expression} + 0 * x" for i, expression in enumerate(expressions)}
    return {
        "forward_model": {"kind": "formula", "series": series},
        "parameters": parameters,
        "constraints": constraints or [],
        "observations": [{"series": name, "points": {"x": [0.0], "y": [0.0]}} for name in series],
        "stopping": {"max_evaluations": 1590},
    }


def oedometer_five() -> dict[str, Any]:
    document = example("oedometer")
    free = {"mu_star": log(1e-5, 0.05), "phi": linear(8, 30)}
    return document | {"parameters": document["parameters"] | free}


def ripples(centre: dict[str, float]) -> dict[str, Any]:
    parts = [f"{name} - ({c})" for name, c in centre.items()]
    parts += [f"1.2 * sin(6 * ({name} - ({c})))" for name, c in centre.items()]
    return equations(parts, {name: linear(-5, 5) for name in centre})


def mildly_curved(count: int) -> dict[str, Any]:
    names = [f"p{i}" for i in range(count)]
    parts = [f"{a} - 0.3 + 0.2 * ({b} - 0.3)**2" for a, b in zip(names, [*names[1:], names[0]], strict=True)]
    parts += [f"0.5 * ({a} - {b})" for a, b in itertools.pairwise(names)]
    return equations(parts, {name: linear(-2, 2) for name in names})


def exponentials() -> dict[str, Any]:
    free = {"a": linear(0, 5), "b": linear(0, 5), "c": linear(-1, 1), "k1": log(0.5, 20), "k2": log(0.02, 1)}
    truth = {"a": 2.0, "b": 1.0, "c": 0.2, "k1": 1.7, "k2": 0.25}
    return curve("a * exp(-k1 * x) + b * exp(-k2 * x) + c", free, truth, np.linspace(0, 10, 60), 0.01)


def oscillation() -> dict[str, Any]:
    free = {"a": linear(0.2, 4), "w": linear(0.5, 8), "p": linear(0, 6.283)}
    truth = {"a": 1.5, "w": 3.3, "p": 2.1}
    return curve("a * sin(w * x + p) * exp(-0.05 * x)", free, truth, np.linspace(0, 8, 40), 0.05)


def slope_surrogate() -> tuple[dict[str, Any], float]:
    """A stand-in for the creeping slope, until a finite-element model is there, and 1.05 times its least objective.

    Not the published section: an infinite slope at six points, with the published bounds, made-up geometry, and
    data made from the published identified values plus 2 mm of scatter. A creeping layer (thickness ``t``,
    inclination ``beta``) flows by an associated Cam clay rule at the mobilised ratio ``m`` of strengths, which
    makes phi and mu* compensate each other as published; its creep rate falls with an age that grows with (lambda*
    - kappa*) / mu*; the cover on it is elastic (G).
    """
    t, beta = "(3 + 0.8 * sin(2 * x))", "((6.2 + 0.2 * x) * pi / 180)"
    m = f"(tan({beta}) / tan(phi * pi / 180))"
    creep = f"{t} * mu_star * ln(1 + 3 / (33 + 1.05**((lambda_star - kappa_star) / mu_star)))"
    along = f"{creep} * 2 * {m} / (1 - {m}**2) + 40 * (1 + 0.1 * x) / G"
    down = f"{creep} + 0.12 * ({along}) + {t} * kappa_star * 0.01 * (1 + 0.2 * x)"
    free = {
        "lambda_star": log(0.01, 2),
        "kappa_star": log(0.005, 1),
        "mu_star": log(0.001, 1.5),
        "phi": linear(8, 16),
        "G": log(200, 20000),
    }
    truth = {"lambda_star": 1.42, "kappa_star": 0.60, "mu_star": 0.145, "phi": 10.7, "G": 5160.0}
    x = np.arange(1.0, 7.0)
    document: dict[str, Any] = {
        "forward_model": {"kind": "formula", "series": {"along": along, "down": down}},
        "parameters": free,
        "constraints": ["lambda_star > kappa_star"],
        "observations": [{"series": name, "points": {"x": x.tolist(), "y": [0.0] * 6}} for name in ("along", "down")],
        "stopping": {"max_evaluations": 1590},
    }
    exact = Calibration(parse_problem(document), 1).evaluate_values(truth).responses
    random = np.random.default_rng(3)
    for observation in document["observations"]:
        scatter = 0.002 * random.standard_normal(6)
        observation["points"]["y"] = (exact[observation["series"]] + scatter).tolist()
    return document, 1.05 * least_objective(document, truth)


def least_objective(document: dict[str, Any], near: dict[str, float]) -> float:
    """The least objective in a valley, by least squares from points in it."""
    calibration = Calibration(parse_problem(document), 1)
    space = calibration.space
    lower, width = space.search_lower, space.search_upper - space.search_lower
    start = (space.to_search(np.array([near[name] for name in space.names])) - lower) / width
    random = np.random.default_rng(0)

    def residuals(unit: FloatArray) -> FloatArray:
        natural = space.to_natural(lower + unit * width)
        return calibration.objective.weighted_residuals(calibration.evaluate(natural).responses)

    starts = [start, *np.clip(start + 0.1 * random.standard_normal((20, start.size)), 0.01, 0.99)]
    return min(2.0 * least_squares(residuals, u, bounds=(0, 1), xtol=1e-12, ftol=1e-12).cost for u in starts)


def combined() -> dict[str, Any]:
    return example("combined")


def constrained() -> dict[str, Any]:
    free = {"p": linear(-3, 3), "q": linear(-3, 6)}
    return equations(["10 * (q - p**2)", "1 - p"], free, ["p + q < 2.2", "q > p - 0.5"])


PROBLEMS: dict[str, Callable[[], Task]] = {
    "oedometer": lambda: Task("oedometer", example("oedometer"), 5e-9),
    "isotropic": lambda: Task("isotropic", example("isotropic_compression"), 1e-8),
    "combined": lambda: Task("combined", combined(), 2.4e-8),
    "oedometer, 5 free": lambda: Task("oedometer, 5 free", oedometer_five(), 5e-9),
    "5 correlated": lambda: Task("5 correlated", exponentials(), 2e-4),
    "slope, surrogate": lambda: Task("slope, surrogate", *slope_surrogate()),
    "rough": lambda: Task("rough", example("oedometer"), 5e-9, rough=2e-6),
    "biased": lambda: Task("biased", example("oedometer"), 2e-8, bias=0.08),
    "20 % failing": lambda: Task("20 % failing", example("oedometer"), 5e-9, failing=0.2),
    "multimodal": lambda: Task("multimodal", oscillation(), 5e-3),
    "ripples": lambda: Task("ripples", ripples({"p": 0.3, "q": -1.2}), 1e-4),
    "multimodal, scalar": lambda: Task("multimodal, scalar", oscillation(), 5e-3, scalar=True),
    "ripples, scalar": lambda: Task("ripples, scalar", ripples({"p": 0.3, "q": -1.2}), 1e-4, scalar=True),
    "constrained": lambda: Task("constrained", constrained(), 1e-4),
    "valley, scalar": lambda: Task("valley, scalar", constrained() | {"constraints": []}, 1e-4, scalar=True),
    "10 parameters": lambda: Task("10 parameters", mildly_curved(10), 1e-4),
    "20 parameters": lambda: Task("20 parameters", mildly_curved(20), 1e-4),
}
