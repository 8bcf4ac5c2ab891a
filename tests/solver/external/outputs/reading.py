"""What the tests of readers share."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.external.errors import OutputError
from geoswarm.solver.external.outputs.base import OutputReader
from geoswarm.solver.external.outputs.series import SeriesReader
from geoswarm.solver.problem.issues import issues_of

__all__ = ["assert_bad", "assert_points", "reader_of", "series"]

ADAPTER: TypeAdapter[dict[str, OutputReader]] = TypeAdapter(dict[str, SeriesReader])


def reader_of(section: Any) -> OutputReader:
    """Make the reader of the section ``series.s``, and tell mistakes, as it is done for problem files."""
    sections = {"s": section}
    try:
        return ADAPTER.validate_json(json.dumps(sections), strict=True)["s"]
    except ValidationError as error:
        raise ProblemError(issues_of(error, sections, "series", ADAPTER.json_schema)) from None


def series(folder: Path, content: str | bytes | None = None, /, **section: Any) -> list[tuple[float, float]]:
    """Write the content into the section's file, read it, and return the points."""
    section.setdefault("file", "out.txt")
    if content is not None:
        data = content if isinstance(content, bytes) else content.encode("utf-8")
        (folder / section["file"]).write_bytes(data)
    reader = reader_of(section)
    x, y = reader.read(folder)
    assert x.dtype == y.dtype == "float64"
    assert len(x) == len(y) == len(reader.traced(folder))
    return list(zip(x.tolist(), y.tolist(), strict=True))


def assert_points(found: list[tuple[float, float]], expected: list[tuple[float, float]]) -> None:
    """Compare points within rounding."""
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def assert_bad(
    folder: Path, content: str | bytes | None, message: str, /, reason: str = "bad_output", **section: Any
) -> None:
    """Expect that reading fails with a message."""
    with pytest.raises(OutputError) as caught:
        series(folder, content, **section)
    assert message in str(caught.value)
    assert caught.value.reason == ("not_finite" if "is not finite" in message else reason)
