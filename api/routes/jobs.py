"""Jobs: submit, list, show, cancel, pause, resume, delete."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Header, Query, Request, Response

from geoswarm.api.access.bodies import ProblemDocument
from geoswarm.api.dependencies import Cursor, JobId, Limit, Service, problems_of
from geoswarm.api.schemas.responses import JobChange, JobPage
from geoswarm.records.job import Job, Retry
from geoswarm.records.states import JobState
from geoswarm.solver.problem import parse_problem
from geoswarm.workers.queries.job_list import JobFilters, SortKey

__all__ = ["router"]

router = APIRouter(prefix="/jobs", tags=["jobs"])

PRINTABLE = r"^[^\x00-\x1f]*$"

PROBLEM_BODY = {
    "required": True,
    "description": "the problem, as in a problem file; observations carry their points",
    "content": {
        "application/json": {"schema": {"$ref": "#/components/schemas/Problem"}},
        "application/yaml": {"schema": {"type": "string"}},
    },
}


@router.post(
    "",
    status_code=201,
    responses={
        200: {"model": Job, "description": "The job that the same request has created before"},
        **problems_of(400, 408, 409, 413, 415, 422),
    },
    openapi_extra={"requestBody": PROBLEM_BODY},
)
def submit(
    document: ProblemDocument,
    service: Service,
    request: Request,
    response: Response,
    idempotency_key: Annotated[
        str | None,
        Header(min_length=1, max_length=200, description="the same key with the same body creates one job only"),
    ] = None,
) -> Job:
    """Submit a problem. It is checked as a whole first; nothing is stored if anything is wrong with it."""
    view, created = service.submit(parse_problem(document), idempotency_key=idempotency_key)
    response.status_code = 201 if created else 200
    response.headers["Location"] = request.app.url_path_for("show", job_id=view.id)
    return view


@router.get("", responses=problems_of(400, 422), name="list")
def list_jobs(
    service: Service,
    state: Annotated[list[JobState] | None, Query(description="only jobs in one of these states")] = None,
    q: Annotated[
        str | None,
        Query(max_length=200, pattern=PRINTABLE, description="text in name, model, method, owner, tags or id"),
    ] = None,
    owner: Annotated[str | None, Query(max_length=80, pattern=PRINTABLE, description="only jobs of this owner")] = None,
    tag: Annotated[str | None, Query(max_length=40, pattern=PRINTABLE, description="only jobs with this tag")] = None,
    parent: Annotated[
        str | None,
        Query(max_length=64, pattern=PRINTABLE, description="only follow-ups of this job; none: only other jobs"),
    ] = None,
    sort: Annotated[SortKey, Query(description="what to order by")] = "created",
    order: Annotated[
        Literal["ascending", "descending"] | None,
        Query(description="newest, best or largest first and names from A to Z when absent"),
    ] = None,
    trend: Annotated[
        int, Query(ge=0, le=60, description="maximum number of values of each job's convergence; 0: none")
    ] = 0,
    limit: Limit = 50,
    cursor: Cursor = None,
) -> JobPage:
    """List jobs, newest first by default; a cursor is valid only for the order that it was returned in."""
    ascending = None if order is None else order == "ascending"
    parents = None if parent is None else () if parent == "none" else (parent,)
    filters = JobFilters(tuple(state or ()), q, owner, sort, ascending, tag, parents)
    page = service.list(filters, limit=limit, cursor=cursor, trend=trend)
    return JobPage(items=page.items, next_cursor=page.next_cursor)


@router.get("/{job_id}", responses=problems_of(404))
def show(job_id: JobId, service: Service) -> Job:
    """Show a job."""
    return service.get(job_id)


@router.patch("/{job_id}", responses=problems_of(404, 408, 409, 413, 422))
def change(job_id: JobId, wanted: JobChange, service: Service) -> Job:
    """Change the stop criteria, name, tags or note of a job.

    A finished or cancelled job continues as if submitted with the stop criteria; name, tags and note change nothing
    else. The name is the one that the list, pages, reports and the problem of the job show from now on.
    """
    view = None if wanted.stopping is None else service.change_stopping(job_id, wanted.stopping)
    if view is not None and not wanted.labels:
        return view
    return service.label(job_id, wanted.tags, wanted.note, wanted.name)


@router.get("/{job_id}/problem", responses=problems_of(404))
def problem(job_id: JobId, service: Service) -> dict[str, Any]:
    """Show the problem that was submitted, complete: it can be submitted again."""
    return service.problem(job_id)


@router.post("/{job_id}/cancel", responses=problems_of(404, 409))
def cancel(job_id: JobId, service: Service) -> Job:
    """End a job now; its results are kept. Cancelling a cancelled job changes nothing."""
    return service.cancel(job_id)


@router.post("/{job_id}/pause", responses=problems_of(404, 409))
def pause(job_id: JobId, service: Service) -> Job:
    """Hold a queued or running job."""
    return service.pause(job_id)


@router.post("/{job_id}/resume", responses=problems_of(404, 409))
def resume(job_id: JobId, service: Service) -> Job:
    """Continue a paused job."""
    return service.resume(job_id)


@router.post("/{job_id}/retry-failed", responses=problems_of(404, 409))
def retry_failed(job_id: JobId, service: Service) -> Retry:
    """Rerun the failed evaluations of a paused or ended job, and only these.

    Results already given to the search stay: positions do not change, but the best evaluation may.
    """
    view, number = service.retry_failed(job_id)
    return Retry(evaluations=number, job=view)


@router.delete("/{job_id}", status_code=204, response_class=Response, responses=problems_of(404, 409))
def delete(job_id: JobId, service: Service) -> None:
    """Delete an ended job with everything that belongs to it."""
    service.delete(job_id)
