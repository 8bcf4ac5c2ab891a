"""Runs cases and keeps what came of them."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from geoswarm.solver.errors import SolverError
from geoswarm.solver.system.extras import extra_of, has
from geoswarm.verification.case import Answer, Case, Check

__all__ = ["CaseResult", "State", "run_cases"]

State = Literal["holds", "fails", "left out"]


@dataclass(frozen=True, slots=True)
class CaseResult:
    """A case that was run, or why it could not be.

    Parameters
    ----------
    case
        Which.
    answer
        What it calculated; None when it was left out or broke off.
    seconds
        How long it took.
    problem
        Why it broke off, or which extra it needs; empty otherwise.
    state
        Of all checks together.
    """

    case: Case
    answer: Answer | None
    seconds: float
    problem: str
    state: State

    @property
    def worst(self) -> Check | None:
        """The check that is nearest to what is allowed, or the farthest beyond it; None without an answer."""
        if self.answer is None:
            return None
        return max(self.answer.checks, key=lambda one: one.difference / one.allowed)


def run_cases(cases: Sequence[Case]) -> Iterator[CaseResult]:
    """Run cases one after the other and yield each outcome when it is there."""
    for one in cases:
        yield _run(one)


def _run(one: Case) -> CaseResult:
    missing = [module for module in one.needs if not has(module)]
    if missing:
        extra = extra_of(missing[0]) or missing[0]
        return CaseResult(one, None, 0.0, f"needs the extra {extra}", "left out")
    began = time.perf_counter()
    try:
        answer = one.calculate()
    except SolverError as error:  # a calculation that finds no solution is a case that fails
        return CaseResult(one, None, time.perf_counter() - began, str(error), "fails")
    seconds = time.perf_counter() - began
    return CaseResult(one, answer, seconds, "", "holds" if all(c.holds for c in answer.checks) else "fails")
