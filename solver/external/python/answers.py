"""What a function returned, as responses at the observed points; everything else is refused in words."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import BadOutputError
from geoswarm.solver.external.interpolation import at_points
from geoswarm.solver.units import base_unit, convert
from geoswarm.solver.words import did_you_mean

__all__ = ["Wanted", "responses_of"]


@dataclass(frozen=True, slots=True)
class Wanted:
    """The points at which a series is wanted.

    Parameters
    ----------
    x
        Shape (m,), base unit.
    x_unit, y_unit
        Units in which the function gets x and returns its values.
    """

    x: FloatArray
    x_unit: str
    y_unit: str

    @property
    def own_x(self) -> FloatArray:
        """x in the unit of the function, shape (m,).

        A number of few digits is given as such: 10 min is 10, not the 9.999999999999998 that comes of two conversions.
        """
        base = base_unit(self.x_unit)
        x = convert(self.x, base, self.x_unit)
        plain = np.array([float(f"{value:.15g}") for value in x])
        return np.where(convert(plain, self.x_unit, base) == self.x, plain, x)


def responses_of(
    returned: Any, wanted: Mapping[str, Wanted], declared: Collection[str], called: str
) -> dict[str, FloatArray]:
    """Return the response of every wanted series, shape (m_g,), base units.

    Parameters
    ----------
    returned
        An array, where one series is declared; or by series an array, or a tuple of x and y.
    declared
        Names of all series.
    called
        What the function is called in messages.

    Raises
    ------
    BadOutputError
        It is something else; the message says what, and what is accepted.
    """
    if not isinstance(returned, Mapping):
        if len(declared) > 1:
            raise BadOutputError(
                f"{called} returned {_described(returned)}; with the series {', '.join(declared)} a dict is accepted: "
                "{series: array}, or {series: (x, y)}"
            )
        returned = dict.fromkeys(wanted, returned)
        return {name: _values(returned[name], one, called, "") for name, one in wanted.items()}
    missing = [name for name in wanted if name not in returned]
    if missing:
        names = [str(name) for name in returned]
        hint = did_you_mean(missing[0], names)
        raise BadOutputError(
            f"{called} returned no series '{missing[0]}'{hint}; it returned {', '.join(names[:50]) or 'an empty dict'}"
        )
    return {name: _series(returned[name], one, called, name) for name, one in wanted.items()}


def _series(value: Any, wanted: Wanted, called: str, name: str) -> FloatArray:
    if not isinstance(value, tuple):
        return _values(value, wanted, called, name)
    if len(value) != 2:
        raise BadOutputError(
            f"{called} returned a tuple of {len(value)} for '{name}'; accepted: an array, or a tuple (x, y)"
        )
    x, y = (_array(one, called, f" as {axis} of '{name}'") for axis, one in zip("xy", value, strict=True))
    if x.ndim != 1 or x.shape != y.shape or not x.size:
        raise BadOutputError(
            f"{called} returned x of shape {x.shape} and y of shape {y.shape} for '{name}'; accepted: two arrays of "
            "one length"
        )
    if not np.isfinite(x).all():
        raise BadOutputError(f"{called} returned x of '{name}' that is not finite: {x[~np.isfinite(x)][0]}")
    base = base_unit(wanted.x_unit)
    return at_points(name, convert(x, wanted.x_unit, base), _in_base(y, wanted), wanted.x)


def _values(value: Any, wanted: Wanted, called: str, name: str) -> FloatArray:
    points = len(wanted.x)
    of = f" for '{name}'" if name else ""
    values = _array(value, called, of)
    if values.shape != (points,):
        accepted = f"an array of shape ({points},), one value for each observed point"
        pair = ", or a dict {series: (x, y)}" if not name else ", or a tuple (x, y)"
        raise BadOutputError(
            f"{called} returned {_described(value)}{of}; accepted: {accepted}{pair}, which is interpolated"
        )
    return _in_base(values, wanted)


def _in_base(values: FloatArray, wanted: Wanted) -> FloatArray:
    return convert(values, wanted.y_unit, base_unit(wanted.y_unit))


def _array(value: Any, called: str, of: str) -> FloatArray:
    """Numbers as they are; text, objects and complex numbers are none."""
    try:
        array = np.asarray(value)
    except Exception:  # noqa: BLE001  anybody's class
        array = np.empty(0, dtype=object)
    if array.dtype.kind not in "fiu":
        raise BadOutputError(f"{called} returned {_described(value)}{of}; accepted: an array of real numbers")
    return array.astype(np.float64)


def _described(value: Any) -> str:
    if value is None:
        return "None (is a return missing?)"
    if isinstance(value, str):
        return f"the text {value[:60]!r}"
    if isinstance(value, tuple):
        return f"a tuple of {len(value)}"
    if isinstance(value, bool | int | float | complex | np.generic):
        return f"the single value {value}"
    shape = getattr(value, "shape", None)
    if isinstance(shape, tuple):
        kind = getattr(value, "dtype", "")
        return f"an array of shape {shape}" + (f" and type {kind}" if str(kind) not in ("float64", "") else "")
    if isinstance(value, list):
        return f"a list of {len(value)}"
    return f"a {type(value).__name__}"
