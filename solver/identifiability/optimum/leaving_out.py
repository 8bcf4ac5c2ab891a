"""The optimum without each of several tests: which of them pulls, and how far the estimates of whole tests scatter.

Tests of specimens of one soil differ by more than the scatter of their readings, and a model that misses them all a
little misses each in its own way. Then a test counts as one piece of information, however many readings it has. With
the derivatives J_g and residuals r_g of test g, in an orthonormal basis of the derivatives of all, the minimum of the
linearised objective without it is at

    c_g = (I - J_g' J_g)^-1 J_g' r_g

from the optimum: no run is needed. The delete-one jackknife over G tests (Quenouille; Efron 1982, chapter 3) gives the
variance (G - 1)/G sum_g (c_g - mean c)^2, with Student's t of G - 1 degrees of freedom; it is the cluster-robust
estimate CR3 (Bell and McCaffrey 2002, Survey Methodology 28, 169-181).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import stdtrit

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.methods.jackknife import FEWEST_TESTS

__all__ = ["WithoutTests", "leave_tests_out"]

_ALONE = 1e-6  # of a direction, what the other tests say of it
_SEEN = 1e-9  # of a move along a direction that only one test determines


@dataclass(frozen=True, slots=True)
class WithoutTests:
    """Where the minimum lies without each of G tests.

    Parameters
    ----------
    names, tests
        Of the parameters and of the tests.
    level
        Of the intervals.
    moves
        Parts of the range from the optimum, shape (G, d); nan where the other tests do not determine a parameter.
    half_widths
        Of the intervals between tests, parts of the range, shape (d,); nan where one test alone determines a parameter.
    optimum
        Natural values with all tests, shape (d,).
    values, intervals
        Moves and intervals as natural values, shapes (G, d) and (d, 2).
    fitted
        By forward runs, not by linearisation.
    notes
        What to know of the fits, in sentences.
    linear_moves
        Moves by linearisation, where ``moves`` are fitted; None: ``moves`` themselves.
    """

    names: tuple[str, ...]
    tests: tuple[str, ...]
    level: float
    moves: FloatArray
    half_widths: FloatArray
    optimum: FloatArray
    values: FloatArray
    intervals: FloatArray
    fitted: bool = False
    notes: tuple[str, ...] = ()
    linear_moves: FloatArray | None = None

    @classmethod
    def of(
        cls,
        names: tuple[str, ...],
        tests: tuple[str, ...],
        moves: FloatArray,
        level: float,
        natural: Callable[[FloatArray], FloatArray],
        *,
        fitted: bool = False,
        notes: tuple[str, ...] = (),
    ) -> WithoutTests:
        """From the moves alone; ``natural``: natural values (k, d) of moves from the optimum (k, d)."""
        count = len(tests)
        about = moves - moves.mean(axis=0)
        deviations = np.sqrt((count - 1.0) / count * np.sum(about**2, axis=0))
        half = float(stdtrit(count - 1.0, 0.5 + level / 2.0)) * deviations
        low, optimum, high = natural(np.stack([-half, np.zeros_like(half), half]))
        ends = np.stack([low, high], axis=-1)
        return cls(names, tests, level, moves, half, optimum, natural(moves), ends, fitted, notes)

    def pulling(self, name: str) -> str | None:
        """The test without which a parameter moves farthest; None where that is not known."""
        moved = np.abs(self.moves[:, self.names.index(name)])
        return None if np.isnan(moved).all() else self.tests[int(np.nanargmax(moved))]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; None for nan."""
        rows = {
            name: {
                "value": value,
                "values": {test: _known(value) for test, value in zip(self.tests, column.tolist(), strict=True)},
                "interval": ends.tolist() if np.isfinite(ends).all() else None,
                "pulls": self.pulling(name),
            }
            for name, value, column, ends in zip(
                self.names, self.optimum.tolist(), self.values.T, self.intervals, strict=True
            )
        }
        return {"tests": list(self.tests), "parameters": rows}


def leave_tests_out(
    names: tuple[str, ...],
    tests: Mapping[str, IntArray],
    basis: FloatArray,
    residuals: FloatArray,
    inverse: FloatArray,
    level: float,
    natural: Callable[[FloatArray], FloatArray],
) -> WithoutTests | None:
    """Leave out one test at a time; None with fewer than three tests.

    Parameters
    ----------
    names
        Of the parameters.
    tests
        Places of the readings of each test among all, by its name.
    basis
        Orthonormal basis of the weighted derivatives, shape (n, r).
    residuals
        Weighted, shape (n,).
    inverse
        What estimates take from weighted readings, shape (d, n).
    level
        Of the intervals.
    natural
        Natural values (k, d) of moves from the optimum (k, d), parts of the range.
    """
    if len(tests) < FEWEST_TESTS:
        return None
    from_basis = inverse @ basis
    moves = np.array([_without(basis[rows], residuals[rows], from_basis) for rows in tests.values()])
    return WithoutTests.of(names, tuple(tests), moves, level, natural)


def _without(rows: FloatArray, residuals: FloatArray, from_basis: FloatArray) -> FloatArray:
    """Move of the minimum without some readings, shape (d,)."""
    shares, directions = np.linalg.eigh(rows.T @ rows)  # of what is known along each direction
    left = 1.0 - shares
    known = left > _ALONE
    along = directions.T @ (rows.T @ residuals)
    move = from_basis @ (directions @ np.where(known, along / np.where(known, left, 1.0), 0.0))
    unknown = np.linalg.norm(from_basis @ directions[:, ~known], axis=1)
    return np.asarray(np.where(unknown > _SEEN * np.linalg.norm(from_basis, axis=1), np.nan, move))


def _known(value: float) -> float | None:
    return value if np.isfinite(value) else None
