"""c_v, k and C_alpha of single stages of an oedometer test, from the settlement within each stage."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.parameter_estimates.consolidation_curve import Consolidation, log_time, root_time
from geoswarm.solver.parameter_estimates.observed_curves import LoadTest, observed
from geoswarm.solver.parameter_estimates.values import (
    ClassicalValue,
    Construction,
    DrawnLine,
    DrawnPoint,
    NoEvaluationError,
)
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.stages import stage_of, stage_times
from geoswarm.solver.units import WATER

__all__ = ["StageReadings", "stage_constructions", "stage_readings", "stage_values"]

_MINUTES = 1440.0
_ROOT = (
    "Taylor (1942): the line through the first part is drawn again with abscissas 1.155 times as large; it meets the "
    "curve at 90 % of consolidation, c_v = 0.848 H²/t90."
)
_LOG = (
    "Casagrande & Fadum (1940): the beginning by the parabola of the first part, the end of primary consolidation "
    "where the steepest tangent meets the line through the last half decade, whose slope is Cα; "
    "c_v = 0.197 H²/t50 half way."
)


@dataclass(frozen=True, slots=True)
class StageReadings:
    """Readings within one stage.

    Parameters
    ----------
    part, stage
        Name of the test, and number of the stage from 1.
    stress
        Load of the stage, kPa.
    virgin
        Whether it is larger than all before.
    step
        Change of the load, kPa, without sign.
    time, strain
        Time since the load, day, and strain of the initial height (settlement downwards), shape (n,); where the load
        falls, minus the strain.
    path
        Drainage path in the middle of the stage, m.
    drained
        Drained ends, in words.
    void_ratio
        Before the test, where it is known.
    """

    part: str
    stage: int
    stress: float
    virgin: bool
    step: float
    time: FloatArray
    strain: FloatArray
    path: float
    drained: str
    void_ratio: float | None


def stage_readings(problem: Problem, test: LoadTest) -> Iterator[StageReadings]:
    """Readings of all stages of an oedometer test that were read over time.

    The drainage path is half the height of the stage's middle, or all of it where the section says that one end is
    closed; a section without flow of water says nothing, and laboratories drain both ends.
    """
    spec = test.model.spec
    if not test.confined:
        return
    one_side = getattr(spec, "drainage", "two_sides") == "one_side"
    drained = "drained at one end" if one_side else "drained at both ends"
    stresses = np.array([spec.initial_stress, *(stage.stress for stage in spec.stages)])
    for number, time, strain, total in _curves(problem, test):
        before, load = stresses[number - 1], stresses[number]
        height = spec.height * (1.0 - (0.5 * float(strain[0] + strain[-1]) if total else 0.0))
        sign = 1.0 if load >= before else -1.0
        yield StageReadings(
            test.part,
            number,
            float(load),
            bool(load > stresses[:number].max()),
            float(abs(load - before)),
            time,
            sign * strain,
            height if one_side else 0.5 * height,
            drained,
            spec.initial_void_ratio,
        )


def _curves(problem: Problem, test: LoadTest) -> Iterator[tuple[int, FloatArray, FloatArray, bool]]:
    """Stage, time since its load, strain, and whether that counts from the beginning of the test."""
    spec = test.model.spec
    series = observed(problem, test.part)
    found: dict[int, tuple[FloatArray, FloatArray, bool]] = {}
    for name, scale in (("settlement", 1.0 / spec.height), ("axial_strain", 1.0)):
        one = series.get(name)
        if one is not None:
            starts = stage_times(problem.forward_model, one.series)
            belongs = stage_of(one.x, starts)
            for number in sorted(set(belongs.tolist())):
                mine = (belongs == number) & (one.x > starts[number - 1])
                whole = getattr(spec, "zero_at_stage", 1) == 1
                found.setdefault(number, (one.x[mine] - starts[number - 1], one.y[mine] * scale, whole))
        for number in range(1, len(spec.stages) + 1):
            branch = series.get(f"branch_{number}.{name}")
            if branch is not None:
                found.setdefault(number, (branch.x, branch.y * scale, False))
    for number, (time, strain, total) in sorted(found.items()):
        if time.size:
            order = np.argsort(time, kind="stable")
            yield number, time[order], strain[order], total


def stage_values(read: StageReadings) -> Iterator[ClassicalValue]:
    """c_v and k by both methods, and C_alpha of a virgin load."""
    values: dict[str, Consolidation | str] = {}
    for method, evaluate in (("root time", root_time), ("log time", log_time)):
        try:
            values[method] = evaluate(read.time, read.strain, read.path)
        except NoEvaluationError as error:
            values[method] = str(error)
    for method, found in values.items():
        c_v, why = (None, found) if isinstance(found, str) else (found.c_v, "")
        yield ClassicalValue(read.part, "c_v", f"{method}, {read.drained}", c_v, why, "m²/day", read.stage, read.virgin)
        if not isinstance(found, str) and read.step > 0.0:
            k = found.c_v * WATER * (found.end - found.start) / read.step
            yield ClassicalValue(read.part, "k", f"{method}, c_v m_v γ_w", k, "", "m/day", read.stage, read.virgin)
    if not read.virgin:
        return
    told, e = values["log time"], read.void_ratio
    symbol = "Cα" if e is not None else "Cα/(1 + e₀)"
    if isinstance(told, str):
        yield ClassicalValue(read.part, symbol, "log time", None, told, "", read.stage)
    elif not told.secondary or told.secondary < 0.0:
        why = "the settlement does not grow at the end"
        yield ClassicalValue(read.part, symbol, "log time", None, why, "", read.stage)
    else:
        value = told.secondary * (1.0 if e is None else 1.0 + e)
        yield ClassicalValue(read.part, symbol, "log time", value, "", "", read.stage)


def stage_constructions(read: StageReadings) -> Iterator[Construction]:
    """Root time and log time, where the readings allow them; strain in per cent, time in minutes."""
    minutes, y = read.time * _MINUTES, 100.0 * read.strain
    at = f"stage {read.stage}, {read.stress:g} kPa"
    try:
        found = root_time(read.time, read.strain, read.path)
    except NoEvaluationError:
        pass
    else:
        yield _root(read, found, np.sqrt(minutes), y, at)
    try:
        found = log_time(read.time, read.strain, read.path)
    except NoEvaluationError:
        return
    inside = minutes > 0.0
    yield _log(read, found, minutes[inside], y[inside], at)


def _told(symbol: str, found: Consolidation) -> str:
    return f"{symbol} = {found.time * _MINUTES:.3g} min,\nc_v = {found.c_v:.3g} m²/day"


def _root(read: StageReadings, found: Consolidation, x: FloatArray, y: FloatArray, at: str) -> Construction:
    root_day = math.sqrt(_MINUTES)
    t_90 = math.sqrt(found.time) * root_day
    lines: list[DrawnLine] = []
    for label, (slope, start) in zip(("first part", "abscissas × 1.155"), found.lines, strict=True):
        reach = min(1.15 * t_90, 1.1 * (found.end - start) / slope * root_day)
        ends = np.array([0.0, reach])
        lines.append(
            DrawnLine(label, ends, 100.0 * (start + slope * ends / root_day), "main" if not lines else "helper")
        )
    d_90 = found.start + 0.9 * (found.end - found.start)
    marks = (
        DrawnPoint("d₀", 0.0, 100.0 * found.start),
        DrawnPoint(_told("t₉₀", found), t_90, 100.0 * d_90),
    )
    shown = x <= 4.0 * t_90
    return Construction(
        f"root_time_{read.stage}",
        read.part,
        f"Root of time, {at}",
        _ROOT,
        "root of time",
        "√min",
        "strain",
        "%",
        x[shown],
        y[shown],
        tuple(lines),
        marks,
        downwards=True,
        first_loading=read.virgin,
    )


def _log(read: StageReadings, found: Consolidation, x: FloatArray, y: FloatArray, at: str) -> Construction:
    (steep, tangent), (flat, tail) = found.lines
    meet = (tail - tangent) / (steep - flat)
    first = max((found.start - tangent) / steep, math.log10(x[0] / _MINUTES))
    last = math.log10(x[-1] / _MINUTES)
    spans = (np.array([first, meet + 0.1]), np.array([meet - 0.4, last]))
    lines = (
        DrawnLine("steepest tangent", 10.0 ** spans[0] * _MINUTES, 100.0 * (tangent + steep * spans[0]), "main"),
        DrawnLine("secondary compression", 10.0 ** spans[1] * _MINUTES, 100.0 * (tail + flat * spans[1]), "main"),
        DrawnLine("d₀ by the parabola", x[[0, -1]], np.full(2, 100.0 * found.start)),
        DrawnLine("d₁₀₀", x[[0, -1]], np.full(2, 100.0 * found.end)),
    )
    mark = DrawnPoint(_told("t₅₀", found), found.time * _MINUTES, 50.0 * (found.start + found.end))
    return Construction(
        f"log_time_{read.stage}",
        read.part,
        f"Logarithm of time, {at}",
        _LOG,
        "time",
        "min",
        "strain",
        "%",
        x,
        y,
        lines,
        (mark,),
        log=True,
        downwards=True,
        first_loading=read.virgin,
    )
