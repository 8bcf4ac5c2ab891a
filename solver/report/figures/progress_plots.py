"""How the search went: objective and parameters over the evaluations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.identifiability import Samples
from geoswarm.solver.progress.result import GenerationRecord
from geoswarm.solver.report.figures.extent import set_limits
from geoswarm.solver.report.figures.labels import ParameterLabel
from geoswarm.solver.report.figures.style import (
    BLUE,
    GRID,
    MUTED,
    ORANGE,
    drawing,
    finish,
    head,
    plain_ticks,
    with_unit,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["convergence_figure", "convergence_rows", "traces_figure"]

_LEAST = 1e-300


def convergence_figure(
    title: str, records: Sequence[GenerationRecord], unit: str, target: float | None = None
) -> Figure:
    """Draw the best objective so far, and the best of each generation, over the evaluations.

    Parameters
    ----------
    title
        Line above the axes.
    records
        Finished generations in order.
    unit
        Unit of the objective, for the axis.
    target
        Objective at which the search was to stop, or None.
    """
    from matplotlib.figure import Figure

    single = [(r.evaluations, r.best_objective) for r in records if r.best_objective is not None]
    so_far = [(r.evaluations, r.objective) for r in records if r.objective is not None]
    with drawing():
        figure = Figure(figsize=(4.6, 3.1), layout="constrained")
        head(figure, title)
        axes = figure.add_subplot()
        axes.plot(
            [x for x, _ in single],
            [y for _, y in single],
            linestyle="none",
            marker=".",
            markersize=4,
            color=MUTED,
            label="best of a generation",
            zorder=2,
        )
        axes.step(
            [x for x, _ in so_far],
            [y for _, y in so_far],
            where="post",
            color=BLUE,
            linewidth=1.7,
            label="best so far",
            zorder=3,
        )
        if target is not None:
            axes.axhline(target, color=ORANGE, linestyle="--", linewidth=1.1, label="target", zorder=1)
        positive = bool(single) and all(y > _LEAST for _, y in single + so_far)
        plain_ticks(axes, "y", log=positive, most=6)
        plain_ticks(axes, "x", log=False, most=8, whole=True)
        axes.set_xlabel("evaluations [-]")
        axes.set_ylabel(with_unit("objective f", unit))
        finish(axes)
        if not single:
            _empty(axes, "no evaluation has succeeded")
    return figure


def convergence_rows(records: Sequence[GenerationRecord]) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: one row a generation."""
    header = ["generation", "evaluations", "failed", "best_objective", "objective"]
    return header, [[r.number, r.evaluations, r.failed, r.best_objective, r.objective] for r in records]


def traces_figure(
    title: str, records: Sequence[GenerationRecord], samples: Samples, labels: Mapping[str, ParameterLabel]
) -> Figure:
    """Draw every free parameter over the generations: all evaluations as points, the best so far as a line.

    Parameters
    ----------
    title
        Line above the panels.
    records
        Finished generations in order.
    samples
        Successful evaluations with their generation.
    labels
        Of the parameters, by name.
    """
    from matplotlib.figure import Figure

    count = samples.dimension
    columns = 1 if count <= 6 else 2
    rows = -(-count // columns)
    with drawing():
        figure = Figure(figsize=(4.6 if columns == 1 else 7.4, 0.7 + 1.45 * rows), layout="constrained")
        head(figure, title)
        for index, name in enumerate(samples.names):
            axes = figure.add_subplot(rows, columns, index + 1)
            axes.plot(
                samples.generations,
                samples.parameters[:, index],
                linestyle="none",
                marker="o",
                markersize=2.4,
                markeredgewidth=0,
                color="#8f979e",
                alpha=0.55,
                rasterized=True,
            )
            best = [(r.number, r.parameters[name]) for r in records if r.parameters is not None]
            axes.step([n for n, _ in best], [v for _, v in best], where="post", color=BLUE, linewidth=1.6)
            lower, upper = float(samples.lower[index]), float(samples.upper[index])
            log = samples.scales[index] == "log"
            set_limits(axes, "y", lower, upper, log=log, margin=0.03)
            for bound in (lower, upper):
                axes.axhline(bound, color=GRID, linewidth=1.0, linestyle=":")
            plain_ticks(axes, "y", log=log, most=4)
            axes.set_ylabel(labels[name].axis)
            finish(axes, legend=False)
            plain_ticks(axes, "x", log=False, most=6, whole=True)
            if index >= count - columns:
                axes.set_xlabel("generation [-]")
            if not best:
                _empty(axes, "no evaluation has succeeded")
    return figure


def _empty(axes: Axes, text: str) -> None:
    axes.text(0.5, 0.5, text, ha="center", va="center", color=MUTED, transform=axes.transAxes)
    if not np.all(np.isfinite(axes.get_xlim())):
        axes.set_xlim(0.0, 1.0)
