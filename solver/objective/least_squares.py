"""Misfits f'_g and objective f.

    f(x) = sum_g w_g f'_g(x)                                                (1)
    f'_g(x) = (1/m) sum_h w_h (y_calc[h, g](x) - y_meas[h, g])^2            (2)

The residual y_calc - y_meas may be a distance from the calculated curve (:mod:`geoswarm.solver.residuals`). A series
with a robust loss has c^2 rho(w_h r^2 / c^2) for its square.

Always minimised. Source: Meier et al. (2008), equations (1) and (2).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.errors import BadOutputError, NotFiniteError
from geoswarm.solver.residuals import CurveScale, Loss, residuals_of

__all__ = ["LEAST_SLOPE", "LeastSquares", "ObservedSeries", "PseudoReadings"]

LEAST_SLOPE = 0.05
"""Smallest mean slope of psi: below it nearly all readings lie beyond the scale, and no linearisation holds."""


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
    loss
        Robust loss; None for squares.
    along
        Scales of x and y where residuals are distances from the calculated curve; None for differences of y.
    """

    series: str
    x: FloatArray
    y: FloatArray
    point_weights: FloatArray
    weight: float
    loss: Loss | None = None
    along: CurveScale | None = None

    def residuals(self, calculated: npt.ArrayLike) -> FloatArray:
        """Return y_calc - y_meas, or the signed distances of the readings from the calculated curve, in units of y.

        Parameters
        ----------
        calculated
            Values at the readings, shape (..., m), base units.
        """
        return residuals_of(self.x, self.y, np.asarray(calculated), self.along)


def counted_in_order(x: FloatArray, point_weights: FloatArray) -> IntArray:
    """Places of the points that count, in the order of x; those at equal x stay in theirs."""
    used = np.flatnonzero(point_weights > 0)
    return np.asarray(used[np.argsort(x[used], kind="stable")])


@dataclass(frozen=True, slots=True)
class PseudoReadings:
    """What a robust fit is at its optimum: least squares of pseudo residuals psi / mean psi' (Huber 1981, section 7.6).

    Their normal equations are those of the loss, their common weight w_g mean psi' gives the curvature of the
    objective, and their variance that of the robust estimate (the sandwich with errors that do not depend on x). Of a
    series without a loss they are its residuals.

    Parameters
    ----------
    observed
        The series, with w_g mean psi' for w_g.
    residuals
        Pseudo residuals by series, shape (m_g,), base units.
    slopes
        mean psi' by series; 1 without a loss.
    unevenness
        var psi' / (mean psi')^2 by series; 0 without a loss. Huber's correction for few readings is
        1 + unevenness (parameters / readings).
    """

    observed: tuple[ObservedSeries, ...]
    residuals: dict[str, FloatArray]
    slopes: dict[str, float]
    unevenness: dict[str, float]


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
        """Return residuals of all series in a row whose squared length is the objective.

        sqrt(w_g w_h / m) r, of a series with a loss sqrt(w_g / m) sign(z) c sqrt(rho(z^2)). Responses
        of shape (k, m_g) give rows of shape (k, n).
        """
        return self.with_losses(self.plain_residuals(responses))

    def plain_residuals(self, responses: Mapping[str, FloatArray]) -> FloatArray:
        """Return sqrt(w_g w_h / m) r of all series in a row, whatever their loss."""
        return np.concatenate(
            [np.sqrt(o.weight * o.point_weights / o.y.size) * o.residuals(responses[o.series]) for o in self.observed],
            axis=-1,
        )

    @property
    def robust(self) -> bool:
        """Whether a series has a loss."""
        return any(o.loss is not None for o in self.observed)

    def with_losses(self, plain: FloatArray) -> FloatArray:
        """Return :meth:`weighted_residuals` from :meth:`plain_residuals`, shape (..., n)."""
        if not self.robust:
            return plain
        found = plain.copy()
        for o, own, scale in self._scaled():
            found[..., own] = scale * o.root(plain[..., own] / scale)
        return found

    def loss_slopes(self, plain: FloatArray) -> FloatArray:
        """Return the derivative of each of :meth:`weighted_residuals` by the plain one, shape (n,)."""
        found = np.ones_like(plain)
        for o, own, scale in self._scaled():
            found[own] = o.root_slope(plain[own] / scale)
        return found

    def _scaled(self) -> Iterator[tuple[Loss, slice, float]]:
        """Losses, the places of their readings, and the scale of these as weighted residuals."""
        start = 0
        for o in self.observed:
            own = slice(start, start + o.y.size)
            start += o.y.size
            if o.loss is not None and o.weight > 0:
                yield o.loss, own, float(np.sqrt(o.weight / o.y.size)) * o.loss.scale

    def point_losses(self, responses: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """Return the weights rho'(z^2) of the readings of every series with a loss, shape (m_g,)."""
        return {o.series: o.loss.weight(_z(o, responses)) for o in self.observed if o.loss is not None}

    def pseudo_readings(self, responses: Mapping[str, FloatArray]) -> PseudoReadings:
        """Return the least squares that a robust fit is at its optimum."""
        observed, residuals, slopes, unevenness = [], {}, {}, {}
        for o in self.observed:
            found, slope, uneven = o.residuals(responses[o.series]), 1.0, 0.0
            if o.loss is not None:
                z = _z(o, responses)
                own = o.loss.slope(z)[o.point_weights > 0]
                slope = max(float(own.mean()), LEAST_SLOPE)
                uneven = float(own.var()) / slope**2
                found = found * o.loss.weight(z) / slope
            observed.append(o if o.loss is None else replace(o, weight=o.weight * slope))
            residuals[o.series], slopes[o.series], unevenness[o.series] = found, slope, uneven
        return PseudoReadings(tuple(observed), residuals, slopes, unevenness)

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
    residuals = observed.residuals(calculated)
    # no BLAS: its summation order may depend on the number of threads
    with np.errstate(over="ignore"):
        if observed.loss is None:
            misfit = float(np.sum(observed.point_weights * residuals * residuals)) / residuals.size
        else:
            z = np.sqrt(observed.point_weights) * (residuals / observed.loss.scale)
            misfit = observed.loss.scale**2 * float(np.sum(observed.loss.rho(z))) / residuals.size
    if not np.isfinite(misfit):
        raise NotFiniteError(
            f"the misfit of series '{observed.series}' is {misfit}: its residuals are too large to be squared"
        )
    return misfit


def _z(observed: ObservedSeries, responses: Mapping[str, FloatArray]) -> FloatArray:
    """Residuals in scales of the loss, graded by w_h."""
    assert observed.loss is not None
    residuals = observed.residuals(responses[observed.series])
    return np.asarray(np.sqrt(observed.point_weights) * (residuals / observed.loss.scale))
