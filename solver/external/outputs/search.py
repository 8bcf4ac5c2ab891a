"""Series from lines that match a regular expression.

::

    crest: {file: run.log, find: "t = (?P<x>\\S+) .* uy = (?P<y>\\S+)"}
    safety: {file: run.log, find: "FoS = (?P<fos>\\S+)", observations: {fos: 1}, take: last}
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from geoswarm.solver.external.errors import OutputError, place
from geoswarm.solver.external.outputs.base import FROM_LIST, Point, ScaledReader
from geoswarm.solver.external.outputs.fields import LONGEST_MATCHED, compiled
from geoswarm.solver.external.outputs.lines import Encoding, lines_of
from geoswarm.solver.external.outputs.numbers import number_of, reason_of
from geoswarm.solver.words import did_you_mean, visible

__all__ = ["SearchReader"]


class SearchReader(ScaledReader):
    """Points from a regular expression that is tried on every line.

    With the groups ``x`` and ``y`` each match is a point. With ``observations`` each named group is one value, whose x
    is given there; the groups may stand in several expressions.
    """

    told_by: ClassVar[str] = "a search (file and find)"

    format: Literal["search"] = Field("search", description="May be left out.")
    find: str | Annotated[tuple[str, ...], FROM_LIST] = Field(
        description="Regular expression, or several, with named groups."
    )
    observations: dict[str, float] | None = Field(
        None, min_length=1, max_length=100_000, description="x of each named group that is one value of the file."
    )
    take: Literal["only", "first", "last"] = Field(
        "only", description="Which match of a named group counts; only: more than one is a mistake."
    )
    decimal: Literal[".", ","] = Field(".", description="The decimal sign.")
    encoding: Encoding = Field("utf-8", description="How characters are written.")

    @model_validator(mode="after")
    def _groups_are_there(self) -> SearchReader:
        patterns = (self.find,) if isinstance(self.find, str) else self.find
        if not patterns:
            raise ValueError("find is empty; write a regular expression")
        groups = [name for pattern in patterns for name in compiled(pattern).groupindex]
        wanted = ["x", "y"] if self.observations is None else list(self.observations)
        for name in wanted:
            if name not in groups:
                there = ", ".join(groups) or "none"
                hint = did_you_mean(name, groups)
                raise ValueError(f"find has no group (?P<{name}>...){hint}; its named groups: {there}")
        twice = [name for name in groups if groups.count(name) > 1]
        if twice:
            raise ValueError(f"group {twice[0]} is in several expressions; use each name once")
        if self.observations is None and (len(patterns) > 1 or self.take != "only"):
            raise ValueError("several expressions, and take, are for observations; points take one find with x and y")
        return self

    def scan(self, folder: Path) -> Iterator[Point]:
        """Give the points in the order of the file, those of ``observations`` in the order given there."""
        if self.observations is None:
            return self._matches(folder)
        return self._values(folder, self.observations)

    def _matches(self, folder: Path) -> Iterator[Point]:
        assert isinstance(self.find, str)
        pattern, found = compiled(self.find), False
        for number, line in lines_of(folder, self.file, self.encoding, LONGEST_MATCHED):
            for match in pattern.finditer(line):
                found = True
                x, y = self._number("x", match["x"], number), self._number("y", match["y"], number)
                yield Point(x, self.y_factor * y, number, line)
        if not found:
            raise OutputError("bad_output", f"{self.file}: no line matches find: {self.find[:100]}")

    def _values(self, folder: Path, observations: dict[str, float]) -> Iterator[Point]:
        patterns = [compiled(text) for text in ((self.find,) if isinstance(self.find, str) else self.find)]
        found: dict[str, Point] = {}
        for number, line in lines_of(folder, self.file, self.encoding, LONGEST_MATCHED):
            for match in (match for pattern in patterns for match in pattern.finditer(line)):
                for name, text in match.groupdict().items():
                    if name not in observations or text is None or (name in found and self.take == "first"):
                        continue
                    if name in found and self.take == "only":
                        message = f"{name} was found in line {found[name].line} already; write take: first or last"
                        raise OutputError("bad_output", f"{place(self.file, number)}: {message}")
                    value = self.y_factor * self._number(name, text, number)
                    found[name] = Point(observations[name], value, number, line)
        for name in observations:
            if name not in found:
                raise OutputError("bad_output", f"{self.file}: no line matches find with a value for {name}")
            yield found[name]

    def _number(self, name: str, text: str | None, line: int) -> float:
        try:
            return number_of(text or "", self.decimal)
        except ValueError as error:
            message = f"{place(self.file, line)}: group {name}: {visible(str(error))}"
            raise OutputError(reason_of(error), message) from None
