"""Series from JSON files.

::

    crest: {file: results.json, x: results.time, y: "results[*].uy"}
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import Field, field_validator

from geoswarm.solver.external.errors import OutputError
from geoswarm.solver.external.outputs.base import Point, ScaledReader
from geoswarm.solver.external.outputs.json_paths import parse_json_path
from geoswarm.solver.external.outputs.lines import decoded, opened

__all__ = ["JsonReader"]

MAX_JSON_BYTES = 256 * 2**20
"""Largest JSON file: it is held as a whole."""


class JsonReader(ScaledReader):
    """x and y by their paths in a JSON document, as many numbers of the one as of the other."""

    told_by: ClassVar[str] = "JSON (a file .json, x and y)"

    format: Literal["json"] = Field("json", description="May be left out for files named .json.")
    x: str = Field(max_length=1000, description="Path of x, such as results.time.")
    y: str = Field(max_length=1000, description="Path of y, such as results[*].uy.")

    @field_validator("x", "y")
    @classmethod
    def _is_path(cls, text: str) -> str:
        return parse_json_path(text.strip()).text

    def scan(self, folder: Path) -> Iterator[Point]:
        """Give the points; the file is read as a whole."""
        document = self._document(folder)
        try:
            x = parse_json_path(self.x).numbers(document)
            y = parse_json_path(self.y).numbers(document)
        except ValueError as error:
            raise OutputError("bad_output", f"{self.file}: {error}") from None
        if len(x) != len(y):
            message = f"{self.x} has {len(x)} numbers and {self.y} has {len(y)}; as many of both are expected"
            raise OutputError("bad_output", f"{self.file}: {message}")
        for (place_x, one_x), (place_y, one_y) in zip(x, y, strict=True):
            yield Point(one_x, self.y_factor * one_y, 0, f"{place_x} = {one_x!r}, {place_y} = {one_y!r}")

    def _document(self, folder: Path) -> Any:
        with opened(folder, self.file) as stream:
            content = stream.read(MAX_JSON_BYTES + 1)
        if len(content) > MAX_JSON_BYTES:
            raise OutputError("bad_output", f"{self.file}: is larger than {MAX_JSON_BYTES // 2**20} MB")
        wide = content[:2] in (b"\xff\xfe", b"\xfe\xff")
        text = decoded(content, self.file, None, "utf-16" if wide else "utf-8").removeprefix("\ufeff")
        try:
            return json.loads(text)
        except json.JSONDecodeError as error:
            message = f"{self.file}: line {error.lineno}: {error.msg} at character {error.colno}; JSON is expected"
            cut = "; the file may be truncated" if error.pos >= len(text.rstrip()) else ""
            raise OutputError("bad_output", message + cut) from None
        except (ValueError, RecursionError) as error:  # a number of many digits; nested too deeply
            raise OutputError("bad_output", f"{self.file}: cannot be read as JSON: {error}") from None
