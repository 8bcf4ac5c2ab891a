"""Results as files for ParaView: one VTU a time, and a PVD that lists them. Needs the extra ``mesh``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import MeshError
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.mesh.reading import load_meshio

__all__ = ["Snapshot", "write_pvd", "write_vtu"]


@dataclass(frozen=True)
class Snapshot:
    """Fields at one time.

    Parameters
    ----------
    time
        As ParaView shows it, day.
    node_fields
        By name, (n,) or (n, 2) or (n, 3); vectors of two components get a third one of 0.
    triangle_fields
        By name, (e,) or (e, k).
    """

    time: float
    node_fields: Mapping[str, FloatArray] = field(default_factory=dict)
    triangle_fields: Mapping[str, FloatArray] = field(default_factory=dict)


def write_vtu(path: Path, mesh: Mesh, snapshot: Snapshot) -> Path:
    """Write the mesh and the fields of one time; the number of the region is added as ``region``.

    Raises
    ------
    MeshError
        meshio is missing, a field does not fit the mesh, or the file cannot be written.
    """
    meshio = load_meshio("writing VTU files")
    nodes, triangles = mesh.nodes.shape[0], mesh.triangles.shape[0]
    node_fields = {
        name: _spatial(_fitting(name, values, nodes, "nodes")) for name, values in snapshot.node_fields.items()
    }
    cell_fields: dict[str, Any] = {"region": [mesh.regions.astype(np.int32)]}
    for name, values in snapshot.triangle_fields.items():
        cell_fields[name] = [_spatial(_fitting(name, values, triangles, "triangles"))]
    flat = np.concatenate([mesh.nodes, np.zeros((nodes, 1))], axis=1)
    content = meshio.Mesh(
        flat, [("triangle6", mesh.triangles.astype(np.int64))], point_data=node_fields, cell_data=cell_fields
    )
    try:
        content.write(path, file_format="vtu")
    except OSError as error:
        raise MeshError(f"{path}: {error.strerror}") from error
    return path


def write_pvd(path: Path, mesh: Mesh, snapshots: Sequence[Snapshot]) -> list[Path]:
    """Write a series: ``name.pvd`` and, beside it, ``name_0000.vtu`` and so on; return all files, the PVD first.

    Raises
    ------
    MeshError
        As :func:`write_vtu`.
    """
    written, lines = [], []
    for number, snapshot in enumerate(snapshots):
        file = write_vtu(path.with_name(f"{path.stem}_{number:04d}.vtu"), mesh, snapshot)
        written.append(file)
        lines.append(f'    <DataSet timestep="{snapshot.time:.12g}" part="0" file={quoteattr(file.name)}/>')
    text = "\n".join(
        (
            '<?xml version="1.0"?>',
            '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">',
            "  <Collection>",
            *lines,
            "  </Collection>",
            "</VTKFile>",
            "",
        )
    )
    path.write_text(text, encoding="utf-8")
    return [path, *written]


def _fitting(name: str, values: FloatArray, count: int, what: str) -> FloatArray:
    if values.ndim not in (1, 2) or values.shape[0] != count:
        raise MeshError(
            f"field {name} has the shape {values.shape}; one row for each of the {count} {what} is accepted"
        )
    return values


def _spatial(values: FloatArray) -> FloatArray:
    if values.ndim == 2 and values.shape[1] == 2:
        return np.concatenate([values, np.zeros((values.shape[0], 1))], axis=1)
    return np.ascontiguousarray(values)
