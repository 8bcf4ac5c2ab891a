"""Sections that the tests mesh."""

from __future__ import annotations

import math

import numpy as np

from geoswarm.solver.fem.mesh.cross_section import Cut, Extent, Layer, Profile, SectionGeometry, SurfacePoint
from geoswarm.solver.fem.mesh.mesh import Mesh


def profile(*points: tuple[float, float]) -> Profile:
    x, y = np.array(points, dtype=np.float64).T
    return Profile(x, y)


def creeping_slope(depth: float = 30.0, thickness: float = 2.0, angle: float = 10.0) -> SectionGeometry:
    """A long slope with a thin shear zone, a crack, and a secondary shear zone between two interfaces."""
    height = 1080.0 * math.tan(math.radians(angle))
    return SectionGeometry(
        surface=profile((0.0, height), (300.0, 0.7 * height), (700.0, 0.33 * height), (1080.0, 0.0)),
        layers=(
            Layer("cover", 2, thickness=profile((0.0, 20.0), (400.0, depth), (900.0, depth), (1080.0, 25.0))),
            Layer("shear_zone", 2, thickness=profile((0.0, thickness))),
            Layer("bedrock", 1, thickness=profile((0.0, 20.0))),
        ),
        cuts=(Cut("crack", 120.0, 120.0, "cover"), Cut("secondary", 200.0, 235.0, "cover", 2.0, "secondary_zone")),
        points=(SurfacePoint("A", 215.0), SurfacePoint("B", 330.0), SurfacePoint("base_of_B", 330.0, "shear_zone")),
        zones=(Extent("stable", 0.0, 120.0, "shear_zone"),),
    )


def embankment(lift: float = 2.5) -> SectionGeometry:
    """An embankment of two lifts on a soft layer; the lifts end where their bottoms meet the slope."""
    return SectionGeometry(
        surface=profile((-30.0, 0.0), (-15.0, 0.0), (-5.0, 5.0), (5.0, 5.0), (15.0, 0.0), (30.0, 0.0)),
        layers=(
            Layer("upper_lift", 1, bottom=profile((0.0, lift))),
            Layer("lower_lift", 1, bottom=profile((0.0, 0.0))),
            Layer("clay", 3, thickness=profile((0.0, 6.0)), grading=2.0),
        ),
        segments=(Extent("road", -4.0, 4.0),),
        interfaces=(Extent("geotextile", -11.0, 11.0, "lower_lift"),),
    )


def area_of(mesh: Mesh, region: str | None = None) -> float:
    chosen = mesh.triangles if region is None else mesh.triangles[mesh.regions == mesh.region_names.index(region)]
    a, b, c = (mesh.nodes[chosen[:, n]] for n in range(3))
    return float(0.5 * np.sum((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]))
