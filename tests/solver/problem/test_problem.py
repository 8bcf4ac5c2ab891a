"""The problem object and its assembly from documents."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.forward.registry import kinds
from geoswarm.solver.problem import Problem, parse_problem, problem_schema
from geoswarm.solver.problem.checks.feasibility import TRIED_POINTS


def _document(**changes: Any) -> dict[str, Any]:
    document: dict[str, Any] = {
        "forward_model": {"kind": "formula", "series": {"y": "a * x + b"}},
        "parameters": {"a": {"lower": 0.1, "upper": 10.0}, "b": {"lower": -1.0, "upper": 1.0}},
        "observations": [{"series": "y", "points": {"x": [0.0, 1.0], "y": [0.1, 1.2]}}],
        "stopping": {"max_evaluations": 100},
    }
    return document | changes


def _messages(document: dict[str, Any]) -> list[str]:
    with pytest.raises(ProblemError) as caught:
        parse_problem(document)
    return [str(issue) for issue in caught.value.issues]


def test_values_in_file_order_with_links_in_their_own() -> None:
    parameters = {
        "half": {"expression": "0.5 * double"},
        "double": {"expression": "2 * a"},
        "a": {"lower": 0.1, "upper": 10.0},
        "known": {"value": 3},
        "b": {"lower": -1, "upper": 1},
    }
    problem = parse_problem(_document(parameters=parameters))
    assert problem.free_names == ("a", "b")
    values = problem.values(np.array([4.0, 0.5]))
    assert list(values.items()) == [("half", 4.0), ("double", 8.0), ("a", 4.0), ("known", 3.0), ("b", 0.5)]
    assert all(type(value) is float for value in values.values())
    with pytest.raises(ValueError, match="argument"):
        problem.values([1.0])


def test_satisfies_judges_constraints_undefined_values_and_the_model() -> None:
    parameters = _document()["parameters"] | {"r": {"expression": "ln(b)"}}
    problem = parse_problem(_document(parameters=parameters, constraints=["a > b", "r != 7"]))
    assert problem.satisfies(problem.values([2.0, 0.5]))
    assert not problem.satisfies(problem.values([0.2, 0.5]))
    assert not problem.satisfies(problem.values([2.0, -0.5]))
    assert not problem.satisfies({"a": math.nan, "b": 0.5, "r": 1.0})


def test_an_undefined_constraint_is_not_satisfied() -> None:
    problem = parse_problem(_document(constraints=["not ln(b) > 1"]))
    assert problem.satisfies(problem.values([2.0, 0.5]))
    assert not problem.satisfies(problem.values([2.0, -0.5]))


def test_linked_parameters_stay_within_the_limits_of_the_model() -> None:
    document = {
        "forward_model": {
            "kind": "oedometer",
            "height": 0.02,
            "initial_stress": 1,
            "stages": [{"stress": 100, "duration": 1}],
        },
        "parameters": {
            "lambda_star": {"lower": 0.05, "upper": 0.2},
            "kappa_star": {"value": 0.01},
            "mu_star": {"value": 0.001},
            "c": {"lower": 0, "upper": 10},
            "phi": {"expression": "95 - c"},
        },
        "observations": [{"series": "settlement", "points": {"x": [1], "y": [0.001]}}],
        "stopping": {"max_seconds": 1},
    }
    problem = parse_problem(document)
    assert problem.satisfies(problem.values([0.1, 8.0]))
    assert not problem.satisfies(problem.values([0.1, 5.0]))


def test_arrays_and_tuples_are_accepted_for_lists() -> None:
    document = _document()
    document["observations"] = ({"series": "y", "points": {"x": np.array([0.0, 1.0]), "y": (0.1, np.float64(1.2))}},)
    assert parse_problem(document) == parse_problem(_document())


def test_defaults_are_written_out() -> None:
    document = parse_problem(_document()).document()
    assert document["method"]["kind"] == "particle_swarm"
    assert document["method"]["particles"] == "auto"
    assert document["parameters"]["a"] == {"lower": 0.1, "upper": 10.0, "scale": "linear"}
    assert document["observations"][0] == {"series": "y", "points": {"x": [0.0, 1.0], "y": [0.1, 1.2]}, "weight": 1.0}
    assert parse_problem(_document()) != parse_problem(_document(seed=1))
    assert parse_problem(_document()) != "something else"


def test_files_are_refused_where_none_can_be_read() -> None:
    document = _document(observations=[{"series": "y", "file": "data.csv"}])
    assert _messages(document) == [
        "observations[0].file: files can only be read beside a problem file; "
        "give the points themselves (points: {x: [..], y: [..]})"
    ]


def test_an_estimate_counts_in_the_search_for_a_feasible_point() -> None:
    narrow = ["abs(a - 1.2345) < 1e-9"]
    (message,) = _messages(_document(constraints=narrow))
    assert message.startswith("constraints[0]: 'abs(a - 1.2345) < 1e-9' holds at none of 10006 points tried")
    assert TRIED_POINTS == 10_000
    parameters = _document()["parameters"] | {"a": {"lower": 0.1, "upper": 10.0, "initial": 1.2345}}
    problem = parse_problem(_document(constraints=narrow, parameters=parameters))
    assert problem.free[0].initial == 1.2345


def test_a_corner_counts_in_the_search_for_a_feasible_point() -> None:
    problem = parse_problem(_document(constraints=["a >= 10", "b <= -1"]))
    assert problem.satisfies(problem.values([10.0, -1.0]))


def test_a_range_beyond_all_numbers_is_refused() -> None:
    parameters = {"a": {"lower": -1e308, "upper": 1e308}, "b": {"lower": -8e307, "upper": 8e307}}
    assert _messages(_document(parameters=parameters)) == [
        "parameters.a.upper: is too far from lower (-1e+308); the largest range is 1.79e308"
    ]


def test_very_many_mistakes_are_counted_not_listed() -> None:
    document = _document()
    document["observations"][0]["points"]["y"] = [math.nan] * 500
    messages = _messages(document)
    assert len(messages) == 21
    assert messages[-1] == "observations[0]: 480 more mistakes like these"


@pytest.mark.parametrize(
    ("section", "value", "message"),
    [
        ("parameters", {}, "parameters: must be a mapping of names, got an empty mapping"),
        ("parameters", {f"p{i}": {"value": 1} for i in range(101)}, "parameters: has 101 entries; at most 100"),
        ("observations", [], "observations: must be a list of 1 to 1000 observations, got an empty list"),
        ("observations", [3], "observations[0]: must be a mapping with keys such as series, "),
        ("method", None, "method: must be a mapping with a kind of particle_swarm, differential_evolution"),
        ("method", {"particles": 5}, "method.kind: is missing; known: particle_swarm, differential_evolution"),
        ("stopping", [], "stopping: must be a mapping with the keys max_evaluations, max_seconds, "),
        ("name", "", "name: must not be empty"),
        ("name", "x" * 201, "name: may have at most 200 characters"),
        ("seed", 2**53, f"seed: must be at most {2**53 - 1}"),
        ("seed", True, "seed: must be a whole number, got true"),
    ],
)
def test_sections_of_the_wrong_shape(section: str, value: Any, message: str) -> None:
    assert any(found.startswith(message) for found in _messages(_document(**{section: value})))


def test_the_schema_knows_every_section_and_every_kind() -> None:
    schema = problem_schema(programs=True)
    assert set(schema["properties"]) == {
        *("name", "forward_model", "parameters", "constraints", "observations", "method", "stopping", "seed"),
        *("weighting", "limits", "failures", "priority", "warm_start", "index_properties", "accept", "answer", "noise"),
        "tests",
    }
    assert schema["required"] == ["parameters"]
    assert schema["anyOf"] == [{"required": ["forward_model", "observations"]}, {"required": ["tests"]}]
    assert [choice["$ref"] for choice in schema["$defs"]["forward_model"]["oneOf"]] == [
        f"#/$defs/forward_model_{kind}" for kind in kinds()
    ]

    def references(value: Any) -> list[str]:
        if isinstance(value, dict):
            own = [value["$ref"]] if isinstance(value.get("$ref"), str) else []
            return own + [found for inner in value.values() for found in references(inner)]
        return [found for inner in value for found in references(inner)] if isinstance(value, list) else []

    found = references(schema)
    assert len(found) > 5
    assert all(reference.removeprefix("#/$defs/") in schema["$defs"] for reference in found)


_numbers = st.floats(-1e6, 1e6, allow_nan=False)
_names = st.from_regex(r"[a-wyz][a-z0-9_]{0,8}_", fullmatch=True)


@st.composite
def _problems(draw: st.DrawFn) -> dict[str, Any]:
    names = draw(st.lists(_names, min_size=2, max_size=5, unique=True))
    parameters: dict[str, Any] = {}
    for name in names[:-1]:
        lower = draw(st.floats(1e-9, 1e3))
        free = {
            "lower": lower,
            "upper": lower * draw(st.floats(1.5, 1e3)),
            "scale": draw(st.sampled_from(["linear", "log"])),
        }
        if draw(st.booleans()):
            free["initial"] = lower
        parameters[name] = draw(st.sampled_from([free, {"value": draw(_numbers)}]))
    parameters[names[0]] = {"lower": draw(st.floats(-9, 0)), "upper": 1}
    parameters[names[-1]] = {"expression": f"{draw(st.floats(-5, 5))} * {names[0]} + {names[-2]}"}
    x = draw(st.lists(_numbers, min_size=1, max_size=6))
    points: dict[str, Any] = {"x": x, "y": draw(st.lists(_numbers, min_size=len(x), max_size=len(x)))}
    if draw(st.booleans()):
        points["weight"] = [1, *draw(st.lists(st.floats(0, 9), min_size=len(x) - 1, max_size=len(x) - 1))]
    method = draw(
        st.sampled_from(
            [
                {"kind": "particle_swarm", "particles": 7, "form": "inertia_weight", "topology": "ring"},
                {"kind": "monte_carlo", "samples": 12, "sampling": "sobol"},
            ]
        )
    )
    document = {
        "name": draw(st.text(min_size=1, max_size=10).filter(str.isprintable)),
        "forward_model": {"kind": "formula", "series": {"s": {"expression": f"x * {names[0]}", "y_unit": "m"}}},
        "parameters": parameters,
        "constraints": [f"{names[0]} <= 1"],
        "observations": [{"series": "s", "points": points, "y_unit": draw(st.sampled_from(["m", "mm", "cm"]))}],
        "method": method,
        "stopping": {"max_evaluations": draw(st.integers(10, 1000))},
    }
    seed = draw(st.none() | st.integers(0, 2**53 - 1))
    return document if seed is None else document | {"seed": seed}


@settings(deadline=None)
@given(_problems())
def test_the_document_of_a_problem_gives_the_problem_again(document: dict[str, Any]) -> None:
    before = copy.deepcopy(document)
    problem = parse_problem(document)
    assert document == before
    canonical = problem.document()
    again = parse_problem(canonical)
    assert again.document() == canonical
    assert again == problem
    np.testing.assert_array_equal(again.observations[0].y, problem.observations[0].y)
    middle = [0.5 * (p.lower + p.upper) for p in problem.free]
    assert again.values(middle) == problem.values(middle)


_junk: st.SearchStrategy[Any] = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=5)
    | st.sampled_from(["a", "y", "formula"]),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(
                ["kind", "series", "lower", "upper", "value", "expression", "points", "x", "y", "weight", "a", "é."]
            ),
            inner,
            max_size=4,
        )
    ),
    max_leaves=8,
)


def _places(document: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    items = (
        document.items() if isinstance(document, dict) else enumerate(document) if isinstance(document, list) else ()
    )
    return [path, *(place for key, inner in items for place in _places(inner, (*path, key)))]


@settings(deadline=None)
@given(st.data(), _junk)
def test_junk_anywhere_gives_a_problem_or_issues(data: st.DataObject, junk: Any) -> None:
    document = copy.deepcopy(_document(constraints=["a > b"], name="n", seed=1, method={"kind": "particle_swarm"}))
    place = data.draw(st.sampled_from(_places(document)[1:]))
    inner: Any = document
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = junk
    assert _outcome(parse_problem, document)


def _outcome(parse: Callable[[dict[str, Any]], Problem], document: dict[str, Any]) -> bool:
    try:
        return bool(parse(document).free)
    except ProblemError as error:
        return bool(error.issues) and all(issue.message for issue in error.issues)
