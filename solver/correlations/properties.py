"""Index properties of a soil, as laboratories report them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

__all__ = ["IndexProperties", "SoilClass"]

SoilClass: TypeAlias = Literal["granular", "shale", "inorganic_clay", "organic_clay", "peat"]
"""Classes of soil by which Mesri & Castro (1987) give C_alpha/Cc; inorganic_clay stands for silts, too."""


@dataclass(frozen=True, slots=True)
class IndexProperties:
    """What is known of a soil; None: not known.

    Parameters
    ----------
    liquid_limit, plastic_limit, plasticity_index, water_content
        In per cent, as they are reported.
    void_ratio
        In the ground.
    specific_gravity
        Density of the solids over that of water.
    relative_density
        Of sand, in per cent: 0 the loosest, 100 the densest state.
    min_void_ratio, max_void_ratio
        Of sand, in its densest and its loosest state by index tests.
    soil_class
        Where it is known.
    """

    liquid_limit: float | None = None
    plastic_limit: float | None = None
    plasticity_index: float | None = None
    water_content: float | None = None
    void_ratio: float | None = None
    specific_gravity: float = 2.7
    relative_density: float | None = None
    min_void_ratio: float | None = None
    max_void_ratio: float | None = None
    soil_class: SoilClass | None = None

    @property
    def plasticity(self) -> float | None:
        """Plasticity index, per cent: as given, else liquid less plastic limit."""
        if self.plasticity_index is None and self.liquid_limit is not None and self.plastic_limit is not None:
            return self.liquid_limit - self.plastic_limit
        return self.plasticity_index

    @property
    def voids(self) -> float | None:
        """Void ratio: as given, else that of the saturated soil, water content times specific gravity."""
        if self.void_ratio is None and self.water_content is not None:
            return 0.01 * self.water_content * self.specific_gravity
        return self.void_ratio

    def value(self, name: str) -> float | None:
        """One of them by the name that correlations use: w_L, I_P, w_n, e_0, G_s, D_r, e_min or e_max."""
        return {
            "w_L": self.liquid_limit,
            "I_P": self.plasticity,
            "w_n": self.water_content,
            "e_0": self.voids,
            "G_s": self.specific_gravity,
            "D_r": self.relative_density,
            "e_min": self.min_void_ratio,
            "e_max": self.max_void_ratio,
        }[name]
