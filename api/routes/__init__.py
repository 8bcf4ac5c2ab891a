"""The routes of /api/v1, /health and /metrics, one module a resource; ``findings`` has what a job tells."""

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
from geoswarm.api.routes.findings import fit, mesh, points, statistics, uncertainty

__all__ = ["api_router", "health_router", "metrics_router"]

api_router = APIRouter()
for module in (
    agents,  # first, as theirs are most of all requests, and routes are tried in turn
    jobs,
    results,
    fit,
    points,
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
