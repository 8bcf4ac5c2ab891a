"""The part of both clients about single evaluations, the fit, points for plots, and bodies."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TypeVar

from geoswarm.client.bodies import Mesh, MeshFields
from geoswarm.client.calls import Call, job_path, present, reader
from geoswarm.client.fit import Fit
from geoswarm.client.models import Evaluation
from geoswarm.client.points import Points, read_points

__all__ = ["AsyncResults", "Results"]

T = TypeVar("T")


def _evaluation(job_id: str, generation: int, particle: int) -> Call[Evaluation]:
    return Call("GET", f"{job_path(job_id)}/evaluations/{generation:d}/{particle:d}", reader(Evaluation))


def _fit(job_id: str, generation: int | None, particle: int | None) -> Call[Fit]:
    return Call("GET", f"{job_path(job_id)}/fit", reader(Fit), present(generation=generation, particle=particle))


def _points(job_id: str, responses: bool) -> Call[Points]:
    return Call("GET", f"{job_path(job_id)}/points", read_points, present(responses=responses or None))


def _mesh(job_id: str, part: str | None, generation: int | None, particle: int | None) -> Call[Mesh]:
    query = present(part=part, generation=generation, particle=particle)
    return Call("GET", f"{job_path(job_id)}/mesh", reader(Mesh), query)


def _mesh_fields(
    job_id: str,
    part: str | None,
    generation: int | None,
    particle: int | None,
    start: str | None,
    end: str | None,
    since_beginning: bool,
) -> Call[MeshFields]:
    query = present(part=part, generation=generation, particle=particle, start=start, end=end)
    query |= present(since_beginning=since_beginning or None)
    return Call("GET", f"{job_path(job_id)}/mesh/fields", reader(MeshFields), query)


class Results(ABC):
    """What evaluations gave; part of :class:`geoswarm.client.Client`."""

    @abstractmethod
    def _send(self, call: Call[T]) -> T:
        """Send a request and read its answer."""

    def evaluation(self, job_id: str, generation: int, particle: int) -> Evaluation:
        """Show one evaluation with its responses."""
        return self._send(_evaluation(job_id, generation, particle))

    def fit(self, job_id: str, *, generation: int | None = None, particle: int | None = None) -> Fit:
        """Show measured points with the first, the best and one chosen evaluation, in the units of the problem."""
        return self._send(_fit(job_id, generation, particle))

    def points(self, job_id: str, *, responses: bool = False) -> Points:
        """Read all successful evaluations as arrays, a selection of long histories; with their calculated series."""
        return self._send(_points(job_id, responses))

    def mesh(
        self, job_id: str, *, part: str | None = None, generation: int | None = None, particle: int | None = None
    ) -> Mesh:
        """Show the mesh of an evaluation, the best one unless another is named; NotFoundError when there is none.

        Parameters
        ----------
        part
            Of a combined forward model; the first with a mesh when None.
        """
        return self._send(_mesh(job_id, part, generation, particle))

    def mesh_fields(
        self,
        job_id: str,
        *,
        part: str | None = None,
        generation: int | None = None,
        particle: int | None = None,
        start: str | None = None,
        end: str | None = None,
        since_beginning: bool = False,
    ) -> MeshFields:
        """Calculate displacements and strains of an evaluation by one forward run of the service, which it keeps.

        Parameters
        ----------
        part
            Of a combined forward model; the first with a mesh when None.
        start, end
            Phases at whose ends the period begins and ends; the usual one when None.
        since_beginning
            Begin before the first phase, whatever ``start`` says.
        """
        return self._send(_mesh_fields(job_id, part, generation, particle, start, end, since_beginning))


class AsyncResults(ABC):
    """What evaluations gave; part of :class:`geoswarm.client.AsyncClient`."""

    @abstractmethod
    async def _send(self, call: Call[T]) -> T:
        """Send a request and read its answer."""

    async def evaluation(self, job_id: str, generation: int, particle: int) -> Evaluation:
        """Show one evaluation with its responses."""
        return await self._send(_evaluation(job_id, generation, particle))

    async def fit(self, job_id: str, *, generation: int | None = None, particle: int | None = None) -> Fit:
        """Show measured points with the first, the best and one chosen evaluation, in the units of the problem."""
        return await self._send(_fit(job_id, generation, particle))

    async def points(self, job_id: str, *, responses: bool = False) -> Points:
        """Read all successful evaluations as arrays, a selection of long histories; with their calculated series."""
        return await self._send(_points(job_id, responses))

    async def mesh(
        self, job_id: str, *, part: str | None = None, generation: int | None = None, particle: int | None = None
    ) -> Mesh:
        """Show the mesh of an evaluation, the best one unless another is named; NotFoundError when there is none.

        Parameters
        ----------
        part
            Of a combined forward model; the first with a mesh when None.
        """
        return await self._send(_mesh(job_id, part, generation, particle))

    async def mesh_fields(
        self,
        job_id: str,
        *,
        part: str | None = None,
        generation: int | None = None,
        particle: int | None = None,
        start: str | None = None,
        end: str | None = None,
        since_beginning: bool = False,
    ) -> MeshFields:
        """Calculate displacements and strains of an evaluation by one forward run of the service, which it keeps.

        Parameters
        ----------
        part
            Of a combined forward model; the first with a mesh when None.
        start, end
            Phases at whose ends the period begins and ends; the usual one when None.
        since_beginning
            Begin before the first phase, whatever ``start`` says.
        """
        return await self._send(_mesh_fields(job_id, part, generation, particle, start, end, since_beginning))
