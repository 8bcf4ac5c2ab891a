"""The direct simple shear test at a material point: how it is led, and its series.

yy is vertical, xx the direction of shearing, zz across it; xx and zz are held by the rings, xy is sheared. Strains are
the integrals of rates of deformation, and stresses are those on horizontal and vertical planes: that the soil between
these planes turns by half the shear strain is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.load_paths import LoadPath
from geoswarm.solver.element_test.specimen import combination, same_strain
from geoswarm.solver.laboratory.model import ShearModel
from geoswarm.solver.laboratory.quantities import (
    MEAN_PRESSURE,
    Quantity,
    Seen,
    pore_pressure,
    state_variables,
    void_ratio,
)
from geoswarm.solver.laboratory.series import TestSeries
from geoswarm.solver.laboratory.shear_axes import path_series, shear_series
from geoswarm.solver.laboratory.shear_stages import Axes, ShearStage
from geoswarm.solver.laws.base import mean_and_squared_q

if TYPE_CHECKING:
    from geoswarm.solver.laboratory.shear.simple_shear import DirectSimpleShearSpec

__all__ = ["SimpleShearModel"]


def _deviatoric(seen: Seen) -> FloatArray:
    q: FloatArray = np.sqrt(mean_and_squared_q(seen.stress)[1])
    return q


def _secant(seen: Seen) -> FloatArray:
    modulus: FloatArray = (seen.stress[:, 3] - seen.reference[3]) / seen.strain[:, 3]
    return modulus


def _rotation(seen: Seen) -> FloatArray:
    turned: FloatArray = np.degrees(0.5 * np.arctan2(2.0 * seen.stress[:, 3], seen.axial - seen.stress[:, 0]))
    return turned


_TAU = Quantity("shear_stress", "Shear stress on horizontal planes", "τ", "kPa", lambda seen: seen.stress[:, 3])
_NORMAL = Quantity("normal_stress", "Vertical effective stress", "σ'v", "kPa", lambda seen: seen.axial)
_VERTICAL = Quantity(
    "vertical_strain",
    "Vertical strain, which is that of the volume",
    "vertical strain",
    "",
    lambda seen: seen.engineering(seen.strain[:, 1]),
)
_SHEARED = (
    _TAU,
    _NORMAL,
    Quantity(
        "stress_ratio",
        "Shear stress over vertical effective stress",
        "τ/σ'v",
        "",
        lambda seen: seen.stress[:, 3] / seen.axial,
    ),
    Quantity(
        "horizontal_stress",
        "Horizontal effective stress in the direction of shearing",
        "horizontal stress",
        "kPa",
        lambda seen: seen.stress[:, 0],
    ),
    MEAN_PRESSURE,
    Quantity("q", "Deviatoric stress sqrt(3/2 s:s)", "q", "kPa", _deviatoric),
    Quantity("rotation", "Angle of the largest compressive stress from the vertical", "rotation", "degree", _rotation),
    Quantity("shear_strain", "Shear strain", "shear strain", "", lambda seen: seen.strain[:, 3]),
    _VERTICAL,
)
_PORE_PRESSURE = pore_pressure(
    "Decrease of the vertical stress at constant volume: the pore pressure of an undrained specimen"
)
_K0 = Quantity(
    "K0", "Ratio of horizontal to vertical effective stress", "K0", "", lambda seen: seen.radial / seen.axial
)
_SECANT = Quantity(
    "secant_modulus",
    "Secant shear modulus: change of shear stress over shear strain, since the beginning of shearing",
    "secant modulus",
    "kPa",
    _secant,
)


@dataclass(frozen=True)
class SimpleShearModel(ShearModel):
    """Forward model of the direct simple shear test."""

    spec: DirectSimpleShearSpec

    @cached_property
    def axes(self) -> Axes:
        """Shear strain and shear stress are led; without drainage the height stays."""
        n = self.spec.components
        alike = np.zeros((n - 2, n))
        alike[0], alike[1] = combination(n, xx=1.0), combination(n, zz=1.0)
        alike[2:, 4:] = np.eye(n - 4)
        return Axes(
            strain=combination(n, xy=1.0),
            stress=combination(n, xy=1.0),
            kept={"normal_stress": combination(n, yy=1.0)},
            alike=alike,
            volume=combination(n, xx=1.0, yy=1.0, zz=1.0),
            inner=same_strain,
            engineering=same_strain,
            largest=np.inf,
        )

    @cached_property
    def consolidation(self) -> Sequence[Sequence[LoadPath]]:
        """Vertical stress without horizontal strain."""
        return self.load_paths_of((stage, stage.normal_stress, None) for stage in self.spec.consolidation)

    @cached_property
    def shearing(self) -> Sequence[ShearStage]:
        """As the section has them; a constant volume is that of a rigid pore water."""
        spec = self.spec
        return [
            stage.stage(f"shearing {number}", spec.keeps_volume(stage), "normal_stress")
            for number, stage in enumerate(spec.shearing, start=1)
        ]

    def series_of(self) -> Sequence[TestSeries]:
        """Stresses, strains, pore pressure and state variables."""
        spec = self.spec
        own = state_variables(self.law, spec.components)
        voids = void_ratio(self.law, self.knows_voids)
        water = (_PORE_PRESSURE,) if any(stage.undrained for stage in self.shearing) else ()
        both = (*_SHEARED, *water, *voids, *own)
        consolidating = (_VERTICAL, *voids, MEAN_PRESSURE, _K0, *own)
        return [
            *shear_series(
                self.axes, self.shearing, len(spec.consolidation), "shear strain", both, (_SECANT,), consolidating
            ),
            path_series("vertical effective stress", self.axes.kept["normal_stress"], _TAU),
        ]
