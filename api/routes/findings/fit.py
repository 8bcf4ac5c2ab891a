"""Measured and calculated series of a job, in the units that the user gave."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from geoswarm.api.dependencies import JobId, Service, problems_of
from geoswarm.api.errors import DetailError
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
