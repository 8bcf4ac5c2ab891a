"""The successful evaluations of a job as one block of float32, for plots of many thousand points.

Layout: an unsigned 32-bit length, a JSON object of that many bytes (padded with blanks, so that what follows is
aligned), then the columns of the object one after the other. Everything is little-endian.
"""

from __future__ import annotations

import gzip
import json
import struct
from typing import TYPE_CHECKING, Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.problem import Problem
from geoswarm.solver.report.figures.labels import parameter_labels
from geoswarm.solver.report.jsonable import jsonable
from geoswarm.solver.units import convert

if TYPE_CHECKING:
    from geoswarm.solver.identifiability import Samples

__all__ = ["MEDIA_TYPE", "compressed", "points_block"]

MEDIA_TYPE = "application/vnd.geoswarm.points"
_LENGTH = struct.Struct("<I")
_FAST = 1  # a tenth of a second for 20 000 x 6; more effort gains a few per cent


def points_block(problem: Problem, samples: Samples, *, responses: bool = False) -> bytes:
    """Return the evaluations as :data:`MEDIA_TYPE`.

    Columns, of shape (n,): generation, particle, objective, one a free parameter (natural values), one a misfit f'_g.
    With ``responses`` one more a series, (n, m_g) row by row, base units. Places are exact up to 2^24.
    """
    columns: list[tuple[str, str, FloatArray]] = [
        ("own", "generation", samples.generations.astype(np.float64)),
        ("own", "particle", samples.particles.astype(np.float64)),
        ("own", "objective", samples.objectives),
    ]
    columns += [("parameter", name, samples.parameters[:, place]) for place, name in enumerate(samples.names)]
    columns += [("misfit", series, values) for series, values in samples.misfits.items()]
    if responses:
        columns += [("response", series, values) for series, values in samples.responses.items()]
    head = _head(problem, samples) | {
        "columns": [
            {"kind": kind, "name": name, "width": 1 if values.ndim == 1 else values.shape[1]}
            for kind, name, values in columns
        ]
    }
    text = json.dumps(jsonable(head), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    with np.errstate(over="ignore", under="ignore"):  # what float32 cannot hold is infinite or 0
        body = b"".join(np.ascontiguousarray(values, dtype="<f4").tobytes() for _, _, values in columns)
    return _LENGTH.pack(len(text)) + text + body


def compressed(content: bytes, accept_encoding: str) -> tuple[bytes, dict[str, str]]:
    """Return a body as a client takes it, and the headers that say so."""
    headers = {"Vary": "Accept-Encoding"}
    if "gzip" not in accept_encoding:
        return content, headers
    return gzip.compress(content, _FAST, mtime=0), headers | {"Content-Encoding": "gzip"}


def _head(problem: Problem, samples: Samples) -> dict[str, Any]:
    labels = parameter_labels(problem)
    series = {info.name: info for info in problem.model.series}
    return {
        "count": samples.size,
        "failed": samples.failed,
        "left_out": samples.left_out,
        "source": samples.source if samples.size else None,
        "parameters": [
            {
                "name": name,
                "symbol": labels[name].symbol,
                "unit": labels[name].unit,
                "scale": samples.scales[place],
                "lower": samples.lower[place],
                "upper": samples.upper[place],
            }
            for place, name in enumerate(samples.names)
        ],
        "series": [
            {
                "name": observed.series,
                "weight": observed.weight,
                "x": observed.x,
                "y": observed.y,
                "x_quantity": series[observed.series].x_quantity,
                "x_unit": series[observed.series].x_unit,
                "y_quantity": series[observed.series].y_quantity,
                "y_unit": series[observed.series].y_unit,
                "shown": _shown(observed.x_unit, series[observed.series].x_unit)
                + _shown(observed.y_unit, series[observed.series].y_unit),
            }
            for observed in problem.observations
        ],
    }


def _shown(given: str | None, base: str) -> list[Any]:
    """The unit that a user gave and the number of it in one base unit."""
    if given is None or given == base:
        return [base, 1.0]
    zero, one = convert(np.array([0.0, 1.0]), base, given)
    return [given, float(one - zero)] if zero == 0.0 else [base, 1.0]
