"""Whether the model bends within the intervals at an optimum, and intervals by likelihood where it does.

A linearised interval of a parameter ends where the objective of the *linearised* model, the others fitted anew, has
risen by a limit. One forward run at each end tells how much that of the model itself rises there: what the linearised
effects of the other parameters can take off its residuals is taken off. With tau^2 the ratio of the two rises, the
interval by likelihood is about 1 / tau as long on that side (the profile t plot of Bates and Watts 1988, section 6.1,
at one place). Where that differs by more than a tenth, the profile objective gives the interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability.differences import residual_rows
from geoswarm.solver.identifiability.linearisation import Linearisation
from geoswarm.solver.identifiability.profiles import Profile, profile_settings, profiles_of
from geoswarm.solver.search.follow_ups import ProfileSearch

__all__ = ["IntervalEnds", "interval_ends", "likelihood_intervals", "measure_bending", "with_profiles"]

_SHORTEST = 0.25  # of the half width: nearer to a bound, nothing is tried on that side
_LARGEST = 10.0


@dataclass(frozen=True, slots=True)
class IntervalEnds:
    """Where the model is run to see whether it bends.

    Parameters
    ----------
    positions
        Natural values, shape (k, d).
    parameter
        Whose interval ends there, shape (k,).
    part
        Of the half width that the position is away, at most 1; less where a bound is nearer, shape (k,).
    """

    positions: FloatArray
    parameter: IntArray
    part: FloatArray


def interval_ends(calibration: Calibration, linearisation: Linearisation) -> IntervalEnds:
    """Ends of the linearised intervals, the other parameters fitted anew to first order; two for each parameter."""
    space = calibration.space
    centre = space.to_unit(linearisation.optimum)
    positions, parameter, parts = [], [], []
    for index in range(space.dimension):
        half = linearisation.linear_half_widths[index]
        if not np.isfinite(half) or half <= 0.0:
            continue
        path = linearisation.model.path(index) * half
        for side in (-1.0, 1.0):
            room = np.where(side * path > 0.0, 1.0 - centre, centre)
            with np.errstate(divide="ignore"):
                part = min(1.0, float(np.min(np.where(path == 0.0, np.inf, room / np.abs(path)))))
            if part >= _SHORTEST:
                positions.append(space.from_unit(np.clip(centre + side * part * path, 0.0, 1.0)))
                parameter.append(index)
                parts.append(part)
    shape = (len(positions), space.dimension)
    return IntervalEnds(np.array(positions).reshape(shape), np.array(parameter, dtype=np.int64), np.array(parts))


def measure_bending(
    calibration: Calibration, linearisation: Linearisation, ends: IntervalEnds, evaluations: Sequence[Evaluation]
) -> Linearisation:
    """Take in the evaluations at :func:`interval_ends`: the same linearisation with its ``bending``."""
    rows = residual_rows(calibration, evaluations)
    lowest = float(np.sum(linearisation.model.residuals**2))
    bending = np.full(len(linearisation.names), np.nan)
    for index in range(len(bending)):
        others = np.delete(linearisation.model.weighted, index, axis=1)
        left, singular, _ = np.linalg.svd(others, full_matrices=False)
        basis = left[:, singular > 1e-10 * max(float(singular.max(initial=0.0)), 1e-300)]
        found = []
        for row, part in zip(rows[ends.parameter == index], ends.part[ends.parameter == index], strict=True):
            if not np.isfinite(row).all():
                continue
            remaining = row - basis @ (basis.T @ row)
            rise = float(np.sum(remaining**2)) - lowest
            expected = part**2 * float(linearisation.profile_increase[index])
            tau = float(np.sqrt(max(rise, 0.0) / expected)) if expected > 0.0 else 1.0
            # what it would be at the end itself: the departure from a parabola grows with the distance
            tau = max(1.0 + (tau - 1.0) / part, 1.0 / _LARGEST)
            found.append(max(tau, 1.0 / tau) - 1.0)
        if found:
            bending[index] = max(found)
    return replace(linearisation, bending=bending)


def likelihood_intervals(calibration: Calibration, linearisation: Linearisation) -> Linearisation:
    """See whether the model bends, and where it does take the intervals by likelihood, with runs in this process.

    Two runs for each parameter that has an interval, and a profile of those within whose intervals the model bends.
    """
    ends = interval_ends(calibration, linearisation)
    checked = measure_bending(
        calibration, linearisation, ends, [calibration.evaluate(position) for position in ends.positions]
    )
    return with_profiles(checked, _profiles(calibration, checked))


def with_profiles(linearisation: Linearisation, profiles: Sequence[Profile]) -> Linearisation:
    """Put the intervals of complete profiles in the place of the linearised ones.

    An end that the data leave open lies on the bound; open on both sides, there is no interval. Profiles that found a
    better fit than the optimum, and parameters without a linearised interval, are left aside.
    """
    intervals, widths = linearisation.intervals.copy(), linearisation.unit_widths.copy()
    bases = list(linearisation.bases)
    for profile in profiles:
        index = linearisation.names.index(profile.parameter)
        if not profile.complete or profile.better is not None or not np.isfinite(widths[index]):
            continue
        low = float(profile.values[0]) if profile.lower is None else profile.lower
        high = float(profile.values[-1]) if profile.upper is None else profile.upper
        ends = np.array([low, high])
        if linearisation.scales[index] == "log":
            ratio = float(np.diff(np.log(ends))[0] / np.diff(np.log(intervals[index]))[0])
        else:
            ratio = float(np.diff(ends)[0] / np.diff(intervals[index])[0])
        bases[index] = "profile"
        is_open = profile.lower is None and profile.upper is None
        intervals[index] = np.nan if is_open else ends
        widths[index] = np.nan if is_open else widths[index] * ratio
    return replace(linearisation, intervals=intervals, unit_widths=widths, bases=tuple(bases))


def _profiles(calibration: Calibration, linearisation: Linearisation) -> tuple[Profile, ...]:
    bent = [name for name in linearisation.names if linearisation.bent(name)]
    if not bent:
        return ()
    search = ProfileSearch(calibration.space, profile_settings(calibration, linearisation, parameters=bent))
    while (due := search.ask()) is not None:
        search.take(residual_rows(calibration, [calibration.evaluate(position) for position in due]))
    return profiles_of(search)
