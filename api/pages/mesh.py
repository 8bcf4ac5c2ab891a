"""Slope, mesh and displacements."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.dependencies import JobId, Service
from geoswarm.api.pages.frame import job_frame
from geoswarm.api.pages.shell import render

__all__ = ["router"]

router = APIRouter()


@router.get("/jobs/{job_id}/mesh", name="mesh_page")
def mesh_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show mesh and displacements of a job."""
    return render(request, "mesh", **job_frame(service, job_id))
