"""Cc, Cs and preconsolidation stress of tests with loads in stages, from the readings at the ends of the stages."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.forward.combined import ModelPart
from geoswarm.solver.laboratory.shear.simple_shear import DirectSimpleShearSpec
from geoswarm.solver.parameter_estimates.compression_curve import (
    LogLog,
    casagrande,
    compression_index,
    first_loading,
    log_log,
    swelling_index,
    virgin_line,
)
from geoswarm.solver.parameter_estimates.observed_curves import LoadTest, measured_strain, observed, rising
from geoswarm.solver.parameter_estimates.values import (
    ClassicalValue,
    Construction,
    DrawnLine,
    DrawnPoint,
    NoEvaluationError,
)
from geoswarm.solver.problem import Problem

__all__ = [
    "CompressionReadings",
    "compression_constructions",
    "compression_readings",
    "compression_values",
    "consolidation_readings",
    "height_of",
]

_CASAGRANDE = (
    "Casagrande (1936): at the largest curvature of a spline through first loading the bisector of tangent and "
    "horizontal is drawn; it meets the virgin line at σ′p. One void ratio is as long as one decade of stress."
)
_LOG_LOG = (
    "Two lines in ln(1 + e) over log σ′ meet at σ′p (Butterfield 1979; Onitsuka et al. 1995); they are parted where "
    "both together have the least squares."
)

_BENDS = "the curve of sand bends without any preconsolidation"


@dataclass(frozen=True, slots=True)
class CompressionReadings:
    """Stress, kPa, and void ratio, or minus the strain where ``void_ratio`` is None, at the ends of stages, shape (n,).

    ``confined``: the stress is the vertical one of an oedometer, else an all-round one. ``sand``: its curve bends by
    itself, so that a bend says nothing of the past.
    """

    part: str
    confined: bool
    void_ratio: float | None
    stress: FloatArray
    y: FloatArray
    sand: bool = False


def _is_sand(problem: Problem, spec: Any) -> bool:
    """Whether the law is one of sand, or index tests of sand are known."""
    index = problem.index_properties
    tests = ("min_void_ratio", "max_void_ratio", "relative_density")
    by_index = any(getattr(index, name, None) is not None for name in tests)
    return by_index or getattr(spec, "material", None) == "hypoplastic_sand"


def height_of(strain: FloatArray, void_ratio: float | None) -> FloatArray:
    """Void ratio under a strain, from that before the test; minus the strain where that is not known."""
    return -strain if void_ratio is None else void_ratio - (1.0 + void_ratio) * strain


def compression_readings(problem: Problem, test: LoadTest) -> CompressionReadings | None:
    """The compression curve that was measured; None where the strain does not count from the first stage."""
    spec = test.model.spec
    if getattr(spec, "zero_at_stage", 1) != 1:
        return None
    loads = np.array([stage.stress for stage in spec.stages])
    e, sand = spec.initial_void_ratio, _is_sand(problem, spec)
    stages, strain = measured_strain(problem, test)
    if stages.size:
        return CompressionReadings(test.part, test.confined, e, loads[stages - 1], height_of(strain, e), sand)
    voids = observed(problem, test.part).get("stage_void_ratio")  # a law may know the one before the test otherwise
    if voids is None or voids.x.size == 0:
        return None
    x, y = rising(voids)
    return CompressionReadings(test.part, test.confined, float(y[0]), loads[np.round(x).astype(int) - 1], y, sand)


def consolidation_readings(problem: Problem, part: ModelPart) -> CompressionReadings | None:
    """The compression curve of the stages of consolidation of a shear test, where they were read.

    That of a triaxial test is all-round, so that all its stages have to be.
    """
    spec: Any = part.spec
    stages = spec.consolidation
    confined = isinstance(spec, DirectSimpleShearSpec)
    name = "consolidation_vertical_strain" if confined else "consolidation_volumetric_strain"
    one = observed(problem, part.name).get(name)
    if one is None or not (confined or all(stage.radial in (None, stage.axial) for stage in stages)):
        return None
    loads = np.array([stage.normal_stress if confined else stage.axial for stage in stages])
    x, strain = rising(one)
    e = spec.initial_void_ratio
    stress, y = loads[np.round(x).astype(int) - 1], height_of(strain, e)
    return CompressionReadings(part.name, confined, e, stress, y, _is_sand(problem, spec))


def compression_values(read: CompressionReadings) -> Iterator[ClassicalValue]:
    """Indices and preconsolidation stress."""
    under = "/(1 + e₀)" if read.void_ratio is None else ""
    methods: list[tuple[str, str, str, Callable[[FloatArray, FloatArray], float]]] = [
        (f"Cc{under}", "", "steepest part", compression_index),
        (f"Cs{under}", "", "unloading", swelling_index),
    ]
    if not read.sand:
        methods.append(("σ′p", "kPa", "Casagrande", lambda s, y: casagrande(s, y).stress))
    if not read.sand and read.void_ratio is not None:
        methods.append(("σ′p", "kPa", "log-log", lambda s, y: _log_log_lines(s, y).stress))
    for symbol, unit, method, evaluate in methods:
        try:
            yield ClassicalValue(read.part, symbol, method, float(evaluate(read.stress, read.y)), unit=unit)
        except NoEvaluationError as error:
            yield ClassicalValue(read.part, symbol, method, None, str(error), unit)
    if read.sand:
        yield ClassicalValue(read.part, "σ′p", "Casagrande", None, _BENDS, "kPa")


def _log_log_lines(stress: FloatArray, y: FloatArray) -> LogLog:
    """The two lines, where the void ratio itself bends as well: ln(1 + e) of a straight virgin line does, too."""
    virgin_line(stress, y)
    return log_log(stress, y)


def compression_constructions(read: CompressionReadings) -> Iterator[Construction]:
    """Casagrande's construction, and the two lines of the log-log one, where the readings allow them."""
    if read.sand:
        return
    stress = "vertical effective stress" if read.confined else "all-round effective stress"
    quantity = "-strain" if read.void_ratio is None else "void ratio"
    with contextlib.suppress(NoEvaluationError):
        yield _casagrande(read, stress, quantity)
    if read.void_ratio is None:
        return
    with contextlib.suppress(NoEvaluationError):
        yield _log_log(read, stress)


def _casagrande(read: CompressionReadings, stress: str, quantity: str) -> Construction:
    found = casagrande(read.stress, read.y)
    x, _ = first_loading(read.stress, read.y)
    line, past = virgin_line(read.stress, read.y), np.log10(found.stress)
    at = np.array([found.place, x[-1]])
    meets = max(past - 0.15, x[0])
    lines = (
        DrawnLine(
            "virgin line", 10.0 ** np.array([meets, x[-1]]), line.start - line.index * np.array([meets, x[-1]]), "main"
        ),
        DrawnLine("horizontal", 10.0**at, np.full(2, found.void_ratio)),
        DrawnLine("tangent", 10.0**at, found.void_ratio + found.tangent * (at - found.place)),
        DrawnLine("bisector", 10.0**at, found.void_ratio + found.bisector * (at - found.place)),
    )
    lowest = float(read.y.min())
    cut = []
    for one in lines:  # what runs far below the readings says nothing
        inside = one.y >= lowest - 0.05 * float(np.ptp(read.y))
        if inside.all():
            cut.append(one)
            continue
        share = (one.y[0] - lowest) / (one.y[0] - one.y[1])
        end = 10.0 ** (np.log10(one.x[0]) + share * (np.log10(one.x[1]) - np.log10(one.x[0])))
        cut.append(DrawnLine(one.label, np.array([one.x[0], end]), np.array([one.y[0], lowest]), one.role))
    marks = (
        DrawnPoint("largest curvature", 10.0**found.place, found.void_ratio),
        DrawnPoint(f"σ′p = {found.stress:.3g} kPa", found.stress, float(line.start - line.index * past)),
    )
    return Construction(
        "casagrande",
        read.part,
        "Preconsolidation stress after Casagrande",
        _CASAGRANDE,
        stress,
        "kPa",
        quantity,
        "",
        read.stress,
        read.y,
        tuple(cut),
        marks,
        log=True,
        joined=True,
    )


def _log_log(read: CompressionReadings, stress: str) -> Construction:
    found = _log_log_lines(read.stress, read.y)
    x, _ = first_loading(read.stress, read.y)
    past = np.log10(found.stress)
    reach = 0.1 * (x[-1] - x[0])
    before, after = np.array([x[0], past + reach]), np.array([past - reach, x[-1]])
    lines = (
        DrawnLine("reloading", 10.0**before, found.before[1] + found.before[0] * before, "main"),
        DrawnLine("virgin line", 10.0**after, found.after[1] + found.after[0] * after, "main"),
    )
    mark = DrawnPoint(f"σ′p = {found.stress:.3g} kPa", found.stress, float(found.before[1] + found.before[0] * past))
    return Construction(
        "log_log",
        read.part,
        "Preconsolidation stress by two lines",
        _LOG_LOG,
        stress,
        "kPa",
        "ln(1 + e)",
        "",
        read.stress,
        np.log1p(read.y),
        lines,
        (mark,),
        log=True,
        joined=True,
    )
