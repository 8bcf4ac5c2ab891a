"""Whether the model describes the data, from stored evaluations alone: no forward calculation, no derivatives."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.noise import known_noise, problem_noise
from geoswarm.solver.identifiability.remedies import follow_up
from geoswarm.solver.identifiability.residuals.lack_of_fit import FitVerdict, examine_fit, unfit_readings, untested
from geoswarm.solver.identifiability.samples import Samples

__all__ = ["fit_of_samples"]

_NEIGHBOURS = 6  # evaluations for each parameter
_AT_BOUND = 1e-3
"""Distance to a bound, over the range, of a parameter that a search has driven there."""


def fit_of_samples(
    calibration: Calibration, samples: Samples, *, noise: Mapping[str, float] | float | None = None
) -> FitVerdict:
    """Test the fit of the best stored evaluation.

    What the parameters can change near it is taken from the evaluations whose responses are closest to its own: the
    leading directions of their differences span what derivatives would.

    Parameters
    ----------
    noise
        Known standard deviation of a reading, base units; that of the problem file when absent.

    Raises
    ------
    StatisticsError
        When the noise is wrong.
    """
    if (unfit := unfit_readings(calibration.problem)) is not None:
        return unfit
    known = problem_noise(calibration.problem) if noise is None else known_noise(calibration.problem, noise)
    if samples.size and samples.unbiased.all():
        return untested("the best of a sampling is not an optimum", follow_up("sensitivity"))
    dimension = samples.dimension
    if not samples.responses:
        return untested("the responses of the evaluations are not stored")
    if samples.size < _NEIGHBOURS * dimension + 1:
        return untested(f"{samples.size} stored evaluations are too few")
    observed = calibration.objective.observed
    best = samples.best
    roots = {o.series: np.sqrt(o.weight * o.point_weights / o.y.size) for o in observed}
    plain = calibration.objective.plain_residuals(samples.responses)
    moves = plain - plain[best]
    lengths = np.linalg.norm(moves, axis=1)
    different = np.flatnonzero(lengths > 0.0)
    nearest = different[np.argsort(lengths[different], kind="stable")][: _NEIGHBOURS * dimension]
    if nearest.size < 2 * dimension:
        return untested(f"{nearest.size} stored evaluations that differ from the best one are too few")
    _, _, rows = np.linalg.svd(moves[nearest] / lengths[nearest][:, None], full_matrices=False)
    spanned = rows[:dimension].T
    derivatives: dict[str, FloatArray] = {}
    start = 0
    for o in observed:
        root = roots[o.series]
        part = spanned[start : start + o.y.size]
        derivatives[o.series] = np.where(root[:, None] > 0, part / np.where(root > 0, root, 1.0)[:, None], 0.0)
        start += o.y.size
    responses = {o.series: samples.responses[o.series][best] for o in observed}
    stated = (
        None if known is None or calibration.objective.robust else known.deviations
    )  # that of pseudo residuals is another
    unit = calibration.space.to_unit(samples.parameters[best])
    at_bound = bool(((unit < _AT_BOUND) | (unit > 1.0 - _AT_BOUND)).any())
    return examine_fit(calibration, responses, derivatives, stated, at_bound=at_bound)
