"""A body on the user's mesh: the same as the section whose mesh it is, files travel with the problem."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.forward.finite_element import FiniteElementSpec
from geoswarm.solver.forward.registry import parse_spec
from geoswarm.solver.problem import load_problem, parse_problem
from tests.solver.fem.mesh.test_files import gmsh
from tests.solver.forward.continuum.bodies import ELASTIC, OEDOMETER, ground, spec

BODY = {
    "materials": {"soil": ELASTIC},
    "fixities": {"base": "both"},
    "phases": [
        {"name": "weight", "kind": "gravity", "materials": {"clay": "soil", "sand": "soil"}},
    ],
}


def finite_element(mesh: dict[str, Any], **changes: Any) -> FiniteElementSpec:
    section = {"kind": "finite_element", "mesh": mesh, **BODY, **changes}
    found = parse_spec(section)
    assert isinstance(found, FiniteElementSpec)
    return found


def test_the_mesh_of_a_section_gives_its_displacements() -> None:
    section = spec(ground()).build()
    mesh = section.nominal
    tables = {
        "nodes": mesh.nodes.tolist(),
        "triangles": mesh.triangles.tolist(),
        "regions": {name: np.flatnonzero(mesh.regions == n).tolist() for n, name in enumerate(mesh.region_names)},
        "lines": {name: mesh.boundaries[name][:, :2].tolist() for name in ("surface", "bottom", "left", "right")},
        "named_nodes": mesh.points,
    }
    shared = {key: ground()[key] for key in ("materials", "zero_at_phase")}
    phases = ground()["phases"]
    phases[1] = phases[1] | {"loads": [{"boundary": "surface", "pressure": "q"}]}
    fixities = {"left": "horizontal", "right": "horizontal", "bottom": "vertical"}
    model = finite_element(tables, **shared, phases=phases, fixities=fixities, points={"C": [3.9, 9.9]}).build()
    values = {"E_rock": 1.0e5, "q": 50.0}
    wanted = {name: np.zeros(1) for name in ("A.uy", "B.uy")}
    found = model.prepare({**wanted, "C.uy": np.zeros(1)})(values)
    expected = section.prepare(wanted)({**values, "depth": 6.0})
    for name in wanted:
        assert found[name] == pytest.approx(expected[name], rel=1e-9)
    assert found["C.uy"] == pytest.approx(found["A.uy"], rel=1e-9)
    assert float(found["A.uy"][0]) == pytest.approx(-50.0 / OEDOMETER * (6.0 + 0.4), rel=1e-6)


def test_the_file_travels_with_the_problem(tmp_path: Path) -> None:
    gmsh(tmp_path)
    document = {
        "forward_model": {
            **{"kind": "finite_element", "mesh": {"file": "body.msh"}, **BODY},
            "materials": {"soil": {**ELASTIC, "E": "E"}},
        },
        "parameters": {"E": {"lower": 1e3, "upper": 1e5, "scale": "log"}},
        "observations": [{"series": "top_right.uy", "points": {"x": [0.0], "y": [-0.003]}}],
        "method": {"kind": "monte_carlo", "samples": 2},
    }
    path = tmp_path / "problem.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    problem = load_problem(path)
    carried = problem.document()
    assert carried["forward_model"]["mesh"]["file"] is None
    assert len(carried["forward_model"]["mesh"]["triangles"]) == 4
    again = parse_problem(carried)
    assert again == problem
    x = {"top_right.uy": np.zeros(1)}
    assert again.model.prepare(x)({"E": 1e4}) == problem.model.prepare(x)({"E": 1e4})
    assert float(problem.model.prepare(x)({"E": 1e4})["top_right.uy"][0]) < 0.0
    with pytest.raises(ProblemError, match=r"forward_model.mesh.file: files can only be read beside a problem file"):
        parse_problem(document)


def test_what_is_observed_must_be_on_the_mesh(tmp_path: Path) -> None:
    gmsh(tmp_path)
    given = finite_element({"file": "body.msh"}, points={"P": [30.0, 2.0]}).with_files(tmp_path, "forward_model")
    with pytest.raises(
        ProblemError, match=r"points.P: \(30, 2\) lies outside the mesh; the nearest node is at \(2, 2\)"
    ):
        given.build()
    given = finite_element({"file": "body.msh"}, fixities={"joint": "both"}).with_files(tmp_path, "forward_model")
    with pytest.raises(ProblemError, match=r"fixities.joint: joint is unknown; known boundaries: base"):
        given.build()
