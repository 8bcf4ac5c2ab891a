"""Size and sign of readings against the specimen: what no soil can do, and what it hardly does."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from geoswarm.solver.plausibility.staged import StagedReadings, staged_readings
from geoswarm.solver.plausibility.units import meant_unit
from geoswarm.solver.problem import Problem
from geoswarm.solver.units import same_unit

__all__ = ["impossible_readings"]

_MOST = 0.7
"""Largest strain to be believed at the end of a test."""
_LEAST_INDEX = 2.0e-4
"""Least strain to be believed for each ln(stress): a tenth of the lowest usual kappa_star."""
_VOID_RATIO = (0.05, 15.0)
_NEGATIVE = 3.0
"""The lowest reading is negative, and so many times as far from zero as the highest."""


def impossible_readings(problem: Problem) -> Iterator[str]:
    """Readings larger than the specimen or next to nothing, and readings of the wrong sign."""
    for readings in staged_readings(problem):
        if readings.quantity == "void_ratio":
            yield from _void_ratio(readings)
        else:
            yield from _sign(readings)
            yield from _size(readings)


def _size(readings: StagedReadings) -> Iterator[str]:
    length, name = _length(readings)
    largest = float(np.abs(readings.y).max())
    strain = largest / length
    zero = readings.spec.zero_at_stage
    loaded = float(readings.stresses[zero:].max() / readings.stresses[zero - 1])
    least = _LEAST_INDEX * math.log(max(loaded, 1.0))
    if strain == 0.0 or least <= strain <= _MOST:
        return
    begins = f"{readings.title} the largest reading, {readings.in_data(largest)}, is"
    if strain > 1.0:
        what = f"more than the {name}" if name else "a strain of more than 1, so more than the specimen itself"
    elif strain > _MOST:
        what = f"{strain:.0%} of the {name}" if name else f"a strain of {strain:.0%}"
        what += ", more than soils are compressed by in a test"
    else:
        what = f"only {strain:.2g} of the {name}" if name else f"a strain of only {strain:.1g}"
        what += f", under {loaded:.0f} times the initial stress"
    yield f"{begins} {what}; {_remedy(readings, largest, length, least)}"


def _remedy(readings: StagedReadings, largest: float, length: float, least: float) -> str:
    meant = None
    if same_unit(readings.y_unit, readings.y_base):
        meant = meant_unit(largest, readings.y_base, lambda y: least <= y / length <= _MOST)
    if meant is not None:
        share = f"{meant[1] / length:.2g} of it" if length != 1.0 else f"{meant[1]:.2g}"
        return f"in {meant[0]} it would be {share}: y_unit: {meant[0]}"
    height = "" if length == 1.0 else f", and {readings.section}.height"
    return f"check y_unit, now {readings.y_unit or '1'}{height}"


def _sign(readings: StagedReadings) -> Iterator[str]:
    zero = readings.spec.zero_at_stage
    if readings.stresses[zero:].max() <= readings.stresses[zero - 1]:
        return  # nothing but unloading
    low, high = float(readings.y.min()), float(readings.y.max())
    if low < 0.0 and -low > _NEGATIVE * max(high, 0.0):
        yield (
            f"{readings.title} the readings are negative (down to {readings.in_data(low)}) while the stress rises to "
            f"{readings.stresses[zero:].max():g} kPa, but compression is positive; give them with the opposite sign"
        )


def _void_ratio(readings: StagedReadings) -> Iterator[str]:
    low, high = float(readings.y.min()), float(readings.y.max())
    if not (low < _VOID_RATIO[0] or high > _VOID_RATIO[1]):
        return
    wrong = high if high > _VOID_RATIO[1] else low
    meant = (
        meant_unit(wrong, "", lambda e: _VOID_RATIO[0] <= e <= 5.0)
        if same_unit(readings.y_unit, readings.y_base)
        else None
    )
    remedy = "check the column and y_unit" if meant is None else f"if they are in {meant[0]}: y_unit: '{meant[0]}'"
    yield (
        f"{readings.title} a void ratio of {readings.in_data(wrong)} is outside what soils have, {_VOID_RATIO[0]:g} to "
        f"{_VOID_RATIO[1]:g}; {remedy}"
    )


def _length(readings: StagedReadings) -> tuple[float, str]:
    """Length that a reading is compared with, m, and what it is; 1 for a strain."""
    spec = readings.spec
    if readings.quantity == "radial_displacement":
        return spec.radius, f"radius of the specimen, {spec.radius:g} m"
    if readings.quantity in ("settlement", "axial_displacement"):
        return spec.height, f"height of the specimen, {spec.height:g} m"
    return 1.0, ""
