"""The dashboard: pages rendered on the server, made live by ``static/js``.

A page renders what its first paint needs; its script asks the routes of ``/api/v1`` for the rest, like any program.

=================  =====================================================================================================
``convergence``    the convergence plot of the first paint, drawn on the server: a job can be read without scripts
``documentation``  the documentation of the installed version
``job``            the pages of one job: result, fit, trust, search, data, mesh
``jobs``           the list of jobs, several of them side by side, and the form of a new one
``shell``          what all pages share: the templates, their words, and how one is rendered
``service``        pages of the service itself: signing in, workers and operations
=================  =====================================================================================================
"""

from __future__ import annotations

from fastapi import APIRouter

from geoswarm.api.pages import documentation, job, jobs, service
from geoswarm.api.pages.shell import error_page, templates

__all__ = ["error_page", "router"]

router = APIRouter(include_in_schema=False)
for page in (jobs, job, service, documentation):
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

templates.globals.update(menu=MENU, job_tabs=JOB_TABS, chapters=documentation.CHAPTERS)
