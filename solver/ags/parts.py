"""One test of a problem, and its readings: as a CSV file beside a problem, or as points in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

__all__ = ["Part", "Reading"]


@dataclass(frozen=True, slots=True)
class Reading:
    """Readings of a series.

    Parameters
    ----------
    series
        Of the forward model.
    name
        Of a file for them, without ending.
    about
        Where they are from, and what x and y are.
    x, y
        One a reading.
    further
        Columns of a file that a problem does not read, by heading.
    keys
        Further keys of the observation.
    """

    series: str
    name: str
    about: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    further: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    keys: Mapping[str, Any] = field(default_factory=dict)

    @property
    def csv(self) -> bytes:
        """The content of a file."""
        rows = zip(map(repr, self.x), map(repr, self.y), *self.further.values(), strict=True)
        lines = [f"# {self.about}", ",".join(["x", "y", *self.further]), *map(",".join, rows)]
        return ("\n".join(lines) + "\n").encode()

    @property
    def points(self) -> dict[str, list[float]]:
        """The same in a problem."""
        return {"x": list(self.x), "y": list(self.y)}


@dataclass(frozen=True, slots=True)
class Part:
    """A test: the section of its forward model, its readings, and parameters of its own; ``id`` as it is listed."""

    name: str
    id: str
    section: Mapping[str, Any]
    readings: tuple[Reading, ...]
    own: Mapping[str, Mapping[str, Any]]
