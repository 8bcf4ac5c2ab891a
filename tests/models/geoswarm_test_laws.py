"""A law of another package: the standard linear solid, linear elasticity with as much again that comes with time.

Strain is D^-1 sigma + v with v' = (r D^-1 sigma - v)/T. One implicit step, with x = dt/T and the state variable
w = v - r D^-1 sigma (what is still to come, with the other sign), which is 0 where the soil is placed::

    D^-1 d_sigma = (d_eps + w x/(1 + x)) / (1 + r x/(1 + x)),     w_new = (w - r D^-1 d_sigma)/(1 + x)
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.laws.base import Law, StateVariable
from geoswarm.solver.laws.binary import NumbaUpdate, carray
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["NoPlaneLaw", "StandardSolid"]


@NumbaUpdate
def _update(components, log_time, strain, stress, state, constants, new_stress, new_state, tangent):  # type: ignore[no-untyped-def]
    shear, lame, ratio, time = constants[0], constants[1], constants[2], constants[3]
    x = math.exp(log_time) / time
    soft = 1.0 + ratio * x / (1.0 + x)
    C = carray(tangent, (components, components))
    volume = 0.0
    for i in range(3):
        volume += strain[i] + state[i] * x / (1.0 + x)
    for i in range(components):
        for j in range(components):
            C[i, j] = lame / soft if i < 3 and j < 3 else 0.0
        stiffness = 2.0 * shear if i < 3 else shear
        C[i, i] += stiffness / soft
        step = strain[i] + state[i] * x / (1.0 + x)
        new_stress[i] = stress[i] + (stiffness * step + (lame * volume if i < 3 else 0.0)) / soft
    mean, bulk = 0.0, lame + 2.0 / 3.0 * shear
    for i in range(3):
        mean += (new_stress[i] - stress[i]) / 3.0
    for i in range(6):
        new_state[i] = 0.0
    for i in range(components):
        change = new_stress[i] - stress[i]
        elastic = (change - mean) / (2.0 * shear) + mean / (3.0 * bulk) if i < 3 else change / shear
        new_state[i] = (state[i] - ratio * elastic) / (1.0 + x)
    return 0


class StandardSolid(Law):
    """Standard linear solid: elastic at once, and ``ratio`` times as much more with the retardation time ``T``."""

    kind: ClassVar[str] = "standard_solid"
    title: ClassVar[str] = "the standard linear solid"
    parameters: ClassVar[tuple[ParameterInfo, ...]] = (
        ParameterInfo("E", "E", "kPa", "Young's modulus at once.", lower=0.0, lower_open=True),
        ParameterInfo("nu", "ν", "", "Poisson's ratio.", default=0.3, lower=0.0, upper=0.5, upper_open=True),
        ParameterInfo("ratio", "r", "", "Delayed strain over that at once.", default=1.0, lower=0.0),
        ParameterInfo("T", "T", "day", "Retardation time.", default=1.0, lower=0.0, lower_open=True),
    )
    state: ClassVar[tuple[StateVariable, ...]] = tuple(
        StateVariable(f"v_{name}", f"v_{name}", "", "Delayed strain less that of the present stress in the end.")
        for name in ("xx", "yy", "zz", "xy", "yz", "zx")
    )
    update: ClassVar[NumbaUpdate] = _update

    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        shear = given["E"] / (2.0 * (1.0 + given["nu"]))
        return np.array([shear, 2.0 * shear * given["nu"] / (1.0 - 2.0 * given["nu"]), given["ratio"], given["T"]])

    def K0(self, constants: FloatArray) -> float:
        return float(constants[1] / (constants[1] + 2.0 * constants[0]))

    def log_time_scale(self, stress: FloatArray, state: FloatArray, constants: FloatArray) -> FloatArray:  # noqa: ARG002
        return np.full(stress.shape[:-1], math.log(constants[3]))

    def elastic_moduli(self, constants: FloatArray, p: float) -> tuple[float, float]:  # noqa: ARG002
        return float(constants[1] + 2.0 / 3.0 * constants[0]), float(constants[0])

    def state_weights(self, constants: FloatArray) -> FloatArray:  # noqa: ARG002
        return np.ones(len(self.state))


class NoPlaneLaw(StandardSolid):
    """The same without an update for planes and without K0."""

    kind: ClassVar[str] = "no_plane"
    components: ClassVar[frozenset[int]] = frozenset({6})
    K0 = Law.K0
