"""What routes ask for: the service, the feed, and the errors that they document."""

from __future__ import annotations

import re
from typing import Annotated, Any

import anyio
from fastapi import Depends, Path, Query, Request

from geoswarm.api.errors import ProblemDetail, role_refused
from geoswarm.api.events.feed import EventFeed
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.errors import JobNotFoundError
from geoswarm.workers.service.job_service import JobService

__all__ = ["Cursor", "Feed", "JobId", "Limit", "Service", "limiter", "problems_of", "require_runs"]

NOBODY = Principal(None, "read")  # on routes that are open to everybody
AT_ONCE = {"test runs": 1, "drafts": 2, "files": 1, "probes": 4}
"""Requests worked on together: a test run occupies a core, drafts come with every change, files take memory, probes
have threads of their own."""
POSSIBLE_ID = re.compile(r"[A-Za-z0-9_-]{1,64}")


async def _service(request: Request) -> JobService:
    """The service with the permissions of the sender, which the gate has found."""
    service: JobService = request.app.state.service
    principal: Principal | None = getattr(request.state, "principal", None)
    return service.on_behalf_of(NOBODY if principal is None else principal)


def limiter(request: Request, name: str) -> anyio.CapacityLimiter:
    """Return what requests of one kind of :data:`AT_ONCE` wait at, holding no thread."""
    limiters: dict[str, anyio.CapacityLimiter] = request.app.state.limiters
    return limiters.setdefault(name, anyio.CapacityLimiter(AT_ONCE[name]))


def require_runs(service: JobService) -> None:
    """Refuse a forward run to a key that may only read."""
    if not service.principal.may("submit"):
        raise role_refused(service.principal.role, "a forward run needs 'submit' or 'admin'")


async def _feed(request: Request) -> EventFeed:
    feed: EventFeed = request.app.state.feed
    return feed


async def _job_id(job_id: Annotated[str, Path(description="id that POST /jobs answered with")]) -> str:
    if POSSIBLE_ID.fullmatch(job_id) is None:  # databases refuse some characters
        raise JobNotFoundError(job_id[:80])
    return job_id


Service = Annotated[JobService, Depends(_service)]
Feed = Annotated[EventFeed, Depends(_feed)]
JobId = Annotated[str, Depends(_job_id)]
Limit = Annotated[int, Query(ge=1, le=1000, description="most items in one answer")]
Cursor = Annotated[str | None, Query(description="next_cursor of the previous answer", max_length=500)]

MEANINGS = {
    400: "The body or a cursor cannot be read",
    401: "An API key is needed",
    403: "Host or origin are refused, the API key's role does not suffice, or its owner's quota is used up",
    404: "Not found",
    409: "Not possible in the present state",
    410: "The lease has ended: kill what runs for it",
    413: "The body is too large",
    408: "The body did not arrive in time",
    415: "The media type of the body is not supported",
    422: "The request is invalid; issues lists every mistake",
    501: "Not available in this installation",
    429: "Too many requests; Retry-After says when to come again",
    503: "Database or broker cannot be reached",
}


def problems_of(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Describe the problem details that a route may answer with, for the OpenAPI document."""
    schema = {"$ref": f"#/components/schemas/{ProblemDetail.__name__}"}
    return {
        status: {"description": MEANINGS[status], "content": {"application/problem+json": {"schema": schema}}}
        for status in sorted({*statuses, 401, 403, 429, 503})
    }
