"""The dashboard: pages rendered on the server, one module each, made live by ``static/js``.

A page renders what its first paint needs; its script asks the routes of ``/api/v1`` for the rest, like any program.
"""

from __future__ import annotations

from fastapi import APIRouter

from geoswarm.api.pages import compare, job, jobs, mesh, new, search, sign_in, statistics, workers
from geoswarm.api.pages.shell import error_page, templates

__all__ = ["error_page", "router"]

router = APIRouter(include_in_schema=False)
for page in (jobs, compare, new, job, search, statistics, mesh, workers, sign_in):
    router.include_router(page.router)

MENU = (
    ("jobs", "Jobs", "/"),
    ("new", "New job", "/new"),
    ("compare", "Compare", "/compare"),
    ("workers", "Workers", "/workers"),
)
"""What the menu of every page leads to: view, words, address."""

JOB_TABS = (
    ("job", "Result", ""),
    ("fit", "Fit", "/fit"),
    ("statistics", "Trust", "/statistics"),
    ("search", "Search", "/search"),
    ("data", "Data", "/data"),
    ("mesh", "Slope and mesh", "/mesh"),
)
"""Pages of a job: view, words, address below that of the job. The mesh is for jobs that have one."""

templates.globals.update(menu=MENU, job_tabs=JOB_TABS)
