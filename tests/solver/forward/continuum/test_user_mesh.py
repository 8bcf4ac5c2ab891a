"""Meshes of the user in problem files: read from a file, carried as tables, refused with their path."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from geoswarm.solver.errors import MeshError, ProblemError
from geoswarm.solver.forward.continuum.user_mesh import MeshSection
from tests.solver.fem.mesh.test_files import gmsh

TABLES = {
    "nodes": [[0, 0], [2, 0], [2, 1], [0, 1]],
    "triangles": [[0, 1, 2], [0, 2, 3]],
    "regions": {"clay": [0], "sand": [1]},
    "lines": {"base": [[0, 1]], "joint": [[0, 2]]},
    "named_nodes": {"P": 2},
}


def section(**fields: object) -> MeshSection:
    return MeshSection.model_validate_json(json.dumps(fields), strict=True)


def test_a_file_becomes_tables_that_make_the_same_mesh(tmp_path: Path) -> None:
    gmsh(tmp_path)
    given = section(file="body.msh", interfaces=["joint"], scale=0.5)
    carried = given.with_tables(tmp_path, "forward_model.mesh")
    assert carried.file is None
    assert section(**json.loads(carried.model_dump_json(exclude_none=True))).mesh().interface_names == ("joint",)
    mesh = carried.mesh()
    assert mesh.region_names == ("clay", "sand")
    assert set(mesh.boundaries) == {"base"}
    assert np.ptp(mesh.nodes, axis=0).tolist() == [1.0, 1.0]
    assert mesh.nodes[mesh.points["top_right"]].tolist() == [1.0, 1.0]


def test_tables_make_a_mesh() -> None:
    mesh = section(**TABLES).mesh()
    assert mesh.triangles.shape == (2, 6)
    assert set(mesh.boundaries) == {"base"}
    assert section(**TABLES).with_tables(None, "").mesh().points == {"P": 2}


def test_files_are_not_read_for_problems_from_the_network(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match=r"^forward_model.mesh.file: files can only be read beside a problem file"):
        section(file="body.msh").with_tables(None, "forward_model.mesh")
    with pytest.raises(ProblemError, match=r"^mesh.file: .*absent.msh: no such file"):
        section(file="absent.msh").with_tables(tmp_path, "mesh")
    with pytest.raises(MeshError, match=r"file body.msh has not been read"):
        section(file="body.msh").mesh()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"regions": {"clay": [0]}}, "triangle 1 belongs to no region"),
        ({"regions": {"clay": [0, 1, 2]}}, "region clay: triangle 2 does not exist; 0 to 1 do"),
        ({"triangles": [[0, 1, 2], [0, 2]]}, "all triangles must have 3 nodes, or all 6"),
        ({"interfaces": ["fault"]}, "interface fault: no line has this name; named lines: base, joint"),
        ({"triangles": [[0, 1, 2], [0, 2, 9]]}, "node 9 does not exist; nodes 0 to 3 do"),
        ({"lines": {"base": [[0, 7]]}}, "line base: node 7 does not exist; nodes 0 to 3 do"),
        ({"named_nodes": {"P": -1}}, "point P: node -1 does not exist; nodes 0 to 3 do"),
    ],
)
def test_unsound_tables_are_refused(changes: dict[str, object], words: str) -> None:
    with pytest.raises(MeshError, match=words):
        section(**{**TABLES, **changes}).mesh()


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"file": "a.msh", **TABLES}, "a file and tables are both given"),
        ({"nodes": TABLES["nodes"]}, "give a file, or all of nodes, triangles and regions"),
    ],
)
def test_one_source_is_wanted(fields: dict[str, object], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        section(**fields)
