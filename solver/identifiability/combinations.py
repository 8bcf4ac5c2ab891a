"""Combinations of parameters: which the data determine, and which they leave open.

The singular values of the weighted derivatives, their columns brought to unit length, compare directions whatever the
units and ranges of the parameters (Belsley, Kuh and Welsch 1980, chapter 3). One that is 0 within the errors of the
derivatives belongs to a direction along which nothing measured changes.
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
    """

    singular_value: float
    components: dict[str, float]
    open: bool


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
    derivative_error
        Largest relative error of an active column.
    """

    combinations: tuple[Combination, ...]
    basis: FloatArray
    active: BoolArray
    determined: BoolArray
    influences: FloatArray
    derivative_error: float

    @property
    def leverage(self) -> FloatArray:
        """Diagonal of the hat matrix, shape (n,)."""
        return np.asarray(np.sum(self.basis * self.basis, axis=1))


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
    derivative_error = float((uncertain[active] / lengths[active]).max(initial=0.0))
    index = np.flatnonzero(active)
    found: list[Combination] = []
    basis = np.empty((len(weighted), 0))
    if index.size:
        left, singular, right = np.linalg.svd(weighted[:, index] / lengths[index], full_matrices=False)
        is_open = singular <= max(_EXACT, 3.0 * derivative_error) * singular[0]
        basis = left[:, ~is_open]
        for value, direction, opened in zip(singular, right, is_open, strict=True):
            components = _components([names[i] for i in index], direction, lengths[index], bool(opened))
            found.append(Combination(float(value), components, bool(opened)))
    found += [Combination(0.0, {names[i]: 1.0}, True) for i in np.flatnonzero(~active)]
    tied = {name for combination in found if combination.open for name in combination.components}
    determined = active & np.array([name not in tied for name in names])
    return Directions(tuple(found), basis, active, determined, lengths / longest, derivative_error)


def _components(names: list[str], direction: FloatArray, lengths: FloatArray, opened: bool) -> dict[str, float]:
    """Components of a direction given for columns of unit length, shape (d,).

    A parameter takes part in an open combination as soon as either form shows it: one of large influence moves little.
    """
    move = direction / lengths
    move = move / np.linalg.norm(move)
    move = move * np.sign(move[np.argmax(np.abs(move))])
    shown = (np.abs(move) >= _TAKES_PART) | (opened & (np.abs(direction) >= _TAKES_PART))
    return {name: float(m) for name, m, show in zip(names, move, shown, strict=True) if show}
