"""The sections of ``series``: the fields of a section determine its reader.

====================  ==========================================================
reader                told by
====================  ==========================================================
any                   ``format: table | search | pest | json | numpy | hdf5 | mesh``
PEST instructions     ``instructions``
search                ``find``
mesh                  ``point``, ``points`` or ``field``
JSON                  a file named ``.json``
NumPy                 a file named ``.npy`` or ``.npz``
HDF5                  a file named ``.h5`` or ``.hdf5``
table                 anything else
====================  ==========================================================
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, TypeAlias

from pydantic import Discriminator, Tag

from geoswarm.solver.external.outputs.base import OutputReader
from geoswarm.solver.external.outputs.hdf5_reader import Hdf5Reader
from geoswarm.solver.external.outputs.json_reader import JsonReader
from geoswarm.solver.external.outputs.mesh.reader import MeshReader
from geoswarm.solver.external.outputs.numpy_reader import NumpyReader
from geoswarm.solver.external.outputs.pest.reader import PestReader
from geoswarm.solver.external.outputs.search import SearchReader
from geoswarm.solver.external.outputs.tables.reader import TableReader

__all__ = ["READERS", "SeriesReader", "format_of"]

READERS: dict[str, type[OutputReader]] = {
    "table": TableReader,
    "search": SearchReader,
    "pest": PestReader,
    "json": JsonReader,
    "numpy": NumpyReader,
    "hdf5": Hdf5Reader,
    "mesh": MeshReader,
}
"""The readers by their format."""

_BY_FIELD = {"instructions": "pest", "find": "search", "point": "mesh", "points": "mesh", "field": "mesh"}
_BY_ENDING = {".json": "json", ".npy": "numpy", ".npz": "numpy", ".h5": "hdf5", ".hdf5": "hdf5"}


def format_of(section: Any) -> str:
    """Return the format of a section (a mapping or a reader), by its fields alone.

    >>> format_of({"file": "out.dat", "instructions": "out.ins"}), format_of({"file": "a.csv", "x": 1, "y": 2})
    ('pest', 'table')
    """
    if isinstance(section, OutputReader):
        return str(getattr(section, "format", "table"))
    if not isinstance(section, Mapping):
        return "table"
    if "format" in section:
        return str(section["format"])
    for field, name in _BY_FIELD.items():
        if field in section:
            return name
    file = str(section.get("file", "")).lower()
    return next((name for ending, name in _BY_ENDING.items() if file.endswith(ending)), "table")


SeriesReader: TypeAlias = Annotated[
    Annotated[TableReader, Tag("table")]
    | Annotated[SearchReader, Tag("search")]
    | Annotated[PestReader, Tag("pest")]
    | Annotated[JsonReader, Tag("json")]
    | Annotated[NumpyReader, Tag("numpy")]
    | Annotated[Hdf5Reader, Tag("hdf5")]
    | Annotated[MeshReader, Tag("mesh")],
    Discriminator(
        format_of,
        custom_error_type="unknown_format",
        custom_error_message=f"format must be one of {', '.join(READERS)}",
    ),
]
"""The section of one series, for fields of pydantic models."""
