"""Index properties let expect values of parameters: through what laws declare, as their sources write them."""

from __future__ import annotations

import math
from typing import Any

import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.parameter_estimates.index import estimates_of
from geoswarm.solver.parameter_estimates.proposal import ordered, proposed, with_parameters
from geoswarm.solver.plausibility import implausible
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.sentences import plain


def problem(material: str, parameters: dict[str, Any], properties: dict[str, Any], **model: Any) -> Problem:
    """An oedometer test with index properties."""
    stages = [{"stress": stress, "duration": 1.0} for stress in (100.0, 200.0)]
    section = {"kind": "oedometer", "material": material, "height": 0.02, "initial_stress": 50.0, "stages": stages}
    return parse_problem(
        {
            "forward_model": {**section, **model},
            "parameters": parameters,
            "observations": [{"series": "stage_settlement", "points": {"x": [1.0, 2.0], "y": [0.001, 0.002]}}],
            "stopping": {"max_evaluations": 10},
            "index_properties": properties,
        }
    )


SOFT: dict[str, Any] = {
    "lambda_star": {"lower": 0.01, "upper": 0.3},
    "kappa_star": {"lower": 0.002, "upper": 0.1},
    "mu_star": {"value": 1.0e-3},
    "c": {"value": 1.0},
    "phi": {"lower": 15.0, "upper": 40.0},
}
PROPERTIES = {"plasticity_index": 40.0, "void_ratio": 1.5, "soil_class": "organic_clay"}


def by_equation(one: Problem) -> dict[tuple[str, str], float]:
    return {(e.parameter, e.correlated.correlation.equation): e.value for e in estimates_of(one)}


def test_soft_soil_takes_lambda_star_as_it_is_published() -> None:
    found = by_equation(problem("soft_soil_creep", SOFT, PROPERTIES))
    assert found["lambda_star", "2.303 (1 + e_0) I_P/500"] == pytest.approx(40.0 / 500.0)
    assert found["lambda_star", "G_s I_P/200"] == pytest.approx(2.7 * 40.0 / 200.0 / (math.log(10.0) * 2.5))
    assert found["phi", "sin φ = 0.8 - 0.094 ln I_P"] == pytest.approx(26.96, abs=0.01)
    # C_alpha/Cc = 0.05 times the middle one of five Cc, translated as lambda* is
    middle = sorted(value for (name, _), value in found.items() if name == "lambda_star")[2]
    assert found["mu_star", "0.05"] == pytest.approx(0.05 * middle)


def test_cam_clay_takes_lambda_without_a_void_ratio_and_both_forms_of_friction() -> None:
    parameters: dict[str, Any] = {
        "lambda": {"lower": 0.05, "upper": 0.5},
        "kappa": {"value": 0.03},
        "M": {"lower": 0.5, "upper": 1.5},
        "nu": {"value": 0.25},
        "e0": {"value": 1.2},
    }
    found = by_equation(problem("modified_cam_clay", parameters, {"plasticity_index": 40.0}))
    assert found["lambda", "G_s I_P/200"] == pytest.approx(2.7 * 40.0 / 200.0 / math.log(10.0))
    sine = 0.8 - 0.094 * math.log(40.0)
    assert found["M", "sin φ = 0.8 - 0.094 ln I_P"] == pytest.approx(6.0 * sine / (3.0 - sine))


def test_the_void_ratio_of_the_test_goes_before_that_of_the_index_properties() -> None:
    found = by_equation(problem("soft_soil_creep", SOFT, PROPERTIES, initial_void_ratio=1.0))
    assert found["lambda_star", "G_s I_P/200"] == pytest.approx(2.7 * 40.0 / 200.0 / (math.log(10.0) * 2.0))


def test_bounds_that_leave_out_all_that_is_expected_are_reported() -> None:
    narrow = SOFT | {"lambda_star": {"lower": 0.002, "upper": 0.01}, "kappa_star": {"value": 0.001}}
    warnings = [
        one for one in map(plain, implausible(problem("soft_soil_creep", narrow, PROPERTIES))) if "index" in one
    ]
    assert len(warnings) == 1
    assert warnings[0].startswith("parameters.lambda_star.upper = 0.01: by the index properties ")
    assert "Wroth & Wood (1978)" in warnings[0]
    assert not [one for one in map(plain, implausible(problem("soft_soil_creep", SOFT, PROPERTIES))) if "index" in one]


def test_the_section_is_part_of_the_document_where_it_is_given() -> None:
    one = problem("soft_soil_creep", SOFT, PROPERTIES)
    assert one.document()["index_properties"] == PROPERTIES
    assert parse_problem(one.document()) == one
    without = {key: value for key, value in one.document().items() if key != "index_properties"}
    assert "index_properties" not in parse_problem(without).document()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"liquid_limit": 0.65}, "liquid_limit must be from 2 to 3000 %, got 0.65 %; in per cent this would be 65"),
        ({"liquid_limit": 30.0, "plastic_limit": 35.0}, "liquid_limit must be above plastic_limit = 35 %, got 30 %"),
        (
            {"liquid_limit": 65.0, "plastic_limit": 30.0, "plasticity_index": 20.0},
            "liquid_limit - plastic_limit = 35 %, got 20 %",
        ),
        ({"plasticity_index": 70.0, "liquid_limit": 65.0}, "must be below liquid_limit = 65 %, got 70 %"),
        ({"relative_density": 120.0}, "index_properties.relative_density"),
        ({"min_void_ratio": 0.9, "max_void_ratio": 0.6}, "max_void_ratio must be above min_void_ratio = 0.9, got 0.6"),
    ],
)
def test_index_properties_that_cannot_be_are_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ProblemError) as caught:
        problem("soft_soil_creep", SOFT, given)
    assert message in str(caught.value)


def layered(**properties: Any) -> dict[str, Any]:
    """A crust on clay whose index properties are known, without parameters."""
    clay = {"material": "modified_cam_clay", "unit_weight": 15.5, "initial_void_ratio": 1.6}
    return {
        "forward_model": {
            "kind": "column",
            "soils": {
                "crust": {"material": "elastic", "unit_weight": 18.0, "initial_ratio": 0.6},
                "clay": {**clay, "index_properties": properties},
            },
            "layers": [{"soil": "crust", "thickness": 1.5}, {"soil": "clay", "thickness": 6.0}],
            "water_table": 1.5,
            "stages": [{"stress": 20.0, "duration": 60.0}],
        },
        "observations": [{"series": "settlement", "points": {"x": [10.0, 60.0], "y": [0.1, 0.2]}}],
    }


def test_a_layer_takes_parameters_from_its_own_index_properties() -> None:
    """Nakase et al. (1988) for I_P = 40 %: Cc = 0.462; Tavenas et al. (1983): C_k = 0.5 e_0, e_0 of the section."""
    document = with_parameters(layered(plasticity_index=40.0))
    given = document["parameters"]
    assert {"clay.lambda", "clay.kappa", "clay.M", "clay.k", "crust.E", "crust.k"} <= given.keys()
    one = parse_problem({**document, "parameters": {**given, "clay.C_k": {"lower": 0.1, "upper": 3.0}}})
    found = by_equation(one)
    assert found["clay.lambda", "0.046 + 0.0104 I_P"] == pytest.approx(0.462 / math.log(10.0))
    assert found["clay.C_k", "0.5 e_0"] == pytest.approx(0.8)
    assert not any(name.startswith("crust.") for name, _ in found)
    sections = {each.name: each.section for each in proposed(one)}
    assert sections["clay.lambda"]["lower"] < 0.462 / math.log(10.0) < sections["clay.lambda"]["upper"]
    assert sections["crust.E"] == given["crust.E"]
    assert ordered(sections) == ["clay.lambda > clay.kappa"]
    wrong = {**document, "parameters": {**given, "clay.lambda": {"lower": 1.0, "upper": 2.0}}}
    assert any(
        "parameters.clay.lambda.lower = 1: by the index properties" in text
        for text in map(plain, implausible(parse_problem(wrong)))
    )


def test_layers_of_a_part_have_its_name_where_the_problem_gives_it() -> None:
    document = layered(plasticity_index=40.0)
    ground = document["forward_model"]
    combined = {
        **document,
        "forward_model": {"kind": "combined", "parts": {"ground": ground}},
        "parameters": {
            "ground.clay.lambda": {"lower": 0.05, "upper": 0.5},
            **{
                f"clay.{name}": {"value": value}
                for name, value in (("kappa", 0.03), ("M", 1.0), ("nu", 0.3), ("k", 1e-4))
            },
            **{f"crust.{name}": {"value": value} for name, value in (("E", 5.0e3), ("nu", 0.3), ("k", 1e-3))},
        },
        "observations": [{"series": "ground.settlement", "points": {"x": [10.0, 60.0], "y": [0.1, 0.2]}}],
        "stopping": {"max_evaluations": 10},
    }
    found = by_equation(parse_problem(combined))
    assert found["ground.clay.lambda", "0.046 + 0.0104 I_P"] == pytest.approx(0.462 / math.log(10.0))


def test_a_mistake_in_the_index_properties_of_a_layer_is_reported() -> None:
    with pytest.raises(ProblemError, match=r"plasticity_index must be from 2 to 3000 %, got 0\.4 %"):
        parse_problem(with_parameters(layered(plasticity_index=0.4)) | {"parameters": {"clay.k": {"value": 1.0}}})
