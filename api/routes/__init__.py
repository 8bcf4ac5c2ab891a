"""The routes of /api/v1, /health and /metrics, one module a resource; ``findings`` has the results of a job.

==================  ===============================================================================================
``administration``  for administrators: API keys, and how the installation is doing
``agents``          agents: workers that reach the service by HTTP and nothing else
``ags``             files in the AGS 4 format: what they hold, and the problem that some of it makes
``events``          live events of a job as server-sent events
``examples``        the examples that come with the program
``findings``        what the evaluations of a job tell: fit, points, statistics, uncertainty, fields
``forward_models``  installed forward models: their section of the problem file, parameters and series with units
``health``          health, for supervisors and load balancers; needs no API key
``hooks``           hooks: whom to tell when a job has ended
``jobs``            jobs: submit, list, show, cancel, pause, resume, delete
``measurements``    files of measurements, before they are part of a problem
``metrics``         metrics in the text format of Prometheus
``problems``        problems before they become jobs
``results``         what a job has found: generations, the best evaluation, all evaluations as JSON, CSV or Parquet
``session``         signing in: a browser gives its API key once and is known by a cookie afterwards
``workers``         processes that run forward calculations
==================  ===============================================================================================
"""

from __future__ import annotations

from fastapi import APIRouter

from geoswarm.api.routes import (
    administration,
    agents,
    ags,
    events,
    examples,
    forward_models,
    health,
    hooks,
    jobs,
    measurements,
    metrics,
    problems,
    results,
    session,
    workers,
)
from geoswarm.api.routes.findings import fit, mesh, statistics, uncertainty

__all__ = ["api_router", "health_router", "metrics_router"]

api_router = APIRouter()
for module in (
    agents,  # first, as theirs are most of all requests, and routes are tried in turn
    jobs,
    results,
    fit,
    statistics,
    uncertainty,
    events,
    problems,
    examples,
    measurements,
    ags,
    forward_models,
    workers,
    hooks,
    session,
    administration,
    mesh,
):
    api_router.include_router(module.router)
health_router = health.router
metrics_router = metrics.router
