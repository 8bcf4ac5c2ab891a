"""Evaluations for plots: a block of numbers instead of thousands of JSON objects."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from geoswarm.api.dependencies import JobId, Service, problems_of
from geoswarm.api.points import MEDIA_TYPE, compressed, points_block

__all__ = ["router"]

router = APIRouter(prefix="/jobs/{job_id}", tags=["results"])


@router.get(
    "/points",
    response_class=Response,
    responses={
        200: {"content": {MEDIA_TYPE: {"schema": {"type": "string", "format": "binary"}}}, "description": "The block"},
        **problems_of(404, 422),
    },
)
def points(
    job_id: JobId,
    service: Service,
    request: Request,
    responses: Annotated[bool, Query(description="with the calculated values at the observed points")] = False,
) -> Response:
    """Give the successful evaluations as one block of float32, a selection of long histories; see docs/http-api.md."""
    job = service.statistics.stored(job_id)
    block = points_block(job.problem, job.samples, responses=responses)
    body, headers = compressed(block, request.headers.get("accept-encoding", ""))
    return Response(body, media_type=MEDIA_TYPE, headers=headers)
