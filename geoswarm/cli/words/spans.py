"""Spans of time on the command line: ``90d``, ``12h``, ``30m``, ``45s``."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import click

__all__ = ["SPAN"]

_SECONDS = {"s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0, "w": 604800.0}
_PATTERN = re.compile(r"(\d{1,9}(?:\.\d{1,9})?)([smhdw])")


if TYPE_CHECKING:
    _ParamType = click.ParamType[float]
else:
    _ParamType = click.ParamType  # takes no type argument before click 8.4


class _Span(_ParamType):
    name = "span"

    def convert(self, value: str | float, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return seconds."""
        if isinstance(value, float):
            return value
        match = _PATTERN.fullmatch(str(value).strip().lower())
        if match is None:
            self.fail(f"must be a number with s, m, h, d or w, for example 90d or 12h; got {value!r}", param, ctx)
        return float(match[1]) * _SECONDS[match[2]]


SPAN = _Span()
"""Seconds, written as a number and a unit (second, minute, hour, day, week)."""
