"""Assembles a problem into what a calibration needs: evaluate one particle, advance one generation.

Both the in-process loop and the distributed engine go through :meth:`Calibration.advance`, so they cannot differ.
"""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import ForwardError, in_words, message_of
from geoswarm.solver.forward.base import NotedResponse
from geoswarm.solver.methods.base import Task
from geoswarm.solver.objective import LeastSquares, ObservedSeries
from geoswarm.solver.offer import Offer
from geoswarm.solver.problem import Problem, Stopping
from geoswarm.solver.problem.running import Failures
from geoswarm.solver.search import Runs, Search, Snapshot
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
from geoswarm.solver.system.activity import counting

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
    """Outcome of one forward calculation; it failed when ``reason`` is not None.

    Parameters
    ----------
    parameters
        Natural values of the free parameters, shape (d,).
    objective
        f, None when failed.
    misfits, responses
        f'_g and calculated values, shape (m_g,), of each observed series; empty when failed.
    reason, message
        Kind of failure (:data:`geoswarm.solver.errors.FailureReason`) and what happened; of a success a note, or None.
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


@dataclass(frozen=True, slots=True)
class Best:
    """The best evaluation so far; of equal objectives the earliest, then the lowest particle."""

    objective: float
    generation: int
    particle: int
    parameters: FloatArray


@dataclass(frozen=True, slots=True)
class Progress:
    """Everything a calibration knows between two generations.

    Parameters
    ----------
    generation
        Number of the generation that is being evaluated, from 0.
    positions
        Natural values of its particles, shape (n, d).
    evaluations, failed
        Counted so far, finished generations only.
    best
        None while no evaluation has succeeded.
    stagnation
        Finished generations since the best objective was last lowered.
    snapshot
        State of the search.
    """

    generation: int
    positions: FloatArray
    evaluations: int
    failed: int
    best: Best | None
    stagnation: int
    snapshot: Snapshot

    def to_json(self) -> dict[str, Any]:
        """Return a JSON-able form that :meth:`from_json` restores exactly."""
        best = self.best
        return {
            "generation": self.generation,
            "positions": self.positions.tolist(),
            "evaluations": self.evaluations,
            "failed": self.failed,
            "best": best
            and {
                "objective": best.objective,
                "generation": best.generation,
                "particle": best.particle,
                "parameters": best.parameters.tolist(),
            },
            "stagnation": self.stagnation,
            "snapshot": self.snapshot,
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Progress:
        """Restore from :meth:`to_json`."""
        best = data["best"]
        return cls(
            **{**data, "positions": np.array(data["positions"], dtype=np.float64)}
            | {"best": best and Best(**{**best, "parameters": np.array(best["parameters"], dtype=np.float64)})}
        )


@dataclass(frozen=True, slots=True)
class Step:
    """What follows a finished generation: with no ``stop_reasons`` the next one, ``progress.positions``, is due."""

    progress: Progress
    stop_reasons: tuple[str, ...]


class Calibration:
    """A problem made ready: its forward run, objective, search space and stop criteria.

    Parameters
    ----------
    problem, seed
        What to calibrate, and what fixes all random numbers.
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
        observed = [ObservedSeries(o.series, o.x, o.y, o.point_weights, o.weight) for o in problem.observations]
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
        self._maker = problem.method.maker(Task(self.space, seed, initial, problem.planned_evaluations, self.offered))

    def make_ready(self) -> None:
        """Have the forward run load what it needs, outside of any evaluation and its limits."""
        make_ready = getattr(self._run, "make_ready", None)
        if make_ready is not None:
            make_ready()

    def start(self, slots: int = 1) -> Progress:
        """Ask for generation 0.

        Parameters
        ----------
        slots
            Evaluations that can run at once now: decides the size of the generations with ``particles: auto``, once
            and for all, because a search goes on with the number of particles in its snapshot.

        Raises
        ------
        InfeasibleSpaceError
            When no feasible proposal is found.
        """
        search = self._maker.start(slots)
        return Progress(0, self._positions(search), 0, 0, None, 0, search.snapshot())

    def evaluate(self, parameters: FloatArray) -> Evaluation:
        """Run the forward calculation for natural values of the free parameters, shape (d,).

        Never raises for a failed forward run: the failure is in the returned evaluation.
        """
        follows_up = self.problem.method.role == "follow_up"
        if follows_up and not self.space.feasible(parameters):  # a search never asks for such
            return Evaluation(parameters, None, {}, {}, "infeasible", "the constraints do not hold there", 0.0)
        return self.evaluate_values(self.problem.values(parameters.tolist()))

    def evaluate_values(self, values: Mapping[str, float]) -> Evaluation:
        """Run the forward calculation for values of all parameters by name."""
        parameters = np.array([values[name] for name in self.free_names], dtype=np.float64)
        began = time.perf_counter()
        with counting() as waited:
            try:
                with np.errstate(all="ignore"):
                    found = self._run(values)
                seconds = time.perf_counter() - began - waited.seconds
                responses = self.objective.responses(found)
                misfits = self.objective.misfits(responses)
            except ForwardError as error:
                reason, message = error.reason, message_of(error)
            except MemoryError:
                reason, message = "killed_memory", "the forward model ran out of memory"
            except Exception as error:  # noqa: BLE001  a forward model may be anybody's code; its bug is one failed evaluation
                reason, message = "bad_output", f"the forward model raised {in_words(error)}"
            else:
                note = found.note if isinstance(found, NotedResponse) else None
                return Evaluation(parameters, self.objective.value(misfits), misfits, responses, None, note, seconds)
        seconds = time.perf_counter() - began - waited.seconds
        return Evaluation(parameters, None, {}, {}, reason, message, seconds)

    @property
    def accelerated(self) -> bool:
        """Whether the search learns from all runs so far: then :meth:`advance` needs them."""
        return self.problem.method.learns

    def advance(
        self,
        progress: Progress,
        objectives: Sequence[float | None],
        seconds: float,
        runs: Runs | None = None,
        criteria: Sequence[StopCriterion] | None = None,
    ) -> Step:
        """Close the current generation and ask for the next one; pure.

        Parameters
        ----------
        progress
            State at which the generation was asked.
        objectives
            f of each particle in particle order, None for a failed evaluation.
        seconds
            Running time of the job so far [s].
        runs
            All evaluations so far, this generation included; needed when :attr:`accelerated`.
        criteria
            Stop criteria in place of the problem's.
        """
        if self.accelerated and runs is None:
            raise ValueError("an accelerated search needs the runs so far")
        told = np.array([np.inf if f is None else f for f in objectives], dtype=np.float64)
        search = self._maker.restore(progress.snapshot)
        search.tell(told, runs)
        best, stagnation = _update_best(progress, told)
        positions = self._positions(search)
        evaluations = progress.evaluations + len(objectives)
        status = SwarmStatus(
            evaluations=evaluations,
            next_evaluations=len(positions),
            seconds=seconds,
            objective=best.objective if best else None,
            stagnation=stagnation,
        )
        reasons = satisfied_reasons(self.criteria if criteria is None else criteria, status)
        method = self.problem.method
        own = method.end_reason(search, evaluations, over=not len(positions))
        if own is not None:
            # Of a follow-up nothing else counts: nobody set its number of evaluations.
            others = () if method.role == "follow_up" else reasons
            reasons = (own, *(r for r in others if r != MaxEvaluations.reason))
        following = Progress(
            generation=search.generation,
            positions=positions,
            evaluations=evaluations,
            failed=progress.failed + objectives.count(None),
            best=best,
            stagnation=stagnation,
            snapshot=search.snapshot(),
        )
        return Step(following, reasons)

    def _positions(self, search: Search) -> FloatArray:
        positions = search.ask()
        return np.empty((0, self.space.dimension)) if positions is None else positions


def with_further_tries(failures: Failures, first: Evaluation, again: Callable[[], Evaluation]) -> Evaluation:
    """Return an evaluation, or that of the last further try that it gets."""
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
    """Return the given seed, or a fresh 32-bit one, which every result reports."""
    return secrets.randbits(32) if seed is None else seed
