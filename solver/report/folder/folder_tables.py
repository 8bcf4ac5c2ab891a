"""The tables of a run in a folder."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["column", "read_table"]


def read_table(path: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV file by column."""
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def column(rows: list[dict[str, str]], name: str) -> FloatArray:
    """Return a column of numbers, shape (n,)."""
    return np.array([float(row[name]) for row in rows], dtype=np.float64)
