"""Slope, mesh and displacements."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.dependencies import JobId, Service
from geoswarm.api.pages.shell import render

__all__ = ["router"]

router = APIRouter()

KINDS = frozenset({"section", "finite_element"})


@router.get("/jobs/{job_id}/mesh", name="mesh_page")
def mesh_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show mesh and displacements of a job."""
    job = service.get(job_id)
    return render(request, "mesh", job=job, has_mesh=_has_mesh(service.problem(job_id)["forward_model"]))


def _has_mesh(section: dict[str, Any]) -> bool:
    """Whether a forward model, or a part of it, has a body; without building it."""
    sections = [section, *section["parts"].values()] if section["kind"] == "combined" else [section]
    return any(one["kind"] in KINDS for one in sections)
