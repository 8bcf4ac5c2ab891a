"""A zoo of small problems of known structure, and what may not be said of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.problem import Problem
from tests.solver.identifiability.cases import X, free, problem_of

__all__ = ["CONFIDENT", "SWARM", "ZOO", "Animal", "formula"]

CONFIDENT = ("identified", "bounded_on_one_side")
Method: TypeAlias = dict[str, Any]
Make: TypeAlias = Callable[[FloatArray, Method | None], Problem]

SWARM: Method = {"kind": "particle_swarm", "particles": 20, "acceleration": "none"}
"""The textbook swarm: it costs nothing beside the runs, and leaves basins unfinished."""


@dataclass(frozen=True)
class Animal:
    """A problem, made from unit normal noise of shape (n,) and a method, and its structure.

    Parameters
    ----------
    make
        The problem; the usual search where the method is None.
    truth
        True values of the free parameters; None where the model is wrong, so that there are none.
    never
        Parameters of which the data do not tell one value: never identified, never bounded on one side.
    always
        Parameters that the data tell in spite of all: a verdict may not deny it.
    tied
        Parameters that act only in combination.
    silent
        Parameters without influence.
    exchange
        Parameters that can be exchanged.
    wrong
        The model does not describe the data: it may not be said to.
    points
        Readings.
    """

    make: Make
    truth: dict[str, float] | None
    never: tuple[str, ...] = ()
    always: tuple[str, ...] = ()
    tied: tuple[str, ...] = ()
    silent: tuple[str, ...] = ()
    exchange: tuple[str, ...] = ()
    wrong: bool = False
    points: int = X.size


def formula(
    expression: str,
    parameters: dict[str, Any],
    curve: Callable[[FloatArray], FloatArray],
    sigma: float,
    x: FloatArray = X,
    runs: int = 200,
    errors: Callable[[FloatArray], FloatArray] = lambda noise: noise,
    observed: dict[str, Any] | None = None,
    sampled: int = 0,
) -> Make:
    """Make problems of a true curve over x, with errors of standard deviation ``sigma`` from unit normal noise."""

    def make(noise: FloatArray, method: Method | None = None) -> Problem:
        y = curve(x) + sigma * errors(noise)
        points = {"x": x.tolist(), "y": y.tolist()}
        changes: dict[str, Any] = {
            "observations": [{"series": "y", "points": points, **(observed or {})}],
            "stopping": {"max_evaluations": runs * 4 // 3},  # a quarter is left to what follows the search
        }
        if sampled:
            method = {"kind": "monte_carlo", "samples": sampled}
        return problem_of(expression, parameters, y, x, **changes | ({} if method is None else {"method": method}))

    return make


def following(noise: FloatArray) -> FloatArray:
    """Errors of unit variance of which each has 0.8 of the one before it (AR(1))."""
    errors = noise.copy()
    for i in range(1, noise.size):
        errors[i] = 0.8 * errors[i - 1] + 0.6 * noise[i]
    return errors


def with_outliers(noise: FloatArray) -> FloatArray:
    """Two of the readings are wrong by twenty standard deviations."""
    errors = noise.copy()
    errors[[4, 13]] += 20.0
    return errors


def two_basins(x: FloatArray) -> FloatArray:
    return np.asarray(4.0 * np.exp(-0.5 * x) + 1.3**2 * x)


TWO_BASINS = "b * exp(-0.5 * x) + (a - 3)**2 * x"
THREE = np.array([0.5, 2.0, 4.0])

ZOO: dict[str, Animal] = {
    # (a - 3)^2 enters alone: 1.7 and 4.3
    "two basins": Animal(
        formula(TWO_BASINS, {"a": free(0.1, 5.9), "b": free()}, two_basins, 0.05),
        {"a": 1.7, "b": 4.0},
        never=("a",),
        always=("b",),
    ),
    # the other basin, at about 4.3, fits a little worse
    "unequal basins": Animal(
        formula(
            "b * exp(-0.5 * x) + (a - 3)**2 * x + 0.05 * a * exp(-2 * x)",
            {"a": free(0.1, 5.9), "b": free()},
            lambda x: 4.0 * np.exp(-0.5 * x) + 1.3**2 * x + 0.05 * 1.7 * np.exp(-2.0 * x),
            0.05,
        ),
        {"a": 1.7, "b": 4.0},
        always=("b",),
    ),
    # many minima, of which one is that of the truth
    "ripples": Animal(
        formula("b * sin(a * x)", {"a": free(0.1, 15.0), "b": free()}, lambda x: 4.0 * np.sin(6.0 * x), 0.3),
        {"a": 6.0, "b": 4.0},
    ),
    # the same slope at each of three roots of a cubic
    "three basins": Animal(
        formula("(a - 1)*(a - 3)*(a - 5)*x + b", {"a": free(0.0, 6.0), "b": free()}, lambda x: 5.0 + 0.0 * x, 0.05),
        {"a": 3.0, "b": 5.0},
        never=("a",),
        always=("b",),
    ),
    "two basins, sixty runs": Animal(
        formula(TWO_BASINS, {"a": free(0.1, 5.9), "b": free()}, two_basins, 0.05, runs=60),
        {"a": 1.7, "b": 4.0},
        never=("a",),
        always=("b",),
    ),
    "two basins, sampled": Animal(
        formula(
            TWO_BASINS,
            {"a": free(0.1, 5.9), "b": free()},
            two_basins,
            0.05,
            runs=1000,
            sampled=1000,
        ),
        {"a": 1.7, "b": 4.0},
        never=("a",),
        always=("b",),
    ),
    # one of a fortieth of the range beside one of the whole range
    "wide and narrow basin": Animal(
        formula(
            "(a - 1.5 - 4 * exp(-((a - 4.5) / 0.15)**2)) * x + b",
            {"a": free(0.1, 5.9), "b": free()},
            lambda x: 5.0 + 0.0 * x,
            0.05,
        ),
        {"a": 1.5, "b": 5.0},
        always=("b",),
    ),
    "four basins": Animal(
        formula(
            "(a - 0.5)*(a - 2.2)*(a - 3.9)*(a - 5.6)*x + b",
            {"a": free(0.0, 6.0), "b": free()},
            lambda x: 5.0 + 0.0 * x,
            0.05,
        ),
        {"a": 2.2, "b": 5.0},
        never=("a",),
        always=("b",),
    ),
    "five basins": Animal(
        formula(
            "(a - 0.6)*(a - 1.8)*(a - 3)*(a - 4.2)*(a - 5.4)*x + b",
            {"a": free(0.0, 6.0), "b": free()},
            lambda x: 5.0 + 0.0 * x,
            0.05,
        ),
        {"a": 3.0, "b": 5.0},
        never=("a",),
        always=("b",),
    ),
    "exchange": Animal(
        formula(
            "exp(-a * x) + exp(-b * x)",
            {"a": free(0.05, 5.0), "b": free(0.05, 5.0)},
            lambda x: np.exp(-0.3 * x) + np.exp(-2.0 * x),
            0.01,
        ),
        {"a": 0.3, "b": 2.0},
        never=("a", "b"),
        exchange=("a", "b"),
    ),
    "exchange, other bounds": Animal(
        formula(
            "exp(-a * x) + exp(-b * x)",
            {"a": free(0.05, 5.0), "b": free(0.02, 8.0)},
            lambda x: np.exp(-0.3 * x) + np.exp(-2.0 * x),
            0.01,
        ),
        {"a": 0.3, "b": 2.0},
        never=("a", "b"),
        exchange=("a", "b"),
    ),
    "exchange of three": Animal(
        formula(
            "exp(-a * x) + exp(-b * x) + exp(-c * x)",
            {name: free(0.05, 5.0) for name in "abc"},
            lambda x: np.exp(-0.2 * x) + np.exp(-1.0 * x) + np.exp(-4.0 * x),
            0.005,
        ),
        {"a": 0.2, "b": 1.0, "c": 4.0},
        never=("a", "b", "c"),
        exchange=("a", "b", "c"),
    ),
    "product": Animal(
        formula("a * b * x + c", {"a": free(), "b": free(), "c": free()}, lambda x: 6.0 * x + 3.0, 0.1),
        {"a": 2.0, "b": 3.0, "c": 3.0},
        never=("a", "b"),
        always=("c",),
        tied=("a", "b"),
        exchange=("a", "b"),
    ),
    "sum": Animal(
        formula("(a + b) * x + c", {"a": free(), "b": free(), "c": free()}, lambda x: 5.0 * x + 3.0, 0.1),
        {"a": 2.0, "b": 3.0, "c": 3.0},
        never=("a", "b"),
        always=("c",),
        tied=("a", "b"),
        exchange=("a", "b"),
    ),
    "ratio": Animal(
        formula(
            "a / b * x + c",
            {"a": free(scale="log"), "b": free(scale="log"), "c": free()},
            lambda x: 1.5 * x + 3.0,
            0.1,
        ),
        {"a": 3.0, "b": 2.0, "c": 3.0},
        never=("a", "b"),
        always=("c",),
        tied=("a", "b"),
    ),
    "no influence": Animal(
        formula("a * x + 0 * b", {"a": free(), "b": free()}, lambda x: 2.0 * x, 0.05),
        {"a": 2.0, "b": 1.0},
        never=("b",),
        always=("a",),
        silent=("b",),
    ),
    # b - a^2 is known ten times better than a
    "banana": Animal(
        formula(
            "a * x + 10 * (b - a**2) * exp(-x)",
            {"a": free(0.0, 3.0), "b": free(0.0, 9.0)},
            lambda x: 1.2 * x + 0.6 * np.exp(-x),
            0.3,
        ),
        {"a": 1.2, "b": 1.5},
    ),
    "at a bound": Animal(
        formula("a * x + b", {"a": free(0.1, 6.0), "b": free()}, lambda x: 6.0 * x + 2.0, 0.1),
        {"a": 6.0, "b": 2.0},
        always=("b",),
    ),
    # the best line inside the bounds is not the true one
    "beyond a bound": Animal(
        formula("a * x + b", {"a": free(0.1, 5.5), "b": free()}, lambda x: 6.0 * x + 2.0, 0.1),
        None,
        never=("a", "b"),
        wrong=True,
    ),
    "noise-free": Animal(
        formula("b * exp(-a * x)", {"a": free(0.05, 5.0), "b": free()}, lambda x: 4.0 * np.exp(-0.5 * x), 0.0),
        {"a": 0.5, "b": 4.0},
    ),
    "three points": Animal(
        formula("a * x + b", {"a": free(), "b": free()}, lambda x: 2.0 * x + 5.0, 0.05, THREE),
        {"a": 2.0, "b": 5.0},
        points=3,
    ),
    "three points without noise": Animal(
        formula("a * x + b", {"a": free(), "b": free()}, lambda x: 2.0 * x + 5.0, 0.0, THREE),
        {"a": 2.0, "b": 5.0},
        never=("a", "b"),
        points=3,
    ),
    "outliers": Animal(
        formula(
            "b * exp(-a * x)",
            {"a": free(0.05, 5.0), "b": free()},
            lambda x: 4.0 * np.exp(-0.5 * x),
            0.05,
            errors=with_outliers,
            observed={"loss": "cauchy", "loss_scale": 2.385 * 0.05},
        ),
        {"a": 0.5, "b": 4.0},
        always=("a", "b"),
    ),
    "outliers that nobody expects": Animal(
        formula(
            "b * exp(-a * x)",
            {"a": free(0.05, 5.0), "b": free()},
            lambda x: 4.0 * np.exp(-0.5 * x),
            0.05,
            errors=with_outliers,
        ),
        {"a": 0.5, "b": 4.0},
    ),
    "correlated residuals": Animal(
        formula("a * x + b", {"a": free(), "b": free()}, lambda x: 2.0 * x + 5.0, 0.05, errors=following),
        {"a": 2.0, "b": 5.0},
        always=("b",),
    ),
    "wrong model": Animal(
        formula("a * x + b", {"a": free(), "b": free()}, lambda x: 8.0 - 4.0 * np.exp(-1.5 * x), 0.03),
        None,
        never=("a", "b"),
        wrong=True,
    ),
    "wrong model, error stated": Animal(
        formula(
            "a * x + b",
            {"a": free(), "b": free()},
            lambda x: 8.0 - 4.0 * np.exp(-0.4 * x),
            0.03,
            observed={"error": 0.03},
        ),
        None,
        never=("a", "b"),
        wrong=True,
    ),
    "plain": Animal(
        formula("b * exp(-a * x)", {"a": free(0.05, 5.0), "b": free()}, lambda x: 4.0 * np.exp(-0.5 * x), 0.05),
        {"a": 0.5, "b": 4.0},
        always=("a", "b"),
    ),
}
