"""Every case of the verification manual holds."""

from __future__ import annotations

import pytest

from geoswarm.verification.case import Case
from geoswarm.verification.catalogue import find_cases
from geoswarm.verification.results import check_row
from geoswarm.verification.run import run_cases


@pytest.mark.parametrize("case", find_cases(), ids=lambda case: case.name)
def test_the_case_holds(case: Case) -> None:
    (outcome,) = run_cases([case])
    assert outcome.state == "holds", outcome.problem or [
        check_row(one)
        for one in outcome.answer.checks
        if not one.holds  # type: ignore[union-attr]
    ]
