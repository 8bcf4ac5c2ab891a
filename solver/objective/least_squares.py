"""Misfits f'_g and objective f.

    f(x) = sum_g w_g f'_g(x)                                                (1)
    f'_g(x) = (1/m) sum_h w_h (y_calc[h, g](x) - y_meas[h, g])^2            (2)

Always minimised. Source: Meier et al. (2008), equations (1) and (2).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import BadOutputError, NotFiniteError

__all__ = ["LeastSquares", "ObservedSeries"]


@dataclass(frozen=True, slots=True)
class ObservedSeries:
    """Measured points of one series in base units.

    Parameters
    ----------
    series
        Name of the series.
    x, y
        Measured points, shape (m,).
    point_weights
        w_h, shape (m,).
    weight
        w_g.
    """

    series: str
    x: FloatArray
    y: FloatArray
    point_weights: FloatArray
    weight: float


class LeastSquares:
    """Objective over the observed series; responses are given at the observed points."""

    def __init__(self, observed: Sequence[ObservedSeries]) -> None:
        self.observed = tuple(observed)

    def responses(self, found: Mapping[str, npt.ArrayLike]) -> dict[str, FloatArray]:
        """Return what a forward model answered for the observed series, in arrays that it cannot change any more.

        Parameters
        ----------
        found
            Calculated values of each series at its observed points, shape (m_g,), base units.

        Raises
        ------
        BadOutputError
            When a series is missing, complex, or has another shape than the observation.
        NotFiniteError
            When a value is NaN or infinite; the message names series and point.
        """
        return {observed.series: _checked(observed, found) for observed in self.observed}

    def misfits(self, responses: Mapping[str, FloatArray]) -> dict[str, float]:
        """Return f'_g of every series, in (base unit of the series)^2, from :meth:`responses`.

        Raises
        ------
        NotFiniteError
            When the residuals are too large to be squared.
        """
        return {observed.series: _misfit(observed, responses[observed.series]) for observed in self.observed}

    def weighted_residuals(self, responses: Mapping[str, FloatArray]) -> FloatArray:
        """Return sqrt(w_g w_h / m) (y_calc - y_meas) of all series in a row: its squared length is the objective."""
        return np.concatenate(
            [
                np.sqrt(o.weight * o.point_weights / o.y.size) * (np.asarray(responses[o.series]) - o.y)
                for o in self.observed
            ]
        )

    def value(self, misfits: Mapping[str, float]) -> float:
        """Return the objective f from the misfits."""
        return sum(observed.weight * misfits[observed.series] for observed in self.observed)


def _checked(observed: ObservedSeries, found: Mapping[str, npt.ArrayLike]) -> FloatArray:
    name = observed.series
    if name not in found:
        raise BadOutputError(f"series '{name}' is missing in the response; it has {', '.join(sorted(found))}")
    if np.iscomplexobj(found[name]):
        raise BadOutputError(f"series '{name}' is complex; real numbers are needed")
    calculated = np.array(found[name], dtype=np.float64)
    if calculated.shape != observed.y.shape:
        raise BadOutputError(
            f"series '{name}' has shape {calculated.shape}, but {observed.y.size} points were asked for"
        )
    finite = np.isfinite(calculated)
    if not finite.all():
        first = int(np.argmin(finite))
        raise NotFiniteError(
            f"series '{name}' is {calculated[first]} at point {first + 1} of {finite.size} (x = {observed.x[first]:g})"
        )
    return calculated


def _misfit(observed: ObservedSeries, calculated: FloatArray) -> float:
    residuals = calculated - observed.y
    # no BLAS: its summation order may depend on the number of threads
    with np.errstate(over="ignore"):
        misfit = float(np.sum(observed.point_weights * residuals * residuals)) / residuals.size
    if not np.isfinite(misfit):
        raise NotFiniteError(
            f"the misfit of series '{observed.series}' is {misfit}: its residuals are too large to be squared"
        )
    return misfit
