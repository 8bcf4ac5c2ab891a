"""Evaluations as Parquet: typed columns, written row group by row group into a temporary file (extra ``parquet``)."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime
from typing import IO, Any

from geoswarm.records.evaluation import COLUMNS, Evaluation
from geoswarm.solver.system.extras import has

__all__ = ["parquet_available", "parquet_pieces"]

ROWS_A_GROUP = 5000
VALUES_A_GROUP = 400_000  # of calculated series, as Python's numbers some 10 MB
PIECE = 1 << 18
IN_MEMORY = 16 << 20

_OWN = {column.name: column.kind for column in COLUMNS}


def parquet_available() -> bool:
    """Return whether pyarrow is installed."""
    return has("pyarrow")


def parquet_pieces(
    views: Iterable[Evaluation],
    columns: Sequence[tuple[str, str, str]],
    series: Sequence[str],
    *,
    responses: bool,
) -> Iterator[bytes]:
    """Write a file and return its bytes in pieces.

    Parameters
    ----------
    views
        Rows.
    columns
        Header, where its value is (``own``, ``parameter`` or ``misfit``), and its name there.
    series
        Observed series; with ``responses`` each has a column ``response.SERIES`` of lists, base units.
    """
    file = tempfile.SpooledTemporaryFile(IN_MEMORY)  # noqa: SIM115  (closed when the last piece is read)
    try:
        _write(file, views, columns, series if responses else ())
        file.seek(0)
    except BaseException:
        file.close()
        raise
    return _pieces(file)


def _pieces(file: IO[bytes]) -> Iterator[bytes]:
    with file:
        while piece := file.read(PIECE):
            yield piece


def _write(
    file: IO[bytes], views: Iterable[Evaluation], columns: Sequence[tuple[str, str, str]], series: Sequence[str]
) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    types = {str: pa.string(), int: pa.int64(), float: pa.float64(), datetime: pa.timestamp("us", tz="UTC")}

    def kind(place: str, name: str) -> Any:
        return types[_OWN[name] if place == "own" else float]

    fields = [pa.field(header, kind(place, name)) for header, place, name in columns]
    fields += [pa.field(f"response.{name}", pa.list_(pa.float64())) for name in series]
    schema = pa.schema(fields)
    with pq.ParquetWriter(file, schema, compression="zstd") as writer:
        for group in _groups(views, series):
            cells = [[_cell(view, place, name) for view in group] for _, place, name in columns]
            cells += [[_response(view, name) for view in group] for name in series]
            arrays = [pa.array(column, type=field.type) for column, field in zip(cells, schema, strict=True)]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))


def _cell(view: Evaluation, place: str, name: str) -> Any:
    if place == "parameter":
        return view.parameters.get(name)
    return view.misfits.get(name) if place == "misfit" else getattr(view, name)


def _response(view: Evaluation, name: str) -> list[float | None] | None:
    """Calculated values; None where there are none: a prediction keeps those of the tests that succeeded."""
    found = None if view.responses is None else view.responses.get(name)
    return None if found is None else found.y


def _groups(views: Iterable[Evaluation], series: Sequence[str]) -> Iterator[list[Evaluation]]:
    """Rows that are written at once: fewer where the responses of ``series`` are long."""
    group: list[Evaluation] = []
    values = 0
    for view in views:
        group.append(view)
        values += sum(len(_response(view, name) or ()) for name in series)
        if len(group) >= ROWS_A_GROUP or values >= VALUES_A_GROUP:
            yield group
            group, values = [], 0
    if group:
        yield group
