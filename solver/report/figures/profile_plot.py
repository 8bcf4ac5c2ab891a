"""Displacement over depth below points of the surface: how much of it the shear zone takes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import MeshError
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.report.figures.style import BLUE, GREEN, MUTED, ORANGE, SKY, drawing, finish

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["DepthProfile", "depth_profile", "profile_figure", "profile_rows"]

_SHADE = "#f3cdb3"


@dataclass(frozen=True)
class DepthProfile:
    """Displacement of the nodes below a point.

    Parameters
    ----------
    depth
        (k,): below the surface, m, increasing.
    displacement
        (k,): horizontal, m.
    band
        Depth of the top and the bottom of the shear zone there, m.
    """

    depth: FloatArray
    displacement: FloatArray
    band: tuple[float, float]


def depth_profile(mesh: Mesh, displacement: FloatArray, point: str, region: str) -> DepthProfile:
    """Take the nodes of the vertical column below a named point of the surface.

    Parameters
    ----------
    displacement
        (n, 2), m.
    region
        Name of the region of the shear zone.

    Raises
    ------
    MeshError
        No column of that region stands there.
    """
    x, y = mesh.nodes[mesh.points[point]]
    wide = float(np.ptp(mesh.nodes[:, 0]))
    column = np.flatnonzero(np.abs(mesh.nodes[:, 0] - x) < 1e-9 * wide)
    column = column[np.argsort(-mesh.nodes[column, 1], kind="stable")]
    members = np.unique(mesh.triangles[mesh.regions == mesh.region_names.index(region)])
    inside = y - mesh.nodes[np.intersect1d(column, members), 1]
    if inside.size < 2:
        raise MeshError(f"point {point}: no column of region {region} stands below it")
    return DepthProfile(y - mesh.nodes[column, 1], displacement[column, 0], (float(inside.min()), float(inside.max())))


def profile_figure(title: str, profiles: Mapping[str, DepthProfile], *, unit: str = "m") -> Figure:
    """Draw one panel a point, depth downwards, the shear zone shaded; displacement in ``unit`` (m, cm or mm)."""
    from matplotlib.figure import Figure

    factor = {"m": 1.0, "cm": 100.0, "mm": 1000.0}[unit]
    colours = (BLUE, ORANGE, GREEN, SKY)
    with drawing():
        figure = Figure(figsize=(1.2 + 1.75 * len(profiles), 3.6), layout="constrained")
        figure.suptitle(title, weight="bold")
        panels = figure.subplots(1, len(profiles), squeeze=False, sharey=True)[0]
        for number, (axes, (name, profile)) in enumerate(zip(panels, profiles.items(), strict=True)):
            axes.axhspan(*profile.band, color=_SHADE, linewidth=0.0, zorder=0)
            axes.axvline(0.0, color=MUTED, linewidth=0.7, zorder=1)
            axes.plot(
                factor * profile.displacement,
                profile.depth,
                color=colours[number % len(colours)],
                linewidth=1.5,
                marker="o",
                markersize=2.2,
            )
            axes.set_title(f"below {name}", loc="left")
            axes.locator_params(axis="x", nbins=4)
            finish(axes, legend=False)
        panels[0].invert_yaxis()
        panels[0].set_ylabel("depth [m]")
        figure.supxlabel(f"horizontal displacement [{unit}]", fontsize=9)
    return figure


def profile_rows(profiles: Mapping[str, DepthProfile]) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: one row a node."""
    rows: list[list[object]] = [
        [name, depth, value]
        for name, profile in profiles.items()
        for depth, value in zip(profile.depth.tolist(), profile.displacement.tolist(), strict=True)
    ]
    return ["point", "depth [m]", "horizontal displacement [m]"], rows
