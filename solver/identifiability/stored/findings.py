"""What the evaluations of follow-ups say.

A follow-up is the problem of a job with another ``method``: ``sensitivity``, ``profile``, ``jackknife``, ``explore``,
``sobol`` or ``morris``; or, with ``predict``, another problem with the parameters of the job. Any engine runs it, and
its stored evaluations alone give the findings: the plan follows from the problem again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import singledispatch
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.errors import SolverError
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.optimum.bending import measure_bending, with_profiles
from geoswarm.solver.identifiability.optimum.differences import differentiate, residual_rows
from geoswarm.solver.identifiability.optimum.leaving_out import WithoutTests
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.identifiability.optimum.profiles import Profile, profiles_of
from geoswarm.solver.identifiability.optimum.refitted import refitted, with_refits
from geoswarm.solver.identifiability.optimum.sensitivity import from_evaluations, linearise
from geoswarm.solver.identifiability.prediction.bands import Prediction, prediction_of
from geoswarm.solver.identifiability.residuals.lack_of_fit import FitVerdict
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.identifiability.stored.global_sensitivity import GlobalSensitivity, analyse_design, outputs_of
from geoswarm.solver.identifiability.stored.stored_fit import fit_of_samples
from geoswarm.solver.identifiability.worth.outcome import Design, design_of
from geoswarm.solver.methods.base import Method
from geoswarm.solver.methods.design import DesignMethod
from geoswarm.solver.methods.explore import ExploreMethod
from geoswarm.solver.methods.given_points import GivenPointsMethod
from geoswarm.solver.methods.global_designs import GlobalMethod
from geoswarm.solver.methods.jackknife import JackknifeMethod
from geoswarm.solver.methods.predict import PredictMethod
from geoswarm.solver.methods.profile import ProfileMethod
from geoswarm.solver.methods.sensitivity import SensitivityMethod
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.answer import Answer
from geoswarm.solver.search.descent.minimum import MinimumSearch
from geoswarm.solver.search.runs import Runs

__all__ = [
    "NO_FINDINGS",
    "Findings",
    "answer_of",
    "findings_of",
    "join_findings",
]

_INCOMPLETE = "the sensitivities are not complete yet"
_NOT_FITTED = ("the fits without each test are not complete yet",)
_TOO_FAR = (
    "{} runs after the search did not reach the minimum, so there are no intervals; give more (answer.max_evaluations)"
)


@dataclass(frozen=True, slots=True)
class Findings:
    """What follow-ups have found.

    Parameters
    ----------
    linearisation
        At the optimum, with standard errors and intervals.
    objective, start_objective
        f there, and where the descent began (the same without one).
    profiles
        As far as they have got.
    global_sensitivities
        One an output: the objective, and each series.
    notes
        Why something could not be had, in sentences.
    responses
        Calculated values there, by series, base units; empty without a linearisation.
    fit
        Whether the model describes the data; None where nothing was evaluated at an optimum.
    explored, left
        Parameters, natural values, and objectives of successful runs that looked for further basins; ``left``: of
        descents that did not end.
    predictions
        Bands of other problems.
    designs
        Candidate tests in order of their worth.
    jackknife
        The optimum without each test, by further runs.
    """

    linearisation: Linearisation | None = None
    objective: float | None = None
    start_objective: float | None = None
    profiles: tuple[Profile, ...] = ()
    global_sensitivities: tuple[GlobalSensitivity, ...] = ()
    notes: tuple[str, ...] = ()
    responses: Mapping[str, FloatArray] = field(default_factory=dict)
    fit: FitVerdict | None = None
    explored: tuple[tuple[FloatArray, float], ...] = ()
    left: tuple[tuple[FloatArray, float], ...] = ()
    predictions: tuple[Prediction, ...] = ()
    designs: tuple[Design, ...] = ()
    jackknife: WithoutTests | None = None

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "fit": None if self.fit is None else self.fit.to_json(),
            "linearisation": None if self.linearisation is None else self.linearisation.to_json(),
            "objective": self.objective,
            "start_objective": self.start_objective,
            "profiles": [profile.to_json() for profile in self.profiles],
            "global_sensitivities": [found.to_json() for found in self.global_sensitivities],
            "explored": len(self.explored) + len(self.left),
            "predictions": [prediction.to_json() for prediction in self.predictions],
            "designs": [design.to_json() for design in self.designs],
            "jackknife": None if self.jackknife is None else self.jackknife.to_json(),
            "notes": list(self.notes),
        }


NO_FINDINGS = Findings()


def findings_of(
    problem: Problem,
    seed: int,
    evaluations: Sequence[Evaluation],
    *,
    noise: Mapping[str, float] | float | None = None,
    level: float = 0.95,
) -> Findings:
    """Read the evaluations of a follow-up, finished or not.

    Parameters
    ----------
    evaluations
        All of finished generations, in the order of generation and particle, failed ones too.
    noise
        Known standard deviation of a reading, base units; that of the problem file when absent. Profiles end where the
        noise that was known when they were asked for says.

    Raises
    ------
    StatisticsError
        When the problem is not a follow-up, or the noise is wrong.
    """
    calibration = Calibration(problem, seed)
    method = problem.method
    if method.role != "follow_up":
        raise StatisticsError(f"a job with method {method.kind} is not a follow-up")
    return examine(method, calibration, evaluations, noise, level)


@singledispatch
def examine(
    method: Method,
    calibration: Calibration,
    evaluations: Sequence[Evaluation],
    noise: Mapping[str, float] | float | None,
    level: float,
) -> Findings:
    """Return the findings from the evaluations of a follow-up; each method registers its own function.

    Raises
    ------
    StatisticsError
        When the method has none.
    """
    del calibration, evaluations, noise, level
    raise StatisticsError(f"the evaluations of method {method.kind} have no interpretation")


@examine.register
def _sensitivity(
    method: SensitivityMethod,
    calibration: Calibration,
    evaluations: Sequence[Evaluation],
    noise: Mapping[str, float] | float | None,
    level: float,
) -> Findings:
    search = method.search(calibration.space)
    if isinstance(search, MinimumSearch):
        return _of_minimum(search, calibration, evaluations, noise, level)
    start = evaluations[0].objective if evaluations else None
    positions, rows = _runs(calibration, evaluations)
    position = first = last_difference = 0
    while (due := search.ask()) is not None:
        if search.descending:
            first = position + len(due)  # of the differences
        if search.ends is None:
            last_difference = position + len(due)
        elif position + len(due) > len(evaluations):
            break  # not tested yet whether the model is nonlinear
        if position + len(due) > len(evaluations):
            going_on = "the descent to the minimum has not ended" if search.descending else _INCOMPLETE
            return Findings(start_objective=start, notes=(going_on,))
        position += len(due)
        _tell(search, positions[:position], rows[:position], len(due))
    plan, last = search.plan, evaluations[first:last_difference]
    if search.steps is not None:
        plan, chosen = search.steps.chosen(rows[first:last_difference])
        last = [last[row] for row in chosen]
    try:
        found = from_evaluations(calibration, plan, last, noise=noise, level=level)
    except StatisticsError as error:
        if noise is not None:
            raise
        return Findings(start_objective=start, notes=(str(error),))
    if search.ends is not None and position > last_difference:
        found = measure_bending(calibration, found, search.ends, evaluations[last_difference:position])
    return Findings(found, last[0].objective, start, responses=dict(last[0].responses), fit=found.fit)


def _of_minimum(
    search: MinimumSearch,
    calibration: Calibration,
    evaluations: Sequence[Evaluation],
    noise: Mapping[str, float] | float | None,
    level: float,
) -> Findings:
    rows = _replay(search, calibration, evaluations)
    start = evaluations[0].objective if evaluations else None
    if search.differences is None:
        return Findings(start_objective=start, notes=(_INCOMPLETE,))
    steps, first = search.differences
    plan, chosen = steps.chosen(rows[first:])
    walk = search.walk(rows)
    best = evaluations[walk.row]
    if walk.far:
        return Findings(start_objective=start, notes=(_TOO_FAR.format(search.told),))
    try:
        jacobian = differentiate(calibration, plan, [evaluations[first + row] for row in chosen])
        there = replace(jacobian, optimum=search.place(walk.row), responses=dict(best.responses))
        found = linearise(calibration, there, noise=noise, level=level)
    except StatisticsError as error:
        if noise is not None:
            raise
        return Findings(start_objective=start, notes=(str(error),))
    if search.ends is not None:
        ends = len(search.ends.positions)
        found = measure_bending(calibration, found, search.ends, evaluations[search.told - ends : search.told])
    return Findings(found, best.objective, start, responses=dict(best.responses), fit=found.fit)


def answer_of(
    calibration: Calibration,
    answer: Answer,
    evaluations: Sequence[Evaluation],
    *,
    noise: Mapping[str, float] | float | None = None,
    level: float = 0.95,
) -> Findings:
    """Read the evaluations after a search, finished or not.

    Parameters
    ----------
    answer
        What they are.
    evaluations, noise
        As for :func:`findings_of`.
    """
    begins = [part.evaluations - answer.evaluations for part in answer.parts]
    parts = [
        examine(part.method, calibration, evaluations[first:last], noise, level)
        for part, first, last in zip(answer.parts, begins, [*begins[1:], len(evaluations)], strict=True)
    ]
    return join_findings(parts[::-1])


@examine.register
def _profiles(
    method: ProfileMethod,
    calibration: Calibration,
    evaluations: Sequence[Evaluation],
    noise: Mapping[str, float] | float | None,
    level: float,  # noqa: ARG001  the form of all
) -> Findings:
    search = method.search(calibration.space)
    _replay(search, calibration, evaluations)
    notes = []
    if search.failed:
        notes.append(_optimum_failed(evaluations[0]))
    elif not search.finished:
        notes.append("the profiles are not complete yet")
    samples = Samples.from_evaluations(calibration.problem, evaluations)
    fit = None if search.objective is None else fit_of_samples(calibration, samples, noise=noise)
    return Findings(objective=search.objective, profiles=profiles_of(search), notes=tuple(notes), fit=fit)


@examine.register
def _jackknife(
    method: JackknifeMethod,
    calibration: Calibration,
    evaluations: Sequence[Evaluation],
    noise: Mapping[str, float] | float | None,  # noqa: ARG001  the form of all
    level: float,
) -> Findings:
    search = method.search(calibration.space, calibration.problem.series_by_test)
    _replay(search, calibration, evaluations)
    if search.failed:
        return Findings(notes=(_optimum_failed(evaluations[0]),))
    found = refitted(search, calibration.space, level)
    return Findings(jackknife=found, notes=_NOT_FITTED if found is None else found.notes)


@examine.register
def _explored(
    method: ExploreMethod, calibration: Calibration, evaluations: Sequence[Evaluation], *_options: Any
) -> Findings:
    search = method.search(calibration.space)
    _replay(search, calibration, evaluations)
    unended = set(search.left)
    made = [(row, (e.parameters, e.objective)) for row, e in enumerate(evaluations) if e.objective is not None]
    return Findings(
        explored=tuple(run for row, run in made if row not in unended),
        left=tuple(run for row, run in made if row in unended),
    )


@examine.register
def _looked_ahead(
    method: GivenPointsMethod, calibration: Calibration, evaluations: Sequence[Evaluation], *_options: Any
) -> Findings:
    try:
        if isinstance(method, DesignMethod):
            return Findings(designs=(design_of(calibration, method, evaluations),))
        if isinstance(method, PredictMethod):
            return Findings(predictions=(prediction_of(calibration, method, evaluations),))
    except StatisticsError as error:
        return Findings(notes=(f"{calibration.problem.name}: {error}",))
    raise StatisticsError(f"the evaluations of method {method.kind} have no interpretation")


@examine.register
def _indices(
    method: GlobalMethod, calibration: Calibration, evaluations: Sequence[Evaluation], *_options: Any
) -> Findings:
    plan = method.points(calibration.space, calibration.seed)
    if len(evaluations) < len(plan.positions):
        return Findings(notes=(f"{len(evaluations)} of {len(plan.positions)} evaluations of the design are done",))
    found, notes = [], []
    for output in ("objective", *(o.series for o in calibration.objective.observed)):
        outputs = outputs_of(calibration, evaluations, output)
        try:
            found.append(analyse_design(calibration, plan, outputs, output=output, seed=calibration.seed % 2**32))
        except SolverError as error:
            notes.append(f"{output}: {error}")
    return Findings(global_sensitivities=tuple(found), notes=tuple(dict.fromkeys(notes)))


def _optimum_failed(evaluation: Evaluation) -> str:
    return f"the evaluation of the optimum failed ({evaluation.reason}): {evaluation.message}"


def _runs(calibration: Calibration, evaluations: Sequence[Evaluation]) -> tuple[FloatArray, FloatArray]:
    """Positions, natural values, and weighted residuals of evaluations."""
    return np.array([one.parameters for one in evaluations]), residual_rows(calibration, evaluations)


def _tell(search: Any, positions: FloatArray, rows: FloatArray, count: int) -> None:
    """Tell a search the last ``count`` of these runs; it may look back at the others."""
    runs = Runs.of(positions, rows)
    search.tell(runs.objectives[-count:], runs)


def _replay(search: Any, calibration: Calibration, evaluations: Sequence[Evaluation]) -> FloatArray:
    """Tell a search all whole generations of its evaluations; return their weighted residuals, shape (n, m)."""
    (positions, rows), told = _runs(calibration, evaluations), 0
    while (due := search.ask()) is not None and told + len(due) <= len(evaluations):
        told += len(due)
        _tell(search, positions[:told], rows[:told], len(due))
    return rows[:told]


def join_findings(parts: Sequence[Findings]) -> Findings:
    """Join what several follow-ups of one job have found; of two of a kind the first counts.

    Where the model is nonlinear within an interval, a complete profile gives it.
    """
    with_optimum = next((part for part in parts if part.linearisation is not None), NO_FINDINGS)
    profiles: dict[str, Profile] = {}
    indices: dict[tuple[str, str], GlobalSensitivity] = {}
    predictions: dict[str, Prediction] = {}
    for part in parts:
        for profile in part.profiles:
            profiles.setdefault(profile.parameter, profile)
        for index in part.global_sensitivities:
            indices.setdefault((index.kind, index.output), index)
        for prediction in part.predictions:
            predictions.setdefault(prediction.name, prediction)
    designs = next((part.designs for part in parts if part.designs), ())
    jackknife = next((part.jackknife for part in parts if part.jackknife is not None), None)
    notes = dict.fromkeys(note for part in parts for note in part.notes)
    linearisation = with_optimum.linearisation
    if linearisation is not None:
        wanted = [profile for name, profile in profiles.items() if linearisation.nonlinear(name)]
        linearisation = with_profiles(linearisation, wanted)
        linearisation = linearisation if jackknife is None else with_refits(linearisation, jackknife)
    return Findings(
        linearisation,
        with_optimum.objective,
        with_optimum.start_objective,
        tuple(profiles.values()),
        tuple(indices.values()),
        tuple(notes),
        with_optimum.responses,
        with_optimum.fit or next((part.fit for part in parts if part.fit is not None), None),
        tuple(run for part in parts for run in part.explored),
        tuple(run for part in parts for run in part.left),
        tuple(predictions.values()),
        designs,
        jackknife,
    )
