"""Writes the mesh of this example, embankment.mdpa: that of own_elements.yaml, six-node triangles, with its parts.

Only needed to change it; it is kept beside it.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from geoswarm.solver.forward.cross_section import SectionModel
from geoswarm.solver.problem import load_problem

HERE = Path(__file__).resolve().parent


def part(name: str, nodes: Iterable[int], elements: Iterable[int] = ()) -> list[str]:
    """Lines of a part: numbers of its nodes and elements, from 0."""
    listed = [f"        {number + 1}" for number in nodes]
    members = [f"        {number + 1}" for number in elements]
    return [
        f"Begin SubModelPart {name}",
        *("    Begin SubModelPartNodes", *listed, "    End SubModelPartNodes"),
        *("    Begin SubModelPartElements", *members, "    End SubModelPartElements"),
        *("End SubModelPart", ""),
    ]


def main(folder: Path) -> None:
    """Write it into a folder."""
    model = load_problem(HERE / "own_elements.yaml").model
    assert isinstance(model, SectionModel)
    mesh = model.nominal
    lines = ["// Half of an embankment on two layers; m. Written by make_model.py.", ""]
    lines += ["Begin Properties 0", "End Properties", "", "Begin Nodes"]
    lines += [f"{number} {x:.12g} {y:.12g} 0" for number, (x, y) in enumerate(mesh.nodes.tolist(), start=1)]
    lines += ["End Nodes", "", "Begin Elements UPwSmallStrainElement2D6N"]
    for number, triangle in enumerate(mesh.triangles.tolist(), start=1):
        lines.append(f"{number} 0 {' '.join(str(node + 1) for node in triangle)}")
    lines += ["End Elements", ""]
    for region, name in enumerate(mesh.region_names):
        elements = np.flatnonzero(mesh.regions == region)
        lines += part(name, np.unique(mesh.triangles[elements]).tolist(), elements.tolist())
    sides = np.concatenate([mesh.boundaries["left"], mesh.boundaries["right"]])
    lines += part("sides", np.unique(sides).tolist())
    lines += part("base", np.unique(mesh.boundaries["bottom"]).tolist())
    for name, node in mesh.points.items():
        lines += part(name, [node])
    (folder / "embankment.mdpa").write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main(HERE)
