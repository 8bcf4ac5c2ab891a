"""What parameters of hardening soil are in the terms of laboratories."""

from __future__ import annotations

from geoswarm.solver.laws.terms import COHESION, DILATANCY_ANGLE, FRICTION, LN10, Known, Term, same

__all__ = ["HARDENING_SOIL_TERMS"]


def _constrained(known: Known) -> float:
    """Modulus of one-dimensional compression over Young's modulus, on unloading."""
    nu = known.get("nu_ur", 0.2)
    return (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))


def _reference(known: Known) -> float:
    return LN10 * (1.0 + known["e_0"]) * known.get("p_ref", 100.0)


HARDENING_SOIL_TERMS = (
    same("E₅₀ʳᵉᶠ", "kPa", "secant modulus at half the strength, at p_ref", "E50_ref"),
    same("E_oedʳᵉᶠ", "kPa", "tangent modulus of one-dimensional compression at p_ref", "Eoed_ref"),
    same("E_urʳᵉᶠ", "kPa", "modulus of unloading and reloading at p_ref", "Eur_ref"),
    Term(
        "Cc",
        "",
        "compression index",
        "Eoed_ref",
        "2.303 (1 + e₀) p_ref/E_oedʳᵉᶠ, at σ′v = p_ref",
        lambda known: _reference(known) / known["Eoed_ref"],
        lambda value, known: _reference(known) / value,
        voids=True,
    ),
    Term(
        "Cs",
        "",
        "swelling index",
        "Eur_ref",
        "2.303 (1 + e₀) p_ref (1 + ν) (1 − 2 ν)/((1 − ν) E_urʳᵉᶠ), at σ′h = σ′v = p_ref, about",
        lambda known: _reference(known) / (_constrained(known) * known["Eur_ref"]),
        lambda value, known: _reference(known) / (_constrained(known) * value),
        voids=True,
    ),
    same("m", "", "power of stress", "m"),
    FRICTION,
    COHESION,
    DILATANCY_ANGLE,
    same("R_f", "", "failure ratio", "R_f"),
    same("K₀", "", "stress ratio at rest", "K0nc"),
)
