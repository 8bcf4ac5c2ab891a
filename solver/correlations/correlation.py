"""One published correlation between index properties and a quantity that laboratories know."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from geoswarm.solver.correlations.properties import IndexProperties, SoilClass

__all__ = ["Correlated", "Correlation"]


@dataclass(frozen=True, slots=True)
class Correlation:
    """A correlation.

    Parameters
    ----------
    quantity
        Symbol of what it gives, as in the laboratory's terms.
    unit
        Of the quantity.
    equation
        As text.
    needs
        Names of the index properties that ``of`` takes, in this order: w_L, I_P and w_n in per cent, e_0, G_s, D_r in
        per cent.
    of
        The quantity from their values.
    valid
        Range of each of them, in their order, in which the source gives it.
    soils
        What it holds for, in words.
    source
        Where it was published.
    scatter
        Published scatter: relative where ``relative``, else in the unit of the quantity; None: none is published.
    classes
        Classes of soil that it is for; empty: any, and those not told.
    """

    quantity: str
    unit: str
    equation: str
    needs: tuple[str, ...]
    of: Callable[..., float]
    valid: tuple[tuple[float, float], ...]
    soils: str
    source: str
    scatter: float | None = None
    relative: bool = True
    classes: tuple[SoilClass, ...] = ()

    @property
    def scatter_in_words(self) -> str:
        """Its scatter, or nothing."""
        if self.scatter is None:
            return ""
        return f"± {100.0 * self.scatter:.0f} %" if self.relative else f"± {self.scatter:g} {self.unit}".rstrip()

    @property
    def authors(self) -> str:
        """Authors and year of its source."""
        found = re.match(r".*?\(\d{4}\)", self.source)
        return found[0] if found else self.source.partition(",")[0]

    def told(self, soil: IndexProperties) -> Correlated | None:
        """What it says about a soil; None where a property is missing, or the class is another."""
        given = [soil.value(name) for name in self.needs]
        values = [value for value in given if value is not None]
        if len(values) < len(given) or (self.classes and soil.soil_class not in self.classes):
            return None
        value = self.of(*values)
        if not math.isfinite(value):
            return None
        outside = [
            f"{name} = {one:g}, published for {low:g} to {high:g}"
            for name, one, (low, high) in zip(self.needs, values, self.valid, strict=True)
            if not low <= one <= high
        ]
        half = None if self.scatter is None else self.scatter * (abs(value) if self.relative else 1.0)
        ends = None if half is None else (value - half, value + half)
        return Correlated(self, value, ends, "; ".join(outside))


@dataclass(frozen=True, slots=True)
class Correlated:
    """What a correlation says about one soil.

    ``ends``: value less and plus the published scatter. ``outside``: the properties that are beyond its range, in
    words; empty: none.
    """

    correlation: Correlation
    value: float
    ends: tuple[float, float] | None
    outside: str
