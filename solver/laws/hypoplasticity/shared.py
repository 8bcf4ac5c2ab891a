"""What hypoplastic laws share: intergranular strain, shift of stress, state variables and the stress update."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.constitutive.hypoplasticity.step import CONSTANTS, STATE, hypoplastic_update
from geoswarm.solver.laws.base import StateTensor, StateVariable
from geoswarm.solver.laws.binary import NumbaUpdate, carray
from geoswarm.solver.laws.sources import NIEMUNIS
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = [
    "HYPOPLASTIC_STATE",
    "HYPOPLASTIC_TENSORS",
    "INTERGRANULAR",
    "LEAST_PRESSURE",
    "SHIFT",
    "critical_slope",
    "first_of",
    "hypoplastic_step",
    "hypoplastic_weights",
    "intergranular_contradiction",
    "mobilised_friction",
    "placed",
    "shared_constants",
    "strength_ratio",
]

LEAST_PRESSURE: Final = 1.0e-4
"""kPa: below it stiffness is only asked for to judge errors."""

SHIFT: Final = ParameterInfo(
    "p_t",
    "p_t",
    "kPa",
    "Added to every normal stress that the law sees: a cohesion of p_t tan(phi), and stiffness at the surface.",
    default=0.0,
    lower=0.0,
    typical=(0.0, 5.0),
    source="no published range: a shift of some kPa for calculations near the surface",
)

INTERGRANULAR: Final = (
    ParameterInfo(
        "R",
        "R",
        "",
        "Largest intergranular strain, the size of the range of high stiffness; 0: without intergranular strain.",
        default=0.0,
        lower=0.0,
        upper=0.1,
        typical=(2.0e-5, 2.0e-4),
        source=NIEMUNIS,
    ),
    ParameterInfo(
        "m_R",
        "m_R",
        "",
        "Stiffness after a reversal of strain over that of the linear part L.",
        default=5.0,
        lower=1.0,
        typical=(2.0, 20.0),
        source=NIEMUNIS,
    ),
    ParameterInfo(
        "m_T",
        "m_T",
        "",
        "The same after a turn of strain by 90 degree; at most m_R.",
        default=2.0,
        lower=1.0,
        typical=(1.0, 10.0),
        source=NIEMUNIS,
    ),
    ParameterInfo(
        "beta_r",
        "β_r",
        "",
        "Exponent of the growth of intergranular strain.",
        default=0.5,
        lower=0.05,
        upper=5.0,
        typical=(0.05, 1.0),
        source=NIEMUNIS,
    ),
    ParameterInfo(
        "chi",
        "χ",
        "",
        "Exponent of the decay of stiffness with intergranular strain.",
        default=6.0,
        lower=0.1,
        upper=50.0,
        typical=(0.5, 10.0),
        source=NIEMUNIS,
    ),
)
"""Of Niemunis & Herle (1997); the defaults but R are theirs for Hochstetten sand."""

_AXES: Final = ("xx", "yy", "zz", "xy", "yz", "zx")
HYPOPLASTIC_STATE: Final = (
    StateVariable("void_ratio", "e", "", "Void ratio."),
    *(
        StateVariable(f"h_{name}", f"h_{name}", "", "Intergranular strain, engineering shear, compression positive.")
        for name in _AXES
    ),
    StateVariable(
        "phi_mob",
        "φ_mob",
        "degree",
        "Mobilised friction angle after Matsuoka and Nakai: that of a triaxial state of the same I1 I2/I3; "
        "of the stress shifted by p_t.",
    ),
)
HYPOPLASTIC_TENSORS: Final = (StateTensor(1, 2.0),)
"""The intergranular strain among them."""


@NumbaUpdate
def hypoplastic_step(components, _log_time, strain, stress, state, constants, new_stress, new_state, tangent):  # type: ignore[no-untyped-def]  # pointers
    """One step of any hypoplastic law; the first constant says which."""
    n = components
    return hypoplastic_update(
        carray(stress, n),
        carray(strain, n),
        carray(state, STATE),
        carray(constants, CONSTANTS),
        carray(new_stress, n),
        carray(new_state, STATE),
        carray(tangent, (n, n)),
    )


def shared_constants(number: int, given: Mapping[str, Any]) -> list[float]:
    """The constants before those of a law: its number, p_t, R, m_R, m_T, beta_r, chi."""
    return [float(number), *(float(given[name]) for name in ("p_t", "R", "m_R", "m_T", "beta_r", "chi"))]


def critical_slope(sine: float) -> float:
    """a = sqrt(3) (3 - sine)/(2 sqrt(2) sine) of the sine of the critical friction angle."""
    return math.sqrt(3.0) * (3.0 - sine) / (2.0 * math.sqrt(2.0) * sine)


def first_of(wrong: BoolArray) -> tuple[np.intp, ...]:
    """Where the first of some places (...) is wrong."""
    return np.unravel_index(int(np.argmax(wrong)), wrong.shape) if wrong.shape else ()


def strength_ratio(sine: float) -> float:
    """(3 + a^2)/(sqrt(3) a) of the sine of the critical friction angle."""
    a = critical_slope(sine)
    return (3.0 + a * a) / (math.sqrt(3.0) * a)


def intergranular_contradiction(values: Mapping[str, float]) -> str | None:
    """What is wrong with the intergranular strain, or None; values may be missing."""
    defaults = {info.name: info.default for info in INTERGRANULAR}
    if values.get("R") == 0.0:
        for name in ("m_R", "m_T", "beta_r", "chi"):
            if values.get(name, defaults[name]) != defaults[name]:
                return (
                    f"{name} = {values[name]:g} with R = 0: {name} is of the intergranular strain, which R above 0 adds"
                )
    m_R, m_T = values.get("m_R"), values.get("m_T")
    if values.get("R", 0.0) > 0.0 and m_R is not None and m_T is not None and m_T > m_R:
        return f"m_T must be at most m_R = {m_R:g}, got {m_T:g}"
    return None


def mobilised_friction(stress: FloatArray, shift: float) -> FloatArray:
    """Mobilised friction angle (...,), degree, after Matsuoka and Nakai, of stresses (..., 4 or 6), kPa."""
    s = np.concatenate([stress, np.zeros((*stress.shape[:-1], 6 - stress.shape[-1]))], axis=-1)
    x, y, z = (s[..., i] + shift for i in range(3))
    a, b, c = (s[..., i] for i in range(3, 6))
    first = x + y + z
    second = x * y + y * z + z * x - a * a - b * b - c * c
    third = x * y * z + 2.0 * a * b * c - x * b * b - y * c * c - z * a * a
    with np.errstate(divide="ignore", invalid="ignore"):
        square = (first * second - 9.0 * third) / (first * second - third)
    angle: FloatArray = np.degrees(np.arcsin(np.sqrt(np.clip(np.nan_to_num(square), 0.0, 1.0))))
    return angle


def placed(stress: FloatArray, e: FloatArray, shift: float) -> FloatArray:
    """State variables (..., s) of a soil placed with a void ratio e (...,): no intergranular strain yet."""
    state = np.zeros((*stress.shape[:-1], STATE))
    state[..., 0], state[..., 7] = e, mobilised_friction(stress, shift)
    return state


def hypoplastic_weights(constants: FloatArray) -> FloatArray:
    """Strain of a unit of the state variables: of void ratio about a half, of intergranular strain by its stiffness."""
    weights = np.zeros(STATE)
    weights[0] = 0.5
    weights[1:7] = constants[3] if constants[2] > 0.0 else 0.0
    return weights
