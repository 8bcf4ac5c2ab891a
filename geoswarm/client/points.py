"""Evaluations of a job as arrays, from the block of float32 that plots use."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import httpx

from geoswarm.client.calls import not_ours, read_json
from geoswarm.records.arrays import Floats

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["PointParameter", "PointSeries", "Points", "read_points"]

_LENGTH = 4
"""Bytes of the length before the JSON object."""


@dataclass(frozen=True, slots=True)
class PointParameter:
    """A free parameter: what to write at an axis, and its bounds (natural values)."""

    name: str
    symbol: str
    unit: str
    scale: str
    lower: float
    upper: float


@dataclass(frozen=True, slots=True, eq=False)
class PointSeries:
    """An observed series: measured points ``x``, ``y`` of shape (m,) in base units."""

    name: str
    weight: float
    x: Floats
    y: Floats
    x_quantity: str
    x_unit: str
    y_quantity: str
    y_unit: str


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """The successful evaluations of a job, a selection of long histories; n of them, in the order of the search.

    Arrays are read-only and hold single precision: values beyond it are infinite or 0.

    Attributes
    ----------
    failed, left_out
        Evaluations that failed; successful ones that the selection leaves out.
    source
        ``monte_carlo``, ``particle_swarm``, ``mixed`` or ``follow_up``: where they come from, None without any.
    parameters, series
        Free parameters and observed series.
    generation, particle
        Shape (n,), whole numbers.
    objective
        Shape (n,), base unit of the series squared.
    values
        Natural values by free parameter, shape (n,).
    misfits
        f'_g by series, shape (n,).
    responses
        Calculated values by series, shape (n, m), base units; empty unless they were asked for.
    """

    failed: int
    left_out: int
    source: str | None
    parameters: list[PointParameter]
    series: list[PointSeries]
    generation: NDArray[np.int64]
    particle: NDArray[np.int64]
    objective: NDArray[np.float32]
    values: dict[str, NDArray[np.float32]]
    misfits: dict[str, NDArray[np.float32]]
    responses: dict[str, NDArray[np.float32]]

    @property
    def count(self) -> int:
        """Number n of evaluations."""
        return len(self.objective)


@dataclass(frozen=True, slots=True)
class _Column:
    kind: str
    name: str
    width: int


@dataclass(frozen=True, slots=True, eq=False)
class _Head:
    count: int
    failed: int
    left_out: int
    source: str | None
    parameters: list[PointParameter]
    series: list[PointSeries]
    columns: list[_Column]


def read_points(response: httpx.Response) -> Points:
    """Read ``application/vnd.geoswarm.points``: a length, a JSON object of that length, columns of float32.

    Raises
    ------
    GeoswarmError
        When the block is not complete.
    """
    import numpy as np

    body = response.content
    size = int.from_bytes(body[:_LENGTH], "little")
    head: _Head = read_json(_Head, body[_LENGTH : _LENGTH + size], response)
    wanted = _LENGTH + size + 4 * head.count * sum(column.width for column in head.columns)
    if len(body) != wanted:
        raise not_ours(response, f"{wanted} bytes were announced, {len(body)} came")
    numbers = np.frombuffer(body, "<f4", offset=_LENGTH + size)
    columns: dict[str, dict[str, NDArray[np.float32]]] = {"own": {}, "parameter": {}, "misfit": {}, "response": {}}
    place = 0
    for column in head.columns:
        end = place + head.count * column.width
        shape = (head.count, column.width) if column.kind == "response" or column.width > 1 else (head.count,)
        columns.setdefault(column.kind, {})[column.name] = numbers[place:end].reshape(shape)
        place = end
    own = columns["own"]
    if missing := {"generation", "particle", "objective"} - set(own):
        raise not_ours(response, f"the block has no column {min(missing)!r}")
    return Points(
        failed=head.failed,
        left_out=head.left_out,
        source=head.source,
        parameters=head.parameters,
        series=head.series,
        generation=_whole(own["generation"]),
        particle=_whole(own["particle"]),
        objective=own["objective"],
        values=columns["parameter"],
        misfits=columns["misfit"],
        responses=columns["response"],
    )


def _whole(column: NDArray[np.float32]) -> NDArray[np.int64]:
    numbers = column.astype("int64")
    numbers.flags.writeable = False
    return numbers
