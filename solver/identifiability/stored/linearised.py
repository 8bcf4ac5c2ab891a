"""Sensitivities at the optimum from stored evaluations, where these are dense enough: no new forward calculation."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.optimum.differences import Jacobian
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.identifiability.stored.surface import ResponseSurface, fit_surface
from geoswarm.solver.words import per_cent

__all__ = ["jacobian_from_samples"]

_STEP = 0.01  # of the region of the surface
_LARGEST_ERROR = 0.1  # of a derivative column, between the surfaces of two halves
_TRUSTED_OBJECTIVE = 0.05


def jacobian_from_samples(calibration: Calibration, samples: Samples) -> Jacobian:
    """Differentiate a response surface at the best sample.

    The error of a derivative is estimated from the surfaces of two halves of the samples (every other one by rank).

    Raises
    ------
    StatisticsError
        When the evaluations are not dense enough: too few, the hold-out check of the surface is off by more than 5 % of
        f, the halves differ by more than a tenth in a derivative, or by more than a tenth of what tells the parameters
        from each other (the smallest singular value). Evaluate the positions of
        :func:`geoswarm.solver.identifiability.design` instead.
    """
    surface = fit_surface(calibration, samples)
    if surface.objective_error > _TRUSTED_OBJECTIVE:
        raise StatisticsError(
            f"stored evaluations are not dense enough for sensitivities: predicted objectives are off by "
            f"{per_cent(surface.objective_error)} (at most {per_cent(_TRUSTED_OBJECTIVE)}); evaluate around the optimum"
        )
    best = samples.best
    unit = samples.unit[best]
    columns = _columns(surface, unit)
    # the root mean square of two independent halves' difference overstates the error of the whole
    order = np.argsort(samples.objectives, kind="stable")
    halves = [_columns(fit_surface(calibration, samples.select(order[start::2])), unit) for start in (0, 1)]
    gap = np.abs(halves[0] - halves[1]) / 2.0
    relative = np.linalg.norm(gap, axis=0) / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    if relative.max() > _LARGEST_ERROR:
        name = samples.names[int(np.argmax(relative))]
        raise StatisticsError(
            f"stored evaluations are not dense enough for sensitivities: that to {name} is uncertain by "
            f"{per_cent(relative.max())} (at most {per_cent(_LARGEST_ERROR)}); evaluate around the optimum"
        )
    singular = np.linalg.svd(columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300), compute_uv=False)
    if relative.max() > _LARGEST_ERROR * singular[-1] / singular[0]:
        raise StatisticsError(
            f"stored evaluations are not dense enough for sensitivities: uncertain by {per_cent(relative.max())}, they "
            "cannot tell the parameters from each other; evaluate around the optimum"
        )
    observed = calibration.objective.observed
    roots = [np.sqrt(o.weight * o.point_weights / o.y.size)[:, None] for o in observed]
    ends = np.cumsum([o.y.size for o in observed])[:-1]

    def by_series(array: FloatArray) -> dict[str, FloatArray]:
        parts = np.split(array, ends)
        return {
            o.series: np.where(root > 0, part / np.where(root > 0, root, 1.0), 0.0)
            for o, part, root in zip(observed, parts, roots, strict=True)
        }

    return Jacobian(
        optimum=samples.parameters[best],
        responses={o.series: samples.responses[o.series][best] for o in observed},
        derivatives=by_series(columns),
        error=by_series(gap),
        origin="samples",
    )


def _columns(surface: ResponseSurface, unit: FloatArray) -> FloatArray:
    """Derivatives of the weighted residuals per range, shape (n, d)."""
    steps = _STEP * (surface.upper - surface.lower)
    moves = np.diag(steps)
    return np.asarray((surface.residuals(unit + moves) - surface.residuals(unit - moves)).T / (2.0 * steps))
