"""The void ratio before a test is given once: in its section, or by the law."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import Problem, parse_problem

SAND: dict[str, float] = {
    "phi_c": 30.0,
    "h_s": 2.6e6,
    "n": 0.27,
    "e_d0": 0.61,
    "e_c0": 0.98,
    "e_i0": 1.10,
    "alpha": 0.18,
}
CAM_CLAY: dict[str, float] = {"M": 1.0, "lambda": 0.2, "kappa": 0.04, "nu": 0.2}
CLAY: dict[str, float] = {"phi_c": 21.9, "lambda_star": 0.095, "kappa_star": 0.015, "N": 1.19}
OEDOMETER = {
    "kind": "oedometer",
    "height": 0.02,
    "initial_stress": 10.0,
    "stages": [{"stress": 100.0, "duration": 1.0}],
}
TRIAXIAL = {"kind": "triaxial", "initial_stress": 100.0, "shearing": [{"kind": "monotonic", "axial_strain": 0.01}]}
SERIES = {"oedometer": ("stage_void_ratio", [1.0]), "triaxial": ("void_ratio", [0.005])}


def problem(test: dict[str, Any], material: str, given: dict[str, Any], **section: Any) -> Problem:
    fixed = {"hypoplastic_sand": SAND, "modified_cam_clay": CAM_CLAY, "hypoplastic_clay": CLAY}[material]
    free = {"hypoplastic_sand": "beta", "modified_cam_clay": "OCR", "hypoplastic_clay": "nu"}[material]
    series, x = SERIES[test["kind"]]
    return parse_problem(
        {
            "forward_model": {**test, "material": material, **section},
            "parameters": {
                free: {"lower": 1.0, "upper": 3.0} if free != "nu" else {"lower": 0.1, "upper": 0.3},
                **{name: {"value": value} for name, value in fixed.items()},
                **{name: one if isinstance(one, dict) else {"value": one} for name, one in given.items()},
            },
            "observations": [{"series": series, "points": {"x": x, "y": [0.7] * len(x)}}],
            "stopping": {"max_evaluations": 20},
        }
    )


def void_ratio(made: Problem, **values: float) -> float:
    """Of the one observation, at these free parameters."""
    (o,) = made.observations
    run = made.model.prepare({o.series: o.x})
    return float(run(made.values([values[name] for name in made.free_names]))[o.series][0])


@pytest.mark.parametrize("test", [OEDOMETER, TRIAXIAL], ids=lambda one: one["kind"])
@pytest.mark.parametrize(
    ("material", "given", "message"),
    [
        (
            "hypoplastic_sand",
            {"e0": 0.95},
            r"parameters\.e0\.value: must be 0\.7, as the forward model has initial",
        ),
        ("modified_cam_clay", {"e0": 1.2}, r"parameters\.e0\.value: must be 0\.7"),
        (
            "hypoplastic_sand",
            {"e00": 0.95},
            r"parameters\.e00\.value: must be 0, as the forward model has initial",
        ),
        ("modified_cam_clay", {"N": 2.5}, r"parameters\.N\.value: must be 0, "),
        ("hypoplastic_clay", {"OCR": 2.0}, r"parameters\.OCR\.value: must be 1, "),
        ("hypoplastic_sand", {"e0": {"lower": 0.65, "upper": 0.9}}, r"parameters\.e0\.lower: must be 0\.7, "),
        ("hypoplastic_sand", {"e0": {"expression": "0.5 * e_c0"}}, r"e0 must be 0\.7, as the forward model has"),
    ],
)
def test_two_void_ratios_are_a_contradiction(
    test: dict[str, Any], material: str, given: dict[str, Any], message: str
) -> None:
    with pytest.raises(ProblemError, match=message):
        problem(test, material, given, initial_void_ratio=0.7)


@pytest.mark.parametrize("test", [OEDOMETER, TRIAXIAL], ids=lambda one: one["kind"])
@pytest.mark.parametrize(("material", "e0"), [("hypoplastic_sand", 0.8), ("modified_cam_clay", 0.9)])
def test_given_in_section_or_law_or_both_it_is_the_same(test: dict[str, Any], material: str, e0: float) -> None:
    free = {"beta": 1.1} if material == "hypoplastic_sand" else {"OCR": 1.0}
    in_law = void_ratio(problem(test, material, {"e0": e0}), **free)
    in_section = void_ratio(problem(test, material, {}, initial_void_ratio=e0), **free)
    in_both = void_ratio(problem(test, material, {"e0": e0}, initial_void_ratio=e0), **free)
    assert in_law == in_section == in_both
    assert 0.0 < abs(e0 - in_law) < 0.5  # it changes from there


def test_the_void_ratio_follows_a_free_e0() -> None:
    made = problem(OEDOMETER, "hypoplastic_sand", {"e0": {"lower": 0.65, "upper": 0.95}})
    for e0 in (0.7, 0.9):
        alone = void_ratio(problem(OEDOMETER, "hypoplastic_sand", {"e0": e0}), beta=1.1)
        assert void_ratio(made, beta=1.1, e0=e0) == alone
        assert 0.0 < e0 - alone < 0.1


def test_a_void_ratio_that_the_law_derives_is_that_under_the_initial_stress() -> None:
    exact = problem(OEDOMETER, "modified_cam_clay", {"N": 2.5})
    found = void_ratio(exact, OCR=1.0)
    # on the line of normal compression at constant stress ratio: e falls by lambda ln(p1/p0)
    unloaded = {**OEDOMETER, "stages": [{"stress": 10.0, "duration": 1.0}]}
    e0 = void_ratio(problem(unloaded, "modified_cam_clay", {"N": 2.5}), OCR=1.0)
    assert found - e0 == pytest.approx(-0.2 * np.log(10.0), rel=2e-3)


def test_the_stiffness_of_water_takes_the_void_ratio_of_the_law() -> None:
    section = {"drainage": "undrained", "water_bulk_modulus": 2.0e6}
    in_law = problem(TRIAXIAL, "hypoplastic_sand", {"e0": {"lower": 0.65, "upper": 0.95}}, **section)
    in_section = problem(TRIAXIAL, "hypoplastic_sand", {}, initial_void_ratio=0.8, **section)
    points = {"pore_pressure": np.array([0.005])}
    found = [
        made.model.prepare(points)(made.values(values))["pore_pressure"]
        for made, values in ((in_law, {"beta": 1.1, "e0": 0.8}), (in_section, {"beta": 1.1}))
        for values in [[values[name] for name in made.free_names]]
    ]
    np.testing.assert_array_equal(found[0], found[1])


def test_of_a_law_without_a_void_ratio_the_section_must_tell_it() -> None:
    soft = {"lambda_star": 0.1, "kappa_star": 0.02, "mu_star": 0.001, "c": 1.0, "phi": 25.0, "psi": 0.0}
    document = {
        "forward_model": {**OEDOMETER, "material": "soft_soil_creep"},
        "parameters": {name: {"value": value} for name, value in soft.items()} | {"phi": {"lower": 20, "upper": 30}},
        "observations": [{"series": "stage_void_ratio", "points": {"x": [1], "y": [0.7]}}],
        "stopping": {"max_evaluations": 20},
    }
    with pytest.raises(ProblemError, match="stage_void_ratio needs a void ratio above 0"):
        parse_problem(document)


@pytest.mark.parametrize("test", [OEDOMETER, TRIAXIAL], ids=lambda one: one["kind"])
@pytest.mark.parametrize(("material", "pair"), [("hypoplastic_sand", "e0 and e00"), ("modified_cam_clay", "e0 and N")])
def test_without_any_void_ratio_a_problem_is_refused_before_it_runs(
    test: dict[str, Any], material: str, pair: str
) -> None:
    message = f"parameters: give exactly one of {pair}, or initial_void_ratio of the test; material {material} needs it"
    with pytest.raises(ProblemError) as caught:
        problem(test, material, {})
    assert str(caught.value) == message
    assert problem(test, material, {}, initial_void_ratio=0.8)
    assert problem(test, material, {"e0": {"expression": "0.4 + 0.4"}})


def test_parts_without_a_void_ratio_are_named_together() -> None:
    parts = {name: {**OEDOMETER, "material": "hypoplastic_sand"} for name in ("first", "second", "third")}
    fixed = {name: {"value": value} for name, value in SAND.items()}
    with pytest.raises(ProblemError) as caught:
        parse_problem(
            {
                "forward_model": {"kind": "combined", "parts": parts},
                "parameters": fixed | {"second.e0": {"value": 0.8}, "beta": {"lower": 1.0, "upper": 3.0}},
                "observations": [
                    {"series": f"{name}.stage_void_ratio", "points": {"x": [1], "y": [0.7]}} for name in parts
                ],
                "stopping": {"max_evaluations": 20},
            }
        )
    assert str(caught.value).startswith("parameters: first and third: give exactly one of e0 and e00, or initial_void")
