"""Has what a job needs imported and compiled before it begins, so that no evaluation, limit or clock counts that."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

from geoswarm.solver.kernels.cache import alone, settle
from geoswarm.solver.problem import Problem
from geoswarm.solver.runner.evaluator import Evaluator
from geoswarm.solver.warm import groups_of, missing_kernels, note_compiled

__all__ = ["make_ready"]

log = logging.getLogger(__name__)


def make_ready(
    evaluator: Evaluator,
    problem: Problem,
    *,
    unwanted: Callable[[], bool] = lambda: False,
    tell: Callable[[int, int, float | None], object] = lambda _compiled, _missing, _seconds: None,
) -> bool:
    """Load the forward models and kernels that a problem needs.

    Of several workers of a machine one compiles kernels, the others wait for it.

    Parameters
    ----------
    unwanted
        Whether to give up; then the answer is False.
    tell
        Called, when this worker compiles, with the number of groups of kernels that are compiled, that of those that
        were missing, and at the end the time that it took [s]; None before.
    """
    kinds = {part.kind for part in (problem.forward_model, *problem.forward_model.by_part().values())}
    evaluator.import_models(kinds, unwanted)
    groups = [group for group in groups_of(problem.forward_model) if group not in evaluator.loaded]
    if groups and missing_kernels(problem.forward_model):
        with alone(settle(), unwanted) as turn:
            missing = [group for group in missing_kernels(problem.forward_model) if group in groups]
            if turn and missing:
                log.warning("compiling the kernels for this machine: once after an installation")
                began = time.monotonic()
                for compiled, group in enumerate(missing):
                    tell(compiled, len(missing), None)
                    evaluator.load(group, unwanted)
                    if group in evaluator.loaded:
                        note_compiled(group)
                if not unwanted():
                    seconds = time.monotonic() - began
                    log.warning("kernels compiled in %.1f s", seconds)
                    tell(len(missing), len(missing), seconds)
    for group in groups:
        if group not in evaluator.loaded and not unwanted():
            evaluator.load(group, unwanted)
    return not unwanted()
