"""Curves that several sets of parameters fit alike, with solutions known by formula."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from tests.solver.identifiability.cases import free
from tests.solver.identifiability.zoo import Animal, formula

__all__ = ["ALIKE"]

_GRID = np.arange(0.0, 12.0, 0.5)
_WAVE = 2.0 * np.pi


def _alike(
    expression: str,
    parameters: dict[str, Any],
    curve: Callable[[FloatArray], FloatArray],
    never: str,
    x: FloatArray = _GRID,
    noise: float = 0.05,
) -> Animal:
    """A curve that several sets of parameters fit alike, searched for long; ``noise`` over the largest value."""
    sigma = noise * float(np.abs(curve(x)).max())
    return Animal(formula(expression, parameters, curve, sigma, x, runs=750), None, tuple(never), points=x.size)


ALIKE: dict[str, Animal] = {
    # where readings stand half a unit apart, f, 2 - f and 2 + f give one curve
    "cosine": _alike(
        "A * cos(2 * pi * f * x)",
        {"A": free(0.1, 5.0), "f": free(0.05, 3.0)},
        lambda x: 2.0 * np.cos(_WAVE * 0.3 * x),
        "f",
    ),
    "sine": _alike(
        "A * sin(2 * pi * f * x)",
        {"A": free(-5.0, 5.0), "f": free(0.05, 3.0)},
        lambda x: 2.0 * np.sin(_WAVE * 0.4 * x),
        "f",
    ),
    "decaying cosine": _alike(
        "A * exp(-k * x) * cos(2 * pi * f * x)",
        {"A": free(0.1, 5.0), "k": free(0.01, 1.0), "f": free(0.05, 3.0)},
        lambda x: 2.0 * np.exp(-0.1 * x) * np.cos(_WAVE * 0.3 * x),
        "f",
    ),
    "cosine about an offset": _alike(
        "A * cos(2 * pi * f * x) + o",
        {"A": free(0.1, 5.0), "f": free(0.05, 1.95), "o": free(-3.0, 3.0)},
        lambda x: 2.0 * np.cos(_WAVE * 0.35 * x) + 1.0,
        "f",
    ),
    "phase": _alike(
        "A * sin(x + p)", {"A": free(0.1, 5.0), "p": free(-6.0, 6.0)}, lambda x: 2.0 * np.sin(x + 1.0), "p"
    ),
    "sign of an amplitude": _alike(
        "A * sin(x + p) + o",
        {"A": free(-5.0, 5.0), "p": free(-3.1, 3.1), "o": free(-3.0, 3.0)},
        lambda x: 2.0 * np.sin(x + 1.0) + 1.0,
        "Ap",
    ),
    # terms of one form change places
    "two exponentials": _alike(
        "c * exp(-a * x) + d * exp(-b * x)",
        {**dict.fromkeys("ab", free(0.05, 5.0)), **dict.fromkeys("cd", free(0.1, 5.0))},
        lambda x: 2.0 * np.exp(-0.3 * x) + 3.0 * np.exp(-2.0 * x),
        "abcd",
        _GRID / 2.0,
        0.02,
    ),
    "two peaks": _alike(
        "exp(-(x - a)**2) + exp(-(x - b)**2)",
        dict.fromkeys("ab", free(0.0, 11.0)),
        lambda x: np.exp(-((x - 3.0) ** 2)) + np.exp(-((x - 7.0) ** 2)),
        "ab",
        noise=0.03,
    ),
    "sum and product": _alike(
        "(a + b) * x + a * b", dict.fromkeys("ab", free(0.1, 6.0)), lambda x: 4.0 * x + 3.0, "ab", _GRID / 3.0, 0.02
    ),
    # several roots
    "square": _alike(
        "b * exp(-0.5 * x) + (a - 3)**2 * x",
        {"a": free(0.1, 5.9), "b": free(0.1, 6.0)},
        lambda x: 4.0 * np.exp(-0.5 * x) + 1.69 * x,
        "a",
        _GRID / 3.0,
        0.02,
    ),
    "cubic": _alike(
        "(a - 1) * (a - 3) * (a - 5) * x + b",
        {"a": free(0.0, 6.0), "b": free(0.1, 10.0)},
        lambda x: 5.0 + 0.0 * x,
        "a",
        _GRID / 3.0,
        0.02,
    ),
    "quartic": _alike(
        "(a**2 - 1) * (a**2 - 9) * x + b",
        {"a": free(-4.0, 4.0), "b": free(0.1, 10.0)},
        lambda x: 5.0 - 15.0 * x,
        "a",
        _GRID / 3.0,
    ),
}
