"""The published laboratory tests as specs, for the tests of the forward models."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.forward.isotropic_compression import IsotropicCompressionSpec
from geoswarm.solver.forward.oedometer import OedometerSpec

__all__ = [
    "IDENTIFIED",
    "ISOTROPIC_IDENTIFIED",
    "LABORATORY",
    "isotropic_spec",
    "observation_times",
    "oedometer_spec",
]

IDENTIFIED = {"lambda_star": 0.082, "kappa_star": 0.051, "mu_star": 1.46e-3, "c": 25.0, "phi": 20.0, "psi": 0.0}
LABORATORY = {"lambda_star": 0.064, "kappa_star": 0.035, "mu_star": 1.46e-3, "c": 27.0, "phi": 20.0, "psi": 0.0}
ISOTROPIC_IDENTIFIED = {
    "lambda_star": 0.089,
    "kappa_star": 0.0445,
    "mu_star": 2.33e-3,
    "c": 27.0,
    "phi": 20.0,
    "psi": 0.0,
}

_LOADS = (9.0, 13.0, 25.0, 50.0, 100.0, 200.0, 400.0, 800.0, 400.0, 200.0, 100.0, 50.0, 100.0, 200.0, 400.0, 800.0)
_DURATIONS = (2.0, *(1.0,) * 14, 43.0 / 24.0)

# 30 kPa 3 h, 50 kPa 17 h, steps of 100 kPa to 800 kPa within 1 h (mean 450 kPa), 800 kPa 3 weeks. The hour of steps is
# shared between 50 and 800 kPa so that the integral of load over time stays the same.
_HOUR = 1.0 / 24.0
_SHARE = (800.0 - 450.0) / (800.0 - 50.0)


def oedometer_spec(**changes: object) -> OedometerSpec:
    """Application A."""
    stages = [{"stress": load, "duration": time} for load, time in zip(_LOADS, _DURATIONS, strict=True)]
    return OedometerSpec.model_validate({"height": 0.02021, "initial_stress": 0.2, "stages": stages, **changes})


def isotropic_spec(**changes: object) -> IsotropicCompressionSpec:
    """Application B."""
    stages = [
        {"stress": 30.0, "duration": 3.0 * _HOUR},
        {"stress": 50.0, "duration": (17.0 + _SHARE) * _HOUR},
        {"stress": 800.0, "duration": 21.0 + (1.0 - _SHARE) * _HOUR},
    ]
    return IsotropicCompressionSpec.model_validate(
        {"height": 0.09855, "diameter": 0.04988, "initial_stress": 0.2, "stages": stages, **changes}
    )


def observation_times(spec: OedometerSpec | IsotropicCompressionSpec, points: int = 20) -> FloatArray:
    """Readings in every stage, ``points`` of them, logarithmic from 1.5 minutes after its load to its end, day."""
    ends = np.cumsum([stage.duration for stage in spec.stages])
    starts = ends - [stage.duration for stage in spec.stages]
    readings = [start + np.geomspace(1.0e-3, end - start, points) for start, end in zip(starts, ends, strict=True)]
    return np.concatenate(readings)
