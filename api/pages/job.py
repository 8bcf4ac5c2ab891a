"""What a job has found, live."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.dependencies import JobId, Service
from geoswarm.api.pages.frame import job_frame
from geoswarm.api.pages.shell import render

__all__ = ["router"]

router = APIRouter()


@router.get("/jobs/{job_id}", name="job_page")
def job_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show a job: its answer, its fit, what to do next."""
    return render(request, "job", plots=True, **job_frame(service, job_id))
