"""Size and sign of readings against the specimen: what no soil can do, and what it hardly does."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from pydantic import BaseModel

from geoswarm.solver.errors import Issue
from geoswarm.solver.forward.base import SeriesInfo
from geoswarm.solver.forward.staged_section import StagedLoadSpec
from geoswarm.solver.laboratory.section import FlowSpec, LaboratorySpec
from geoswarm.solver.plausibility.loads import ends_early_in
from geoswarm.solver.plausibility.staged import StagedReadings, staged_readings
from geoswarm.solver.problem import Observation, Problem
from geoswarm.solver.problem.stages import section_of_test
from geoswarm.solver.sentences import Key, Sentence, plain, setting
from geoswarm.solver.units import convert, meant_unit, with_unit
from geoswarm.solver.words import per_cent

__all__ = ["Doubt", "doubtful_readings"]

_MOST = 0.7
"""Largest strain to be believed at the end of a test."""
_LEAST_INDEX = 2.0e-4
"""Least strain to be believed for each ln(stress): a tenth of the lowest usual kappa_star."""
_NOTHING = 0.5
"""Part of that least strain below which readings cannot be those of a soil: its modulus would be that of rock, 4 GPa
at 400 kPa. Settlements of a clay in mm that are taken for µm are some 0.1 to 0.3 of it."""
_VOID_RATIO = (0.05, 15.0)
_NEGATIVE = 3.0
"""The lowest reading is negative, and this many times as far from zero as the highest."""
_STRESSES, _USUAL_STRESSES = (1.0e-3, 1.0e3), (0.02, 20.0)
"""Largest stress that is read over the largest one that is applied: what is possible, and what is usual."""
_GAUGE = "0.01 mm"
"""Unit of dial gauges, of which others divide into smaller steps."""
_SHEARED, _STRENGTHS, _USUAL_STRENGTHS = 0.01, (0.06, 30.0), (0.06, 5.0)
"""Strain from which soils have some strength; their largest shear stress over the largest stress applied, twice."""
_SHORT, _WHOLE = 0.02, (0.5, 1.02)
"""Part of the strain at the end of a test that readings seldom end before; what they reach in the right unit."""
_AT_FIRST, _OFFSET = 2.0e-3, 5.0
"""Part of the largest x up to which a reading is one of the beginning; kPa that its pore pressure may be off."""
_ANEW, _SOME = 0.02, 2
"""Part of the range of x from its beginning within which readings begin anew, and how many are then another test."""
_SYMBOLS = frozenset(("q", "p'", "τ", "σ'v"))
"""Quantities of series that are stresses."""
_SHEAR = frozenset(("q", "τ"))


@dataclass(frozen=True, slots=True)
class Doubt:
    """Readings of a series that are probably not meant.

    Parameters
    ----------
    series, observation
        Name, and place in the problem: ``observations[0]``.
    field
        Key of the observation that is probably wrong; empty if it is none.
    seen
        What is seen, and what it would be in another unit.
    remedy
        What to do, as the rest of that sentence.
    impossible
        Whether no soil has such readings.
    unit
        The unit in which they would be usual ones; None where none is known.
    """

    series: str
    observation: str
    field: str
    seen: str
    remedy: Sentence
    impossible: bool
    unit: str | None = None

    @property
    def message(self) -> str:
        """What is seen and what to do, in the words of the problem file."""
        return plain((self.seen, *self.remedy))

    @property
    def sentence(self) -> Sentence:
        """The message with its place."""
        place = Key(self.observation, f"{self.observation} ({self.series})", self.series)
        return place, f": {self.seen}", *self.remedy

    @property
    def issue(self) -> Issue:
        """The doubt as a mistake in the problem."""
        path = f"{self.observation}.{self.field}" if self.field else self.observation
        accept = Key("accept", f"accept: [{self.series}]", self.series)
        return Issue.about(path, (self.seen, *self.remedy, "; ", accept, " runs the problem as it is"))


def doubtful_readings(problem: Problem) -> Iterator[Doubt]:
    """Readings larger than the specimen or next to nothing, of the wrong sign, or far from the loads."""
    for readings in staged_readings(problem):
        yield from _times(readings)
        if readings.quantity == "void_ratio":
            yield from _void_ratio(readings)
        else:
            yield from _sign(readings)
            yield from _size(readings)
    infos = {info.name: info for info in problem.model.series}
    for index, one in enumerate(problem.observations):
        section, spec, name = section_of_test(problem.forward_model, one.series)
        if isinstance(spec, LaboratorySpec):
            yield from _of_any_law(f"observations[{index}]", one, infos[one.series], spec)
            yield from _begins_anew(f"observations[{index}]", one, infos[one.series])
            yield from _ends_early(f"observations[{index}]", one, infos[one.series], spec)
            yield from _no_modulus(f"observations[{index}]", one, infos[one.series])
            if name == "pore_pressure" and not isinstance(spec, FlowSpec):
                yield from _back_pressure(f"observations[{index}]", one, section, getattr(spec, "back_pressure", 0.0))


def _times(readings: StagedReadings) -> Iterator[Doubt]:
    """Times of the first stages only, which in another unit end with the test."""
    ends = ends_early_in(readings)
    if ends is not None and (meant := ends[1]) is not None:
        seen = f"{ends[0]}; in {meant} they would end with it"
        remedy: Sentence = ": ", setting(f"{readings.path}.x_unit", meant)
        yield Doubt(readings.observation.series, readings.path, "x_unit", seen, remedy, True, meant)


def _size(readings: StagedReadings) -> Iterator[Doubt]:
    length, name = _length(readings)
    largest = float(np.abs(readings.y).max())
    strain = largest / length
    zero = readings.spec.zero_at_stage
    loaded = float(readings.stresses[zero:].max() / readings.stresses[zero - 1])
    least = _LEAST_INDEX * math.log(max(loaded, 1.0)) if readings.drains_at_once else 0.0
    if strain == 0.0 or least <= strain <= _MOST:
        return
    begins = f"the largest reading, {readings.in_data(largest)}, is"
    if strain > 1.0:
        what = f"more than the {name}" if name else "a strain of more than 1, so more than the specimen itself"
    elif strain > _MOST:
        what = f"{per_cent(strain)} of the {name}" if name else f"a strain of {per_cent(strain)}"
        what += ", more than soils are compressed by in a test"
    else:
        what = f"only {strain:.2g} of the {name}" if name else f"a strain of only {strain:.1g}"
        what += f", under {loaded:.0f} times the initial stress"
    usual = partial(_within, length, (least, _MOST))
    meant = meant_unit(largest, readings.y_base, usual, given=readings.y_unit)
    if meant is not None:
        share = f"{meant[1] / length:.2g} of it" if length != 1.0 else f"{meant[1]:.2g}"
        what += f"; in {meant[0]} it would be {share}"
        smaller = partial(_within, length, (least, 0.5 * meant[1] / length))
        other = meant_unit(largest, readings.y_base, smaller, given=readings.y_unit)
        if meant[0] == _GAUGE and other is not None:
            what += f", in {other[0]} {other[1] / length:.2g}"
    height: Sentence = () if length == 1.0 else (", and ", readings.key("height"))
    remedy = _unit(readings.path, "y", readings.y_unit, meant, height)
    if meant is not None and length != 1.0 and strain < least:
        remedy = (*remedy, ", or check ", readings.key("height"))
    impossible = strain > 1.0 or strain < _NOTHING * least
    unit = meant and meant[0]
    yield Doubt(readings.observation.series, readings.path, "y_unit", f"{begins} {what}", remedy, impossible, unit)


def _sign(readings: StagedReadings) -> Iterator[Doubt]:
    zero = readings.spec.zero_at_stage
    if readings.stresses[zero:].max() <= readings.stresses[zero - 1]:
        return  # nothing but unloading
    low, high = float(readings.y.min()), float(readings.y.max())
    if low < 0.0 and -low > _NEGATIVE * max(high, 0.0):
        seen = (
            f"the readings are negative (down to {readings.in_data(low)}) while the stress rises to "
            f"{readings.stresses[zero:].max():g} kPa, but compression is positive"
        )
        remedy = ("; ", setting(f"{readings.path}.y_factor", "-1"), " turns them")
        yield Doubt(readings.observation.series, readings.path, "", seen, remedy, False)


def _void_ratio(readings: StagedReadings) -> Iterator[Doubt]:
    low, high = float(readings.y.min()), float(readings.y.max())
    if not (low < _VOID_RATIO[0] or high > _VOID_RATIO[1]):
        return
    wrong = high if high > _VOID_RATIO[1] else low
    meant = meant_unit(wrong, "", lambda e: _VOID_RATIO[0] <= e <= 5.0, given=readings.y_unit)
    unit = f"{readings.path}.y_unit"
    remedy: Sentence = ("; check the column and ", setting(unit))
    if meant is not None:
        remedy = (f"; if they are in {meant[0]}: ", setting(unit, meant[0]))
    seen = (
        f"a void ratio of {readings.in_data(wrong)} is outside what soils have, {_VOID_RATIO[0]:g} to "
        f"{_VOID_RATIO[1]:g}"
    )
    impossible = wrong <= 0.0 or wrong == high
    yield Doubt(readings.observation.series, readings.path, "y_unit", seen, remedy, impossible, meant and meant[0])


def _unit(place: str, axis: str, unit: str, meant: tuple[str, float] | None, other: Sentence = ()) -> Sentence:
    """What to do where a unit is probably another one."""
    path = f"{place}.{axis}_unit"
    if meant is not None:
        return ": ", setting(path, meant[0])
    return "; check ", setting(path), f", now {unit or '1'}", *other


def _length(readings: StagedReadings) -> tuple[float, str]:
    """Length that a reading is compared with, m, and what it is; 1 for a strain."""
    spec = readings.spec
    if readings.quantity == "radial_displacement" and isinstance(spec, StagedLoadSpec):
        return spec.radius, f"radius of the specimen, {spec.radius:g} m"
    if readings.quantity in ("settlement", "axial_displacement"):
        return spec.height, f"height of the specimen, {spec.height:g} m"
    return 1.0, ""


def _of_any_law(place: str, observation: Observation, info: SeriesInfo, spec: LaboratorySpec) -> Iterator[Doubt]:
    """Strains above 1 and stresses far from those that are applied, in tests on a material point of any law."""
    load = _largest_load(spec)
    for axis, quantity, base, values, given in (
        ("x", info.x_quantity, info.x_unit, observation.x, observation.x_unit),
        ("y", info.y_quantity, info.y_unit, observation.y, observation.y_unit),
    ):
        largest = float(np.abs(values).max())
        if "strain" in quantity and "shear" not in quantity:
            scale, low, high, usual = 1.0, 0.0, 1.0, (0.0, _MOST)
            what = "more than 1, so more than the specimen itself"
        elif (quantity in _SYMBOLS or quantity.endswith(" stress")) and load is not None and largest > 0.0:
            scale, (low, high), usual = load, _STRESSES, _USUAL_STRESSES
            what = f"{largest / load:.2g} times the largest stress that is applied, {load:g} kPa"
        else:
            continue
        possible = low <= largest / scale <= high
        if possible and (quantity not in _SHEAR or _usual_strength(observation, info, largest / scale)):
            continue
        unit = given or base
        usual = _USUAL_STRENGTHS if possible else usual
        meant = meant_unit(largest, base, partial(_within, scale, usual), given=unit)
        if meant is not None:
            what += f"; in {meant[0]} it would be {with_unit(float(f'{meant[1]:.2g}'), base)}"
        shown = with_unit(float(f"{float(convert(largest, base or '1', unit or '1')):.3g}"), unit)
        seen = f"the largest value of {quantity}, {shown}, is {what}"
        remedy = _unit(place, axis, unit, meant)
        yield Doubt(observation.series, place, f"{axis}_unit", seen, remedy, not possible, meant and meant[0])


def _usual_strength(observation: Observation, info: SeriesInfo, part: float) -> bool:
    """Whether the largest shear stress is a usual part of the stress that is applied, once the soil is sheared."""
    sheared = "strain" in info.x_quantity and float(np.abs(observation.x).max()) >= _SHEARED
    return (part >= _STRENGTHS[0] or not sheared) and part <= _STRENGTHS[1]


def _ends_early(place: str, observation: Observation, info: SeriesInfo, spec: LaboratorySpec) -> Iterator[Doubt]:
    """Strains that end soon after the beginning of a test, and with it in another unit."""
    name = info.x_quantity.replace(" ", "_")
    if "strain" not in name:
        return
    end = max((abs(getattr(stage, name, None) or 0.0) for stage in getattr(spec, "shearing", ())), default=0.0)
    largest, unit = float(np.abs(observation.x).max()), observation.x_unit or info.x_unit
    if not 0.0 < largest < _SHORT * end:
        return
    meant = meant_unit(largest, info.x_unit, partial(_within, end, _WHOLE), given=unit)
    if meant is not None:
        shown = with_unit(float(f"{float(convert(largest, info.x_unit or '1', unit or '1')):.3g}"), unit)
        part = f"{largest / end:.1g} of that of the test, {end:g}"
        seen = f"{info.x_quantity} ends at {shown}, {part}; in {meant[0]} it fits"
        yield Doubt(observation.series, place, "x_unit", seen, _unit(place, "x", unit, meant), False)


def _begins_anew(place: str, observation: Observation, info: SeriesInfo) -> Iterator[Doubt]:
    """Strains that return to their beginning within one branch, as where two tests stand one below the other."""
    x = observation.x
    if "strain" not in info.x_quantity or "shear" in info.x_quantity or np.ptp(x) == 0.0:
        return
    back = (x[1:] <= x[0] + _ANEW * np.ptp(x)) & (np.maximum.accumulate(x)[:-1] > x[0] + 0.5 * np.ptp(x))
    places = np.flatnonzero(back) + 1
    first = int(places[0]) if places.size else 0
    if not _SOME <= first <= len(x) - _SOME:
        return
    unit = observation.x_unit or "1"
    before, now = (f"{value:.4g}" for value in convert(x[first - 1 : first + 1], info.x_unit or "1", unit))
    seen = f"{info.x_quantity} restarts at point {first + 1}, {with_unit(float(now), unit)} after {before}"
    remedy = (", as where two tests stand in one table; ", setting(f"{place}.where"), " or the cells choose one")
    yield Doubt(observation.series, place, "", seen, remedy, True)


def _no_modulus(place: str, observation: Observation, info: SeriesInfo) -> Iterator[Doubt]:
    """Secant moduli at strain 0, where there is none."""
    at = np.flatnonzero(observation.x == 0.0)
    if not info.y_quantity.endswith("modulus") or not at.size:
        return
    seen = f"{info.y_quantity} at {info.x_quantity} 0 (point {at[0] + 1}), where it would be no stress over no strain"
    remedy = ("; leave the reading out, as ", setting(f"{place}.x_from"), " above 0 does if it is the first")
    yield Doubt(observation.series, place, "", seen, remedy, True)


def _back_pressure(place: str, observation: Observation, section: str, back: float) -> Iterator[Doubt]:
    """Pore pressures that do not begin at the back pressure, where a reading stands at the beginning."""
    first = int(np.argmin(np.abs(observation.x)))
    begins, span = float(observation.y[first]), float(np.ptp(observation.y))
    away = abs(begins - back)
    if abs(observation.x[first]) > _AT_FIRST * np.abs(observation.x).max() or away < _OFFSET or away < 0.2 * span:
        return
    seen = f"the pore pressure begins at {begins:.4g} kPa, but the back pressure of the test is {back:g} kPa"
    remedy = ("; give ", setting(f"{section}.back_pressure", f"{begins:.0f}"), ", or the excess pore pressure")
    yield Doubt(observation.series, place, "", seen, remedy, away > 0.5 * span)


def _within(scale: float, usual: tuple[float, float], value: float) -> bool:
    return usual[0] <= value / scale <= usual[1]


def _largest_load(spec: LaboratorySpec) -> float | None:
    """Largest stress, kPa, that a test with shearing applies; None for tests that only move the specimen."""
    stages: tuple[BaseModel, ...] = (*getattr(spec, "consolidation", ()), *getattr(spec, "shearing", ()))
    if not stages:
        return None
    applied = [
        abs(value)
        for stage in stages
        for name, value in stage
        if isinstance(value, float) and (name in ("axial", "radial") or "stress" in name)
    ]
    return max([spec.initial_stress, *applied])
