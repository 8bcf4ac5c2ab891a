"""What is known of each parameter, between the bounds it was searched in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from geoswarm.solver.report.figures.extent import set_limits
from geoswarm.solver.report.figures.labels import ParameterLabel
from geoswarm.solver.report.figures.style import BLUE, GRID, INK, ORANGE, drawing, head, plain_ticks
from geoswarm.solver.words import per_cent

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

__all__ = ["IntervalRow", "interval_rows", "intervals_figure"]


@dataclass(frozen=True, slots=True)
class IntervalRow:
    """What is known of one parameter, natural values.

    Parameters
    ----------
    label
        Name, symbol, unit.
    lower, upper, log
        Search range and whether it was searched on a log scale.
    value
        At the minimum, or of the best evaluation.
    at_minimum
        Which of the two.
    good_fits
        5 % to 95 % of the good fits; None where there are too few, or only a swarm's.
    confidence, level
        Confidence interval at the optimum and its level; None where there is none, for a parameter that is not
        identifiable above all.
    remark
        Shown beside the parameter: the verdict.
    """

    label: ParameterLabel
    lower: float
    upper: float
    log: bool
    value: float
    at_minimum: bool
    good_fits: tuple[float, float] | None
    confidence: tuple[float, float] | None
    level: float
    remark: str


def intervals_figure(title: str, rows: Sequence[IntervalRow]) -> Figure:
    """Draw one band a parameter: search range, good fits, confidence interval, value."""
    from matplotlib.figure import Figure

    with drawing():
        figure = Figure(figsize=(4.6, 0.95 + 0.86 * len(rows)), layout="constrained")
        head(figure, title)
        for index, row in enumerate(rows):
            axes = figure.add_subplot(len(rows), 1, index + 1)
            axes.set_ylim(-1.0, 1.0)
            set_limits(axes, "x", row.lower, row.upper, log=row.log, margin=0.03)
            axes.barh(0.0, row.upper - row.lower, left=row.lower, height=0.5, color=GRID, label="search range")
            if row.good_fits is not None:
                low, high = row.good_fits
                axes.barh(0.0, high - low, left=low, height=0.9, color=BLUE, alpha=0.55, label="5–95 % of good fits")
            if row.confidence is not None:
                low, high = row.confidence
                axes.plot(
                    [low, high],
                    [0.0, 0.0],
                    color=ORANGE,
                    marker="|",
                    markersize=10,
                    linewidth=2.0,
                    label=f"{per_cent(row.level)} interval at the optimum",
                )
            axes.plot(
                row.value,
                0.0,
                marker="D",
                markersize=3.0,
                color=INK,
                linestyle="none",
                label="minimum" if row.at_minimum else "best evaluation",
            )
            plain_ticks(axes, "x", log=row.log, most=5)
            axes.set_yticks([])
            axes.spines[["left", "right", "top"]].set_visible(False)
            axes.set_title(f"{row.label.axis}   {row.remark}", loc="left", fontsize=8.5, pad=2)
            axes.tick_params(labelsize=7.5, pad=1.5)
        handles: dict[str, Artist] = {}
        for axes in figure.axes:
            for handle, text in zip(*axes.get_legend_handles_labels(), strict=True):
                handles.setdefault(text, handle)
        figure.legend(
            list(handles.values()),
            list(handles),
            loc="outside lower center",
            ncols=2,
            frameon=False,
        )
    return figure


def interval_rows(rows: Sequence[IntervalRow]) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: one row a parameter."""
    header = ["parameter", "unit", "lower", "upper", "scale", "value"]
    header += ["good_fits_05", "good_fits_95", "interval_lower", "interval_upper", "level", "verdict"]
    table: list[list[object]] = []
    for r in rows:
        good, sure = r.good_fits or (None, None), r.confidence or (None, None)
        scale = "log" if r.log else "linear"
        table.append([r.label.name, r.label.unit, r.lower, r.upper, scale, r.value, *good, *sure, r.level, r.remark])
    return header, table
