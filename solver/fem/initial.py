"""Initial stresses at rest, and the preconsolidation of a creeping soil where it is placed."""

from __future__ import annotations

import math

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.fem.materials import SoftSoilCreepMaterial
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.triangle import SHAPES

__all__ = ["creep_scale", "equivalent_pressures", "point_coordinates", "preconsolidation", "stress_at_rest"]


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


def equivalent_pressures(stress: FloatArray, material: SoftSoilCreepMaterial) -> FloatArray:
    """Equivalent pressure p_eq, kPa, of stresses (..., 4), tension positive."""
    soil = material.soil
    p = -stress[..., :3].mean(axis=-1)
    q2 = 1.5 * ((stress[..., :3] + p[..., np.newaxis]) ** 2).sum(axis=-1) + 3.0 * stress[..., 3] ** 2
    x = np.maximum(p + soil.shift, soil.pressure_floor)
    pressure: FloatArray = x + q2 / (soil.M**2 * (x + soil.extra))
    return pressure


def preconsolidation(stress: FloatArray, material: SoftSoilCreepMaterial) -> FloatArray:
    """ln p_p (...,), kPa, of a soil placed under stresses (..., 4), tension positive."""
    if material.POP is None:
        log_pp: FloatArray = np.log(equivalent_pressures(stress, material)) + math.log(material.OCR)
        return log_pp
    shift = material.POP * np.array([material.soil.K0nc, 1.0, material.soil.K0nc, 0.0])
    raised: FloatArray = np.log(equivalent_pressures(stress - shift, material))
    return raised


def creep_scale(stress: FloatArray, log_pp: FloatArray, chosen: IntArray, material: SoftSoilCreepMaterial) -> float:
    """Smallest ln(theta/day) over triangles: theta is the time that creep takes to slow down, tau (p_eq/p_p)^-beta."""
    soil = material.soil
    beta = (soil.lambda_star - soil.kappa_star) / soil.mu_star
    ratio = np.log(equivalent_pressures(stress[chosen], material)) - log_pp[chosen]
    return math.log(soil.tau) - beta * float(ratio.max())
