"""What is identified, and how well."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.dependencies import JobId, Service
from geoswarm.api.pages.frame import job_frame
from geoswarm.api.pages.shell import render

__all__ = ["router"]

router = APIRouter()


@router.get("/jobs/{job_id}/statistics", name="statistics_page")
def statistics_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show the statistics of a job."""
    return render(request, "statistics", plots=True, **job_frame(service, job_id))
