"""Generations in progress in this process; nothing is run twice, including what an interrupted run has kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Evaluation
from geoswarm.solver.runs.evaluators import EvaluateGeneration, Results
from geoswarm.solver.runs.journal import Keeper

__all__ = ["UnderWay"]


class UnderWay:
    """The generations that are evaluated now, one or two, and the outcome at every position so far.

    Parameters
    ----------
    begin
        Begins to evaluate positions.
    keeper
        Knows the outcomes of an earlier part of this run.
    """

    def __init__(self, begin: EvaluateGeneration, keeper: Keeper) -> None:
        self._begin = begin
        self._keeper = keeper
        self._known: dict[bytes, Evaluation] = {}
        self._out: set[bytes] = set()
        self._generations: dict[int, tuple[list[bytes], list[bytes], Results]] = {}

    def begin(self, generation: int, positions: FloatArray) -> None:
        """Start a generation, natural values, shape (n, d), unless it is in progress."""
        if generation in self._generations:
            return
        keys = [position.tobytes() for position in positions]
        new: list[bytes] = []
        missing: list[FloatArray] = []
        recalled: list[bytes] = []
        for key, position in zip(keys, positions, strict=True):
            if key in self._known or key in self._out:
                continue
            self._out.add(key)
            stored = self._keeper.recall(position)
            if stored is None:
                new.append(key)
                missing.append(position)
            else:
                self._known[key] = stored
                recalled.append(key)
        results: Results = self._begin(np.array(missing)) if missing else list
        self._generations[generation] = keys, [*recalled, *new], results

    def drop(self, generation: int) -> None:
        """Forget a generation that was asked ahead: another one takes its place."""
        if generation in self._generations:
            self.results(generation)

    def results(self, generation: int) -> list[Evaluation]:
        """Wait for the first generation in progress; return its evaluations in particle order.

        One at a position that an earlier one has takes over its outcome, and no time.
        """
        keys, own, results = self._generations.pop(generation)
        found = results()
        if found:
            self._known |= zip(own[len(own) - len(found) :], found, strict=True)
        fresh = set(own)
        evaluations = []
        for key in keys:
            evaluation = self._known[key]
            evaluations.append(evaluation if key in fresh else replace(evaluation, seconds=0.0))
            fresh.discard(key)
        return evaluations
