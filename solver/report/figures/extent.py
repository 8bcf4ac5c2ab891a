"""Limits of axes that can be drawn, whatever numbers they come from: finite, and different from each other."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["drawable", "set_limits"]

_SMALLEST, _LARGEST = 1e-280, 1e290  # beyond them matplotlib takes other limits, or has no room for its margins
_CLOSE = 1.0 + 1e-9
_NARROW, _WIDER = 1e-12, 0.05


def set_limits(axes: Axes, which: str, low: float, high: float, *, log: bool = False, margin: float = 0.0) -> None:
    """Let the ``x`` or ``y`` axis run from ``low`` to ``high``, as far as that can be drawn.

    Parameters
    ----------
    log
        Whether the axis is logarithmic.
    margin
        Free space at both ends, as a part of the length of the axis.
    """
    limits = drawable(low, high, log=log)
    if log:
        space = margin * (math.log(limits[1]) - math.log(limits[0]))
        limits = drawable(limits[0] * math.exp(-space), limits[1] * math.exp(space), log=True)
    else:
        space = margin * (limits[1] - limits[0])
        limits = drawable(limits[0] - space, limits[1] + space, log=False)
    (axes.set_xlim if which == "x" else axes.set_ylim)(*limits)


def drawable(low: float, high: float, *, log: bool = False) -> tuple[float, float]:
    """Return two finite numbers, the second larger, that are as near to ``low`` and ``high`` as can be drawn."""
    if log:
        low, high = (min(max(_finite(value), _SMALLEST), _LARGEST) for value in (low, high))
        return (low, high) if high > low * _CLOSE else (low / 2.0, low * 2.0)
    low, high = (min(max(_finite(value), -_LARGEST), _LARGEST) for value in (low, high))
    size = max(abs(low), abs(high))
    if size < _SMALLEST:  # all of it is 0 for a figure
        return -1.0, 1.0
    return (low, high) if high - low > _NARROW * size else (low - _WIDER * size, low + _WIDER * size)


def _finite(value: float) -> float:
    return 0.0 if math.isnan(value) else value
