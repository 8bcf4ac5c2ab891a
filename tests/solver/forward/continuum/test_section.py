"""Sections: known displacements, geometry that follows its parameters, phases in time, names that do not fit."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import InfeasibleError, ProblemError
from geoswarm.solver.forward.continuum.model import BodyModel
from geoswarm.solver.forward.registry import parse_spec
from tests.solver.forward.continuum.bodies import ELASTIC, OEDOMETER, creeping, ground, spec

VALUES = {"depth": 6.0, "E_rock": 1.0e5, "q": 50.0}


def displacement(model: BodyModel, values: dict[str, float], series: str = "A.uy", time: float = 0.0) -> float:
    return float(model.prepare({series: np.array([time])})(values)[series][0])


@pytest.mark.parametrize("depth", [6.0, 2.0, 9.0])
def test_level_ground_settles_as_one_dimensional_compression(depth: float) -> None:
    model = spec(ground()).build()
    values = {**VALUES, "depth": depth}
    rock = 50.0 * (10.0 - depth) / (10.0 * OEDOMETER)
    assert displacement(model, values) == pytest.approx(-50.0 * depth / OEDOMETER - rock, rel=1e-6)
    assert displacement(model, values, "B.uy") == pytest.approx(-rock, rel=1e-6)
    assert displacement(model, values, "A.ux") == pytest.approx(0.0, abs=1e-9)


def test_parameters_are_the_names_in_the_expressions() -> None:
    model = spec(ground()).build()
    infos = {info.name: info for info in model.parameters}
    assert set(infos) == {"depth", "E_rock", "q"}
    assert (infos["depth"].unit, infos["depth"].default) == ("m", 6.0)
    assert (infos["q"].unit, infos["q"].default) == ("kPa", None)
    assert displacement(model, {"E_rock": 1.0e5, "q": 50.0}) == displacement(model, VALUES)
    soil = {info.name: info for info in spec(creeping()).build().parameters}
    assert soil["mu_star"].symbol == "μ*"


def test_a_layer_that_is_placed_later_acts_by_its_weight() -> None:
    layers = [{"name": "fill", "thickness": 2}, {"name": "clay", "thickness": 4, "rows": 2}]
    phases = [
        {
            **{"name": "weight", "kind": "gravity", "materials": {"fill": "soil", "clay": "soil"}},
            "deactivate": ["fill"],
        },
        {"name": "fill", "kind": "plastic", "activate": ["fill"]},
    ]
    points = {"P": {"x": 4, "below": "fill"}}
    section = ground(layers=layers, phases=phases, points=points, nominal={}, materials={"soil": ELASTIC})
    model = spec(section | {"zero_at_phase": "fill"}).build()
    assert displacement(model, {}, "P.uy") == pytest.approx(-2.0 * 20.0 * 4.0 / OEDOMETER, rel=1e-6)


def test_pressure_grows_with_depth_below_its_level() -> None:
    """A triangular pressure on the side of a plate that only moves sideways: mean strain from the mean pressure."""
    load = {"boundary": "right", "pressure": 5.0, "pressure_increase": 10.0, "level": 10.0}
    section = ground(
        layers=[{"name": "sand", "thickness": 10, "rows": 4}],
        materials={"soil": {**ELASTIC, "unit_weight": 0.0}},
        nominal={},
        points={name: {"x": 8.0, **below} for name, below in (("T", {}), ("B", {"below": "sand"}))},
        fixities={"left": "horizontal", "right": "free", "bottom": "vertical", "surface": "vertical"},
        phases=[
            {"name": "weight", "kind": "gravity", "materials": {"sand": "soil"}},
            {"name": "loading", "kind": "plastic", "loads": [load]},
        ],
    )
    section["layers"] = [
        {"name": "sand", "thickness": 5, "rows": 2},
        {"name": "below", "bottom": 0, "rows": 2},
    ]
    section["phases"][0]["materials"]["below"] = "soil"
    section["points"] = {"T": {"x": 8}, "M": {"x": 8, "below": "sand"}, "B": {"x": 8, "below": "below"}}
    run = spec(section).build().prepare({f"{name}.ux": np.zeros(1) for name in "TMB"})({})
    top, middle, bottom = (float(run[f"{name}.ux"][0]) for name in "TMB")
    assert top > middle > bottom
    assert middle == pytest.approx(-55.0 * 8.0 / OEDOMETER, rel=0.02)


def test_phases_in_time_follow_one_another() -> None:
    """Two phases of 400 and 600 days are one of 1000; resets and vectors count the same displacements."""
    whole = spec(creeping()).build()
    section = creeping()
    first = section["phases"][1] | {"duration": 400}
    second = {"name": "later", "kind": "creep", "duration": 600, "reset_displacements": True}
    section |= {
        "phases": [section["phases"][0], first, second],
        "vectors": {"v": {"points": ["A"], "start": 100, "end": 900}},
    }
    parts = spec(section).build()
    values = {"mu_star": 0.005}
    times = np.array([0.0, 1.0, 100.0, 400.0, 700.0, 900.0, 1000.0])
    one = whole.prepare({"A.uy": times})(values)["A.uy"]
    two = parts.prepare({"A.uy": times, "v.uy": np.ones(1)})(values)
    assert one[0] == two["A.uy"][0] == 0.0
    assert one[-1] < one[1] < -0.05
    assert np.abs(two["A.uy"] - one).max() < 2e-3 * abs(one[-1])
    assert two["v.uy"][0] == pytest.approx(two["A.uy"][5] - two["A.uy"][2], rel=1e-12)
    assert parts.end == 1000.0
    assert 400.0 in parts.grid("A.uy")
    assert parts.grid("v.uy").tolist() == [1.0]


def test_the_section_survives_its_canonical_form() -> None:
    given = spec(ground())
    again = parse_spec(json.loads(json.dumps(given.model_dump(mode="json"))))
    assert again == given
    assert displacement(again.build(), VALUES) == displacement(given.build(), VALUES)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"depth": -1.0}, "'depth' must be at least 0, got -1 m"),
        ({"depth": 12.0}, "has no area or runs clockwise"),
        ({"E_rock": 0.0}, "'E_rock' must be above 0, got 0 kPa"),
    ],
)
def test_inadmissible_values_are_named(values: dict[str, float], words: str) -> None:
    model = spec(ground()).build()
    with pytest.raises(InfeasibleError, match=words):
        displacement(model, {**VALUES, **values})


def test_check_judges_what_is_known() -> None:
    model = spec(creeping()).build()
    assert model.check({}) is None
    assert model.check({"mu_star": 0.01}) is None
    assert model.check({"mu_star": 0.0}) == "'mu_star' must be above 0, got 0"
    section = creeping()
    section["materials"]["clay"] = section["materials"]["clay"] | {"lambda_star": "lam"}
    message = spec(section).build().check({"lam": 0.01})
    assert message == "material clay: lambda_star must be above kappa_star = 0.02, got 0.01"


PHASE: dict[str, Any] = ground()["phases"][0]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"nominal": {}}, "nominal: depth is missing"),
        ({"element_length": "depth"}, "element_length: 'depth' must be a number"),
        ({"phases": [PHASE | {"materials": {"sand": "soil"}}]}, r"phases\[0\].materials: rock without a material"),
        ({"phases": [PHASE | {"materials": {"sand": "mud", "rock": "rock"}}]}, "sand: mud is unknown; known materials"),
        ({"phases": [PHASE | {"kind": "plastic"}]}, r"phases\[0\].kind: must be gravity or K0 for .*; got plastic"),
        ({"phases": [PHASE | {"fixities": {"roof": "both"}}]}, "fixities: roof is unknown; known boundaries: surface"),
        ({"zero_at_phase": "later"}, "zero_at_phase: later is unknown; known phases: weight, loading"),
        ({"vectors": {"v": {"points": ["Z"], "end": 1}}}, "points: Z is unknown; known points: A, B"),
        ({"vectors": {"A": {"points": ["A"], "end": 1}}}, "vectors.A: is also the name of a point"),
        ({"points": {"A": {"x": 40}}}, "point A at x = 40 m lies outside the surface"),
    ],
)
def test_sections_that_do_not_fit_together_are_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ProblemError, match=rf"^forward_model.*{words}"):
        spec(ground(**changes)).build()


def test_points_and_series_are_checked() -> None:
    model = spec(ground(vectors={"v": {"points": ["A"], "end": 5}})).build()
    assert {info.name: info.x_names for info in model.series}["v.ux"] == ("A",)
    with pytest.raises(ProblemError, match=r"v.end: end = 5 day: the phases end at 0 day"):
        model.prepare({"v.ux": np.ones(1)})
    with pytest.raises(ProblemError, match=r"'C.ux' is unknown; known are A.ux, A.uy"):
        model.prepare({"C.ux": np.zeros(1)})
    with pytest.raises(ProblemError, match=r"A.ux: x must be from 0 to 0, got 3 day"):
        model.prepare({"A.ux": np.full(1, 3.0)})
