"""Every verdict has a reason and a sentence, made from its record."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, get_args

import numpy as np
import pytest

from geoswarm.solver.identifiability import Linearisation
from geoswarm.solver.identifiability.stored.verdict_words import in_words
from geoswarm.solver.identifiability.stored.verdicts import Evidence, VerdictCode, VerdictKind
from tests.solver.identifiability.cases import X, free, linearised, problem_of

RUNS = Evidence("sampling", 42, 2.5, 3.5, 0.21, open_below=False, open_above=False)
OPTIMUM = Evidence("linearisation", 0, 2.5, 3.5, 0.21, open_below=False, open_above=False)
NOTHING = Evidence("none", 3)
TIED: dict[str, Any] = {"partners": (("b", -0.97), ("c", 0.62)), "partner_intervals": ((-0.98, -0.95), (0.51, 0.73))}
RANGE = ("2.5", "3.5", "21 %")

CASES: list[tuple[VerdictKind, VerdictCode, Evidence, tuple[str, ...]]] = [
    ("identified", "width", RUNS, ("42 good fits", *RANGE)),
    ("identified", "width", replace(OPTIMUM, hidden=0.37), ("its 95 % interval", *RANGE)),
    ("bounded_on_one_side", "width", replace(RUNS, open_below=True), (*RANGE, "reach the lower bound")),
    ("bounded_on_one_side", "width", replace(OPTIMUM, open_above=True), (*RANGE, "up to the upper bound")),
    ("not_identified", "width", replace(RUNS, unimodal=False), (*RANGE, "more than one group")),
    ("not_identified", "several", RUNS, (*RANGE, "more than one solution")),
    ("not_identified", "several", replace(OPTIMUM, elsewhere=(7.25,)), ("a = 3 or 7.25", "both")),
    ("not_identified", "several", replace(OPTIMUM, elsewhere=(7.25, 8.5)), ("a = 3, 7.25 or 8.5", "all of them")),
    ("not_identified", "several", replace(OPTIMUM, elsewhere=(3.0001,)), ("a = 3 or 3.0001", "both")),
    ("not_identified", "no_influence", OPTIMUM, ("no influence",)),
    ("not_identified", "no_influence", NOTHING, ("all runs gave the same objective",)),
    ("not_identified", "no_interval", OPTIMUM, ("wider than the searched range",)),
    ("in_combination", "tied", replace(OPTIMUM, partners=(("b", None), ("c", None))), ("b and c",)),
    ("in_combination", "correlated", replace(RUNS, **TIED), ("r = -0.97 (-0.98 to -0.95) with b", "0.62", "c", *RANGE)),
    ("undecided", "not_minimum", OPTIMUM, ("2.5 to 3.5", "3.2 standard errors")),
    ("undecided", "nonlinear", OPTIMUM, ("2.5 to 3.5", "44 %")),
    ("undecided", "no_error", replace(OPTIMUM, exact=True, spare=1), ("is only 1 more reading than",)),
    ("undecided", "no_error", replace(OPTIMUM, exact=True, spare=3), ("are only 3 more readings than",)),
    ("undecided", "unexplored", replace(OPTIMUM, elsewhere=(7.25, 8.5)), (*RANGE, "a = 7.25 and 8.5")),
    ("undecided", "untried", replace(OPTIMUM, exchangeable=("b", "c")), (*RANGE, "a and b or c may be exchanged")),
    ("lack_of_fit", "misfit", RUNS, ("the model does not describe the data", *RANGE)),
    ("error_not_met", "misfit", OPTIMUM, ("the stated error is not met", *RANGE)),
    ("undecided", "swarm", NOTHING, ("the runs of a search cluster",)),
    ("undecided", "few_good_fits", NOTHING, ("only 3 samples", "at least 10")),
    ("undecided", "thin", NOTHING, ("too thin to judge",)),
]


@pytest.fixture(scope="module")
def found() -> Linearisation:
    problem = problem_of("a * x", {"a": free()}, 3.0 * X + 0.05 * np.random.default_rng(4).standard_normal(X.size))
    made = linearised(problem, [3.0])
    return replace(made, distance=np.array([3.2]), bending=np.array([0.44]))


@pytest.mark.parametrize(("kind", "code", "evidence", "parts"), CASES)
def test_a_sentence_names_parameter_reason_and_values(
    found: Linearisation, kind: VerdictKind, code: VerdictCode, evidence: Evidence, parts: tuple[str, ...]
) -> None:
    reason, sentence = in_words("a", kind, code, evidence, found, "the sampling is too thin to judge")
    assert all(part in reason for part in parts), reason
    assert sentence.startswith("a is ")
    assert f": {reason}" in sentence
    assert sentence.endswith(".")
    assert "None" not in sentence
    assert "\n" not in sentence


def test_every_kind_and_code_is_worded() -> None:
    assert {kind for kind, *_ in CASES} == set(get_args(VerdictKind))
    assert {code for _, code, *_ in CASES} == set(get_args(VerdictCode))


def test_an_interval_says_where_it_holds_and_what_its_error_comes_from(found: Linearisation) -> None:
    def said(kind: VerdictKind = "identified", **known: Any) -> str:
        return in_words("a", kind, "width", replace(OPTIMUM, **known), found)[1]

    assert said().endswith("; it holds within its basin.")
    assert "another basin like it could still hide in 4 % of the searched space" in said(hidden=0.04)
    assert said(hidden=0.37).startswith("a is identified within one basin only: ")
    assert "the runs are sparse, and another basin like it could still hide in 37 %" in said(hidden=0.37)
    assert "estimated from only 3 more readings than parameters" in said(hidden=0.04, spare=3)
    assert "the width is that of rounding" in said(hidden=0.04, exact=True, spare=9)
    assert "basin" not in said("not_identified", hidden=0.04, spare=3)
