"""Soils of the built-in laws by their usual numbers, and states of soft soil creep."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.constitutive.soft_soil_creep.physics import SoftSoilCreep
from geoswarm.solver.element_test.load_paths import PointState
from geoswarm.solver.element_test.material_point import History, point_under
from geoswarm.solver.fem.materials import Material
from geoswarm.solver.fem.setup import SoilTable
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.solver.laws.soft_soil_creep import equivalent_pressures

__all__ = ["creep_law", "creep_point", "creeping", "elastic", "mohr_coulomb", "overconsolidation", "soil_arrays"]


def elastic(young: float, poisson: float, unit_weight: float = 0.0, K0: float | None = None) -> Material:
    """Linear elasticity."""
    return Material(find_law("elastic").soil({"E": young, "nu": poisson}), unit_weight, K0)


def mohr_coulomb(
    young: float,
    poisson: float,
    c: float,
    phi: float,
    psi: float = 0.0,
    tension_cutoff: float | None = 0.0,
    unit_weight: float = 0.0,
    K0: float | None = None,
) -> Material:
    """Mohr-Coulomb."""
    given = {"E": young, "nu": poisson, "c": c, "phi": phi, "psi": psi, "tension_cutoff": tension_cutoff}
    return Material(find_law("mohr_coulomb").soil(given), unit_weight, K0)


def creeping(
    soil: SoftSoilCreep, unit_weight: float = 0.0, OCR: float = 1.0, POP: float = 0.0, K0: float | None = None
) -> Material:
    """Soft soil creep with constants as the kernels take them."""
    return Material(Soil(find_law("soft_soil_creep"), np.array([*soil, OCR, POP])), unit_weight, K0)


def soil_arrays(material: Material) -> tuple[IntArray, FloatArray, IntArray, FloatArray, IntArray, FloatArray]:
    """What a body of one soil holds about it: update, constants, strength, elastic moduli, and tensors of state."""
    table = SoilTable.of([material.soil])
    return table.updates, table.constants, table.strength, table.elastic, table.tensors, table.tensor_shear


def creep_law(soil: SoftSoilCreep, OCR: float = 1.0) -> Soil:
    """Soft soil creep with constants as the kernels take them."""
    return Soil(find_law("soft_soil_creep"), np.array([*soil, OCR, 0.0]))


def creep_point(stress: Sequence[float], soil: SoftSoilCreep, OCR: float = 1.0) -> PointState:
    """Unstrained state under a stress, with p_p = OCR p_eq."""
    return point_under(stress, creep_law(soil, OCR))


def overconsolidation(history: History, soil: SoftSoilCreep) -> FloatArray:
    """p_p/p_eq at all times."""
    ratio: FloatArray = np.exp(history.internal[:, 0]) / equivalent_pressures(history.stress, soil)
    return ratio
