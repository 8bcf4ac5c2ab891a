"""The course of a calibration from generation to generation; pure.

Both the in-process loop and the distributed engine go through :meth:`Course.advance`, so they cannot differ.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TypeGuard

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.methods.base import Maker, Task
from geoswarm.solver.methods.registry import BUILT_IN
from geoswarm.solver.methods.widths import REMEMBERED, Situation
from geoswarm.solver.problem import Problem, Stopping
from geoswarm.solver.problem.running import SHARE_OF_SEARCH
from geoswarm.solver.progress.state import Best, Progress, Step
from geoswarm.solver.progress.stopping import (
    ALL_FAILED,
    MaxEvaluations,
    MaxSeconds,
    StagnationGenerations,
    StopCriterion,
    SwarmStatus,
    TargetObjective,
    evaluations_left,
    fails_always,
    satisfied_reasons,
)
from geoswarm.solver.search.base import Search, WideSearch
from geoswarm.solver.search.runs import Runs

__all__ = ["Course", "stop_criteria"]


class Course:
    """How a calibration begins and goes on.

    Parameters
    ----------
    calibration
        Whose.
    """

    def __init__(self, calibration: Calibration) -> None:
        self.calibration = calibration
        self.criteria = stop_criteria(calibration.problem.stopping)

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

    @property
    def problem(self) -> Problem:
        """What is calibrated."""
        return self.calibration.problem

    @property
    def foreign_method(self) -> bool:
        """Whether its method is of another package: it acts in :meth:`start` and :meth:`advance` only."""
        return self.problem.method.kind not in BUILT_IN

    @cached_property
    def _maker(self) -> Maker:
        calibration, problem = self.calibration, self.problem
        initial = np.array([np.nan if p.initial is None else p.initial for p in problem.free])
        return problem.method.maker(
            Task(
                calibration.space,
                calibration.seed,
                initial,
                problem.planned_evaluations,
                calibration.offered,
                problem.forward_model.quick,
                problem.series_by_test,
            )
        )

    def learns(self, progress: Progress) -> bool:
        """Whether all runs so far are needed to go on from there."""
        return self.problem.method.learns or progress.answer is not None

    def advance(
        self,
        progress: Progress,
        objectives: Sequence[float | None],
        seconds: float,
        runs: Runs | None = None,
        criteria: Sequence[StopCriterion] | None = None,
        situation: Situation | None = None,
        failures: Mapping[str, int] | None = None,
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
            All evaluations so far, this generation included; needed where it :meth:`learns`.
        criteria
            Stop criteria instead of the problem's.
        situation
            State of the engine; decides the size of the next generation with ``particles: auto``.
        failures
            Number of failed evaluations so far by reason, this generation included; a program that always fails ends
            the search.
        """
        problem = self.problem
        method, limits = problem.method, self.criteria if criteria is None else criteria
        if self.learns(progress) and runs is None:
            raise ValueError("a search that learns needs the runs so far")
        told = np.array([np.inf if f is None else f for f in objectives], dtype=np.float64)
        found = progress.best is not None or bool(np.isfinite(told).any())
        criteria = search_criteria(self.problem, limits) if found else limits
        if progress.answer is not None and runs is not None:
            from geoswarm.solver.answering import go_on_answering  # needs SciPy: not before a search has ended

            return go_on_answering(self.calibration, progress, told, runs, limits, seconds)
        search = self._maker.restore(progress.snapshot)
        evaluations = progress.evaluations + len(objectives)
        lengths = (*progress.lengths, *(s for s in situation.lengths if s > 0.0)) if situation else progress.lengths
        lengths = lengths[-REMEMBERED:] if method.follows_slots else ()
        asked = 0 if progress.ahead is None else len(progress.ahead)
        following = method.asks_next(situation, lengths, quick=problem.forward_model.quick)
        if _is_wide(search):
            particles = following.particles
            left = evaluations_left(criteria, evaluations + asked)
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
            # Of a follow-up nothing else counts: its number of evaluations was not set.
            others = () if method.role == "follow_up" else reasons
            reasons = (own, *(r for r in others if r != MaxEvaluations.reason))
        if best is None and fails_always(failures or {}, evaluations):
            reasons = (ALL_FAILED, *reasons)
        if reasons and problem.answers:
            from geoswarm.solver.answering import begin_answer

            return begin_answer(self.calibration, step, reasons, limits) or Step(step, reasons)
        return Step(step, reasons)

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
        return np.empty((0, self.calibration.space.dimension)) if positions is None else positions


def _ahead(search: Search) -> FloatArray | None:
    return search.ask_ahead() if _is_wide(search) else None


def _is_wide(search: Search) -> TypeGuard[WideSearch]:
    return hasattr(search, "ask_ahead")  # isinstance looks for every method of the protocol, at ten times the cost


def _may_begin(criteria: Sequence[StopCriterion], evaluations: int, ahead: FloatArray | None) -> bool:
    """Whether a generation may be started ahead, after this number of evaluations."""
    left = evaluations_left(criteria, evaluations)
    return ahead is not None and (left is None or len(ahead) <= left)


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


def search_criteria(problem: Problem, criteria: Sequence[StopCriterion]) -> tuple[StopCriterion, ...]:
    """Return the criteria of a search that leaves a part of its evaluations and time to the runs after it."""
    if not problem.answers:
        return tuple(criteria)
    kept: list[StopCriterion] = []
    for criterion in criteria:
        if isinstance(criterion, MaxEvaluations):
            criterion = MaxEvaluations(criterion.limit - problem.left_to_answer(criterion.limit))
        elif isinstance(criterion, MaxSeconds):
            criterion = MaxSeconds(criterion.limit * SHARE_OF_SEARCH)
        kept.append(criterion)
    return tuple(kept)
