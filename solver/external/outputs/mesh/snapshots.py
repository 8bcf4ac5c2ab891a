"""Meshes with results at each time, out of VTU, PVTU, PVD and XDMF files. meshio (extra ``mesh``) reads them."""

from __future__ import annotations

import importlib
import lzma
import os
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.external.errors import OutputError
from geoswarm.solver.external.outputs.fields import below, relative_path
from geoswarm.solver.external.outputs.lines import opened
from geoswarm.solver.system.extras import has, needs_extra

__all__ = ["Piece", "Snapshot", "needed_package", "snapshots"]

_ERRORS = (
    *(OSError, ValueError, KeyError, IndexError, TypeError, AttributeError, AssertionError, RuntimeError, SystemExit),
    *(ET.ParseError, zlib.error, lzma.LZMAError, EOFError, struct.error, Warning),
)


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A mesh with results.

    Parameters
    ----------
    file
        Where it was read, for messages.
    nodes
        (n, 3), a missing z is 0.
    blocks
        Type of element in meshio's words, and its nodes, (e, k).
    at_nodes
        Results by name, (n,) or (n, components).
    in_elements
        Results by name, for each block (e,) or (e, components).
    """

    file: str
    nodes: FloatArray
    blocks: tuple[tuple[str, IntArray], ...]
    at_nodes: Mapping[str, FloatArray]
    in_elements: Mapping[str, list[FloatArray]]


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """What a body is like at one time, in pieces where several processes wrote it."""

    time: float
    pieces: tuple[Piece, ...]


def needed_package(file: str) -> str | None:
    """Return what is not installed here and needed for meshes, in words."""
    for package in ("meshio", "h5py") if file.lower().endswith(".xdmf") else ("meshio",):
        if not has(package):
            return needs_extra(f"{file}: reading results on meshes", package)
    return None


def snapshots(folder: Path, file: str) -> Iterator[Snapshot]:
    """Give the snapshots of a file in its order, one in memory at a time.

    A PVD file names the others and their times; XDMF holds them; a VTU or PVTU file is one, at the time that its field
    data call ``TimeValue`` or ``TIME``, else at 0.

    Raises
    ------
    OutputError
        A file is missing, empty, cut off or of another kind.
    """
    opened(folder, file).close()
    ending = file.lower().rpartition(".")[2]
    if ending == "pvd":
        for time, names in _collection(folder, file):
            yield Snapshot(time, tuple(piece for name in names for _, piece in _pieces(folder, name)))
    elif ending in ("vtu", "pvtu"):
        found = _pieces(folder, file)
        yield Snapshot(found[0][0], tuple(piece for _, piece in found))
    elif ending in ("xdmf", "xmf"):
        yield from _xdmf(folder, file)
    else:
        raise OutputError("bad_output", f"{file}: .pvd, .vtu, .pvtu or .xdmf is expected")


def _meshio(file: str, module: str) -> Any:
    try:
        return importlib.import_module(f"meshio.{module}")
    except ImportError:
        raise OutputError("bad_output", needs_extra(f"{file}: reading results on meshes", "meshio")) from None


def _unreadable(file: str, kind: str, error: BaseException) -> OutputError:
    if isinstance(error, ImportError) or (error.__cause__ and isinstance(error.__cause__, ImportError)):
        return OutputError("bad_output", needs_extra(f"{file}: reading HDF5", "h5py"))
    if isinstance(error, ET.ParseError):
        line, column = error.position
        message = (
            f"{file}: line {line}: {error.msg.partition(':')[0]} at character {column + 1}; the file may be truncated"
        )
        return OutputError("bad_output", message)
    reason = f"meshio does not know {error}" if isinstance(error, KeyError) else str(error) or type(error).__name__
    return OutputError("bad_output", f"{file}: cannot be read as {kind}: {reason}")


def _root(folder: Path, file: str) -> ET.Element:
    with opened(folder, file) as stream:
        try:
            return ET.parse(stream).getroot()
        except ET.ParseError as error:
            raise _unreadable(file, "XML", error) from None


def _beside(file: str, name: str | None) -> str:
    """Return the name, below the folder of the run, of a file that another one names."""
    parent = file.rpartition("/")[0]
    try:
        return relative_path(f"{parent}/{name or ''}" if parent else name or "")
    except ValueError as error:
        raise OutputError("bad_output", f"{file}: names another file that cannot be read: {error}") from None


def _collection(folder: Path, file: str) -> list[tuple[float, list[str]]]:
    times: dict[float, list[str]] = {}
    for entry in _root(folder, file).iter("DataSet"):
        try:
            time = float(entry.get("timestep", "nan"))
        except ValueError:
            raise OutputError(
                "bad_output", f"{file}: timestep '{entry.get('timestep', '')[:40]}' is not a number"
            ) from None
        times.setdefault(time, []).append(_beside(file, entry.get("file")))
    if not times:
        raise OutputError("bad_output", f"{file}: names no files; entries DataSet with timestep and file are expected")
    return list(times.items())


def _pieces(folder: Path, file: str) -> list[tuple[float, Piece]]:
    if file.lower().endswith(".pvtu"):
        names = [_beside(file, entry.get("Source")) for entry in _root(folder, file).iter("Piece")]
        if not names:
            raise OutputError("bad_output", f"{file}: names no pieces")
        return [piece for name in names for piece in _pieces(folder, name)]
    vtu = _meshio(file, "vtu")
    exceptions = importlib.import_module("meshio._exceptions")
    with opened(folder, file) as stream:
        stream.seek(-min(1000, stream.seek(0, os.SEEK_END)), os.SEEK_END)
        whole = b"</VTKFile>" in stream.read()
        stream.seek(0)
        packed = b"vtkLZ4DataCompressor" in stream.read(1000)
    if packed:
        raise OutputError("bad_output", f"{file}: is compressed with LZ4; zlib, LZMA or none is expected")
    if not whole:
        raise OutputError("bad_output", f"{file}: the file is truncated or not VTU; </VTKFile> is expected at its end")
    try:
        mesh = vtu.read(below(folder, file))
    except (*_ERRORS, exceptions.ReadError, exceptions.CorruptionError) as error:
        raise _unreadable(file, "VTU", error) from None
    time = next((mesh.field_data[name] for name in ("TimeValue", "TIME") if name in mesh.field_data), 0.0)
    return [
        (float(np.asarray(time).ravel()[0]), _piece(file, mesh.points, mesh.cells, mesh.point_data, mesh.cell_data))
    ]


def _xdmf(folder: Path, file: str) -> Iterator[Snapshot]:
    xdmf = _meshio(file, "xdmf")
    exceptions = importlib.import_module("meshio._exceptions")
    errors = (*_ERRORS, exceptions.ReadError, exceptions.CorruptionError, ImportError)
    path = below(folder, file)
    series = any(grid.get("CollectionType") == "Temporal" for grid in _root(folder, file).iter("Grid"))
    try:
        if not series:
            mesh = xdmf.read(path)
            yield Snapshot(0.0, (_piece(file, mesh.points, mesh.cells, mesh.point_data, mesh.cell_data),))
            return
        with xdmf.TimeSeriesReader(path) as reader:
            nodes, blocks = reader.read_points_cells()
            for step in range(reader.num_steps):
                time, at_nodes, in_elements = reader.read_data(step)
                yield Snapshot(time, (_piece(file, nodes, blocks, at_nodes, in_elements),))
    except errors as error:
        raise _unreadable(file, "XDMF", error) from None


def _piece(file: str, points: Any, cells: Any, at_nodes: Any, in_elements: Any) -> Piece:
    given = np.asarray(points, dtype=np.float64)
    nodes = np.zeros((len(given), 3))
    nodes[:, : given.shape[1]] = given
    blocks = []
    for block in cells:
        try:
            table = np.asarray(block.data, dtype=np.int64)
        except (ValueError, TypeError):  # polyhedra of several lengths
            table = np.empty((0, 0), dtype=np.int64)
        if table.size and not (table.min() >= 0 and table.max() < len(nodes)):
            raise OutputError("bad_output", f"{file}: an element has nodes that do not exist; 0 to {len(nodes) - 1} do")
        blocks.append((str(block.type), table))
    return Piece(file, nodes, tuple(blocks), dict(at_nodes), dict(in_elements))
