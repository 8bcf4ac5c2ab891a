"""Ticks of the axes of a sketch, and where values lie along them."""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["Scale", "ground_length", "linear_scale", "log_scale", "number", "short", "specimen_length"]

_MOST = 5


@dataclass(frozen=True, slots=True)
class Scale:
    """An axis from ``low`` to ``high``, with its ticks; logarithmic or not."""

    low: float
    high: float
    ticks: tuple[float, ...]
    log: bool = False

    def part(self, value: float) -> float:
        """Where a value lies, 0 to 1 along the axis; on a logarithmic one, what is not positive lies at 0."""
        if not self.log:
            return (value - self.low) / (self.high - self.low)
        if value <= self.low:
            return 0.0
        return math.log(value / self.low) / math.log(self.high / self.low)


def linear_scale(low: float, high: float) -> Scale:
    """An axis that holds two values, with round numbers."""
    if not high > low:
        spread = abs(low) or 1.0
        low, high = low - 0.5 * spread, high + 0.5 * spread
    step = (high - low) / _MOST
    power = 10.0 ** math.floor(math.log10(step))
    step = next(one * power for one in (1.0, 2.0, 2.5, 5.0, 10.0) if one * power >= step * (1.0 - 1e-9))
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    ticks = tuple(number * step for number in range(first, last + 1))
    return Scale(ticks[0], ticks[-1], ticks)


def log_scale(low: float, high: float) -> Scale:
    """A logarithmic axis that holds two positive values: powers of ten, and 2 and 5 where there are few of them."""
    high = max(high, 2.0 * low)
    decades = math.log10(high / low)
    parts = (1.0, 2.0, 5.0) if decades <= 2.0 else (1.0, 3.0) if decades <= 2.6 else (1.0,)
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    every = 1 if decades <= 6.0 else math.ceil(decades / 6.0)
    powers = [10.0**power for power in range(first, last + 1) if power % every == 0]
    ticks = tuple(
        part * power
        for power in powers
        for part in parts
        if low <= part * power * 1.000001 and part * power <= high * 1.000001
    )
    return Scale(low, high, ticks, log=True)


def short(value: float) -> str:
    """A number as short as it is understood: ``0.05``, ``5000``, ``2e4``."""
    if value == 0.0:
        return "0"
    text = f"{value:.4g}"
    return text.replace("e+0", "e").replace("e+", "e").replace("e-0", "e-").replace("-", "\N{MINUS SIGN}")


def number(value: float) -> str:
    """A number that is given, with up to 8 figures.

    >>> number(10957.5)
    '10957.5'
    """
    return f"{value:.8g}".replace("-", "\N{MINUS SIGN}")


def specimen_length(metres: float) -> str:
    """A length of a specimen, which is given in mm below 1 m.

    >>> specimen_length(0.02021)
    '20.21 mm'
    """
    return f"{metres:g} m" if metres >= 1.0 else f"{_rounded(1e3 * metres)} mm"


def ground_length(metres: float) -> str:
    """A depth, distance or thickness in the ground, which is given in cm below 0.1 m.

    >>> ground_length(1.5)
    '1.5 m'
    """
    return f"{metres:g} m" if metres == 0.0 or metres >= 0.1 else f"{_rounded(1e2 * metres)} cm"


def _rounded(value: float) -> str:
    return f"{float(f'{value:.12g}'):g}"  # 1000 times 0.07 is 70.00000000000001
