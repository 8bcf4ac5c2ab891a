"""Series of different units without weights are warned of, with their shares."""

from __future__ import annotations

from typing import Any

import pytest

from geoswarm.solver.plausibility import implausible
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.sentences import plain


def warnings(*weights: float, **more: Any) -> list[str]:
    """A stress of 100 kPa, a strain and a void ratio."""
    units = {"q": "kPa", "strain": "", "void_ratio": ""}
    sizes = (100.0, 0.1, 0.2)
    document: dict[str, Any] = {
        "forward_model": {
            "kind": "formula",
            "series": {name: {"expression": "a * x", "y_unit": unit} for name, unit in units.items()},
        },
        "parameters": {"a": {"lower": 0, "upper": 1}},
        "observations": [
            {"series": name, "points": {"x": [0, 1], "y": [0, size]}, "weight": weight, "error": 0.01}
            for name, size, weight in zip(units, sizes, weights, strict=True)
        ],
        "stopping": {"max_evaluations": 10},
    }
    return [one for one in map(plain, implausible(parse_problem(document | more))) if "units" in one]


def test_different_units_without_weights_are_a_warning_with_the_shares() -> None:
    assert warnings(1.0, 1.0, 1.0) == [
        "series of different units (kPa and no unit) add up without weights: if each is missed by the same part of its "
        "range, q has 100 % and 2 of 3 series have less than 1 % of the objective. weighting: by_range counts every "
        "series alike, by_test every test, by_error every reading by its error"
    ]


@pytest.mark.parametrize("scheme", ["by_range", "by_test", "by_error"])
def test_a_scheme_is_an_answer(scheme: str) -> None:
    assert warnings(1.0, 1.0, 1.0, weighting=scheme) == []


def test_counting_readings_is_none() -> None:
    assert warnings(1.0, 1.0, 1.0, weighting="by_count") == warnings(1.0, 1.0, 1.0)


def test_so_are_weights_and_one_unit() -> None:
    assert warnings(1.0, 1e6, 1e6) == []
    assert warnings(0.0, 1.0, 1.0) == []
