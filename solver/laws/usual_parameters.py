"""Parameters that several laws have, and what is said where two of them do not fit together."""

from __future__ import annotations

from typing import Any

from geoswarm.solver.laws.sources import BJERRUM, BOLTON, JAKY, MESRI_COHESION, OVERBURDEN, PLAXIS
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = [
    "DILATANCY",
    "angle",
    "cohesion",
    "critical_friction",
    "normal_K0",
    "overconsolidation",
    "pre_overburden",
    "too_dilatant",
    "two_pasts",
    "unloading_poisson",
]


def angle(
    name: str,
    symbol: str,
    description: str,
    typical: tuple[float, float],
    source: str,
    *,
    default: float | None = None,
    lower_open: bool = False,
) -> ParameterInfo:
    """An angle below 90 degree."""
    limits: dict[str, Any] = {"lower": 0.0, "upper": 90.0, "lower_open": lower_open, "upper_open": True}
    return ParameterInfo(name, symbol, "degree", description, default, typical=typical, source=source, **limits)


DILATANCY = angle("psi", "ψ", "Dilatancy angle, at most phi.", (0.0, 15.0), BOLTON, default=0.0)


def cohesion(highest: float) -> ParameterInfo:
    """c, usual up to a stress, kPa."""
    return ParameterInfo(
        "c", "c", "kPa", "Effective cohesion.", lower=0.0, typical=(0.0, highest), source=MESRI_COHESION
    )


def unloading_poisson(default: float, lowest: float, highest: float) -> ParameterInfo:
    """nu_ur, usual between two values."""
    return ParameterInfo(
        "nu_ur",
        "ν_ur",
        "",
        "Poisson's ratio for unloading and reloading.",
        default=default,
        lower=0.0,
        upper=0.5,
        upper_open=True,
        typical=(lowest, highest),
        source=f"{PLAXIS}: 0.15 for soft soil, 0.2 for hardening soil",
    )


def normal_K0(lowest: float, highest: float) -> ParameterInfo:
    """K0nc, usual between two values."""
    return ParameterInfo(
        "K0nc",
        "K₀ⁿᶜ",
        "",
        "Stress ratio of normally consolidated one-dimensional compression; 0: derived, 1 - sin(phi).",
        default=0.0,
        lower=0.0,
        upper=1.0,
        upper_open=True,
        typical=(lowest, highest),
        source=JAKY,
    )


def pre_overburden(highest: float) -> ParameterInfo:
    """POP, usual up to a stress, kPa."""
    return ParameterInfo(
        "POP",
        "POP",
        "kPa",
        "Initial pre-overburden pressure: preconsolidation stress minus initial stress; not together with OCR.",
        default=0.0,
        lower=0.0,
        typical=(0.0, highest),
        source=OVERBURDEN,
    )


def critical_friction(lowest: float, highest: float, source: str) -> ParameterInfo:
    """phi_c, usual between two angles, degree, by a source."""
    return angle("phi_c", "φ_c", "Critical friction angle.", (lowest, highest), source, lower_open=True)


def overconsolidation(description: str) -> ParameterInfo:
    """OCR, with what it compares."""
    return ParameterInfo("OCR", "OCR", "", description, default=1.0, lower=1.0, typical=(1.0, 4.0), source=BJERRUM)


def too_dilatant(phi: float | None, psi: float) -> str | None:
    """What is wrong with more dilatancy than friction, degree; None: nothing, or friction is not known."""
    if phi is None or psi <= phi:
        return None
    return f"psi must be at most phi = {phi:g} degree, got {psi:g} degree"


def two_pasts(OCR: float, POP: float) -> str | None:
    """What is wrong with two preconsolidations, POP in kPa; None: nothing."""
    if OCR == 1.0 or POP == 0.0:
        return None
    return f"OCR = {OCR:g} and POP = {POP:g} kPa are both given; give only one of them"
