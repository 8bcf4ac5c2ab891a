"""Observations of laboratory tests with loads in stages, wherever in a problem they stand."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.forward.staged_section import StagedLoadSpec
from geoswarm.solver.problem import Observation, Problem
from geoswarm.solver.problem.stages import section_of_test, stage_of, stage_times
from geoswarm.solver.sentences import Key
from geoswarm.solver.units import convert

__all__ = ["StagedReadings", "staged_readings"]


_DEFORMATIONS = frozenset(
    {
        *("settlement", "axial_strain", "axial_displacement", "radial_displacement", "volumetric_strain"),
        "void_ratio",
    }
)
"""Series that show how a specimen is compressed; stresses and state variables are judged by nothing here."""


@runtime_checkable
class StagedTest(Protocol):
    """Section of a test on a specimen with loads in stages, by its fields: its module may load the kernels."""

    @property
    def height(self) -> float:
        """Height of the specimen, m."""

    @property
    def initial_stress(self) -> float:
        """Stress before the first stage, kPa."""

    @property
    def stages(self) -> Sequence[Any]:
        """Each with ``stress``, kPa, and ``duration``, day."""

    @property
    def zero_at_stage(self) -> int:
        """Stage just before which deformation is zero."""


@dataclass(frozen=True, slots=True)
class StagedReadings:
    """All readings of one series of such a test, those that take no part, too.

    Parameters
    ----------
    path, section
        Where the observation and the test stand in the problem.
    spec
        The test.
    quantity
        Series without the name of a part and without ``stage_``.
    by_stage
        Whether x is the stage number and not time.
    x, y
        Readings in the order of x, each of shape (m,), base units.
    stages
        Number of the stage of each reading, from 1, shape (m,).
    x_unit, y_unit, y_base
        Units of the data, and the base unit of y.
    observation
        The observation itself.
    """

    path: str
    section: str
    spec: StagedTest
    quantity: str
    by_stage: bool
    x: FloatArray
    y: FloatArray
    stages: FloatArray
    x_unit: str
    y_unit: str
    y_base: str
    observation: Observation

    @property
    def drains_at_once(self) -> bool:
        """Whether a load compresses the specimen when it acts, and not while pore water flows."""
        return isinstance(self.spec, StagedLoadSpec)

    @property
    def title(self) -> Key:
        """How a sentence begins."""
        return Key(self.path, f"{self.path} ({self.observation.series})", self.observation.series)

    def key(self, name: str, *, short: bool = False) -> Key:
        """A key of the test."""
        path = f"{self.section}.{name}"
        return Key(path, name if short else path)

    @property
    def stresses(self) -> FloatArray:
        """Stress before the first stage and of every stage, shape (n + 1,), kPa."""
        return np.array([self.spec.initial_stress, *(stage.stress for stage in self.spec.stages)])

    def in_data(self, y: float) -> str:
        """A value as the data show it."""
        shown = float(convert(y, self.y_base, self.y_unit))
        return f"{shown:.3g}{'' if self.y_unit in ('', '1', 'dimensionless') else f' {self.y_unit}'}"


def staged_readings(problem: Problem) -> Iterator[StagedReadings]:
    """Every observation of the deformation of a test in stages."""
    infos = {info.name: info for info in problem.model.series}
    for index, one in enumerate(problem.observations):
        section, spec, series = section_of_test(problem.forward_model, one.series)
        if not isinstance(spec, StagedTest) or series.removeprefix("stage_") not in _DEFORMATIONS:
            continue
        info = infos[one.series]
        x_unit, y_unit = one.x_unit or info.x_unit, one.y_unit or info.y_unit
        x, y = convert(one.points.x, x_unit, info.x_unit), convert(one.points.y, y_unit, info.y_unit)
        order = np.argsort(x, kind="stable")
        x, y = x[order], y[order]
        stages = np.round(x) if info.x_integer else stage_of(x, stage_times(problem.forward_model, one.series))
        yield StagedReadings(
            f"observations[{index}]",
            section,
            spec,
            series.removeprefix("stage_"),
            info.x_integer,
            x,
            y,
            np.asarray(stages, dtype=np.float64),
            x_unit,
            y_unit,
            info.y_unit,
            one,
        )
