"""Every laboratory test has its sketch: numbers and symbols are there, nothing sticks out, no text on text."""

from __future__ import annotations

import itertools
import math
import xml.etree.ElementTree as ElementTree
from typing import Any

import pytest

from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.solver.forward.registry import find_spec, parse_spec, sketches_of
from geoswarm.solver.sketches.drawing import Told, drawings
from geoswarm.solver.sketches.shapes import Area, Dot, Drawing, Line, Text, text_width
from geoswarm.solver.sketches.svg import svg_element
from geoswarm.solver.sketches.ticks import ground_length, specimen_length
from tests.solver.sketches.sections import CLIFF, EXCAVATION, SLOPE

TESTS = (
    "oedometer",
    "isotropic_compression",
    "triaxial",
    "direct_simple_shear",
    "crs_oedometer",
    "consolidation",
    "column",
    "section",
)
TRIAXIAL = {"kind": "triaxial", "material": "modified_cam_clay", "initial_stress": 20, "back_pressure": 300}
CASES: dict[str, dict[str, Any]] = {
    "cyclic": TRIAXIAL
    | {
        "drainage": "undrained",
        "consolidation": [{"axial": 200, "radial": "K0"}, {"axial": 400, "radial": 300, "loading_time": 0.3}],
        "shearing": [{"kind": "cyclic", "axial_strain_amplitude": 0.01, "cycles": 20000}],
    },
    "stress, creep, extension": TRIAXIAL
    | {
        "consolidation": [{"axial": 200, "radial": 120}],
        "shearing": [
            {"kind": "cyclic", "deviator_stress_amplitude": 40, "cycles": 1000, "period": 1e-3},
            {"kind": "hold", "duration": 0.5},
            {"kind": "monotonic", "axial_strain": -0.1, "rate": 0.24},
        ],
    },
    "long": {
        "kind": "consolidation",
        "material": "modified_cam_clay",
        "height": 0.02,
        "initial_stress": 25,
        "drainage": "one_side",
        "back_pressure": 200,
        "stages": [{"stress": 50, "duration": 0.01}, {"stress": 800, "duration": 100}],
    },
    "many stages": {
        "kind": "oedometer",
        "height": 0.02,
        "diameter": 0.07,
        "initial_stress": 1,
        "stages": [{"stress": 1 + n % 500, "duration": 0.5 + n % 3} for n in range(1000)],
    },
    "one point of time": {
        "kind": "isotropic_compression",
        "height": 1e-6,
        "diameter": 1000,
        "initial_stress": 10,
        "stages": [{"stress": 10, "duration": 1e-7}],
    },
    "deep": {
        "kind": "column",
        "soils": {"s" * 100: {"material": "elastic", "unit_weight": 18, "initial_ratio": 0.6}},
        "layers": [{"soil": "s" * 100, "thickness": 0.01 + 3 * (n % 7)} for n in range(200)],
        "water_table": -2,
        "base": "drained",
        "drains": {"spacing": 1.2, "diameter": 0.06, "top": 1, "bottom": 600},
        "stages": [{"stress": 20, "duration": 3000, "loading_time": 1}, {"stress": 0, "duration": 1}],
        "points": {f"P{n}": {"depth": 1.2 * n} for n in range(500)},
    },
}

CASES |= {"slope": SLOPE, "excavation": EXCAVATION, "cliff": CLIFF}


def spec_of(case: str) -> ForwardModelSpec:
    """The small example of a kind, or one of the cases here."""
    return parse_spec(CASES.get(case) or find_spec(case).example())


def told(spec: ForwardModelSpec) -> tuple[Told, ...]:
    sketch = spec.sketch()
    assert sketch is not None
    return drawings(sketch)


def texts(drawing: Drawing) -> list[str]:
    return [shape.text for shape in drawing.shapes if isinstance(shape, Text)]


def extent(text: Text) -> tuple[float, float, float, float]:
    """Left, right, top and bottom of the letters, about."""
    x, y = text.at
    wide, tall = 0.9 * text_width(text.text, text.size), 0.7 * text.size
    if text.upwards:
        return x - tall, x, y - 0.5 * wide, y + 0.5 * wide
    left = {"start": x, "middle": x - 0.5 * wide, "end": x - wide}[text.anchor]
    return left, left + wide, y - tall, y


def corners(drawing: Drawing) -> list[tuple[float, float]]:
    found: list[tuple[float, float]] = []
    for shape in drawing.shapes:
        if isinstance(shape, Line | Area):
            found += shape.points
        elif isinstance(shape, Dot):
            x, y, r = *shape.centre, shape.radius
            found += [(x - r, y - r), (x + r, y + r)]
        else:
            left, right, top, bottom = extent(shape)
            found += [(left, top), (right, bottom)]
    return found


@pytest.mark.parametrize("case", [*TESTS, *CASES])
def test_nothing_sticks_out_and_no_text_lies_on_another(case: str) -> None:
    for one in told(spec_of(case)):
        drawing = one.drawing
        for x, y in corners(drawing):
            assert math.isfinite(x)
            assert -0.5 <= x <= drawing.width + 0.5, (one.heading, x, y)
            assert -0.5 <= y <= drawing.height + 0.5, (one.heading, x, y)
        boxes = [(shape.text, extent(shape)) for shape in drawing.shapes if isinstance(shape, Text)]
        for (first, a), (second, b) in itertools.combinations(boxes, 2):
            apart = a[1] <= b[0] or b[1] <= a[0] or a[3] <= b[2] or b[3] <= a[2]
            assert apart, (case, one.heading, first, second)


@pytest.mark.parametrize("case", [*TESTS, *CASES])
def test_the_element_is_sound_and_says_the_same_in_words(case: str) -> None:
    for one in told(spec_of(case)):
        element = ElementTree.fromstring(svg_element(one.drawing, one.words))
        assert element.attrib["role"] == "img"
        assert element.attrib["aria-label"] == one.words
        assert "style" not in {name for child in element.iter() for name in child.attrib}
        assert len(one.words) < 4000
        assert one.words.endswith(".")


@pytest.mark.parametrize(
    ("case", "written", "said"),
    [
        (
            "oedometer",
            ["h = 20 mm", "σ′v", "s", "soft soil creep"],
            "in a ring that holds its side, height h = 20 mm",
        ),
        ("isotropic_compression", ["h = 100 mm", "d = 50 mm", "p′", "Δr"], "diameter d = 50 mm"),
        ("triaxial", ["σ′a = σ′r + q", "σ′r", "q, εa", "εv"], "in a membrane under cell pressure"),
        ("cyclic", ["u", "u₀ =", "300 kPa"], "No water leaves while it is sheared; back pressure u₀ = 300 kPa"),
        ("direct_simple_shear", ["τ, γ", "σ′v"], "While it is sheared its volume stays"),
        ("crs_oedometer", ["σv, εa", "u"], "a porous stone at the top, the base is closed"),
        ("consolidation", ["s", "u"], "pore pressure at mid-height"),
        ("long", ["u", "200 kPa"], "u: pore pressure at the base"),
        ("column", ["crust, 1.5 m", "clay, 6 m", "S1", "P1", "7.5"], "Water table 1.5 m below the surface"),
        ("section", ["clay", "rock", "A", "y [m]", "x [m]"], "Drawn for depth = 3."),
        ("slope", ["cover", "shear_zone", "bedrock", "stable", "crack", "secondary", *"ABCDEF"], "226 m high"),
        ("excavation", ["pit_1", "pit_2", "wall", "base_slip", "33.3 kPa", "p₂", "p₃"], "40 m wide and 20 m high"),
    ],
)
def test_a_specimen_shows_what_its_section_says(case: str, written: list[str], said: str) -> None:
    body = told(spec_of(case))[0]
    assert set(written) <= set(texts(body.drawing))
    assert said in body.words


@pytest.mark.parametrize(
    ("case", "written", "said"),
    [
        (
            "oedometer",
            ["σ′v [kPa]", "time [day]", "50", "100"],
            "0.2 kPa in 2 stages: 50 kPa for 1 day, 100 kPa for 1 day",
        ),
        ("long", ["time [day], logarithmic", "800"], "800 kPa for 100 day"),
        ("triaxial", ["εa [-]", "q [kPa]", "stage", "0.005"], "by deviator stress: to 20 kPa in stage 2"),
        ("cyclic", ["20000 cycles ±0.01"], "20000 cycles of ±0.01 in stage 1"),
        ("crs_oedometer", ["εa [-]", "time [day]", "0.12", "0.11", "0.2"], "to 0.12 in stage 1, to 0.11 in stage 2"),
        ("column", ["Δσ [kPa]", "20", "40"], "20 kPa for 60 day, 40 kPa for 300 day"),
    ],
)
def test_the_programme_has_its_numbers_and_units(case: str, written: list[str], said: str) -> None:
    programme = told(spec_of(case))[1]
    assert set(written) <= set(texts(programme.drawing))
    assert said in programme.words


def test_the_staircase_holds_each_load_for_its_duration() -> None:
    sketch = spec_of("consolidation").sketch()
    assert sketch is not None
    (track,) = sketch.programme[0].tracks
    assert track.points == ((0, 25), (0, 50), (1, 50), (1, 100), (2, 100), (2, 25), (3, 25))


def test_a_rate_gives_the_time_of_a_movement() -> None:
    sketch = spec_of("crs_oedometer").sketch()
    assert sketch is not None
    (track,) = sketch.programme[0].tracks
    times = [0.0, 0.12 / 0.24, 0.12 / 0.24 + 0.01 / 0.12, 0.12 / 0.24 + 0.01 / 0.12 + 0.09 / 0.24]
    assert [x for x, _ in track.points] == pytest.approx(times, rel=1e-12)


def test_what_is_not_led_is_dashed() -> None:
    sketch = spec_of("triaxial").sketch()
    assert sketch is not None
    _, strain, stress = sketch.programme
    assert strain.tracks[0].points == ((0, 0), (1, 0.005), (3, 0.1))
    assert strain.tracks[0].free == {2}
    assert stress.tracks[0].free == {1}


def test_a_model_without_a_sketch_has_none() -> None:
    formula = parse_spec({"kind": "formula", "series": {"y": "a * x"}})
    assert formula.sketch() is None
    assert sketches_of(formula) == {}


def test_a_combined_model_has_the_sketches_of_its_parts() -> None:
    parts = {name: find_spec(name).example() for name in ("oedometer", "column")}
    parts["line"] = {"kind": "formula", "series": {"y": "a * x"}}
    found = sketches_of(parse_spec({"kind": "combined", "parts": parts}))
    assert {name: one.sketch.test for name, one in found.items()} == {
        "oedometer": "Oedometer test",
        "column": "Layered ground",
    }


@pytest.mark.parametrize(
    ("metres", "specimen", "ground"),
    [
        (0.02021, "20.21 mm", "2.021 cm"),
        (0.07, "70 mm", "7 cm"),
        (0.1, "100 mm", "0.1 m"),
        (1e-6, "0.001 mm", "0.0001 cm"),
        (0.0, "0 mm", "0 m"),
        (1.5, "1.5 m", "1.5 m"),
        (1000.0, "1000 m", "1000 m"),
    ],
)
def test_lengths_have_the_unit_that_is_usual(metres: float, specimen: str, ground: str) -> None:
    assert specimen_length(metres) == specimen
    assert ground_length(metres) == ground


LOADS = (12.5, 25, 50, 100, 200, 400, 200, 100, 50, 100, 200, 400, 800, 1600, 800, 400, 100, 25)


@pytest.mark.parametrize("loads", [LOADS, (25, 50, 100, 75, 50, 75, 100, 125, 150, 175, 200, 100, 50)])
def test_no_value_of_many_stages_touches_the_staircase(loads: tuple[float, ...]) -> None:
    example = find_spec("oedometer").example() or {}
    stages = [{"stress": load, "duration": 1} for load in loads]
    drawing = told(parse_spec(example | {"initial_stress": 5, "stages": stages}))[1].drawing
    (staircase,) = [shape.points for shape in drawing.shapes if isinstance(shape, Line) and shape.ink == "load"]
    top, bottom = min(y for _, y in staircase), max(y for _, y in staircase)
    inside = [s for s in drawing.shapes if isinstance(s, Text) and s.at[0] > 48 and top - 20 < s.at[1] < bottom + 1]
    values = [text for text in inside if text.text.replace(".", "").isdigit()]
    assert len(values) > len(loads) // 2
    assert str(max(loads)) in [text.text for text in values]
    for text in values:
        left, right, upper, lower = extent(text)
        for (x, y), (next_x, next_y) in itertools.pairwise(staircase):  # level or upright
            apart = max(x, next_x) <= left or min(x, next_x) >= right or max(y, next_y) <= upper - 1
            assert apart or min(y, next_y) >= lower + 1, text.text
