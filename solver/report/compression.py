"""The compression curve of a laboratory test: void ratio, or strain, at the ends of the stages over log stress."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.errors import SolverError
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec
from geoswarm.solver.forward.combined import CombinedModel
from geoswarm.solver.identifiability import Linearisation
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.stages import stage_of, stage_times
from geoswarm.solver.report.laboratory import StagedTest, laboratory_values

__all__ = ["CompressionCurve", "compression_curves", "measured_strain"]

_LATE = 0.5
"""A reading stands for the end of a stage when it was made in the last half of it."""

_Ends: TypeAlias = dict[str, dict[int, float]]
"""Readings at the ends of stages, by number, of each series."""


@dataclass(frozen=True, slots=True)
class _LoadTest:
    """A test in stages: name of its part, forward model, and parameters of the part."""

    part: str
    model: Any
    values: Callable[[Mapping[str, float]], Mapping[str, float]]

    @property
    def confined(self) -> bool:
        """Whether a ring holds the side."""
        return any(info.name == "stage_axial_strain" for info in self.model.series)


@dataclass(frozen=True, slots=True)
class CompressionCurve:
    """Measured and calculated state at the ends of the stages of one test.

    Parameters
    ----------
    part
        Name of the test in a combined model; empty otherwise.
    confined, total
        Whether the stress is the vertical one of an oedometer, not an all-round one; whether it is the total one less
        the back pressure, as where pore water flows.
    void_ratio
        Whether y is a void ratio; otherwise engineering strain in percent, of the height (oedometer) or the volume.
    stages
        Number of each calculated point, shape (n,); 0 stands for the initial state.
    stress, calculated
        Shape (n,), kPa and y.
    measured_stages, measured
        Stages that were read, shape (m,), and y, shape (m,).
    gross_stages, gross
        Stages whose last reading is marked as a gross error, shape (q,), and y, shape (q,).
    preconsolidation, interval
        Preconsolidation stress and its 95 % interval, kPa; None for laws that have none of this kind.
    """

    part: str
    confined: bool
    void_ratio: bool
    stages: IntArray
    stress: FloatArray
    calculated: FloatArray
    measured_stages: IntArray
    measured: FloatArray
    preconsolidation: float | None
    interval: tuple[float, float] | None
    total: bool = False
    gross_stages: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    gross: FloatArray = field(default_factory=lambda: np.empty(0))

    @property
    def measured_stress(self) -> FloatArray:
        """Stress of the measured points, shape (m,), kPa."""
        return self.stress[np.searchsorted(self.stages, self.measured_stages)]

    @property
    def gross_stress(self) -> FloatArray:
        """Stress of the gross errors, shape (q,), kPa."""
        return self.stress[np.searchsorted(self.stages, self.gross_stages)]


def compression_curves(
    problem: Problem, values: Mapping[str, float], linearisation: Linearisation | None
) -> tuple[CompressionCurve, ...]:
    """Return the compression curve of every laboratory test; none of one that cannot be calculated."""
    found = {v.part: v for v in laboratory_values(problem, values, linearisation) if v.symbol == "σ′p"}
    curves = []
    for test in _load_tests(problem):
        own = found.get(test.part)
        ends = (None, None) if own is None else (own.value, own.interval)
        try:
            curves.append(_curve(problem, test, values, *ends))
        except SolverError:
            continue
    return tuple(curves)


def _curve(
    problem: Problem,
    test: _LoadTest,
    values: Mapping[str, float],
    preconsolidation: float | None,
    interval: tuple[float, float] | None,
) -> CompressionCurve:
    spec = test.model.spec
    e = spec.initial_void_ratio
    strain_series = "stage_axial_strain" if test.confined else "stage_volumetric_strain"
    numbers = np.arange(1.0, len(spec.stages) + 1.0)
    strain = test.model.prepare({strain_series: numbers})(test.values(values))[strain_series]
    at_zero = 0.0 if spec.zero_at_stage == 1 else _strain_before(test, values, strain)
    read, measured = measured_strain(problem, test)
    struck, gross = measured_strain(problem, test, gross=True)

    def shown(since_zero: FloatArray) -> FloatArray:
        return 100.0 * since_zero if e is None else e - (1.0 + e) * (at_zero + since_zero)

    return CompressionCurve(
        test.part,
        test.confined,
        e is not None,
        np.arange(len(numbers) + 1),
        np.array([spec.initial_stress, *(stage.stress for stage in spec.stages)]),
        shown(np.concatenate([[0.0 - at_zero], strain])),
        read,
        shown(measured),
        preconsolidation,
        interval,
        spec.consolidates,
        struck,
        shown(gross),
    )


def _load_tests(problem: Problem) -> Iterator[_LoadTest]:
    """The tests of a problem with loads in stages, and strains at their ends, of any law."""
    spec, model = problem.forward_model, problem.model
    if spec.runs_outside:
        return
    if not isinstance(model, CombinedModel):
        if _is_load_test(spec, model):
            yield _LoadTest("", model, dict)
        return
    for name in model.part_names:
        if _is_load_test(spec.parts[name], model.part(name)):  # type: ignore[attr-defined]  # of a combined model
            yield _LoadTest(name, model.part(name), partial(model.part_values, name))


def _is_load_test(spec: ForwardModelSpec, model: ForwardModel) -> bool:
    stages: Any = getattr(spec, "stages", ())
    names = {info.name for info in model.series}
    whole = bool(stages) and hasattr(stages[0], "stress") and hasattr(spec, "initial_stress")
    return whole and bool(names & {"stage_axial_strain", "stage_volumetric_strain"})


def _strain_before(test: _LoadTest, values: Mapping[str, float], strain: FloatArray) -> float:
    """Calculated strain from the beginning of the test to the zero of its readings."""
    whole = type(test.model)(test.model.spec.model_copy(update={"zero_at_stage": 1}))
    series = "stage_axial_strain" if test.confined else "stage_volumetric_strain"
    first = whole.prepare({series: np.array([1.0])})(test.values(values))[series]
    return float(first[0] - strain[0])


def measured_strain(
    problem: Problem, test: StagedTest | _LoadTest, *, gross: bool = False
) -> tuple[IntArray, FloatArray]:
    """Stages that were read, from 1, and the strain since the zero of the readings; or those of gross errors alone."""
    prefix = f"{test.part}." if test.part else ""
    read: _Ends = {}
    struck: _Ends = {}
    for o in problem.observations:
        if o.series.startswith(prefix):
            name = o.series.removeprefix(prefix)
            read[name] = _ends(problem, test, o.series, o.x, o.y)
            struck[name] = _ends(problem, test, o.series, o.gross_x, o.gross_y)
    if not gross:
        return _sorted(_strains(test, read)[1])
    used, strains = _strains(test, {name: read[name] | struck[name] for name in read})
    return _sorted({stage: strain for stage, strain in strains.items() if any(stage in struck[name] for name in used)})


def _strains(test: StagedTest | _LoadTest, ends: _Ends) -> tuple[tuple[str, ...], dict[int, float]]:
    """Series that give the strain at the ends of stages, and the strains by stage."""
    spec = test.model.spec
    for name in ("axial_strain", "settlement") if test.confined else ("volumetric_strain",):
        for series in (f"stage_{name}", name):
            if ends.get(series):
                scale = spec.height if name == "settlement" else 1.0
                return (series,), {stage: y / scale for stage, y in ends[series].items()}
    e = spec.initial_void_ratio
    if ends.get("stage_void_ratio") and e is not None and spec.zero_at_stage == 1:
        return ("stage_void_ratio",), {stage: (e - y) / (1.0 + e) for stage, y in ends["stage_void_ratio"].items()}
    for form in ("stage_", ""):
        names = (f"{form}axial_displacement", f"{form}radial_displacement")
        axial, radial = (ends.get(name, {}) for name in names)
        both = {
            stage: 1.0 - (1.0 - axial[stage] / spec.height) * (1.0 - radial[stage] / spec.radius) ** 2
            for stage in axial
            if stage in radial
        }
        if both:
            return names, both
    return (), {}


def _sorted(ends: Mapping[int, float]) -> tuple[IntArray, FloatArray]:
    stages = sorted(ends)
    return np.array(stages, dtype=np.int64), np.array([ends[stage] for stage in stages], dtype=np.float64)


def _ends(
    problem: Problem, test: StagedTest | _LoadTest, series: str, x: FloatArray, y: FloatArray
) -> dict[int, float]:
    """Reading at the end of each stage, by its number."""
    starts = stage_times(problem.forward_model, series)
    if starts.size == 0:
        return dict(zip(np.round(x).astype(int).tolist(), y.tolist(), strict=True))
    durations = np.array([stage.duration for stage in test.model.spec.stages])
    stages = stage_of(x, starts)
    late = x - starts[stages - 1] >= _LATE * durations[stages - 1]
    return {int(stage): float(value) for stage, value in zip(stages[late], y[late], strict=True)}
