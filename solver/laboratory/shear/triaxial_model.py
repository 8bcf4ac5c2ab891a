"""The triaxial test at a material point: how it is led, and its series.

Components are those of an axisymmetric body: xx and zz radial, yy axial (vertical, as in finite elements).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.element_test.load_paths import LoadPath
from geoswarm.solver.element_test.specimen import (
    combination,
    engineering_strain,
    inner_strain,
    same_strain,
)
from geoswarm.solver.laboratory.model import ShearModel
from geoswarm.solver.laboratory.quantities import (
    MEAN_PRESSURE,
    Quantity,
    Seen,
    pore_pressure,
    state_variables,
    void_ratio,
)
from geoswarm.solver.laboratory.record import Voids
from geoswarm.solver.laboratory.series import TestSeries
from geoswarm.solver.laboratory.shear_axes import path_series, shear_series
from geoswarm.solver.laboratory.shear_stages import Axes, ShearStage

if TYPE_CHECKING:
    from geoswarm.solver.laboratory.shear.triaxial import TriaxialSpec

__all__ = ["TriaxialModel"]

_Q = Quantity("q", "Deviator stress, axial less radial", "q", "kPa", lambda seen: seen.axial - seen.radial)


def _secant(seen: Seen) -> np.ndarray:
    first = seen.reference
    q = seen.axial - seen.radial - (first[1] - 0.5 * (first[0] + first[2]))
    return np.asarray(q / seen.engineering(seen.strain[:, 1]))


def _sheared(seen: Seen) -> np.ndarray:
    strain = seen.engineering(seen.strain[:, 1]) - seen.engineering(0.5 * (seen.strain[:, 0] + seen.strain[:, 2]))
    return np.asarray(strain)


def _shear_modulus(seen: Seen) -> np.ndarray:
    first = seen.reference
    q = seen.axial - seen.radial - (first[1] - 0.5 * (first[0] + first[2]))
    return np.asarray(0.5 * q / _sheared(seen))


_STRAINS = (
    Quantity("axial_strain", "Axial strain", "axial strain", "", lambda seen: seen.engineering(seen.strain[:, 1])),
    Quantity(
        "radial_strain",
        "Radial strain",
        "radial strain",
        "",
        lambda seen: seen.engineering(0.5 * (seen.strain[:, 0] + seen.strain[:, 2])),
    ),
    Quantity(
        "volumetric_strain",
        "Volumetric strain",
        "volumetric strain",
        "",
        lambda seen: seen.engineering(seen.strain[:, :3].sum(axis=1)),
    ),
)
_STRESSES = (
    _Q,
    MEAN_PRESSURE,
    Quantity("axial_stress", "Axial effective stress", "axial stress", "kPa", lambda seen: seen.axial),
    Quantity("radial_stress", "Radial effective stress", "radial stress", "kPa", lambda seen: seen.radial),
    Quantity(
        "stress_ratio",
        "Stress ratio q/p'",
        "q/p'",
        "",
        lambda seen: (seen.axial - seen.radial) / seen.stress[:, :3].mean(axis=1),
    ),
)
_PORE_PRESSURE = pore_pressure("Pore pressure")
_K0 = Quantity("K0", "Ratio of radial to axial effective stress", "K0", "", lambda seen: seen.radial / seen.axial)
_SHEARED = Quantity("shear_strain", "Shear strain: axial less radial", "shear strain", "", _sheared)
_SHEAR_MODULUS = Quantity(
    "shear_modulus",
    "Secant shear modulus: change of q over twice the shear strain, since the beginning of shearing",
    "secant shear modulus",
    "kPa",
    _shear_modulus,
)
_SECANT = Quantity(
    "secant_modulus",
    "Secant modulus: change of q over axial strain, since the beginning of shearing",
    "secant modulus",
    "kPa",
    _secant,
)


@dataclass(frozen=True)
class TriaxialModel(ShearModel):
    """Forward model of the triaxial test."""

    spec: TriaxialSpec

    @cached_property
    def axes(self) -> Axes:
        """Axial strain and deviator stress are led."""
        n = self.spec.components
        alike = np.zeros((n - 2, n))
        alike[0] = combination(n, xx=1.0, zz=-1.0)
        alike[1:, 3:] = np.eye(n - 3)
        fixed = self.spec.geometry == "fixed"
        return Axes(
            strain=combination(n, yy=1.0),
            stress=combination(n, yy=1.0, xx=-0.5, zz=-0.5),
            kept={
                "radial_stress": combination(n, xx=0.5, zz=0.5),
                "mean_stress": combination(n, xx=1.0 / 3.0, yy=1.0 / 3.0, zz=1.0 / 3.0),
                "axial_stress": combination(n, yy=1.0),
            },
            alike=alike,
            volume=combination(n, xx=1.0, yy=1.0, zz=1.0),
            inner=same_strain if fixed else inner_strain,
            engineering=same_strain if fixed else engineering_strain,
            largest=0.95,
        )

    def voids(self, parameters: Mapping[str, float]) -> Voids:
        """With the water's stiffness."""
        return replace(super().voids(parameters), water_modulus=self.spec.water_bulk_modulus)

    @property
    def back_pressure(self) -> float:
        """Of the section."""
        return self.spec.back_pressure

    @cached_property
    def consolidation(self) -> Sequence[Sequence[LoadPath]]:
        """Axial stress, and radial stress or no radial strain."""
        return self.load_paths_of(
            (
                stage,
                stage.axial,
                None if stage.radial == "K0" else stage.axial if stage.radial is None else stage.radial,
            )
            for stage in self.spec.consolidation
        )

    @cached_property
    def shearing(self) -> Sequence[ShearStage]:
        """As the section has them."""
        spec = self.spec
        return [
            stage.stage(f"shearing {number}", spec.is_undrained(stage), stage.constant)
            for number, stage in enumerate(spec.shearing, start=1)
        ]

    def series_of(self) -> Sequence[TestSeries]:
        """Stresses, strains, pore pressure and state variables."""
        spec = self.spec
        own = state_variables(self.law, spec.components)
        voids = void_ratio(self.law, self.knows_voids)
        water = (_PORE_PRESSURE,) if any(stage.undrained for stage in self.shearing) else ()
        both = (*_STRESSES, *water, *_STRAINS, _SHEARED, *voids, *own)
        consolidating = (*_STRAINS, *voids, _Q, MEAN_PRESSURE, _K0, *own)
        return [
            *shear_series(
                self.axes,
                self.shearing,
                len(spec.consolidation),
                "axial strain",
                both,
                (_SECANT, _SHEAR_MODULUS),
                consolidating,
            ),
            path_series("mean effective stress", self.axes.kept["mean_stress"], _Q),
        ]
