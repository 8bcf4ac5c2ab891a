"""What a job has found: generations, the best evaluation, all evaluations as JSON, CSV or Parquet."""

from __future__ import annotations

import csv
import io
import itertools
from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime
from typing import Annotated, Literal

from fastapi import APIRouter, Path, Query, Request, Response
from fastapi.responses import StreamingResponse

from geoswarm.api.dependencies import Cursor, JobId, Limit, Service, problems_of
from geoswarm.api.errors import DetailError
from geoswarm.api.parquet import parquet_available, parquet_pieces
from geoswarm.api.schemas.responses import (
    AttemptList,
    EvaluationPage,
    GenerationList,
)
from geoswarm.records.evaluation import COLUMNS, Best, Evaluation, EvaluationSort
from geoswarm.records.progress import Progress
from geoswarm.records.states import EvaluationState
from geoswarm.solver.system.extras import needs_extra
from geoswarm.solver.words import csv_cell

__all__ = ["csv_header", "csv_lines", "parquet_columns", "router"]

router = APIRouter(prefix="/jobs/{job_id}", tags=["results"])

BEFORE = tuple(column.name for column in COLUMNS if column.leading)
AFTER = tuple(column.name for column in COLUMNS if not column.leading)
LINES_A_CHUNK = 200
PARQUET = "application/vnd.apache.parquet"
MAX_GENERATION = 2**31 - 1  # what every database holds in a column of this kind


@router.get("/generations", responses=problems_of(404, 422))
def generations(
    job_id: JobId,
    service: Service,
    after: Annotated[int, Query(ge=-1, le=MAX_GENERATION, description="only generations with a higher number")] = -1,
    limit: Annotated[int, Query(ge=1, le=10_000)] = 1000,
    diversity: Annotated[bool, Query(description="also the scatter of the particles; reads all of them")] = False,
    points: Annotated[
        int | None,
        Query(ge=2, le=5000, description="at most this many, evenly spaced over all of them"),
    ] = None,
) -> GenerationList:
    """Show the progress of the search, one item per generation."""
    views = service.generations(job_id, after=after, limit=limit, points=points, diversity=diversity)
    return GenerationList(items=views)


@router.get("/progress", responses=problems_of(404))
def progress(job_id: JobId, service: Service) -> Progress:
    """Show the progress of the current generation: every finished run counts, even before its generation has ended."""
    return service.progress(job_id)


@router.get("/best", responses=problems_of(404))
def best(job_id: JobId, service: Service) -> Best:
    """Show the evaluation with the lowest objective so far, with its responses."""
    view = service.best(job_id)
    if view is None or view.objective is None:
        state = service.get(job_id).state
        raise DetailError(
            404,
            f"Job {job_id} ({state}) has no successful evaluation yet, so there is no best one.",
            kind="no-best-evaluation",
            title="No best evaluation yet",
        )
    problem = service.parsed_problem(job_id)
    return Best(
        generation=view.generation,
        particle=view.particle,
        objective=view.objective,
        parameters=problem.values([view.parameters[name] for name in problem.free_names]),
        misfits=view.misfits,
        responses=view.responses or {},
    )


@router.get(
    "/evaluations",
    response_model=EvaluationPage,
    responses={
        200: {
            "content": {
                "text/csv": {"schema": {"type": "string"}},
                PARQUET: {"schema": {"type": "string", "format": "binary"}},
            },
            "description": "Evaluations",
        },
        **problems_of(400, 404, 422, 501),
    },
)
def evaluations(
    job_id: JobId,
    request: Request,
    service: Service,
    format: Annotated[
        Literal["json", "csv", "parquet"] | None, Query(description="takes precedence over the Accept header")
    ] = None,
    generation: Annotated[int | None, Query(ge=0, le=MAX_GENERATION, description="only this generation")] = None,
    state: Annotated[EvaluationState | None, Query(description="only evaluations in this state")] = None,
    max_objective: Annotated[
        float | None, Query(allow_inf_nan=False, description="only evaluations with an objective up to this")
    ] = None,
    sort: Annotated[EvaluationSort, Query(description="what to order by")] = "generation",
    limit: Limit = 100,
    cursor: Cursor = None,
    responses: Annotated[bool, Query(description="with the calculated series (not in CSV)")] = False,
) -> Response | EvaluationPage:
    """Show evaluations, ordered by generation and particle, or in pages by objective.

    By objective the lowest comes first, ties by generation and particle; evaluations without an objective come last. A
    cursor is valid only for the order that it was returned in.

    JSON comes in pages. CSV is a stream of all matches (``sort``, ``limit`` and ``cursor`` are for JSON), with one
    column for each free parameter and each misfit, and numbers with all their digits. Parquet has the same columns
    with their types, and the calculated series as lists.
    """
    accepted = request.headers.get("accept", "")
    chosen = format or ("csv" if "text/csv" in accepted else "parquet" if PARQUET in accepted else "json")
    if chosen == "json":
        page = service.evaluations(
            job_id,
            generation=generation,
            state=state,
            max_objective=max_objective,
            limit=limit,
            cursor=cursor,
            responses=responses,
            sort=sort,
        )
        return EvaluationPage(items=page.items, next_cursor=page.next_cursor)
    names = service.get(job_id).free_parameters
    series = list(dict.fromkeys(item["series"] for item in service.problem(job_id)["observations"]))
    if chosen == "parquet":
        if not parquet_available():
            raise DetailError(
                501,
                f"{needs_extra('a service that writes Parquet', 'pyarrow')}.",
                kind="no-parquet",
                title="Parquet not available",
            )
        views = service.iterate_evaluations(
            job_id, generation=generation, state=state, max_objective=max_objective, responses=responses
        )
        return StreamingResponse(
            parquet_pieces(views, parquet_columns(names, series), series, responses=responses),
            media_type=PARQUET,
            headers={"Content-Disposition": f'attachment; filename="evaluations-{job_id}.parquet"'},
        )
    views = service.iterate_evaluations(job_id, generation=generation, state=state, max_objective=max_objective)
    return StreamingResponse(
        itertools.chain([_lines([csv_header(names, series)])], csv_lines(views, names, series)),
        media_type="text/csv; charset=utf-8; header=present",
        headers={"Content-Disposition": f'attachment; filename="evaluations-{job_id}.csv"'},
    )


@router.get("/evaluations/{generation}/{particle}", responses=problems_of(404, 422))
def evaluation(
    job_id: JobId,
    service: Service,
    generation: Annotated[int, Path(ge=0, le=MAX_GENERATION)],
    particle: Annotated[int, Path(ge=0, le=MAX_GENERATION)],
) -> Evaluation:
    """Show one evaluation, with its responses."""
    return service.evaluation(job_id, generation, particle)


@router.get("/evaluations/{generation}/{particle}/attempts", responses=problems_of(404, 422))
def attempts(
    job_id: JobId,
    service: Service,
    generation: Annotated[int, Path(ge=0, le=MAX_GENERATION)],
    particle: Annotated[int, Path(ge=0, le=MAX_GENERATION)],
) -> AttemptList:
    """Show every attempt at one evaluation: by whom, when, and how it ended."""
    return AttemptList(items=service.attempts(job_id, generation, particle))


def csv_header(names: Sequence[str], series: Sequence[str]) -> list[str]:
    """Column names; a parameter that is called like another column gets the prefix ``parameter.``."""
    taken = {*BEFORE, *AFTER}
    parameters = [f"parameter.{name}" if name in taken else name for name in names]
    return [*BEFORE, *parameters, *(f"misfit.{name}" for name in series), *AFTER]


def parquet_columns(names: Sequence[str], series: Sequence[str]) -> list[tuple[str, str, str]]:
    """The columns of the CSV, and where the value of each is."""
    own = [("own", name) for name in BEFORE]
    parameters = [("parameter", name) for name in names]
    misfits = [("misfit", name) for name in series]
    places = [*own, *parameters, *misfits, *(("own", name) for name in AFTER)]
    return [(header, *place) for header, place in zip(csv_header(names, series), places, strict=True)]


def csv_lines(views: Iterable[Evaluation], names: Sequence[str], series: Sequence[str]) -> Iterator[str]:
    """CSV of evaluations without the header, some hundred lines at a time."""
    remaining = iter(views)
    while chunk := list(itertools.islice(remaining, LINES_A_CHUNK)):
        yield _lines(_row(view, names, series) for view in chunk)


def _row(view: Evaluation, names: Sequence[str], series: Sequence[str]) -> list[object]:
    return [
        *(getattr(view, column) for column in BEFORE),
        *(view.parameters.get(name) for name in names),
        *(view.misfits.get(name) for name in series),
        *(getattr(view, column) for column in AFTER),
    ]


def _lines(rows: Iterable[Sequence[object]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\r\n").writerows([_cell(one) for one in row] for row in rows)
    return text.getvalue()


def _cell(value: object) -> object:
    return value.isoformat() if isinstance(value, datetime) else csv_cell(value)
