"""Figures of a body: its mesh, its deformed mesh, and displacement vectors measured against calculated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.fem.mesh.mesh import Mesh, boundary_edges
from geoswarm.solver.report.figures.style import BLUE, GREEN, GRID, INK, MUTED, ORANGE, drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["deformed_figure", "mesh_figure", "vectors_figure", "vectors_rows"]

_WIDTH = 7.4
_TINTS = ("#cfe3f1", "#f3cdb3", "#dfe2e5", "#c5e5da", "#f2e6b8", "#e5d0e6", "#cde9f2", "#f0d5da")
_CORNERS = [0, 3, 1, 4, 2, 5]
_LONGEST_ARROW = 0.16
"""Length of the longest arrow as a share of the width of the body."""


def mesh_figure(title: str, mesh: Mesh, *, window: tuple[float, float, float, float] | None = None) -> Figure:
    """Draw the mesh with its regions, interfaces and named points.

    Parameters
    ----------
    window
        Left, right, bottom and top of a piece that is drawn larger below, m.
    """
    from matplotlib.figure import Figure

    views = [_limits(mesh.nodes)] if window is None else [_limits(mesh.nodes), window]
    with drawing():
        heights = [_panel_height(view) for view in views]
        figure = Figure(figsize=(_WIDTH, 0.9 + sum(heights) + 0.35 * len(views)), layout="constrained")
        figure.suptitle(title, weight="bold")
        panels = figure.subplots(len(views), 1, squeeze=False, height_ratios=heights)[:, 0]
        for number, (axes, view) in enumerate(zip(panels, views, strict=True)):
            _triangles(axes, mesh, mesh.nodes, 0.25 if number == 0 else 0.5)
            _interfaces(axes, mesh, mesh.nodes)
            _points(axes, mesh, view)
            _frame(axes, view)
        _legend(figure, mesh)
    return figure


def deformed_figure(title: str, mesh: Mesh, displacement: FloatArray, factor: float | None = None) -> Figure:
    """Draw the deformed mesh over the outline of the undeformed one.

    Parameters
    ----------
    displacement
        (n, 2), m.
    factor
        By how much it is exaggerated; a round number that shows it well unless given.
    """
    from matplotlib.figure import Figure

    if factor is None:
        factor = _round_factor(mesh.nodes, displacement)
    moved = mesh.nodes + factor * displacement
    view = _limits(np.concatenate([mesh.nodes, moved]))
    with drawing():
        figure = Figure(figsize=(_WIDTH, 1.25 + _panel_height(view)), layout="constrained")
        figure.suptitle(f"{title}, displacements × {factor:g}", weight="bold")
        axes = figure.add_subplot()
        _triangles(axes, mesh, moved, 0.25)
        _interfaces(axes, mesh, moved)
        for edge in mesh.nodes[boundary_edges(mesh.triangles)[:, :2]]:
            axes.plot(*edge.T, color=INK, linewidth=0.7, linestyle=(0, (3, 2)), zorder=4)
        _frame(axes, view)
        _legend(figure, mesh)
    return figure


def vectors_figure(title: str, mesh: Mesh, points: Sequence[str], vectors: Mapping[str, FloatArray]) -> Figure:
    """Draw displacement vectors at named points over the outline of the body, all to one scale.

    Parameters
    ----------
    vectors
        By their name in the legend (measured first), (k, 2) for the k points, in m.
    """
    from matplotlib.figure import Figure

    places = mesh.nodes[[mesh.points[name] for name in points]]
    longest = max(float(np.linalg.norm(v, axis=1).max()) for v in vectors.values())
    low, high, bottom, top = _limits(mesh.nodes)
    length = _LONGEST_ARROW * (high - low) / max(longest, 1e-300)
    margin = 0.05 * (high - low)
    view = (low, high + margin, bottom, top + margin)
    with drawing():
        figure = Figure(figsize=(_WIDTH, 3.0 + _panel_height(view)), layout="constrained")
        figure.suptitle(title, weight="bold")
        upper, lower = figure.subplots(2, 1, height_ratios=[_panel_height(view) + 0.3, 1.9])
        _outline(upper, mesh)
        looks = ((INK, 0.0060), (BLUE, 0.0042), (ORANGE, 0.0042), (GREEN, 0.0042))
        for (name, vector), (colour, width) in zip(vectors.items(), looks, strict=False):
            upper.quiver(
                *places.T, *(length * vector).T, angles="xy", scale_units="xy", scale=1.0, width=width, color=colour,
                label=name, zorder=5, headwidth=3.2, headlength=4.0, headaxislength=3.6,
            )  # fmt: skip
        for name, (x, y) in zip(points, places.tolist(), strict=True):
            upper.annotate(name, (x, y), (0, 6), textcoords="offset points", ha="center", fontsize=8)
        key = _round_down(longest)
        upper.plot([low, low + length * key], [bottom, bottom], color=INK, linewidth=1.6, solid_capstyle="butt")
        upper.annotate(f"{key:g} m", (low, bottom), (0, 4), textcoords="offset points", fontsize=8)
        _frame(upper, view)
        upper.legend(frameon=False, loc="upper right")
        _bars(lower, points, vectors, [colour for colour, _ in looks])
    return figure


def vectors_rows(points: Sequence[str], vectors: Mapping[str, FloatArray]) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: one row a point."""
    header = ["point", *(f"{name} {component}" for name in vectors for component in ("ux", "uy")), "unit"]
    rows: list[list[object]] = []
    for number, point in enumerate(points):
        values = [float(value) for vector in vectors.values() for value in vector[number]]
        rows.append([point, *values, "m"])
    return header, rows


def _bars(axes: Axes, points: Sequence[str], vectors: Mapping[str, FloatArray], colours: Sequence[str]) -> None:
    """Lengths of the vectors side by side: arrows show directions well, lengths less so."""
    wide = 0.8 / len(vectors)
    for number, ((name, vector), colour) in enumerate(zip(vectors.items(), colours, strict=False)):
        place = np.arange(len(points)) + (number - 0.5 * (len(vectors) - 1)) * wide
        axes.bar(place, np.linalg.norm(vector, axis=1), 0.9 * wide, color=colour, label=name)
    axes.set_xticks(np.arange(len(points)), points)
    axes.set_ylabel("length [m]")
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(visible=True, axis="y", color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)


def _limits(nodes: FloatArray) -> tuple[float, float, float, float]:
    (low, bottom), (high, top) = nodes.min(axis=0).tolist(), nodes.max(axis=0).tolist()
    return low, high, bottom, top


def _panel_height(view: tuple[float, float, float, float]) -> float:
    low, high, bottom, top = view
    return float(np.clip((_WIDTH - 0.9) * (top - bottom) / (high - low), 1.0, 7.0))


def _triangles(axes: Axes, mesh: Mesh, nodes: FloatArray, width: float) -> None:
    from matplotlib.collections import PolyCollection

    colours = [_TINTS[number % len(_TINTS)] for number in mesh.regions.tolist()]
    outlines = nodes[mesh.triangles[:, _CORNERS]]
    axes.add_collection(PolyCollection(list(outlines), facecolors=colours, edgecolors=MUTED, linewidths=width))


def _outline(axes: Axes, mesh: Mesh) -> None:
    from matplotlib.collections import LineCollection, PolyCollection

    colours = [_TINTS[number % len(_TINTS)] for number in mesh.regions.tolist()]
    outlines = mesh.nodes[mesh.triangles[:, _CORNERS]]
    axes.add_collection(PolyCollection(list(outlines), facecolors=colours, edgecolors=colours, linewidths=0.3))
    edges = mesh.nodes[boundary_edges(mesh.triangles)[:, :2]]
    axes.add_collection(LineCollection(list(edges), colors=MUTED, linewidths=0.6))


def _interfaces(axes: Axes, mesh: Mesh, nodes: FloatArray) -> None:
    for start, end, mid in (*mesh.interfaces[:, :3].tolist(), *mesh.interfaces[:, 3:].tolist()):
        axes.plot(*nodes[[start, mid, end]].T, color=ORANGE, linewidth=1.4, zorder=3)


def _points(axes: Axes, mesh: Mesh, view: tuple[float, float, float, float]) -> None:
    low, high, bottom, top = view
    for name, node in mesh.points.items():
        x, y = mesh.nodes[node].tolist()
        if low <= x <= high and bottom <= y <= top:
            axes.plot([x], [y], marker="o", markersize=3.6, color=INK, zorder=5)
            axes.annotate(name, (x, y), (0, 5), textcoords="offset points", ha="center", fontsize=8)


def _frame(axes: Axes, view: tuple[float, float, float, float]) -> None:
    low, high, bottom, top = view
    margin = 0.02 * (high - low)
    axes.set_xlim(low - margin, high + margin)
    axes.set_ylim(bottom - margin, top + 2.0 * margin)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.spines[["top", "right"]].set_visible(False)


def _legend(figure: Figure, mesh: Mesh) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    counts: IntArray = np.bincount(mesh.regions, minlength=len(mesh.region_names))
    entries: list[Patch | Line2D] = [
        Patch(facecolor=_TINTS[number % len(_TINTS)], edgecolor=MUTED, label=f"{name} ({counts[number]})")
        for number, name in enumerate(mesh.region_names)
    ]
    if mesh.interface_names:
        entries.append(Line2D([], [], color=ORANGE, label=f"interfaces ({len(mesh.interfaces)})"))
    figure.legend(handles=entries, loc="outside lower center", ncols=4, frameon=False)


def _round_down(value: float) -> float:
    power = 10.0 ** np.floor(np.log10(max(value, 1e-300)))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= value * (1.0 + 1e-9)))


def _round_factor(nodes: FloatArray, displacement: FloatArray) -> float:
    """About a fortieth of the body's width for the largest displacement, and never less than 1."""
    largest = float(np.linalg.norm(displacement, axis=1).max())
    return max(1.0, _round_down(0.025 * float(np.ptp(nodes[:, 0])) / max(largest, 1e-12)))
