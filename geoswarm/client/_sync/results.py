# Generated from geoswarm/client/_async/results.py by scripts/generate_client.py; `make format` renews it.
"""What a job has evaluated: one by one, in pages, as files and arrays, its fit, and the bodies behind it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from geoswarm.client._sync.connection import Connection
from geoswarm.client.calls import Call, job_path, nothing, present, reader
from geoswarm.client.files import partial_file
from geoswarm.client.models import Mesh, MeshFields
from geoswarm.client.points import Points, read_points
from geoswarm.records.evaluation import Attempt, Best, Evaluation, EvaluationSort
from geoswarm.records.fit import Fit
from geoswarm.records.job import Generation
from geoswarm.records.record import Page

__all__ = [
    "attempts",
    "best",
    "download_evaluations",
    "evaluation",
    "evaluations",
    "fit",
    "generations",
    "iterate_evaluations",
    "mesh",
    "mesh_fields",
    "points",
]


def best(self: Connection, job_id: str) -> Best:
    """Show the best evaluation with its responses; NotFoundError when there is none yet.

    Examples
    --------
    >>> best = client.best(job.id)
    >>> round(best.parameters["b"], 2)
    2.0
    """
    return self._send(Call("GET", f"{job_path(job_id)}/best", reader(Best)))


def generations(
    self: Connection,
    job_id: str,
    *,
    after: int = -1,
    limit: int = 1000,
    diversity: bool = False,
    points: int | None = None,
) -> tuple[Generation, ...]:
    """Show finished generations with a number above ``after``; with ``diversity`` also their scatter.

    Parameters
    ----------
    points
        At most this many, evenly spaced over all of them.

    Examples
    --------
    >>> generations = client.generations(job.id)
    >>> generations[-1].evaluations
    60
    """
    query = present(after=after, limit=limit, diversity=diversity or None, points=points)
    return self._send(Call("GET", f"{job_path(job_id)}/generations", reader(tuple[Generation, ...], "items"), query))


def evaluations(
    self: Connection,
    job_id: str,
    *,
    generation: int | None = None,
    state: str | None = None,
    max_objective: float | None = None,
    limit: int = 100,
    cursor: str | None = None,
    responses: bool = False,
    sort: EvaluationSort | None = None,
) -> Page[Evaluation]:
    """Show one page of evaluations, ordered by generation and particle.

    Parameters
    ----------
    sort
        ``"objective"``: the lowest objective first, those without one last.

    Examples
    --------
    >>> page = client.evaluations(job.id, limit=5)
    >>> len(page.items)
    5
    >>> (client.evaluations(job.id, sort="objective")).items[0].objective == job.objective
    True
    """
    query = present(
        generation=generation,
        state=state,
        max_objective=max_objective,
        limit=limit,
        cursor=cursor,
        responses="true" if responses else "false",
        sort=sort,
        format="json",
    )
    return self._send(Call("GET", f"{job_path(job_id)}/evaluations", reader(Page[Evaluation]), query))


def iterate_evaluations(
    self: Connection,
    job_id: str,
    *,
    generation: int | None = None,
    state: str | None = None,
    max_objective: float | None = None,
    responses: bool = False,
    sort: EvaluationSort | None = None,
) -> Iterator[Evaluation]:
    """Go through all evaluations that match, in the order of ``sort`` as in :meth:`evaluations`.

    Examples
    --------
    >>> objectives = [one.objective for one in client.iterate_evaluations(job.id)]
    >>> len(objectives)
    60
    """
    cursor = None
    while True:
        page = evaluations(
            self,
            job_id,
            generation=generation,
            state=state,
            max_objective=max_objective,
            limit=500,
            cursor=cursor,
            responses=responses,
            sort=sort,
        )
        yield from page.items
        if (cursor := page.next_cursor) is None:
            return


def download_evaluations(
    self: Connection,
    job_id: str,
    path: str | Path,
    *,
    generation: int | None = None,
    state: str | None = None,
    max_objective: float | None = None,
    form: Literal["csv", "parquet"] = "csv",
    responses: bool = False,
) -> Path:
    """Write all matching evaluations to a CSV or Parquet file; the file appears only when it is complete.

    Parameters
    ----------
    responses
        Include the calculated series; Parquet only.

    Examples
    --------
    >>> path = client.download_evaluations(job.id, "runs.csv")
    >>> path.name
    'runs.csv'
    """
    query = present(generation=generation, state=state, max_objective=max_objective, format=form)
    if responses:
        query["responses"] = "true"
    with partial_file(Path(path)) as file:
        self._download(Call("GET", f"{job_path(job_id)}/evaluations", nothing, query), file)
    return Path(path)


def evaluation(self: Connection, job_id: str, generation: int, particle: int) -> Evaluation:
    """Show one evaluation with its responses.

    Examples
    --------
    >>> one = client.evaluation(job.id, 0, 3)
    >>> one.state, sorted(one.parameters)
    ('finished', ['a', 'b'])
    """
    return self._send(Call("GET", f"{job_path(job_id)}/evaluations/{generation:d}/{particle:d}", reader(Evaluation)))


def attempts(self: Connection, job_id: str, generation: int, particle: int) -> tuple[Attempt, ...]:
    """Show every attempt at one evaluation: by whom, when, and how it ended.

    Examples
    --------
    >>> tries = client.attempts(job.id, 0, 3)
    >>> [(one.number, one.outcome) for one in tries]
    [(1, 'finished')]
    """
    path = f"{job_path(job_id)}/evaluations/{generation:d}/{particle:d}/attempts"
    return self._send(Call("GET", path, reader(tuple[Attempt, ...], "items")))


def fit(self: Connection, job_id: str, *, generation: int | None = None, particle: int | None = None) -> Fit:
    """Show measured points with the first, the best and one chosen evaluation, in the units of the problem.

    Examples
    --------
    >>> fit = client.fit(job.id)
    >>> fit.series[0].series
    'y'
    """
    query = present(generation=generation, particle=particle)
    return self._send(Call("GET", f"{job_path(job_id)}/fit", reader(Fit), query))


def points(self: Connection, job_id: str, *, responses: bool = False) -> Points:
    """Read all successful evaluations as arrays, a selection of long histories; with their calculated series.

    Examples
    --------
    >>> points = client.points(job.id)
    >>> points.objective.shape, sorted(points.values)
    ((60,), ['a', 'b'])
    """
    query = present(responses=responses or None)
    return self._send(Call("GET", f"{job_path(job_id)}/points", read_points, query))


def mesh(
    self: Connection,
    job_id: str,
    *,
    part: str | None = None,
    generation: int | None = None,
    particle: int | None = None,
) -> Mesh:
    """Show the mesh of an evaluation, the best one unless another is named; NotFoundError when there is none.

    Parameters
    ----------
    part
        Part of a combined forward model; the first with a mesh when None.

    Examples
    --------
    >>> mesh = client.mesh(slope.id)
    >>> mesh.triangles.shape
    (192, 6)
    """
    query = present(part=part, generation=generation, particle=particle)
    return self._send(Call("GET", f"{job_path(job_id)}/mesh", reader(Mesh), query))


def mesh_fields(
    self: Connection,
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
        Part of a combined forward model; the first with a mesh when None.
    start, end
        Phases at whose ends the period starts and ends; the usual period when None.
    since_beginning
        Start before the first phase, regardless of ``start``.

    Examples
    --------
    >>> fields = client.mesh_fields(slope.id)
    >>> fields.shear_strain.shape
    (192, 6)
    """
    query = present(part=part, generation=generation, particle=particle, start=start, end=end)
    query |= present(since_beginning=since_beginning or None)
    return self._send(Call("GET", f"{job_path(job_id)}/mesh/fields", reader(MeshFields), query))
