"""The functions and constants that an expression may use."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

__all__ = ["CONSTANTS", "FUNCTIONS", "HINTS", "WHERE", "Function"]


@dataclass(frozen=True, slots=True)
class Function:
    """One function: for floats (may raise for what has no value) and for arrays (gives inf or nan)."""

    name: str
    description: str
    scalar: Callable[..., float]
    array: Callable[..., Any]
    most_arguments: int | None = 1


def _lowest(*numbers: float) -> float:
    # min() of Python ignores or keeps a NaN depending on the order; a NaN must stay visible.
    return math.nan if any(number != number for number in numbers) else min(numbers)


def _highest(*numbers: float) -> float:
    return math.nan if any(number != number for number in numbers) else max(numbers)


def _lowest_of_arrays(*arrays: Any) -> Any:
    return reduce(np.minimum, arrays)


def _highest_of_arrays(*arrays: Any) -> Any:
    return reduce(np.maximum, arrays)


def _error_function(x: Any) -> Any:
    from scipy.special import erf

    return erf(x)


def _complementary_error_function(x: Any) -> Any:
    from scipy.special import erfc

    return erfc(x)


def _exponential_integral(x: Any) -> Any:
    from scipy.special import exp1  # gives inf at 0 and nan below

    return exp1(x)


def _chosen(holds: bool, fails: bool, first: float, second: float) -> float:
    # over nan a condition neither holds nor fails: the value is then not defined
    return first if holds else second if fails else math.nan


def _chosen_of_arrays(holds: Any, fails: Any, first: Any, second: Any) -> Any:
    return np.where(holds, first, np.where(fails, second, np.nan))[()]


WHERE = "where"
"""The function of a comparison and two numbers; a call of it has the opposite comparison, too."""

FUNCTIONS: dict[str, Function] = {
    function.name: function
    for function in (
        Function("exp", "exponential", math.exp, np.exp),
        Function("ln", "natural logarithm", math.log, np.log),
        Function("log10", "decimal logarithm", math.log10, np.log10),
        Function("sqrt", "square root", math.sqrt, np.sqrt),
        Function("abs", "absolute value", math.fabs, np.abs),
        Function("min", "lowest of its arguments", _lowest, _lowest_of_arrays, None),
        Function("max", "highest of its arguments", _highest, _highest_of_arrays, None),
        Function("sin", "sine of an angle in radians", math.sin, np.sin),
        Function("cos", "cosine of an angle in radians", math.cos, np.cos),
        Function("tan", "tangent of an angle in radians", math.tan, np.tan),
        Function("asin", "angle in radians from its sine", math.asin, np.arcsin),
        Function("acos", "angle in radians from its cosine", math.acos, np.arccos),
        Function("atan", "angle in radians from its tangent", math.atan, np.arctan),
        Function("sinh", "hyperbolic sine", math.sinh, np.sinh),
        Function("cosh", "hyperbolic cosine", math.cosh, np.cosh),
        Function("tanh", "hyperbolic tangent", math.tanh, np.tanh),
        Function("erf", "error function", math.erf, _error_function),
        Function("erfc", "complementary error function, 1 - erf", math.erfc, _complementary_error_function),
        Function(
            "exp1",
            "exponential integral E1 of a positive number",
            lambda x: float(_exponential_integral(x)),
            _exponential_integral,
        ),
        Function(WHERE, "where(a > b, c, d): c where the comparison holds, else d", _chosen, _chosen_of_arrays, 3),
    )
}
"""Functions by name."""

CONSTANTS: dict[str, float] = {"pi": math.pi}
"""Constants by name; no parameter may have such a name."""

HINTS: dict[str, str] = {
    "log": "write ln for the natural or log10 for the decimal logarithm",
    "log2": "write ln(x) / ln(2)",
    "pow": "write a**b",
    "arcsin": "write asin",
    "arccos": "write acos",
    "arctan": "write atan",
    "fabs": "write abs",
    "if": "write where(a > b, c, d)",
    "expint": "write exp1",
    "e1": "write exp1",
    "E1": "write exp1",
}
"""What to write instead of names that users know from elsewhere."""
