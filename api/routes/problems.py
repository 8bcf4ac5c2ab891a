"""Problems before they become jobs."""

from __future__ import annotations

from dataclasses import asdict

import anyio
import anyio.to_thread
from fastapi import APIRouter, Request

from api.bodies import ProblemDocument
from api.dependencies import Service, problems_of
from api.routes.jobs import PROBLEM_BODY
from api.schemas import CheckResult, WarmStarts
from solver.problem import parse_problem

__all__ = ["router"]

router = APIRouter(prefix="/problems", tags=["problems"])


@router.post("/check", responses=problems_of(400, 408, 413, 415, 422), openapi_extra={"requestBody": PROBLEM_BODY})
async def check(document: ProblemDocument, request: Request, service: Service) -> CheckResult:
    """Validate a problem, make one test run and estimate the cost. Nothing is stored."""
    problem = await anyio.to_thread.run_sync(parse_problem, document)
    # One at a time, as a test run occupies a core; those who wait occupy no thread.
    report = await anyio.to_thread.run_sync(service.check, problem, limiter=_one_at_a_time(request))
    earlier = await anyio.to_thread.run_sync(service.warm_starts, problem)
    return CheckResult.model_validate(asdict(report) | {"warm_starts": [asdict(job) for job in earlier]})


@router.post(
    "/warm-starts", responses=problems_of(400, 408, 413, 415, 422), openapi_extra={"requestBody": PROBLEM_BODY}
)
async def warm_starts(document: ProblemDocument, service: Service) -> WarmStarts:
    """Name earlier jobs with the same forward model whose stored evaluations the search could learn from."""
    problem = await anyio.to_thread.run_sync(parse_problem, document)
    earlier = await anyio.to_thread.run_sync(service.warm_starts, problem)
    return WarmStarts.model_validate({"items": [asdict(job) for job in earlier]})


def _one_at_a_time(request: Request) -> anyio.CapacityLimiter:
    state = request.app.state
    if not hasattr(state, "test_runs"):
        state.test_runs = anyio.CapacityLimiter(1)
    limiter: anyio.CapacityLimiter = state.test_runs
    return limiter
