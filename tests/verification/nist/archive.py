"""Sixteen problems of the NIST archive, read from its files; bounds are a start value over a factor and times it."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["NAMES", "ArchiveSet", "archive_set"]

_PEAKS = "b1*exp(-b2*x) + b3*exp(-(x-b4)**2/b5**2) + b6*exp(-(x-b7)**2/b8**2)"
_DECAY = "exp(-b1*x)/(b2+b3*x)"
_YEAR = "b1+b2*cos(2*pi*x/12)+b3*sin(2*pi*x/12)"
_MODELS = {
    "Chwirut1": _DECAY,
    "Chwirut2": _DECAY,
    "Misra1b": "b1*(1-(1+b2*x/2)**(-2))",
    "DanWood": "b1*x**b2",
    "Roszman1": "b1-b2*x-atan(b3/(x-b4))/pi",
    "Kirby2": "(b1+b2*x+b3*x**2)/(1+b4*x+b5*x**2)",
    "Rat43": "b1/((1+exp(b2-b3*x))**(1/b4))",
    "Eckerle4": "(b1/b2)*exp(-0.5*((x-b3)/b2)**2)",
    "MGH10": "b1*exp(b2/(x+b3))",
    "MGH17": "b1+b2*exp(-x*b4)+b3*exp(-x*b5)",
    "Lanczos3": "b1*exp(-b2*x)+b3*exp(-b4*x)+b5*exp(-b6*x)",
    "Bennett5": "b1*(b2+x)**(-1/b3)",
    "Gauss1": _PEAKS,
    "Gauss3": _PEAKS,
    "Hahn1": "(b1+b2*x+b3*x**2+b4*x**3)/(1+b5*x+b6*x**2+b7*x**3)",
    "ENSO": f"{_YEAR}+b5*cos(2*pi*x/b4)+b6*sin(2*pi*x/b4)+b8*cos(2*pi*x/b7)+b9*sin(2*pi*x/b7)",
}

_TERMS = {
    "Lanczos3": (slice(0, 2), slice(2, 4), slice(4, 6)),
    "Gauss1": (slice(2, 5), slice(5, 8)),
    "Gauss3": (slice(2, 5), slice(5, 8)),
    "ENSO": (slice(3, 6), slice(6, 9)),
    "MGH17": (slice(1, 5, 2), slice(2, 5, 2)),
}
"""Parameters of terms that have the same form."""

NAMES = tuple(_MODELS)


@dataclass(frozen=True, slots=True)
class ArchiveSet:
    """One data set: both start values (2, d), certified values, standard deviations, each of shape (d,), and points."""

    name: str
    starts: FloatArray
    certified: FloatArray
    deviations: FloatArray
    residual_sum_of_squares: float
    x: FloatArray
    y: FloatArray

    def document(self, start: int = 2, factor: float = 10.0, scale: str = "linear", **changes: Any) -> dict[str, Any]:
        """As a problem file.

        With the scale ``log``, parameters whose start value is negative enter the formula with the other sign.
        ENSO's b8 has another sign than its start: its bounds are widened to it, and linear.
        """
        values, expression = self.starts[start - 1], _MODELS[self.name]
        bounds: dict[str, dict[str, Any]] = {}
        for name, value in zip((f"b{i + 1}" for i in range(values.size)), values.tolist(), strict=True):
            linear = scale == "linear" or (self.name, name) == ("ENSO", "b8")
            if value < 0.0 and not linear:
                expression, value = re.sub(rf"\b{name}\b", f"(-{name})", expression), -value
            lower, upper = sorted((value / factor, value * factor))
            bounds[name] = {"lower": lower, "upper": upper, "scale": "linear" if linear else scale}
        if self.name == "ENSO":
            bounds["b8"]["upper"] = 3.0
        return {
            "name": self.name,
            "forward_model": {"kind": "formula", "series": {"y": expression}},
            "parameters": bounds,
            "observations": [{"series": "y", "points": {"x": self.x.tolist(), "y": self.y.tolist()}}],
            "method": {"kind": "particle_swarm", "polish": True},
            "stopping": {"max_evaluations": 1000},
            "seed": 1,
        } | changes

    def digits(self, parameters: FloatArray) -> float:
        """Correct digits of the worst parameter; terms of the same form may change places."""
        terms = _TERMS.get(self.name, ())
        orders = [list(range(len(parameters)))]
        for chosen in permutations(terms):
            order = orders[0].copy()
            for place, term in zip(terms, chosen, strict=True):
                order[place] = range(len(parameters))[term]
            orders.append(order)
        worst = min(float(np.abs(parameters[order] / self.certified - 1.0).max()) for order in orders)
        return -math.log10(worst + 1e-16)


@cache
def archive_set(name: str) -> ArchiveSet:
    """Read a file of the archive."""
    lines = (Path(__file__).parent / "strd" / f"{name}.dat").read_text(encoding="ascii").splitlines()
    rows = [line.split("=")[1].split() for line in lines[:60] if re.match(r"\s*b\d\s*=", line)]
    table = np.array(rows, dtype=np.float64)
    (sum_of_squares,) = (line.split(":")[1] for line in lines if line.startswith("Residual Sum of Squares"))
    first = max(i for i, line in enumerate(lines) if line.startswith("Data:")) + 1
    points = np.array([line.split() for line in lines[first:] if line.strip()], dtype=np.float64)
    return ArchiveSet(name, table[:, :2].T, table[:, 2], table[:, 3], float(sum_of_squares), points[:, 1], points[:, 0])
