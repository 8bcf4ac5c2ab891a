"""Three problems with ten candidate tests each, and their worth by brute force.

Every candidate is carried out in silence many times: data of the first test and of the candidate are drawn, both are
fitted together (SciPy, not our own search), and the scatter of the estimates is measured.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.noise import problem_noise
from geoswarm.solver.identifiability.prediction.draws import basins_of
from geoswarm.solver.identifiability.stored.findings import findings_of
from geoswarm.solver.identifiability.worth.candidates import read_candidates
from geoswarm.solver.identifiability.worth.outcome import Design
from geoswarm.solver.identifiability.worth.question import design_problem
from geoswarm.solver.problem import Problem
from geoswarm.solver.runs.local import calibrate
from tests.solver.identifiability.cases import free, linearised, problem_of

__all__ = ["PROBLEMS", "Choice", "designed", "scatter"]

Curve = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True)
class Choice:
    """A first test, and candidates: (name, expression, the same in NumPy, x, error)."""

    expression: str
    curve: Curve
    parameters: dict[str, Any]
    truth: tuple[float, ...]
    x: FloatArray
    error: float
    candidates: tuple[tuple[str, str, Curve, tuple[float, ...], float], ...]

    def problem(self, y: FloatArray) -> Problem:
        points = {"x": self.x.tolist(), "y": y.tolist()}
        observed = [{"series": "y", "points": points, "error": self.error}]
        return problem_of(self.expression, self.parameters, y, self.x, observations=observed)

    def document(self) -> dict[str, Any]:
        return {
            "candidates": [
                {
                    "name": name,
                    "forward_model": {"kind": "formula", "series": {"z": expression}},
                    "observations": [{"series": "z", "points": {"x": list(x)}, "error": error}],
                }
                for name, expression, _, x, error in self.candidates
            ]
        }


def _decay(p: FloatArray, x: FloatArray) -> FloatArray:
    return np.asarray(p[0] * (1.0 - np.exp(-p[1] * x)) + p[2] * x)


def _decays() -> tuple[tuple[str, str, Curve, tuple[float, ...], float], ...]:
    expression = "a * (1 - exp(-b * x)) + c * x"
    places = ((0.2,), (0.6,), (1.5,), (4.0,), (8.0,), (16.0,), (0.2, 0.3), (4.0, 16.0), (8.0, 9.0), (0.6, 8.0))
    return tuple((f"readings at {x}", expression, _decay, x, 0.05) for x in places)


def _power(p: FloatArray, x: FloatArray) -> FloatArray:
    return np.asarray(p[0] * x ** p[1])


def _ratio(p: FloatArray, x: FloatArray) -> FloatArray:
    return np.asarray(p[0] * x / (1.0 + p[1] * x))


def _sum(p: FloatArray, x: FloatArray) -> FloatArray:
    return np.asarray(p[0] * x + p[1])


def _others() -> tuple[tuple[str, str, Curve, tuple[float, ...], float], ...]:
    tests: list[tuple[str, str, Curve, tuple[float, ...], float]] = []
    for x, error in (((2.0,), 0.05), ((9.0,), 0.1), ((30.0,), 0.6), ((1.0, 30.0), 0.6), ((7.0, 8.0), 0.1)):
        tests.append((f"power {x}", "a * x**b", _power, x, error))
    for x, error in (((1.0,), 0.02), ((5.0,), 0.1), ((1.0, 5.0), 0.05)):
        tests.append((f"ratio {x}", "a * x / (1 + b * x)", _ratio, x, error))
    tests += [("sum 1", "a * x + b", _sum, (1.0,), 0.2), ("sum 5", "a * x + b", _sum, (5.0,), 0.05)]
    return tuple(tests)


def _two(p: FloatArray, x: FloatArray) -> FloatArray:
    return np.asarray(p[0] * np.exp(-p[1] * x) + p[2] / (1.0 + x))


def _cools() -> tuple[tuple[str, str, Curve, tuple[float, ...], float], ...]:
    expression = "a * exp(-b * x) + c / (1 + x)"
    tests: list[tuple[str, str, Curve, tuple[float, ...], float]] = [
        (f"at {x}", expression, _two, x, error)
        for x, error in (((0.0,), 0.02), ((1.0,), 0.05), ((3.0,), 0.02), ((10.0,), 0.005), ((0.0, 10.0), 0.05))
    ]
    tests += [
        (f"product {x}", "a * c * x", lambda p, x: p[0] * p[2] * x, (x,), error)
        for x, error in ((1.0, 0.1), (4.0, 0.6))
    ]
    tests += [
        (f"rate {x}", "b * x", lambda p, x: p[1] * x, (x,), error) for x, error in ((1.0, 0.03), (1.0, 0.1), (1.0, 0.4))
    ]
    return tuple((f"{number}: {test[0]}", *test[1:]) for number, test in enumerate(tests))


PROBLEMS = {
    "consolidation and creep": Choice(
        "a * (1 - exp(-b * x)) + c * x",
        _decay,
        {"a": free(0.5, 20.0, "log"), "b": free(0.1, 10.0, "log"), "c": free(0.01, 2.0, "log")},
        (4.0, 1.0, 0.2),
        np.linspace(0.5, 4.0, 10),
        0.05,
        _decays(),
    ),
    "tests of other kinds": Choice(
        "a * x**b",
        _power,
        {"a": free(0.1, 10.0, "log"), "b": free(0.2, 3.0)},
        (1.0, 1.2),
        np.linspace(5.0, 9.0, 10),
        0.2,
        _others(),
    ),
    "three parameters, products": Choice(
        "a * exp(-b * x) + c / (1 + x)",
        _two,
        {"a": free(0.2, 10.0, "log"), "b": free(0.1, 5.0, "log"), "c": free(0.2, 10.0, "log")},
        (2.0, 0.8, 1.5),
        np.linspace(0.2, 4.0, 12),
        0.03,
        _cools(),
    ),
}


def designed(choice: Choice, y: FloatArray, best: FloatArray, draws: int, criterion: str = "widths") -> Design:
    """The order that a design gives for data and their fit."""
    problem = choice.problem(y)
    calibration = Calibration(problem, 1)
    objective = calibration.evaluate(best).objective
    assert objective is not None
    basins = basins_of(calibration, linearised(problem, best.tolist()), objective, (), (), problem_noise(problem))
    candidates = read_candidates(problem, choice.document(), {})
    question = design_problem(
        calibration,
        basins,
        candidates,
        seed=1,
        quantile=1.96,
        draws=draws,
        criterion=criterion,  # type: ignore[arg-type]
    )
    result = calibrate(question)
    (found,) = findings_of(question, 1, [record.evaluation for record in result.history]).designs
    return found


def fitted(choice: Choice, y: FloatArray, more: tuple[tuple[Curve, FloatArray, FloatArray, float], ...]) -> FloatArray:
    """Least squares of the first test and others (curve, x, y, error), from the truth, in search coordinates."""
    log = np.array([p["scale"] == "log" for p in choice.parameters.values()])
    low, high = (np.array([p[end] for p in choice.parameters.values()]) for end in ("lower", "upper"))

    def search(p: FloatArray) -> FloatArray:
        return np.where(log, np.log(np.where(log, p, 1.0)), p)

    def natural(s: FloatArray) -> FloatArray:
        return np.where(log, np.exp(np.where(log, s, 0.0)), s)

    def residuals(s: FloatArray) -> FloatArray:
        p = natural(s)
        parts = [(choice.curve(p, choice.x) - y) / choice.error]
        parts += [(curve(p, x) - z) / error for curve, x, z, error in more]
        return np.concatenate(parts)

    found = least_squares(residuals, search(np.array(choice.truth)), bounds=(search(low), search(high)))
    return np.asarray((found.x - search(low)) / (search(high) - search(low)))


def scatter(choice: Choice, repeats: int, seed: int = 0) -> dict[str, float]:
    """Geometric mean of the standard deviations of the estimates with each candidate, over repeated experiments."""
    random = np.random.default_rng(seed)
    truth = np.array(choice.truth)
    noise = random.standard_normal((repeats, choice.x.size))
    found = {}
    for name, _, curve, x, error in choice.candidates:
        at = np.array(x)
        own = random.standard_normal((repeats, at.size))
        estimates = [
            fitted(
                choice,
                choice.curve(truth, choice.x) + choice.error * noise[i],
                ((curve, at, curve(truth, at) + error * own[i], error),),
            )
            for i in range(repeats)
        ]
        deviations = np.std(np.array(estimates), axis=0)
        found[name] = float(np.exp(np.mean(np.log(deviations))))
    return found
