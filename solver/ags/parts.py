"""One test of a problem, and the files of its readings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

__all__ = ["Part", "Reading"]


@dataclass(frozen=True, slots=True)
class Reading:
    """Readings of a series: the file's name without ending, its content, and further keys of the observation."""

    series: str
    name: str
    content: bytes
    keys: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Part:
    """A test: the section of its forward model, its readings, and parameters that are its own."""

    name: str
    section: Mapping[str, Any]
    readings: tuple[Reading, ...]
    own: Mapping[str, Mapping[str, Any]]
