"""Problems in the making: mistakes by line, and the forward model meanwhile."""

from __future__ import annotations

from geoswarm.solver.problem import draft_of_document, draft_of_text

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
