"""Fit and convergence figures (matplotlib, without a display and without its global state)."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from solver.local import GenerationRecord
from solver.report.curves import SeriesCurve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["convergence_figure", "figures_available", "fit_figure", "save_figure"]

# Okabe and Ito: told apart with every common colour vision
_BLACK, _BLUE, _ORANGE, _GREY = "#000000", "#0072B2", "#D55E00", "#666666"


def figures_available() -> bool:
    """Tell whether matplotlib (the ``plots`` extra) is installed."""
    return importlib.util.find_spec("matplotlib") is not None


def fit_figure(title: str, curves: Sequence[SeriesCurve]) -> Figure:
    """Draw measured points and the calculated curve of every series, one panel a series.

    Parameters
    ----------
    title
        Line above the panels.
    curves
        Series in the user's units; compression is positive and drawn upwards, as in the data.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 1.0 + 3.4 * len(curves)), layout="constrained")
    figure.suptitle(title)
    for index, curve in enumerate(curves):
        axes = figure.add_subplot(len(curves), 1, index + 1)
        axes.plot(curve.x, curve.y, color=_BLUE, linewidth=1.4, label="calculated", zorder=2)
        axes.plot(
            curve.measured_x,
            curve.measured_y,
            linestyle="none",
            marker="o",
            markersize=3.5,
            markerfacecolor="none",
            markeredgecolor=_BLACK,
            markeredgewidth=0.8,
            label="measured",
            zorder=3,
        )
        axes.set_xlabel(_label(curve.x_quantity, curve.x_unit))
        axes.set_ylabel(_label(curve.y_quantity, curve.y_unit))
        axes.set_title(curve.series, fontsize="medium", loc="left")
        _finish(axes)
    return figure


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

    figure = Figure(figsize=(8.0, 4.4), layout="constrained")
    figure.suptitle(title)
    axes = figure.add_subplot()
    single = [(r.evaluations, r.best_objective) for r in records if r.best_objective is not None]
    axes.plot(
        [x for x, _ in single],
        [y for _, y in single],
        linestyle="none",
        marker=".",
        color=_GREY,
        label="best of a generation",
        zorder=2,
    )
    so_far = [(r.evaluations, r.objective) for r in records if r.objective is not None]
    axes.step(
        [x for x, _ in so_far],
        [y for _, y in so_far],
        where="post",
        color=_BLUE,
        linewidth=1.6,
        label="best so far",
        zorder=3,
    )
    if target is not None:
        axes.axhline(target, color=_ORANGE, linestyle="--", linewidth=1.0, label="target", zorder=1)
    if all(y > 0.0 for _, y in single + so_far) and single:
        axes.set_yscale("log")
    axes.set_xlabel("evaluations")
    axes.set_ylabel(_label("objective", unit))
    _finish(axes)
    return figure


def save_figure(figure: Figure, directory: Path, name: str) -> list[Path]:
    """Write ``<name>.png`` and ``<name>.svg``; the SVG of the same figure has the same bytes each time."""
    import matplotlib as mpl

    written = []
    with mpl.rc_context({"svg.hashsalt": "geoswarm", "svg.fonttype": "none"}):
        for suffix in ("png", "svg"):
            path = directory / f"{name}.{suffix}"
            figure.savefig(path, dpi=150, metadata={"Date": None} if suffix == "svg" else None)
            written.append(path)
    return written


def _label(quantity: str, unit: str) -> str:
    return f"{quantity} [{unit}]" if unit and unit != "dimensionless" else quantity


def _finish(axes: Axes) -> None:
    axes.grid(visible=True, color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize="small")
