"""The form of a new job."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.dependencies import Service
from geoswarm.api.pages.shell import render

__all__ = ["router"]

router = APIRouter()


@router.get("/new")
def new_page(
    request: Request,
    service: Service,
    from_job: Annotated[str | None, Query(alias="from", max_length=64, description="job to start from")] = None,
    example: Annotated[str | None, Query(max_length=64, description="example to start from")] = None,
) -> HTMLResponse:
    """Show the form, empty or filled from an earlier job or an example."""
    source = None if from_job is None else service.get(from_job)
    return render(request, "new", plots=True, source=source, example=example)
