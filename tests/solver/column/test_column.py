"""Layered ground: names of parameters and series, water at rest, what is refused, failures as data."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from geoswarm.solver.column.section import ColumnSpec
from geoswarm.solver.errors import InfeasibleError, ProblemError
from geoswarm.solver.laws.registry import BUILT_IN, find_law
from geoswarm.solver.problem import parse_problem
from geoswarm.verification.specimens.laboratory import run
from tests.solver.column.grounds import CLAY, WATER, embankment, ground
from tests.solver.laws.checks import usual_values

CRUST = {"crust.E": 5.0e3, "crust.nu": 0.3, "crust.k": 1.0e-3}
SOILS = CRUST | {f"clay.{name}": value for name, value in CLAY.items()} | {"clay.e0": 1.6, "clay.k": 5.0e-5}
DRAINS = {"spacing": 1.5, "diameter": 0.066, "bottom": 8.0}


def test_parameters_have_the_names_of_their_soils() -> None:
    drains = {**DRAINS, "smear_diameter": 0.2, "smear_ratio": 2.0, "discharge_capacity": 0.5}
    model = embankment("soft_soil", drains=drains).build()
    known = {info.name: info for info in model.parameters}
    assert {"crust.E", "crust.k", "clay.lambda_star", "clay.k", "clay.C_k", "clay.k_ratio"} <= known.keys()
    assert known["drains.smear_ratio"].default == 2.0
    assert known["drains.discharge_capacity"].default == 0.5
    assert known["clay.k"].default is None
    assert "soil clay" in known["clay.k"].description
    plain = {info.name for info in embankment("soft_soil").build().parameters}
    assert not any(name.endswith("k_ratio") or name.startswith("drains.") for name in plain)


def test_series_are_those_of_the_points() -> None:
    names = {info.name for info in embankment("soft_soil").build().series}
    assert {
        "settlement",
        "S1.settlement",
        "P1.pore_pressure",
        "P1.excess_pore_pressure",
        "P1.effective_stress",
    } <= names
    assert "P1.void_ratio" in names
    shallow = embankment("soft_soil", points={"A": {"depth": 0.5}}).build()
    assert "A.void_ratio" not in {info.name for info in shallow.series}  # the crust has none


def test_water_and_weight_are_at_rest_before_the_first_load() -> None:
    spec = embankment("modified_cam_clay")
    pore, excess, effective = run(
        spec, SOILS, [0.0], "P1.pore_pressure", "P1.excess_pore_pressure", "P1.effective_stress"
    )
    assert pore == pytest.approx([WATER * 3.5])
    assert excess == pytest.approx([0.0], abs=1.0e-9)
    assert effective == pytest.approx([5.0 + 1.5 * 18.0 + 3.5 * (15.5 - WATER)])


def test_free_water_weighs_on_the_ground_and_changes_no_effective_stress() -> None:
    under = embankment("modified_cam_clay", water_table=-2.0)
    at = embankment("modified_cam_clay", water_table=0.0)
    x = [0.0, 100.0, 1000.0]
    deep, pore = run(under, SOILS, x, "settlement", "P1.pore_pressure")
    shallow, less = run(at, SOILS, x, "settlement", "P1.pore_pressure")
    assert deep == pytest.approx(shallow, rel=1.0e-9, abs=1.0e-12)
    assert pore == pytest.approx(less + 2.0 * WATER, rel=1.0e-9)


def test_a_piezometer_that_settles_has_more_water_above_it() -> None:
    names = ("P1.pore_pressure", "P1.excess_pore_pressure", "P1.settlement")
    pore, excess, settlement = run(embankment("modified_cam_clay"), SOILS, [1000.0], *names)
    assert pore - excess == pytest.approx(WATER * (3.5 + settlement), rel=1.0e-9)
    pore, excess, _ = run(embankment("modified_cam_clay", geometry="fixed"), SOILS, [1000.0], *names)
    assert pore - excess == pytest.approx([WATER * 3.5], rel=1.0e-9)


@pytest.mark.parametrize("kind", BUILT_IN)
def test_every_law_bears_an_embankment(kind: str) -> None:
    usual = usual_values(find_law(kind))
    values = {f"clay.{name}": value for name, value in usual.items()}
    voids = None if kind == "hypoplastic_clay" else usual.get("e0", 1.6)  # that of its normal compression
    spec = embankment(kind, voids, cells=12, tolerance=1.0e-3)
    settlement, pore = run(
        spec,
        CRUST | values | {"clay.k": 5.0e-5, "clay.C_k": 0.8},
        [60.0, 3650.0],
        "settlement",
        "P1.excess_pore_pressure",
    )
    assert 0.0 < settlement[0] < settlement[1] < 1.0
    assert np.isfinite(pore).all()


def test_time_may_count_from_a_later_stage() -> None:
    (first,) = run(embankment("modified_cam_clay"), SOILS, [60.0, 100.0], "settlement")
    (second,) = run(embankment("modified_cam_clay", zero_at_stage=2), SOILS, [0.0, 40.0], "settlement")
    assert second == pytest.approx(first - first[0], abs=1.0e-12)


def test_layers_of_one_soil_are_as_good_as_one_layer() -> None:
    layers = [("crust", 1.5), ("clay", 3.0), ("clay", 5.5)]
    split = embankment("modified_cam_clay", layers=[{"soil": soil, "thickness": h} for soil, h in layers], cells=80)
    x = [60.0, 300.0, 3000.0]
    (one,) = run(embankment("modified_cam_clay", cells=80), SOILS, x, "settlement")
    (two,) = run(split, SOILS, x, "settlement")
    assert two == pytest.approx(one, rel=5.0e-3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"layers": [{"soil": "sand", "thickness": 1.0}]},
            r"layers\[0\].soil must be one of crust, clay, got 'sand'",
        ),
        ({"layers": [{"soil": "clay", "thickness": 1.0}]}, "soils.crust: no layer uses this soil"),
        ({"layers": [{"soil": "clay", "thickness": -1.0}]}, "greater than 0"),
        ({"points": {"P": {"depth": 11.0}}}, "points.P.depth must be at most the height, 10 m, got 11 m"),
        ({"stages": [{"stress": -5.0}]}, "greater than or equal to 0"),
        ({"stages": [{"stress": 5.0, "loading_time": 3.0}]}, "loading_time must be at most the duration"),
        ({"zero_at_stage": 4}, "zero_at_stage must be from 1 to 3, got 4"),
        ({"initial_surcharge": 0.0}, "greater than 0"),
        ({"base": "open"}, "'closed' or 'drained'"),
        ({"drains": {**DRAINS, "bottom": 12.0}}, "drains.bottom must be at most the height of all layers, 10"),
        ({"drains": {**DRAINS, "top": 8.0}}, "bottom must be below the top, 8 m"),
        ({"drains": {**DRAINS, "diameter": 1.6}}, "diameter must be below that of the ground of a drain, 1.57"),
        (
            {"drains": {**DRAINS, "smear_diameter": 0.05}},
            "smear_diameter must be from the diameter of the drain, 0.066",
        ),
        ({"drains": {**DRAINS, "smear_ratio": 3.0}}, "smear_ratio must be 1 without smear_diameter, got 3"),
        ({"wells": 3}, "Extra inputs"),
    ],
)
def test_sections_that_cannot_be_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        embankment("modified_cam_clay", **changes)


@pytest.mark.parametrize(
    ("soil", "message"),
    [
        ({"unit_weight": 0.0}, "greater than 0"),
        ({"unit_weight": 5.0}, "the effective stress before the first stage is -3.81 kPa at a depth of 1 m; above 0"),
        ({"settings": {"shape": 1}}, "settings.shape: material elastic has no such setting"),
        ({"initial_ratio": 0.0}, "initial_ratio must be above 0"),
        ({"consolidated": 1.5}, "less than or equal to 1"),
    ],
)
def test_soils_that_cannot_be_are_refused(soil: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        ground([("a", 1.0)], {"a": {"material": "elastic", **soil}}, [(10.0, 1.0)], initial_surcharge=1.0)


def test_drains_are_no_name_of_a_soil() -> None:
    with pytest.raises(ValidationError, match=r"soils.drains: the name is reserved for drains"):
        ground([("drains", 1.0)], {"drains": {"material": "elastic"}}, [(10.0, 1.0)])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"clay.k": 0.0}, "clay: k must be above 0, got 0 m/day"),
        ({"crust.C_k": 0.5}, "crust: C_k needs the initial void ratio; where that is not given C_k must be 0, got 0.5"),
        ({"crust.nu": 0.6}, "crust: nu must be "),
        ({"clay.k_ratio": 0.0}, "clay: k_ratio must be above 0"),
        ({"drains.smear_ratio": 0.0}, "drains: smear_ratio must be above 0"),
        ({"clay.e0": 1.2}, "clay: e0 must be 1.6, as the forward model has initial_void_ratio (give one of the two)"),
    ],
)
def test_parameters_that_cannot_be_are_told_with_their_soil(changes: dict[str, float], message: str) -> None:
    model = embankment("modified_cam_clay", drains={**DRAINS, "smear_diameter": 0.2}).build()
    assert str(model.check(SOILS | changes)).startswith(message)
    assert model.check(SOILS) is None


def test_a_void_ratio_of_the_soil_is_that_of_its_law() -> None:
    model = embankment("modified_cam_clay").build()
    without = {name: value for name, value in SOILS.items() if name != "clay.e0"}
    times = {"settlement": np.array([60.0])}
    assert model.prepare(times)(without)["settlement"] == model.prepare(times)(SOILS)["settlement"]
    with pytest.raises(InfeasibleError, match=r"clay: e0 must be 1\.6, as the forward model has initial_void_ratio"):
        model.prepare(times)({**SOILS, "clay.e0": 1.2})


def test_permeability_falls_with_the_void_ratio_of_the_law() -> None:
    values, times = SOILS | {"clay.C_k": 0.8}, {"settlement": np.array([60.0, 3650.0])}
    of_section = embankment("modified_cam_clay").build().prepare(times)(values)
    of_law = embankment("modified_cam_clay", None).build().prepare(times)(values)
    assert of_law["settlement"] == pytest.approx(of_section["settlement"], rel=1.0e-12)


def test_a_law_without_a_void_ratio_is_found_before_a_run() -> None:
    model = embankment("modified_cam_clay", None).build()
    fault = model.incomplete([name for name in SOILS if name != "clay.e0"])
    assert fault is not None
    assert fault.startswith("clay: give exactly one of e0 and N")
    assert "initial_void_ratio" in fault
    assert model.incomplete(list(SOILS)) is None


def test_a_run_without_permeability_names_the_soil() -> None:
    model = embankment("modified_cam_clay").build()
    without = {name: value for name, value in SOILS.items() if name != "clay.k"}
    with pytest.raises(InfeasibleError, match="clay: the flow of water needs k"):
        model.prepare({"settlement": np.array([1.0])})(without)


def test_readings_after_the_end_and_unknown_points_are_refused() -> None:
    model = embankment("modified_cam_clay").build()
    with pytest.raises(ProblemError, match="must be from 0 to 3650 day, got"):
        model.prepare({"settlement": np.array([4000.0])})
    with pytest.raises(ProblemError, match=r"'P9\.settlement' is unknown"):
        model.prepare({"P9.settlement": np.array([1.0])})


def test_ground_without_voids_is_a_failed_evaluation() -> None:
    spec = embankment("elastic", stages=[{"stress": 5.0e3, "duration": 3000.0}])
    soft = CRUST | {"clay.E": 1.0e3, "clay.nu": 0.3, "clay.k": 1.0e-2}
    with pytest.raises(InfeasibleError, match=r"stage 1 \(5000 kPa\): the void ratio of clay falls to -\d"):
        run(spec, soft, [1.0], "settlement")


def test_a_problem_names_and_links_parameters_of_soils() -> None:
    document: dict[str, Any] = {
        "name": "ground",
        "forward_model": ColumnSpec.example(),
        "parameters": {
            "crust.E": {"value": 5000},
            "crust.nu": {"value": 0.3},
            "crust.k": {"expression": "10 * clay.k"},
            "clay.k": {"lower": 1e-5, "upper": 1e-3, "scale": "log"},
            "clay.lambda": {"lower": 0.1, "upper": 0.5},
            "clay.kappa": {"expression": "0.2 * clay.lambda"},
            "clay.M": {"value": 1},
            "clay.nu": {"value": 0.3},
            "clay.e0": {"value": 1.6},
        },
        "constraints": ["clay.lambda > clay.k"],
        "observations": [{"series": "P1.excess_pore_pressure", "points": {"x": [10, 100], "y": [10, 20]}}],
        "method": {"kind": "monte_carlo", "samples": 2},
    }
    problem = parse_problem(document)
    values = problem.values([1.0e-4, 0.2])
    assert values["crust.k"] == pytest.approx(1.0e-3)
    found = problem.model.prepare({one.series: one.x for one in problem.observations})(values)
    assert np.isfinite(found["P1.excess_pore_pressure"]).all()
