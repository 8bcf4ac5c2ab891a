"""Evaluations as arrays: what every statistic starts from, wherever they were made and stored."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.calibration import Evaluation
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.result import CalibrationResult, EvaluationRecord

__all__ = ["Samples", "Source"]

Source: TypeAlias = str
"""Kind of the method that the samples come from; ``follow_up`` for all follow-ups, ``mixed`` for several methods."""


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Successful evaluations of one problem.

    Parameters
    ----------
    names, scales
        Names of the d free parameters and whether each is searched on a ``linear`` or ``log`` scale.
    lower, upper
        Bounds of the search space, shape (d,), natural values.
    parameters
        Natural values, shape (n, d).
    objectives
        f, shape (n,).
    misfits
        f'_g of each series, shape (n,); empty when not stored.
    responses
        Calculated values of each series at its observed points, shape (n, m_g), base units; empty when not stored.
    unbiased
        Shape (n,): True for Monte Carlo samples, which fill the space evenly in search coordinates; False for the
        particles of a swarm, which crowd where the swarm was drawn to.
    generations, particles
        Place in the history, shape (n,), from 0.
    failed
        Evaluations that failed; they are not among the n.
    left_out
        Successful evaluations of a long history that were not read.
    planned
        Positions of a follow-up (sensitivities, profiles, a design), neither sampled nor searched.
    method
        Kind of the method that asked for them, of the first where there are several.
    """

    names: tuple[str, ...]
    scales: tuple[str, ...]
    lower: FloatArray
    upper: FloatArray
    parameters: FloatArray
    objectives: FloatArray
    misfits: dict[str, FloatArray]
    responses: dict[str, FloatArray]
    unbiased: BoolArray
    generations: IntArray
    particles: IntArray
    failed: int = 0
    left_out: int = 0
    planned: bool = False
    method: str = "particle_swarm"

    @classmethod
    def from_arrays(
        cls,
        problem: Problem,
        parameters: FloatArray,
        objectives: FloatArray,
        *,
        misfits: Mapping[str, FloatArray] | None = None,
        responses: Mapping[str, FloatArray] | None = None,
        generations: IntArray | None = None,
        particles: IntArray | None = None,
        failed: int = 0,
        left_out: int = 0,
    ) -> Samples:
        """Take rows as a store keeps them; ``failed`` counts failed ones that are not among the rows.

        Rows whose objective is nan or infinite count as failed. Shapes as in :class:`Samples`.

        Raises
        ------
        StatisticsError
            When the shapes do not fit together.
        """
        free = problem.free
        parameters = np.asarray(parameters, dtype=np.float64).reshape(-1, len(free))
        objectives = np.asarray(objectives, dtype=np.float64)
        count = len(objectives)
        columns = {**(misfits or {}), **{f"responses of {k}": v for k, v in (responses or {}).items()}}
        wrong = [name for name, column in {"parameters": parameters, **columns}.items() if len(column) != count]
        if wrong:
            raise StatisticsError(f"{', '.join(wrong)}: the number of rows differs from that of objectives ({count})")
        good = np.isfinite(objectives)
        index = np.arange(count, dtype=np.int64)
        return cls(
            names=problem.free_names,
            scales=tuple(p.scale for p in free),
            lower=np.array([p.lower for p in free], dtype=np.float64),
            upper=np.array([p.upper for p in free], dtype=np.float64),
            parameters=parameters[good],
            objectives=objectives[good],
            misfits={k: np.asarray(v, dtype=np.float64)[good] for k, v in (misfits or {}).items()},
            responses={k: np.asarray(v, dtype=np.float64)[good] for k, v in (responses or {}).items()},
            unbiased=np.full(int(good.sum()), problem.method.role == "sampling"),
            generations=(np.zeros(count, dtype=np.int64) if generations is None else np.asarray(generations))[good],
            particles=(index if particles is None else np.asarray(particles))[good],
            failed=failed + int(count - good.sum()),
            left_out=left_out,
            planned=problem.method.role == "follow_up",
            method=problem.method.kind,
        )

    @classmethod
    def from_history(cls, problem: Problem, history: Iterable[EvaluationRecord]) -> Samples:
        """Take the evaluations of an in-process run; failed ones are counted."""
        records = list(history)
        generations = np.array([r.generation for r in records], dtype=np.int64)
        particles = np.array([r.particle for r in records], dtype=np.int64)
        evaluations = [r.evaluation for r in records]
        return cls.from_evaluations(problem, evaluations, generations=generations, particles=particles)

    @classmethod
    def from_evaluations(
        cls,
        problem: Problem,
        evaluations: Sequence[Evaluation],
        *,
        generations: IntArray | None = None,
        particles: IntArray | None = None,
    ) -> Samples:
        """Take evaluations with their places in the history; failed ones are counted."""
        kept = np.array([e.objective is not None for e in evaluations], dtype=np.bool_)
        good = [e for e in evaluations if e.objective is not None]
        series = [o.series for o in problem.observations]
        stored = all(e.responses for e in good)
        return cls.from_arrays(
            problem,
            np.array([e.parameters for e in good]),
            np.array([e.objective for e in good], dtype=np.float64),
            misfits={s: np.array([e.misfits[s] for e in good]) for s in series},
            responses={
                o.series: np.array([e.responses[o.series] for e in good]).reshape(-1, o.x.size)
                for o in problem.observations
            }
            if stored
            else {},
            generations=None if generations is None else generations[kept],
            particles=None if particles is None else particles[kept],
            failed=len(evaluations) - len(good),
        )

    @classmethod
    def from_result(cls, problem: Problem, result: CalibrationResult) -> Samples:
        """Take the history of the search of an in-process run."""
        answer = result.answer
        searched = [one for one in result.history if answer is None or one.generation < answer.generation]
        return cls.from_history(problem, searched)

    @classmethod
    def merge(cls, parts: Sequence[Samples]) -> Samples:
        """Put samples of the same problem (one free space, same series) together, such as a sampling and a swarm.

        Raises
        ------
        StatisticsError
            When free parameters, scales or bounds differ.
        """
        first = parts[0]
        for other in parts[1:]:
            alike = (first.names, first.scales) == (other.names, other.scales)
            if not (alike and np.array_equal(first.lower, other.lower) and np.array_equal(first.upper, other.upper)):
                raise StatisticsError("samples can only be put together when free parameters, scales and bounds agree")
        misfits = set.intersection(*(set(p.misfits) for p in parts))
        responses = set.intersection(*(set(p.responses) for p in parts))
        return replace(
            first,
            parameters=np.concatenate([p.parameters for p in parts]),
            objectives=np.concatenate([p.objectives for p in parts]),
            misfits={k: np.concatenate([p.misfits[k] for p in parts]) for k in first.misfits if k in misfits},
            responses={k: np.concatenate([p.responses[k] for p in parts]) for k in first.responses if k in responses},
            unbiased=np.concatenate([p.unbiased for p in parts]),
            generations=np.concatenate([p.generations for p in parts]),
            particles=np.concatenate([p.particles for p in parts]),
            failed=sum(p.failed for p in parts),
            left_out=sum(p.left_out for p in parts),
        )

    @property
    def size(self) -> int:
        """Number n of samples."""
        return len(self.objectives)

    @property
    def dimension(self) -> int:
        """Number d of free parameters."""
        return len(self.names)

    @property
    def source(self) -> Source:
        """Where the samples come from."""
        if self.planned and not self.unbiased.all():
            return "follow_up"
        return "mixed" if self.unbiased.any() and not self.unbiased.all() else self.method

    @property
    def best(self) -> int:
        """Index of the lowest objective, the first of equal ones.

        Raises
        ------
        StatisticsError
            When there are no samples.
        """
        if self.size == 0:
            raise StatisticsError("there is no successful evaluation")
        return int(np.argmin(self.objectives))

    @property
    def log(self) -> BoolArray:
        """Whether a parameter is searched on a log scale, shape (d,)."""
        return np.array([scale == "log" for scale in self.scales], dtype=np.bool_)

    def to_search(self, natural: FloatArray) -> FloatArray:
        """Natural values, shape (..., d), in search coordinates: ln on a log scale, the value itself otherwise."""
        log = self.log
        return np.where(log, np.log(np.where(log, natural, 1.0)), natural)

    @property
    def coordinates(self) -> FloatArray:
        """Search coordinates, shape (n, d)."""
        return self.to_search(self.parameters)

    @property
    def unit(self) -> FloatArray:
        """Place between the bounds in search coordinates, 0 to 1, shape (n, d)."""
        return self.to_unit(self.parameters)

    def to_unit(self, natural: FloatArray) -> FloatArray:
        """Natural values, shape (..., d), as places between the bounds in search coordinates, 0 to 1."""
        lower = self.to_search(self.lower)
        return (self.to_search(natural) - lower) / (self.to_search(self.upper) - lower)

    def select(self, chosen: BoolArray | IntArray) -> Samples:
        """The samples of a mask or of indices, shape (k,)."""
        return replace(
            self,
            parameters=self.parameters[chosen],
            objectives=self.objectives[chosen],
            misfits={k: v[chosen] for k, v in self.misfits.items()},
            responses={k: v[chosen] for k, v in self.responses.items()},
            unbiased=self.unbiased[chosen],
            generations=self.generations[chosen],
            particles=self.particles[chosen],
        )
