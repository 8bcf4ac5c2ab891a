"""The quick way to read a large CSV file that holds nothing but numbers below its headings."""

from __future__ import annotations

import io
import re

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.problem.tables.cells import Sheet
from geoswarm.solver.problem.tables.packed import Cell
from geoswarm.solver.problem.tables.reading import MAX_TABLE_BYTES

__all__ = ["plain_numbers"]

_WORTH_IT = 2**17
_PLAIN = re.compile(rb"[0-9eE+\-., \r\n]*")


def plain_numbers(content: bytes) -> tuple[Sheet, FloatArray] | None:
    """Read headings, with the first row as a sample, and all numbers, shape (rows, columns).

    None for what is small, is no such file, or has a mistake: then the reader that names lines is asked.
    """
    if not _WORTH_IT < len(content) <= MAX_TABLE_BYTES:
        return None
    first, newline, body = content.partition(b"\n")
    heading = first.removeprefix(b"\xef\xbb\xbf").strip()
    if not newline or any(sign in heading for sign in b';\t"#') or _PLAIN.fullmatch(body) is None:
        return None
    try:
        header = [cell.strip() for cell in heading.decode("ascii").split(",")]
        numbers = np.loadtxt(io.BytesIO(body), delimiter=",", ndmin=2)
    except ValueError:  # not ASCII, an empty cell, rows of several lengths
        return None
    if numbers.shape[1] != len(header) or not np.isfinite(numbers).all() or _PLAIN.fullmatch(heading) is not None:
        return None
    sample: list[Cell] = [float(number) for number in numbers[0]]
    return Sheet((), None, "", 1, header, [(2, sample)], {}), numbers
