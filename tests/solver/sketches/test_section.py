"""The sketch of a section: corners in metres, what acts and holds in the end, none of what is not possible."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.forward.cross_section import SectionModel
from geoswarm.solver.forward.registry import built, find_spec, parse_spec, sketches_of
from geoswarm.solver.report.figures.sketch_plot import sketch_figure, sketch_rows
from geoswarm.solver.sketches.declared import CrossSection, Region, Sketch
from geoswarm.solver.sketches.drawing import drawings
from geoswarm.solver.sketches.shapes import Area, Line, Text
from tests.solver.sketches.sections import CLIFF, EXCAVATION, LAYERED, SLOPE


def sketched(section: dict[str, Any]) -> Sketch:
    sketch = parse_spec(section).sketch()
    assert sketch is not None
    return sketch


def body_of(section: dict[str, Any]) -> CrossSection:
    body = sketched(section).body
    assert isinstance(body, CrossSection)
    return body


def region(section: dict[str, Any], name: str) -> Region:
    return next(one for one in body_of(section).regions if one.name == name)


def area_of(corners: Any) -> float:
    x, y = np.array(corners).T
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def test_corners_follow_surface_and_thickness() -> None:
    (fill,) = region(LAYERED, "fill").pieces
    assert fill == ((0.0, 3.0), (8.0, 3.0), (14.0, 0.0), (8.0, 0.0), (0.0, 0.0))
    (clay,) = region(LAYERED, "clay").pieces
    assert area_of(clay) == pytest.approx(40.0 * 5.0)
    assert body_of(LAYERED).bottom[0] == (0.0, -10.0)
    assert dict(body_of(LAYERED).points) == {"axis": (0.0, 0.0), "toe": (14.0, 0.0)}


@pytest.mark.parametrize("section", [SLOPE, EXCAVATION, LAYERED], ids=["slope", "excavation", "embankment"])
def test_regions_are_those_of_the_mesh(section: dict[str, Any]) -> None:
    model = built(parse_spec(section))
    assert isinstance(model, SectionModel)
    mesh = model.nominal
    corners = mesh.nodes[mesh.triangles[:, :3]]
    sizes = [area_of(triangle) for triangle in corners]
    drawn = {one.name: one for one in body_of(section).regions}
    zones = sum(area_of(piece) for one in drawn.values() if one.kind == "zone" for piece in one.pieces)
    total = sum(area_of(piece) for one in drawn.values() if one.kind == "layer" for piece in one.pieces)
    assert total == pytest.approx(sum(sizes), rel=1e-3)
    for number, name in enumerate(mesh.region_names):
        if drawn[name].kind == "zone":
            own = sum(size for size, part in zip(sizes, mesh.regions, strict=True) if part == number)
            assert sum(map(area_of, drawn[name].pieces)) == pytest.approx(own, rel=0.02), name
    assert zones < total
    for name, place in body_of(section).points:
        assert place == pytest.approx(tuple(mesh.nodes[mesh.points[name]]), abs=1e-9)


def test_a_layer_that_ends_and_begins_again_has_two_pieces() -> None:
    hills = LAYERED | {"surface": [[0, 2], [10, 0], [20, -1], [30, 0], [40, 2]], "points": {"axis": {"x": 0}}}
    first, second = region(hills, "fill").pieces
    assert max(x for x, _ in first) == 10.0
    assert min(x for x, _ in second) == 30.0


def test_materials_loads_and_what_holds_are_those_of_the_end() -> None:
    assert region(SLOPE, "shear_zone").materials == ("rock", "soil", "strength", "clay")
    assert region(EXCAVATION, "pit_2").removed == "dig_2"
    assert region(LAYERED, "fill").since == "lift"
    (crest,) = body_of(LAYERED).loads
    assert (crest.value, crest.sizes) == ("25 kPa", (1.0, 1.0))
    (traffic,) = (phase for phase in sketched(LAYERED).phases if phase.name == "traffic")
    assert f"load on {crest.boundary}: 25 kPa" in traffic.changes
    slope = body_of(SLOPE)
    assert {load.value for load in slope.loads} == {"20 * K_foot kPa/m below 0 m"}
    assert [support.boundary for support in slope.supports] == ["left.bedrock", "right.bedrock", "bottom"]
    assert [load.water for load in body_of(EXCAVATION).loads] == [None, 1.5, -3.0]


def test_a_load_of_unknown_size_acts_as_its_sign_says() -> None:
    crest, surface = body_of(CLIFF).loads
    assert (crest.value, crest.towards) == ("-q kPa along y", (0.0, -1.0))
    assert (surface.value, surface.towards) == ("5 kPa along x", (1.0, 0.0))


def test_loads_that_follow_each_other_are_drawn_over_time() -> None:
    (panel,) = sketched(LAYERED).programme
    (track,) = panel.tracks
    assert track.points == ((0.0, 0.0), (0.0, 10.0), (30.0, 10.0), (30.0, 25.0), (90.0, 25.0))
    assert [one.heading for one in drawings(sketched(LAYERED))] == ["Section", "Legend", "Phases", "Loading programme"]


def test_phases_say_how_long_they_take_and_what_they_change() -> None:
    phases = sketched(SLOPE).phases
    assert [one.duration for one in phases] == ["", "", "", "10957.5 day (30 years)", "1095.75 day (3 years)"]
    assert [one.name for one in phases if one.zero] == ["creep"]
    assert phases[3].changes == ("shear_zone: clay",)
    assert sketched(EXCAVATION).phases[3].changes == ("removed: pit_2", "load on road: 33.3 kPa")


def test_layers_lie_where_the_axes_say() -> None:
    drawing = drawings(sketched(EXCAVATION))[0].drawing
    written = {shape.text: shape.at for shape in drawing.shapes if isinstance(shape, Text)}
    gravel = next(shape for shape in drawing.shapes if isinstance(shape, Area) and shape.ink == "steel")
    (left, top), (right, bottom) = min(gravel.points), max(gravel.points)
    assert written["0"] is not None
    assert right - written["40"][0] == pytest.approx(0.0, abs=0.1)
    assert bottom - (written["−20"][1] - 4.0) == pytest.approx(0.0, abs=0.1)
    assert (bottom - top) / (right - left) == pytest.approx(12.0 / 40.0)


def test_thin_layers_stay_visible_and_flat_sections_are_enlarged() -> None:
    one = drawings(sketched(SLOPE))[0]
    bands = [s for s in one.drawing.shapes if isinstance(s, Line) and s.ink in ("stone", "marl")]
    assert bands
    assert all(band.width > 2.0 for band in bands)
    assert "Heights are drawn 2.5 times larger than widths." in one.words
    assert "times larger" not in drawings(sketched(EXCAVATION))[0].words


@pytest.mark.parametrize(
    "change",
    [
        {"nominal": {}, "surface": [[0, 3], [40, "H"]]},
        {"nominal": {"H": -2}, "surface": [[0, 3], ["H", 3], [40, 0]]},
        {"layers": [{"name": "fill", "bottom": 0}, {"name": "clay", "thickness": "0 * H - 1"}], "nominal": {"H": 1}},
        {
            "cuts": [
                {"name": "a", "x": 2, "x_bottom": 30, "through": "sand"},
                {"name": "b", "x": 20, "x_bottom": 3, "through": "sand"},
            ]
        },
    ],
    ids=["no nominal value", "surface that turns back", "negative thickness", "cuts that cross"],
)
def test_what_is_not_possible_is_not_drawn(change: dict[str, Any]) -> None:
    assert sketches_of(parse_spec(LAYERED | change)) == {}


def test_unknown_boundaries_and_names_do_not_hinder_the_picture() -> None:
    phases = [LAYERED["phases"][0], {"name": "p", "kind": "plastic", "loads": [{"boundary": "moon", "pressure": 1}]}]
    assert body_of(LAYERED | {"phases": phases, "fixities": {"left.moon": "both"}}).loads == ()


def test_a_combined_model_draws_its_sections() -> None:
    parts = {"slope": SLOPE, "triaxial": find_spec("triaxial").example()}
    found = sketches_of(parse_spec({"kind": "combined", "parts": parts}))
    assert {name: one.sketch.test for name, one in found.items()}["slope"] == "Section"


@pytest.mark.parametrize("section", [SLOPE, CLIFF], ids=["slope", "cliff"])
def test_a_report_has_the_figure_and_its_numbers(section: dict[str, Any]) -> None:
    (drawn,) = sketches_of(parse_spec(section)).values()
    figure = sketch_figure("Slope", drawn)
    written = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert {"x [m]", "y [m]"} <= set(written)
    _, rows = sketch_rows(drawn.sketch)
    assert {row[1] for row in rows} == {one.name for one in body_of(section).regions}


@pytest.mark.timing
def test_it_is_drawn_at_once() -> None:
    spec = parse_spec(SLOPE)
    times = []
    for _ in range(3):
        start = time.perf_counter()
        sketches_of(spec)
        times.append(time.perf_counter() - start)
    assert min(times) < 0.05
