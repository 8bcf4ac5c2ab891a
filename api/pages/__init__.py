"""The dashboard: pages rendered on the server, one module each, made live by ``static/js``.

A page renders what its first paint needs; its script asks the routes of ``/api/v1`` for the rest, like any program.
"""

from __future__ import annotations

from fastapi import APIRouter

from geoswarm.api.pages import compare, job, jobs, mesh, new, sign_in, statistics, workers
from geoswarm.api.pages.shell import error_page

__all__ = ["error_page", "router"]

router = APIRouter(include_in_schema=False)
for page in (jobs, compare, new, job, statistics, mesh, workers, sign_in):
    router.include_router(page.router)
