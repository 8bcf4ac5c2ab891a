"""Sizes of problems are counted before anything of that size is made."""

from __future__ import annotations

import copy
import time
from typing import Any

import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.examples import example_file
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.problem.text.reading import read_problem_file

PARAMETERS = {f"p{i}": {"lower": 0.0, "upper": 1.0} for i in range(30)}


@pytest.fixture(scope="module")
def slope() -> dict[str, Any]:
    with example_file("slope") as path:
        document = read_problem_file(path)
    document["observations"] = [
        {"series": f"{name}.ux", "points": {"x": [1.0], "y": [0.1]}} for name in document["forward_model"]["points"]
    ]
    return document


def document(points: int = 2, **sections: Any) -> dict[str, Any]:
    series = {"series": "y", "points": {"x": [float(i) for i in range(points)], "y": [1.0] * points}}
    return {
        "forward_model": {"kind": "formula", "series": {"y": " + ".join(f"{name} * x" for name in PARAMETERS)}},
        "parameters": PARAMETERS,
        "observations": [series],
        "stopping": {"max_evaluations": 20},
        **sections,
    }


@pytest.mark.parametrize(
    ("length", "elements"), [(1e-4, r"1.08e\+08"), (0.1, r"1.08e\+05"), (5e-324, "inf"), ([[0, 10], [9, 1e-9]], "")]
)
def test_elements_are_counted_before_the_mesh_is_made(slope: dict[str, Any], length: Any, elements: str) -> None:
    wanted = copy.deepcopy(slope)
    wanted["forward_model"]["element_length"] = length
    began = time.thread_time()
    with pytest.raises(
        ProblemError, match=f"element length, .* m .* {elements}.* elements; at most 100000 are accepted"
    ):
        parse_problem(wanted)
    assert time.thread_time() - began < 2.0


def test_many_marks_are_sorted_in_little_time(slope: dict[str, Any]) -> None:
    wanted = copy.deepcopy(slope)
    wanted["forward_model"]["element_length"] = 0.5
    wanted["forward_model"]["layers"][:0] = [
        {"name": f"layer{i}", "thickness": [[2.0 * k + 0.04 * i, 0.01] for k in range(500)]} for i in range(40)
    ]
    began = time.thread_time()
    with pytest.raises(ProblemError):
        parse_problem(wanted)
    assert time.thread_time() - began < 20.0


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        (document(200_001), "observations: have 200001 points; at most 200000 are accepted; resample: "),
        (
            document(method={"kind": "monte_carlo", "samples": 1_000_000, "sampling": "sobol"}, stopping={}),
            r"method.samples: 1000000 samples of 30 free parameters are 30000000 values, .* at most 20000000 are",
        ),
        (
            document(1000, stopping={"max_evaluations": 2_000_000}),
            "stopping.max_evaluations: 2000000 evaluations of 1000 points are 2000000000 values .* at most 1000000000",
        ),
        (
            document(1000, method={"kind": "monte_carlo", "samples": 5_000_000}, stopping={}),
            "method: 5000000 evaluations of 1000 points are 5000000000 values",
        ),
    ],
)
def test_sizes_are_refused_with_the_number_and_the_limit(wanted: dict[str, Any], message: str) -> None:
    with pytest.raises(ProblemError, match=f"^{message}"):
        parse_problem(wanted)


def test_what_is_just_within_the_limits_is_accepted() -> None:
    planned = document(100, method={"kind": "monte_carlo", "samples": 10_000_000}, stopping={})
    assert parse_problem(planned).planned_evaluations == 10_000_000
    assert parse_problem(document(200_000)).observations[0].x.size == 200_000


def test_mistakes_are_listed_up_to_a_hundred() -> None:
    unknown = {f"key{i}": 1 for i in range(5000)}
    with pytest.raises(ProblemError) as caught:
        parse_problem(document(**unknown, observations=[{"series": "y", **unknown}] * 100))
    assert len(caught.value.issues) == 101
    assert "more mistakes" in caught.value.issues[-1].message


def test_text_for_units_is_judged_quickly() -> None:
    observations = [
        {"series": "y", "points": {"x": [1.0], "y": [1.0]}, "x_unit": f"km^{33_000 + i}"} for i in range(50)
    ]
    began = time.thread_time()
    with pytest.raises(ProblemError, match="unknown unit 'km"):
        parse_problem(document(observations=observations))
    assert time.thread_time() - began < 4.0
