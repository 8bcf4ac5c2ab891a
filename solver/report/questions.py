"""Starting point of follow-ups, from the report of a run: parameters with all that is known about them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

from scipy.special import ndtri, stdtrit

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import SolverError
from geoswarm.solver.identifiability import Linearisation, Statistics, StatisticsError
from geoswarm.solver.identifiability.noise import Noise, known_noise, problem_noise
from geoswarm.solver.identifiability.optimum.hidden import is_sparse
from geoswarm.solver.identifiability.prediction.draws import (
    Basin,
    ParameterSample,
    basins_of,
    draw_around,
    take_from,
)
from geoswarm.solver.identifiability.prediction.question import MOST_RUNS, predict_problem
from geoswarm.solver.identifiability.prediction.shapes import shape_of
from geoswarm.solver.identifiability.residuals.dependence import DependenceKind
from geoswarm.solver.identifiability.stored.follow_ups import at_minimum
from geoswarm.solver.identifiability.stored.posterior import Posterior
from geoswarm.solver.identifiability.worth.candidates import read_candidates, read_predicted
from geoswarm.solver.identifiability.worth.question import MOST_DRAWS, design_problem
from geoswarm.solver.methods.design import Criterion
from geoswarm.solver.problem import Problem
from geoswarm.solver.report.document.build import Report
from geoswarm.solver.words import listed, per_cent

__all__ = [
    "DEFAULT_DRAWS",
    "DEFAULT_LEVEL",
    "DEFAULT_RUNS",
    "Known",
    "Source",
    "design_question",
    "known_of",
    "prediction_question",
    "sample_of",
]

KnownNoise: TypeAlias = Mapping[str, float] | float | None
Source: TypeAlias = Literal["auto", "posterior", "covariance"]

DEFAULT_RUNS, DEFAULT_LEVEL, DEFAULT_DRAWS = 200, 0.9, 8
_FEWEST_RUNS = 20

_WIDER: dict[DependenceKind, str] = {
    "correlated": "the residuals are correlated",
    "uneven": "the residuals are uneven",
    "possible": "so few readings cannot exclude that their errors are correlated",
    "stated": "the errors of the readings are correlated, as stated",
}
_CONTAINS = (
    "the band covers the effect of the uncertainty of the identified parameters, {level} at each x. It "
    "holds neither the error of a reading nor what the forward model itself lacks"
)

_NOTHING_HOLDS = "So the sensitivities are those of a model that does not describe the data, and the order may be wrong"


@dataclass(frozen=True, slots=True)
class Known:
    """What a run has found, ready for what follows: its optimum and all basins."""

    calibration: Calibration
    statistics: Statistics
    linearisation: Linearisation
    basins: list[Basin]
    noise: Noise | None


def known_of(report: Report, noise: KnownNoise = None) -> Known:
    """Take optimum and basins from a report.

    Raises
    ------
    NotExaminedError
        When there are no sensitivities at a minimum.
    StatisticsError
        When no evaluation has succeeded, or the error of a reading is not known.
    """
    problem, statistics = report.problem, report.statistics
    if statistics is None:
        raise StatisticsError("no evaluation has succeeded yet, so no parameters are identified")
    found = at_minimum(statistics.linearisation)
    calibration = Calibration(problem, report.record.seed)
    known = problem_noise(problem) if noise is None else known_noise(problem, noise)
    others = [(other.parameters, other.objective) for other in statistics.basins.others]
    lowest = report.lowest_objective
    basins = basins_of(calibration, found, lowest, others, statistics.basins.exchanges, known)
    return Known(calibration, statistics, found, basins, known)


def sample_of(
    known: Known,
    runs: int,
    seed: int,
    *,
    source: Source = "auto",
    posterior: Callable[[], Posterior] | None = None,
) -> tuple[ParameterSample, list[str]]:
    """Draw the parameters; return them with what is to be said of them.

    Parameters
    ----------
    source
        ``auto`` takes the covariance where the model is nearly linear over the uncertainty, or where there are several
        basins or dependent residuals, and a trusted posterior sample where it bends.
    posterior
        Samples the posterior from stored evaluations.

    Raises
    ------
    StatisticsError
        When a posterior sample is wanted and cannot be had, or ``runs`` is wrong.
    """
    if not _FEWEST_RUNS <= runs <= MOST_RUNS:
        raise StatisticsError(f"runs must be from {_FEWEST_RUNS} to {MOST_RUNS}, got {runs}")
    found, several = known.linearisation, len(known.basins) > 1
    nonlinear = [name for name in found.names if found.nonlinear(name)]
    remarks: list[str] = []
    if source == "posterior" or (source == "auto" and nonlinear and not several and not found.departures):
        try:
            if posterior is None:
                raise StatisticsError("no posterior sample is available here")
            sample = posterior()
            if source == "auto" and not sample.trusted:
                raise StatisticsError(f"the posterior sample cannot be trusted ({'; '.join(sample.warnings)})")
        except SolverError as error:
            if source == "posterior":
                raise
            remarks.append(
                f"the fit is nonlinear within the interval of {' and '.join(nonlinear)}, and {error}: "
                "the band rests on the linearised fit and is approximate"
            )
        else:
            shape = shape_of(found)
            cut = tuple(
                name for name, (low, _) in zip(sample.names, sample.intervals.tolist(), strict=True) if low != low
            )
            remarks.append(
                "the parameters are those of a posterior sample through the response surface of the stored evaluations"
                + (f"; that of {', '.join(cut)} reaches the edge of the sampled region" if cut else "")
            )
            optimum = known.basins[0].optimum
            taken = take_from(
                known.calibration,
                optimum,
                sample.parameters,
                runs - 1,
                cut,
                shape.degrees_of_freedom,
                seed,
                found.widest,
            )
            return taken, remarks
    elif nonlinear:
        remarks.append(
            f"the fit is nonlinear within the interval of {' and '.join(nonlinear)}: "
            "the band rests on the linearised fit and is approximate"
        )
    return draw_around(known.calibration, known.basins, runs - len(known.basins), seed), remarks


def prediction_question(
    report: Report,
    other: Mapping[str, Any] | Path,
    *,
    runs: int = DEFAULT_RUNS,
    level: float = DEFAULT_LEVEL,
    noise: KnownNoise = None,
    source: Source = "auto",
    posterior: Callable[[], Posterior] | None = None,
    of: str | None = None,
    programs: bool = False,
) -> Problem:
    """The problem of a prediction: ``other`` with the parameters of a run; see :func:`predict_problem`.

    Parameters
    ----------
    runs
        Forward runs: the optima of all basins, the others drawn.
    level
        Of the band.

    Raises
    ------
    NotExaminedError, StatisticsError, ProblemError
    """
    if not 0.0 < level < 1.0:
        raise StatisticsError(f"level must be between 0 and 1, got {level:g}")
    known = known_of(report, noise)
    seed = report.record.seed
    sample, remarks = sample_of(known, runs, seed, source=source, posterior=posterior)
    found = known.linearisation
    return predict_problem(
        report.problem,
        other,
        sample,
        seed=seed,
        level=level,
        readings=_errors_of(report.problem, found.noise),
        alarm=_alarm(known.statistics),
        remarks=[_CONTAINS.format(level=per_cent(level)), *remarks, *_said(known, sample)],
        of=of,
        programs=programs,
    )


def _errors_of(problem: Problem, noise: Noise | None) -> dict[str, float]:
    """Errors of a reading by series, base units, without those whose noise is one of pseudo residuals or distances."""
    unlike = {o.series for o in problem.observations if o.loss is not None or o.along is not None}
    return {} if noise is None else {series: size for series, size in noise.deviations.items() if series not in unlike}


def design_question(
    report: Report,
    candidates: Mapping[str, Any] | Path,
    *,
    predict: Mapping[str, Any] | Path | None = None,
    criterion: Criterion | None = None,
    draws: int = DEFAULT_DRAWS,
    noise: KnownNoise = None,
    of: str | None = None,
    programs: bool = False,
) -> Problem:
    """The problem of the worth of candidate tests; see :func:`design_problem`.

    Parameters
    ----------
    candidates, predict
        Candidates, and the problem of which a prediction is to become narrower, as documents or files.
    draws
        Places around the optima over which the worth is averaged, as the model is nonlinear.

    Raises
    ------
    NotExaminedError, StatisticsError, ProblemError
    """
    if not 0 <= draws <= MOST_DRAWS:
        raise StatisticsError(f"draws must be from 0 to {MOST_DRAWS}, got {draws}")
    if criterion == "prediction" and predict is None:
        raise StatisticsError("criterion prediction needs the problem that is to be predicted (predict)")
    known = known_of(report, noise)
    found, seed = known.linearisation, report.record.seed
    assert found.noise is not None  # or its basins would have no shape
    freedom = found.noise.degrees_of_freedom
    errors = _errors_of(report.problem, found.noise)
    remarks = [
        "expected from sensitivities, for readings with independent errors of the stated size, and a model that "
        "describes them"
    ]
    remarks += [text for text in _said(known, None) if "drawn over" not in text]
    undecided = [n for n, open_ in zip(found.names, known.basins[0].shape.undecided, strict=True) if open_]
    if undecided:
        remarks.append(
            f"the data leave {' and '.join(undecided)} undecided: the reduction is that of the searched range"
        )
    return design_problem(
        known.calibration,
        known.basins,
        read_candidates(report.problem, candidates, errors, programs=programs),
        seed=seed,
        quantile=float(ndtri(0.975) if freedom == float("inf") else stdtrit(freedom, 0.975)),
        draws=draws,
        predicted=None if predict is None else read_predicted(report.problem, predict, programs=programs),
        criterion=criterion,
        alarm=None if not known.statistics.fit.wrong else f"{known.statistics.fit.sentence} {_NOTHING_HOLDS}",
        remarks=remarks,
        of=of,
    )


def _alarm(statistics: Statistics) -> str | None:
    fit = statistics.fit
    if not fit.wrong:
        return None
    return (
        f"{fit.sentence} So the band holds the uncertainty of the parameters only, not what the model lacks: expect "
        "readings outside it"
    )


def _said(known: Known, sample: ParameterSample | None) -> list[str]:
    """What the band rests on, in sentences."""
    found, names = known.linearisation, known.calibration.free_names
    said = []
    if len(known.basins) > 1:
        told = "; ".join(
            f"{', '.join(f'{name} = {value:.4g}' for name, value in zip(names, basin.optimum, strict=True))} with "
            f"{per_cent(basin.share)}"
            for basin in known.basins
        )
        said.append(
            f"the data allow {len(known.basins)} sets of parameters, and all of them take part by their weights: {told}"
        )
    if sample is not None and sample.undecided:
        said.append(
            f"the data leave {' and '.join(sample.undecided)} undecided: drawn over the searched range, as far as what "
            "the data do determine allows"
        )
    widest = found.widest
    if found.dependence and widest > 1.0:
        why = listed(list(dict.fromkeys(_WIDER[one.kind] for one in found.dependence)))
        said.append(f"the parameters scatter {widest:.2g} times as widely, as their intervals do, because {why}")
    if not found.at_optimum and found.far is not None:
        said.append(f"the search had not reached the minimum: it is {found.far:.1f} standard errors away")
    said += [f"{name} lies on its {side} bound: its distribution is cut there" for name, side in found.held]
    hidden = known.statistics.basins.hidden
    if is_sparse(hidden):
        said.append(
            f"another basin could still hide in {per_cent(hidden)} of the searched space, which takes no part: "
            "the follow-up explore looks there"
        )
    return said
