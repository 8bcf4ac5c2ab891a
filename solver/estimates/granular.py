"""Granulate hardness and exponent of hypoplastic sand, from the compression of the loosest specimen."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.classical.compression import first_loading
from geoswarm.solver.classical.errors import NoEvaluationError
from geoswarm.solver.classical.straight import straight_line
from geoswarm.solver.estimates.compression import CompressionReadings, compression_readings
from geoswarm.solver.estimates.stage_ends import load_tests
from geoswarm.solver.problem import Problem

__all__ = ["Hardness", "bauer_fit", "hardness_of"]

_FEWEST = 4
"""Readings of first loading through which a law of three constants is drawn."""
_EXPONENTS = np.linspace(0.05, 1.0, 951)
_USUAL_ANGLE = 33.0
"""Critical friction angle, degree, for the earth pressure at rest, where none is known."""


@dataclass(frozen=True, slots=True)
class Hardness:
    """h_s [kPa], n, and what they were read from."""

    h_s: float
    n: float
    source: str


def hardness_of(problem: Problem, known: Mapping[str, float]) -> Hardness | None:
    """h_s and n from first loading of the specimen with the largest void ratio; None where it shows none.

    The mean stress of an oedometer is that at rest, K0 = 1 - sin(phi_c), with ``phi_c`` [degree] among ``known``.
    """
    read = [one for test in load_tests(problem) if (one := compression_readings(problem, test)) is not None]
    read = [one for one in read if one.void_ratio is not None]
    if not read:
        return None
    loose = max(read, key=lambda one: one.void_ratio or 0.0)
    try:
        h_s, n, _ = bauer_fit(*_first_loading(loose, known.get("phi_c", _USUAL_ANGLE)))
    except NoEvaluationError:
        return None
    test = f"{loose.part}: " if loose.part else ""
    how = f"{test}Bauer's law through first loading, e = {loose.void_ratio:.3g}; Herle & Gudehus (1999)"
    return Hardness(h_s, n, how)


def _first_loading(read: CompressionReadings, phi_c: float) -> tuple[FloatArray, FloatArray]:
    logarithm, e = first_loading(read.stress, read.y)
    share = 1.0 - 2.0 / 3.0 * math.sin(math.radians(phi_c)) if read.confined else 1.0  # (1 + 2 K0) / 3
    return share * 10.0**logarithm, e


def bauer_fit(p: FloatArray, e: FloatArray) -> tuple[float, float, float]:
    """Return h_s [kPa], n and the void ratio at p = 0 of ``e = e_0 exp(-(3 p/h_s)^n)`` (Bauer 1996), least squares.

    Parameters
    ----------
    p, e
        Mean effective stress, kPa, and void ratio, shape (k,).

    Raises
    ------
    NoEvaluationError
        There are fewer than four readings, or they do not bend as the law does.
    """
    if p.size < _FEWEST:
        raise NoEvaluationError(f"first loading has {p.size} readings; at least {_FEWEST} are needed")
    logarithm = np.log(e)  # a - (3/h_s)^n p^n: a straight line over p^n

    def missed(n: float) -> float:
        slope, start, _ = straight_line(p**n, logarithm)
        return float(np.sum((logarithm - start - slope * p**n) ** 2)) if slope < 0.0 else math.inf

    misses = np.array([missed(n) for n in _EXPONENTS])
    best = int(np.argmin(misses))
    if not np.isfinite(misses[best]) or best in (0, _EXPONENTS.size - 1):
        raise NoEvaluationError("the compression curve does not bend as Bauer's law does")
    n = float(_EXPONENTS[best])
    slope, start, _ = straight_line(p**n, logarithm)
    return 3.0 / (-slope) ** (1.0 / n), n, math.exp(start)
