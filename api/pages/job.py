"""What a job has found, live; its fit; its data."""

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


@router.get("/jobs/{job_id}/fit", name="fit_page")
def fit_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show how the best evaluation fits, series by series, with residuals and the diagrams of the tests."""
    return render(request, "fit", plots=True, **job_frame(service, job_id))


@router.get("/jobs/{job_id}/data", name="data_page")
def data_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show the problem and the readings of a job, and everything as files."""
    return render(request, "data", **job_frame(service, job_id))
