"""Array types used throughout the solver, and arrays as bytes."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

__all__ = ["BoolArray", "FloatArray", "IntArray", "pack_array", "unpack_array"]

FloatArray: TypeAlias = NDArray[np.float64]
"""Numbers as forward models get and return them.

Examples
--------
>>> import numpy as np
>>> import geoswarm as gs
>>> def doubled(x: gs.FloatArray) -> gs.FloatArray:
...     return 2.0 * x
>>> doubled(np.array([1.0, 2.0])).tolist()
[2.0, 4.0]
"""
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]


def pack_array(array: FloatArray) -> bytes:
    """Return the little-endian float64 of an array, shape (n,)."""
    return np.ascontiguousarray(array, dtype="<f8").tobytes()


def unpack_array(data: bytes) -> FloatArray:
    """Invert :func:`pack_array`."""
    return np.frombuffer(data, dtype="<f8").astype(np.float64)
