"""A job, live."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.dependencies import JobId, Service
from geoswarm.api.pages.convergence import convergence
from geoswarm.api.pages.shell import render

__all__ = ["router"]

router = APIRouter()

MOST_POINTS = 1000


@router.get("/jobs/{job_id}", name="job_page")
def job_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show a job: progress, identified parameters, convergence."""
    job = service.get(job_id)
    generations = service.generations(job_id, after=max(-1, job.generations - MOST_POINTS - 1), limit=MOST_POINTS)
    return render(request, "job", plots=True, job=job, plot=convergence(generations))
