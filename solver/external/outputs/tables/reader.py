"""Series from tables: CSV, blanks, fixed columns, and tables that a listing repeats under a heading.

::

    crest: {file: results.csv, x: time, y: uy_A, x_unit: day, y_unit: m}
    settlement: {file: footing.dat, each: "displacements .* time +(?P<t>\\S+)", row: 5, x: t, y: "-column4"}
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from geoswarm.solver.errors import ExpressionError
from geoswarm.solver.expressions import parse_expression
from geoswarm.solver.external.outputs.base import FROM_LIST, OutputReader, Point
from geoswarm.solver.external.outputs.fields import LONGEST_MATCHED, compiled
from geoswarm.solver.external.outputs.lines import LONGEST_LINE, Encoding, lines_of
from geoswarm.solver.external.outputs.tables.blocks import block_points
from geoswarm.solver.external.outputs.tables.quantities import ColumnName, column_of
from geoswarm.solver.external.outputs.tables.rows import Separator, TableShape, table_points

__all__ = ["TableReader"]

_FirstLast = Annotated[tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1, le=LONGEST_LINE)]], FROM_LIST]


class TableReader(OutputReader):
    """x and y from the columns of a table.

    Examples
    --------
    >>> TableReader(file="results.csv", x="time", y="-(uy_A) * 1000").files
    ('results.csv',)
    """

    told_by: ClassVar[str] = "a table (file, x and y)"

    format: Literal["table"] = Field("table", description="May be left out.")
    x: ColumnName = Field(description="Column by name or number (from 1), or an expression of columns.")
    y: ColumnName = Field(description="Column by name or number (from 1), or an expression such as -column4.")
    separator: Separator = Field("auto", description="Separator of cells: , ; tab or blanks.")
    columns: Annotated[tuple[_FirstLast, ...], FROM_LIST] | None = Field(
        None, min_length=1, max_length=1000, description="Fixed columns: first and last character of each, from 1."
    )
    header: int | None = Field(
        None,
        ge=0,
        le=100,
        description="Lines of headings, names in the first; otherwise found by rows that are not numbers.",
    )
    comment: Annotated[tuple[str, ...], FROM_LIST] = Field(
        ("#",), max_length=10, description="Lines that start with this are skipped."
    )
    decimal: Literal[".", ","] = Field(".", description="The decimal sign.")
    encoding: Encoding = Field("utf-8", description="How characters are written.")
    skip: int = Field(0, ge=0, description="Lines to skip at the start.")
    rows: int | None = Field(None, ge=1, description="Number of points; what follows is not read.")
    where: str | None = Field(None, max_length=1000, description="Rows to take, such as column1 == 25.")
    each: str | None = Field(
        None,
        max_length=1000,
        description="Regular expression of the heading that each block has; its groups are names.",
    )
    row: int | None = Field(None, ge=1, description="Row of each block: lines after the heading that are not blank.")

    @field_validator("columns")
    @classmethod
    def _ordered(cls, columns: tuple[tuple[int, int], ...] | None) -> tuple[tuple[int, int], ...] | None:
        for first, last in columns or ():
            if last < first:
                raise ValueError(f"column [{first}, {last}] ends before it begins")
        return columns

    @field_validator("comment")
    @classmethod
    def _comments(cls, comment: tuple[str, ...]) -> tuple[str, ...]:
        if any(not sign.strip() for sign in comment):
            raise ValueError("a comment begins with a sign, such as #; write [] where there are no comments")
        return comment

    @field_validator("where")
    @classmethod
    def _comparison(cls, text: str | None) -> str | None:
        if text is not None:
            try:
                expression = parse_expression(text)
            except ExpressionError as error:
                raise ValueError(str(error)) from error
            if not expression.is_comparison:
                raise ValueError(f"'{text}' must be a comparison, such as column1 == 25")
        return text

    @model_validator(mode="after")
    def _fits_together(self) -> TableReader:
        if self.columns is not None and self.separator != "auto":
            raise ValueError("columns are fixed characters, separator is for others; give one of them")
        if self.separator == self.decimal:
            raise ValueError("separator and decimal are both a comma; one of them must be something else")
        if self.each is None:
            if self.row is not None:
                raise ValueError("row counts lines after a heading; give each, the regular expression of the heading")
            return self
        if self.row is not None and self.where is not None:
            raise ValueError("row and where both choose a row of each block; give one of them")
        if self.header is not None:
            raise ValueError("header is for a single table; blocks (each) have numbered columns and named groups")
        pattern = compiled(self.each)
        known = (*pattern.groupindex, "row", "block")
        for name in ("x", "y", "where"):
            try:
                if getattr(self, name) is not None:
                    column_of(getattr(self, name), known)
            except ValueError as error:
                raise ValueError(
                    f"{name}: {error}, and groups of each: {', '.join(pattern.groupindex) or 'none'}"
                ) from None
        return self

    def shape(self) -> TableShape:
        """Return how the lines are read, without the names of files."""
        return TableShape(
            file=self.file,
            x=self.x,
            y=self.y,
            separator=self.separator,
            fixed=self.columns,
            header=self.header,
            comment=self.comment,
            decimal=self.decimal,
            rows=self.rows,
            where=self.where,
        )

    def scan(self, folder: Path) -> Iterator[Point]:
        """Give the points row by row; a file of any size is read line by line."""
        longest = LONGEST_LINE if self.each is None else LONGEST_MATCHED
        lines = lines_of(folder, self.file, self.encoding, longest)
        kept = ((number, line) for number, line in lines if number > self.skip)
        if self.each is None:
            return table_points(kept, self.shape())
        return block_points(kept, self.shape(), re.compile(self.each), self.row)
