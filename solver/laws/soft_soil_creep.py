"""The soft soil creep model as a law, and the soft soil model: the same kernels without creep."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.soft_soil_creep.physics import (
    Formulation,
    SoftSoilCreep,
    friction_constant,
    soft_soil,
    soft_soil_creep,
)
from geoswarm.solver.constitutive.soft_soil_creep.step import soft_soil_step
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Law, Setting, StateVariable, StrengthPlaces, mean_and_squared_q
from geoswarm.solver.laws.binary import NumbaUpdate, carray
from geoswarm.solver.laws.perfect_plasticity.mohr_coulomb import TENSION_CUTOFF
from geoswarm.solver.laws.sources import BRINKGREVE, MESRI_CREEP, PLAXIS, TERZAGHI
from geoswarm.solver.laws.terms import COHESION, FRICTION, LN10, Term, oedometric, same
from geoswarm.solver.laws.usual_parameters import (
    DILATANCY,
    angle,
    cohesion,
    normal_K0,
    overconsolidation,
    pre_overburden,
    too_dilatant,
    two_pasts,
    unloading_poisson,
)
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = [
    "PARAMETERS",
    "SOFT_SOIL_TERMS",
    "SoftSoilCreepLaw",
    "SoftSoilLaw",
    "creep_constants",
    "creep_soil",
    "equivalent_pressures",
]

_OCR, _POP = 16, 17
"""Where the constants hold the initial preconsolidation, after those of the kernels."""

_CC = Term(
    "Cc",
    "",
    "compression index",
    "lambda_star",
    "2.303 λ* (1 + e₀)",
    lambda known: LN10 * known["lambda_star"] * (1.0 + known["e_0"]),
    lambda value, known: value / (LN10 * (1.0 + known["e_0"])),
    voids=True,
)
_CS = Term(
    "Cs",
    "",
    "swelling index",
    "kappa_star",
    "2.303 κ* (1 + e₀) (1 + ν)/(3 (1 − ν)), about",
    lambda known: LN10 * known["kappa_star"] * (1.0 + known["e_0"]) * oedometric(known.get("nu_ur", 0.15), known),
    lambda value, known: value / (LN10 * (1.0 + known["e_0"]) * oedometric(known.get("nu_ur", 0.15), known)),
    voids=True,
)
_CALPHA = Term(
    "Cα",
    "",
    "creep index",
    "mu_star",
    "2.303 μ* (1 + e₀)",
    lambda known: LN10 * known["mu_star"] * (1.0 + known["e_0"]),
    lambda value, known: value / (LN10 * (1.0 + known["e_0"])),
    voids=True,
)
SOFT_SOIL_TERMS = (_CC, _CS, FRICTION, COHESION, same("K₀", "", "stress ratio at rest", "K0nc"))

PARAMETERS = (
    ParameterInfo(
        "lambda_star",
        "λ*",
        "",
        "Modified compression index, slope of normal compression over ln(stress); above kappa_star.",
        lower=0.0,
        lower_open=True,
        typical=(0.01, 0.3),
        source=f"{PLAXIS}: I_P/500, I_P from 5 to 150 %",
    ),
    ParameterInfo(
        "kappa_star",
        "κ*",
        "",
        "Modified swelling index, slope of unloading and reloading over ln(stress).",
        lower=0.0,
        lower_open=True,
        typical=(0.002, 0.1),
        source=f"{PLAXIS}: lambda_star/kappa_star from 2.5 to 7",
    ),
    ParameterInfo(
        "mu_star",
        "μ*",
        "",
        "Modified creep index, creep strain over ln(time).",
        lower=0.0,
        lower_open=True,
        typical=(1.0e-4, 0.02),
        source=MESRI_CREEP,
    ),
    cohesion(50.0),
    angle(
        "phi",
        "φ",
        "Effective friction angle; 0 is refused.",
        (15.0, 35.0),
        f"{TERZAGHI}, article 19 (clays)",
        lower_open=True,
    ),
    DILATANCY,
    unloading_poisson(0.15, 0.1, 0.2),
    normal_K0(0.4, 0.8),
    ParameterInfo(
        "M",
        "M",
        "",
        "Slope q/p of the tops of the equivalent pressure ellipses; 0: derived from K0nc.",
        default=0.0,
        lower=0.0,
        typical=(0.8, 1.8),
        source=BRINKGREVE,
    ),
    overconsolidation(
        "Initial overconsolidation ratio p_p/p_eq of the model; without cohesion that of the vertical stress. "
        "Translated, both hold a = c cot(phi): with p = a = 20 kPa, OCR = 2 is a preconsolidation stress of "
        "2 (p + a) - a = 60 kPa. POP counts stresses as they are."
    ),
    pre_overburden(50.0),
)


@NumbaUpdate
def _update(components, log_time, strain, stress, state, constants, new_stress, new_state, tangent):  # type: ignore[no-untyped-def]  # pointers
    c = carray(constants, 16)
    soil = SoftSoilCreep(
        c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10], c[11], c[12], c[13], c[14], c[15]
    )
    old, step = carray(stress, components), carray(strain, components)
    new, C = carray(new_stress, components), carray(tangent, (components, components))
    log_time -= math.log(soil.tau)
    new_state[0], active = soft_soil_step(old, step, log_time, state[0], soil, new, C)
    if soil.mu_star == 0.0 and active >= 0:
        return 2 * active + (1 if new_state[0] > state[0] else 0)  # yield by compression is a limit of its own
    return active


class SoftSoilCreepLaw(Law):
    """Soft soil creep; constants: those of the kernels (:class:`SoftSoilCreep`), OCR and POP."""

    kind: ClassVar[str] = "soft_soil_creep"
    title: ClassVar[str] = "soft soil creep"
    parameters: ClassVar[tuple[ParameterInfo, ...]] = PARAMETERS
    terms: ClassVar[tuple[Term, ...]] = (*SOFT_SOIL_TERMS, _CALPHA)
    derived: ClassVar[frozenset[str]] = frozenset({"K0nc", "M"})
    settings: ClassVar[tuple[Setting, ...]] = (
        Setting(
            "formulation",
            "Whether stiffness and creep see the mean stress shifted by c cot(phi).",
            "translated",
            choices=("translated", "untranslated"),
        ),
        TENSION_CUTOFF,
    )
    state: ClassVar[tuple[StateVariable, ...]] = (
        StateVariable("log_pp", "ln p_p", "", "Logarithm of the preconsolidation pressure in kPa."),
    )
    update: ClassVar[NumbaUpdate] = _update
    strength: ClassVar[StrengthPlaces | None] = StrengthPlaces(7, 8, 9, 10, 14)

    def inadmissible(self, values: Mapping[str, float]) -> str | None:
        """What is inadmissible, in words; friction is needed."""
        if values.get("phi") == 0.0:
            return f"phi must be above 0 and below 90 degree, got 0 degree: {self.title} needs friction"
        return super().inadmissible(values)

    def contradiction(self, values: Mapping[str, float]) -> str | None:
        """Indices, angles, K0nc and M, or OCR and POP that do not fit together."""
        defaults = {info.name: info.default for info in self.parameters if info.default is not None}
        known = {**defaults, **values}
        stiff, soft = known.get("lambda_star"), known.get("kappa_star")
        if stiff is not None and soft is not None and not stiff > soft:
            return f"lambda_star must be above kappa_star = {soft:g}, got {stiff:g}"
        phi, psi, K0nc, M = known.get("phi"), known["psi"], known["K0nc"], known["M"]
        fault = too_dilatant(phi, psi)
        if fault is not None:
            return fault
        if K0nc > 0.0 and M > 0.0:
            return f"K0nc = {K0nc:g} and M = {M:g} are both given; give only one, the other follows from it"
        fault = two_pasts(known["OCR"], known["POP"])
        if fault is not None:
            return fault
        if M == 0.0 and stiff is not None and soft is not None and (phi is not None or K0nc > 0.0):
            ratio = K0nc if K0nc > 0.0 or phi is None else 1.0 - math.sin(math.radians(phi))
            try:
                friction_constant(ratio, known["nu_ur"], stiff / soft)
            except InfeasibleError as error:
                return str(error)
        return None

    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        """Those that the class names."""
        soil = self.kernel_constants(given, given["formulation"], given["tension_cutoff"])
        return np.array([*soil, given["OCR"], given["POP"]])

    def kernel_constants(
        self, given: Mapping[str, float], formulation: Formulation, tension_cutoff: float | None
    ) -> SoftSoilCreep:
        """Constants of the kernels from parameters by name; raises as :meth:`constants`."""
        return creep_soil(given, formulation, tension_cutoff)

    def K0(self, constants: FloatArray) -> float:
        """K0nc."""
        return creep_constants(constants).K0nc

    def initial_state(self, stress: FloatArray, constants: FloatArray) -> FloatArray:
        """ln p_p: p_p = OCR p_eq, or p_eq where the vertical stress is raised by POP and the horizontal by K0nc POP."""
        soil, POP = creep_constants(constants), constants[_POP]
        if POP > 0.0:
            shift = np.zeros(stress.shape[-1])
            shift[:3] = POP * np.array([soil.K0nc, 1.0, soil.K0nc])
            return np.log(equivalent_pressures(stress + shift, soil))[..., np.newaxis]
        return (np.log(equivalent_pressures(stress, soil)) + math.log(constants[_OCR]))[..., np.newaxis]

    def log_time_scale(self, stress: FloatArray, state: FloatArray, constants: FloatArray) -> FloatArray | None:
        """ln of tau (p_eq/p_p)^-beta: the time that creep takes to slow down."""
        soil = creep_constants(constants)
        beta = (soil.lambda_star - soil.kappa_star) / soil.mu_star
        ratio = np.log(equivalent_pressures(stress, soil)) - state[..., 0]
        scale: FloatArray = math.log(soil.tau) - beta * ratio
        return scale

    def elastic_moduli(self, constants: FloatArray, p: float) -> tuple[float, float]:
        """K = (p + a)/kappa*."""
        soil = creep_constants(constants)
        bulk = max(p + soil.shift, soil.pressure_floor) / soil.kappa_star
        return bulk, soil.shear_ratio * bulk

    def state_weights(self, constants: FloatArray) -> FloatArray:
        """Creep strain of a unit of ln p_p."""
        return np.array([constants[0] - constants[1]])


def creep_soil(
    parameters: Mapping[str, float], formulation: Formulation, tension_cutoff: float | None
) -> SoftSoilCreep:
    """Constants of the kernels from parameters by name.

    Raises
    ------
    InfeasibleError
        A value is outside what the law admits.
    """
    return soft_soil_creep(
        parameters["lambda_star"],
        parameters["kappa_star"],
        parameters["mu_star"],
        parameters["c"],
        parameters["phi"],
        parameters.get("psi", 0.0),
        parameters.get("nu_ur", 0.15),
        parameters.get("K0nc") or None,
        parameters.get("M") or None,
        formulation=formulation,
        tension_cutoff=tension_cutoff,
    )


def creep_constants(constants: FloatArray) -> SoftSoilCreep:
    """The constants as the kernels take them."""
    return SoftSoilCreep(*constants[:_OCR].tolist())


def equivalent_pressures(stress: FloatArray, soil: SoftSoilCreep) -> FloatArray:
    """Equivalent pressure p_eq, kPa, of stresses (..., 4 or 6), compression positive."""
    p, q2 = mean_and_squared_q(stress)
    x = np.maximum(p + soil.shift, soil.pressure_floor)
    pressure: FloatArray = x + q2 / (soil.M**2 * (x + soil.extra))
    return pressure


class SoftSoilLaw(SoftSoilCreepLaw):
    """Soft soil (Brinkgreve 1994; Vermeer & Neher 1999 without creep); constants as of soft soil creep with mu* = 0."""

    kind: ClassVar[str] = "soft_soil"
    title: ClassVar[str] = "soft soil"
    parameters: ClassVar[tuple[ParameterInfo, ...]] = tuple(info for info in PARAMETERS if info.name != "mu_star")
    terms: ClassVar[tuple[Term, ...]] = SOFT_SOIL_TERMS

    def kernel_constants(
        self, given: Mapping[str, float], formulation: Formulation, tension_cutoff: float | None
    ) -> SoftSoilCreep:
        """Constants of the kernels from parameters by name; raises as :meth:`constants`."""
        return soft_soil(
            given["lambda_star"],
            given["kappa_star"],
            given["c"],
            given["phi"],
            given.get("psi", 0.0),
            given.get("nu_ur", 0.15),
            given.get("K0nc") or None,
            given.get("M") or None,
            formulation=formulation,
            tension_cutoff=tension_cutoff,
        )

    @property
    def depends_on_time(self) -> bool:
        """Time has no effect."""
        return False

    def log_time_scale(self, stress: FloatArray, state: FloatArray, constants: FloatArray) -> None:
        """Time has no effect."""
        del stress, state, constants
