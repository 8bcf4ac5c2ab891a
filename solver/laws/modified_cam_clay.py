"""Modified Cam clay as a law: the physics is in :mod:`geoswarm.solver.constitutive.cam_clay`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.cam_clay import cam_clay_step
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Law, Setting, StateVariable, mean_and_squared_q
from geoswarm.solver.laws.binary import NumbaUpdate, carray
from geoswarm.solver.laws.sources import BOWLES, KULHAWY, SCHOFIELD, TERZAGHI, WOOD
from geoswarm.solver.laws.terms import LN10, Term, oedometric, same
from geoswarm.solver.laws.usual_parameters import angle, overconsolidation, pre_overburden
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["ModifiedCamClay"]

_M, _LAMBDA, _KAPPA, _RATIO, _G, _E0, _N, _VOLUME, _OCR, _POP, _PC = range(11)
"""Places of the constants; _RATIO is G/K of a constant nu, or 0."""

_EITHER = (("M", "phi_cs"), ("nu", "G"), ("e0", "N"))
_LEAST_PRESSURE = 1.0e-3
"""kPa: below it stiffness is only asked for to judge errors."""

_TERMS = (
    Term(
        "Cc",
        "",
        "compression index",
        "lambda",
        "2.303 λ",
        lambda known: LN10 * known["lambda"],
        lambda value, _known: value / LN10,
    ),
    Term(
        "Cs",
        "",
        "swelling index",
        "kappa",
        "2.303 κ (1 + ν)/(3 (1 − ν)), about",
        lambda known: LN10 * known["kappa"] * oedometric(known.get("nu") or 0.25, known),
        lambda value, known: value / (LN10 * oedometric(known.get("nu") or 0.25, known)),
    ),
    Term(
        "φ_cs",
        "degree",
        "friction angle of the critical state",
        "M",
        "sin φ = 3 M/(6 + M)",
        lambda known: math.degrees(math.asin(min(3.0 * known["M"] / (6.0 + known["M"]), 1.0))),
        lambda value, _known: 6.0 * math.sin(math.radians(value)) / (3.0 - math.sin(math.radians(value))),
    ),
    same("φ_cs", "degree", "friction angle of the critical state", "phi_cs"),
    same("e₀", "", "void ratio before the test", "e0"),
)

_PARAMETERS = (
    ParameterInfo(
        "M",
        "M",
        "",
        "Slope q/p of the critical state line; or give phi_cs.",
        default=0.0,
        lower=0.0,
        typical=(0.7, 1.6),
        source=f"{WOOD}: 6 sin(phi)/(3 - sin(phi))",
    ),
    angle(
        "phi_cs",
        "φ_cs",
        "Friction angle of the critical state in triaxial compression, M = 6 sin(phi)/(3 - sin(phi)); or give M.",
        (18.0, 40.0),
        WOOD,
        default=0.0,
    ),
    ParameterInfo(
        "lambda",
        "λ",
        "",
        "Slope of the normal compression line, void ratio over ln(mean stress); above kappa.",
        lower=0.0,
        lower_open=True,
        typical=(0.05, 0.5),
        source=SCHOFIELD,
    ),
    ParameterInfo(
        "kappa",
        "κ",
        "",
        "Slope of unloading and reloading lines, void ratio over ln(mean stress).",
        lower=0.0,
        lower_open=True,
        typical=(0.005, 0.1),
        source=SCHOFIELD,
    ),
    ParameterInfo(
        "nu",
        "ν",
        "",
        "Poisson's ratio, constant; or give G.",
        default=0.0,
        lower=0.0,
        upper=0.5,
        upper_open=True,
        typical=(0.15, 0.35),
        source=KULHAWY,
    ),
    ParameterInfo(
        "G",
        "G",
        "kPa",
        "Shear modulus, constant, Poisson's ratio then changes with the mean stress; or give nu.",
        default=0.0,
        lower=0.0,
        typical=(1.0e3, 3.0e4),
        source=f"E/(2 (1 + nu)) of soft to hard clay; {BOWLES}",
    ),
    ParameterInfo(
        "e0",
        "e₀",
        "",
        "Void ratio where the soil is placed; or give N.",
        default=0.0,
        lower=0.0,
        typical=(0.4, 2.5),
        source=f"{TERZAGHI}, table 6.3",
    ),
    ParameterInfo(
        "N",
        "N",
        "",
        "Specific volume 1 + e on the isotropic normal compression line at 1 kPa; or give e0.",
        default=0.0,
        lower=0.0,
        typical=(1.5, 5.0),
        source=SCHOFIELD,
    ),
    overconsolidation("Initial overconsolidation ratio p_c/(p + q^2/(M^2 p))."),
    pre_overburden(100.0),
    ParameterInfo(
        "p_c",
        "p_c",
        "kPa",
        "Initial preconsolidation pressure, isotropic; 0: from OCR or POP.",
        default=0.0,
        lower=0.0,
        typical=(20.0, 1000.0),
        source="no published range: soft clay at the surface to stiff clay",
    ),
)


@NumbaUpdate
def _update(components, _log_time, strain, stress, state, constants, new_stress, new_state, tangent):  # type: ignore[no-untyped-def]  # pointers
    c = constants
    old, step = carray(stress, components), carray(strain, components)
    new, C = carray(new_stress, components), carray(tangent, (components, components))
    new_state[0], new_state[1], status = cam_clay_step(
        old, step, state[0], state[1], c[0], c[1], c[2], c[3], c[4], c[7], new, C
    )
    return status


class ModifiedCamClay(Law):
    """Modified Cam clay of Roscoe & Burland (1968).

    Constants: M, lambda, kappa, G/K (0: constant G), G, e0, N (one of both is 0), the specific volume in
    compressibilities (0: the present one), OCR, POP and p_c.
    """

    kind: ClassVar[str] = "modified_cam_clay"
    title: ClassVar[str] = "modified Cam clay"
    parameters: ClassVar[tuple[ParameterInfo, ...]] = _PARAMETERS
    terms: ClassVar[tuple[Term, ...]] = _TERMS
    derived: ClassVar[frozenset[str]] = frozenset({"M", "phi_cs", "nu", "G", "e0", "N", "p_c"})
    instead_of_e0: ClassVar[frozenset[str]] = frozenset({"N"})
    settings: ClassVar[tuple[Setting, ...]] = (
        Setting(
            "specific_volume",
            "Whether 1 + e in compressibilities is the present one, as strains are logarithmic, or stays 1 + e0.",
            "present",
            choices=("present", "initial"),
        ),
    )
    state: ClassVar[tuple[StateVariable, ...]] = (
        StateVariable("p_c", "p_c", "kPa", "Preconsolidation pressure, isotropic."),
        StateVariable("e", "e", "", "Void ratio."),
    )
    update: ClassVar[NumbaUpdate] = _update

    def contradiction(self, values: Mapping[str, float]) -> str | None:
        """Both of two that exclude each other, kappa above lambda, or more than one preconsolidation."""
        for one, other in _EITHER:
            if values.get(one, 0.0) > 0.0 and values.get(other, 0.0) > 0.0:
                return f"{one} = {values[one]:g} and {other} = {values[other]:g} are both given; give only one of them"
        stiff, soft = values.get("lambda"), values.get("kappa")
        if stiff is not None and soft is not None and not stiff > soft:
            return f"lambda must be above kappa = {soft:g}, got {stiff:g}"
        past = {"OCR": 1.0, "POP": 0.0, "p_c": 0.0}
        given = [f"{name} = {values[name]:g}" for name, none in past.items() if values.get(name, none) != none]
        return f"{' and '.join(given)} are given; give only one of them" if len(given) > 1 else None

    def incomplete(self, given: frozenset[str]) -> str | None:
        """One of each pair."""
        for one, other in _EITHER:
            if len(given & {one, other}) != 1:
                return f"give exactly one of {one} and {other}"
        return None

    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        """Those that the class names."""
        for one, other in _EITHER:
            if not given[one] and not given[other]:
                raise InfeasibleError(f"give exactly one of {one} and {other}, a value above 0")
        if given["specific_volume"] == "initial" and not given["e0"]:
            raise InfeasibleError("an initial specific volume needs e0; N is not accepted with it")
        sine = math.sin(math.radians(given["phi_cs"]))
        nu = given["nu"]
        return np.array(
            [
                given["M"] if given["M"] else 6.0 * sine / (3.0 - sine),
                given["lambda"],
                given["kappa"],
                0.0 if given["G"] else 1.5 * (1.0 - 2.0 * nu) / (1.0 + nu),
                given["G"],
                given["e0"],
                given["N"],
                1.0 + given["e0"] if given["specific_volume"] == "initial" else 0.0,
                given["OCR"],
                given["POP"],
                given["p_c"],
            ]
        )

    def K0(self, constants: FloatArray) -> float:
        """Of steady one-dimensional compression, normally consolidated.

        With L = 1 - kappa/lambda and constant nu, eta = q/p is the root of (2/3 - eta kappa/(3 lambda G/K)) (M^2 -
        eta^2) = 2 L eta: elastic and plastic strains are those of a constant eta. With constant G there is no steady
        ratio, as elastic shear grows with the stress; that without elastic shear is taken, whose root is (sqrt(9 L^2 +
        4 M^2) - 3 L)/2.
        """
        M, stiff, soft, ratio = (float(one) for one in constants[:4])
        plastic = 1.0 - soft / stiff
        elastic = soft / (3.0 * stiff * ratio) if ratio > 0.0 else 0.0
        eta = 0.5 * (math.sqrt(9.0 * plastic**2 + 4.0 * M**2) - 3.0 * plastic)
        for _ in range(50):  # Newton's method, from above: the cubic is convex there
            rest = (2.0 / 3.0 - elastic * eta) * (M**2 - eta**2) - 2.0 * plastic * eta
            slope = -elastic * (M**2 - eta**2) - 2.0 * eta * (2.0 / 3.0 - elastic * eta) - 2.0 * plastic
            eta -= rest / slope
        return (3.0 - eta) / (3.0 + 2.0 * eta)

    def initial_state(self, stress: FloatArray, constants: FloatArray) -> FloatArray:
        """p_c from OCR, POP (with K0 times it at the sides) or as given, and e from e0 or N.

        Raises
        ------
        InfeasibleError
            A mean stress is not above 0, a stress is beyond p_c, or N gives no void ratio above 0.
        """
        M, stiff, soft = constants[:3].tolist()
        p = stress[..., :3].mean(axis=-1)
        if not (p > 0.0).all():
            raise InfeasibleError(
                f"initial mean stress = {p.min():g} kPa: modified Cam clay needs a value above 0 kPa where it is placed"
            )
        least = _equivalent(stress, M)
        past = constants[_OCR] * least
        if constants[_POP] > 0.0:
            shift = np.zeros(stress.shape[-1])
            K0 = self.K0(constants)
            shift[:3] = constants[_POP] * np.array([K0, 1.0, K0])
            past = np.maximum(_equivalent(stress + shift, M), least)
        elif constants[_PC] > 0.0:
            past = np.full(p.shape, constants[_PC])
            if (past < (1.0 - 1.0e-9) * least).any():
                raise InfeasibleError(
                    "p_c must be at least the equivalent pressure p + q^2/(M^2 p) of the initial stress, "
                    f"{least.max():g} kPa, got {constants[_PC]:g} kPa"
                )
        e = np.full(p.shape, constants[_E0])
        if constants[_N] > 0.0:
            e = constants[_N] - 1.0 - stiff * np.log(past) + soft * np.log(past / p)
            if not (e > 0.0).all():
                raise InfeasibleError(f"N = {constants[_N]:g} gives the void ratio {e.min():g}; give a larger N")
        return np.stack([past, e], axis=-1)

    def elastic_moduli(self, constants: FloatArray, p: float) -> tuple[float, float]:
        """K = (1 + e) p/kappa and G, with e of the initial state or of the normal compression line."""
        pressure = max(p, _LEAST_PRESSURE)
        volume = 1.0 + constants[_E0]
        if constants[_N] > 0.0:
            volume = max(constants[_N] - constants[_LAMBDA] * math.log(pressure), 1.0)
        bulk = float(volume * pressure / constants[_KAPPA])
        return bulk, float(constants[_G] if constants[_G] > 0.0 else constants[_RATIO] * bulk)


def _equivalent(stress: FloatArray, M: float) -> FloatArray:
    """p + q^2/(M^2 p), kPa, of stresses (..., 4 or 6)."""
    p, q2 = mean_and_squared_q(stress)
    pressure: FloatArray = p + q2 / (M**2 * p)
    return pressure
