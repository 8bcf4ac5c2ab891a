"""Figures of what follow-ups and a posterior sample have found: profiles, distributions, indices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.identifiability.optimum.profiles import Profile
from geoswarm.solver.identifiability.stored.global_sensitivity import GlobalSensitivity
from geoswarm.solver.identifiability.stored.posterior import Posterior
from geoswarm.solver.report.figures.extent import set_limits
from geoswarm.solver.report.figures.labels import ParameterLabel
from geoswarm.solver.report.figures.style import (
    BLUE,
    GRID,
    INK,
    MUTED,
    ORANGE,
    SKY,
    drawing,
    finish,
    head,
    plain_ticks,
    with_unit,
)
from geoswarm.solver.words import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "index_rows",
    "indices_figure",
    "posterior_figure",
    "posterior_rows",
    "profile_rows",
    "profiles_figure",
]

Labels = Mapping[str, ParameterLabel]
_BINS = 40
_COLUMNS = 3
_WIDE = 5.0


def profiles_figure(
    title: str, profiles: Sequence[Profile], labels: Labels, logs: Mapping[str, bool], unit: str
) -> Figure:
    """Draw the profile objective of each parameter, the limit, and the interval.

    Parameters
    ----------
    logs
        Whether a parameter is searched on a log scale, by name.
    unit
        Of the objective.
    """
    with drawing():
        figure, panels = _panels(title, len(profiles), 2.15)
        for axes, profile in zip(panels, profiles, strict=True):
            values, objectives = profile.values, profile.objectives
            lowest = float(objectives.min())
            top = max(profile.limit + 0.6 * (profile.limit - lowest), lowest * (1.0 + 1e-9))
            ends = (
                float(values[0]) if profile.lower is None else profile.lower,
                float(values[-1]) if profile.upper is None else profile.upper,
            )
            axes.axvspan(*ends, color=SKY, alpha=0.25, linewidth=0, label="95 % interval")
            axes.plot(
                values, objectives, color=BLUE, marker="o", markersize=3.0, linewidth=1.4, label="profile objective"
            )
            axes.axhline(profile.limit, color=ORANGE, linestyle="--", linewidth=1.1, label="limit of the interval")
            plain_ticks(axes, "x", log=logs[profile.parameter] and _wide(values), most=3)
            set_limits(axes, "y", lowest - 0.08 * (top - lowest), top)
            plain_ticks(axes, "y", log=False, most=4)
            axes.set_xlabel(labels[profile.parameter].axis)
            axes.set_ylabel(with_unit("objective f", unit))
            finish(axes, legend=False)
            axes.set_title(_interval_words(profile), fontsize=8.0)
        handles, words = panels[0].get_legend_handles_labels()
        figure.legend(handles, words, loc="outside lower center", ncols=3, frameon=False)
    return figure


def _panels(title: str, count: int, height: float) -> tuple[Figure, list[Axes]]:
    """A figure of panels side by side, three in a row at most."""
    from matplotlib.figure import Figure

    columns = min(count, _COLUMNS)
    rows = -(-count // columns)
    figure = Figure(figsize=(max(2.5 * columns, 4.6), 0.75 + height * rows), layout="constrained")
    head(figure, title)
    return figure, [figure.add_subplot(rows, columns, index + 1) for index in range(count)]


def _wide(values: FloatArray) -> bool:
    """Whether a logarithmic axis says more than a linear one."""
    return bool(values.max() > _WIDE * values.min())


def _interval_words(profile: Profile) -> str:
    if not profile.complete:
        return "not complete yet"
    if profile.interval is not None:
        return f"{number(profile.lower)} … {number(profile.upper)}"
    sides = [name for name, end in (("below", profile.lower), ("above", profile.upper)) if end is None]
    return f"open {' and '.join(sides)}"


def profile_rows(profiles: Sequence[Profile]) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: one row a point of a profile."""
    header = ["parameter", "value", "objective", "limit", "lower", "upper"]
    rows: list[list[object]] = [
        [p.parameter, float(value), float(objective), p.limit, p.lower, p.upper]
        for p in profiles
        for value, objective in zip(p.values, p.objectives, strict=True)
    ]
    return header, rows


def posterior_figure(title: str, posterior: Posterior, labels: Labels, logs: Mapping[str, bool]) -> Figure:
    """Draw the distribution of each parameter in the posterior sample, and its credible interval."""
    with drawing():
        figure, panels = _panels(title, len(posterior.names), 1.9)
        for index, (axes, name) in enumerate(zip(panels, posterior.names, strict=True)):
            density, edges = _density(posterior, index, logs[name])
            axes.stairs(density, edges, fill=True, color=BLUE, alpha=0.55, linewidth=0)
            low, high = posterior.intervals[index]
            if np.isfinite(low + high):
                axes.axvspan(low, high, color=GRID, alpha=0.7, linewidth=0, zorder=0)
            else:
                axes.text(
                    0.99, 0.95, "no interval: not limited by the data alone", ha="right", va="top", fontsize=7.5,
                    color=MUTED, transform=axes.transAxes,
                )  # fmt: skip
            axes.axvline(float(np.median(posterior.parameters[:, index])), color=ORANGE, linewidth=1.2)
            plain_ticks(axes, "x", log=logs[name] and _wide(posterior.parameters[:, index]), most=3)
            plain_ticks(axes, "y", log=False, most=3)
            set_limits(axes, "y", 0.0, 1.15 * float(density.max()))
            axes.set_xlabel(labels[name].axis)
            axes.set_ylabel("share of sample [-]")
            finish(axes, legend=False)
    return figure


def _density(posterior: Posterior, index: int, log: bool) -> tuple[Any, Any]:
    values = posterior.parameters[:, index]
    edges = (
        np.geomspace(values.min(), values.max(), _BINS + 1)
        if log
        else np.linspace(values.min(), values.max(), _BINS + 1)
    )
    counts, _ = np.histogram(values, edges)
    return counts / values.size, edges


def posterior_rows(posterior: Posterior, logs: Mapping[str, bool]) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: one row a bar."""
    rows: list[list[object]] = []
    for index, name in enumerate(posterior.names):
        density, edges = _density(posterior, index, logs[name])
        rows += [[name, *bar] for bar in zip(edges[:-1].tolist(), edges[1:].tolist(), density.tolist(), strict=True)]
    return ["parameter", "from", "to", "share"], rows


def indices_figure(title: str, found: Sequence[GlobalSensitivity], labels: Labels, units: Mapping[str, str]) -> Figure:
    """Draw the indices of each output as bars, with whiskers.

    Parameters
    ----------
    units
        Of each series, base units.
    """
    from matplotlib.figure import Figure

    columns = min(len(found), 2)
    rows = -(-len(found) // columns)
    height = 0.9 + 0.36 * len(found[0].indices)
    with drawing():
        figure = Figure(figsize=(4.6 if columns == 1 else 7.4, 0.5 + height * rows), layout="constrained")
        head(figure, title)
        for index, one in enumerate(found):
            axes = figure.add_subplot(rows, columns, index + 1)
            place = np.arange(len(one.indices))[::-1]
            sobol = one.kind == "sobol"
            names = ("first order", "total") if sobol else ("mean absolute effect", "spread of the effect")
            pairs = (
                (0.19, BLUE, names[0], [i.main for i in one.indices], [i.main_half_width for i in one.indices]),
                (-0.19, ORANGE, names[1], [i.total for i in one.indices], [i.total_half_width for i in one.indices]),
            )
            for offset, colour, name, values, half in pairs:
                axes.barh(place + offset, values, height=0.34, color=colour, alpha=0.8, label=name)
                if np.isfinite(half).all():
                    axes.errorbar(
                        values, place + offset, xerr=half, fmt="none", ecolor=INK, elinewidth=0.9, capsize=2.0, zorder=3
                    )
            axes.set_yticks(place, [labels[i.parameter].symbol for i in one.indices])
            low = min(
                0.0,
                *(v - (h if np.isfinite(h) else 0.0) for _, _, _, vs, hs in pairs for v, h in zip(vs, hs, strict=True)),
            )
            axes.set_xlim(left=1.05 * low)
            plain_ticks(axes, "x", log=False, most=5)
            output = "log₁₀ objective" if one.output == "objective" else one.output
            axes.set_title(f"{output} ({'Sobol' if sobol else 'Morris'})", loc="left", fontsize=8.5)
            unit = "-" if one.output == "objective" else units.get(one.output) or "-"
            axes.set_xlabel("index [-]" if sobol else f"change of {output} over the range [{unit}]")
            finish(axes, legend=False)
            if one.kind not in {other.kind for other in found[:index]}:
                axes.legend(frameon=False, fontsize=7.5, loc="best")
    return figure


def index_rows(found: Sequence[GlobalSensitivity]) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: one row a parameter and output."""
    header = [
        "kind",
        "output",
        "parameter",
        "main",
        "main_half_width",
        "total",
        "total_half_width",
        "blocks",
        "dropped",
    ]
    rows: list[list[object]] = []
    for one in found:
        for i in one.indices:
            half = i.total_half_width if np.isfinite(i.total_half_width) else None
            rows.append(
                [one.kind, one.output, i.parameter, i.main, i.main_half_width, i.total, half, one.blocks, one.dropped]
            )
    return header, rows
