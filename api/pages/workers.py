"""Workers and operations."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.pages.shell import render

__all__ = ["router"]

router = APIRouter()


@router.get("/workers")
def workers_page(request: Request) -> HTMLResponse:
    """Show who runs what, since when."""
    return render(request, "workers")
