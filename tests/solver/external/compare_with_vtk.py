"""Write vtk_cases.json: elements with values at points inside them by VTK 9, which our sampling is compared with.

VTK is no dependency: the script runs in an environment of its own.

    uv run --no-project --with vtk,numpy python tests/solver/external/compare_with_vtk.py
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

CASES = Path(__file__).with_name("vtk_cases.json")

CELLS = {
    "triangle": "vtkTriangle",
    "triangle6": "vtkQuadraticTriangle",
    "quad": "vtkQuad",
    "quad8": "vtkQuadraticQuad",
    "quad9": "vtkBiQuadraticQuad",
    "tetra": "vtkTetra",
    "tetra10": "vtkQuadraticTetra",
    "hexahedron": "vtkHexahedron",
    "hexahedron20": "vtkQuadraticHexahedron",
    "hexahedron27": "vtkTriQuadraticHexahedron",
    "wedge15": "vtkQuadraticWedge",
    "pyramid": "vtkPyramid",
}


def case(name: str, random: np.random.Generator) -> dict[str, Any]:
    """Disturb the nodes of a cell, and evaluate coordinates and a random field at inner points."""
    from vtkmodules import vtkCommonDataModel
    from vtkmodules.vtkCommonCore import mutable

    cell = getattr(vtkCommonDataModel, CELLS[name])()
    count, dimension = cell.GetNumberOfPoints(), cell.GetCellDimension()
    nodes = np.array(cell.GetParametricCoords()).reshape(-1, 3)[:count]
    nodes[:, :dimension] += random.uniform(-0.04, 0.04, (count, dimension))
    for number, node in enumerate(nodes.tolist()):
        cell.GetPoints().SetPoint(number, node)
        cell.GetPointIds().SetId(number, number)
    field = random.normal(size=count)
    points, values = [], []
    for _ in range(3):
        at, point, weights = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0] * count
        at[:dimension] = random.uniform(0.1, 0.3, dimension).tolist()
        cell.EvaluateLocation(mutable(0), at, point, weights)
        points.append(point[:dimension])
        values.append(float(np.dot(weights, field)))
    return {"nodes": nodes[:, :dimension].tolist(), "field": field.tolist(), "points": points, "values": values}


def main() -> None:
    """Evaluate every type of cell."""
    random = np.random.default_rng(2026)
    CASES.write_text(json.dumps({name: case(name, random) for name in CELLS}) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
