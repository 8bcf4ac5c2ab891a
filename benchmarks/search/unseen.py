"""Twenty curves with 4 to 10 parameters and one to some ten basins.

A search has solved one when its objective is at most 1 % above the least.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.search.problems import Task, curve, least_objective, linear, log

__all__ = ["UNSEEN"]

_NEARLY = 1.01  # times the least objective


def _made(name: str, x: tuple[float, float], noise: float, expression: str, **parameters: Any) -> Callable[[], Task]:
    """A curve at 60 points; each parameter is ``(section, true value)``."""

    def make() -> Task:
        truth = {key: value for key, (_, value) in parameters.items()}
        free = {key: section for key, (section, _) in parameters.items()}
        document = curve(expression, free, truth, np.linspace(*x, 60), noise)
        return Task(name, document, _NEARLY * least_objective(document, truth))

    return make


def _gauss(number: int) -> str:
    return f"a{number} * exp(-((x - m{number}) / s{number})**2)"


UNSEEN: dict[str, Callable[[], Task]] = {
    "damped cosine": _made(
        "damped cosine",
        (0.0, 4.0),
        0.15,
        "a * exp(-d * x) * cos(2 * pi * f * x + p) + o",
        a=(log(0.1, 20), 3.0),
        d=(log(0.01, 5), 0.5),
        f=(linear(0.2, 6), 2.3),
        p=(linear(-3.2, 3.2), 0.7),
        o=(linear(-3, 3), 0.4),
    ),
    "two tones": _made(
        "two tones",
        (0.0, 5.0),
        0.1,
        "a * sin(2 * pi * f * x) + b * sin(2 * pi * g * x) + o",
        a=(linear(0, 3), 1.0),
        f=(linear(0.45, 0.75), 0.6),
        b=(linear(0, 3), 0.7),
        g=(linear(1.5, 1.9), 1.7),
        o=(linear(-2, 2), 0.3),
    ),
    "chirp": _made(
        "chirp",
        (0.0, 3.0),
        0.05,
        "a * sin(2 * pi * (f * x + k * x**2) + p)",
        a=(log(0.1, 10), 1.2),
        f=(linear(0.2, 2), 0.8),
        k=(linear(-0.2, 0.5), 0.15),
        p=(linear(-3.2, 3.2), -0.5),
    ),
    "two exponentials": _made(
        "two exponentials",
        (0.0, 10.0),
        0.02,
        "a * exp(-k * x) + b * exp(-l * x) + o",
        a=(linear(0, 5), 2.0),
        k=(log(0.5, 20), 1.2),
        b=(linear(0, 5), 1.5),
        l=(log(0.01, 1), 0.15),
        o=(linear(-1, 1), 0.1),
    ),
    "rise and decay": _made(
        "rise and decay",
        (0.0, 8.0),
        0.02,
        "a * (exp(-k * x) - exp(-l * x)) + o + s * x",
        a=(log(0.1, 20), 2.5),
        k=(log(0.05, 1), 0.3),
        l=(log(1, 30), 3.0),
        o=(linear(-1, 1), 0.2),
        s=(linear(-0.2, 0.2), -0.02),
    ),
    "stretched exponential": _made(
        "stretched exponential",
        (0.01, 20.0),
        0.01,
        "a * exp(-(k * x)**n) + o + s * x",
        a=(linear(0.1, 5), 1.5),
        k=(log(0.01, 10), 0.4),
        n=(linear(0.2, 2), 0.6),
        o=(linear(-1, 1), 0.2),
        s=(linear(-0.05, 0.05), 0.01),
    ),
    "two Gaussians": _made(
        "two Gaussians",
        (0.0, 10.0),
        0.03,
        f"{_gauss(1)} + {_gauss(2)} + o",
        a1=(linear(0, 3), 1.0),
        m1=(linear(0, 5), 3.2),
        s1=(log(0.2, 3), 0.8),
        a2=(linear(0, 3), 0.6),
        m2=(linear(5, 10), 6.4),
        s2=(log(0.2, 3), 1.2),
        o=(linear(-1, 1), 0.1),
    ),
    "two Gaussians, any order": _made(
        "two Gaussians, any order",
        (0.0, 10.0),
        0.03,
        f"{_gauss(1)} + {_gauss(2)}",
        a1=(linear(0, 3), 1.2),
        m1=(linear(0, 10), 2.7),
        s1=(log(0.2, 3), 0.7),
        a2=(linear(0, 3), 0.7),
        m2=(linear(0, 10), 6.8),
        s2=(log(0.2, 3), 1.0),
    ),
    "three Gaussians": _made(
        "three Gaussians",
        (0.0, 10.0),
        0.03,
        f"{_gauss(1)} + {_gauss(2)} + {_gauss(3)} + o",
        a1=(linear(0, 3), 1.0),
        m1=(linear(0, 3.5), 2.0),
        s1=(log(0.3, 2), 0.6),
        a2=(linear(0, 3), 0.8),
        m2=(linear(3.5, 6.5), 4.8),
        s2=(log(0.3, 2), 0.9),
        a3=(linear(0, 3), 1.3),
        m3=(linear(6.5, 10), 7.7),
        s3=(log(0.3, 2), 0.7),
        o=(linear(-1, 1), 0.05),
    ),
    "two resonances": _made(
        "two resonances",
        (0.0, 10.0),
        0.03,
        "a / (1 + ((x - m) / w)**2) + b / (1 + ((x - n) / v)**2) + o + s * x",
        a=(linear(0, 4), 1.5),
        m=(linear(0, 5), 3.0),
        w=(log(0.1, 3), 0.5),
        b=(linear(0, 4), 1.0),
        n=(linear(5, 10), 7.0),
        v=(log(0.1, 3), 0.8),
        o=(linear(-1, 1), 0.2),
        s=(linear(-0.2, 0.2), 0.03),
    ),
    "hyperbola": _made(
        "hyperbola",
        (0.0, 10.0),
        1.5,
        "x / (1 / E + x / q) + c * x**n",
        E=(log(10, 10000), 400.0),
        q=(log(10, 1000), 180.0),
        c=(linear(-20, 20), -3.0),
        n=(linear(0.3, 3), 1.5),
    ),
    "two hyperbolas": _made(
        "two hyperbolas",
        (0.0, 10.0),
        0.5,
        "a * x / (k + x) + b * x / (l + x) + o",
        a=(log(1, 200), 40.0),
        k=(log(0.01, 1), 0.15),
        b=(log(1, 200), 60.0),
        l=(log(1, 100), 8.0),
        o=(linear(-10, 10), 1.0),
    ),
    "inhibition": _made(
        "inhibition",
        (0.05, 20.0),
        0.02,
        "v * x**h / (k**h + x**h + x**2 / i) + o",
        v=(log(0.1, 20), 3.0),
        k=(log(0.05, 20), 1.5),
        i=(log(0.5, 200), 12.0),
        h=(linear(0.5, 3), 1.4),
        o=(linear(-0.5, 0.5), 0.05),
    ),
    "product of powers": _made(
        "product of powers",
        (0.05, 5.0),
        0.02,
        "a * x**n * exp(-k * x) + o",
        a=(log(0.1, 50), 2.5),
        n=(linear(0.2, 4), 1.6),
        k=(log(0.1, 10), 1.1),
        o=(linear(-1, 1), 0.1),
    ),
    "rational": _made(
        "rational",
        (0.0, 6.0),
        0.03,
        "(a + b * x) / (1 + c * x + d * x**2) + o",
        a=(linear(-3, 3), 0.4),
        b=(linear(0, 10), 4.0),
        c=(linear(-0.9, 3), -0.5),
        d=(log(0.1, 5), 0.6),
        o=(linear(-1, 1), 0.2),
    ),
    "retention": _made(
        "retention",
        (-2.0, 4.0),
        0.004,
        "r + (s - r) / (1 + (a * 10**x)**n)**m",
        r=(linear(0, 0.2), 0.06),
        s=(linear(0.3, 0.6), 0.43),
        a=(log(0.001, 10), 0.08),
        n=(linear(1.05, 4), 1.8),
        m=(linear(0.05, 1), 0.4),
    ),
    "two steps": _made(
        "two steps",
        (0.0, 10.0),
        0.02,
        "a / (1 + exp(-k * (x - m))) + b / (1 + exp(-l * (x - n))) + o",
        a=(linear(0, 3), 1.0),
        k=(log(0.5, 20), 3.0),
        m=(linear(0, 5), 2.5),
        b=(linear(0, 3), 0.7),
        l=(log(0.5, 20), 2.0),
        n=(linear(5, 10), 6.5),
        o=(linear(-1, 1), 0.1),
    ),
    "growth and season": _made(
        "growth and season",
        (0.0, 10.0),
        0.05,
        "a * exp(-b * exp(-k * x)) + c * sin(2 * pi * f * x + p)",
        a=(log(0.5, 50), 6.0),
        b=(log(0.5, 50), 4.0),
        k=(log(0.05, 5), 0.5),
        c=(linear(0, 2), 0.4),
        f=(linear(0.3, 0.75), 0.5),
        p=(linear(-3.2, 3.2), 1.0),
    ),
    "pulse and peak": _made(
        "pulse and peak",
        (0.1, 10.0),
        0.02,
        "a * exp(-(ln(x / m) / s)**2) + b * exp(-((x - n) / v)**2) + o",
        a=(linear(0, 3), 1.1),
        m=(log(0.3, 4), 1.3),
        s=(log(0.1, 2), 0.5),
        b=(linear(0, 3), 0.8),
        n=(linear(4, 10), 6.0),
        v=(log(0.2, 3), 1.1),
        o=(linear(-1, 1), 0.1),
    ),
    "beat": _made(
        "beat",
        (0.0, 6.0),
        0.08,
        "a * sin(2 * pi * f * x + p) * exp(-((x - m) / w)**2) + o + s * x",
        a=(log(0.1, 10), 1.5),
        f=(linear(0.3, 3), 1.4),
        p=(linear(-3.2, 3.2), 0.4),
        m=(linear(0, 6), 3.0),
        w=(log(0.3, 5), 1.5),
        o=(linear(-2, 2), 0.2),
        s=(linear(-0.5, 0.5), 0.05),
    ),
}
