"""Figure of a compression curve: void ratio, or strain downwards, over the logarithm of stress."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.report.compression import CompressionCurve
from geoswarm.solver.report.figures.extent import set_limits
from geoswarm.solver.report.figures.style import (
    BLUE,
    ORANGE,
    PAPER,
    drawing,
    finish,
    head,
    plain_ticks,
    plot_gross_errors,
    plot_measured,
    with_unit,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["compression_figure", "compression_rows"]

_BEYOND = 1.01


def compression_figure(title: str, curve: CompressionCurve) -> Figure:
    """Draw measured and calculated states at the ends of the stages, and the preconsolidation stress."""
    from matplotlib.figure import Figure

    with drawing():
        figure = Figure(figsize=(4.6, 3.8), layout="constrained")
        head(figure, title)
        axes = figure.add_subplot()
        axes.plot(curve.stress, curve.calculated, color=BLUE, linewidth=1.6, label="identified", zorder=3)
        if curve.measured.size:
            plot_measured(axes, curve.measured_stress, curve.measured)
        plot_gross_errors(axes, curve.gross_stress, curve.gross)
        past = curve.preconsolidation
        ends = curve.stress if past is None else np.append(curve.stress, past)
        set_limits(axes, "x", float(ends.min()) / 1.4, float(ends.max()) * 1.4, log=True)
        if past is not None and past > _BEYOND * curve.stress[0]:  # else normally consolidated from the start
            if curve.interval is not None:
                axes.axvspan(*curve.interval, color=ORANGE, alpha=0.18, linewidth=0.0, zorder=1)
            label = f"σ′p = {past:.3g} kPa"
            axes.axvline(past, color=ORANGE, linewidth=1.2, linestyle="--", label=label, zorder=2)
        plain_ticks(axes, "x", log=True, most=6)
        plain_ticks(axes, "y", log=False, most=7)
        if not curve.void_ratio:
            axes.invert_yaxis()
        across, up = curve.axes
        axes.set_xlabel(with_unit(*across))
        axes.set_ylabel(with_unit(*up))
        finish(axes)
        axes.legend(loc="lower left", facecolor=PAPER, framealpha=0.85, edgecolor="none")
    return figure


def compression_rows(curve: CompressionCurve) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: the initial state, then one row a stage."""
    quantity, unit = curve.axes[1]
    measured = dict(zip(curve.measured_stages.tolist(), curve.measured.tolist(), strict=True))
    struck = dict(zip(curve.gross_stages.tolist(), curve.gross.tolist(), strict=True))
    header = ["stage", "stress_kPa", "quantity", "unit", "measured", "calculated"]
    rows: list[list[object]] = [
        [stage, stress, quantity, unit, measured.get(stage), calculated]
        for stage, stress, calculated in zip(
            curve.stages.tolist(), curve.stress.tolist(), curve.calculated.tolist(), strict=True
        )
    ]
    if struck:
        header.append("gross error")
        rows = [[*row, struck.get(stage)] for stage, row in zip(curve.stages.tolist(), rows, strict=True)]
    return header, rows
