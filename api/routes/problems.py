"""Problems before they become jobs."""

from __future__ import annotations

import threading
from dataclasses import asdict

from fastapi import APIRouter

from api.bodies import ProblemDocument
from api.dependencies import problems_of
from api.routes.jobs import PROBLEM_BODY
from api.schemas import CheckResult
from solver.check import check_problem
from solver.problem import parse_problem

__all__ = ["router"]

router = APIRouter(prefix="/problems", tags=["problems"])

one_at_a_time = threading.Lock()


@router.post("/check", responses=problems_of(400, 413, 415, 422), openapi_extra={"requestBody": PROBLEM_BODY})
def check(document: ProblemDocument) -> CheckResult:
    """Validate a problem, make one test run and estimate the cost. Nothing is stored."""
    problem = parse_problem(document)
    with one_at_a_time:  # a test run occupies a core
        report = check_problem(problem)
    return CheckResult.model_validate(asdict(report))
