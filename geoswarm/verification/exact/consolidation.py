"""Consolidation in one dimension and to a drain: series and closed forms. Time factors are T = c_v t/H^2."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from geoswarm.solver.arrays import FloatArray

__all__ = ["barron", "crs_strain", "degree", "isochrone", "mu_by_quadrature", "ramped_degree", "two_layers"]

TERMS = 400


def _modes(terms: int) -> FloatArray:
    found: FloatArray = (np.arange(terms, dtype=np.float64) + 0.5) * math.pi
    return found


def degree(T: FloatArray, terms: int = TERMS) -> FloatArray:
    """Mean degree of consolidation at time factors (m,) of a load that acts at once (Terzaghi & Fröhlich 1936)."""
    M = _modes(terms)
    found: FloatArray = 1.0 - (2.0 / M**2 * np.exp(-np.outer(T, M**2))).sum(axis=1)
    return found


def isochrone(z: float, T: FloatArray, terms: int = TERMS) -> FloatArray:
    """Pore pressure over the load, (m,), at a depth over the way of water: 1 is the closed end (the same)."""
    M = _modes(terms)
    found: FloatArray = (2.0 / M * np.sin(M * z) * np.exp(-np.outer(T, M**2))).sum(axis=1)
    return found


def ramped_degree(T: FloatArray, ramp: float, terms: int = TERMS) -> FloatArray:
    """The degree over the final load of a load that grows until ``ramp`` (Olson 1977): the mean of loads before."""
    M = _modes(terms)
    grown = np.minimum(T, ramp)[:, np.newaxis]
    rest = (np.exp((grown - T[:, np.newaxis]) * M**2) - np.exp(-np.outer(T, M**2))) / M**2
    found: FloatArray = (grown[:, 0] - (2.0 / M**2 * rest).sum(axis=1)) / ramp
    return found


def crs_strain(x: float, T: float, terms: int = TERMS) -> float:
    """(strain - r t)/(r H^2/c_v) at height x (0 base, 1 top) and time factor T, r the rate of strain.

    Diffusion of strain with a constant inflow at the top (Carslaw & Jaeger 1959, section 3.8), which is Wissa,
    Christian, Davis & Heiberg (1971), equation 5, with their X = 1 - x.
    """
    n = np.arange(1, terms + 1)
    decay = (-1.0) ** n / n**2 * np.cos(n * math.pi * x) * np.exp(-((n * math.pi) ** 2) * T)
    return float((3.0 * x**2 - 1.0) / 6.0 - 2.0 / math.pi**2 * decay.sum())


def two_layers(
    T: FloatArray, upper: tuple[float, float, float], lower: tuple[float, float, float], water: float
) -> FloatArray:
    """Settlement over the load of two layers (thickness, k, E), closed at the base, at times (m,).

    Gray (1945), by separated variables: in the upper layer sin(w z/sqrt(c1)), in the lower one cos(w y/sqrt(c2)) from
    the base; pressures and flows are the same where they meet.
    """
    (h1, k1, E1), (h2, k2, E2) = upper, lower
    a, b = h1 / math.sqrt(k1 * E1 / water), h2 / math.sqrt(k2 * E2 / water)
    q = math.sqrt(k1 / E1) / math.sqrt(k2 / E2)

    def left(w: float) -> float:
        return math.sin(a * w) * math.sin(b * w) - q * math.cos(a * w) * math.cos(b * w)

    fine = np.linspace(1.0e-9, 400.0 * math.pi / (a + b), 40_001)
    signs = np.array([left(w) for w in fine])
    roots = [brentq(left, fine[i], fine[i + 1], xtol=1e-14) for i in np.flatnonzero(signs[:-1] * signs[1:] < 0.0)]
    settled = np.full(T.size, h1 / E1 + h2 / E2)
    for w in roots:
        # One of both may vanish where they meet: the shape is scaled by the larger.
        A, B = math.cos(b * w), math.sin(a * w)
        if abs(A) + abs(B) < 1.0e-9:
            A, B = 1.0, -math.cos(a * w) / math.sin(b * w) * q
        first = A * (1.0 - math.cos(a * w)) / (a * w) * h1 / E1 + B * math.sin(b * w) / (b * w) * h2 / E2
        square = A * A * (0.5 - math.sin(2 * a * w) / (4 * a * w)) * h1 / E1
        square += B * B * (0.5 + math.sin(2 * b * w) / (4 * b * w)) * h2 / E2
        settled -= first**2 / square * np.exp(-w * w * T)
    return settled


def barron(n: float) -> float:
    """mu of equal strain without smear, n the ratio of the diameters (Barron 1948)."""
    return n**2 / (n**2 - 1.0) * math.log(n) - (3.0 * n**2 - 1.0) / (4.0 * n**2)


def mu_by_quadrature(n: float, s: float, ratio: float) -> float:
    """mu of equal strain from the flow through each cylinder, the radius of the drain being 1.

    ``s``: radius of the smeared zone; ``ratio``: permeability outside over that within.
    """

    def pressure(r: float) -> float:
        def slope(x: float) -> float:
            return (n * n - x * x) / (2.0 * x) * (ratio if x < s else 1.0)

        return float(quad(slope, 1.0, r, points=[s] if 1.0 < s < r else None)[0])

    whole = quad(lambda r: pressure(r) * 2.0 * r, 1.0, n, points=[s], limit=200)[0] / (n * n - 1.0)
    return float(2.0 * whole / n**2)
