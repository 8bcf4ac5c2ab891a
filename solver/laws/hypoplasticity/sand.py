"""Hypoplasticity of sand as a law; equations: :mod:`geoswarm.solver.constitutive.hypoplasticity.sand`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.hypoplasticity.step import FIRST, SAND
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Law, StateTensor, StateVariable
from geoswarm.solver.laws.binary import NumbaUpdate
from geoswarm.solver.laws.hypoplasticity.shared import (
    HYPOPLASTIC_STATE,
    HYPOPLASTIC_TENSORS,
    INTERGRANULAR,
    LEAST_PRESSURE,
    SHIFT,
    critical_slope,
    first_of,
    hypoplastic_step,
    hypoplastic_weights,
    intergranular_contradiction,
    placed,
    shared_constants,
    strength_ratio,
)
from geoswarm.solver.laws.sources import HERLE, TERZAGHI
from geoswarm.solver.laws.terms import CRITICAL_FRICTION, Term
from geoswarm.solver.laws.usual_parameters import critical_friction
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["HypoplasticSand"]

_E0, _E00 = FIRST + 9, FIRST + 10
"""Where the constants hold the initial void ratio, after those of the kernels."""

_PARAMETERS = (
    critical_friction(28.0, 38.0, HERLE),
    ParameterInfo(
        "h_s", "h_s", "kPa", "Granular hardness.", lower=0.0, lower_open=True, typical=(1.0e5, 4.0e7), source=HERLE
    ),
    ParameterInfo(
        "n",
        "n",
        "",
        "Exponent of compression.",
        lower=0.0,
        upper=1.0,
        lower_open=True,
        upper_open=True,
        typical=(0.15, 0.5),
        source=HERLE,
    ),
    ParameterInfo(
        "e_d0",
        "e_d0",
        "",
        "Least void ratio at zero mean stress; below e_c0.",
        lower=0.0,
        lower_open=True,
        typical=(0.25, 0.8),
        source=HERLE,
    ),
    ParameterInfo(
        "e_c0",
        "e_c0",
        "",
        "Critical void ratio at zero mean stress; below e_i0.",
        lower=0.0,
        lower_open=True,
        typical=(0.4, 1.3),
        source=HERLE,
    ),
    ParameterInfo(
        "e_i0",
        "e_i0",
        "",
        "Largest void ratio at zero mean stress.",
        lower=0.0,
        lower_open=True,
        typical=(0.5, 1.5),
        source=HERLE,
    ),
    ParameterInfo(
        "alpha",
        "α",
        "",
        "Exponent of the relative void ratio: peak friction and dilatancy.",
        lower=0.0,
        upper=5.0,
        lower_open=True,
        typical=(0.05, 0.5),
        source=HERLE,
    ),
    ParameterInfo(
        "beta",
        "β",
        "",
        "Exponent of the void ratio: stiffness of dense soil.",
        lower=0.0,
        upper=20.0,
        typical=(0.8, 3.0),
        source=HERLE,
    ),
    ParameterInfo(
        "e0",
        "e₀",
        "",
        "Initial void ratio under the initial stress; or give e00.",
        default=0.0,
        lower=0.0,
        typical=(0.4, 1.0),
        source=f"{TERZAGHI}, table 6.3",
    ),
    ParameterInfo(
        "e00",
        "e₀₀",
        "",
        "Initial void ratio at zero mean stress, which Bauer's law reduces to that under the initial stress: the same "
        "relative density at any depth; or give e0.",
        default=0.0,
        lower=0.0,
        typical=(0.4, 1.0),
        source=f"{TERZAGHI}, table 6.3",
    ),
    SHIFT,
    *INTERGRANULAR,
)


class HypoplasticSand(Law):
    """Hypoplasticity for sand.

    Constants: those that hypoplastic laws share, a, h_s, n, e_d0, e_c0, e_i0, alpha, beta, the last bracket of f_s, e0
    and e00.

    Examples
    --------
    >>> toyoura = {"phi_c": 30, "h_s": 2.6e6, "n": 0.27, "e_d0": 0.61, "e_c0": 0.98, "e_i0": 1.10, "alpha": 0.18}
    >>> soil = HypoplasticSand().soil({**toyoura, "beta": 1.1, "e0": 0.75})
    """

    kind: ClassVar[str] = "hypoplastic_sand"
    title: ClassVar[str] = "hypoplasticity of sand"
    parameters: ClassVar[tuple[ParameterInfo, ...]] = _PARAMETERS
    terms: ClassVar[tuple[Term, ...]] = (CRITICAL_FRICTION,)
    derived: ClassVar[frozenset[str]] = frozenset({"e0", "e00"})
    instead_of_e0: ClassVar[frozenset[str]] = frozenset({"e00"})
    state: ClassVar[tuple[StateVariable, ...]] = HYPOPLASTIC_STATE
    tensors: ClassVar[tuple[StateTensor, ...]] = HYPOPLASTIC_TENSORS
    update: ClassVar[NumbaUpdate] = hypoplastic_step

    def contradiction(self, values: Mapping[str, float]) -> str | None:
        """Void ratios that do not fit together, or parameters of the intergranular strain."""
        for lower, upper in (("e_d0", "e_c0"), ("e_c0", "e_i0"), ("e_d0", "e_i0")):
            low, high = values.get(lower), values.get(upper)
            if low is not None and high is not None and not low < high:
                return f"{lower} must be below {upper} = {high:g}, got {low:g}"
        e0, e00 = values.get("e0", 0.0), values.get("e00", 0.0)
        if e0 > 0.0 and e00 > 0.0:
            return f"e0 = {e0:g} and e00 = {e00:g} are both given; give only one of them"
        for name, e in (("e0", e0), ("e00", e00)):
            most = values.get("e_i0", math.inf)
            if e > most:
                return f"{name} must be at most e_i0 = {most:g}, got {e:g}"
        least = values.get("e_d0", 0.0)
        if 0.0 < e00 <= least:
            return f"e00 must be above e_d0 = {least:g}, got {e00:g}"
        return intergranular_contradiction(values)

    def incomplete(self, given: frozenset[str]) -> str | None:
        """The initial void ratio."""
        return None if len(given & {"e0", "e00"}) == 1 else "give exactly one of e0 and e00"

    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        """Those that the class names."""
        if not given["e0"] and not given["e00"]:
            raise InfeasibleError("give exactly one of e0 and e00, a value above 0")
        sine = math.sin(math.radians(given["phi_c"]))
        a = critical_slope(sine)
        density = (given["e_i0"] - given["e_d0"]) / (given["e_c0"] - given["e_d0"])
        bracket = 3.0 + a * a - math.sqrt(3.0) * a * density ** given["alpha"]
        if not bracket > 0.0:
            raise InfeasibleError(
                f"e_i0 = {given['e_i0']:g} with alpha = {given['alpha']:g}: e_i0 is too far above e_c0 for f_s; "
                "values with ((e_i0 - e_d0)/(e_c0 - e_d0))^alpha below (3 + a^2)/(sqrt(3) a) = "
                f"{strength_ratio(sine):g} are accepted"
            )
        own = [given[name] for name in ("h_s", "n", "e_d0", "e_c0", "e_i0", "alpha", "beta")]
        return np.array([*shared_constants(SAND, given), a, *own, bracket, given["e0"], given["e00"]])

    def K0(self, constants: FloatArray) -> float:
        """Jaky: 1 - sin(phi_c)."""
        return float(1.0 - 3.0 / (1.0 + 2.0 * math.sqrt(2.0 / 3.0) * constants[FIRST]))

    def initial_state(self, stress: FloatArray, constants: FloatArray) -> FloatArray:
        """The void ratio given, no intergranular strain.

        Raises
        ------
        InfeasibleError
            The void ratio is outside e_d to e_i under the stress.
        """
        h_s, n, e_d0, _, e_i0 = constants[FIRST + 1 : FIRST + 6].tolist()
        trace = np.maximum(stress[..., :3].sum(axis=-1) + 3.0 * constants[1], 0.0)
        shrunk = np.exp(-((trace / h_s) ** n))
        e = constants[_E00] * shrunk if constants[_E00] > 0.0 else np.full(trace.shape, constants[_E0])
        wrong = (e <= e_d0 * shrunk) | (e > e_i0 * shrunk * (1.0 + 1.0e-9))
        if wrong.any():
            at = first_of(wrong)
            raise InfeasibleError(
                f"e0 must be above e_d = {e_d0 * shrunk[at]:.6g} and at most e_i = {e_i0 * shrunk[at]:.6g} "
                f"under a mean stress of {trace[at] / 3.0:g} kPa, got {e[at]:g}"
            )
        return placed(stress, e, float(constants[1]))

    def elastic_moduli(self, constants: FloatArray, p: float) -> tuple[float, float]:
        """Those of the linear part L at an all-round stress and the initial void ratio."""
        a, h_s, n, _, _, e_i0, _, beta, bracket, e0, e00 = constants[FIRST : FIRST + 11].tolist()
        ratio = 3.0 * max(p + float(constants[1]), LEAST_PRESSURE) / h_s
        shrunk = math.exp(-(ratio**n))
        e, e_i = e00 * shrunk if e00 > 0.0 else e0, e_i0 * shrunk
        f_s = h_s / n * (e_i / e) ** beta * (1.0 + e_i) / e_i * ratio ** (1.0 - n) / bracket
        return f_s * (1.0 + a * a / 3.0), 1.5 * f_s

    def state_weights(self, constants: FloatArray) -> FloatArray:
        """Strain of a unit of void ratio; what intergranular strain does to stiffness, at most."""
        return hypoplastic_weights(constants)
