"""The runs after a search that its result needs: begun when it ends, each follow-up planned from those before.

Sensitivities and the steps to the minimum come first. Descents then begin where stored runs point to another basin,
and profiles give the intervals within which the model is nonlinear. A better minimum begins all of it again.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability.optimum.profiles import profile_settings
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.identifiability.stored.exploring import other_starts
from geoswarm.solver.identifiability.stored.findings import Findings, answer_of
from geoswarm.solver.identifiability.stored.study import Statistics, analyse
from geoswarm.solver.methods.base import FollowUpMethod, Maker, Task, by_name
from geoswarm.solver.methods.explore import ExploreMethod
from geoswarm.solver.methods.profile import ProfileMethod
from geoswarm.solver.methods.sensitivity import SensitivityMethod
from geoswarm.solver.progress.answer import Answer, Part
from geoswarm.solver.progress.state import Best, Progress, Step
from geoswarm.solver.progress.stopping import MaxSeconds, StopCriterion, evaluations_left
from geoswarm.solver.search.descent.minimum import LOST_IN_NOISE, MinimumSearch
from geoswarm.solver.search.runs import Runs

__all__ = ["begin_answer", "conclude", "go_on_answering"]

_MOST_MINIMA = 4  # that sensitivities are calculated at
_MOST_EXPLORATIONS = 4  # around one minimum, of twelve places or more each
_MOST_JUDGED = 20_000  # runs of a search that verdicts are based on
_BETTER = 1e-9  # relative decrease of the objective


def begin_answer(
    calibration: Calibration, ended: Progress, reasons: tuple[str, ...], limits: Sequence[StopCriterion]
) -> Step | None:
    """Begin them where a search has found something and there is room; None otherwise.

    Parameters
    ----------
    ended
        The search at its end.
    reasons
        Why it ended.
    limits
        Stop criteria of the job.
    """
    problem, best = calibration.problem, ended.best
    if best is None or not problem.answers:
        return None
    free, quick = calibration.space.dimension, problem.forward_model.quick
    most, left = problem.answer.most(free, ended.evaluations, quick=quick), evaluations_left(limits, ended.evaluations)
    ahead = None if ended.ahead is None else ended.ahead.tolist()
    most = most if left is None else min(most, left)
    answer = Answer(most, best.objective, reasons, ended.positions.tolist(), ahead)
    begun = _begin(calibration, ended, answer, _sensitivity(calibration, best, answer.most))
    return None if begun is None else Step(begun, ())


def go_on_answering(
    calibration: Calibration,
    progress: Progress,
    objectives: FloatArray,
    runs: Runs,
    limits: Sequence[StopCriterion],
    seconds: float,
) -> Step:
    """Close a generation of them.

    Parameters
    ----------
    objectives
        f of each particle, inf where it failed.
    runs
        All evaluations so far, this generation included.
    limits
        Stop criteria of the job.
    seconds
        Its running time so far [s].
    """
    answer = progress.answer
    assert answer is not None
    part = answer.parts[-1]
    search = _maker(calibration, part.method).restore(part.snapshot)
    best = _best(calibration, progress, search, objectives)
    search.tell(objectives, runs)
    positions = search.ask()
    answer = replace(answer, parts=(*answer.parts[:-1], replace(part, snapshot=search.snapshot())))
    after = replace(
        progress,
        generation=progress.generation + 1,
        positions=np.empty((0, calibration.space.dimension)) if positions is None else positions,
        evaluations=progress.evaluations + len(objectives),
        failed=progress.failed + int(np.isinf(objectives).sum()),
        best=best,
        answer=answer,
    )
    if any(isinstance(one, MaxSeconds) and seconds >= one.limit for one in limits):
        return Step(after, answer.reasons)
    if 0 < len(after.positions) <= _room(after):
        return Step(after, ())
    for method in _further(calibration, after, runs):
        if (begun := _begin(calibration, after, answer, method)) is not None:
            return Step(begun, ())
    return Step(replace(after, positions=np.empty((0, calibration.space.dimension))), answer.reasons)


def conclude(calibration: Calibration, progress: Progress, runs: Runs) -> Statistics | None:
    """Return what a job says of its parameters when these runs have ended; None where they gave no sensitivities.

    Parameters
    ----------
    runs
        All evaluations.
    """
    answer = progress.answer
    assert answer is not None
    findings = answer_of(calibration, answer, _evaluations(calibration, progress, answer, runs))
    if findings.linearisation is None:
        return None
    samples = _searched(calibration, answer, runs)
    if samples.size > _MOST_JUDGED:  # the best, and others spread evenly
        order = np.argsort(samples.objectives, kind="stable")
        half = _MOST_JUDGED // 2
        samples = samples.select(np.sort(np.append(order[:half], order[half :: -(-len(order) // half)])))
    return analyse(
        calibration,
        samples,
        linearisation=findings.linearisation,
        at_optimum=findings.responses,
        elsewhere=findings.explored,
        left=findings.left,
    )


def _room(progress: Progress) -> int:
    """How many evaluations may follow."""
    answer = progress.answer
    return 0 if answer is None else answer.evaluations + answer.most - progress.evaluations


def _maker(calibration: Calibration, method: FollowUpMethod) -> Maker:
    nothing = np.full(calibration.space.dimension, np.nan)
    return method.maker(Task(calibration.space, calibration.seed, nothing, None, None))


def _begin(calibration: Calibration, progress: Progress, answer: Answer, method: FollowUpMethod) -> Progress | None:
    """Ask for the first generation of a follow-up; None where it has none, or there is no room."""
    search = _maker(calibration, method).start(1)
    positions = search.ask()
    document = method.model_dump(mode="json", exclude_none=True)
    part = Part(document, progress.generation, progress.evaluations, search.snapshot())
    answer = replace(answer, parts=(*answer.parts, part))
    begun = replace(progress, ahead=None, ahead_begun=False, answer=answer)
    if positions is None or len(positions) > _room(begun):
        return None
    return replace(begun, positions=positions)


def _best(calibration: Calibration, progress: Progress, search: object, objectives: FloatArray) -> Best | None:
    """The best evaluation after a generation. A neighbour of the minimum is none: it may be lower by chance."""
    best, particle = progress.best, int(np.argmin(objectives))
    walking = isinstance(search, MinimumSearch)
    if isinstance(search, MinimumSearch) and not search.trying:
        return best
    if best is not None and objectives[particle] >= best.objective * (1.0 if walking else _lower(calibration)):
        return best
    return Best(float(objectives[particle]), progress.generation, particle, progress.positions[particle].copy())


def _lower(calibration: Calibration) -> float:
    """How many times an objective another one must be to belong to a better minimum, and not to the same one."""
    return 1.0 - max(_BETTER, LOST_IN_NOISE / max(calibration.problem.counted_points - calibration.space.dimension, 1))


def _sensitivity(calibration: Calibration, best: Best, runs: int) -> SensitivityMethod:
    return SensitivityMethod(at=by_name(calibration.space, best.parameters), polish=True, runs=max(runs, 1))


def _further(calibration: Calibration, progress: Progress, runs: Runs) -> Iterator[FollowUpMethod]:
    """What may follow, the most useful first."""
    answer, best, room = progress.answer, progress.best, _room(progress)
    if answer is None or best is None or room < 1:
        return
    findings = answer_of(calibration, answer, _evaluations(calibration, progress, answer, runs))
    found = findings.linearisation
    if found is None or findings.objective is None:
        return
    methods = [part.method for part in answer.parts]
    minima = sum(isinstance(method, SensitivityMethod) for method in methods)
    if best.objective < findings.objective * _lower(calibration):
        if minima < _MOST_MINIMA:
            yield _sensitivity(calibration, best, room)
        return
    last = max(place for place, method in enumerate(methods) if isinstance(method, SensitivityMethod))
    since = methods[last + 1 :]
    if sum(isinstance(method, ExploreMethod) for method in since) < _MOST_EXPLORATIONS:
        points = _elsewhere(calibration, answer, findings, runs)[:room]
        if points:
            listed = dict(zip(calibration.free_names, np.array(points).T.tolist(), strict=True))
            at = by_name(calibration.space, found.optimum)
            yield ExploreMethod(at=at, points=listed, runs=room, objective=findings.objective)
    unprofiled = [name for name in found.names if found.needs_profile(name)]
    if unprofiled and not any(isinstance(method, ProfileMethod) for method in since):
        settings = profile_settings(calibration, found, parameters=unprofiled)
        at, rise, step = (
            by_name(calibration.space, values) for values in (settings.optimum, settings.rise, settings.step)
        )
        yield ProfileMethod(at=at, rise={n: rise[n] for n in unprofiled}, step={n: step[n] for n in unprofiled})


def _elsewhere(calibration: Calibration, answer: Answer, findings: Findings, runs: Runs) -> list[FloatArray]:
    """Where to look for other basins, natural values: not where parts of the answer began to look already."""
    assert findings.linearisation is not None
    assert findings.objective is not None
    samples, names = _searched(calibration, answer, runs), calibration.free_names
    explored = [part.method for part in answer.parts if isinstance(part.method, ExploreMethod)]
    looked = [np.array(place) for one in explored for place in zip(*(one.points[name] for name in names), strict=True)]
    return other_starts(calibration, samples, findings.linearisation, findings.objective, findings.explored, looked)


def _searched(calibration: Calibration, answer: Answer, runs: Runs) -> Samples:
    """The runs of the search."""
    first = _offered(calibration)
    rows = slice(first, first + answer.evaluations)
    return Samples.from_arrays(calibration.problem, runs.positions[rows], runs.objectives[rows])


def _offered(calibration: Calibration) -> int:
    """How many runs of earlier jobs come before those of this one."""
    return 0 if calibration.offered is None else len(calibration.offered.positions)


def _evaluations(calibration: Calibration, progress: Progress, answer: Answer, runs: Runs) -> list[Evaluation]:
    """The evaluations after the search, with their responses."""
    first = _offered(calibration)
    rows = np.arange(first + answer.evaluations, first + progress.evaluations)
    responses = iter(runs.responses(rows[runs.succeeded[rows]]))
    made = []
    for row in rows.tolist():
        objective = float(runs.objectives[row]) if runs.succeeded[row] else None
        curves = {} if objective is None else dict(next(responses))
        misfits = {} if objective is None else calibration.objective.misfits(curves)
        reason = "error" if objective is None else None
        made.append(Evaluation(runs.positions[row], objective, misfits, curves, reason, None, 0.0))
    return made
