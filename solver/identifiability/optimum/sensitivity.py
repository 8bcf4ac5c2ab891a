"""Linearised uncertainty at the optimum: combinations that the data leave open, covariance, errors and intervals.

With J the derivatives of all responses, W the diagonal of the weights w_g w_h / m_g that the objective gives the points
and S the diagonal of their noise variances, the estimate that minimises the objective has the covariance

    C = (J' W J)^-1  J' W S W J  (J' W J)^-1                         (Seber and Wild 2003, section 2.8)

which is the usual s^2 (J' J)^-1 for one series. Standard errors and covariance are these; intervals are wider where the
residuals show that the noise is not independent and even (``residuals.dependence``), and follow the likelihood where
the model is nonlinear (``bending``). A series with a robust loss enters by its pseudo residuals
(:class:`geoswarm.solver.objective.PseudoReadings`), which gives the sandwich covariance of the robust estimate; its
noise is estimated, as a stated error is that of readings without outliers. Parameters are taken in parts of their
range in search coordinates, so that singular
values compare what a move through the whole searched range would change.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.noise import Noise, estimate_noise, known_noise, problem_noise, with_losses
from geoswarm.solver.identifiability.optimum.combinations import Directions, find_directions
from geoswarm.solver.identifiability.optimum.differences import (
    DifferenceDesign,
    Jacobian,
    check_points,
    design,
    differentiate,
)
from geoswarm.solver.identifiability.optimum.leaving_out import WithoutTests, leave_tests_out
from geoswarm.solver.identifiability.optimum.linearisation import IntervalBasis, Linearisation, LinearModel
from geoswarm.solver.identifiability.optimum.minimising import MinimisingStep, minimising_step
from geoswarm.solver.identifiability.optimum.refitted import natural_moves
from geoswarm.solver.identifiability.optimum.spread import Spread, mean_variance, reading_variances
from geoswarm.solver.identifiability.residuals.dependence import ALLOWANCES, Dependence, dependence_of
from geoswarm.solver.identifiability.residuals.lack_of_fit import FitVerdict, examine_fit
from geoswarm.solver.identifiability.residuals.readings import is_exact, met_to_rounding
from geoswarm.solver.objective import LEAST_SLOPE, PseudoReadings
from geoswarm.solver.problem.weighting import test_of

__all__ = ["design", "from_evaluations", "linearise"]

_AT_BOUND = 1e-9
_TESTS_DIFFER = ("lack_of_fit", "error_not_met", "doubtful")  # verdicts on the fit with which a test counts as one


def from_evaluations(
    calibration: Calibration,
    plan: DifferenceDesign,
    evaluations: Sequence[Evaluation],
    *,
    noise: Mapping[str, float] | float | None = None,
    level: float = 0.95,
) -> Linearisation:
    """Linearise from the evaluations of :func:`design`'s positions, in their order.

    Parameters
    ----------
    noise
        Known standard deviation of a reading, base units, one for all series or one each; that of the problem file
        when absent, and estimated where it states none.

    Raises
    ------
    TooFewPointsError
        When there are fewer measured points than free parameters.
    StatisticsError
        When too few evaluations succeeded, or ``noise`` is wrong.
    """
    return linearise(calibration, differentiate(calibration, plan, evaluations), noise=noise, level=level)


def linearise(
    calibration: Calibration,
    jacobian: Jacobian,
    *,
    noise: Mapping[str, float] | float | None = None,
    level: float = 0.95,
) -> Linearisation:
    """Linearise from derivatives, wherever they come from; arguments and errors as :func:`from_evaluations`."""
    check_points(calibration)
    objective = calibration.objective
    plain = objective.plain_residuals(jacobian.responses)
    pseudo = objective.pseudo_readings(jacobian.responses)
    _check_scales(pseudo)
    observed = pseudo.observed
    series = [o.series for o in observed]
    weights = np.concatenate([o.weight * o.point_weights / o.y.size for o in observed])
    root = np.sqrt(weights)
    weighted = np.concatenate([jacobian.derivatives[s] for s in series]) * root[:, None]
    errors = np.concatenate([jacobian.error[s] for s in series]) * root[:, None]
    residuals = np.concatenate([pseudo.residuals[s] for s in series]) * root
    found = find_directions(calibration.free_names, weighted, errors, np.concatenate([o.y for o in observed]) * root)
    stated = known_noise(calibration.problem, noise) if noise is not None else problem_noise(calibration.problem)
    taken = dict(zip(series, _blocks(found.leverage, [o.y.size for o in observed]), strict=True))
    estimate = (
        stated
        if stated is not None and not objective.robust
        else with_losses(estimate_noise(calibration.problem, pseudo.residuals, taken), stated, pseudo, taken)
    )
    if objective.robust and stated is not None:  # a stated error says nothing of pseudo residuals
        stated = estimate if any(o.loss is None for o in observed) else None
    noise_level = 0.0 if estimate is None else float(np.sqrt(mean_variance(calibration, weights, estimate)))
    unclear = found.unclear(calibration.free_names, noise_level)
    step = minimising_step(weighted, residuals, found, calibration.space.to_unit(jacobian.optimum))
    inner = _inner(calibration, jacobian.optimum)
    fit = examine_fit(
        calibration,
        jacobian.responses,
        {name: columns[:, inner] for name, columns in jacobian.derivatives.items()},
        None if stated is None else stated.deviations,
        at_bound=not inner.all(),
    )
    inverse = found.inverse(weighted)
    variances = np.full(len(weights), np.nan) if estimate is None else reading_variances(calibration, weights, estimate)
    if objective.robust:  # profiles and the look at bending see the losses themselves
        slopes = (
            objective.loss_slopes(plain)
            * np.sqrt(np.concatenate([np.full(o.y.size, pseudo.slopes[o.series]) for o in observed])) ** -1.0
        )
        model = LinearModel(weighted * slopes[:, None], objective.with_losses(plain), inverse, variances)
    else:
        model = LinearModel(weighted, residuals, inverse, variances)
    dependence = _dependence(calibration, jacobian, residuals, weights, found, fit)
    without = leave_tests_out(
        calibration.free_names,
        _tests(calibration, weights),
        found.basis,
        residuals,
        inverse,
        level,
        lambda moves: natural_moves(calibration.space, jacobian.optimum, moves),
    )
    between = without.half_widths if without is not None and fit.kind in _TESTS_DIFFER else None
    if without is not None:
        fit = fit.between(len(without.tests))
    spread = Spread.of(calibration, weighted, weights, residuals, step, found, estimate, level, dependence, between)
    if unclear:
        spread = spread.without_intervals()
    return _assemble(
        calibration,
        jacobian,
        found,
        estimate,
        level,
        spread,
        step,
        unclear,
        int((weights > 0).sum()),
        fit,
        tuple(one for one, _ in dependence),
        model,
        stated is None and met_to_rounding([o for o in objective.observed if o.weight > 0], jacobian.responses),
        without,
    )


def _tests(calibration: Calibration, weights: FloatArray) -> dict[str, IntArray]:
    """Places of the readings that count of each test, by its name."""
    found: dict[str, list[IntArray]] = {}
    start = 0
    for o in calibration.objective.observed:
        places = start + np.flatnonzero(weights[start : start + o.y.size] > 0)
        start += o.y.size
        if places.size:
            found.setdefault(test_of(calibration.problem.forward_model, o.series), []).append(places)
    return {test: np.concatenate(parts) for test, parts in found.items()}


def _check_scales(pseudo: PseudoReadings) -> None:
    """Refuse losses beyond whose scale nearly all readings lie: nothing there resembles least squares."""
    beyond = [o.series for o in pseudo.observed if o.loss is not None and pseudo.slopes[o.series] <= LEAST_SLOPE]
    if beyond:
        raise StatisticsError(
            f"too many residuals of {', '.join(beyond)} lie beyond the scale of the loss for a linearisation; give a "
            "scale nearer to the scatter of the readings"
        )


def _dependence(
    calibration: Calibration,
    jacobian: Jacobian,
    residuals: FloatArray,
    weights: FloatArray,
    found: Directions,
    fit: FitVerdict,
) -> list[tuple[Dependence, IntArray]]:
    """Series whose noise is or may be correlated or of uneven size, and their readings in the order of x."""
    departing = []
    start = 0
    patterned = {m.series for m in fit.misfits if m.reason == "pattern"}
    for o in calibration.objective.observed:
        places = start + np.flatnonzero(weights[start : start + o.y.size] > 0)
        places = places[np.argsort(o.x[places - start], kind="stable")]
        first, start = start, start + o.y.size
        stated = calibration.problem.noise_of(o.series)
        if stated == "white" or is_exact(o, o.residuals(jacobian.responses[o.series])):
            continue
        one = dependence_of(
            o.series,
            residuals[places],
            found.basis[places],
            o.x[places - first],
            o.series in patterned,
            stated == "correlated",
        )
        if one is not None:
            departing.append((one, places))
    return departing


def _inner(calibration: Calibration, optimum: FloatArray) -> BoolArray:
    """Parameters that do not lie at a bound, shape (d,): only they were fitted."""
    unit = calibration.space.to_unit(optimum)
    return np.asarray((unit > _AT_BOUND) & (unit < 1.0 - _AT_BOUND))


def _blocks(leverage: FloatArray, sizes: Sequence[int]) -> list[float]:
    """Trace of each series' block of the hat matrix; their sum is the rank."""
    return [float(part.sum()) for part in np.split(leverage, np.cumsum(sizes)[:-1])]


def _assemble(
    calibration: Calibration,
    jacobian: Jacobian,
    found: Directions,
    noise: Noise | None,
    level: float,
    spread: Spread,
    step: MinimisingStep,
    unclear: tuple[str, ...],
    points: int,
    fit: FitVerdict,
    dependence: tuple[Dependence, ...],
    model: LinearModel,
    to_rounding: bool,
    without: WithoutTests | None,
) -> Linearisation:
    space = calibration.space
    span = space.search_upper - space.search_lower
    return Linearisation(
        names=calibration.free_names,
        scales=tuple("log" if is_log else "linear" for is_log in space.log),
        optimum=jacobian.optimum,
        combinations=found.combinations,
        without_influence=tuple(
            name
            for name, is_active in zip(calibration.free_names, found.active, strict=True)
            if not is_active and name not in unclear
        ),
        unclear=unclear,
        held=tuple(
            (name, "lower" if side < 0 else "upper")
            for name, side in zip(calibration.free_names, step.held, strict=True)
            if side
        ),
        influences=found.influences,
        noise=noise,
        degrees_of_freedom=points - space.dimension,
        covariance=None if noise is None else spread.covariance * np.outer(span, span),
        standard_errors=spread.deviations * span * np.where(space.log, jacobian.optimum, 1.0),
        intervals=natural_moves(calibration.space, jacobian.optimum, np.stack([-spread.half, spread.half])).T,
        unit_widths=2.0 * spread.half,
        level=level,
        derivative_error=found.derivative_error,
        derivative_errors=found.derivative_errors,
        distance=np.where(np.isfinite(spread.distance), 0.0, np.nan) if to_rounding else spread.distance,
        profile_increase=spread.profile_increase,
        fit=fit,
        model=model,
        linear_half_widths=spread.half,
        widening=spread.widening,
        bases=_bases(spread, dependence),
        bending=np.full(space.dimension, np.nan),
        dependence=dependence,
        to_rounding=to_rounding,
        without=without,
        between_tests=tuple(np.array(calibration.free_names)[spread.between_tests].tolist()),
    )


def _bases(spread: Spread, dependence: tuple[Dependence, ...]) -> tuple[IntervalBasis, ...]:
    """What the interval of each parameter rests on: what was found goes before what is possible where both widen it."""
    kinds = {one.kind for one in dependence}
    wider: IntervalBasis = next((kind for kind in ALLOWANCES if kind in kinds), "uneven")
    return tuple(
        "tests" if between else wider if factor > 1.0 else "linearised"
        for factor, between in zip(spread.widening.tolist(), spread.between_tests.tolist(), strict=True)
    )
