"""What a check says of differences, and what every case declares."""

from __future__ import annotations

import re
from collections import Counter

import numpy as np
import pytest

from geoswarm.solver.errors import DivergedError
from geoswarm.verification.case import Answer, Case, Curve, Plot, check
from geoswarm.verification.catalogue import CHAPTERS, UnknownCaseError, find_cases
from geoswarm.verification.figure import COLOURS
from geoswarm.verification.provenance import provenance
from geoswarm.verification.results import check_row, outcomes_json, summary
from geoswarm.verification.run import run_cases

PLOT = Plot("x [-]", "y [-]", (Curve("", np.arange(2.0), np.arange(2.0)),))


def case_of(*checks: object, needs: tuple[str, ...] = (), problem: Exception | None = None) -> Case:
    """A case that answers with these checks, or breaks off."""

    def calculate() -> Answer:
        if problem is not None:
            raise problem
        return Answer(checks, PLOT)  # type: ignore[arg-type]

    return Case("a-case", "A case", "shows", "given", "source", "reference", "allowed", calculate, needs)


def test_a_difference_is_relative_unless_it_says_of_what() -> None:
    relative = check("a", "kPa", [1.0, 2.02], [1.0, 2.0], 0.02)
    assert relative.difference == pytest.approx(0.01)
    assert relative.worst == 1
    assert relative.holds
    absolute = check("a", "kPa", [1.0, 2.02], [1.0, 2.0], 0.01, scale=1.0, of="absolute")
    assert absolute.difference == pytest.approx(0.02)
    assert not absolute.holds
    row = check_row(absolute, plain=True)
    assert (row.quantity, row.values, row.ours, row.reference) == ("a [kPa]", "2", "2.02", "2")
    assert (row.difference, row.allowed, row.holds) == ("0.02 absolute", "0.01 absolute", False)
    assert check_row(check("a", "", 1.0, 2.0, 0.1, scale=4.0, of="the height")).difference == "0.25 of the height"


def test_one_reference_may_serve_all_values() -> None:
    assert check("a", "", [0.5, 0.6], 0.5, 0.3).differences == pytest.approx([0.0, 0.2])


@pytest.mark.parametrize("ours", [np.nan, np.inf])
def test_what_is_not_finite_fails(ours: float) -> None:
    one = check("a", "", [1.0, ours], 1.0, 1.0e9)
    assert one.worst == 1
    assert not one.holds
    (outcome,) = run_cases([case_of(one)])
    assert outcome.state == "fails"
    found = outcomes_json([outcome], provenance())
    assert not found["holds"]
    assert found["cases"][0]["checks"][0]["ours"] is None


def test_a_reference_of_zero_needs_a_scale_or_the_same_value() -> None:
    assert check("a", "", 0.0, 0.0, 1.0e-9).holds
    assert not check("a", "", 1.0e-30, 0.0, 1.0).holds


@pytest.mark.parametrize("more", [{"scale": 1.0}, {"of": "the height"}])
def test_a_scale_without_words_is_refused(more: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="a scale and what it is come together"):
        check("a", "", 1.0, 1.0, 0.1, **more)  # type: ignore[arg-type]


def test_a_check_without_values_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one value"):
        check("a", "", [], 1.0, 0.1)


def test_a_calculation_without_a_solution_is_a_case_that_fails() -> None:
    (outcome,) = run_cases([case_of(problem=DivergedError("no equilibrium"))])
    assert (outcome.state, outcome.answer, outcome.worst) == ("fails", None, None)
    assert "no equilibrium" in outcome.problem


def test_a_case_without_its_extra_is_left_out() -> None:
    outcomes = list(run_cases([case_of(needs=("no_such_module",)), case_of(check("a", "", 1.0, 1.0, 0.1))]))
    assert [one.state for one in outcomes] == ["left out", "holds"]
    assert outcomes[0].problem == "needs the extra no_such_module"
    assert summary(outcomes) == "1 of 2 cases hold, 1 left out"
    assert outcomes_json(outcomes, provenance())["holds"]


def test_the_worst_check_is_the_one_nearest_to_what_is_allowed() -> None:
    far, near = check("far", "", 1.1, 1.0, 1.0), check("near", "", 1.001, 1.0, 0.0011)
    (outcome,) = run_cases([case_of(far, near)])
    assert outcome.worst is near


def test_names_and_titles_are_their_own() -> None:
    cases = find_cases()
    assert len(cases) >= 40
    names = [*(one.name for one in cases), *(chapter.name for chapter in CHAPTERS)]
    for held in (names, [one.title for one in cases]):
        assert {word: count for word, count in Counter(held).items() if count > 1} == {}
    assert [name for name in names if not re.fullmatch(r"[a-z]+(-[a-z]+)*", name)] == []


@pytest.mark.parametrize("one", find_cases(), ids=lambda case: case.name)
def test_every_case_declares_what_its_page_needs(one: Case) -> None:
    assert one.title.isascii()  # GitHub and MkDocs make the same anchor of it
    assert one.shows.endswith(".")
    assert min(len(text) for text in (one.given, one.source, one.reference, one.allowed)) > 8


def test_a_chapter_stands_for_its_cases() -> None:
    chapter = CHAPTERS[4]
    assert find_cases([chapter.name]) == chapter.cases
    assert find_cases([chapter.cases[1].name, chapter.cases[0].name]) == chapter.cases[:2]
    with pytest.raises(UnknownCaseError) as unknown:
        find_cases(["nothing"])
    assert chapter.name in unknown.value.known
    assert len(COLOURS) == len(set(COLOURS))
