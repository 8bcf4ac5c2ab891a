"""Workers and operations."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from api.dependencies import Service
from api.pages.shell import render

__all__ = ["router"]

router = APIRouter()


@router.get("/workers")
def workers_page(request: Request, service: Service) -> HTMLResponse:
    """Show who runs what, since when."""
    return render(request, "workers", workers=service.workers())
