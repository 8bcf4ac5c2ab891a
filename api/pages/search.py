"""How a search went: convergence, particles, every evaluation."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.dependencies import JobId, Service
from geoswarm.api.pages.convergence import convergence
from geoswarm.api.pages.frame import job_frame
from geoswarm.api.pages.shell import render

__all__ = ["router"]

router = APIRouter()

MOST_POINTS = 1000


@router.get("/jobs/{job_id}/search", name="search_page")
def search_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show how the search of a job went."""
    frame = job_frame(service, job_id)
    first = max(-1, frame["job"].generations - MOST_POINTS - 1)
    generations = service.generations(job_id, after=first, limit=MOST_POINTS) if frame["role"] == "search" else []
    return render(request, "search", plots=True, plot=convergence(generations), **frame)
