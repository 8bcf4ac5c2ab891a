"""Runners that share the evaluations of a calibration in process."""

from __future__ import annotations

import os
import queue
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from types import TracebackType

import numpy as np

from geoswarm.environment import without_secrets
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation, with_further_tries
from geoswarm.solver.errors import WorkerLostError
from geoswarm.solver.runner.evaluator import NoProcessError, RunLimits
from geoswarm.solver.runner.kernels import make_ready
from geoswarm.solver.runner.runner import Runner
from geoswarm.solver.words import visible

__all__ = ["Team"]

_JOB = "run"


class Team:
    """Some runners, each with an evaluation process and a thread of its own.

    A context manager: at its end all processes end, at once when an error has brought it about.

    Parameters
    ----------
    calibration
        What is evaluated.
    workers
        Number of runners.
    """

    def __init__(self, calibration: Calibration, workers: int) -> None:
        self._calibration = calibration
        self._limits = RunLimits.of(calibration.problem)
        self._stopping = threading.Event()
        # A run in process belongs to its operator: forward models see the same environment as with one worker.
        self._runners = [Runner(tuple(without_secrets(os.environ))) for _ in range(workers)]
        self._idle: queue.SimpleQueue[Runner] = queue.SimpleQueue()
        self.threads = ThreadPoolExecutor(workers, thread_name_prefix="geoswarm-runner")
        """As many threads as there are runners, for :meth:`evaluate`."""

    def __enter__(self) -> Team:
        for runner in self._runners:
            runner.start()
            self._idle.put(runner)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if kind is not None:
            self.abandon()
        self.threads.shutdown(cancel_futures=True)
        for runner in self._runners:
            runner.close()

    def abandon(self) -> None:
        """Have what is evaluated now killed: it is not wanted any more."""
        self._stopping.set()

    def evaluate(self, positions: FloatArray) -> list[Evaluation]:
        """Evaluate positions, shape (n, d), in order, with the further tries of the problem.

        Raises
        ------
        WorkerLostError
            When the system has no process to spare.
        EvaluationCancelled
            When the team is ending.
        """
        runner = self._idle.get()
        try:
            make_ready(runner, self._calibration.problem, unwanted=self._stopping.is_set)
            evaluations = self._once(runner, positions)
            failures = self._calibration.problem.failures
            for place, first in enumerate(evaluations):
                again = partial(self._one, runner, positions[place])
                evaluations[place] = with_further_tries(failures, first, again)
            return evaluations
        except NoProcessError as error:
            raise WorkerLostError(f"{error}; use fewer workers, or try again later") from None
        finally:
            self._idle.put(runner)

    def _once(self, runner: Runner, positions: FloatArray) -> list[Evaluation]:
        evaluations: list[Evaluation] = []
        while len(evaluations) < len(positions):  # a runner stops early to go on in a fresh process
            rest = positions[len(evaluations) :]
            for outcome in runner.run(_JOB, self._calibration, rest, self._limits, unwanted=self._unwanted):
                evaluations.append(outcome.evaluation)
                if outcome.log:
                    sys.stderr.write(visible(outcome.log, lines=True))
        return evaluations

    def _one(self, runner: Runner, position: FloatArray) -> Evaluation:
        (evaluation,) = self._once(runner, position[np.newaxis])
        return evaluation

    def _unwanted(self) -> float | None:
        return 0.0 if self._stopping.is_set() else None
