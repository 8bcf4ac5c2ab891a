"""Linear elasticity up to the limit of Matsuoka and Nakai, perfectly plastic, as a law."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from geoswarm.solver.constitutive.smooth_cone import MATSUOKA_NAKAI
from geoswarm.solver.laws.perfect_plasticity.drucker_prager import SmoothCone

__all__ = ["MatsuokaNakai"]


class MatsuokaNakai(SmoothCone):
    """Matsuoka-Nakai (Matsuoka & Nakai 1974), with dilatancy and tension cut-off.

    It holds the limit of Mohr-Coulomb within, and meets it in triaxial compression and extension; so a strength that
    is enough for Mohr-Coulomb is enough here.
    """

    kind: ClassVar[str] = "matsuoka_nakai"
    title: ClassVar[str] = "elasticity with the strength of Matsuoka and Nakai"

    def cone_kind(self, given: Mapping[str, Any]) -> int:
        """That of Matsuoka and Nakai."""
        del given
        return MATSUOKA_NAKAI
