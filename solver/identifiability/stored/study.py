"""All results from stored evaluations together, as a report and the HTTP interface show them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.noise import known_noise, noise_objective, problem_noise
from geoswarm.solver.identifiability.optimum.basins import (
    OtherFit,
    equivalent_objective,
    exchanges,
    fits_at,
    other_fits,
    untried_exchanges,
)
from geoswarm.solver.identifiability.optimum.hidden import Unseen, hidden_share, is_sparse
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.identifiability.remedies import Remedy, follow_up
from geoswarm.solver.identifiability.residuals.dependence import dependence_in_words
from geoswarm.solver.identifiability.residuals.independence import SeriesResiduals, examine_residuals
from geoswarm.solver.identifiability.residuals.lack_of_fit import FitVerdict
from geoswarm.solver.identifiability.residuals.readings import is_exact
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.identifiability.stored.correlations import Correlations, correlate
from geoswarm.solver.identifiability.stored.filtering import Filtered, filter_samples, propose_threshold
from geoswarm.solver.identifiability.stored.projections import Projection, project
from geoswarm.solver.identifiability.stored.stored_fit import fit_of_samples
from geoswarm.solver.identifiability.stored.verdict_words import where_intervals_hold
from geoswarm.solver.identifiability.stored.verdicts import Beyond, Verdict, judge
from geoswarm.solver.methods.registry import find_method
from geoswarm.solver.problem.weighting import SeriesShare, series_shares
from geoswarm.solver.words import per_cent

__all__ = ["NOT_AT_OPTIMUM", "TOO_FEW_POINTS", "Basins", "Statistics", "analyse"]

NOT_AT_OPTIMUM = (
    "Intervals are centred on a point that is not the minimum yet ({far:.1f} standard errors away at most): polish it "
    "first."
)

UNKNOWN_OPTIMUM = "Whether the best point is a minimum is unknown, because no parameter has a standard error there."

OTHER_FITS = (
    "Another set of parameters {how} (objective {objective:.4g} against {best:.4g}; up to {limit:.4g} the data cannot "
    "tell them apart at 95 %): {values}. Search around both, or add a measurement that tells them apart."
)

EXCHANGE = (
    "{first} and {second} can be exchanged: with their values swapped the objective is the same. Which is which is not "
    "in the data; give them bounds that do not overlap."
)

SPARSE_RUNS = (
    "Intervals hold within the basin of the optimum, and a basin like this one could still hide in {hidden} of the "
    "searched space, where no run came near."
)

UNFINISHED = (
    "A run points to another basin that the search did not explore: {values} (objective {objective:.4g} against "
    "{best:.4g} at the optimum)."
)

_NEARLY_ALL = 0.99  # of the objective: what a step to the minimum takes off is no error of readings
_AS_WELL = 1.05  # times the objective
_ROUNDING = 1.0 + 1e-9

ON_BOUND = (
    "The best fit lies on the {side} bound of {name}, and the data pull beyond it: widen the bound, unless what lies "
    "beyond is impossible. Intervals of the other parameters hold for {name} on its bound or inside."
)


SELECTED = (
    "The history is long: {read} of its {total} successful evaluations were read, {rule}. "
    "Counts, correlations and widths are of these."
)

TOO_FEW_POINTS = (
    "Too few measurements: {points} of them cannot determine {free} free parameters, so each value is one of many "
    "that fit. Fix or link some parameters, or add measurements."
)


@dataclass(frozen=True, slots=True)
class Basins:
    """What is known of the space beyond the basin of the optimum.

    Parameters
    ----------
    others
        Sets of parameters that the data do not exclude, outside the region of the optimum.
    exchanges
        Pairs of parameters that can be exchanged: a run with their values swapped has the same objective.
    hidden
        Share of the searched space in which a basin like that of the optimum could hide, 0 to 1; None: not known.
    unfinished
        Runs that point to another basin into which nobody has gone down, the best first, at most four.
    untried
        Pairs of parameters that may be exchanged for all that is known, as nobody has run swapped values.
    """

    others: tuple[OtherFit, ...] = ()
    exchanges: tuple[tuple[str, str], ...] = ()
    hidden: float | None = None
    unfinished: tuple[OtherFit, ...] = ()
    untried: tuple[tuple[str, str], ...] = ()

    @property
    def remedies(self) -> tuple[Remedy, ...]:
        """What to do: explore, where another basin is likely or could hide."""
        return (follow_up("explore"),) if self.unfinished or self.untried or is_sparse(self.hidden) else ()

    def to_json(self, names: Sequence[str]) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "others": [other.to_json(names) for other in self.others],
            "exchanges": [list(pair) for pair in self.exchanges],
            "hidden": self.hidden,
            "unfinished": [other.to_json(names) for other in self.unfinished],
            "untried": [list(pair) for pair in self.untried],
            "sentence": where_intervals_hold(self.hidden),
            "what_to_do": [remedy.to_json() for remedy in self.remedies],
        }


@dataclass(frozen=True, slots=True)
class Statistics:
    """Results from stored evaluations.

    Parameters
    ----------
    samples, filtered
        All successful evaluations, and the good fits among them.
    pearson
        Over natural values, as in the published study.
    pearson_search, spearman
        Over search coordinates, and of ranks.
    projections, verdicts
        One a free parameter.
    linearisation
        At the optimum, when it was made.
    residuals
        At the best sample or the optimum, one a series; empty when responses are not stored.
    weights
        Share of each series in the objective at the optimum, or of the best sample.
    warnings
        What to be careful about, in sentences, beyond what ``fit`` says.
    fit
        Whether the model describes the data at all: it stands before the verdicts.
    residuals_at_optimum
        The residuals are those of a polished optimum, not of the best sample.
    basins
        Beyond that of the optimum.
    at_minimum
        The values are those of a minimum, not of the best sample.
    """

    samples: Samples
    filtered: Filtered
    pearson: Correlations
    pearson_search: Correlations
    spearman: Correlations
    projections: tuple[Projection, ...]
    verdicts: tuple[Verdict, ...]
    linearisation: Linearisation | None
    residuals: tuple[SeriesResiduals, ...]
    weights: tuple[SeriesShare, ...]
    warnings: tuple[str, ...]
    fit: FitVerdict
    residuals_at_optimum: bool = False
    basins: Basins = Basins()
    at_minimum: bool = False

    def verdict(self, parameter: str) -> Verdict:
        """The verdict about one parameter."""
        return next(verdict for verdict in self.verdicts if verdict.parameter == parameter)

    @property
    def intervals(self) -> dict[str, tuple[float, float] | None]:
        """95 % interval of each free parameter at the optimum, natural values; None where there is none."""
        found = self.linearisation
        return {name: None if found is None else found.interval(name) for name in self.samples.names}

    @property
    def kinds(self) -> dict[str, str]:
        """Kind of the verdict on each free parameter."""
        return {verdict.parameter: verdict.kind for verdict in self.verdicts}

    def conclusion(self) -> dict[str, Any]:
        """What a search says at its end, as plain JSON: intervals, verdicts as kinds and in words, and the fit."""
        return {
            "intervals": self.intervals,
            "verdicts": self.kinds,
            "verdict_words": {verdict.parameter: verdict.words for verdict in self.verdicts},
            "fit": self.fit.kind,
            "shares": [asdict(share) for share in self.weights],
        }

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, without the samples themselves; None for what is not known."""
        filtered = self.filtered
        return {
            "samples": {
                "total": filtered.total,
                "failed": self.samples.failed,
                "left_out": self.samples.left_out,
                "source": self.samples.source,
                "kept": filtered.kept,
                "kept_unbiased": filtered.kept_unbiased,
            },
            "fit": self.fit.to_json(),
            "threshold": asdict(filtered.threshold),
            "correlations": [_correlation_json(c) for c in (self.pearson, self.pearson_search, self.spearman)],
            "projections": [_projection_json(projection) for projection in self.projections],
            "verdicts": [verdict.to_json() for verdict in self.verdicts],
            "linearisation": None if self.linearisation is None else self.linearisation.to_json(),
            "basins": self.basins.to_json(self.samples.names),
            "residuals_at_optimum": self.residuals_at_optimum,
            "residuals": [residuals.to_json() for residuals in self.residuals],
            "weights": [asdict(weight) for weight in self.weights],
            "warnings": list(self.warnings),
        }


def analyse(
    calibration: Calibration,
    samples: Samples,
    *,
    threshold: float | None = None,
    noise: Mapping[str, float] | float | None = None,
    linearisation: Linearisation | None = None,
    at_optimum: Mapping[str, FloatArray] | None = None,
    elsewhere: Sequence[tuple[FloatArray, float]] = (),
    left: Sequence[tuple[FloatArray, float]] = (),
    bins: int = 30,
) -> Statistics:
    """Analyse stored evaluations; runs no forward calculation.

    Parameters
    ----------
    threshold
        Of the objective; proposed when absent.
    noise
        Known standard deviation of a reading, base units, one for all series or one each; that of the problem file when
        absent.
    linearisation
        At the optimum, from :func:`geoswarm.solver.identifiability.from_evaluations`.
    at_optimum
        Responses at a polished optimum, whose residuals are examined instead of those of the best sample.
    elsewhere
        Parameters, natural values, and objectives of minima in other basins, beyond the samples.
    left
        The same of runs of descents that did not end. They may fit as well, but do not show that a basin is none.
    bins
        Of the projections.

    Raises
    ------
    StatisticsError
        When no evaluation succeeded, or threshold or noise are wrong.
    """
    known = problem_noise(calibration.problem) if noise is None else known_noise(calibration.problem, noise)
    points = calibration.problem.counted_points
    limit = (
        propose_threshold(
            samples, points, noise_objective=None if known is None else noise_objective(calibration.problem, known)
        )
        if threshold is None
        else threshold
    )
    filtered = filter_samples(samples, limit)
    pearson = correlate(filtered.samples)
    pearson_search = correlate(filtered.samples, coordinates="search")
    projections = project(samples, filtered.threshold.value, bins=bins)
    best = samples.best
    misfits = {series: float(values[best]) for series, values in samples.misfits.items()}
    lowest = float(samples.objectives[best])
    if at_optimum:
        misfits_there = calibration.objective.misfits(dict(at_optimum))
        lowest = calibration.objective.value(misfits_there)
    at_minimum = linearisation is not None and lowest <= float(samples.objectives[best]) * _ROUNDING
    if linearisation is not None and at_minimum:  # the minimum is the result, not the best sample
        result = linearisation.optimum.tolist()
        projections = tuple(replace(one, best=value) for one, value in zip(projections, result, strict=True))
    at_best = at_optimum or {series: values[best] for series, values in samples.responses.items()}
    residuals = examine_residuals(calibration, at_best, None if known is None else known.deviations) if at_best else ()
    if at_optimum and at_minimum:
        misfits = misfits_there
    fit = fit_of_samples(calibration, samples, noise=noise) if linearisation is None else linearisation.fit
    warnings = [w for r in residuals for w in r.warnings] if fit.kind in ("untested", "error_not_met") else []
    if linearisation is not None:
        warnings = [*dependence_in_words(linearisation.departures), *warnings]
    if linearisation is not None and not linearisation.at_optimum:
        far = linearisation.far
        warnings.insert(0, UNKNOWN_OPTIMUM if far is None else NOT_AT_OPTIMUM.format(far=far))
    basins = Basins()
    if linearisation is not None and not linearisation.misplaced:
        equal = equivalent_objective(calibration, lowest, known, linearisation)
        every = (*elsewhere, *left)
        others = other_fits(samples, linearisation, equal, lowest, every)
        unseen = Unseen.of(samples, linearisation, lowest, elsewhere)
        found = [samples.to_unit(place) for place in (other.parameters for other in others)]
        unfinished = unseen.unfinished(equal - lowest, found)
        basins = Basins(
            others,
            exchanges(calibration, samples, linearisation, lowest, every),
            hidden_share(calibration.space, unseen, unfinished),
            fits_at(samples, linearisation, equal, lowest, unseen.places_of(calibration.space, unfinished)),
            untried_exchanges(calibration, samples, linearisation, every),
        )
        warnings[:0] = [_other_fit(samples, other, lowest, equal) for other in basins.others]
        warnings[:0] = [EXCHANGE.format(first=first, second=second) for first, second in basins.exchanges]
        warnings += [_left(samples, other, lowest) for other in basins.unfinished]
        warnings += [ON_BOUND.format(name=name, side=side) for name, side in linearisation.held]
        if is_sparse(basins.hidden):
            warnings.append(SPARSE_RUNS.format(hidden=per_cent(basins.hidden)))
    if points < samples.dimension:
        warnings.insert(0, TOO_FEW_POINTS.format(points=points, free=samples.dimension))
    if samples.size and samples.source != "mixed" and (bias := find_method(samples.method).bias):
        warnings.insert(0, bias)
    if samples.left_out:
        evenly = "spread evenly"
        rule = evenly if samples.unbiased.all() else f"half with the lowest objectives, half {evenly}"
        warnings.insert(0, SELECTED.format(read=samples.size, total=samples.size + samples.left_out, rule=rule))
    observed = [o for o in calibration.objective.observed if o.weight > 0]
    exact = bool(at_best) and known is None and all(is_exact(o, o.residuals(at_best[o.series])) for o in observed)
    if linearisation is not None and known is None and not linearisation.held:  # or would be met at the minimum
        exact |= linearisation.model.reachable > _NEARLY_ALL
    spare = None if known is not None else points - samples.dimension
    beyond = Beyond(basins.hidden, exact, spare, basins.unfinished, basins.untried)
    return Statistics(
        samples=samples,
        filtered=filtered,
        pearson=pearson,
        pearson_search=pearson_search,
        spearman=correlate(filtered.samples, method="spearman"),
        projections=projections,
        verdicts=judge(samples, filtered, projections, linearisation, basins.others, fit, beyond),
        linearisation=linearisation,
        residuals=residuals,
        weights=series_shares(calibration.problem, misfits) if misfits else (),
        warnings=tuple(warnings),
        fit=fit,
        residuals_at_optimum=bool(at_optimum),
        basins=basins,
        at_minimum=at_minimum,
    )


def _other_fit(samples: Samples, other: OtherFit, best: float, limit: float) -> str:
    values = ", ".join(f"{name} = {value:.4g}" for name, value in zip(samples.names, other.parameters, strict=True))
    if other.objective < best / _AS_WELL:
        how = "fits better than the optimum"
    elif other.objective <= _AS_WELL * best or best <= 0.0:
        how = "fits as well as the optimum"
    else:
        how = "fits worse than the optimum, but is not excluded"
    return OTHER_FITS.format(how=how, objective=other.objective, best=best, limit=limit, values=values)


def _left(samples: Samples, other: OtherFit, best: float) -> str:
    values = ", ".join(f"{name} = {value:.4g}" for name, value in zip(samples.names, other.parameters, strict=True))
    return UNFINISHED.format(values=values, objective=other.objective, best=best)


def _correlation_json(correlations: Correlations) -> dict[str, Any]:
    return {
        "method": correlations.method,
        "coordinates": correlations.coordinates,
        "level": correlations.level,
        "biased": correlations.biased,
        "pairs": [asdict(pair) | {"correlated": pair.correlated} for pair in correlations],
    }


def _projection_json(projection: Projection) -> dict[str, Any]:
    envelope = [float(v) if np.isfinite(v) else None for v in projection.envelope]
    return asdict(projection) | {
        "edges": projection.edges.tolist(),
        "envelope": envelope,
        "counts": projection.counts.tolist(),
    }
