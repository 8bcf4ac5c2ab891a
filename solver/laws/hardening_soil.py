"""The hardening soil model as a law: the physics is in :mod:`geoswarm.solver.constitutive.hardening_soil.surfaces`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, Final

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.hardening_soil.step import hardening_soil_step
from geoswarm.solver.constitutive.hardening_soil.surfaces import (
    LEAST_STIFF,
    HardeningSoil,
    hardening_soil_of,
    shear_strain,
)
from geoswarm.solver.constitutive.local_arrays import local_vector
from geoswarm.solver.constitutive.tensors import principal_axes
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Law, Setting, StateVariable, StrengthPlaces
from geoswarm.solver.laws.binary import NumbaUpdate, carray
from geoswarm.solver.laws.hardening_soil_terms import HARDENING_SOIL_TERMS
from geoswarm.solver.laws.perfect_plasticity.mohr_coulomb import TENSION_CUTOFF
from geoswarm.solver.laws.sources import BRINKGREVE_SAND, DUNCAN, PLAXIS, TERZAGHI, VON_SOOS
from geoswarm.solver.laws.terms import Term
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

__all__ = ["HardeningSoilLaw", "cap_constants"]

_NOTICED: Final = 1.0e-9
_COHESION, _SINE, _COSINE, _DILATANCY = 5, 6, 7, 8
_TENSION, _ALPHA, _HARDENING, _K0, _OCR, _POP = 10, 12, 13, 14, 15, 16
"""Places of the constants."""


def _modulus(name: str, symbol: str, meaning: str, typical: tuple[float, float]) -> ParameterInfo:
    return ParameterInfo(
        name, symbol, "kPa", meaning, lower=0.0, lower_open=True, typical=typical, source=BRINKGREVE_SAND
    )


_PARAMETERS = (
    _modulus(
        "E50_ref",
        "E₅₀ʳᵉᶠ",
        "Secant modulus at half the strength of a drained triaxial test with the cell pressure p_ref.",
        (4.0e3, 6.0e4),
    ),
    _modulus(
        "Eoed_ref",
        "E_oedʳᵉᶠ",
        "Tangent modulus of normally consolidated one-dimensional compression at the vertical stress p_ref.",
        (4.0e3, 6.0e4),
    ),
    _modulus(
        "Eur_ref",
        "E_urʳᵉᶠ",
        "Modulus of unloading and reloading at the minor principal stress p_ref; above 2 E50_ref/(2 - R_f).",
        (1.2e4, 1.8e5),
    ),
    ParameterInfo(
        "m",
        "m",
        "",
        "Power of stress in all stiffnesses.",
        lower=0.0,
        upper=1.0,
        typical=(0.4, 1.0),
        source=VON_SOOS,
    ),
    unloading_poisson(0.2, 0.1, 0.3),
    ParameterInfo(
        "p_ref",
        "p_ref",
        "kPa",
        "Reference stress of the stiffnesses.",
        default=100.0,
        lower=0.0,
        lower_open=True,
        typical=(50.0, 200.0),
        source=f"{PLAXIS}: 100 kPa",
    ),
    cohesion(30.0),
    angle(
        "phi",
        "φ",
        "Effective friction angle.",
        (20.0, 42.0),
        f"{TERZAGHI}, article 19 (clays to dense sands)",
        lower_open=True,
    ),
    replace(DILATANCY, description="Dilatancy angle at failure, at most phi."),
    ParameterInfo(
        "R_f",
        "R_f",
        "",
        "Failure ratio q_f/q_a: strength over the asymptote of the hyperbola.",
        default=0.9,
        lower=0.0,
        upper=1.0,
        lower_open=True,
        upper_open=True,
        typical=(0.75, 0.95),
        source=DUNCAN,
    ),
    normal_K0(0.35, 0.7),
    overconsolidation("Initial overconsolidation ratio (p_p + a)/(p_eq + a) of the model, a = c cot(phi)."),
    pre_overburden(100.0),
)


@NumbaUpdate
def _update(components, _log_time, strain, stress, state, constants, new_stress, new_state, tangent):  # type: ignore[no-untyped-def]  # pointers
    soil = hardening_soil_of(carray(constants, 14))
    old, step = carray(stress, components), carray(strain, components)
    new, C = carray(new_stress, components), carray(tangent, (components, components))
    unused = local_vector(6)
    new_state[0], new_state[1], status = hardening_soil_step(old, step, state[0], state[1], soil, new, C, unused)
    return status


class HardeningSoilLaw(Law):
    """Hardening soil (Schanz, Vermeer & Bonnier 1999).

    Constants: E_i, Eur_ref, m, nu_ur, p_ref, c, sin(phi), cos(phi), sin(psi), R_f, tension cut-off, whether shear
    contracts, alpha, H, K0nc, OCR and POP.

    Examples
    --------
    >>> stiffness = {"E50_ref": 3.0e4, "Eoed_ref": 3.0e4, "Eur_ref": 9.0e4, "m": 0.5}
    >>> soil = HardeningSoilLaw().soil({**stiffness, "c": 0.0, "phi": 33.0, "psi": 3.0})
    """

    kind: ClassVar[str] = "hardening_soil"
    title: ClassVar[str] = "hardening soil"
    parameters: ClassVar[tuple[ParameterInfo, ...]] = _PARAMETERS
    terms: ClassVar[tuple[Term, ...]] = HARDENING_SOIL_TERMS
    derived: ClassVar[frozenset[str]] = frozenset({"K0nc"})
    settings: ClassVar[tuple[Setting, ...]] = (
        Setting(
            "contraction",
            "Below the friction angle of the critical state plastic shear keeps its volume (none), or contracts by "
            "Rowe's equation (rowe).",
            "none",
            choices=("none", "rowe"),
        ),
        TENSION_CUTOFF,
    )
    state: ClassVar[tuple[StateVariable, ...]] = (
        StateVariable("gamma_p", "γᵖ", "", "Plastic shear strain of the shear surface."),
        StateVariable("p_p", "p_p", "kPa", "Preconsolidation pressure: where the cap meets the p axis."),
    )
    update: ClassVar[NumbaUpdate] = _update
    strength: ClassVar[StrengthPlaces | None] = StrengthPlaces(_COHESION, _SINE, _COSINE, _DILATANCY, _TENSION)
    perfectly_plastic: ClassVar[bool] = True

    def contradiction(self, values: Mapping[str, float]) -> str | None:
        """Stiffnesses, angles, K0nc, or OCR and POP that do not fit together."""
        defaults = {info.name: info.default for info in self.parameters if info.default is not None}
        known = {**defaults, **values}
        E50, unloading, phi, psi = known.get("E50_ref"), known.get("Eur_ref"), known.get("phi"), known["psi"]
        if E50 is not None and unloading is not None:
            least = 2.0 * E50 / (2.0 - known["R_f"])
            if not unloading > least:
                return (
                    f"Eur_ref must be above 2 E50_ref/(2 - R_f) = {least:g} kPa with E50_ref = {E50:g} kPa, "
                    f"got {unloading:g} kPa"
                )
        return too_dilatant(phi, psi) or two_pasts(known["OCR"], known["POP"])

    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        """Those that the class names."""
        phi, psi = math.radians(given["phi"]), math.radians(given["psi"])
        tension = math.inf if given["tension_cutoff"] is None else given["tension_cutoff"]
        c = np.array(
            [
                2.0 * given["E50_ref"] / (2.0 - given["R_f"]),
                given["Eur_ref"],
                given["m"],
                given["nu_ur"],
                given["p_ref"],
                given["c"],
                math.sin(phi),
                math.cos(phi),
                math.sin(psi),
                given["R_f"],
                tension,
                1.0 if given["contraction"] == "rowe" else 0.0,
                1.0,
                1.0,
                given["K0nc"] or 1.0 - math.sin(phi),
                given["OCR"],
                given["POP"],
            ]
        )
        c[_ALPHA], c[_HARDENING] = cap_constants(hardening_soil_of(c), given["p_ref"], float(c[_K0]), given["Eoed_ref"])
        return c

    def K0(self, constants: FloatArray) -> float:
        """K0nc."""
        return float(constants[_K0])

    def initial_state(self, stress: FloatArray, constants: FloatArray) -> FloatArray:
        """Both surfaces pass through the stress, or where it is larger, through that of the past.

        The stress of the past has OCR times the distance from the tip of the cone, or the vertical stress raised by
        POP and the horizontal by K0nc POP.

        Raises
        ------
        InfeasibleError
            A stress is beyond the strength.
        """
        soil = hardening_soil_of(constants)
        general = np.zeros((*stress.shape[:-1], 6))
        general[..., : stress.shape[-1]] = stress
        normal = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        shift = np.array([constants[_K0], 1.0, constants[_K0], 0.0, 0.0, 0.0]) * constants[_POP]
        past = (general + soil.attraction * normal) * constants[_OCR] - soil.attraction * normal + shift
        rows = []
        for now, before in zip(general.reshape(-1, 6), past.reshape(-1, 6), strict=True):
            values = principal_axes(now)[0]
            size = abs(values[0]) + abs(values[2]) + soil.attraction
            excess = values[0] - values[2] - soil.strength * (values[2] + soil.attraction)
            if excess > _NOTICED * size or -values[2] > soil.tension + _NOTICED * size:
                found = ", ".join(f"{value:g}" for value in values.tolist())
                raise InfeasibleError(f"initial principal stresses {found} kPa violate the strength; give others")
            both = [_surfaces(values, soil), _surfaces(principal_axes(before)[0], soil)]
            rows.append(np.maximum(*both))
        return np.reshape(rows, (*stress.shape[:-1], 2))

    def elastic_moduli(self, constants: FloatArray, p: float) -> tuple[float, float]:
        """Those of E_ur where p is the minor principal stress."""
        soil = hardening_soil_of(constants)
        young = soil.unloading * (max(p + soil.attraction, LEAST_STIFF) / soil.reference) ** soil.power
        return young / (3.0 * (1.0 - 2.0 * soil.poisson)), young / (2.0 * (1.0 + soil.poisson))

    def state_weights(self, constants: FloatArray) -> FloatArray:
        """Of gamma one; of p_p none: its error is that of plastic strain."""
        del constants
        return np.array([1.0, 0.0])


def _surfaces(values: FloatArray, soil: HardeningSoil) -> FloatArray:
    """gamma and p_p, kPa, of surfaces through sorted principal stresses (3,)."""
    q = min(float(values[0] - values[2]), soil.strength * max(float(values[2]) + soil.attraction, 0.0))
    along = float(values[0] + (soil.delta - 1.0) * values[1] - soil.delta * values[2]) / soil.alpha
    return np.array(
        [
            shear_strain(q, float(values[2]), soil),
            math.hypot(along, float(values.mean()) + soil.attraction) - soil.attraction,
        ]
    )


def cap_constants(soil: HardeningSoil, p_ref: float, K0nc: float, Eoed: float) -> tuple[float, float]:
    """alpha and H, kPa, with which one-dimensional compression has K0nc and Eoed at the vertical stress p_ref.

    Both surfaces are active there. Stress rates Eoed (1, K0nc, K0nc) for a unit axial strain rate, elasticity and the
    shear surface give elastic strain and that of shear; what is left is that of the cap, whose direction is q/(alpha^2
    (p + a)) and whose size gives H: no iteration. ``alpha`` and ``hardening`` of ``soil`` are not read.

    Raises
    ------
    InfeasibleError
        No cap has both.
    """
    a, ratio, power = soil.attraction, soil.failure_ratio, soil.power
    major, minor = p_ref, K0nc * p_ref
    q, p, largest = major - minor, (major + 2.0 * minor) / 3.0, soil.strength * (minor + a)
    if not q < largest:
        lowest = max((p_ref - soil.strength * a) / (1.0 + soil.strength), 0.0) / p_ref
        raise InfeasibleError(f"K0nc must be above {lowest:g}, which the strength allows, got {K0nc:g}")
    stiff = ((minor + a) / soil.reference) ** power
    d_major, d_minor = Eoed, K0nc * Eoed
    y = q * ratio / largest
    curve = 2.0 / (soil.initial * (1.0 - y) ** 2)
    gamma = shear_strain(q, minor, soil)
    by_q = (curve - 2.0 / soil.unloading) / stiff
    by_minor = -(power * gamma + curve / stiff * q * y) / (minor + a)
    shear = max(by_q * (d_major - d_minor) + by_minor * d_minor, 0.0)
    mobilised = q / (major + minor + 2.0 * a)
    sine = max((mobilised - soil.sin_cs) / (1.0 - mobilised * soil.sin_cs), soil.least_dilatancy)
    young, poisson = soil.unloading * stiff, soil.poisson
    axial = 1.0 - (d_major - 2.0 * poisson * d_minor) / young - 0.5 * (1.0 - sine) * shear
    radial = -((1.0 - poisson) * d_minor - poisson * d_major) / young + 0.25 * (1.0 + sine) * shear
    volume, distortion = axial + 2.0 * radial, 2.0 / 3.0 * (axial - radial)
    if not volume > 0.0:
        raise InfeasibleError(
            f"Eoed_ref = {Eoed:g} kPa with K0nc = {K0nc:g}: elasticity and shear alone are softer or compress as much; "
            "lower Eoed_ref or raise Eur_ref"
        )
    if not distortion > 0.0:
        raise InfeasibleError(
            f"K0nc = {K0nc:g} with Eoed_ref = {Eoed:g} kPa: shear of E50_ref alone distorts more; raise K0nc or "
            "E50_ref, or lower Eoed_ref"
        )
    square = q * volume / ((p + a) * distortion)
    past = math.sqrt(q * q / square + (p + a) ** 2)
    rate = (q * (d_major - d_minor) / square + (p + a) * (d_major + 2.0 * d_minor) / 3.0) / past
    return math.sqrt(square), rate / (volume * (past / soil.reference) ** power)
