"""Measured and calculated series of a job in the user's units, and its evaluations as a block of numbers for plots."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from geoswarm.api.dependencies import JobId, Service, problems_of
from geoswarm.api.errors import DetailError
from geoswarm.api.points import MEDIA_TYPE, compressed, points_block
from geoswarm.records.fit import Fit, FitDiagrams
from geoswarm.workers.service.fit import diagrams_of, fit_of

__all__ = ["router"]

router = APIRouter(prefix="/jobs/{job_id}", tags=["results"])

MAX_NUMBER = 2**31 - 1


@router.get("/fit", responses=problems_of(404, 422))
def fit(
    job_id: JobId,
    service: Service,
    generation: Annotated[
        int | None, Query(ge=0, le=MAX_NUMBER, description="with particle: one more evaluation to show")
    ] = None,
    particle: Annotated[int | None, Query(ge=0, le=MAX_NUMBER)] = None,
) -> Fit:
    """Show measured points with what was calculated there, from stored responses; and the parameters with units."""
    if (generation is None) != (particle is None):
        raise DetailError(422, "generation and particle name an evaluation together: give both, or none.")
    chosen = None if generation is None or particle is None else (generation, particle)
    return fit_of(service, job_id, chosen)


@router.get("/diagrams", responses=problems_of(404))
def diagrams(job_id: JobId, service: Service) -> FitDiagrams:
    """Show the diagrams of the job's tests, measured and calculated: compression curves, stress paths and others.

    Empty for models without tests, and before an evaluation has succeeded.
    """
    return diagrams_of(service, job_id)


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
