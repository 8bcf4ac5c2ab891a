"""Combinations of parameters: which the data determine, and which they leave open.

The singular values of the weighted derivatives, their columns brought to unit length, compare directions whatever the
units and ranges of the parameters (Belsley, Kuh and Welsch 1980, chapter 3). One that is 0 within the errors of the
derivatives belongs to a direction along which nothing measured changes, if those errors are small themselves: what is
left open needs a bound on what it changes. Where the errors are too large for one, nothing can be told.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray

__all__ = ["Combination", "Directions", "find_directions"]

_EXACT = 1e-7  # relative size of a singular value that differences cannot tell from 0
_TAKES_PART = 0.05  # component from which a parameter belongs to a combination
_INFLUENCE = 1e-9  # of the longest column
_ROUNDING = 1e-11  # of the measured values
_ZERO = 1e-5  # relative size up to which the error of a singular value that is 0 does not matter
_BELOW_NOISE = 1.0  # change through the whole range, in noise of one reading, that would not be seen


@dataclass(frozen=True, slots=True)
class Combination:
    """A direction in the space of the parameters.

    Parameters
    ----------
    singular_value
        Of the weighted derivatives with columns of unit length: 0 for a direction that changes nothing measured.
    components
        Move of each parameter, parts of its range in search coordinates, unit length; small ones left out.
    open
        True when the data leave the combination undetermined.
    change
        Bound on what a move along it through the whole range of a parameter changes: length of the weighted residuals.
    exact
        That bound is 0 but for rounding and differences.
    """

    singular_value: float
    components: dict[str, float]
    open: bool
    change: float = np.inf
    exact: bool = True

    def unclear(self, noise: float) -> bool:
        """Whether it looks open only because its derivatives are uncertain, given the noise of a weighted reading."""
        return self.open and not self.exact and not self.change <= _BELOW_NOISE * noise


@dataclass(frozen=True, slots=True)
class Directions:
    """What the derivatives of n measured values to d parameters span.

    Parameters
    ----------
    combinations
        All d directions, the best determined first.
    basis
        Orthonormal basis of what the determined directions move, shape (n, rank).
    active
        Whether any measured value depends on a parameter, shape (d,).
    determined
        Active, and in no open combination, shape (d,).
    influences
        Length of each column over the longest, shape (d,).
    derivative_errors
        Relative error of each column, shape (d,).
    """

    combinations: tuple[Combination, ...]
    basis: FloatArray
    active: BoolArray
    determined: BoolArray
    influences: FloatArray
    derivative_errors: FloatArray

    @property
    def derivative_error(self) -> float:
        """Largest relative error of an active column."""
        return float(self.derivative_errors[self.active].max(initial=0.0))

    @property
    def leverage(self) -> FloatArray:
        """Diagonal of the hat matrix, shape (n,)."""
        return np.asarray(np.sum(self.basis * self.basis, axis=1))

    def inverse(self, weighted: FloatArray) -> FloatArray:
        """Pseudo-inverse, shape (d, n), of the weighted derivatives over what the determined directions move."""
        return np.asarray(np.linalg.pinv(self.basis.T @ weighted) @ self.basis.T)

    def unclear(self, names: tuple[str, ...], noise: float) -> tuple[str, ...]:
        """Parameters in directions that only look open, in the order of ``names``; see :meth:`Combination.unclear`."""
        involved = {name for c in self.combinations if c.unclear(noise) for name in c.components}
        return tuple(name for name in names if name in involved)


def find_directions(names: tuple[str, ...], weighted: FloatArray, errors: FloatArray, values: FloatArray) -> Directions:
    """Split the space of the parameters into determined and open directions.

    Parameters
    ----------
    weighted, errors
        Weighted derivatives per range and their errors, shape (n, d).
    values
        Weighted measured values, shape (n,): the scale of rounding errors.
    """
    lengths = np.linalg.norm(weighted, axis=0)
    longest = max(float(lengths.max()), 1e-300)
    uncertain = np.linalg.norm(errors, axis=0)
    floor = max(_INFLUENCE * longest, _ROUNDING * float(np.linalg.norm(values)))
    active = lengths > np.maximum(floor, 3.0 * uncertain)
    relative = uncertain / np.maximum(lengths, 1e-300)
    index = np.flatnonzero(active)
    found: list[Combination] = []
    basis = np.empty((len(weighted), 0))
    if index.size:
        left, singular, right = np.linalg.svd(weighted[:, index] / lengths[index], full_matrices=False)
        # Along a direction that changes nothing, the derivatives show no more than their own errors.
        doubt = 3.0 * np.linalg.norm(relative[index] * right, axis=1)
        is_open = singular <= np.maximum(_EXACT * singular[0], doubt)
        basis = left[:, ~is_open]
        for value, direction, opened, most in zip(singular, right, is_open, doubt, strict=True):
            components = _components([names[i] for i in index], direction, lengths[index], bool(opened))
            move = direction / lengths[index]
            largest = float(value) + float(most)
            change = largest / float(np.abs(move).max())
            found.append(
                Combination(float(value), components, bool(opened), change, bool(largest <= _ZERO * singular[0]))
            )
    for i in np.flatnonzero(~active):
        change = float(lengths[i] + 3.0 * uncertain[i])
        found.append(Combination(0.0, {names[i]: 1.0}, True, change, change <= floor))
    tied = {name for combination in found if combination.open for name in combination.components}
    determined = active & np.array([name not in tied for name in names])
    return Directions(tuple(found), basis, active, determined, lengths / longest, relative)


def _components(names: list[str], direction: FloatArray, lengths: FloatArray, opened: bool) -> dict[str, float]:
    """Components of a direction given for columns of unit length, shape (d,).

    A parameter takes part in an open combination as soon as either form shows it: one of large influence moves little.
    """
    move = direction / lengths
    move = move / np.linalg.norm(move)
    move = move * np.sign(move[np.argmax(np.abs(move))])
    shown = (np.abs(move) >= _TAKES_PART) | (opened & (np.abs(direction) >= _TAKES_PART))
    return {name: float(m) for name, m, show in zip(names, move, shown, strict=True) if show}
