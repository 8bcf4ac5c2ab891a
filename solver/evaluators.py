"""The processes that share the evaluations of a calibration in process."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.errors import WorkerLostError
from geoswarm.solver.problem import parse_problem

__all__ = ["EvaluateGeneration", "Finished", "evaluator"]

EvaluateGeneration: TypeAlias = Callable[[FloatArray], list[Evaluation]]

Finished: TypeAlias = Callable[[FloatArray, Evaluation], None]
"""Called with the position and outcome of every evaluation as it finishes, in any order."""

_SECONDS_PER_TASK = 0.05
"""Shorter evaluations are handed out several at a time."""


_GUARD = (
    "each of them reads the script that was started: in a script, calibrate(workers={workers}) must stand below "
    "if __name__ == '__main__':"
)


@contextmanager
def evaluator(calibration: Calibration, workers: int, finished: Finished) -> Iterator[EvaluateGeneration]:
    """Give a function that evaluates all positions of a generation, shape (n, d), and returns them in order."""
    if workers < 1:
        raise ValueError(f"workers is {workers}, at least 1 is needed")
    if workers == 1:

        def evaluate_here(positions: FloatArray) -> list[Evaluation]:
            evaluations = []
            for position in positions:
                evaluations.append(calibration.evaluate(position))
                finished(position, evaluations[-1])
            return evaluations

        yield evaluate_here
        return
    if getattr(multiprocessing.current_process(), "_inheriting", False):  # the script is being read by a child
        raise WorkerLostError(_GUARD.format(workers=workers))
    before = set(multiprocessing.active_children())
    # spawn: a forked child would inherit the locks of Numba's and BLAS's threads in whatever state they are
    pool = ProcessPoolExecutor(
        workers,
        mp_context=multiprocessing.get_context("spawn"),
        initializer=_initialise_process,
        initargs=(calibration.problem.document(), calibration.seed),
    )
    seconds: list[float] = []

    def evaluate_shared(positions: FloatArray) -> list[Evaluation]:
        mean = sum(seconds) / len(seconds) if seconds else _SECONDS_PER_TASK
        most = max(1, int(_SECONDS_PER_TASK / max(mean, 1e-9)))
        size = min(most, -(-len(positions) // workers))
        tasks: dict[Future[list[Evaluation]], range] = {}
        evaluations: dict[int, Evaluation] = {}
        for first in range(0, len(positions), size):
            places = range(first, min(first + size, len(positions)))
            tasks[pool.submit(_evaluate_chunk, positions[places.start : places.stop])] = places
        while tasks:
            for task in wait(tasks, return_when=FIRST_COMPLETED).done:
                for place, evaluation in zip(tasks.pop(task), task.result(), strict=True):
                    evaluations[place] = evaluation
                    finished(positions[place], evaluation)
        seconds.extend(e.seconds for e in evaluations.values())
        return [evaluations[place] for place in range(len(positions))]

    try:
        yield evaluate_shared
    except BrokenProcessPool as error:
        if not seconds:
            raise WorkerLostError(
                f"the {workers} worker processes ended before their first evaluation; {_GUARD.format(workers=workers)}"
            ) from error
        raise WorkerLostError(
            f"one of the {workers} worker processes ended unexpectedly (out of memory, or killed); "
            "the service (geoswarm serve) survives such losses, an in-process run does not"
        ) from error
    except BaseException:  # also an interrupt: nobody waits for runs that nobody will read
        for child in set(multiprocessing.active_children()) - before:
            child.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


_process_calibration: Calibration | None = None  # one for the life of a pool's process


def _initialise_process(document: dict[str, Any], seed: int) -> None:
    global _process_calibration
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C reaches the whole group: end without a traceback
    _process_calibration = Calibration(parse_problem(document), seed)


def _evaluate_chunk(positions: FloatArray) -> list[Evaluation]:
    if _process_calibration is None:
        raise RuntimeError("the process was not initialised")
    return [_process_calibration.evaluate(position) for position in np.atleast_2d(positions)]
