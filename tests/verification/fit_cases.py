"""Problems on which the test of lack of fit is measured: right models of many kinds, and wrong ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.special import stdtrit

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.forward.formula import FormulaSpec
from geoswarm.solver.identifiability import Linearisation, design, from_evaluations
from geoswarm.solver.identifiability.optimum.bending import likelihood_intervals
from geoswarm.solver.identifiability.optimum.polish import polish
from geoswarm.solver.problem import parse_problem

__all__ = [
    "BANANA",
    "DEPARTING",
    "FEW_STATED",
    "RIGHT",
    "WRONG",
    "Case",
    "Coverage",
    "coverage",
    "fitted",
    "share_flagged",
]

Noise = Callable[[np.random.Generator, FloatArray], FloatArray]


def normal(deviation: float) -> Noise:
    """Independent normal noise."""
    return lambda random, x: random.normal(0.0, deviation, x.size)


def students(deviation: float) -> Noise:
    """Noise with heavy tails: Student's t with 4 degrees of freedom."""
    return lambda random, x: deviation / np.sqrt(2.0) * random.standard_t(4.0, x.size)


def autocorrelated(deviation: float, rho: float) -> Noise:
    """Noise of first-order autocorrelation."""

    def draw(random: np.random.Generator, x: FloatArray) -> FloatArray:
        e = random.normal(0.0, deviation, x.size)
        e[1:] *= np.sqrt(1.0 - rho * rho)
        for i in range(1, x.size):
            e[i] += rho * e[i - 1]
        return e

    return draw


def growing(deviation: float) -> Noise:
    """Noise that grows as x squared."""
    return lambda random, x: random.normal(0.0, 1.0, x.size) * deviation * (0.1 + (x / x.max()) ** 2)


@dataclass(frozen=True)
class Case:
    """A problem with formulas, the truth, and what is wrong with it.

    ``truth`` calculates the measured series from (x, parameters) where it is not the model itself.
    """

    formulas: dict[str, str]
    parameters: dict[str, tuple[float, float, float, str]]  # truth, lower, upper, scale
    x: dict[str, FloatArray]
    noise: dict[str, Noise]
    wrong: dict[str, Callable[[FloatArray], FloatArray]] = field(default_factory=dict)
    error: dict[str, float] = field(default_factory=dict)
    weights: dict[str, list[float]] = field(default_factory=dict)
    noise_kind: str | None = None

    @property
    def values(self) -> dict[str, float]:
        return {name: given[0] for name, given in self.parameters.items()}

    def document(self, random: np.random.Generator) -> dict[str, Any]:
        observations = []
        for series, y in exact(self.formulas, self.x, self.values).items():
            x = self.x[series]
            bias = self.wrong[series](x) if series in self.wrong else 0.0
            measured = y + bias + self.noise[series](random, x)
            points: dict[str, Any] = {"x": x.tolist(), "y": measured.tolist()}
            if series in self.weights:
                points["weight"] = self.weights[series]
            given = {"error": self.error[series]} if series in self.error else {}
            observations.append({"series": series, "points": points, **given})
        return {
            "forward_model": {"kind": "formula", "series": self.formulas},
            "parameters": {
                name: {"lower": low, "upper": high, "scale": scale}
                for name, (_, low, high, scale) in self.parameters.items()
            },
            "observations": observations,
            "stopping": {"max_evaluations": 10},
        } | ({} if self.noise_kind is None else {"noise": {"kind": self.noise_kind}})


def exact(formulas: dict[str, str], x: dict[str, FloatArray], values: dict[str, float]) -> dict[str, FloatArray]:
    """The formulas at the truth."""
    return FormulaSpec(kind="formula", series=formulas).build().prepare(x)(values)


def fitted(case: Case, random: np.random.Generator) -> Linearisation:
    """One experiment, fitted from the truth and linearised."""
    calibration = Calibration(parse_problem(case.document(random)), 1)
    return _linearised(calibration, np.array(list(case.values.values())))


def _linearised(calibration: Calibration, start: FloatArray) -> Linearisation:
    found = polish(calibration, start).parameters
    plan = design(calibration, found, step=2e-3)
    return from_evaluations(calibration, plan, [calibration.evaluate(x) for x in plan.positions])


def share_flagged(case: Case, repeats: int, seed: int = 77) -> float:
    """Share of the experiments in which the model is doubted, said not to describe the data, or the error not met."""
    random = np.random.default_rng(seed)
    kinds = [fitted(case, random).fit.kind for _ in range(repeats)]
    return sum(kind in ("doubtful", "lack_of_fit", "error_not_met") for kind in kinds) / repeats


LINE = {"a": (1.0, 0.1, 5.0, "linear"), "b": (0.5, 0.05, 5.0, "log")}
CURVE = {"a": (2.0, 0.1, 10.0, "linear"), "b": (0.8, 0.05, 8.0, "log")}
SATURATION = {"y": "a * (1 - exp(-b * x))"}
HYPERBOLA = {"y": "a * x / (b + x)"}
EVEN = {n: {"y": np.linspace(0.05, 4.0, n)} for n in (8, 15, 40, 200)}
SPREAD = {"y": np.geomspace(1e-2, 1e3, 30)}
TWO = {"level": "a + b * x", "rate": "10 * b * x - a"}

RIGHT: dict[str, Case] = {
    "8 points, line": Case({"y": "a + b * x"}, LINE, EVEN[8], {"y": normal(0.05)}),
    "15 points, saturation": Case(SATURATION, CURVE, EVEN[15], {"y": normal(0.05)}),
    "40 points, saturation": Case(SATURATION, CURVE, EVEN[40], {"y": normal(0.05)}),
    "200 points, saturation": Case(SATURATION, CURVE, EVEN[200], {"y": normal(0.05)}),
    "strongly bent": Case(
        HYPERBOLA, {"a": (2.0, 0.2, 50.0, "log"), "b": (3.0, 0.05, 200.0, "log")}, EVEN[15], {"y": normal(0.04)}
    ),
    "readings spaced by the logarithm": Case(
        {"y": "a + b * ln(1 + x / t)"},
        {**LINE, "t": (1.0, 0.01, 100.0, "log")},
        SPREAD,
        {"y": normal(0.05)},
    ),
    "five correlated parameters": Case(
        {"y": "a + b * x + c * x**2 + d * exp(-k * x)"},
        {
            "a": (1.0, -5.0, 5.0, "linear"),
            "b": (0.5, -5.0, 5.0, "linear"),
            "c": (0.1, -5.0, 5.0, "linear"),
            "d": (2.0, -8.0, 8.0, "linear"),
            "k": (3.0, 0.3, 30.0, "log"),
        },
        EVEN[40],
        {"y": normal(0.05)},
    ),
    "repeats": Case({"y": "a + b * x"}, LINE, {"y": np.repeat(np.linspace(0.0, 4.0, 8), 3)}, {"y": normal(0.05)}),
    "stated error": Case(SATURATION, CURVE, EVEN[15], {"y": normal(0.05)}, error={"y": 0.05}),
    "graded points": Case(
        SATURATION,
        CURVE,
        EVEN[40],
        {"y": lambda random, x: random.normal(0.0, 0.05, x.size) / np.sqrt(np.where(np.arange(x.size) % 3, 1.0, 9.0))},
        weights={"y": np.where(np.arange(40) % 3, 1.0, 9.0).tolist()},
    ),
    "two series of different noise": Case(
        TWO,
        LINE,
        {"level": np.linspace(0.0, 4.0, 12), "rate": np.linspace(0.0, 4.0, 40)},
        {"level": normal(0.05), "rate": normal(1.0)},
    ),
    "two series, stated errors": Case(
        TWO,
        LINE,
        {"level": np.linspace(0.0, 4.0, 12), "rate": np.linspace(0.0, 4.0, 40)},
        {"level": normal(0.05), "rate": normal(1.0)},
        error={"level": 0.05, "rate": 1.0},
    ),
    "heavy tails": Case(SATURATION, CURVE, EVEN[40], {"y": students(0.05)}),
    "noise that grows as x squared": Case(SATURATION, CURVE, EVEN[40], {"y": growing(0.1)}),
}
"""Models that are right, with the noise that they are said to have, or with none stated."""


def scaled(shape: Callable[[FloatArray], FloatArray], size: float, x: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """A systematic deviation whose largest value over x is ``size`` after the best straight line is taken off."""
    table = np.stack([np.ones_like(x), x], axis=1)
    left = shape(x) - table @ np.linalg.lstsq(table, shape(x), rcond=None)[0]
    factor = size / float(np.abs(left).max())
    return lambda at: factor * shape(at)


def _line(points: int, shape: Callable[[FloatArray], FloatArray], error: float | None = None) -> Case:
    x = np.linspace(0.05, 4.0, points)
    return Case(
        {"y": "a + b * x"},
        {"a": (1.0, -20.0, 20.0, "linear"), "b": (0.5, -20.0, 20.0, "linear")},
        {"y": x},
        {"y": normal(0.05)},
        wrong={"y": scaled(shape, 0.1, x)},
        error={} if error is None else {"y": error},
    )


SHAPES: dict[str, Callable[[FloatArray], FloatArray]] = {
    "bend": lambda x: x * x,
    "wave": lambda x: np.sin(2.0 * x),
    "step": lambda x: np.where(x > 2.5, 1.0, 0.0),
}

WRONG: dict[str, Case] = {
    f"{name}, {points} points{', stated error' if error else ''}": _line(points, shape, error)
    for error in (None, 0.05)
    for points in (15, 18, 40, 100)
    for name, shape in SHAPES.items()
}
"""Lines fitted to data with a systematic deviation of at most twice the noise."""


@dataclass(frozen=True)
class Coverage:
    """How 95 % intervals of a case did.

    Parameters
    ----------
    covered, classical
        Share that holds the truth, by parameter: of the intervals, and of those from the standard errors alone.
    warned
        Share of the fits that are told not to be described, or whose residuals are told to be correlated or uneven.
    plain
        Share of the fits in which a plain interval, of which nothing is said, misses the truth, by parameter.
    """

    covered: FloatArray
    classical: FloatArray
    warned: float
    plain: FloatArray


def coverage(case: Case, repeats: int, seed: int = 11) -> Coverage:
    """Repeat an experiment; intervals are those of a report, by likelihood where the model is nonlinear."""
    random = np.random.default_rng(seed)
    truth = np.array(list(case.values.values()))
    held, classical, plain, warned = [], [], [], 0
    for _ in range(repeats):
        calibration = Calibration(parse_problem(case.document(random)), 1)
        found = likelihood_intervals(calibration, _linearised(calibration, truth))
        held.append(_holds(found.intervals, truth))
        classical.append(_holds(_classical(found), truth))
        told = found.fit.wrong or bool(found.dependence)
        warned += told
        usual = np.array([basis == "linearised" for basis in found.bases])
        plain.append(usual & ~held[-1] & (not told))
    return Coverage(np.mean(held, axis=0), np.mean(classical, axis=0), warned / repeats, np.mean(plain, axis=0))


def _holds(intervals: FloatArray, truth: FloatArray) -> BoolArray:
    return np.asarray((intervals[:, 0] <= truth) & (truth <= intervals[:, 1]))


def _classical(found: Linearisation) -> FloatArray:
    """Student's intervals from the standard errors, shape (d, 2)."""
    log = np.array([scale == "log" for scale in found.scales])
    half = float(stdtrit(found.degrees_of_freedom, 0.975)) * found.standard_errors
    relative = np.exp(half / found.optimum)
    low, high = found.optimum - half, found.optimum + half
    return np.stack([np.where(log, found.optimum / relative, low), np.where(log, found.optimum * relative, high)], 1)


FEW_STATED: dict[tuple[int, float], Case] = {
    (points, error): Case(
        SATURATION, CURVE, {"y": np.linspace(0.5, 4.0, points)}, {"y": normal(0.05)}, error={"y": error}
    )
    for points in (3, 4, 5, 6)
    for error in (0.05, 0.0025)
}
"""Few readings with a stated error, by their number and the error: the right one, and one 20 times too small."""

BANANA = Case(
    {"y": "where(x < 0.5, a, 10 * (b - a**2))"},
    {"a": (1.0, -4.0, 6.0, "linear"), "b": (1.0, -15.0, 30.0, "linear")},
    {"y": np.linspace(0.0, 1.0, 20)},
    {"y": normal(1.5)},
    noise_kind="white",
)
"""Readings of a and of 10 (b - a^2), Rosenbrock's valley: b follows the square of an uncertain a."""

DEPARTING: dict[str, Case] = (
    {"banana": BANANA}
    | {
        f"correlated noise, {rho}": Case(SATURATION, CURVE, EVEN[40], {"y": autocorrelated(0.05, rho)})
        for rho in (0.5, 0.8)
    }
    | {
        "noise that grows as x squared": RIGHT["noise that grows as x squared"],
        "bias below the noise": Case(
            SATURATION, CURVE, EVEN[200], {"y": normal(0.05)}, wrong={"y": lambda x: 0.04 * np.sin(1.5 * x)}
        ),
    }
)
"""A model that bends, noise that is not independent and even, and a bias: what intervals do under them."""
