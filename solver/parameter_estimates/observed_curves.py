"""Readings of laboratory tests, of any law: curves of a test, and strain at the ends of its stages."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec
from geoswarm.solver.forward.combined import parts_of
from geoswarm.solver.problem import Observation, Problem
from geoswarm.solver.problem.stages import stage_of, stage_times

__all__ = ["LoadTest", "first_of", "load_tests", "measured_strain", "observed", "rising"]

_LATE = 0.5
"""A reading stands for the end of a stage when it was made in the last half of it."""

_Ends: TypeAlias = dict[str, dict[int, float]]
"""Readings at the ends of stages, by number, of each series."""


@dataclass(frozen=True, slots=True)
class LoadTest:
    """A test in stages: name of its part, forward model, and parameters of the part."""

    part: str
    model: Any
    values: Callable[[Mapping[str, float]], Mapping[str, float]]

    @property
    def confined(self) -> bool:
        """Whether a ring holds the side."""
        return any(info.name == "stage_axial_strain" for info in self.model.series)


def observed(problem: Problem, part: str) -> dict[str, Observation]:
    """Observations of one test, by the names that its series have in the test."""
    start = f"{part}." if part else ""
    return {o.series.removeprefix(start): o for o in problem.observations if o.series.startswith(start)}


def first_of(series: Mapping[str, Observation], name: str) -> Observation | None:
    """A series of the whole test, else that of its first stage."""
    return series.get(name) or series.get(f"branch_1.{name}")


def rising(one: Observation) -> tuple[FloatArray, FloatArray]:
    """Readings of a curve in the order of x."""
    order = np.argsort(one.x, kind="stable")
    return one.x[order], one.y[order]


def load_tests(problem: Problem) -> Iterator[LoadTest]:
    """The tests of a problem with loads in stages, and strains at their ends, of any law."""
    if problem.forward_model.runs_outside:
        return
    for part in parts_of(problem.forward_model, problem.model):
        if _is_load_test(part.spec, part.model):
            yield LoadTest(part.name, part.model, part.values)


def _is_load_test(spec: ForwardModelSpec, model: ForwardModel) -> bool:
    stages: Any = getattr(spec, "stages", ())
    names = {info.name for info in model.series}
    whole = bool(stages) and hasattr(stages[0], "stress") and hasattr(spec, "initial_stress")
    return whole and bool(names & {"stage_axial_strain", "stage_volumetric_strain"})


def measured_strain(problem: Problem, test: LoadTest, *, gross: bool = False) -> tuple[IntArray, FloatArray]:
    """Stages that were read, from 1, and the strain since the zero of the readings; or those of gross errors alone."""
    series = observed(problem, test.part)
    read = {name: _ends(problem, test, o.series, o.x, o.y) for name, o in series.items()}
    struck = {name: _ends(problem, test, o.series, o.gross_x, o.gross_y) for name, o in series.items()}
    if not gross:
        return _sorted(_strains(test, read)[1])
    used, strains = _strains(test, {name: read[name] | struck[name] for name in read})
    return _sorted({stage: strain for stage, strain in strains.items() if any(stage in struck[name] for name in used)})


def _strains(test: LoadTest, ends: _Ends) -> tuple[tuple[str, ...], dict[int, float]]:
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


def _ends(problem: Problem, test: LoadTest, series: str, x: FloatArray, y: FloatArray) -> dict[int, float]:
    """Reading at the end of each stage, by its number."""
    starts = stage_times(problem.forward_model, series)
    if starts.size == 0:
        return dict(zip(np.round(x).astype(int).tolist(), y.tolist(), strict=True))
    durations = np.array([stage.duration for stage in test.model.spec.stages])
    stages = stage_of(x, starts)
    late = x - starts[stages - 1] >= _LATE * durations[stages - 1]
    return {int(stage): float(value) for stage, value in zip(stages[late], y[late], strict=True)}
