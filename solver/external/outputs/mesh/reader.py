"""Series from results on meshes.

::

    toe: {file: result.pvd, point: [12.0, 0.0], field: displacement, component: y, x_unit: day, y_unit: m}
    trough: {file: result.pvd, points: [[0, 0], [5, 0], [10, 0]], field: displacement, component: y, time: 365}
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import accumulate, pairwise
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from geoswarm.solver.external.errors import OutputError
from geoswarm.solver.external.outputs.base import FROM_LIST, Point, ScaledReader
from geoswarm.solver.external.outputs.mesh.sampling import Sampler
from geoswarm.solver.external.outputs.mesh.snapshots import Snapshot, needed_package, snapshots

__all__ = ["MeshReader"]

_Coordinates = Annotated[tuple[float, ...], FROM_LIST, Field(min_length=2, max_length=3)]
_ENDINGS = (".pvd", ".vtu", ".pvtu", ".xdmf", ".xmf")


class MeshReader(ScaledReader):
    """A field at a point over time, or at several points at one time.

    Values at nodes are interpolated by the shape functions of the element that holds the point; values of elements are
    taken as they are.
    """

    told_by: ClassVar[str] = "a mesh (file, point or points, and field)"

    format: Literal["mesh"] = Field("mesh", description="May be left out.")
    point: _Coordinates | None = Field(None, description="x and y, or x, y and z; the series is over time.")
    points: Annotated[tuple[_Coordinates, ...], FROM_LIST] | None = Field(
        None, min_length=1, max_length=10_000, description="Several points; the series is along them, at one time."
    )
    field: str = Field(min_length=1, max_length=200, description="Name of the field, such as displacement.")
    component: Literal["x", "y", "z", "magnitude"] | Annotated[int, Field(ge=1, le=100)] | None = Field(
        None, description="Which one: x, y, z, magnitude, or the number of the component, from 1; none for a scalar."
    )
    along: Literal["distance", "x", "y", "z"] = Field(
        "distance", description="x of the series for points: distance from the first one along them, or a coordinate."
    )
    time: float | None = Field(None, description="Time of the file at which points are taken; otherwise the last.")

    @field_validator("file")
    @classmethod
    def _is_mesh(cls, name: str) -> str:
        if not name.lower().endswith(_ENDINGS):
            raise ValueError(f"'{name[:60]}' must be named {', '.join(_ENDINGS)} to be read as results on a mesh")
        return name

    @model_validator(mode="after")
    def _one_way(self) -> MeshReader:
        if (self.point is None) == (self.points is None):
            raise ValueError("give either point, for a series over time, or points, for a series along them")
        if self.point is not None and (self.time is not None or self.along != "distance"):
            raise ValueError("time and along are for points; a series at one point is over time")
        if self.points is not None:
            if len({len(one) for one in self.points}) > 1:
                raise ValueError("points have two coordinates, or all of them three")
            if self.along == "z" and len(self.points[0]) == 2:
                raise ValueError("along: z needs points with three coordinates")
        return self

    @property
    def lacks(self) -> str | None:
        """meshio, or h5py for XDMF, where they are not installed."""
        return needed_package(self.file)

    def scan(self, folder: Path) -> Iterator[Point]:
        """Give the values, one snapshot in memory at a time."""
        if self.point is not None:
            sampler = self._sampler(self.point)
            for snapshot in snapshots(folder, self.file):
                value, where = sampler.value(snapshot)
                yield Point(snapshot.time, self.y_factor * value, 0, where)
            return
        snapshot = self._snapshot(folder)
        points = self.points or ()
        for at, point in zip(self._distances(points), points, strict=True):
            value, where = self._sampler(point).value(snapshot)
            yield Point(at, self.y_factor * value, 0, where)

    def _sampler(self, point: tuple[float, ...]) -> Sampler:
        return Sampler(self.file, point, self.field, self.component)

    def _snapshot(self, folder: Path) -> Snapshot:
        last: Snapshot | None = None
        times: list[float] = []
        for snapshot in snapshots(folder, self.file):
            if self.time is not None and math.isclose(snapshot.time, self.time, rel_tol=1e-9):
                return snapshot
            times.append(snapshot.time)
            last = snapshot
        if last is None:
            raise OutputError("bad_output", f"{self.file}: there is no time in it; at least one is expected")
        if self.time is not None:
            near = ", ".join(f"{time:g}" for time in sorted(times, key=lambda one: abs(one - (self.time or 0.0)))[:5])
            raise OutputError("bad_output", f"{self.file}: no results at time {self.time:g}; the nearest are at {near}")
        return last

    def _distances(self, points: Sequence[tuple[float, ...]]) -> list[float]:
        if self.along != "distance":
            return [point["xyz".index(self.along)] for point in points]
        lengths = [math.dist(before, after) for before, after in pairwise(points)]
        return [0.0, *accumulate(lengths)]
