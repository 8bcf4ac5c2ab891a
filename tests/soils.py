"""Soils of the built-in laws for tests and benchmarks of finite elements, by their usual numbers."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.constitutive.soft_soil_creep import SoftSoilCreep
from geoswarm.solver.fem.materials import Material
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law

__all__ = ["creeping", "elastic", "mohr_coulomb"]


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
