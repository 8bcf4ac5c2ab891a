"""One parameter of a calculation, as its users see it."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

__all__ = ["ParameterInfo", "outside_limits"]


@dataclass(frozen=True, slots=True)
class ParameterInfo:
    """One parameter of a forward model.

    ``default`` None means that the problem must give the parameter. ``lower`` and ``upper`` (base units) are physical
    limits; ``typical`` is a usual range offered to users, and ``source`` its origin. ``lower_open``: ``lower`` itself
    is refused. ``any_case``: its name is not case-sensitive, as in PEST templates. ``set_by``: the key of the forward
    model that settles its value, to which both limits are then equal.

    Examples
    --------
    >>> import geoswarm as gs
    >>> phi = gs.ParameterInfo("phi", "φ", "degree", "friction angle", lower=0.0, upper=90.0, upper_open=True)
    >>> phi.accepted, phi.admits(95.0)
    ('at least 0 and below 90', False)
    """

    name: str
    symbol: str
    unit: str
    description: str
    default: float | None = None
    lower: float | None = None
    upper: float | None = None
    lower_open: bool = False
    upper_open: bool = False
    typical: tuple[float, float] | None = None
    any_case: bool = False
    source: str = ""
    set_by: str = ""

    def is_among(self, names: Collection[str]) -> bool:
        """Whether it has one of the given names."""
        return self.name in names or (self.any_case and self.name.lower() in {name.lower() for name in names})

    @property
    def accepted(self) -> str:
        """Its limits in words."""
        if self.set_by:
            return f"{self.lower:g}, as the forward model has {self.set_by} (give one of the two)"
        lower = "" if self.lower is None else f"{'above' if self.lower_open else 'at least'} {self.lower:g}"
        upper = "" if self.upper is None else f"{'below' if self.upper_open else 'at most'} {self.upper:g}"
        return " and ".join(part for part in (lower, upper) if part) or "a finite value"

    def admits(self, value: float) -> bool:
        """Whether a value is finite and within the limits."""
        below = self.lower is not None and (value < self.lower or (self.lower_open and value == self.lower))
        above = self.upper is not None and (value > self.upper or (self.upper_open and value == self.upper))
        return not below and not above and math.isfinite(value)


def outside_limits(infos: Iterable[ParameterInfo], values: Mapping[str, float]) -> str | None:
    """The first of the given values that is outside its limits, and what is accepted, in words; or None."""
    for info in infos:
        value = values.get(info.name)
        if value is not None and not info.admits(value):
            unit = f" {info.unit}" if info.unit else ""
            return f"{info.name} must be {info.accepted}, got {value:g}{unit}"
    return None
