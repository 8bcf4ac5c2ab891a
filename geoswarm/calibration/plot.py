"""Draws measured and calculated series into given or new axes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from geoswarm.solver.report.curves import SeriesCurve
from geoswarm.solver.system.extras import has, needs_extra

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["plot_curves"]


def plot_curves(curves: list[SeriesCurve], axes: Axes | Iterable[Axes] | None) -> list[Axes]:
    """Draw each series, in the units of its observation; return the axes, one a series.

    Parameters
    ----------
    axes
        One for each series, or a single one for a single series; None for a new figure.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        There are not as many axes as series.
    """
    if not has("matplotlib"):
        raise ImportError(needs_extra("plot()", "matplotlib"))
    from matplotlib.axes import Axes

    if axes is None:
        from matplotlib import pyplot

        size = (6.0, 3.4 * len(curves))
        _, made = pyplot.subplots(len(curves), 1, squeeze=False, figsize=size, layout="constrained")
        found: list[Axes] = list(made.flat)
    elif isinstance(axes, Axes):
        found = [axes]
    else:
        found = list(getattr(axes, "flat", axes))
    if len(found) != len(curves):
        names = ", ".join(curve.series for curve in curves)
        raise ValueError(f"{len(found)} axes are given; accepted is one for each of the {len(curves)} series: {names}")
    for one, curve in zip(found, curves, strict=True):
        one.plot(curve.measured_x, curve.measured_y, "o", color="0.2", markersize=4, label="measured")
        one.plot(curve.x, curve.y, "-", color="C0", label="calculated")
        one.set_xlabel(_labelled(curve.x_quantity, curve.x_unit))
        one.set_ylabel(_labelled(curve.y_quantity, curve.y_unit))
        one.legend()
    return found


def _labelled(quantity: str, unit: str) -> str:
    return f"{quantity} [{unit}]" if unit and unit != "dimensionless" else quantity
