"""The compression curve of a laboratory test: void ratio, or strain, at the ends of the stages over log stress."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.errors import SolverError
from geoswarm.solver.identifiability import Linearisation
from geoswarm.solver.parameter_estimates.observed_curves import LoadTest, load_tests, measured_strain
from geoswarm.solver.problem import Problem
from geoswarm.solver.report.laboratory import laboratory_values

__all__ = ["CompressionCurve", "compression_curves"]


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
    def axes(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Quantity and unit of x and of y."""
        stress = "vertical effective stress σ′v" if self.confined else "mean effective stress p′"
        x = ("vertical stress less back pressure" if self.total else stress, "kPa")
        if self.void_ratio:
            return x, ("void ratio e", "")
        return x, ("axial strain" if self.confined else "volumetric strain", "%")

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
    for test in load_tests(problem):
        own = found.get(test.part)
        ends = (None, None) if own is None else (own.value, own.interval)
        try:
            curves.append(_curve(problem, test, values, *ends))
        except SolverError:
            continue
    return tuple(curves)


def _curve(
    problem: Problem,
    test: LoadTest,
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


def _strain_before(test: LoadTest, values: Mapping[str, float], strain: FloatArray) -> float:
    """Calculated strain from the beginning of the test to the zero of its readings."""
    whole = type(test.model)(test.model.spec.model_copy(update={"zero_at_stage": 1}))
    series = "stage_axial_strain" if test.confined else "stage_volumetric_strain"
    first = whole.prepare({series: np.array([1.0])})(test.values(values))[series]
    return float(first[0] - strain[0])
