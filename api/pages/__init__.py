"""The dashboard: pages rendered on the server, one module each, made live by ``static/js``.

A page renders what its first paint needs; its script asks the routes of ``/api/v1`` for the rest, like any program.

===============  =======================================================================================================
``compare``      several jobs side by side
``convergence``  the convergence plot of the first paint: drawn on the server, so that a job can be read without scripts
``frame``        what every page of a job needs: the job, what its method is for, what it follows, whether it has a body
``job``          what a job has found, live; its fit; its data
``jobs``         the list of jobs
``mesh``         slope, mesh and displacements
``new``          the form of a new job
``search``       how a search went: convergence, particles, every evaluation
``shell``        what all pages share: the templates, their words, and how one is rendered
``sign_in``      signing in with an API key
``sparkline``    the course of a search as a small line in a list
``statistics``   what is identified, and how well
``workers``      workers and operations
===============  =======================================================================================================
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
