"""Hypoplasticity of clay as a law; equations: :mod:`geoswarm.solver.constitutive.hypoplasticity.clay`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.hypoplasticity.clay import SHAPE
from geoswarm.solver.constitutive.hypoplasticity.step import CLAY, FIRST
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Law, StateTensor, StateVariable
from geoswarm.solver.laws.binary import NumbaUpdate
from geoswarm.solver.laws.hypoplasticity.shared import (
    HYPOPLASTIC_STATE,
    HYPOPLASTIC_TENSORS,
    INTERGRANULAR,
    LEAST_PRESSURE,
    SHIFT,
    first_of,
    hypoplastic_step,
    hypoplastic_weights,
    intergranular_contradiction,
    mobilised_friction,
    placed,
    shared_constants,
    strength_ratio,
)
from geoswarm.solver.laws.sources import BJERRUM, MASIN, TERZAGHI
from geoswarm.solver.laws.terms import CRITICAL_FRICTION, LN10, Term
from geoswarm.solver.laws.usual_parameters import critical_friction
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["HypoplasticClay"]

_E0, _OCR = FIRST + 9, FIRST + 10
"""Where the constants hold the initial void ratio and OCR, after those of the kernels."""

_CC = Term(
    "Cc",
    "",
    "compression index",
    "lambda_star",
    "2.303 λ* (1 + e₀), about: λ* is of ln(1 + e)",
    lambda known: LN10 * known["lambda_star"] * (1.0 + known["e_0"]),
    lambda value, known: value / (LN10 * (1.0 + known["e_0"])),
    voids=True,
)

_PARAMETERS = (
    critical_friction(18.0, 35.0, MASIN),
    ParameterInfo(
        "lambda_star",
        "λ*",
        "",
        "Slope of normal compression, ln(1 + e) over ln(p); above kappa_star.",
        lower=0.0,
        lower_open=True,
        typical=(0.03, 0.15),
        source=MASIN,
    ),
    ParameterInfo(
        "kappa_star",
        "κ*",
        "",
        "Slope of isotropic unloading from the normally consolidated state, ln(1 + e) over ln(p).",
        lower=0.0,
        lower_open=True,
        typical=(0.004, 0.03),
        source=MASIN,
    ),
    ParameterInfo(
        "N",
        "N",
        "",
        "ln(1 + e) of isotropic normal compression at p = 1 kPa.",
        lower=0.0,
        lower_open=True,
        typical=(0.6, 2.0),
        source=MASIN,
    ),
    ParameterInfo(
        "nu",
        "ν",
        "",
        "Ratio of bulk and shear stiffness, as Poisson's ratio of the linear part L.",
        lower=0.0,
        upper=0.5,
        upper_open=True,
        typical=(0.1, 0.4),
        source=MASIN,
    ),
    ParameterInfo(
        "OCR",
        "OCR",
        "",
        "Initial overconsolidation ratio: mean stress on the state boundary, at the same stress ratio and void ratio, "
        "over that of the soil; not together with e0.",
        default=1.0,
        lower=1.0,
        typical=(1.0, 8.0),
        source=BJERRUM,
    ),
    ParameterInfo(
        "e0",
        "e₀",
        "",
        "Initial void ratio under the initial stress; 0: derived from OCR.",
        default=0.0,
        lower=0.0,
        typical=(0.4, 3.0),
        source=f"{TERZAGHI}, table 6.3",
    ),
    SHIFT,
    *INTERGRANULAR,
)


class HypoplasticClay(Law):
    """Hypoplasticity for clay.

    Constants: those that hypoplastic laws share, f_s/tr(sigma), nu/(1 - 2 nu), lambda*, N, alpha, sin(phi_c), omega at
    phi_c, xi, sin^xi(phi_c), e0 (0: derived) and OCR.

    Examples
    --------
    >>> london = {"phi_c": 21.9, "lambda_star": 0.095, "kappa_star": 0.015, "N": 1.19, "nu": 0.1}
    >>> soil = HypoplasticClay().soil({**london, "OCR": 2})
    """

    kind: ClassVar[str] = "hypoplastic_clay"
    title: ClassVar[str] = "hypoplasticity of clay"
    parameters: ClassVar[tuple[ParameterInfo, ...]] = _PARAMETERS
    terms: ClassVar[tuple[Term, ...]] = (_CC, CRITICAL_FRICTION)
    derived: ClassVar[frozenset[str]] = frozenset({"e0"})
    instead_of_e0: ClassVar[frozenset[str]] = frozenset({"OCR"})
    state: ClassVar[tuple[StateVariable, ...]] = HYPOPLASTIC_STATE
    tensors: ClassVar[tuple[StateTensor, ...]] = HYPOPLASTIC_TENSORS
    update: ClassVar[NumbaUpdate] = hypoplastic_step

    def contradiction(self, values: Mapping[str, float]) -> str | None:
        """Slopes that do not fit together, both e0 and OCR, or parameters of the intergranular strain."""
        soft, stiff, phi = values.get("lambda_star"), values.get("kappa_star"), values.get("phi_c")
        if soft is not None and stiff is not None:
            if not stiff < soft:
                return f"kappa_star must be below lambda_star = {soft:g}, got {stiff:g}"
            if phi is not None and not stiff < (most := _largest_kappa(soft, phi)):
                return (
                    f"kappa_star must be below {most:.6g} with lambda_star = {soft:g} and "
                    f"phi_c = {phi:g} degree, got {stiff:g}"
                )
        if values.get("e0", 0.0) > 0.0 and values.get("OCR", 1.0) != 1.0:
            return f"e0 = {values['e0']:g} and OCR = {values['OCR']:g} are both given; give only one of them"
        return intergranular_contradiction(values)

    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        """Those that the class names."""
        soft, stiff, nu = given["lambda_star"], given["kappa_star"], given["nu"]
        sine = math.sin(math.radians(given["phi_c"]))
        own = [
            0.5 * (1.0 / soft + 1.0 / stiff) * (1.0 - 2.0 * nu) / (1.0 + nu),
            nu / (1.0 - 2.0 * nu),
            soft,
            given["N"],
            math.log2((soft - stiff) / (soft + stiff) * strength_ratio(sine)),
            sine,
            -math.log2(1.0 - sine * sine),
            1.7 + 3.9 * sine * sine,
            sine ** (1.7 + 3.9 * sine * sine),
        ]
        return np.array([*shared_constants(CLAY, given), *own, given["e0"], given["OCR"]])

    def K0(self, constants: FloatArray) -> float:
        """That of normal one-dimensional compression: where s + zeta 1 has no lateral component."""
        sine, xi, power = constants[[FIRST + 5, FIRST + 7, FIRST + 8]].tolist()
        low, high = 0.0, sine
        for _ in range(60):
            mobilised = 0.5 * (low + high)
            if mobilised / (3.0 - mobilised) < (power - mobilised**xi) / (1.0 - power):
                low = mobilised
            else:
                high = mobilised
        return (1.0 - low) / (1.0 + low)

    def initial_state(self, stress: FloatArray, constants: FloatArray) -> FloatArray:
        """The void ratio given, or that of OCR; no intergranular strain.

        Raises
        ------
        InfeasibleError
            The stress is tensile, or the void ratio negative or above that of the state boundary under the stress.
        """
        shift, soft, N, sine, omega = constants[[1, FIRST + 2, FIRST + 3, FIRST + 5, FIRST + 6]].tolist()
        p = stress[..., :3].mean(axis=-1) + shift
        friction = np.sin(np.radians(mobilised_friction(stress, shift))) ** 2
        wrong = ~((p > 0.0) & (friction < 1.0))
        if wrong.any():
            at = first_of(wrong)
            raise InfeasibleError(
                f"initial stress with a mean of {p[at] - shift:g} kPa and a mobilised friction angle of "
                f"{math.degrees(math.asin(math.sqrt(friction[at]))):g} degree: {self.title} accepts compression only"
            )
        boundary = p * (1.0 - friction) ** (-1.0 / (omega + SHAPE * (friction - sine * sine)))
        most = np.exp(N - soft * np.log(boundary)) - 1.0
        if constants[_E0] > 0.0:
            e = np.full(p.shape, constants[_E0])
            wrong = e > most + 1.0e-9
            name = "e0"
        else:
            e = np.exp(N - soft * np.log(constants[_OCR] * boundary)) - 1.0
            wrong, name = e <= 0.0, f"OCR = {constants[_OCR]:g} gives a void ratio"
        if wrong.any():
            at = first_of(wrong)
            raise InfeasibleError(
                f"{name} = {e[at]:g} under a mean stress of {p[at] - shift:g} kPa; it must be above 0 and at most "
                f"{most[at]:.6g}, that of normal consolidation"
            )
        return placed(stress, e, shift)

    def elastic_moduli(self, constants: FloatArray, p: float) -> tuple[float, float]:
        """Those of the linear part L."""
        f_s = 3.0 * float(constants[FIRST]) * max(p + float(constants[1]), LEAST_PRESSURE)
        return f_s * (1.0 / 3.0 + float(constants[FIRST + 1])), 0.5 * f_s

    def state_weights(self, constants: FloatArray) -> FloatArray:
        """Strain of a unit of void ratio; what intergranular strain does to stiffness, at most."""
        return hypoplastic_weights(constants)


def _largest_kappa(soft: float, phi: float) -> float:
    """kappa* at which alpha, and with it the influence of density, becomes 0."""
    ratio = strength_ratio(math.sin(math.radians(phi)))
    return soft * (ratio - 1.0) / (ratio + 1.0)
