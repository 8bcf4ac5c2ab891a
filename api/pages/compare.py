"""Several jobs side by side."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.dependencies import Service
from geoswarm.api.pages.jobs import BADGES
from geoswarm.api.pages.shell import render
from geoswarm.solver.words import FITS

__all__ = ["router"]

router = APIRouter()

MOST_JOBS = 6


@router.get("/compare")
def compare_page(
    request: Request,
    service: Service,
    job: Annotated[list[str] | None, Query(max_length=MOST_JOBS, description="ids of two to six jobs")] = None,
) -> HTMLResponse:
    """Show jobs side by side; jobs that are not there answer as on their own page."""
    jobs = [service.get(job_id) for job_id in dict.fromkeys(job or [])]
    return render(request, "compare", plots=True, jobs=jobs, fits=FITS, badges=BADGES)
