"""How many runs a generation has where the problem leaves it to the engine, and when generations overlap.

A generation whose runs differ in length keeps slots waiting for its last one. A second generation, asked ahead of the
results of the first, gives them work, but knows less. So it is asked only where waiting costs more: the share of the
slots' time that n slots wait for the longest of n runs, estimated from the runs made lately, is

    1 - mean(t) / E[max of n],   E[max of n] = sum_i t_(i) ((i / m)^n - ((i - 1) / m)^n)

with the lengths t_(1) <= ... <= t_(m) of the last runs, drawn with replacement.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

__all__ = ["LEAST_QUICK", "MOST", "NEXT", "Next", "Situation", "overlapping", "share_waited", "wide"]

LEAST_QUICK, MOST = 10, 200
"""Particles of a generation of a quick forward model at least, of any at most."""

REMEMBERED = 24
"""Runs whose lengths decide whether generations overlap; a search that ends before is better off waiting."""

_LONG = 1.0  # [s] of a run, below which waiting is no matter
_WAITED = 0.25  # share of the slots' time above which two generations are under way


@dataclass(frozen=True, slots=True)
class Situation:
    """What an engine sees when it closes a generation.

    Parameters
    ----------
    slots
        Runs that can be under way at once now.
    lengths
        What the runs of the generation took [s], in particle order.
    """

    slots: int
    lengths: Sequence[float] = ()


@dataclass(frozen=True, slots=True)
class Next:
    """What is asked for next: ``particles`` of its generation, None: as many as before; ``ahead`` of results or not."""

    particles: int | None = None
    ahead: bool = False


NEXT = Next()
"""A generation like the one before, when that is complete."""


def wide(slots: int, *, quick: bool) -> int:
    """Return how many runs a generation has on a number of slots: some more where a run costs less than a proposal."""
    return min(max(slots, LEAST_QUICK if quick else 1), MOST)


def overlapping(slots: int) -> int:
    """Return how many runs each of two generations under way has, so that slots hardly ever wait.

    Half as many again as slots: where a third of the runs take four times as long as the others, 2 to 40 slots then
    work 94 to 100 % of the time (a simulation of events), and 80 to 96 % with as many as slots.
    """
    return min(math.ceil(1.5 * slots), MOST)


def share_waited(lengths: Sequence[float], slots: int) -> float:
    """Return the share of the slots' time that is spent waiting for the last run of generations of this size.

    Examples
    --------
    >>> share_waited([1.0, 1.0, 1.0], 4)
    0.0
    >>> round(share_waited([1.0, 1.0, 4.0], 4), 2)
    0.41
    """
    if not len(lengths):
        return 0.0
    ordered = np.sort(np.asarray(lengths, dtype=np.float64))
    below = (np.arange(ordered.size + 1) / ordered.size) ** slots
    longest = float(ordered @ np.diff(below))
    return 0.0 if longest <= 0.0 else max(1.0 - float(ordered.mean()) / longest, 0.0)


def worth_overlapping(lengths: Sequence[float], slots: int) -> bool:
    """Whether slots would wait long enough for the last run of a generation."""
    if slots < 2 or len(lengths) < REMEMBERED or np.mean(lengths) < _LONG:
        return False
    return share_waited(lengths, slots) > _WAITED
