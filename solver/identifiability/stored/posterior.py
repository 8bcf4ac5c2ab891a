"""Posterior sample of the parameters through a checked response surface.

Independent normal errors; parameters uniform over the bounds in search coordinates, where the constraints hold. With
known noise the likelihood is exp(-sum r^2 / (2 sigma^2)); with unknown noise, integrated over its size with Jeffreys'
prior, f^(-n/2) (Box and Tiao 1973, section 2.2; Seber and Wild 2003, section 2.7.2). Drawn by the affine invariant
ensemble sampler of Goodman and Weare (2010), package emcee (Foreman-Mackey et al. 2013; extra ``statistics``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.noise import Noise, known_noise, noise_objective, problem_noise
from geoswarm.solver.identifiability.residuals.dependence import FEW
from geoswarm.solver.identifiability.residuals.lack_of_fit import FitVerdict
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.identifiability.stored.stored_fit import fit_of_samples
from geoswarm.solver.identifiability.stored.surface import ResponseSurface, fit_surface
from geoswarm.solver.system.extras import needs_extra
from geoswarm.solver.words import listed

_Likelihood: TypeAlias = Callable[[FloatArray], FloatArray]

__all__ = ["TRUSTED_ERROR", "Posterior", "sample_posterior"]

TRUSTED_ERROR = 0.5
"""Largest error of the log-likelihood among good fits, by the surface's hold-out check, that is called trusted."""

_AT_EDGE = 0.01  # share of the sample
_EDGE = 0.05  # of the region
_WALKERS = 32  # of the ensemble, at least
_LEVEL = 0.95
_CHUNK = 1000
_LONG_ENOUGH = 50  # autocorrelation times


@dataclass(frozen=True, slots=True)
class Posterior:
    """A posterior sample.

    Parameters
    ----------
    names
        Of the d free parameters.
    parameters
        Shape (k, d), natural values.
    level, intervals
        Central credible intervals, shape (d, 2), natural values; nan where the sample reaches the edge of the region
        that the surface covers or of the search, as the parameter is then not limited by the data alone.
    correlation
        In search coordinates, shape (d, d).
    acceptance
        Mean acceptance fraction of the walkers; 0.2 to 0.5 is usual.
    autocorrelation
        Largest integrated autocorrelation time, steps; infinite when a walker never moved.
    effective
        Independent samples that the sample is worth.
    surface_error
        Error of the log-likelihood by the surface's hold-out check, among good fits.
    trusted
        Whether that error is small and the chains were long enough (50 autocorrelation times).
    warnings
        What to be careful about, in sentences.
    """

    names: tuple[str, ...]
    parameters: FloatArray
    level: float
    intervals: FloatArray
    correlation: FloatArray
    acceptance: float
    autocorrelation: float
    effective: int
    surface_error: float
    trusted: bool
    warnings: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values without the sample itself; None for nan."""
        return {
            "level": self.level,
            "intervals": {
                name: [float(v) for v in row] if np.isfinite(row).all() else None
                for name, row in zip(self.names, self.intervals, strict=True)
            },
            "medians": {
                name: float(np.median(column)) for name, column in zip(self.names, self.parameters.T, strict=True)
            },
            "correlation": self.correlation.tolist(),
            "samples": len(self.parameters),
            "effective": self.effective,
            "acceptance": self.acceptance,
            "autocorrelation": self.autocorrelation if np.isfinite(self.autocorrelation) else None,
            "surface_error": self.surface_error,
            "trusted": self.trusted,
            "warnings": list(self.warnings),
        }


def sample_posterior(
    calibration: Calibration,
    samples: Samples,
    *,
    noise: Mapping[str, float] | float | None = None,
    steps: int = 8000,
    seed: int = 0,
) -> Posterior:
    """Sample the posterior; runs no forward calculation.

    Parameters
    ----------
    samples
        Stored evaluations with responses.
    noise
        Known standard deviation of a reading, base units; that of the problem file when absent. Where it is unknown,
        series must have been weighted by their precision, since their noise shares one unknown factor.
    steps
        Of the ensemble; it ends before them when 50 autocorrelation times are left after the first quarter, which
        is dropped.
    seed
        Of the sampler.

    Raises
    ------
    StatisticsError
        When emcee is not installed, or no response surface can be fitted.
    """
    try:
        import emcee
    except ImportError as missing:
        raise StatisticsError(needs_extra("a posterior sample", "emcee")) from missing

    surface = fit_surface(calibration, samples, seed=seed)
    if not np.isfinite(surface.objective_error):
        raise StatisticsError(
            "no response surface holds for the stored evaluations: their objectives, "
            f"{samples.objectives[samples.best]:g} and more, are too far apart; narrower bounds, or a transformed "
            "parameter, are needed"
        )
    space = calibration.space
    low, span = space.search_lower, space.search_upper - space.search_lower
    known = problem_noise(calibration.problem) if noise is None else known_noise(calibration.problem, noise)
    if known is not None:
        noise_objective(calibration.problem, known)  # refuses what cannot be calculated with
    log_likelihood = _likelihood(calibration, known)

    def log_probability(unit: FloatArray) -> FloatArray:
        value = np.full(len(unit), -np.inf)
        inside = np.flatnonzero(surface.inside(unit))
        allowed = [i for i in inside if space.feasible(space.to_natural(low + unit[i] * span))]
        if allowed:
            with np.errstate(over="ignore", divide="ignore"):
                value[allowed] = log_likelihood(calibration.objective.with_losses(surface.residuals(unit[allowed])))
        return value

    walkers = max(_WALKERS, 2 * space.dimension + 2)
    start = _start(samples, surface, walkers)
    if not np.isfinite(log_probability(start)).all():
        raise StatisticsError(
            "the likelihood of stored evaluations is not a number: objectives from "
            f"{samples.objectives[samples.best]:g} are too large, or too small, to be compared with the noise; units "
            "in which they are nearer to 1 are needed"
        )
    random = np.random.RandomState(seed)
    sampler = emcee.EnsembleSampler(walkers, space.dimension, log_probability, vectorize=True)
    state = emcee.State(start, random_state=random.get_state())
    run, time = 0, np.inf
    while run < steps and 3 * run < 4 * _LONG_ENOUGH * time:
        with np.errstate(invalid="ignore"):  # of two points without likelihood
            state = sampler.run_mcmc(state, min(_CHUNK, steps - run), skip_initial_state_check=True)
        run += min(_CHUNK, steps - run)
        chain = sampler.get_chain(discard=run // 4)
        moved = bool((np.ptp(chain, axis=0) > 0).all())
        time = float(np.max(emcee.autocorr.integrated_time(chain, quiet=True, tol=0))) if moved else np.inf
    unit = chain.reshape(-1, space.dimension)
    natural = space.to_natural(low + unit * span)
    error = surface.objective_error * _error_factor(calibration, known, float(samples.objectives[samples.best]))
    intervals = np.quantile(natural, [0.5 - _LEVEL / 2.0, 0.5 + _LEVEL / 2.0], axis=0).T
    fit = fit_of_samples(calibration, samples, noise=noise)
    wrong = (fit.sentence,) if fit.wrong else ()
    warnings = wrong + _warnings(samples.names, unit, surface, error, len(chain), time) + _dependent(calibration, fit)
    cut = _reaches_edge(unit, surface)
    intervals[cut] = np.nan
    return Posterior(
        names=samples.names,
        parameters=natural,
        level=_LEVEL,
        intervals=intervals,
        correlation=np.atleast_2d(np.corrcoef(unit, rowvar=False)),
        acceptance=float(np.mean(sampler.acceptance_fraction)),
        autocorrelation=time,
        effective=int(len(unit) / max(time, 1.0)),
        surface_error=error,
        trusted=error <= TRUSTED_ERROR and len(chain) >= _LONG_ENOUGH * time,
        warnings=warnings,
    )


def _likelihood(calibration: Calibration, noise: Noise | None) -> _Likelihood:
    observed = calibration.objective.observed
    weights = np.concatenate([o.weight * o.point_weights / o.y.size for o in observed])
    used = int((weights > 0).sum())
    if noise is None:
        return lambda residuals: np.asarray(-0.5 * used * np.log(np.sum(residuals**2, axis=1)))
    deviations = noise.deviations
    variance = np.concatenate([np.full(o.y.size, o.weight * deviations[o.series] ** 2 / o.y.size) for o in observed])
    variance = np.where(variance > 0, variance, 1.0)  # of the weighted residuals; those of weight 0 are 0 themselves
    return lambda residuals: np.asarray(-0.5 * np.sum(residuals**2 / variance, axis=1))


def _error_factor(calibration: Calibration, noise: Noise | None, best: float) -> float:
    """Error of the log-likelihood for a relative error of f near its minimum."""
    observed = calibration.objective.observed
    used = calibration.problem.counted_points
    if noise is None:
        return 0.5 * used
    deviations = noise.deviations
    expected = sum(o.weight * deviations[o.series] ** 2 for o in observed)
    return 0.5 * used * best / expected


def _start(samples: Samples, surface: ResponseSurface, walkers: int) -> FloatArray:
    """Start at the best different samples: they are feasible, and spread as the good fits do."""
    order = np.argsort(samples.objectives, kind="stable")
    unit = samples.unit[order]
    _, first = np.unique(np.round(unit, 9), axis=0, return_index=True)
    unit = unit[np.sort(first)]
    unit = unit[surface.inside(unit)]
    if len(unit) < walkers:
        raise StatisticsError(f"{walkers} walkers need as many different evaluations, there are {len(unit)}")
    return np.asarray(unit[:walkers])


def _reaches_edge(unit: FloatArray, surface: ResponseSurface) -> BoolArray:
    """Parameters of which more than 1 % of the sample lies in the outer 5 % of the region, shape (d,)."""
    margin = _EDGE * (surface.upper - surface.lower)
    near = ((unit <= surface.lower + margin) | (unit >= surface.upper - margin)).mean(axis=0)
    return np.asarray(near > _AT_EDGE)


def _dependent(calibration: Calibration, fit: FitVerdict) -> tuple[str, ...]:
    """A sentence where intervals at the optimum allow for a correlation of errors, which the likelihood does not."""
    correlated = {misfit.series for misfit in fit.misfits if misfit.reason == "pattern"}
    for o in calibration.objective.observed:
        stated = calibration.problem.noise_of(o.series)
        if stated == "correlated" or int((o.point_weights > 0).sum()) < FEW:
            correlated.add(o.series)
        if stated == "white" or o.weight == 0.0:
            correlated.discard(o.series)
    if not correlated:
        return ()
    return (
        f"the errors of the readings of {listed(sorted(correlated))} are taken as independent; intervals at the "
        "optimum allow for a correlation and may be wider",
    )


def _warnings(
    names: tuple[str, ...], unit: FloatArray, surface: ResponseSurface, error: float, steps: int, time: float
) -> tuple[str, ...]:
    warnings = []
    if error > TRUSTED_ERROR:
        warnings.append(
            f"the response surface misses the log-likelihood of good fits by {error:.2g} (at most {TRUSTED_ERROR} is "
            "trusted): evaluate more samples near the optimum"
        )
    if np.isinf(time):
        warnings.append("some walkers never moved: the response surface is too rough for the sampler")
    elif steps < _LONG_ENOUGH * time:
        warnings.append(f"the chains are short: {steps} steps for an autocorrelation time of {time:.0f}")
    cut = [name for name, is_cut in zip(names, _reaches_edge(unit, surface), strict=True) if is_cut]
    if cut:
        warnings.append(f"the sample of {', '.join(cut)} reaches the edge of the sampled region: no interval")
    return tuple(warnings)
