"""Vertical drains: what they take from the ground between them, by equal vertical strain.

Barron (1948) and Hansbo (1981): a drain of diameter d_w takes water from a cylinder of diameter d_e whose horizontal
slices stay plane. A slice that is compressed at the rate e' has, above the pressure in a free drain, the mean one ::

    u = gamma_w d_e^2/(8 k_h) (mu + mu_w) e',    mu_w = pi z (2 l - z) (1 - 1/n^2) k_h/q_w

with n = d_e/d_w, the smear zone of diameter s d_w and permeability k_h/r, and the well resistance at depth z of a
drain of length l that discharges q_w at a unit gradient, at its top.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.forward.base import in_unit
from geoswarm.solver.laboratory.section import Part
from geoswarm.solver.sentences import SentenceError, setting
from geoswarm.solver.units import WATER

__all__ = ["DrainsSection", "Taken", "equal_strain", "influence"]


class DrainsSection(Part):
    """Vertical drains; their water leaves at their upper ends without resistance."""

    spacing: float = Field(
        gt=0.0,
        le=100.0,
        description="Distance of the axes of neighbouring drains, m.",
        json_schema_extra=in_unit("m", 0.8, 3),
    )
    pattern: Literal["triangular", "square"] = Field("triangular", description="How the drains are arranged.")
    diameter: float = Field(
        gt=0.0,
        le=10.0,
        description="Diameter, m; of a band 2 (width + thickness)/pi.",
        json_schema_extra=in_unit("m", 0.05, 0.4),
    )
    top: float = Field(
        0.0,
        ge=0.0,
        description="Depth of their upper ends below the ground surface, m.",
        json_schema_extra=in_unit("m"),
    )
    bottom: float = Field(
        gt=0.0,
        description="Depth of their lower ends below the ground surface, m.",
        json_schema_extra=in_unit("m", 5, 20),
    )
    smear_diameter: float | None = Field(
        None,
        gt=0.0,
        description="Diameter of the zone that installation has disturbed, m; none unless given.",
        json_schema_extra=in_unit("m", 0.1, 0.5),
    )
    smear_ratio: float = Field(
        1.0,
        gt=0.0,
        le=1.0e4,
        description="Permeability of undisturbed over that of disturbed soil; default of the parameter "
        "drains.smear_ratio.",
        json_schema_extra=in_unit("1", 1, 5),
    )
    discharge_capacity: float | None = Field(
        None,
        gt=0.0,
        description="Flow through a drain at a unit gradient, m³/day; without limit unless given. Default of the "
        "parameter drains.discharge_capacity.",
        json_schema_extra=in_unit("m³/day", 0.1, 3),
    )

    @model_validator(mode="after")
    def _one_inside_the_other(self) -> DrainsSection:
        if not self.bottom > self.top:
            raise ValueError(f"bottom must be below the top, {self.top:g} m, got {self.bottom:g} m")
        outer = influence(self.spacing, self.pattern)
        if not self.diameter < outer:
            raise ValueError(
                f"diameter must be below that of the ground of a drain, {outer:g}, got {self.diameter:g} m"
            )
        smeared = self.smear_diameter
        if smeared is not None and not self.diameter <= smeared < outer:
            raise SentenceError(
                setting("smear_diameter"),
                f" must be from the diameter of the drain, {self.diameter:g} m, to below that of "
                f"its ground, {outer:g} m, got {smeared:g} m",
            )
        if smeared is None and self.smear_ratio != 1.0:
            raise SentenceError(
                *(setting("smear_ratio"), " must be 1 without ", setting("smear_diameter")),
                f", got {self.smear_ratio:g}",
            )
        return self


def influence(spacing: float, pattern: str) -> float:
    """Diameter of the circle with the area that belongs to a drain, m."""
    area = spacing**2 * (math.sqrt(0.75) if pattern == "triangular" else 1.0)
    return math.sqrt(4.0 * area / math.pi)


def equal_strain(n: float, s: float, ratio: float) -> float:
    """mu of Barron (1948) and Hansbo (1981) without well resistance; the smear zone is compressed as the soil is.

    Parameters
    ----------
    n, s
        Diameters of the ground of a drain and of its smear zone, over that of the drain, n > s >= 1.
    ratio
        Permeability of undisturbed over that of disturbed soil.
    """
    inner = ratio * math.log(s)
    outer = math.log(n / s)
    tail = s**2 * (1.0 - s**2 / (4.0 * n**2)) + ratio * ((s**4 - 1.0) / (4.0 * n**2) - s**2 + 1.0)
    return (n**2 * (outer + inner - 0.75) + tail) / (n**2 - 1.0)


@dataclass(frozen=True)
class Taken:
    """What drains take of cells: 1/(kPa day) for each part of the height, and the share of their resistance, (j,)."""

    sink: FloatArray
    resist: FloatArray

    @classmethod
    def by(cls, drains: DrainsSection, horizontal: FloatArray, depths: FloatArray) -> Taken:
        """Of cells whose permeability to horizontal flow is given, m/day, (j,).

        Parameters
        ----------
        depths
            Of the bounds of the cells below the ground surface, from the base up, m, (j + 1,).
        """
        outer = influence(drains.spacing, drains.pattern)
        n = outer / drains.diameter
        s = 1.0 if drains.smear_diameter is None else drains.smear_diameter / drains.diameter
        mu = equal_strain(n, s, drains.smear_ratio)
        lower, upper = np.minimum(depths[:-1], drains.bottom), np.maximum(depths[1:], drains.top)
        reached = np.maximum(lower - upper, 0.0)
        part = reached / (depths[:-1] - depths[1:])
        z = np.clip(0.5 * (lower + upper), drains.top, drains.bottom) - drains.top
        length = drains.bottom - drains.top
        well = np.zeros(z.size)
        if drains.discharge_capacity is not None:
            well = math.pi * z * (2.0 * length - z) * (1.0 - 1.0 / n**2) * horizontal / drains.discharge_capacity
        return cls(part * 8.0 * horizontal / (WATER * outer**2 * mu), well / mu)
