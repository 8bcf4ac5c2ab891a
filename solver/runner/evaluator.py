"""What evaluates positions for a worker, and the limits that it keeps."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.errors import ForwardError
from geoswarm.solver.problem import Problem
from geoswarm.solver.runner.wire import Outcome
from geoswarm.solver.warm import run_sample

__all__ = [
    "BuildError",
    "EvaluationCancelled",
    "Evaluator",
    "InlineEvaluator",
    "NoProcessError",
    "RunLimits",
    "evaluate",
    "evaluate_fields",
]


@dataclass(frozen=True, slots=True)
class RunLimits:
    """Wall time [s] and memory [MiB] that one evaluation may use; None: any. ``of_time``: what limits the time."""

    seconds: float | None = None
    memory_mb: float | None = None
    of_time: str = "limits.seconds_per_evaluation"

    @classmethod
    def of(cls, problem: Problem) -> RunLimits:
        """Return those that a problem sets."""
        return cls(problem.limits.seconds_per_evaluation, problem.limits.memory_mb)

    def within(self, seconds: float | None, memory_mb: float | None = None, *, of_time: str) -> RunLimits:
        """Return these limits where they are tighter than the given ones, else those."""
        least = _least(self.seconds, seconds)
        return RunLimits(least, _least(self.memory_mb, memory_mb), self.of_time if least == self.seconds else of_time)


class EvaluationCancelled(Exception):  # noqa: N818  no error
    """An evaluation was killed on request; ``index`` is its place, and nothing came of it."""

    def __init__(self, index: int) -> None:
        self.index = index
        super().__init__(index)


class NoProcessError(Exception):
    """No process to evaluate in is to be had now: the worker's own trouble, for which no evaluation is to blame."""


class BuildError(Exception):
    """The problem of a job cannot be built: whatever builds it dies, hangs or takes too much memory."""


class Evaluator(Protocol):
    """Evaluates positions of a job."""

    def start(self) -> None:
        """Make ready; returns at once."""

    @property
    def loaded(self) -> Collection[str]:
        """Groups of kernels (:data:`geoswarm.solver.warm.SAMPLES`) that need not be loaded any more."""

    def load(self, group: str, unwanted: Callable[[], bool]) -> None:
        """Load a group of kernels, and compile it if need be, outside of any evaluation.

        Ends early when ``unwanted`` becomes true. Does not raise for what goes wrong: an evaluation will tell.
        """

    def import_models(self, kinds: Collection[str], unwanted: Callable[[], bool]) -> None:
        """Import forward models that are not there yet, as :meth:`load` loads kernels."""

    def build(self, job_id: str, document: Mapping[str, Any], seed: int, limits: RunLimits) -> None:
        """Build the problem of a job where no harm is done, before this process builds it.

        Raises
        ------
        BuildError
            When that ended the process, exceeded a limit, or took too long, three times.
        NoProcessError
        """

    def run(
        self,
        job_id: str,
        calibration: Calibration,
        positions: FloatArray,
        limits: RunLimits,
        *,
        budget: float | None = None,
        unwanted: Callable[[], float | None] = lambda: None,
        fields: str | None = None,
    ) -> Iterator[Outcome]:
        """Evaluate positions, shape (k, d), in order, and give what comes of each.

        Parameters
        ----------
        budget
            No further evaluation is begun after this time [s]; the first one always is.
        unwanted
            How long the evaluation under way may still take [s], None: it is wanted. No other is begun.
        fields
            Part whose displacement fields are wanted instead of responses, see
            :mod:`geoswarm.solver.runner.evaluator`; None: responses.

        Raises
        ------
        EvaluationCancelled
            When an unwanted evaluation was killed; those before it were given.
        NoProcessError
            When the system has no process to spare; those before it were given.
        """

    def close(self) -> None:
        """End what was started."""


class InlineEvaluator:
    """Evaluates in this very process: for debugging. Nothing is limited, an unwanted evaluation is finished."""

    def __init__(self) -> None:
        self.loaded: set[str] = set()

    def start(self) -> None:
        """Do nothing."""

    def load(self, group: str, unwanted: Callable[[], bool]) -> None:  # noqa: ARG002  the protocol of all evaluators
        """Load a group of kernels into this process."""
        run_sample(group)
        self.loaded.add(group)

    def import_models(self, kinds: Collection[str], unwanted: Callable[[], bool]) -> None:
        """Do nothing: reading the problem has imported them."""

    def build(self, job_id: str, document: Mapping[str, Any], seed: int, limits: RunLimits) -> None:
        """Do nothing."""

    def run(
        self,
        job_id: str,  # noqa: ARG002  the protocol of all evaluators
        calibration: Calibration,
        positions: FloatArray,
        limits: RunLimits,  # noqa: ARG002  others need it
        *,
        budget: float | None = None,
        unwanted: Callable[[], float | None] = lambda: None,
        fields: str | None = None,
    ) -> Iterator[Outcome]:
        """Evaluate positions in order."""
        started = time.monotonic()
        for index, position in enumerate(positions):
            began = time.monotonic()
            if index > 0 and ((budget is not None and began - started > budget) or unwanted() is not None):
                return
            yield Outcome(evaluate(calibration, position, fields), None, began, time.monotonic())

    def close(self) -> None:
        """Do nothing."""


def evaluate(calibration: Calibration, position: FloatArray, fields: str | None) -> Evaluation:
    """Evaluate a position here and now: its responses, or the displacement fields of a part."""
    if fields is None:
        return calibration.evaluate(position)
    return evaluate_fields(calibration, position, fields)


def _least(*limits: float | None) -> float | None:
    return min((limit for limit in limits if limit is not None), default=None)


def evaluate_fields(calibration: Calibration, parameters: FloatArray, part: str) -> Evaluation:
    """Calculate the displacements of a body; a failure is in the returned evaluation.

    Parameters
    ----------
    parameters
        Natural values of the free parameters, shape (d,).
    part
        Name of the part of a combined model; empty for a model that is none.

    Returns
    -------
    Evaluation
        Its responses are the displacements at the end of each phase, flattened to (2 n,), m; no objective.
    """
    from geoswarm.solver.forward.continuum.fields import body_of, displacement_fields  # with finite elements

    began = time.perf_counter()
    found = body_of(calibration.problem.model, part, calibration.problem.values(parameters.tolist()))
    try:
        if found is None:
            raise ForwardError(f"the forward model has no body {part!r}")
        with np.errstate(all="ignore"):
            fields = displacement_fields(*found)
    except ForwardError as error:
        reason, message = error.reason, str(error)
    except MemoryError:
        reason, message = "killed_memory", "the forward model ran out of memory"
    else:
        flat = {name: displacement.ravel() for name, displacement in fields.items()}
        return Evaluation(parameters, None, {}, flat, None, None, time.perf_counter() - began)
    return Evaluation(parameters, None, {}, {}, reason, message, time.perf_counter() - began)
