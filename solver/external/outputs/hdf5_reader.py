"""Series from HDF5 files. Needs h5py, which the extra ``mesh`` brings.

::

    crest: {file: results.h5, x: results/time, y: "results/uy[*, 3]", y_factor: -1}
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field, field_validator

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.external.errors import OutputError
from geoswarm.solver.external.outputs.base import Point, ScaledReader
from geoswarm.solver.external.outputs.fields import below
from geoswarm.solver.external.outputs.lines import opened
from geoswarm.solver.system.extras import has, needs_extra
from geoswarm.solver.words import did_you_mean

__all__ = ["Dataset", "Hdf5Reader", "parse_dataset"]

_DATASET = re.compile(r"(?P<path>[^\[\]]+?)\s*(?:\[(?P<places>[-\d*,\s]+)\])?", re.ASCII)


@dataclass(frozen=True, slots=True)
class Dataset:
    """A data set and which of its numbers: an index (from 0, negative from the end) or None for all, a dimension."""

    path: str
    places: tuple[int | None, ...] | None


def parse_dataset(text: str) -> Dataset:
    """Read ``group/name`` or ``group/name[*, 3]``.

    Raises
    ------
    ValueError
        It is none, or the brackets do not hold exactly one ``*``.
    """
    found = _DATASET.fullmatch(text.strip())
    if found is None:
        raise ValueError(f"'{text[:60]}' is not a data set; write for example results/uy or results/uy[*, 3]")
    if found["places"] is None:
        return Dataset(found["path"], None)
    places = [place.strip() for place in found["places"].split(",")]
    if places.count("*") != 1 or not all(re.fullmatch(r"\*|-?\d{1,18}", place, re.ASCII) for place in places):
        raise ValueError(f"'{text[:60]}': one * and otherwise whole numbers are expected, such as results/uy[*, 3]")
    return Dataset(found["path"], tuple(None if place == "*" else int(place) for place in places))


class Hdf5Reader(ScaledReader):
    """x and y from data sets; only the requested part is read."""

    told_by: ClassVar[str] = "HDF5 (a file .h5 or .hdf5, x and y)"

    format: Literal["hdf5"] = Field("hdf5", description="May be left out for files named .h5 or .hdf5.")
    x: str = Field(max_length=1000, description="Data set of x, such as results/time.")
    y: str = Field(max_length=1000, description="Data set of y, such as results/uy[*, 3]; indices count from 0.")

    @field_validator("x", "y")
    @classmethod
    def _is_dataset(cls, text: str) -> str:
        parse_dataset(text)
        return text.strip()

    @property
    def lacks(self) -> str | None:
        """h5py, where it is not installed."""
        return None if has("h5py") else needs_extra(f"{self.file}: reading HDF5", "h5py")

    def scan(self, folder: Path) -> Iterator[Point]:
        """Give the points in the order of the data sets."""
        opened(folder, self.file).close()
        try:
            h5py = importlib.import_module("h5py")
        except ImportError:
            raise OutputError("bad_output", needs_extra(f"{self.file}: reading HDF5", "h5py")) from None
        try:
            with h5py.File(below(folder, self.file), "r") as file:
                x, y = self._numbers(h5py, file, self.x), self._numbers(h5py, file, self.y)
        except (OSError, KeyError, ValueError, RuntimeError, TypeError) as error:
            raise OutputError("bad_output", f"{self.file}: cannot be read as HDF5: {error}") from None
        if len(x) != len(y):
            message = f"{self.x} has {len(x)} numbers and {self.y} has {len(y)}; as many of both are expected"
            raise OutputError("bad_output", f"{self.file}: {message}")
        for at, (one_x, one_y) in enumerate(zip(x.tolist(), (self.y_factor * y).tolist(), strict=True)):
            yield Point(one_x, one_y, 0, f"entry {at}: x = {one_x!r}, y = {one_y!r}")

    def _numbers(self, h5py: Any, file: Any, text: str) -> FloatArray:
        wanted = parse_dataset(text)
        found = file.get(wanted.path)
        if not isinstance(found, h5py.Dataset):
            raise OutputError("bad_output", f"{self.file}: no data set {wanted.path}{_nearby(h5py, file, wanted.path)}")
        shape = found.shape or ()
        places = wanted.places or (None,)
        if len(places) != len(shape):
            message = f"{wanted.path} has shape {shape}; an index or * for each dimension is expected, such as [*, 0]"
            raise OutputError("bad_output", f"{self.file}: {message}")
        for place, length in zip(places, shape, strict=True):
            if place is not None and not -length <= place < length:
                message = f"{wanted.path} has shape {shape}; index {place} does not exist"
                raise OutputError("bad_output", f"{self.file}: {message}")
        key = tuple(
            slice(None) if place is None else place % length for place, length in zip(places, shape, strict=True)
        )
        numbers = np.asarray(found[key])
        if numbers.dtype.kind not in "fiu":
            raise OutputError("bad_output", f"{self.file}: {wanted.path} holds {numbers.dtype}; numbers are expected")
        return numbers.astype(np.float64)


def _nearby(h5py: Any, file: Any, path: str) -> str:
    names: list[str] = []

    def collect(name: str, one: Any) -> bool | None:
        if isinstance(one, h5py.Dataset):
            names.append(name)
        return True if len(names) == 50 else None

    file.visititems(collect)
    listed = ", ".join(names[:20]) or "none"
    return f"{did_you_mean(path.strip('/'), names)}; there are {listed}"
