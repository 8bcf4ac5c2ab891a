"""Measurement noise, known or estimated from the residuals."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.objective import PseudoReadings
from geoswarm.solver.problem import Problem

SMALLEST, LARGEST = 1e-150, 1e150
"""Standard deviations whose squares are ordinary numbers."""

__all__ = ["Noise", "estimate_noise", "known_noise", "noise_objective", "problem_noise", "with_losses"]


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviation of a reading with point weight 1, by series, in the series' base unit.

    A reading with point weight w_h has the standard deviation ``deviations[series] / sqrt(w_h)``: w_h grade points
    inside one series.

    Parameters
    ----------
    deviations
        By series.
    origin
        ``known`` (given by the user) or ``estimated`` from the residuals at the optimum.
    degrees_of_freedom
        Of the estimate, n - d over all series; infinite when known.
    """

    deviations: dict[str, float]
    origin: Literal["known", "estimated"]
    degrees_of_freedom: float


def known_noise(problem: Problem, deviations: Mapping[str, float] | float) -> Noise:
    """Take the standard deviations of readings from the user, one number for all series or one each, base units.

    Like ``error`` of the problem file it is that of a reading; that of a mean of readings follows from it.

    Raises
    ------
    StatisticsError
        When a series is missing or unknown, or a deviation is not above 0 or its square no ordinary number.
    """
    names = [o.series for o in problem.observations]
    values = dict.fromkeys(names, deviations) if isinstance(deviations, int | float) else dict(deviations)
    if set(values) != set(names):
        raise StatisticsError(f"noise is given for {', '.join(values)}; observed series: {', '.join(names)}")
    wrong = [f"{name}: {value:g}" for name, value in values.items() if not (np.isfinite(value) and value > 0)]
    if wrong:
        raise StatisticsError(f"the standard deviation of noise must be above 0, got {', '.join(wrong)}")
    return _judged({o.series: float(values[o.series]) * o.mean_error for o in problem.observations})


def problem_noise(problem: Problem) -> Noise | None:
    """The noise that the problem file states (``error`` of every observation that counts), or None.

    Raises
    ------
    StatisticsError
        When the square of a deviation is no ordinary number.
    """
    errors = {o.series: o.error for o in problem.observations}
    if any(o.error is None and o.weight > 0 for o in problem.observations):
        return None
    return _judged({series: error or 1.0 for series, error in errors.items()})


def _judged(deviations: dict[str, float]) -> Noise:
    beyond = [f"{name}: {value:g}" for name, value in deviations.items() if not SMALLEST <= value <= LARGEST]
    if beyond:
        raise StatisticsError(
            f"the standard deviation of noise must be from {SMALLEST:g} to {LARGEST:g}, got {', '.join(beyond)}"
        )
    return Noise(deviations, "known", np.inf)


def estimate_noise(
    problem: Problem, residuals: Mapping[str, FloatArray], degrees_taken: Mapping[str, float]
) -> Noise | None:
    """Estimate the noise of every series from the residuals at the optimum.

    sigma_g^2 = sum_h w_h r_hg^2 / (m_g - t_g), where t_g, the trace of the series' block of the hat matrix, is the
    share of the parameters that the series determines (sum of t_g = d). For one series this is the usual
    s^2 = SSR / (n - d). A series that leaves less than one degree of freedom shares the mean of all.

    Parameters
    ----------
    residuals
        y_calc - y_meas of each series, shape (m_g,), base units.
    degrees_taken
        t_g of each series.

    Returns
    -------
    Noise or None
        None when there are no more points than parameters: then noise cannot be estimated.
    """
    squares, free, total = {}, {}, 0
    for o in problem.observations:
        used = o.point_weights > 0
        r = residuals[o.series]
        squares[o.series] = float(np.sum(o.point_weights * r * r))
        free[o.series] = float(used.sum()) - degrees_taken[o.series]
        total += int(used.sum()) if o.weight > 0 else 0
    degrees = total - round(sum(degrees_taken.values()))
    if degrees < 1:
        return None
    counted = [o.series for o in problem.observations if o.weight > 0]
    pooled = sum(squares[s] for s in counted) / sum(free[s] for s in counted)
    deviations = {s: float(np.sqrt(squares[s] / free[s] if free[s] >= 1.0 else pooled)) for s in squares}
    return Noise(deviations, "estimated", float(degrees))


def with_losses(
    estimated: Noise | None, stated: Noise | None, pseudo: PseudoReadings, degrees_taken: Mapping[str, float]
) -> Noise | None:
    """Noise where series have robust losses: of these that of the pseudo residuals, of others the stated one, if any.

    Of few readings that of a loss is larger by Huber's (1981, equation 7.6.6) factor 1 + (t_g / m_g) var psi' / (mean
    psi')^2; 1 without losses, which changes nothing.

    Parameters
    ----------
    estimated
        From the pseudo residuals of all series (:func:`estimate_noise`).
    stated
        Of the problem or the user; None without.
    degrees_taken
        t_g of each series.
    """
    if estimated is None:
        return None
    deviations = dict(estimated.deviations)
    for o in pseudo.observed:
        if o.loss is not None:
            share = degrees_taken[o.series] / max(int((o.point_weights > 0).sum()), 1)
            deviations[o.series] *= 1.0 + share * pseudo.unevenness[o.series]
        elif stated is not None:
            deviations[o.series] = stated.deviations[o.series]
    return Noise(deviations, "estimated", estimated.degrees_of_freedom)


def noise_objective(problem: Problem, noise: Noise) -> float:
    """Objective f that this noise alone leaves on average at the true parameters: sum_g w_g sigma_g^2.

    Raises
    ------
    StatisticsError
        When it is too large or too small a number.
    """
    found = sum(
        o.weight * noise.deviations[o.series] ** 2 * float((o.point_weights > 0).mean()) for o in problem.observations
    )
    if not sys.float_info.min <= found < np.inf:
        given = ", ".join(f"{o.series}: {noise.deviations[o.series]:g}" for o in problem.observations)
        raise StatisticsError(
            f"this noise ({given}), squared and weighted, is {found:g}, which cannot be calculated with; noise and "
            "weights nearer to 1 are accepted"
        )
    return found
