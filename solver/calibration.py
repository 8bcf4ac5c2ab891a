"""Assembles a problem into what a calibration needs: evaluate one particle, advance one generation.

Both the in-process loop and the distributed engine go through :meth:`Calibration.advance`, so they cannot differ.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geoswarm.solver.answer import Answer
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import ForwardError, message_of
from geoswarm.solver.methods.base import Task
from geoswarm.solver.methods.widths import REMEMBERED, Situation
from geoswarm.solver.objective import LeastSquares, ObservedSeries
from geoswarm.solver.objective.outcome import ForwardOutcome, outcome_of
from geoswarm.solver.offer import Offer
from geoswarm.solver.problem import Problem, Stopping
from geoswarm.solver.problem.running import SHARE_OF_SEARCH, Failures
from geoswarm.solver.progress import Best, Progress, Step
from geoswarm.solver.search import Runs, Search, WideSearch
from geoswarm.solver.search.descent.minimum import MinimumSearch
from geoswarm.solver.space import search_space
from geoswarm.solver.stopping import (
    MaxEvaluations,
    MaxSeconds,
    StagnationGenerations,
    StopCriterion,
    SwarmStatus,
    TargetObjective,
    satisfied_reasons,
)

__all__ = [
    "Best",
    "Calibration",
    "Evaluation",
    "Offer",
    "Progress",
    "Step",
    "choose_seed",
    "stop_criteria",
    "with_further_tries",
]


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Outcome of one forward calculation; it failed if ``reason`` is not None.

    Parameters
    ----------
    parameters
        Natural values of the free parameters, shape (d,).
    objective
        f, None when failed.
    misfits, responses
        f'_g and calculated values, shape (m_g,), of each observed series; empty when failed.
    reason, message
        Kind of failure (:data:`geoswarm.solver.errors.FailureReason`) and what happened; for a success, a note or None.
    seconds
        Wall time of the forward calculation [s].
    """

    parameters: FloatArray
    objective: float | None
    misfits: dict[str, float]
    responses: dict[str, FloatArray]
    reason: str | None
    message: str | None
    seconds: float


class Calibration:
    """A problem made ready: its forward run, objective, search space and stop criteria.

    Parameters
    ----------
    problem, seed
        What to calibrate, and the seed of all random numbers.
    offer
        Runs of earlier jobs; used by an accelerated search.

    Raises
    ------
    ProblemError
        When the forward model cannot be prepared for the observed points.
    """

    def __init__(self, problem: Problem, seed: int, offer: Offer | None = None) -> None:
        self.problem = problem
        self.seed = seed
        self.free_names = problem.free_names
        observed = [ObservedSeries(o.series, o.x, o.y, o.point_weights, o.weight, o.loss) for o in problem.observations]
        self.objective = LeastSquares(observed)
        self.grids = {series.series: series.x for series in observed}
        self.criteria = stop_criteria(problem.stopping)
        self.space = search_space(problem)
        self.offered = None
        if offer is not None and len(offer.parameters):
            rows = np.array([self.objective.weighted_residuals(r) for r in offer.responses])
            self.offered = Runs.of(offer.parameters, rows)
        self._run = problem.model.prepare(self.grids)
        initial = np.array([np.nan if p.initial is None else p.initial for p in problem.free])
        quick = problem.forward_model.quick
        self._maker = problem.method.maker(
            Task(self.space, seed, initial, problem.planned_evaluations, self.offered, quick)
        )

    def make_ready(self) -> None:
        """Let the forward run load what it needs, outside any evaluation and its limits."""
        make_ready = getattr(self._run, "make_ready", None)
        if make_ready is not None:
            make_ready()

    def start(self, slots: int = 1) -> Progress:
        """Ask for generation 0.

        Parameters
        ----------
        slots
            Evaluations that can run at once now: decides the size of the first generation with ``particles: auto``.

        Raises
        ------
        InfeasibleSpaceError
            When no feasible proposal is found.
        """
        search = self._maker.start(slots)
        positions, ahead = self._positions(search), _ahead(search)
        return Progress(
            0,
            positions,
            0,
            0,
            None,
            0,
            search.snapshot(),
            ahead,
            _may_begin(self.criteria, len(positions), ahead),
            widths=self._widths(
                (), [positions] if ahead is None else [positions, ahead], overlapping=ahead is not None
            ),
        )

    def evaluate(self, parameters: FloatArray) -> Evaluation:
        """Run the forward calculation for natural values of the free parameters, shape (d,).

        Never raises for a failed forward run: the failure is in the returned evaluation.
        """
        refused = self.refused(parameters)
        return self.evaluate_values(self.problem.values(parameters.tolist())) if refused is None else refused

    def evaluate_values(self, values: Mapping[str, float]) -> Evaluation:
        """Run the forward calculation for values of all parameters by name."""
        parameters = np.array([values[name] for name in self.free_names], dtype=np.float64)
        return self.judged(parameters, outcome_of(self._run, values, self.objective.responses))

    def judged(self, parameters: FloatArray, outcome: ForwardOutcome) -> Evaluation:
        """Return the evaluation for a forward calculation, wherever it ran: its misfits and objective.

        Parameters
        ----------
        parameters
            Natural values of the free parameters, shape (d,).
        """
        reason, message = outcome.reason, outcome.message
        if reason is None:
            try:
                misfits = self.objective.misfits(outcome.responses)
            except ForwardError as error:
                reason, message = error.reason, message_of(error)
            else:
                value = self.objective.value(misfits)
                return Evaluation(parameters, value, misfits, outcome.responses, None, message, outcome.seconds)
        return Evaluation(parameters, None, {}, {}, reason, message, outcome.seconds)

    def refused(self, parameters: FloatArray) -> Evaluation | None:
        """Return the failed evaluation of a follow-up at values that are not feasible; a search never asks for
        these."""
        if self.problem.method.role == "follow_up" and not self.space.feasible(parameters):
            return Evaluation(parameters, None, {}, {}, "infeasible", "the constraints are not satisfied there", 0.0)
        return None

    @property
    def accelerated(self) -> bool:
        """Whether the search learns from all runs so far: then :meth:`advance` needs them."""
        return self.problem.method.learns or self.answers

    @property
    def answers(self) -> bool:
        """Whether the runs that the result needs follow the search."""
        return self.problem.answers

    def advance(
        self,
        progress: Progress,
        objectives: Sequence[float | None],
        seconds: float,
        runs: Runs | None = None,
        criteria: Sequence[StopCriterion] | None = None,
        situation: Situation | None = None,
    ) -> Step:
        """Close the current generation and ask for the next one; pure.

        Parameters
        ----------
        progress
            State in which the generation was asked for.
        objectives
            f of each particle in particle order, None for a failed evaluation.
        seconds
            Running time of the job so far [s].
        runs
            All evaluations so far, this generation included; needed when :attr:`accelerated`.
        criteria
            Stop criteria in place of the problem's.
        situation
            State of the engine; decides the size of the next generation with ``particles: auto``.
        """
        method, criteria = self.problem.method, self.criteria if criteria is None else criteria
        limits, criteria = criteria, self._of_search(criteria)
        if self.accelerated and runs is None:
            raise ValueError("an accelerated search needs the runs so far")
        told = np.array([np.inf if f is None else f for f in objectives], dtype=np.float64)
        if progress.answer is not None:
            return self._go_on_answering(progress, progress.answer, told, runs, limits, seconds)
        search = self._maker.restore(progress.snapshot)
        evaluations = progress.evaluations + len(objectives)
        lengths = (*progress.lengths, *(s for s in situation.lengths if s > 0.0)) if situation else progress.lengths
        lengths = lengths[-REMEMBERED:] if method.follows_slots else ()
        asked = 0 if progress.ahead is None else len(progress.ahead)
        following = method.asks_next(situation, lengths, quick=self.problem.forward_model.quick)
        if isinstance(search, WideSearch):
            particles = following.particles
            left = _left(criteria, evaluations + asked)
            if particles is not None and left is not None and left > 0:
                particles = min(particles, left)
            search.tell(told, runs, particles=particles, ahead=following.ahead)
        else:
            search.tell(told, runs)
        best, stagnation = _update_best(progress, told)
        positions, ahead = self._positions(search), _ahead(search)
        new = [p for p in ((positions, ahead) if progress.ahead is None else (ahead,)) if p is not None]
        step = Progress(
            generation=progress.generation + 1,
            positions=positions,
            evaluations=evaluations,
            failed=progress.failed + objectives.count(None),
            best=best,
            stagnation=stagnation,
            snapshot=search.snapshot(),
            ahead=ahead,
            ahead_begun=_may_begin(criteria, evaluations + len(positions), ahead),
            lowered_at=progress.lowered_at if stagnation else evaluations,
            widths=self._widths(progress.widths, new, overlapping=following.ahead),
            lengths=lengths,
        )
        status = SwarmStatus(
            evaluations=evaluations,
            next_evaluations=len(positions),
            seconds=seconds,
            objective=best.objective if best else None,
            stagnation=step.stagnant(method),
        )
        reasons = satisfied_reasons(criteria, status)
        own = method.end_reason(search, evaluations, over=not len(positions))
        if own is not None:
            # Of a follow-up nothing else counts: nobody set its number of evaluations.
            others = () if method.role == "follow_up" else reasons
            reasons = (own, *(r for r in others if r != MaxEvaluations.reason))
        return (self._answer(step, reasons, limits) if reasons else None) or Step(step, reasons)

    def _of_search(self, criteria: Sequence[StopCriterion]) -> Sequence[StopCriterion]:
        """Criteria of a search that leaves a part of its evaluations and time to the runs after it."""
        if not self.answers:
            return criteria
        answer, free = self.problem.answer, self.space.dimension
        kept: list[StopCriterion] = []
        for criterion in criteria:
            if isinstance(criterion, MaxEvaluations):
                criterion = MaxEvaluations(criterion.limit - answer.share_of(criterion.limit, free))
            elif isinstance(criterion, MaxSeconds):
                criterion = MaxSeconds(criterion.limit * SHARE_OF_SEARCH)
            kept.append(criterion)
        return kept

    def _answer(self, ended: Progress, reasons: tuple[str, ...], limits: Sequence[StopCriterion]) -> Step | None:
        """Begin the runs that the result needs, where the search has found something and there is room for them."""
        best = ended.best
        if best is None or not self.answers:
            return None
        most, left = self.problem.answer.most(self.space.dimension, ended.evaluations), _left(limits, ended.evaluations)
        most = most if left is None else min(most, left)
        runs = MinimumSearch(self.space, best.parameters, most)
        positions = runs.ask()
        if positions is None:
            return None
        answer = Answer(
            best.parameters,
            best.objective,
            ended.generation,
            ended.evaluations,
            most,
            reasons,
            ended.to_json(),
            runs.snapshot(),
        )
        return Step(replace(ended, positions=positions, ahead=None, ahead_begun=False, answer=answer), ())

    def _go_on_answering(
        self,
        progress: Progress,
        answer: Answer,
        objectives: FloatArray,
        runs: Runs | None,
        limits: Sequence[StopCriterion],
        seconds: float,
    ) -> Step:
        """Close a generation after the search: the point that a descent has tried may be the new best one."""
        due = answer.runs(self.space)
        best = progress.best
        if due.trying and best is not None and objectives[0] < best.objective:
            best = Best(float(objectives[0]), progress.generation, 0, progress.positions[0].copy())
        due.tell(objectives, runs)
        evaluations, positions = progress.evaluations + len(objectives), self._positions(due)
        after = replace(
            progress,
            generation=progress.generation + 1,
            positions=positions,
            evaluations=evaluations,
            failed=progress.failed + int(np.isinf(objectives).sum()),
            best=best,
            answer=answer.after(due),
        )
        time_over = any(isinstance(one, MaxSeconds) and seconds >= one.limit for one in limits)
        return Step(after, answer.reasons if time_over or not len(positions) else ())

    def _widths(
        self, before: tuple[tuple[int, int, int], ...], new: Sequence[FloatArray], *, overlapping: bool
    ) -> tuple[tuple[int, int, int], ...]:
        """Append generations that were asked for, the last of them ahead of results where two are under way."""
        if not self.problem.method.follows_slots:
            return ()
        found = list(before)
        for positions in new:
            kind = (len(positions), int(overlapping))
            if found and found[-1][:2] == kind:
                found[-1] = (*kind, found[-1][2] + 1)
            else:
                found.append((*kind, 1))
        return tuple(found)

    def _positions(self, search: Search) -> FloatArray:
        positions = search.ask()
        return np.empty((0, self.space.dimension)) if positions is None else positions


def _ahead(search: Search) -> FloatArray | None:
    return search.ask_ahead() if isinstance(search, WideSearch) else None


def _left(criteria: Sequence[StopCriterion], evaluations: int) -> int | None:
    """Return how many evaluations may follow so many, None: any number."""
    limits = [criterion.limit - evaluations for criterion in criteria if isinstance(criterion, MaxEvaluations)]
    return min(limits, default=None)


def _may_begin(criteria: Sequence[StopCriterion], evaluations: int, ahead: FloatArray | None) -> bool:
    """Whether a generation that is asked for ahead, after so many evaluations, may be begun."""
    left = _left(criteria, evaluations)
    return ahead is not None and (left is None or len(ahead) <= left)


def with_further_tries(failures: Failures, first: Evaluation, again: Callable[[], Evaluation]) -> Evaluation:
    """Return an evaluation, or that of its last retry."""
    evaluation, earlier = first, list[str]()
    while evaluation.reason is not None and failures.tries_again(evaluation.reason, earlier):
        earlier.append(evaluation.reason)
        evaluation = again()
    return evaluation


def _update_best(progress: Progress, objectives: FloatArray) -> tuple[Best | None, int]:
    particle = int(np.argmin(objectives))  # the lowest index of equal ones
    objective = float(objectives[particle])
    if np.isfinite(objective) and (progress.best is None or objective < progress.best.objective):
        return Best(objective, progress.generation, particle, progress.positions[particle].copy()), 0
    return progress.best, progress.stagnation + 1


def stop_criteria(stopping: Stopping) -> tuple[StopCriterion, ...]:
    """Return the criteria that the problem file names."""
    criteria: list[StopCriterion] = []
    if stopping.target_objective is not None:
        criteria.append(TargetObjective(stopping.target_objective))
    if stopping.max_evaluations is not None:
        criteria.append(MaxEvaluations(stopping.max_evaluations))
    if stopping.max_seconds is not None:
        criteria.append(MaxSeconds(stopping.max_seconds))
    if stopping.stagnation_generations is not None:
        criteria.append(StagnationGenerations(stopping.stagnation_generations))
    return tuple(criteria)


def choose_seed(seed: int | None) -> int:
    """Return the given seed, or a new 32-bit one; every result reports it."""
    return secrets.randbits(32) if seed is None else seed
