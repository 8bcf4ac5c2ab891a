"""Problems in the making: mistakes by line, and the forward model meanwhile."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

import pytest

from geoswarm.solver.problem import draft_of_document, draft_of_text, problem_schema
from geoswarm.solver.sentences import Key
from tests.contracts.repository import ROOT
from tests.solver.problem.test_selection import staged

TEXT = """\
name: clay
forward_model:
  kind: formula
  series:
    y: {expression: "a + b * x", x_unit: day, y_unit: m}
parameters:
  a: {lower: 2, upper: 1}
  b:
    value: 3
constraints:
  - a < 5
  - a <
observations:
  - series: z
    points: {x: [1, 2], y: [1, 2]}
stopping: {max_evaluations: 50}
"""


def test_every_mistake_has_its_line() -> None:
    draft = draft_of_text(TEXT)
    assert draft.problem is None
    assert draft.yaml == TEXT
    found = {issue.path: issue.line for issue in draft.issues}
    assert found == {"parameters.a.lower": 7, "constraints[1]": 12, "observations[0].series": 14}


def test_the_forward_model_is_known_while_the_rest_is_wrong() -> None:
    draft = draft_of_text(TEXT)
    assert draft.model is not None
    assert [info.name for info in draft.model.parameters] == ["a", "b"]
    assert [(info.name, info.x_unit, info.y_unit) for info in draft.model.series] == [("y", "day", "m")]
    assert draft_of_text(TEXT.replace("a + b * x", "a + (b")).model is None


def test_a_sound_problem_has_no_issues() -> None:
    sound = TEXT.replace("upper: 1}", "upper: 3}").replace("series: z", "series: y").replace("  - a <\n", "")
    draft = draft_of_text(sound)
    assert draft.issues == ()
    assert draft.problem is not None
    assert draft.problem.free_names == ("a",)


def test_mistakes_of_syntax_have_their_line_too() -> None:
    draft = draft_of_text("name: a\nparameters: [1\nstopping: 2\n")
    assert draft.document is None
    assert [issue.line for issue in draft.issues] == [3]
    assert [issue.line for issue in draft_of_text("name: a\nname: b\n").issues] == [2]


def test_a_document_is_written_and_its_lines_are_those_of_the_text() -> None:
    draft = draft_of_document({"name": "a", "parameters": {"c": {"lower": 2, "upper": 1}}, "speed": 3})
    assert draft.yaml == "name: a\nparameters:\n  c: {lower: 2, upper: 1}\nspeed: 3\n"
    lines = {issue.path: issue.line for issue in draft.issues}
    assert lines["parameters.c.lower"] == 3
    assert lines["speed"] == 4
    assert lines["forward_model"] is None


def test_a_problem_that_is_too_long_has_no_text() -> None:
    points = {"x": list(range(60_000)), "y": [0.5] * 60_000}
    draft = draft_of_document({"observations": [{"series": "y", "points": points}]})
    assert draft.yaml is None
    assert draft.issues


def formula(**changes: Any) -> dict[str, Any]:
    """A sound problem of a formula, changed."""
    return {
        "name": "a",
        "forward_model": {"kind": "formula", "series": {"y": {"expression": "a * x"}}},
        "parameters": {"a": {"lower": 0, "upper": 1}},
        "observations": [{"series": "y", "points": {"x": [1, 2], "y": [1, 2]}}],
        "stopping": {"max_evaluations": 50},
    } | changes


def observed(**keys: Any) -> dict[str, Any]:
    return formula(observations=[formula()["observations"][0] | keys])


def swarm(**keys: Any) -> dict[str, Any]:
    return formula(method={"kind": "particle_swarm", **keys})


OEDOMETER = staged().document()["forward_model"]


@pytest.mark.parametrize(
    ("document", "path", "named"),
    [
        (formula(stopping={}), "stopping", ["stopping.max_evaluations", "stopping.max_seconds"]),
        (swarm(form="constriction", inertia_weight=0.7), "method.inertia_weight", ["method.form", "method.form"]),
        (swarm(form="constriction", social_coefficient=1), "method", ["method.cognitive_coefficient"]),
        (swarm(acceleration="none", polish=True), "method.polish", ["method.acceleration"]),
        (observed(loss_scale=1), "observations[0]", ["observations[0].loss_scale", "observations[0].loss"]),
        (observed(x_from=2, x_to=1), "observations[0].x_to", ["observations[0].x_from"]),
        (observed(stage_x_from=1), "observations[0].stage_x_from", ["observations[0].x_from", "observations[0].x_to"]),
        (observed(resample={}), "observations[0].resample", ["observations[0].resample.per_decade"]),
        (formula(observations=2 * formula()["observations"]), "observations[1].series", ["observations[0]"]),
        (formula(observations=[{"series": "y", "file": "a.csv"}]), "observations[0].file", ["files"]),
        (formula(index_properties={"liquid_limit": 2, "plastic_limit": 30}), "index_properties", []),
        (formula(forward_model=OEDOMETER | {"unit_weight": 9}), "forward_model", ["forward_model.unit_weight"]),
        (formula(forward_model=OEDOMETER | {"zero_at_stage": 9}), "forward_model", ["forward_model.zero_at_stage"]),
    ],
)
def test_keys_in_messages_are_named_as_keys(document: Mapping[str, Any], path: str, named: list[str]) -> None:
    """The form of a new job words them by the labels of its fields."""
    (issue,) = (one for one in draft_of_document(document).issues if one.path == path)
    keys = [part.path for part in issue.parts if isinstance(part, Key)]
    assert keys[: len(named)] == named
    text = "".join(part for part in issue.parts if isinstance(part, str))
    assert issue.parts
    assert not re.search(r"[a-z]_[a-z]|: \{", text.replace("soft_l1", ""))


RAISED = re.compile(r"raise (?:ValueError|PydanticCustomError)\(((?:[^()]|\([^()]*\))*)\)")


def test_no_validator_names_a_key_in_plain_text() -> None:
    keys = set(re.findall(r'"([a-z]+(?:_[a-z]+)+)": \{', json.dumps(problem_schema())))
    assert {"smear_diameter", "loss_scale"} <= keys
    found = [
        (path.name, text)
        for path in (ROOT / "solver").rglob("*.py")
        if "_validator(" in (source := path.read_text(encoding="utf-8")) and path.parent.name != "registered"
        for raised in RAISED.findall(source)
        for text in re.findall(r'"([^"]* [^"]*)"', raised)
        if keys & set(re.findall(r"[a-z]+(?:_[a-z]+)+", text))
    ]
    assert not found
