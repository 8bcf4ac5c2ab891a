"""Workers and operations."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.pages.shell import render
from geoswarm.solver.system.versions import versions

__all__ = ["router"]

router = APIRouter()


@router.get("/workers")
def workers_page(request: Request) -> HTMLResponse:
    """Show workers and their work."""
    return render(request, "workers", version=versions()["geoswarm"])
