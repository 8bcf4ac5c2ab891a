"""What the data determine at an optimum: the result of a linearisation, and what its intervals rest on."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.identifiability.noise import Noise
from geoswarm.solver.identifiability.optimum.combinations import Combination
from geoswarm.solver.identifiability.optimum.leaving_out import WithoutTests
from geoswarm.solver.identifiability.residuals.dependence import ALLOWANCES, Dependence
from geoswarm.solver.identifiability.residuals.lack_of_fit import FitVerdict
from geoswarm.solver.words import listed, per_cent

__all__ = ["BENDS", "CORRECTED", "IntervalBasis", "LinearModel", "Linearisation"]

IntervalBasis: TypeAlias = Literal[
    "linearised", "correlated", "uneven", "possible", "stated", "tests", "moved", "profile"
]
"""What an interval rests on: the usual covariance, or with an allowance for correlated residuals, such of uneven size,
a correlation that so few readings cannot exclude, or one that the problem states; the scatter between tests; ends moved
as one run at each shows; or the profile objective."""

BENDS = 0.1
"""Part by which an end of an interval by likelihood differs from the linearised one where a model is nonlinear."""
CORRECTED = 0.2
"""The largest such part for which one run at each end of the linearised interval is enough to move it."""

_FAR, _MISPLACED = 0.2, 1.0  # standard errors
_WIDER = 1.05  # the least factor that is said
_UNKNOWN, _ANY = 1.0 / 3.0, 1.0  # relative errors from which a derivative may be 0, and from which it may be anything
_BASES: dict[IntervalBasis, str] = {
    "linearised": "",
    "correlated": "widened by a factor of {:.2g} for correlated residuals",
    "uneven": "widened by a factor of {:.2g} for residuals of uneven size",
    "possible": "widened by a factor of {:.2g} for a correlation that so few readings cannot exclude",
    "stated": "widened by a factor of {:.2g} for correlated noise, as stated",
    "tests": "widened by a factor of {:.2g} for tests that differ",
    "moved": "by likelihood from one run at each end",
    "profile": "by likelihood",
}


@dataclass(frozen=True, slots=True)
class LinearModel:
    """The linearised model.

    Parameters
    ----------
    weighted, residuals
        Weighted derivatives per range, shape (n, d), and residuals, shape (n,).
    inverse
        What estimates take from weighted readings, shape (d, n).
    variances
        Of weighted readings with independent noise, shape (n,); nan where the noise is neither known nor estimated.
    """

    weighted: FloatArray
    residuals: FloatArray
    inverse: FloatArray
    variances: FloatArray

    @property
    def reachable(self) -> float:
        """Share of the sum of squares that a step to the minimum of the linearised objective takes off, 0 to 1."""
        total = float(self.residuals @ self.residuals)
        if total == 0.0:
            return 0.0
        left = self.residuals - self.weighted @ np.linalg.lstsq(self.weighted, self.residuals)[0]
        return 1.0 - float(left @ left) / total


@dataclass(frozen=True, slots=True)
class Linearisation:
    """What the data determine at the optimum, linearised.

    Parameters
    ----------
    names, scales
        Of the d free parameters.
    optimum
        Shape (d,), natural values.
    combinations
        All d directions, the best determined first.
    without_influence
        Parameters on which no measured value depends there, or less than its noise through the whole range.
    unclear
        Parameters whose derivatives are too uncertain to tell whether and how they act; with any of these, no parameter
        has an interval.
    held
        Parameters at a bound beyond which the data pull, with ``lower`` or ``upper``: there the minimum lies on it.
    influences
        Length of the weighted derivative of each parameter over the longest one, shape (d,).
    noise
        Known or estimated; None when it is neither (no more points than parameters).
    degrees_of_freedom
        n - d, n measured points.
    covariance
        Of search coordinates under independent noise, shape (d, d); nan in rows and columns of parameters without a
        standard error. None without noise.
    standard_errors
        Square roots of its diagonal, shape (d,), natural values (delta method on a log scale); nan where the data do
        not limit the parameter.
    intervals
        Shape (d, 2), natural values, nan where there is none; ``bases`` says what each rests on. By linearisation:
        Student's t, normal with known noise; on a log scale symmetric in the logarithm.
    unit_widths
        Width of the intervals in parts of the range, shape (d,).
    level
        Of the intervals.
    derivative_error
        Largest estimated relative error of a derivative column on which readings depend.
    derivative_errors
        That of each column, shape (d,).
    distance
        How far, in standard errors, a Gauss-Newton step inside the bounds would move each parameter, shape (d,); nan
        where there is no standard error. Far from 0, ``optimum`` is not the minimum yet: polish it first.
    profile_increase
        How much the profile objective of each parameter rises to the ends of its interval, shape (d,); for a parameter
        without one, by the mean noise variance of the weighted points. nan without noise.
    fit
        Whether the model describes the data; where it does not, only intervals that count whole tests hold.
    model
        The linearised model itself.
    linear_half_widths
        Of the intervals by linearisation, parts of the range, shape (d,); nan where there is none.
    widening
        How many times wider an allowance for dependence makes the intervals by linearisation, shape (d,); 1 without.
    bases
        What each interval rests on.
    bending
        Relative difference of an end of each interval by likelihood from the linearised one, the larger of both, shape
        (d,); nan where this was not calculated (:mod:`geoswarm.solver.identifiability.optimum.bending`).
    dependence
        Series whose noise is or may be correlated, or is of uneven size; intervals allow for it, standard errors do
        not.
    to_rounding
        The readings are met to rounding and no error is stated. The standard errors are rounding errors then, so the
        distance from the minimum counts as 0 and nonlinearity within the intervals as none.
    without
        Where the minimum lies without each of the tests; None with fewer than three.
    between_tests
        Parameters whose intervals by linearisation rest on the scatter between tests.
    """

    names: tuple[str, ...]
    scales: tuple[str, ...]
    optimum: FloatArray
    combinations: tuple[Combination, ...]
    without_influence: tuple[str, ...]
    unclear: tuple[str, ...]
    held: tuple[tuple[str, str], ...]
    influences: FloatArray
    noise: Noise | None
    degrees_of_freedom: int
    covariance: FloatArray | None
    standard_errors: FloatArray
    intervals: FloatArray
    unit_widths: FloatArray
    level: float
    derivative_error: float
    derivative_errors: FloatArray
    distance: FloatArray
    profile_increase: FloatArray
    fit: FitVerdict
    model: LinearModel
    linear_half_widths: FloatArray
    widening: FloatArray
    bases: tuple[IntervalBasis, ...]
    bending: FloatArray
    dependence: tuple[Dependence, ...] = ()
    to_rounding: bool = False
    without: WithoutTests | None = None
    between_tests: tuple[str, ...] = ()

    @property
    def departures(self) -> tuple[Dependence, ...]:
        """What was found or stated of the noise, without what so few readings cannot exclude."""
        return tuple(one for one in self.dependence if one.kind != "possible")

    @property
    def widest(self) -> float:
        """The largest factor by which an interval is wider than the usual one; 1 without."""
        return float(np.max(self.widening, where=np.isfinite(self.widening), initial=1.0))

    @property
    def at_optimum(self) -> bool:
        """Whether no parameter is more than a fifth of its standard error away from the nearest minimum.

        False where no distance is known.
        """
        return bool(np.isfinite(self.distance).any()) and not bool((self.distance > _FAR).any())

    @property
    def far(self) -> float | None:
        """The largest distance from the minimum in standard errors; None where none is known."""
        known = self.distance[np.isfinite(self.distance)]
        return float(known.max()) if known.size else None

    @property
    def misplaced(self) -> bool:
        """Whether the minimum is more than a standard error away: then nothing can be decided here.

        Of parameters that act alike, none need be that far where all together are too far to test the fit.
        """
        return self.far is not None and (self.far > _MISPLACED or self.fit.unreached)

    def influence(self, name: str) -> float:
        """Length of the parameter's weighted derivative over the longest one, 0 to 1."""
        return float(self.influences[self.names.index(name)])

    def tied_to(self, name: str) -> tuple[str, ...]:
        """Parameters with which it forms combinations that the data leave open."""
        found = {
            partner: None
            for combination in self.combinations
            if combination.open and name in combination.components and len(combination.components) > 1
            for partner in combination.components
            if partner != name
        }
        return tuple(found)

    def interval(self, name: str) -> tuple[float, float] | None:
        """Confidence interval, natural values, or None."""
        low, high = self.intervals[self.names.index(name)]
        return (float(low), float(high)) if np.isfinite(low) and np.isfinite(high) else None

    def unit_width(self, name: str) -> float:
        """Width of the interval in parts of the searched range; nan without one."""
        return float(self.unit_widths[self.names.index(name)])

    def basis(self, name: str) -> IntervalBasis:
        """What its interval rests on."""
        return self.bases[self.names.index(name)]

    def needs_profile(self, name: str) -> bool:
        """Whether the model is so nonlinear within its interval by linearisation that a profile must give it."""
        index = self.names.index(name)
        return not self.to_rounding and self.bases[index] != "profile" and bool(self.bending[index] > CORRECTED)

    def nonlinear(self, name: str) -> bool:
        """Whether its interval by linearisation does not hold, whatever it rests on now."""
        return self.needs_profile(name) or self.basis(name) in ("moved", "profile")

    def bending_of(self, name: str) -> float:
        """How far an end of its interval by likelihood lies from the linearised one, relatively; nan if unknown."""
        return float(self.bending[self.names.index(name)])

    def widening_of(self, name: str) -> float:
        """How many times wider an allowance for dependence makes its interval by linearisation."""
        return float(self.widening[self.names.index(name)])

    def counts_tests(self, name: str) -> bool:
        """Whether its interval counts each test as one piece of information, so that it holds for a wrong model."""
        half = None if self.without is None else self.without.half_widths[self.names.index(name)]
        return self.fit.tests > 0 and half is not None and bool(np.isfinite(half))

    def _allowance(self, name: str) -> str:
        """For what its interval is widened, in a few words; empty where it is not."""
        basis, factor = self.basis(name), self.widening_of(name)
        kinds = {basis, *(one.kind for one in self.dependence if factor > 1.0)}
        kind: IntervalBasis | None = next((kind for kind in ALLOWANCES if kind in kinds), None)
        if name in self.between_tests:
            kind = "tests"
        return "" if kind is None or factor < _WIDER else _BASES[kind].format(factor)

    def basis_in_words(self, name: str) -> str:
        """What its interval rests on, in a few words; empty for linearisation where that is enough."""
        if self.needs_profile(name):
            return "approximate: the model is nonlinear there"
        how = "" if self.basis(name) in (*ALLOWANCES, "tests") else _BASES[self.basis(name)]
        return ", ".join(part for part in (how, self._allowance(name)) if part)

    def interval_in_words(self, name: str) -> str:
        """Which interval it has: "its 95 % interval by linearisation"."""
        looked = bool(np.isfinite(self.bending_of(name)))
        how = {"linearised": " at the optimum" if looked else " by linearisation"}
        how |= {"moved": " by likelihood", "profile": " by likelihood"}
        allowance = self._allowance(name)
        words = f"its {per_cent(self.level)} interval{how.get(self.basis(name), '')}"
        words += f", {allowance}," if allowance else ""
        untold = self.noise is not None and self.noise.origin == "known" and self.degrees_of_freedom < 1
        return f"{words.rstrip(',')}, if the stated error holds," if untold else words

    def correlation(self) -> FloatArray:
        """Correlations of the estimates in search coordinates, shape (d, d), nan where there is none."""
        if self.covariance is None:
            return np.full((len(self.names), len(self.names)), np.nan)
        deviation = np.sqrt(np.diag(self.covariance))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(self.covariance / np.outer(deviation, deviation))

    def why_no_interval(self, name: str) -> str:
        """Say why a parameter has no interval."""
        if name in self.unclear:
            error = float(self.derivative_errors[self.names.index(name)])
            if error >= _ANY:
                return "its sensitivity is unknown, as the forward model is rough there"
            others = [other for other in self.unclear if other != name]
            left = f"tell it from {listed(others)}" if error < _UNKNOWN and others else "show how it acts"
            rough = f"uncertain by {per_cent(error)} (the forward model is rough there)"
            return f"its sensitivity is {rough}, too much to {left}"
        if name in self.without_influence:
            return "no measured value depends on it"
        tied = self.tied_to(name)
        if tied:
            return f"it acts only in combination with {' and '.join(tied)}"
        if self.noise is None:
            return "there are no more measured points than free parameters, so the noise cannot be estimated; give it"
        if self.basis(name) == "profile":
            return "other values fit nearly as well up to both bounds, as the model is nonlinear"
        if self.unclear:
            return f"the sensitivities to {listed(self.unclear)} are too uncertain"
        return "its interval would be wider than the searched range"

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; None for nan."""
        rows = {
            name: {
                "value": float(self.optimum[i]),
                "standard_error": _number(self.standard_errors[i]),
                "interval": None if self.interval(name) is None else list(self.interval(name) or ()),
                "interval_basis": None if self.interval(name) is None else self.bases[i],
                "widening": _number(self.widening[i]),
                "bending": _number(self.bending[i]),
                "needs_profile": self.needs_profile(name),
                "influence": float(self.influences[i]),
                "why_no_interval": None if self.interval(name) else self.why_no_interval(name),
            }
            for i, name in enumerate(self.names)
        }
        return {
            "parameters": rows,
            "level": self.level,
            "degrees_of_freedom": self.degrees_of_freedom,
            "noise": None if self.noise is None else {"origin": self.noise.origin, "deviations": self.noise.deviations},
            "combinations": [
                {"singular_value": c.singular_value, "components": c.components, "open": c.open}
                for c in self.combinations
            ],
            "correlation": [[_number(v) for v in row] for row in self.correlation().tolist()],
            "unclear": list(self.unclear),
            "derivative_error": self.derivative_error,
            "distance": [_number(v) for v in self.distance],
            "at_optimum": self.at_optimum,
            "held": dict(self.held),
            "fit": self.fit.to_json(),
            "without_tests": None if self.without is None else self.without.to_json(),
            "dependence": [asdict(one) | {"sentence": one.sentence} for one in self.dependence],
        }


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
