"""Profile objectives: the lowest objective for every value of one parameter, and the intervals they give.

For each parameter and side, a chain of values walks away from the optimum; at each, the other parameters are fitted by
Levenberg-Marquardt steps. All paths advance together, generation by generation, as any search does
(:class:`geoswarm.solver.search.descent.planned.ProfileSearch`): a job with ``method: {kind: profile}``, dispatched and
resumed like every other. Here is what such a job needs, and what its evaluations tell.

An interval ends where the profile has risen by ``increase``: for one series and estimated noise by the factor
1 + F_{1, n-d} / (n - d) (Bates and Watts 1988, section 6.1.2). Where the profile stays below it up to a bound, the
interval is open on that side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.search.descent.planned import BLIND_STEP, ProfileSearch, ProfileSettings
from geoswarm.solver.search.descent.profile_paths import ProfilePoint

__all__ = ["Profile", "profile_settings", "profiles_of"]

_WIDEST_STEP = 0.1


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
    complete
        Whether both sides have ended; else a missing end only means that the profile has not got there.
    """

    parameter: str
    values: FloatArray
    objectives: FloatArray
    others: FloatArray
    limit: float
    lower: float | None
    upper: float | None
    better: float | None
    complete: bool

    @property
    def interval(self) -> tuple[float, float] | None:
        """The interval when it is closed on both sides."""
        return None if self.lower is None or self.upper is None else (self.lower, self.upper)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "parameter": self.parameter,
            "values": self.values.tolist(),
            "objectives": self.objectives.tolist(),
            "others": self.others.tolist(),
            "limit": self.limit,
            "lower": self.lower,
            "upper": self.upper,
            "better": self.better,
            "complete": self.complete,
        }


def profile_settings(
    calibration: Calibration, linearisation: Linearisation, *, parameters: Sequence[str] | None = None
) -> ProfileSettings:
    """Return where profiles start, the size of their first steps, and where they end.

    Parameters
    ----------
    linearisation
        At the optimum.
    parameters
        Names of those to profile; all when absent.

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
    rise = [
        float(increase) if name in wanted else np.nan
        for name, increase in zip(calibration.free_names, linearisation.profile_increase, strict=True)
    ]
    steps = []
    for name in calibration.free_names:
        half = linearisation.unit_width(name) / 2.0
        steps.append(float(np.clip(half / 3.0, 1e-6, _WIDEST_STEP)) if np.isfinite(half) else BLIND_STEP)
    return ProfileSettings(linearisation.optimum, np.array(rise), np.array(steps))


def profiles_of(search: ProfileSearch) -> tuple[Profile, ...]:
    """Profiles as far as they have got, one a parameter that was asked for; none before the optimum is known."""
    if search.objective is None:
        return ()
    wanted = np.flatnonzero(np.isfinite(search.settings.rise)).tolist()
    return tuple(_profile(search, search.objective, index) for index in wanted)


def _profile(search: ProfileSearch, lowest: float, index: int) -> Profile:
    space, rise = search.space, float(search.settings.rise[index])
    centre = ProfilePoint(space.to_unit(search.settings.optimum), lowest)
    paths = [path for path in search.paths if path.index == index]
    sides = [[centre, *path.points] for path in paths]
    points = [*reversed(sides[0][1:]), *sides[1]]
    natural = space.from_unit(np.array([point.unit for point in points]))
    limit = lowest + rise
    ends = [_crossing(side, index, lowest, limit) for side in sides]
    bounds = [None if end is None else float(space.from_unit(np.full(space.dimension, end))[index]) for end in ends]
    found = min(point.objective for point in points)
    return Profile(
        parameter=space.names[index],
        values=natural[:, index],
        objectives=np.array([point.objective for point in points]),
        others=natural,
        limit=limit,
        lower=bounds[0],
        upper=bounds[1],
        better=found if found < lowest - 0.05 * rise else None,
        complete=all(path.finished for path in paths),
    )


def _crossing(side: list[ProfilePoint], index: int, lowest: float, limit: float) -> float | None:
    """Where the profile first exceeds the limit, in parts of the range; None if it never does.

    Interpolated between neighbours in the root of the rise, which is straight for a parabola.
    """
    for before, after in pairwise(side):
        if after.objective >= limit:
            a, b, c = (np.sqrt(max(f - lowest, 0.0)) for f in (before.objective, after.objective, limit))
            part = 1.0 if b <= a else (c - a) / (b - a)
            return float(before.unit[index] + part * (after.unit[index] - before.unit[index]))
    return None
