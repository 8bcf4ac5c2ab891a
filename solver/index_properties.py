"""Index properties of a soil, as laboratories report them and as problem files give them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from pydantic import Field, model_validator

from geoswarm.solver.section import Section
from geoswarm.solver.sentences import SentenceError, setting

__all__ = ["IndexProperties", "IndexSection", "SoilClass"]

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


_LEAST = 2.0
_LIMITS = ("liquid_limit", "plastic_limit", "plasticity_index", "water_content")


def _per_cent(lowest: float, highest: float) -> dict[str, Any]:
    """What forms know of a field."""
    return {"x-unit": "%", "x-typical": [lowest, highest]}


class IndexSection(Section):
    """Index properties of the soil, as laboratories report them: per cent, not fractions."""

    liquid_limit: float | None = Field(
        None, description="liquid limit w_L, per cent", json_schema_extra=_per_cent(20, 150)
    )
    plastic_limit: float | None = Field(
        None, description="plastic limit w_P, per cent", json_schema_extra=_per_cent(10, 60)
    )
    plasticity_index: float | None = Field(
        None, description="plasticity index I_P, per cent; w_L - w_P unless given", json_schema_extra=_per_cent(5, 100)
    )
    water_content: float | None = Field(
        None, description="natural water content w_n, per cent", json_schema_extra=_per_cent(10, 150)
    )
    void_ratio: float | None = Field(
        None,
        gt=0.0,
        le=30.0,
        description="void ratio e_0 in the ground; that of the saturated soil, w_n G_s, unless given",
    )
    specific_gravity: float = Field(2.7, ge=1.0, le=6.0, description="density of the solids over that of water, G_s")
    relative_density: float | None = Field(
        None, ge=0.0, le=100.0, description="relative density of sand, per cent", json_schema_extra=_per_cent(0, 100)
    )
    min_void_ratio: float | None = Field(
        None, gt=0.0, le=5.0, description="void ratio of sand in its densest state by index tests, e_min"
    )
    max_void_ratio: float | None = Field(
        None, gt=0.0, le=5.0, description="void ratio of sand in its loosest state by index tests, e_max"
    )
    soil_class: SoilClass | None = Field(
        None, description="class by which creep is estimated; clay stands for silt, too"
    )

    @model_validator(mode="after")
    def _plausible(self) -> IndexSection:
        for name in _LIMITS:
            value = getattr(self, name)
            if value is not None and not _LEAST <= value <= 3000.0:
                hint = f"; in per cent this would be {100.0 * value:g}" if 0.0 < value < _LEAST else ""
                raise SentenceError(setting(name), f" must be from {_LEAST:g} to 3000 %, got {value:g} %{hint}")
        w_L, w_P, I_P = self.liquid_limit, self.plastic_limit, self.plasticity_index
        if w_L is not None and w_P is not None:
            if not w_L > w_P:
                raise _unlike("liquid_limit", "must be above", "plastic_limit", w_P, w_L, " %")
            if I_P is not None and abs(w_L - w_P - I_P) > 1.0:
                difference = setting("liquid_limit"), " - ", setting("plastic_limit")
                raise SentenceError(
                    *(setting("plasticity_index"), " must be ", *difference),
                    f" = {w_L - w_P:g} %, got {I_P:g} %; leave one of the three out, or correct it",
                )
        elif w_L is not None and I_P is not None and not w_L > I_P:
            raise _unlike("plasticity_index", "must be below", "liquid_limit", w_L, I_P, " %")
        low, high = self.min_void_ratio, self.max_void_ratio
        if low is not None and high is not None and not low < high:
            raise _unlike("max_void_ratio", "must be above", "min_void_ratio", low, high)
        return self

    def properties(self) -> IndexProperties:
        """As correlations take them."""
        return IndexProperties(**self.model_dump())


def _unlike(key: str, rule: str, other: str, limit: float, given: float, unit: str = "") -> SentenceError:
    return SentenceError(setting(key), f" {rule} ", setting(other), f" = {limit:g}{unit}, got {given:g}{unit}")
