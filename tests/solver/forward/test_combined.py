"""Several forward models at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import ForwardError, InfeasibleError, ProblemError
from geoswarm.solver.forward.base import ForwardModel, ForwardRun, ParameterInfo, SeriesInfo
from geoswarm.solver.forward.combined import CombinedModel, CombinedSpec
from geoswarm.solver.forward.formula import FormulaSpec


class _Closed:
    """A forward model with limits: y = p x, p between bounds."""

    open_parameters = False

    def __init__(self, info: ParameterInfo) -> None:
        self.parameters = (info,)
        self.series = (SeriesInfo("y", "line", "x", "", "y", ""),)

    def grid(self, series: str) -> FloatArray:
        return np.array([0.0, 1.0]) if series == "y" else np.empty(0)

    def check(self, parameters: Mapping[str, float]) -> str | None:
        assert set(parameters) <= {"p"}
        return f"p = {parameters['p']:g} is odd" if parameters.get("p", 0) % 2 else None

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        return lambda parameters: {name: parameters["p"] * x for name, x in points.items()}


def _formulas(**parts: str) -> ForwardModel:
    sections = {name: {"kind": "formula", "series": {"y": text}} for name, text in parts.items()}
    return CombinedSpec.model_validate({"kind": "combined", "parts": sections}).build()


def _closed(**limits: Any) -> _Closed:
    return _Closed(ParameterInfo("p", "p", "kPa", "Pressure.", **limits))


def test_series_are_named_by_part() -> None:
    model = _formulas(first="a * x", second="a + b")
    assert [info.name for info in model.series] == ["first.y", "second.y"]
    assert [info.name for info in model.parameters] == ["a", "b", "first.a", "second.a", "second.b"]
    assert model.open_parameters


def test_parameters_are_shared_unless_a_part_has_its_own() -> None:
    run = _formulas(first="a * x", second="a * x").prepare(
        {"second.y": np.array([1.0]), "first.y": np.array([1.0, 2.0])}
    )
    responses = run({"a": 3.0})
    assert list(responses) == ["second.y", "first.y"]
    np.testing.assert_array_equal(responses["first.y"], [3.0, 6.0])
    np.testing.assert_array_equal(responses["second.y"], [3.0])
    own = run({"a": 3.0, "second.a": 5.0})
    np.testing.assert_array_equal(own["first.y"], [3.0, 6.0])
    np.testing.assert_array_equal(own["second.y"], [5.0])


def test_only_parts_with_points_are_run() -> None:
    run = _formulas(first="a * x", second="b * x").prepare({"first.y": np.array([1.0])})
    np.testing.assert_array_equal(run({"a": 3.0})["first.y"], [3.0])


def test_missing_parameters() -> None:
    model = CombinedModel({"first": _closed(), "second": _closed(default=1.0), "third": _closed()})
    assert [info.name for info in model.missing([])] == ["p"]
    assert [info.name for info in model.missing(["first.p"])] == ["p"]
    assert model.missing(["p"]) == []
    assert model.missing(["first.p", "third.p"]) == []


def test_a_shared_parameter_has_the_narrowest_limits() -> None:
    wide = _closed(lower=0.0, upper=10.0, upper_open=True, default=2.0)
    narrow = _closed(lower=0.0, lower_open=True, default=3.0)
    shared, first, second = CombinedModel({"first": wide, "second": narrow}).parameters
    assert (shared.lower, shared.lower_open, shared.upper, shared.upper_open) == (0.0, True, 10.0, True)
    assert shared.default == 2.0
    assert (first.name, first.lower_open, first.upper) == ("first.p", False, 10.0)
    assert (second.name, second.lower_open, second.upper) == ("second.p", True, None)
    assert second.description == "Pressure, in second only."
    free, *_ = CombinedModel({"first": _closed(), "second": _closed()}).parameters
    assert (free.lower, free.lower_open, free.upper, free.upper_open) == (None, False, None, False)


def test_check_names_the_part() -> None:
    model = CombinedModel({"first": _closed(), "second": _closed()})
    assert model.check({"p": 2.0}) is None
    assert model.check({}) is None
    assert model.check({"p": 3.0}) == "first: p = 3 is odd"
    assert model.check({"p": 2.0, "second.p": 3.0, "other": 1.0}) == "second: p = 3 is odd"
    assert not model.open_parameters


def test_grid() -> None:
    model = CombinedModel({"first": _closed()})
    np.testing.assert_array_equal(model.grid("first.y"), [0.0, 1.0])


def test_a_part_that_cannot_be_prepared_is_named() -> None:
    section = {"kind": "oedometer", "height": 0.02, "initial_stress": 1, "stages": [{"stress": 9, "duration": 1}]}
    model = CombinedSpec.model_validate({"kind": "combined", "parts": {"first": section}}).build()
    with pytest.raises(ProblemError, match=r"^forward_model\.parts\.first\.initial_void_ratio: is missing"):
        model.prepare({"first.stage_void_ratio": np.array([1.0])})


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({}, "at least 1 item"),
        ({"a": {"kind": "nothing"}}, "unknown kind 'nothing'; known kinds: formula, combined"),
        ({"a": {"kind": "formula", "serie": {}}}, "Extra inputs are not permitted"),
        ({"a.b": {"kind": "formula", "series": {"y": "a"}}}, "should match pattern"),
        (
            {"a": {"kind": "combined", "parts": {"b": {"kind": "formula", "series": {"y": "a"}}}}},
            "part a is itself combined; list its parts here",
        ),
    ],
)
def test_refused(parts: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        CombinedSpec.model_validate({"kind": "combined", "parts": parts})


def test_the_section_is_written_with_all_of_its_parts() -> None:
    part = FormulaSpec.model_validate({"series": {"y": "a * x"}})
    spec = CombinedSpec(parts={"a": part})
    document = spec.model_dump(mode="json")
    assert document["parts"]["a"]["series"]["y"]["expression"] == "a * x"
    assert CombinedSpec.model_validate(document) == spec


def test_a_failure_names_its_part_and_keeps_its_reason() -> None:
    class Failing(_Closed):
        def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
            def run(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
                raise InfeasibleError(f"{', '.join(points)} has no value at p = {parameters['p']:g}")

            return run

    run = CombinedModel({"sound": _closed(), "dense": Failing(ParameterInfo("p", "p", "", "p."))}).prepare(
        {"sound.y": np.array([1.0]), "dense.y": np.array([1.0])}
    )
    with pytest.raises(ForwardError, match="dense: y has no value at p = 1") as caught:
        run({"p": 1.0})
    assert caught.value.reason == "infeasible"
