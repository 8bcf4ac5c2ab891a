"""Where to evaluate for derivatives of fourth order at an optimum, and the derivatives with their errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.search.space import SearchSpace

__all__ = ["DifferenceDesign", "derivative", "join_moves", "plan_differences"]

_CENTRAL = (-1.0, -0.5, 0.5, 1.0)
_ABOVE = (0.25, 0.5, 0.75, 1.0)
_WHOLE = (-2.0, -1.0, 1.0, 2.0)  # units of a parameter that takes whole numbers
_WHOLE_ABOVE = (1.0, 2.0, 3.0, 4.0)
_PLACES = 5
_FOURTH_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0])


@dataclass(frozen=True, slots=True)
class DifferenceDesign:
    """Where to evaluate for the sensitivities at an optimum.

    Parameters
    ----------
    optimum
        Shape (d,), natural values.
    positions
        Shape (n, d), natural values; the first is the optimum.
    parameter
        Which parameter each position moves, shape (n,); -1 for the optimum.
    offset
        By how much, shape (n,), in parts of the range between the bounds in search coordinates.
    """

    optimum: FloatArray
    positions: FloatArray
    parameter: IntArray
    offset: FloatArray

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, from which :meth:`from_json` restores exactly."""
        return {
            "optimum": self.optimum.tolist(),
            "positions": self.positions.tolist(),
            "parameter": self.parameter.tolist(),
            "offset": self.offset.tolist(),
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> DifferenceDesign:
        """Restore from :meth:`to_json`."""
        return cls(
            np.array(data["optimum"], dtype=np.float64),
            np.array(data["positions"], dtype=np.float64),
            np.array(data["parameter"], dtype=np.int64),
            np.array(data["offset"], dtype=np.float64),
        )


def plan_differences(space: SearchSpace, optimum: FloatArray, step: float) -> DifferenceDesign:
    """Plan the optimum and four places along each parameter, 4 d + 1 at most.

    Central places where both sides are inside the bounds and feasible, otherwise all on one side. A parameter that
    takes whole numbers is moved by whole units, whatever the step.

    Parameters
    ----------
    optimum
        Shape (d,), natural values, inside the bounds.
    step
        Largest offset in parts of the range in search coordinates.
    """
    optimum = np.asarray(optimum, dtype=np.float64)
    return join_moves(optimum, [(index, step) for index in range(space.dimension)], space)


def join_moves(optimum: FloatArray, moves: list[tuple[int, float]], space: SearchSpace) -> DifferenceDesign:
    """Plan the optimum and four places for each pair of a parameter and its step."""
    positions, parameter, offset = [optimum], [-1], [0.0]
    for index, step in moves:
        offsets, points = _places(space, optimum, index, step)
        positions += points
        offset += offsets
        parameter += [index] * len(points)
    return DifferenceDesign(optimum, np.array(positions), np.array(parameter, dtype=np.int64), np.array(offset))


def _places(space: SearchSpace, optimum: FloatArray, index: int, step: float) -> tuple[list[float], list[FloatArray]]:
    low, span = space.search_lower, space.search_upper - space.search_lower
    centre = (space.to_search(optimum) - low) / span
    central, above = _CENTRAL, _ABOVE
    if space.integer[index]:
        central, above, step = _WHOLE, _WHOLE_ABOVE, 1.0 / float(span[index])
    best: tuple[list[float], list[FloatArray]] = ([], [])
    for pattern in (central, above, tuple(-v for v in above)):
        offsets, points = [], []
        for part in pattern:
            unit = centre.copy()
            unit[index] += part * step
            point = optimum.copy()  # the others stay as they are, to the last digit
            point[index] = space.to_natural(low + unit * span)[index]
            inside = space.lower[index] <= point[index] <= space.upper[index] and 0.0 <= unit[index] <= 1.0
            if inside and space.feasible(point):
                offsets.append(part * step)
                points.append(point)
        if len(points) > len(best[0]):
            best = offsets, points
        if len(points) == len(pattern):  # no other side has more
            break
    return best


def derivative(offsets: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Derivative of values, shape (k, m), at offset 0, and an estimate of its error, both of shape (m,).

    Five evenly spaced places tell the roughness of a forward model from its curvature: their fourth difference is
    small for a smooth one, and sqrt(70) times the roughness otherwise. The truncation error is that of the two outer
    places squared, relative to the derivative. With fewer places the difference between both formulas counts in full.

    Parameters
    ----------
    offsets
        Shape (k,); the first is 0, the last one of the outermost.
    """
    weights = _weights(offsets)
    fine = weights @ (values - values[0])
    outer = [0, 1, len(offsets) - 1]
    gap = np.abs(fine - _weights(offsets[outer]) @ (values[outer] - values[0]))
    if len(offsets) < _PLACES:
        return fine, gap
    order = np.argsort(offsets)
    roughness = np.abs(_FOURTH_DIFFERENCE @ values[order]) / np.linalg.norm(_FOURTH_DIFFERENCE)
    truncation = gap * min(float(np.linalg.norm(gap)) / max(float(np.linalg.norm(fine)), 1e-300), 1.0)
    return fine, roughness * np.linalg.norm(weights) + truncation


def _weights(offsets: FloatArray) -> FloatArray:
    """Weights of values at ``offsets``, shape (k,), in the derivative at 0; exact for polynomials below order k."""
    scale = np.abs(offsets).max()
    system = np.vander(offsets / scale, increasing=True).T
    target = np.zeros(len(offsets))
    target[1] = 1.0
    return np.asarray(np.linalg.solve(system, target) / scale)
