"""Sections that are drawn: the slope of the examples, an excavation beside loads and water, a cliff, an embankment."""

from __future__ import annotations

from typing import Any

from geoswarm.solver.examples import example_file
from geoswarm.solver.problem.text.reading import read_problem_file

__all__ = ["CLIFF", "EXCAVATION", "LAYERED", "SLOPE"]

with example_file("slope") as _path:
    SLOPE: dict[str, Any] = read_problem_file(_path)["forward_model"]

_SOIL = {"law": "elastic", "E": 20000, "nu": 0.3, "unit_weight": 20}
_CONTACT = {"law": "interface", "normal_stiffness": 1e5, "shear_stiffness": 1e4, "c": 0, "phi": 20}

EXCAVATION: dict[str, Any] = {
    "kind": "section",
    "surface": [[0, 0], [40, 0]],
    "layers": [
        {"name": "fill", "thickness": 2},
        {"name": "silt", "thickness": 6},
        {"name": "gravel", "bottom": -20},
    ],
    "zones": [
        {"name": "pit_1", "layer": "fill", "start": 0, "end": 12},
        {"name": "pit_2", "layer": "silt", "start": 0, "end": 12},
    ],
    "cuts": [{"name": "wall", "x": 12, "through": "silt"}],
    "slips": [{"name": "base_slip", "layer": "silt", "start": 22, "end": 32}],
    "segments": [{"name": "road", "start": 16, "end": 24}, {"name": "lake", "start": 28, "end": 40}],
    "points": {
        "head": {"x": 12.5},
        "P1": {"x": 18},
        "P2": {"x": 20},
        "P3": {"x": 22},
        "deep": {"x": 20, "below": "silt"},
    },
    "element_length": 2,
    "materials": {"soil": _SOIL, "contact": _CONTACT},
    "phases": [
        {
            "name": "rest",
            "kind": "K0",
            "materials": dict.fromkeys(("fill", "silt", "gravel", "pit_1", "pit_2"), "soil")
            | dict.fromkeys(("wall", "base_slip"), "contact"),
        },
        {
            "name": "loads",
            "kind": "plastic",
            "loads": [
                {"boundary": "road", "pressure": 20},
                {"boundary": "lake", "pressure_increase": 10, "level": 1.5},
                {"boundary": "right", "pressure_increase": 10, "level": -3},
            ],
        },
        {"name": "dig_1", "kind": "creep", "duration": 10, "deactivate": ["pit_1"]},
        {
            "name": "dig_2",
            "kind": "creep",
            "duration": 20,
            "deactivate": ["pit_2"],
            "loads": [{"boundary": "road", "pressure": 33.3}],
        },
    ],
}

CLIFF: dict[str, Any] = {
    "kind": "section",
    "surface": [[0, "H"], [6, "H"], [6.5, 0], [20, 0]],
    "layers": [{"name": "limestone_of_the_upper_quarry", "bottom": [[0, -10], [20, -12]]}],
    "nominal": {"H": 25},
    "points": {"top": {"x": 3}, **{f"T{n}": {"x": 7 + 0.5 * n} for n in range(20)}},
    "segments": [{"name": "crest", "start": 0, "end": 5}],
    "element_length": 1,
    "fixities": {"left": "horizontal", "right": "both", "bottom": "both"},
    "materials": {"rock": _SOIL},
    "phases": [
        {"name": "weight", "kind": "gravity", "materials": {"limestone_of_the_upper_quarry": "rock"}},
        {
            "name": "loads",
            "kind": "plastic",
            "loads": [{"boundary": "crest", "y": "-q"}, {"boundary": "surface", "x": 5}],
        },
    ],
}

LAYERED: dict[str, Any] = {
    "kind": "section",
    "surface": [[0, 3], [8, 3], [14, 0], [40, 0]],
    "layers": [
        {"name": "fill", "bottom": 0},
        {"name": "clay", "thickness": [[0, 4], [40, 6]]},
        {"name": "sand", "bottom": -10},
    ],
    "segments": [{"name": "crest", "start": 0, "end": 8}],
    "points": {"axis": {"x": 0, "below": "fill"}, "toe": {"x": 14}},
    "element_length": 1,
    "materials": {"soil": _SOIL},
    "phases": [
        {
            "name": "weight",
            "kind": "gravity",
            "materials": dict.fromkeys(("fill", "clay", "sand"), "soil"),
            "deactivate": ["fill"],
        },
        {
            "name": "lift",
            "kind": "creep",
            "duration": 30,
            "activate": ["fill"],
            "loads": [{"boundary": "crest", "pressure": 10}],
        },
        {"name": "traffic", "kind": "creep", "duration": 60, "loads": [{"boundary": "crest", "pressure": 25}]},
    ],
}
"""An embankment whose fill ends at its toe."""
