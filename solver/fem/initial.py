"""Initial stresses at rest, and the initial state of a soil where it is placed."""

from __future__ import annotations

import math

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.tensors import flip_sign
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.triangle import SHAPES
from geoswarm.solver.laws.base import Soil

__all__ = ["initial_internal", "log_time_scale", "point_coordinates", "stress_at_rest"]


def point_coordinates(mesh: Mesh, positions: FloatArray) -> FloatArray:
    """Coordinates (e, 3, 2), m, of the integration points."""
    coordinates: FloatArray = np.einsum("pn,enk->epk", SHAPES, positions[mesh.triangles])
    return coordinates


def stress_at_rest(
    mesh: Mesh, positions: FloatArray, unit_weight: FloatArray, ratio: FloatArray, surcharge: float
) -> FloatArray:
    """Stress (e, 3, 4), kPa, tension positive, of a body at rest under its weight.

    Parameters
    ----------
    positions
        (n, 2), m.
    unit_weight, ratio
        (e,): kN/m3, 0 where inactive; K0 of each triangle.
    surcharge
        Pressure on top, kPa.

    Notes
    -----
    The vertical stress is the weight of the column above each point, the horizontal ones K0 times that; exact for
    horizontal surfaces and layers. The next phase brings what is missing to equilibrium.
    """
    points = point_coordinates(mesh, positions).reshape(-1, 2)
    vertical = np.full(points.shape[0], surcharge)
    order = np.argsort(points[:, 0], kind="stable")
    x, y = points[order, 0], points[order, 1]
    above = np.zeros(points.shape[0])
    for e in np.flatnonzero(unit_weight > 0.0):
        corners = positions[mesh.triangles[e, :3]]
        first, last = np.searchsorted(x, [corners[:, 0].min(), corners[:, 0].max()])
        if first == last:
            continue
        low, high = np.full(last - first, np.inf), np.full(last - first, -np.inf)
        for a, b in ((0, 1), (1, 2), (2, 0)):
            (xa, ya), (xb, yb) = corners[a], corners[b]
            if xa == xb:
                continue
            share = (x[first:last] - xa) / (xb - xa)
            inside = (share >= 0.0) & (share <= 1.0)
            height = ya + share * (yb - ya)
            low = np.where(inside, np.minimum(low, height), low)
            high = np.where(inside, np.maximum(high, height), high)
        length = np.maximum(high - np.maximum(low, y[first:last]), 0.0)
        above[first:last] += unit_weight[e] * length
    vertical[order] += above
    stress = np.zeros((points.shape[0], 4))
    stress[:, 1] = -vertical
    stress[:, 0] = stress[:, 2] = -np.repeat(ratio, 3) * vertical
    return stress.reshape(-1, 3, 4)


def initial_internal(stress: FloatArray, soil: Soil) -> FloatArray:
    """State variables (..., s) of a soil placed under stresses (..., 4), tension positive."""
    return soil.law.initial_state(flip_sign(stress), soil.constants)


def log_time_scale(stress: FloatArray, internal: FloatArray, soil: Soil) -> float:
    """Smallest ln(theta/day) over points (..., 4), tension positive, in which a soil slows down; inf: time has none."""
    scales = soil.law.log_time_scale(flip_sign(stress), internal, soil.constants)
    return math.inf if scales is None else float(scales.min(initial=math.inf))
