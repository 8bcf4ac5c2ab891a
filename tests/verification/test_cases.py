"""Every case of the verification manual holds."""

from __future__ import annotations

import pytest

from geoswarm.verification.case import Case
from geoswarm.verification.catalogue import find_cases
from geoswarm.verification.results import check_row
from geoswarm.verification.run import run_cases

LONG = {"fem-infinite-slope"}
"""In the long run only: tests/verification/fem/test_strength_change.py has infinite slopes by default."""


@pytest.mark.parametrize(
    "case",
    [pytest.param(case, id=case.name, marks=[pytest.mark.slow] if case.name in LONG else []) for case in find_cases()],
)
def test_the_case_holds(case: Case) -> None:
    (outcome,) = run_cases([case])
    assert outcome.state == "holds", outcome.problem or [
        check_row(one)
        for one in outcome.answer.checks
        if not one.holds  # type: ignore[union-attr]
    ]
