"""The processes that share the evaluations of a calibration in process."""

from __future__ import annotations

import math
import multiprocessing
import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import TypeAlias

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation, with_further_tries
from geoswarm.solver.errors import WorkerLostError
from geoswarm.solver.forward.registry import is_foreign
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.running import Limits

__all__ = ["WATCHED", "EvaluateGeneration", "Finished", "Results", "evaluator"]

Results: TypeAlias = Callable[[], list[Evaluation]]
"""Waits for the evaluations of positions, and gives them in order."""

EvaluateGeneration: TypeAlias = Callable[[FloatArray], Results]

Finished: TypeAlias = Callable[[FloatArray, Evaluation], None]
"""Called with the position and outcome of every evaluation as it finishes, in any order."""

_SECONDS_PER_TASK = 0.05
"""Shorter evaluations are handed out several at a time."""

_START_SECONDS = 3.0
"""What it takes to start processes, about."""

WATCHED = sys.platform == "linux"
"""Whether this system lets processes be watched as :mod:`geoswarm.solver.runner` does it."""

_GUARD = (
    "each of them reads the script that was started: in a script, calibrate(workers={workers}) must be below "
    "if __name__ == '__main__':"
)


@contextmanager
def evaluator(calibration: Calibration, workers: int, finished: Finished) -> Iterator[EvaluateGeneration]:
    """Yield a function that starts evaluating all positions of a generation, shape (n, d); calling its result waits
    for them and returns them in order. A generation may be begun while another is under way.

    One worker is this very process, unless the problem limits an evaluation or starts programs. Several are watched
    processes: a run that exceeds a limit or ends its process is a failed evaluation. As they take seconds to start, our
    own quick models begin in this process. On systems other than Linux limits do not hold, and the processes are a
    plain pool: one that dies ends the calibration. A forward model that lives in this process alone stays in it.
    """
    if workers < 1:
        raise ValueError(f"workers is {workers}, at least 1 is needed")
    problem = calibration.problem
    limited = WATCHED and (problem.limits != Limits() or problem.forward_model.runs_outside)
    stays = problem.forward_model.only_here or (workers == 1 and not limited)
    here = math.inf if stays else _seconds_here(calibration, limited)
    with ExitStack() as started:
        shared: _Shared | None = None

        def share(positions: FloatArray) -> Results:
            nonlocal shared
            if shared is None:
                shared = started.enter_context(_shared(calibration, workers, finished))
            return shared.begin(positions)

        def evaluate(positions: FloatArray) -> list[Evaluation]:
            nonlocal here
            evaluations: list[Evaluation] = []
            while len(evaluations) < len(positions) and here > 0.0:
                position = positions[len(evaluations)]
                evaluations.append(_evaluate(calibration, position))
                finished(position, evaluations[-1])
                here -= evaluations[-1].seconds
            if len(evaluations) == len(positions):
                return evaluations
            return evaluations + share(positions[len(evaluations) :])()

        def begin(positions: FloatArray) -> Results:
            return partial(evaluate, positions) if here > 0.0 else share(positions)

        yield begin


def _seconds_here(calibration: Calibration, limited: bool) -> float:
    """How long evaluations are made in this process before others are started for them [s]."""
    problem = calibration.problem
    own = problem.forward_model.quick and not is_foreign(problem.document()["forward_model"])
    return _START_SECONDS if own and not limited else 0.0


@contextmanager
def _shared(calibration: Calibration, workers: int, finished: Finished) -> Iterator[_Shared]:
    """Start processes."""
    if not WATCHED:
        with _pool(calibration, workers, finished) as shared:
            yield shared
        return
    from geoswarm.solver.runner.team import Team

    with Team(calibration, workers) as team:
        shared = _Shared(team.threads, workers, team.evaluate, finished)
        yield shared
        if shared.under_way:
            team.abandon()  # the search has ended without them


class _Batch:
    """Positions that were begun together, shape (n, d), and what is known of them by place."""

    def __init__(self, positions: FloatArray) -> None:
        self.positions = positions
        self.evaluations: dict[int, Evaluation] = {}

    @property
    def complete(self) -> bool:
        return len(self.evaluations) == len(self.positions)


class _Shared:
    """Evaluates positions by an executor, cheap ones several at a time, in the order in which they were begun."""

    def __init__(
        self,
        executor: Executor,
        workers: int,
        evaluate: Callable[[FloatArray], list[Evaluation]],
        finished: Finished,
    ) -> None:
        self._executor = executor
        self._workers = workers
        self._evaluate = evaluate
        self._finished = finished
        self._seconds = 0.0
        self._tasks: dict[Future[list[Evaluation]], tuple[_Batch, range]] = {}
        self.count = 0
        """How many have been evaluated."""

    @property
    def under_way(self) -> bool:
        """Whether evaluations may still be running."""
        return bool(self._tasks)

    def begin(self, positions: FloatArray) -> Results:
        """Start evaluating positions, shape (n, d)."""
        mean = self._seconds / self.count if self.count else _SECONDS_PER_TASK
        most = max(1, int(_SECONDS_PER_TASK / max(mean, 1e-9)))
        size = min(most, -(-len(positions) // self._workers))
        batch = _Batch(positions)
        for first in range(0, len(positions), size):
            places = range(first, min(first + size, len(positions)))
            task = self._executor.submit(self._evaluate, positions[places.start : places.stop])
            self._tasks[task] = batch, places
        return partial(self._wait_for, batch)

    def _wait_for(self, batch: _Batch) -> list[Evaluation]:
        while not batch.complete:
            for task in wait(self._tasks, return_when=FIRST_COMPLETED).done:
                of, places = self._tasks.pop(task)
                for place, evaluation in zip(places, task.result(), strict=True):
                    of.evaluations[place] = evaluation
                    self._finished(of.positions[place], evaluation)
                    self._seconds += evaluation.seconds
                    self.count += 1
        return [batch.evaluations[place] for place in range(len(batch.positions))]


@contextmanager
def _pool(calibration: Calibration, workers: int, finished: Finished) -> Iterator[_Shared]:
    if getattr(multiprocessing.current_process(), "_inheriting", False):  # the script is being read by a child
        raise WorkerLostError(_GUARD.format(workers=workers))
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(
        workers,
        mp_context=multiprocessing.get_context("spawn"),
        initializer=_initialise_process,
        initargs=(calibration.problem, calibration.seed),
    )
    shared = _Shared(pool, workers, _evaluate_chunk, finished)
    try:
        yield shared
    except BrokenProcessPool as error:
        if not shared.count:
            raise WorkerLostError(
                f"the {workers} worker processes ended before their first evaluation; {_GUARD.format(workers=workers)}"
            ) from error
        raise WorkerLostError(
            f"one of the {workers} worker processes ended unexpectedly (out of memory, or killed); "
            "the service (geoswarm serve) survives such losses, an in-process run does not"
        ) from error
    except BaseException:  # also an interrupt: runs without a reader are not waited for
        for child in set(multiprocessing.active_children()) - before:
            child.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


_process_calibration: Calibration | None = None  # one for the life of a pool's process


def _initialise_process(problem: Problem, seed: int) -> None:
    global _process_calibration
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C reaches the whole group: end without a traceback
    _process_calibration = Calibration(problem, seed)


def _evaluate_chunk(positions: FloatArray) -> list[Evaluation]:
    if _process_calibration is None:
        raise RuntimeError("the process was not initialised")
    return [_evaluate(_process_calibration, position) for position in positions]


def _evaluate(calibration: Calibration, position: FloatArray) -> Evaluation:
    first = calibration.evaluate(position)
    return with_further_tries(calibration.problem.failures, first, lambda: calibration.evaluate(position))
