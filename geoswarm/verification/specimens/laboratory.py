"""Sections of laboratory tests, and a short way to run them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.laboratory.flow.consolidation import ConsolidationSpec
from geoswarm.solver.laboratory.flow.crs import CrsOedometerSpec
from geoswarm.solver.laboratory.shear.simple_shear import DirectSimpleShearSpec
from geoswarm.solver.laboratory.shear.triaxial import TriaxialSpec

__all__ = ["CREEP", "ELASTIC", "MOHR_COULOMB", "consolidation", "crs_oedometer", "run", "simple_shear", "triaxial"]

ELASTIC = {"E": 2.0e4, "nu": 0.3}
MOHR_COULOMB = {"E": 2.0e4, "nu": 0.3, "c": 5.0, "phi": 30.0, "psi": 10.0}
CREEP = {"lambda_star": 0.1, "kappa_star": 0.02, "mu_star": 0.004, "c": 2.0, "phi": 28.0}


def triaxial(material: str, shearing: Sequence[Mapping[str, Any]], **changes: Any) -> TriaxialSpec:
    """A specimen under 100 kPa all round, at small strain; stages of shearing are monotonic unless they say more."""
    section = {
        "material": material,
        "initial_stress": 100.0,
        "shearing": [{"kind": "monotonic", **stage} for stage in shearing],
        "geometry": "fixed",
        **changes,
    }
    return TriaxialSpec.model_validate(section)


def simple_shear(material: str, shearing: Sequence[Mapping[str, Any]], **changes: Any) -> DirectSimpleShearSpec:
    """A specimen under 100 kPa vertical and the law's K0; stages of shearing are monotonic unless they say more."""
    section = {
        "material": material,
        "initial_stress": 100.0,
        "shearing": [{"kind": "monotonic", **stage} for stage in shearing],
        **changes,
    }
    return DirectSimpleShearSpec.model_validate(section)


def run(spec: Any, parameters: Mapping[str, float], x: Any, *series: str) -> tuple[FloatArray, ...]:
    """Values of series at x."""
    points = np.atleast_1d(np.asarray(x, dtype=np.float64))
    found = spec.build().prepare(dict.fromkeys(series, points))(parameters)
    return tuple(found[name] for name in series)


def crs_oedometer(material: str, stages: Sequence[Mapping[str, Any]], **changes: Any) -> CrsOedometerSpec:
    """A specimen of 2 cm under 100 kPa vertical and the law's K0; stages are monotonic unless they say more."""
    section = {
        "material": material,
        "height": 0.02,
        "initial_stress": 100.0,
        "stages": [{"kind": "monotonic", **stage} for stage in stages],
        **changes,
    }
    return CrsOedometerSpec.model_validate(section)


def consolidation(material: str, loads: Sequence[tuple[float, ...]], **changes: Any) -> ConsolidationSpec:
    """A specimen of 2 cm under 100 kPa vertical and the law's K0; loads are (stress, duration[, loading_time])."""
    section = {
        "material": material,
        "height": 0.02,
        "initial_stress": 100.0,
        "stages": [dict(zip(("stress", "duration", "loading_time"), stage, strict=False)) for stage in loads],
        **changes,
    }
    return ConsolidationSpec.model_validate(section)
