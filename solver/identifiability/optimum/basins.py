"""Other sets of parameters that fit as well as the optimum: what an interval around one optimum cannot show.

An interval at the optimum follows from the curvature there. Stored runs that fit as well but lie outside the region
that this curvature allows contradict it: the objective has a second basin, or a valley that is bent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import fdtri

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.noise import Noise, noise_objective
from geoswarm.solver.identifiability.optimum.differences import count_points
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.identifiability.samples import Samples

__all__ = ["OtherFit", "equivalent_objective", "heads_elsewhere", "other_fits"]

_LEVEL = 0.95
_REPRODUCED = 1e-10  # of the mean square of the measured values: no measurement tells fits apart below it
_OUTSIDE = 1.5  # times as far from the optimum as the curvature there allows
_LEAST_APART = 1e-3  # parts of the range
_UNFINISHED = 10.0  # times the limit: a basin left there may hold as good a fit
_HEAD_APART = 0.1  # parts of the range to the nearest better run


@dataclass(frozen=True, slots=True)
class OtherFit:
    """A set of parameters, shape (d,), natural values, that fits as well; ``differs``: those outside their region."""

    parameters: FloatArray
    objective: float
    differs: tuple[str, ...]


def equivalent_objective(calibration: Calibration, best: float, noise: Noise | None) -> float:
    """Objective up to which a fit cannot be told from the best one at 95 % (Seber and Wild 2003, eq. 5.22).

    Parameters
    ----------
    best
        The lowest objective known.
    noise
        When it is known.
    """
    observed = calibration.objective.observed
    dimension = calibration.space.dimension
    free = count_points(calibration) - dimension
    factor = 1.0 + dimension / free * float(fdtri(dimension, free, _LEVEL)) if free > 0 else 2.0
    floor = _REPRODUCED * sum(o.weight * float((o.point_weights * o.y**2).mean()) for o in observed)
    known = 0.0 if noise is None else noise_objective(calibration.problem, noise)
    return max(best, floor, known) * factor


def _extent(linearisation: Linearisation, limit: float, best: float) -> FloatArray:
    """How far from the optimum the linearised objective reaches the limit, parts of the range, shape (d,)."""
    half = linearisation.linear_half_widths
    with np.errstate(invalid="ignore", divide="ignore"):
        extent = half * np.sqrt(max(limit - best, 0.0) / linearisation.profile_increase)
    return np.where(half == 0.0, 0.0, extent)


def _outside(samples: Samples, unit: FloatArray, linearisation: Linearisation, limit: float, best: float) -> FloatArray:
    """Whether each parameter of points (k, d), parts of the range, lies outside its region, shape (k, d)."""
    extent = _extent(linearisation, limit, best)
    allowed = np.where(np.isnan(extent), np.inf, np.maximum(_OUTSIDE * extent, _LEAST_APART))
    return np.asarray(np.abs(unit - samples.to_unit(linearisation.optimum)) > allowed)


def other_fits(
    samples: Samples,
    linearisation: Linearisation,
    limit: float,
    best: float,
    further: Sequence[tuple[FloatArray, float]] = (),
) -> tuple[OtherFit, ...]:
    """Fits as good as the optimum that its curvature does not allow, at most one more for each parameter.

    Parameters
    ----------
    samples, linearisation
        All stored runs, and the region around the optimum.
    limit, best
        Of :func:`equivalent_objective`, and the objective at the optimum.
    further
        Parameters, natural values, and objectives that are not among the samples.
    """
    parameters = np.concatenate([samples.parameters, *(p[None] for p, _ in further)])
    objectives = np.concatenate([samples.objectives, [f for _, f in further]])
    good = np.flatnonzero(objectives <= limit)
    good = good[np.argsort(objectives[good], kind="stable")]
    outside = _outside(samples, samples.to_unit(parameters[good]), linearisation, limit, best)
    found: dict[int, OtherFit] = {}
    for column in range(samples.dimension):
        rows = np.flatnonzero(outside[:, column])
        if rows.size and int(rows[0]) not in found:
            row = int(rows[0])
            differs = tuple(name for name, out in zip(samples.names, outside[row], strict=True) if out)
            found[row] = OtherFit(parameters[good[row]], float(objectives[good[row]]), differs)
    return tuple(found[row] for row in sorted(found))


def heads_elsewhere(samples: Samples, linearisation: Linearisation, limit: float, best: float) -> IntArray:
    """Indices of the best runs of basins that the search left unfinished, the best first.

    Runs outside the region of the optimum without a better one nearby, whose objective is not far above the limit.
    """
    order = np.argsort(samples.objectives, kind="stable")
    order = order[samples.objectives[order] <= _UNFINISHED * limit]
    unit = samples.unit[order]
    outside = np.atleast_1d(_outside(samples, unit, linearisation, limit, best).any(axis=1))
    heads = [
        i
        for i in range(1, len(order))
        if outside[i] and float(np.abs(unit[:i] - unit[i]).max(axis=1).min()) > _HEAD_APART
    ]
    return np.asarray(order[heads], dtype=np.int64)
