"""The list of jobs."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse

from api.dependencies import Service
from api.pages.shell import render

__all__ = ["router"]

router = APIRouter()


@router.get("/")
def jobs_page(
    request: Request, service: Service, cursor: Annotated[str | None, Query(max_length=500)] = None
) -> HTMLResponse:
    """List the jobs, newest first."""
    page = service.list(limit=50, cursor=cursor)
    return render(request, "jobs", page=page, first=cursor is None)
