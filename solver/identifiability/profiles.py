"""Profile objectives: the lowest objective for every value of one parameter, and the intervals they give.

For each parameter and side, a chain of values walks away from the optimum; at each, the other parameters are fitted by
Levenberg-Marquardt steps. All chains advance together: :meth:`Profiles.positions` is one generation that can be
dispatched, :meth:`Profiles.advance` takes its evaluations and plans the next. The state is plain data, so the work can
be stopped after any generation and resumed elsewhere with the same result.

An interval ends where the profile has risen by ``increase``: for one series and estimated noise by the factor
1 + F_{1, n-d} / (n - d) (Bates and Watts 1988, section 6.1.2). Where the profile stays below it up to a bound, the
interval is open on that side.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from solver.arrays import FloatArray
from solver.calibration import Calibration, Evaluation
from solver.identifiability.chains import Chain, ChainPoint
from solver.identifiability.errors import StatisticsError
from solver.identifiability.sensitivity import Linearisation

__all__ = ["Profile", "Profiles", "start_profiles"]

_WIDEST_STEP = 0.1
_BLIND_STEP = 0.05


@dataclass(frozen=True, slots=True)
class Profile:
    """Profile objective of one parameter.

    Parameters
    ----------
    parameter
        Its name.
    values, objectives
        In rising order, shape (k,): natural values and the lowest objective found at each, the optimum among them.
    others
        All free parameters there, shape (k, d), natural values.
    limit
        Objective at the ends of the interval.
    lower, upper
        Ends of the interval, natural values; None where it is open: the profile stays below the limit up to the bound.
    better
        Lowest objective found, where it is below that of the optimum by more than the tolerance; None otherwise. The
        search then had not found the best fit.
    """

    parameter: str
    values: FloatArray
    objectives: FloatArray
    others: FloatArray
    limit: float
    lower: float | None
    upper: float | None
    better: float | None

    @property
    def interval(self) -> tuple[float, float] | None:
        """The interval when it is closed on both sides."""
        return None if self.lower is None or self.upper is None else (self.lower, self.upper)


@dataclass(frozen=True, slots=True)
class Profiles:
    """State of all profiles between two generations; JSON-able.

    Parameters
    ----------
    optimum
        Shape (d,), in parts of the range in search coordinates.
    objective
        f there.
    increase
        By how much a profile rises to the ends of its interval, shape (d,).
    chains
        One a parameter and side.
    generation
        Number of the generation that is due, from 0.
    evaluations
        Made so far.
    """

    optimum: FloatArray
    objective: float
    increase: FloatArray
    chains: tuple[Chain, ...]
    generation: int = 0
    evaluations: int = 0

    @property
    def finished(self) -> bool:
        """Whether nothing is left to evaluate."""
        return all(chain.finished for chain in self.chains)

    def positions(self, calibration: Calibration) -> FloatArray:
        """Positions of the generation that is due, shape (n, d), natural values; empty when finished."""
        parts = [chain.positions(calibration) for chain in self.chains if not chain.finished]
        return np.concatenate(parts) if parts else np.empty((0, len(self.optimum)))

    def advance(self, calibration: Calibration, evaluations: Sequence[Evaluation]) -> Profiles:
        """Take the evaluations of :meth:`positions`, in their order, and plan the next generation; pure.

        Raises
        ------
        StatisticsError
            When their number is wrong.
        """
        sizes = [len(chain.positions(calibration)) for chain in self.chains if not chain.finished]
        if len(evaluations) != sum(sizes):
            raise StatisticsError(f"{len(evaluations)} evaluations are given, {sum(sizes)} are due")
        chains, start = [], 0
        for chain in self.chains:
            if chain.finished:
                chains.append(chain)
                continue
            size = sizes.pop(0)
            chains.append(chain.advance(calibration, evaluations[start : start + size], self.objective))
            start += size
        return replace(
            self, chains=tuple(chains), generation=self.generation + 1, evaluations=self.evaluations + len(evaluations)
        )

    def results(self, calibration: Calibration) -> tuple[Profile, ...]:
        """Profiles as far as they have got, one a parameter."""
        return tuple(self._profile(calibration, index) for index in range(len(self.optimum)))

    def _profile(self, calibration: Calibration, index: int) -> Profile:
        space = calibration.space
        low, span = space.search_lower, space.search_upper - space.search_lower
        centre = ChainPoint(self.optimum, self.objective)
        sides = [[centre, *chain.points] for chain in self.chains if chain.index == index]
        points = [*reversed(sides[0][1:]), *sides[1]]
        natural = space.to_natural(low + np.array([point.unit for point in points]) * span)
        limit = self.objective + float(self.increase[index])
        ends = [_crossing(side, index, self.objective, limit) for side in sides]
        natural_ends = [
            None if end is None else float(space.to_natural(low + np.full(len(low), end) * span)[index]) for end in ends
        ]
        lowest = min(point.objective for point in points)
        better = lowest if lowest < self.objective - 0.05 * self.increase[index] else None
        return Profile(
            parameter=calibration.free_names[index],
            values=natural[:, index],
            objectives=np.array([point.objective for point in points]),
            others=natural,
            limit=limit,
            lower=natural_ends[0],
            upper=natural_ends[1],
            better=better,
        )

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, from which :meth:`from_json` restores exactly."""
        return {
            "optimum": self.optimum.tolist(),
            "objective": self.objective,
            "increase": self.increase.tolist(),
            "chains": [chain.to_json() for chain in self.chains],
            "generation": self.generation,
            "evaluations": self.evaluations,
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Profiles:
        """Restore from :meth:`to_json`."""
        return cls(
            optimum=np.array(data["optimum"], dtype=np.float64),
            objective=data["objective"],
            increase=np.array(data["increase"], dtype=np.float64),
            chains=tuple(Chain.from_json(chain) for chain in data["chains"]),
            generation=data["generation"],
            evaluations=data["evaluations"],
        )


def start_profiles(
    calibration: Calibration, linearisation: Linearisation, objective: float, *, parameters: Sequence[str] | None = None
) -> Profiles:
    """Begin profiles at the optimum of a linearisation.

    Parameters
    ----------
    objective
        f at that optimum.
    parameters
        Names of those to profile; all when absent. The others' chains are finished from the start.

    Raises
    ------
    StatisticsError
        When the noise is neither known nor could be estimated, or a name is unknown.
    """
    if linearisation.noise is None:
        raise StatisticsError("a profile interval needs the noise: give it, there are too few points to estimate it")
    wanted = calibration.free_names if parameters is None else tuple(parameters)
    unknown = sorted(set(wanted) - set(calibration.free_names))
    if unknown:
        raise StatisticsError(f"unknown parameter {', '.join(unknown)}; free: {', '.join(calibration.free_names)}")
    space = calibration.space
    low, span = space.search_lower, space.search_upper - space.search_lower
    unit = np.clip((space.to_search(linearisation.optimum) - low) / span, 0.0, 1.0)
    chains = []
    for index, name in enumerate(calibration.free_names):
        half = linearisation.unit_width(name) / 2.0
        step = float(np.clip(half / 3.0, 1e-6, _WIDEST_STEP)) if np.isfinite(half) else _BLIND_STEP
        for side in (-1, 1):
            increase = float(linearisation.profile_increase[index])
            chains.append(Chain.begin(index, side, unit, step, increase, idle=name not in wanted))
    return Profiles(unit, objective, linearisation.profile_increase, tuple(chains))


def _crossing(side: list[ChainPoint], index: int, lowest: float, limit: float) -> float | None:
    """Where the profile first exceeds the limit, in parts of the range; None if it never does.

    Interpolated between neighbours in the root of the rise, which is straight for a parabola.
    """
    for before, after in pairwise(side):
        if after.objective >= limit:
            a, b, c = (np.sqrt(max(f - lowest, 0.0)) for f in (before.objective, after.objective, limit))
            part = 1.0 if b <= a else (c - a) / (b - a)
            return float(before.unit[index] + part * (after.unit[index] - before.unit[index]))
    return None
