"""The routes of /api/v1, /health and /metrics, one module a resource; ``findings`` has the results of a job.

==================  ===============================================================================================
``administration``  for administrators: API keys, and how the installation is doing
``agents``          agents: workers that reach the service by HTTP and nothing else
``ags``             files in the AGS 4 format: what they hold, and the problem that some of it makes
``attachments``     files that people attach to a job: list, attach, download, delete
``events``          live events of a job as server-sent events
``findings``        what the evaluations of a job tell: fit, points, statistics, uncertainty, fields
``forward_models``  installed forward models: their section of the problem file, parameters and series with units
``hooks``           hooks: whom to tell when a job has ended
``jobs``            jobs: submit, list, show, cancel, pause, resume, delete
``links``           read-only links: addresses that show one job to people without a key
``measurements``    files of measurements, before they are part of a problem
``metrics``         metrics in the text format of Prometheus
``problems``        problems before they become jobs, and the examples that come with the program
``results``         what a job has found: generations, the best evaluation, all evaluations as JSON, CSV or Parquet
``service``         the service itself: its health, without an API key, and its workers
``session``         signing in: a browser gives its API key once and is known by a cookie afterwards
==================  ===============================================================================================
"""

from __future__ import annotations

from fastapi import APIRouter

from geoswarm.api.routes import (
    administration,
    agents,
    ags,
    attachments,
    events,
    forward_models,
    hooks,
    jobs,
    links,
    measurements,
    metrics,
    problems,
    results,
    service,
    session,
)
from geoswarm.api.routes.findings import fit, mesh, statistics, uncertainty

__all__ = ["api_router", "health_router", "metrics_router"]

api_router = APIRouter()
for router in (
    agents.router,  # first, as theirs are most of all requests, and routes are tried in turn
    jobs.router,
    attachments.router,
    links.router,
    results.router,
    fit.router,
    statistics.router,
    uncertainty.router,
    events.router,
    problems.router,
    problems.examples_router,
    measurements.router,
    ags.router,
    forward_models.router,
    service.workers_router,
    hooks.router,
    session.router,
    administration.router,
    mesh.router,
):
    api_router.include_router(router)
health_router = service.health_router
metrics_router = metrics.router
