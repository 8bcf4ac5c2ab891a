"""Soil parameters that the forward models of laboratory tests share, and what is admissible about them."""

from __future__ import annotations

import math
from collections.abc import Mapping

from geoswarm.solver.constitutive.soft_soil_creep import Formulation, SoftSoilCreep, friction_constant, soft_soil_creep
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.forward.base import ParameterInfo

__all__ = ["inadmissible_soil", "soil_from", "soil_parameters"]


def soil_parameters(OCR: float = 1.0, POP: float = 0.0) -> tuple[ParameterInfo, ...]:
    """Parameters of soft soil creep; ``OCR`` and ``POP`` are the defaults of the two parameters of that name.

    K0nc and M have the default 0, which stands for "derived": K0nc = 1 - sin(phi), M from K0nc.
    """
    return (
        ParameterInfo(
            "lambda_star",
            "λ*",
            "",
            "Modified compression index, slope of normal compression over ln(stress); above kappa_star.",
            lower=0.0,
            lower_open=True,
            typical=(0.01, 0.3),
        ),
        ParameterInfo(
            "kappa_star",
            "κ*",
            "",
            "Modified swelling index, slope of unloading and reloading over ln(stress).",
            lower=0.0,
            lower_open=True,
            typical=(0.002, 0.1),
        ),
        ParameterInfo(
            "mu_star",
            "μ*",
            "",
            "Modified creep index, creep strain over ln(time).",
            lower=0.0,
            lower_open=True,
            typical=(1.0e-4, 0.02),
        ),
        ParameterInfo("c", "c", "kPa", "Effective cohesion.", lower=0.0, typical=(0.0, 50.0)),
        ParameterInfo(
            "phi",
            "φ",
            "degree",
            "Effective friction angle; 0 is refused.",
            lower=0.0,
            upper=90.0,
            lower_open=True,
            upper_open=True,
            typical=(15.0, 35.0),
        ),
        ParameterInfo(
            "psi", "ψ", "degree", "Dilatancy angle, at most phi.", default=0.0, lower=0.0, upper=90.0, upper_open=True
        ),
        ParameterInfo(
            "nu_ur",
            "ν_ur",
            "",
            "Poisson's ratio for unloading and reloading.",
            default=0.15,
            lower=0.0,
            upper=0.5,
            upper_open=True,
            typical=(0.1, 0.2),
        ),
        ParameterInfo(
            "K0nc",
            "K₀ⁿᶜ",
            "",
            "Stress ratio of normally consolidated one-dimensional compression; 0: derived, 1 - sin(phi).",
            default=0.0,
            lower=0.0,
            upper=1.0,
            upper_open=True,
            typical=(0.4, 0.8),
        ),
        ParameterInfo(
            "M",
            "M",
            "",
            "Slope q/p of the tops of the equivalent pressure ellipses; 0: derived from K0nc.",
            default=0.0,
            lower=0.0,
            typical=(0.8, 1.8),
        ),
        ParameterInfo(
            "OCR",
            "OCR",
            "",
            "Initial overconsolidation ratio p_p/p_eq of the model; without cohesion that of the vertical stress. "
            "Translated, both hold a = c cot(phi): with p = a = 20 kPa, OCR = 2 is a preconsolidation stress of "
            "2 (p + a) - a = 60 kPa. POP counts stresses as they are.",
            default=OCR,
            lower=1.0,
            typical=(1.0, 4.0),
        ),
        ParameterInfo(
            "POP",
            "POP",
            "kPa",
            "Initial pre-overburden pressure: preconsolidation stress minus initial stress; not together with OCR.",
            default=POP,
            lower=0.0,
            typical=(0.0, 50.0),
        ),
    )


def _range(info: ParameterInfo) -> str:
    lower = "" if info.lower is None else f"{'above' if info.lower_open else 'at least'} {info.lower:g}"
    upper = "" if info.upper is None else f"{'below' if info.upper_open else 'at most'} {info.upper:g}"
    return " and ".join(part for part in (lower, upper) if part)


def inadmissible_soil(infos: tuple[ParameterInfo, ...], parameters: Mapping[str, float]) -> str | None:
    """What is inadmissible about these values, in words, or None.

    ``parameters`` may be a subset of ``infos``; then only what is already decided by it is judged.
    """
    for info in infos:
        value = parameters.get(info.name)
        if value is None:
            continue
        if info.name == "phi" and value == 0.0:
            return "phi = 0 degree: soft soil creep needs friction; a value above 0 and below 90 degree is accepted"
        below = info.lower is not None and (value < info.lower or (info.lower_open and value == info.lower))
        above = info.upper is not None and (value > info.upper or (info.upper_open and value == info.upper))
        if below or above or not math.isfinite(value):
            unit = f" {info.unit}" if info.unit else ""
            return f"{info.name} = {value:g}{unit}: {_range(info) or 'a finite value'} is accepted"
    return _contradiction(infos, parameters)


def _contradiction(infos: tuple[ParameterInfo, ...], parameters: Mapping[str, float]) -> str | None:
    defaults = {info.name: info.default for info in infos if info.default is not None}
    values = {**defaults, **parameters}
    stiff, soft = values.get("lambda_star"), values.get("kappa_star")
    if stiff is not None and soft is not None and not stiff > soft:
        return f"lambda_star = {stiff:g} with kappa_star = {soft:g}: lambda_star above kappa_star is accepted"
    phi, psi, K0nc, M = values.get("phi"), values["psi"], values["K0nc"], values["M"]
    if phi is not None and psi > phi:
        return f"psi = {psi:g} degree with phi = {phi:g} degree: psi at most phi is accepted"
    if K0nc > 0.0 and M > 0.0:
        return f"K0nc = {K0nc:g} and M = {M:g} are both given; one of them is accepted, the other follows from it"
    if values["OCR"] != 1.0 and values["POP"] != 0.0:
        return f"OCR = {values['OCR']:g} and POP = {values['POP']:g} kPa are both given; one of them is accepted"
    if M == 0.0 and stiff is not None and soft is not None and (phi is not None or K0nc > 0.0):
        ratio = K0nc if K0nc > 0.0 or phi is None else 1.0 - math.sin(math.radians(phi))
        try:
            friction_constant(ratio, values["nu_ur"], stiff / soft)
        except InfeasibleError as error:
            return str(error)
    return None


def soil_from(parameters: Mapping[str, float], formulation: Formulation, tension_cutoff: float | None) -> SoftSoilCreep:
    """Constants of the soil of one forward calculation.

    Raises
    ------
    InfeasibleError
        A value is outside what the material admits.
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
