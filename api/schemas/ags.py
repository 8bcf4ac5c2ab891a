"""Models of what is answered about files in the AGS 4 format."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from geoswarm.api.schemas.responses import Model

__all__ = ["AgsContents", "AgsEntry", "AgsProblem", "AgsReadings"]


class AgsEntry(Model):
    """A test, or the readings of one quantity by an instrument."""

    id: str = Field(description="borehole, sample, specimen, depth; a specimen with several tests has several entries")
    kind: str = Field(description="kind of test, and its groups in the file")
    what: str = Field(description="what it holds, or why it cannot be used")
    location: str
    depth: str = Field(description="m, as it stands; empty: the file does not say")
    count: int = Field(description="increments, specimens or stages at failure, readings")
    use: Literal["problem", "readings", "nothing"] = Field(
        description="it makes a problem or a part of one, a CSV file, or nothing"
    )
    why: str = Field(description="why nothing is made of it; empty otherwise")


class AgsContents(Model):
    """What a file in the AGS 4 format holds."""

    name: str
    count: int = Field(description="entries of the file, of which at most 2000 are given")
    items: list[AgsEntry]


class AgsReadings(Model):
    """Readings of an instrument as a CSV file."""

    name: str
    csv: str


class AgsProblem(Model):
    """The problem and files made from tests and readings of a file."""

    name: str
    specimens: list[str] = Field(description="IDs of the tests that the problem is made of")
    problem: dict[str, Any] | None = Field(
        description="the problem with its readings, for the form or to be submitted; null: readings of instruments only"
    )
    notes: list[str] = Field(
        description="what was assumed, or is to be known; those on tests stand in the problem, too"
    )
    readings: list[AgsReadings]
