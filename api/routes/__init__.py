"""The routes of /api/v1, /health and /metrics, one module a resource."""

from __future__ import annotations

from fastapi import APIRouter

from geoswarm.api.paths import API_PREFIX
from geoswarm.api.routes import (
    administration,
    events,
    examples,
    fit,
    forward_models,
    health,
    jobs,
    measurements,
    mesh,
    metrics,
    points,
    problems,
    results,
    session,
    statistics,
    uncertainty,
    workers,
)

__all__ = ["api_router", "health_router", "metrics_router"]

api_router = APIRouter(prefix=API_PREFIX)
for module in (
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
    forward_models,
    workers,
    session,
    administration,
    mesh,
):
    api_router.include_router(module.router)
health_router = health.router
metrics_router = metrics.router
