"""How parameters of a law translate into the terms of laboratories, and back.

A law declares its terms. Symbols are those of reports: ``Cc``, ``Cs``, ``Cα``, ``φ``, ``c``, ``E₅₀ʳᵉᶠ`` ...
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

__all__ = [
    "COHESION",
    "CRITICAL_FRICTION",
    "DILATANCY_ANGLE",
    "FRICTION",
    "LN10",
    "Known",
    "Term",
    "oedometric",
    "same",
]

LN10: Final = math.log(10.0)

Known: TypeAlias = Mapping[str, float]
"""Parameters of the law by name (those that are known), the void ratio before the test as ``e_0``, and ``all_round``
above 0 where a quantity was read under all-round stress: it is taken for that of an oedometer otherwise."""


@dataclass(frozen=True, slots=True)
class Term:
    """One parameter in the terms of laboratories.

    Parameters
    ----------
    quantity, unit
        Symbol of the quantity, and its unit.
    name
        What it is.
    parameter
        Parameter of the law that stands for it.
    relation
        The quantity by the parameter, as text.
    of
        The quantity from what is known; the parameter is among it. Above 0 where there is one.
    back
        The parameter from the quantity and what else is known.
    voids
        Whether both need ``e_0``.
    """

    quantity: str
    unit: str
    name: str
    parameter: str
    relation: str
    of: Callable[[Known], float]
    back: Callable[[float, Known], float]
    voids: bool = False


def same(quantity: str, unit: str, name: str, parameter: str) -> Term:
    """A parameter that laboratories know by its own name."""
    return Term(quantity, unit, name, parameter, quantity, lambda known: known[parameter], lambda value, _known: value)


FRICTION = same("φ", "degree", "friction angle", "phi")
COHESION = same("c", "kPa", "cohesion", "c")
CRITICAL_FRICTION = same("φ_cs", "degree", "friction angle of the critical state", "phi_c")
DILATANCY_ANGLE = same("ψ", "degree", "dilatancy angle", "psi")


def oedometric(poisson: float, known: Known) -> float:
    """Strain of an elastic body in the test over its volume strain under all-round stress: 1 where that is the test.

    Laterally held, for the same change of ln(stress), at equal stresses: ``(1 + nu)/(3 (1 - nu))``, 0.45 for nu = 0.15.
    """
    if known.get("all_round"):
        return 1.0
    return (1.0 + poisson) / (3.0 * (1.0 - poisson))
