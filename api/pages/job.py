"""The pages of one job: result, fit, trust, search, data, mesh."""

from __future__ import annotations

import contextlib
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.dependencies import JobId, Service
from geoswarm.api.pages.convergence import convergence
from geoswarm.api.pages.shell import render
from geoswarm.solver.methods.registry import find_method
from geoswarm.solver.report.parts import LABELS
from geoswarm.workers.errors import JobNotFoundError
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.service.media_types import ENDINGS

__all__ = ["job_frame", "router"]

router = APIRouter()


WITH_BODY = frozenset({"section", "finite_element"})
MOST_POINTS = 1000


@router.get("/jobs/{job_id}", name="job_page")
def job_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show a job: its answer, its fit, its files, what to do next."""
    return render(
        request,
        "job",
        plots=True,
        attachments=service.attachments.list(job_id),
        attachment_mb=service.settings.attachment_mb,
        attachment_endings=[ending for endings in ENDINGS.values() for ending in endings],
        **job_frame(service, job_id),
    )


@router.get("/jobs/{job_id}/fit", name="fit_page")
def fit_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show how the best evaluation fits, series by series, with residuals and the diagrams of the tests."""
    return render(request, "fit", plots=True, **job_frame(service, job_id))


@router.get("/jobs/{job_id}/data", name="data_page")
def data_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show the problem and the readings of a job, and everything as files."""
    return render(request, "data", parts=LABELS, **job_frame(service, job_id))


def job_frame(service: JobService, job_id: str) -> dict[str, Any]:
    """Return ``job``, ``role`` (search, sampling or follow_up), ``parent`` (a job or None) and ``has_mesh``.

    Raises
    ------
    JobNotFoundError
        When there is no such job; a parent that has been deleted is None.
    """
    job = service.get(job_id)
    document = service.problem(job_id)
    parent = None
    if job.parent is not None:
        with contextlib.suppress(JobNotFoundError):  # deleted meanwhile, or not shown by a read-only link
            parent = service.get(job.parent)
    return {
        "job": job,
        "role": find_method(job.method).role,
        "parent": parent,
        "has_mesh": _has_body(document["forward_model"]),
    }


def _has_body(section: dict[str, Any]) -> bool:
    """Whether a forward model, or a part of it, has a body; without building it."""
    sections = [section, *section["parts"].values()] if section["kind"] == "combined" else [section]
    return any(one["kind"] in WITH_BODY for one in sections)


@router.get("/jobs/{job_id}/mesh", name="mesh_page")
def mesh_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show mesh and displacements of a job."""
    return render(request, "mesh", **job_frame(service, job_id))


@router.get("/jobs/{job_id}/search", name="search_page")
def search_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show how the search of a job went."""
    frame = job_frame(service, job_id)
    first = max(-1, frame["job"].generations - MOST_POINTS - 1)
    generations = service.generations(job_id, after=first, limit=MOST_POINTS) if frame["role"] == "search" else []
    return render(request, "search", plots=True, plot=convergence(generations), **frame)


@router.get("/jobs/{job_id}/statistics", name="statistics_page")
def statistics_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show the statistics of a job."""
    return render(request, "statistics", plots=True, **job_frame(service, job_id))
