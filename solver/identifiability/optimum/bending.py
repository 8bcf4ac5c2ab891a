"""Whether the model is nonlinear within the intervals at an optimum, and intervals by likelihood where it does.

A linearised interval of a parameter ends where the objective of the *linearised* model, the others refitted, has
risen by a limit. One forward run at each end shows how much that of the model itself rises there: what the linearised
effects of the other parameters can take off its residuals is taken off. With tau^2 the ratio of the two rises, the
interval by likelihood is about 1 / tau as long on that side (the profile t plot of Bates and Watts 1988, section 6.1,
at one place). Where that differs by a tenth to a fifth, both ends are moved so; by more, the profile objective gives
the interval. Nine of ten moved ends are off by less than a tenth (docs/statistics.md).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability.optimum.differences import residual_rows
from geoswarm.solver.identifiability.optimum.linearisation import BENDS, CORRECTED, IntervalBasis, Linearisation
from geoswarm.solver.identifiability.optimum.profiles import Profile, profile_settings, profiles_of
from geoswarm.solver.search.descent.interval_ends import IntervalEnds, plan_ends
from geoswarm.solver.search.descent.planned import ProfileSearch

__all__ = ["likelihood_intervals", "measure_bending", "with_profiles"]

_LARGEST = 10.0
_SAME_LIMIT = 0.02  # of the rise of a profile up to the end of the interval
_NEAREST, _FARTHEST = 0.25, 3.0  # of the half width: places from which nothing is concluded about the end


def measure_bending(
    calibration: Calibration, linearisation: Linearisation, ends: IntervalEnds, evaluations: Sequence[Evaluation]
) -> Linearisation:
    """Take in the evaluations at the ends of the intervals: ``bending``, and ends moved where that is enough."""
    rows = residual_rows(calibration, evaluations)
    lowest = float(np.sum(linearisation.model.residuals**2))
    bending = np.full(len(linearisation.names), np.nan)
    moved_ends: dict[int, FloatArray] = {}
    places, centre = calibration.space.to_unit(ends.positions), calibration.space.to_unit(linearisation.optimum)
    for index in range(len(bending)):
        others = np.delete(linearisation.model.weighted, index, axis=1)
        left, singular, _ = np.linalg.svd(others, full_matrices=False)
        basis = left[:, singular > 1e-10 * max(float(singular.max(initial=0.0)), 1e-300)]
        factors = [1.0, 1.0]  # of the lengths below and above
        own = ends.parameter == index
        for row, away, place in zip(rows[own], ends.moved[own], places[own], strict=True):
            part = float(away / linearisation.linear_half_widths[index])
            if not np.isfinite(row).all() or not _NEAREST <= part <= _FARTHEST:
                continue
            remaining = row - basis @ (basis.T @ row)
            rise = float(np.sum(remaining**2)) - lowest
            expected = part**2 * float(linearisation.profile_increase[index])
            tau = float(np.sqrt(max(rise, 0.0) / expected)) if expected > 0.0 else 1.0
            # what it would be at the end itself: the departure from a parabola grows with the distance
            tau = max(1.0 + (tau - 1.0) / part, 1.0 / _LARGEST)
            factors[int(place[index] > centre[index])] = 1.0 / tau
            bending[index] = max(np.nan_to_num(bending[index]), max(tau, 1.0 / tau) - 1.0)
        if BENDS < bending[index] <= CORRECTED and not linearisation.to_rounding:
            optimum, interval = (
                _in_search(linearisation, index, one[index]) for one in (linearisation.optimum, linearisation.intervals)
            )
            moved = optimum + (interval - optimum) * np.array(factors)
            moved_ends[index] = np.exp(moved) if linearisation.scales[index] == "log" else moved
    return _with_ends(replace(linearisation, bending=bending), moved_ends, "moved")


def _with_ends(linearisation: Linearisation, ends: Mapping[int, FloatArray], basis: IntervalBasis) -> Linearisation:
    """Give some parameters other intervals, natural values, each of shape (2,); nan: none."""
    intervals, widths, bases = linearisation.intervals.copy(), linearisation.unit_widths.copy(), [*linearisation.bases]
    for index, new in ends.items():
        before, after = (float(np.ptp(_in_search(linearisation, index, one))) for one in (intervals[index], new))
        intervals[index], widths[index], bases[index] = new, widths[index] * after / before, basis
    return replace(linearisation, intervals=intervals, unit_widths=widths, bases=tuple(bases))


def _in_search(linearisation: Linearisation, index: int, values: FloatArray) -> FloatArray:
    """Natural values of a parameter in search coordinates."""
    return np.log(values) if linearisation.scales[index] == "log" else values


def likelihood_intervals(calibration: Calibration, linearisation: Linearisation) -> Linearisation:
    """Check whether the model is nonlinear, and take the intervals by likelihood where it is, with runs in process.

    Two runs for each parameter that has an interval, and a profile of those within whose intervals the model is
    nonlinear.
    """
    half = linearisation.linear_half_widths
    ends = plan_ends(calibration.space, linearisation.optimum, linearisation.model.inverse, half)
    checked = measure_bending(
        calibration, linearisation, ends, [calibration.evaluate(position) for position in ends.positions]
    )
    return with_profiles(checked, _profiles(calibration, checked))


def with_profiles(linearisation: Linearisation, profiles: Sequence[Profile]) -> Linearisation:
    """Put the intervals of complete profiles in the place of the linearised ones.

    An end that the data leave open lies on the bound; open on both sides, there is no interval. Profiles of another
    optimum or noise, such that found a better fit than the optimum, and parameters without a linearised interval are
    left aside.
    """
    lowest = float(np.sum(linearisation.model.residuals**2))
    found: dict[int, FloatArray] = {}
    for profile in profiles:
        index = linearisation.names.index(profile.parameter)
        if not profile.complete or profile.better is not None or not np.isfinite(linearisation.unit_widths[index]):
            continue
        if not np.ptp(linearisation.intervals[index]) > 0.0:  # of an exact fit, below the spacing of floats
            continue
        rise = float(linearisation.profile_increase[index])
        if abs(profile.limit - lowest - rise) > _SAME_LIMIT * rise:
            continue
        low = float(profile.values[0]) if profile.lower is None else profile.lower
        high = float(profile.values[-1]) if profile.upper is None else profile.upper
        is_open = profile.lower is None and profile.upper is None
        found[index] = np.array([np.nan, np.nan] if is_open else [low, high])
    return _with_ends(linearisation, found, "profile")


def _profiles(calibration: Calibration, linearisation: Linearisation) -> tuple[Profile, ...]:
    unprofiled = [name for name in linearisation.names if linearisation.needs_profile(name)]
    if not unprofiled:
        return ()
    search = ProfileSearch(calibration.space, profile_settings(calibration, linearisation, parameters=unprofiled))
    while (due := search.ask()) is not None:
        search.take(residual_rows(calibration, [calibration.evaluate(position) for position in due]))
    return profiles_of(search)
