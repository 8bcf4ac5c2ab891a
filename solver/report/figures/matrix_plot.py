"""The matrix plot of a statistical analysis (Meier et al. 2008, figures 2, 4 and 6).

Diagonal: the objective over one parameter, its projection, with the lower envelope. Below it: scatter plots of two
parameters, good fits coloured by their objective. Above it: their correlations among the good fits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.identifiability import Correlation, Correlations, Filtered, Projection, Samples
from geoswarm.solver.report.figures.extent import drawable, set_limits
from geoswarm.solver.report.figures.labels import ParameterLabel
from geoswarm.solver.report.figures.style import (
    GRID,
    INK,
    MUTED,
    ORANGE,
    SKY,
    colour_map,
    drawing,
    plain_ticks,
    shortened,
    with_unit,
)
from geoswarm.solver.words import typeset

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

__all__ = ["MOST_POINTS", "MatrixData", "matrix_figure", "matrix_rows"]

MOST_POINTS = 20_000
"""Largest number of points in a panel; all good fits come first."""

_LEFT, _RIGHT, _TOP, _BOTTOM, _GAP = 0.72, 0.5, 0.62, 1.22, 0.1  # inch


@dataclass(frozen=True, slots=True)
class MatrixData:
    """What a matrix plot shows.

    Parameters
    ----------
    samples, filtered, projections
        All samples, the good fits among them, and the objective over each parameter.
    correlations, ranks
        Pearson's, and where known Spearman's correlations of the good fits.
    labels
        Of the parameters, by name.
    unit
        Of the objective.
    """

    samples: Samples
    filtered: Filtered
    projections: tuple[Projection, ...]
    correlations: Correlations
    ranks: Correlations | None
    labels: Mapping[str, ParameterLabel]
    unit: str


def matrix_figure(title: str, data: MatrixData) -> Figure:
    """Draw the matrix plot.

    Points are drawn as an image inside the vector graphic; of more than :data:`MOST_POINTS` samples only
    that number is drawn, and the figure says so. Axes run over the search range, on a log scale where the search did.
    """
    from matplotlib.figure import Figure

    samples, size = data.samples, data.samples.dimension
    cell = {1: 3.2, 2: 2.2, 3: 1.62}.get(size, 1.28)
    width = max(_LEFT + _RIGHT + size * cell + (size - 1) * _GAP, 4.6)
    height = _TOP + _BOTTOM + size * cell + (size - 1) * _GAP
    shown, colours = _points(data)
    with drawing():
        figure = Figure(figsize=(width, height))
        figure.text(
            _LEFT / width, 1 - 0.22 / height, shortened(figure, title), fontsize="large", va="center", weight="bold"
        )
        figure.text(_LEFT / width, 1 - 0.44 / height, _statement(data, len(shown)), fontsize="small", va="center")
        norm = _norm(data)
        panels: dict[tuple[int, int], Axes] = {}
        for row in range(size):
            for column in range(size):
                left = (_LEFT + column * (cell + _GAP)) / width
                bottom = (_BOTTOM + (size - 1 - row) * (cell + _GAP)) / height
                axes = figure.add_axes((left, bottom, cell / width, cell / height))
                panels[row, column] = axes
                if row == column:
                    _projection(axes, data, row, shown, colours, norm)
                elif row > column:
                    _scatter(axes, data, row, column, shown, colours, norm)
                else:
                    _correlation(axes, data, samples.names[row], samples.names[column])
        for (row, column), axes in panels.items():
            _edge_labels(axes, data, row, column)
        _colour_bar(figure, data, norm, width, height)
    return figure


def matrix_rows(data: MatrixData) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: one row a pair of parameters."""
    header = ["first", "second", "pearson", "pearson_lower", "pearson_upper", "spearman", "samples", "threshold"]
    rows: list[list[object]] = []
    for pair in data.correlations:
        rank = None if data.ranks is None else data.ranks.get(pair.first, pair.second).coefficient
        threshold = data.filtered.threshold.value
        rows.append(
            [pair.first, pair.second, pair.coefficient, pair.lower, pair.upper, rank, pair.count, threshold],
        )
    return header, rows


def _statement(data: MatrixData, drawn: int) -> str:
    # two short lines at most: the figure must stay readable on a phone
    text = f"good fits: {typeset(data.filtered.statement)}"
    if drawn < data.samples.size:
        text += f"; {drawn} points drawn"
    return text


def _points(data: MatrixData) -> tuple[IntArray, BoolArray]:
    """Indices of the points to draw, worst first so that the best lie on top, and which of them are good fits."""
    objectives = data.samples.objectives
    order = np.argsort(-objectives, kind="stable")
    good = objectives <= data.filtered.threshold.value
    if len(order) > MOST_POINTS:
        room = max(MOST_POINTS - int(good.sum()), 0)
        others = np.random.default_rng(0).permutation(np.flatnonzero(~good))[:room]
        chosen = np.zeros(len(order), dtype=np.bool_)
        chosen[others] = True
        chosen[np.flatnonzero(good)[np.argsort(objectives[good], kind="stable")[:MOST_POINTS]]] = True
        order = order[chosen[order]]
    return order, good[order]


def _norm(data: MatrixData) -> Normalize:
    from matplotlib.colors import LogNorm, Normalize

    top = data.filtered.threshold.value
    found = data.filtered.samples.objectives
    low = float(found.min()) if found.size else top / 10.0
    if low > 0.0 and top / 3.0 > low:
        return LogNorm(*drawable(low, top, log=True))
    return Normalize(*drawable(min(low, 0.999 * top), top))


def _draw(axes: Axes, x: FloatArray, y: FloatArray, objectives: FloatArray, good: BoolArray, norm: Normalize) -> None:
    """Faint other samples below, good fits on top, both as images."""
    few = x.size < 5000
    faint: Any = {"color": "#8f979e", "alpha": 0.28, "markeredgewidth": 0, "markersize": 1.6 if few else 1.0}
    axes.plot(x[~good], y[~good], linestyle="none", marker="o", rasterized=True, zorder=1.5, **faint)
    count = int(good.sum())
    size = 9.0 if count < 300 else 5.0 if count < 3000 else 2.5
    colours = colour_map()(norm(objectives[good]))
    axes.scatter(x[good], y[good], s=size, c=colours, linewidths=0, rasterized=True, zorder=2)


def _projection(axes: Axes, data: MatrixData, index: int, shown: IntArray, good: BoolArray, norm: Normalize) -> None:
    samples, projection = data.samples, data.projections[index]
    x, f = samples.parameters[shown, index], samples.objectives[shown]
    threshold = data.filtered.threshold.value
    log = bool((samples.objectives > 0.0).all())
    lowest = float(samples.objectives.min())
    top = threshold * (30.0 if log else 3.0)
    visible = f <= top
    _draw(axes, x[visible], f[visible], f[visible], good[visible], norm)
    edges, envelope = projection.edges, projection.envelope
    axes.stairs(envelope, edges, baseline=None, color=ORANGE, linewidth=1.3, zorder=4)
    axes.axhline(threshold, color=MUTED, linestyle="--", linewidth=0.8, zorder=3)
    _limits(axes, samples, index, "x")
    set_limits(axes, "y", lowest * 0.7 if log else min(0.0, lowest), top, log=log)
    axes.yaxis.tick_right()
    plain_ticks(axes, "y", log=log, most=4)
    axes.tick_params(axis="y", labelsize=6.5, pad=1.5, length=2)


def _scatter(
    axes: Axes, data: MatrixData, row: int, column: int, shown: IntArray, good: BoolArray, norm: Normalize
) -> None:
    samples = data.samples
    points = samples.parameters[shown]
    _draw(axes, points[:, column], points[:, row], samples.objectives[shown], good, norm)
    best = [data.projections[index].best for index in (column, row)]
    axes.plot(*best, marker="+", color=ORANGE, markersize=9, markeredgewidth=1.6, zorder=5)
    _limits(axes, samples, column, "x")
    _limits(axes, samples, row, "y")


def _correlation(axes: Axes, data: MatrixData, first: str, second: str) -> None:
    pair = data.correlations.get(first, second)
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_color(GRID)
    strength = 0.0 if pair.coefficient is None else abs(pair.coefficient)
    axes.set_facecolor((*_rgb(SKY), 0.42 * strength**2))
    axes.patch.set_visible(True)
    lines = _words(pair, data)
    axes.text(
        0.56,
        0.66,
        lines[0],
        ha="center",
        va="center",
        fontsize=11.5,
        weight="bold" if pair.correlated else "normal",
        transform=axes.transAxes,
    )
    for place, line in zip((0.42, 0.26, 0.1), lines[1:], strict=False):
        axes.text(0.56, place, line, ha="center", va="center", fontsize=7.0, color=INK, transform=axes.transAxes)


def _words(pair: Correlation, data: MatrixData) -> list[str]:
    if pair.coefficient is None:
        return ["r = ?", f"n = {pair.count}"]
    lines = [f"r = {pair.coefficient:.2f}"]
    if pair.lower is not None and pair.upper is not None:
        lines.append(f"{pair.lower:.2f} … {pair.upper:.2f}")
    rank = None if data.ranks is None else data.ranks.get(pair.first, pair.second).coefficient
    if rank is not None:
        lines.append(f"ρ = {rank:.2f}")
    return [line.replace("-", "\N{MINUS SIGN}") for line in [*lines, f"n = {pair.count}"]]


def _rgb(colour: str) -> tuple[float, float, float]:
    from matplotlib.colors import to_rgb

    return to_rgb(colour)


def _limits(axes: Axes, samples: Samples, index: int, which: str) -> None:
    lower, upper, log = float(samples.lower[index]), float(samples.upper[index]), samples.scales[index] == "log"
    set_limits(axes, which, lower, upper, log=log, margin=0.02)
    plain_ticks(axes, which, log=log, most=4, inset=True)


def _edge_labels(axes: Axes, data: MatrixData, row: int, column: int) -> None:
    """Ticks with numbers only at the left and lower edge; the objective's at each diagonal panel."""
    if row < column:
        return
    names, size = data.samples.names, data.samples.dimension
    if row == size - 1:
        axes.set_xlabel(data.labels[names[column]].axis)
    else:
        axes.tick_params(axis="x", labelbottom=False)
    if column == 0 and row > 0:
        axes.set_ylabel(data.labels[names[row]].axis)
    elif row != column:
        axes.tick_params(axis="y", labelleft=False)
    if row == column == 0:
        axes.set_ylabel(with_unit("f", data.unit))
        axes.yaxis.set_label_position("left")


def _colour_bar(figure: Figure, data: MatrixData, norm: Normalize, width: float, height: float) -> None:
    from matplotlib.cm import ScalarMappable

    axes = figure.add_axes((_LEFT / width, 0.5 / height, min(2.4, width - _LEFT - 1.7) / width, 0.09 / height))
    bar = figure.colorbar(ScalarMappable(norm, colour_map()), cax=axes, orientation="horizontal")
    bar.outline.set_visible(False)
    axes.set_xlabel(with_unit("objective f of good fits", data.unit), fontsize=8)
    plain_ticks(axes, "x", log=type(norm).__name__ == "LogNorm", most=4)
    axes.tick_params(labelsize=7)
    left = (_LEFT + min(2.4, width - _LEFT - 1.7) + 0.25) / width
    keys = (("—", ORANGE, "lower envelope"), ("- -", MUTED, "threshold"), ("+", ORANGE, "best"))
    for number, (sign, colour, text) in enumerate(keys):
        y = (0.57 - 0.16 * number) / height
        figure.text(left, y, sign, color=colour, fontsize=8, va="center", weight="bold")
        figure.text(left + 0.24 / width, y, text, fontsize=7.5, va="center")
