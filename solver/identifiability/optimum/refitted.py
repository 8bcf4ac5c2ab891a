"""The minimum without each of several tests by forward runs, and the intervals that follow.

Where the model is nonlinear between these minima, or the residuals are large, the linearised ones of
:mod:`geoswarm.solver.identifiability.optimum.leaving_out` are only a first guess.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.identifiability.optimum.leaving_out import WithoutTests
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.search.descent.leaving_out import LeavingOutSearch
from geoswarm.solver.search.space import SearchSpace

__all__ = ["natural_moves", "notes_on", "refitted", "with_refits"]


def natural_moves(space: SearchSpace, optimum: FloatArray, moves: FloatArray) -> FloatArray:
    """Natural values of moves (k, d) from the optimum, parts of the range; beyond the bounds, too, to infinity."""
    places = space.to_search(optimum) + moves * (space.search_upper - space.search_lower)
    with np.errstate(over="ignore"):
        return np.asarray(np.where(space.log, np.exp(np.where(space.log, places, 0.0)), places))


def refitted(search: LeavingOutSearch, space: SearchSpace, level: float) -> WithoutTests | None:
    """Return the minima that a search has found, with intervals between the tests; None before its end."""
    settings = search.settings
    if search.ask() is not None:
        return None
    return WithoutTests.of(
        space.names,
        settings.names,
        search.moves,
        level,
        lambda moves: natural_moves(space, settings.optimum, moves),
        fitted=True,
        notes=notes_on(search, space),
    )


def notes_on(search: LeavingOutSearch, space: SearchSpace) -> tuple[str, ...]:
    """What to know of these minima, in sentences."""
    notes = []
    if search.unsettled:
        why = (
            f"within {search.told} runs; give more than {search.settings.runs}"
            if search.told >= search.settings.runs
            else "as its last trials were no better: the forward model is rough there"
        )
        notes.append(f"the fit without {', '.join(search.unsettled)} has not settled {why}")
    places = space.to_unit(search.settings.optimum) + search.moves
    for test, place in zip(search.settings.names, places, strict=True):
        for name, value in zip(space.names, place.tolist(), strict=True):
            if value <= 0.0 or value >= 1.0:
                side = "lower" if value <= 0.0 else "upper"
                notes.append(f"without {test}, the best fit lies on the {side} bound of {name}")
    return tuple(notes)


def with_refits(linearisation: Linearisation, without: WithoutTests) -> Linearisation:
    """Put intervals between tests by forward runs in the place of linearised ones, where a test counts as one."""
    half = without.half_widths
    rests = np.array([name in linearisation.between_tests for name in linearisation.names])
    wider = np.array([linearisation.counts_tests(name) for name in linearisation.names])
    wider &= 2.0 * half > np.nan_to_num(linearisation.unit_widths, nan=np.inf)
    chosen = (rests | wider) & np.isfinite(half) & (linearisation.noise is not None)
    if linearisation.unclear:
        chosen[:] = False
    inside = 2.0 * half <= 1.0  # wider than the range: the data do not limit it
    with np.errstate(invalid="ignore", divide="ignore"):
        factor = np.where(linearisation.linear_half_widths > 0.0, half / linearisation.linear_half_widths, 1.0)
    linear = linearisation.without
    names, bases = np.array(linearisation.names), np.array(linearisation.bases, dtype=object)
    bases[chosen] = "tests"
    return replace(
        linearisation,
        intervals=np.where(
            chosen[:, None], np.where(inside[:, None], without.intervals, np.nan), linearisation.intervals
        ),
        unit_widths=np.where(chosen, np.where(inside, 2.0 * half, np.nan), linearisation.unit_widths),
        linear_half_widths=np.where(chosen, np.where(inside, half, np.nan), linearisation.linear_half_widths),
        widening=np.where(chosen, linearisation.widening * factor, linearisation.widening),
        bending=np.where(chosen, 0.0, linearisation.bending),  # these intervals follow the model
        bases=tuple(bases.tolist()),
        between_tests=tuple(names[rests | chosen].tolist()),
        without=replace(without, linear_moves=None if linear is None else linear.moves),
    )
