"""Units at the door: factors between the units that users write and the base units of series (kN, m, day, degree)."""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from functools import cache, lru_cache
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from geoswarm.solver.arrays import FloatArray

__all__ = [
    "WATER",
    "UnitError",
    "base_unit",
    "convert",
    "convert_difference",
    "meant_unit",
    "same_unit",
    "shown_unit",
    "with_unit",
]

WATER: Final = 9.81
"""Unit weight of water, kN/m³."""

_MAX_LENGTH = 50
_TIMES = re.compile(r"(0\.\d{1,9}|10{1,6}|1(?=/))(?:/([1-9]\d{0,8}))? +([^\d\s*/].*)", re.ASCII)
_MOST_DIGITS = 100  # of a factor to root units; whole numbers of a million digits take a third of a second
_DIMENSIONLESS = frozenset({"", "1", "-", "dimensionless"})
_EXAMPLES = {
    "day": "s, min, h, day, week",
    "m": "um, mm, cm, m",
    "kPa": "Pa, kPa, MPa, bar, kN/m^2",
    "degree": "degree, rad",
    "dimensionless": "1, %",
}
_CANDIDATES = {
    "m": ("mm", "cm", "0.01 mm", "um", "inch"),
    "kPa": ("Pa", "MPa", "bar", "kgf/cm^2", "psi"),
    "day": ("h", "min", "s"),
    "degree": ("rad",),
    "kN/m³": ("N/m^3",),
    "": ("%",),
    "1": ("%",),
    "dimensionless": ("%",),
}
"""What is mistaken for another unit, the likeliest first."""


class UnitError(ValueError):
    """A unit is unknown or of the wrong dimension."""


def same_unit(first: str, second: str) -> bool:
    """Whether two names obviously mean the same unit."""
    return _canonical(first) == _canonical(second)


def _canonical(unit: str) -> str:
    unit = unit.strip()
    return "dimensionless" if unit in _DIMENSIONLESS else unit


@lru_cache(maxsize=256)
def base_unit(unit: str) -> str:
    """Return the unit of ours (kN, m, day, degree) that has the dimension of another; that itself where there is none.

    Raises
    ------
    UnitError
        The unit is unknown or has an offset.
    """
    plain = _split(_canonical(unit))[1]
    if plain in _BASE_OF:
        return _BASE_OF[plain]
    _root(plain, "m, kPa, kN, day, degree, 1")
    for base in _BASES:
        try:
            convert(0.0, plain, base)
        except UnitError:
            continue
        return base
    return plain


def _split(unit: str) -> tuple[Fraction, str]:
    """Factor and plain unit of one such as ``0.01 mm`` or ``1/100 mm``, the step of a dial gauge."""
    found = _TIMES.fullmatch(unit)
    times = Fraction(1) if found is None else Fraction(found[1]) / Fraction(found[2] or 1)
    return (times, found[3]) if found is not None and times else (Fraction(1), unit)


def convert(values: npt.ArrayLike, unit: str, base: str) -> FloatArray:
    """Convert values, any shape, from ``unit`` to ``base``; exact for factors such as 1/1000 or 1/1440.

    Raises
    ------
    UnitError
        ``unit`` is unknown, has an offset (degC) or is of another dimension than ``base``.
    """
    array = np.array(values, dtype=np.float64)
    if same_unit(unit, base):
        return array
    numerator, denominator = _ratio(unit, base)
    with np.errstate(all="ignore"):
        return np.asarray(array * numerator / denominator)


@lru_cache(maxsize=256)
def convert_difference(difference: float, unit: str, base: str) -> float:
    """Convert the difference of two values; offsets of a unit do not matter."""
    zero, moved = convert([0.0, difference], unit, base)
    return float(moved - zero)


def shown_unit(unit: str) -> str:
    """Return the unit as it follows a number: nothing for pure numbers.

    >>> shown_unit("kPa"), shown_unit("dimensionless")
    ('kPa', '')
    """
    return "" if unit in _DIMENSIONLESS else unit


def _ratio(unit: str, base: str) -> tuple[float, float]:
    """The factor as two numbers: two roundings keep 1440 min exactly one day, which one rounded factor would not."""
    (times, plain), (base_times, base_plain) = _split(_canonical(unit)), _split(_canonical(base))
    factor = _factor(plain, base_plain) * times / base_times
    return float(factor.numerator), float(factor.denominator)


_BASES = ("day", "m", "kPa", "kN", "degree", "dimensionless", "m^2", "m^3", "kN/m", "kN*m", "kN/m^3", "m/day", "1/m")

COMMON = {
    **{base: (Fraction(1), base) for base in _BASES},
    "s": (Fraction(1, 86400), "day"),
    "min": (Fraction(1, 1440), "day"),
    "h": (Fraction(1, 24), "day"),
    "week": (Fraction(7), "day"),
    "um": (Fraction(1, 10**6), "m"),
    "mm": (Fraction(1, 1000), "m"),
    "cm": (Fraction(1, 100), "m"),
    "in": (Fraction(254, 10**4), "m"),
    "Pa": (Fraction(1, 1000), "kPa"),
    "hPa": (Fraction(1, 10), "kPa"),
    "kN/m^2": (Fraction(1), "kPa"),
    "MPa": (Fraction(1000), "kPa"),
    "bar": (Fraction(100), "kPa"),
    "N": (Fraction(1, 1000), "kN"),
    "MN": (Fraction(1000), "kN"),
    "%": (Fraction(1, 100), "dimensionless"),
}
"""What nearly all measurements need, so that the registry need not be loaded (tests compare the two)."""

# Symbols and words of headings are also units: psi, whose factor the registry rounds, and "in".
_BASE_OF = {unit: base for unit, (_, base) in COMMON.items()} | {"psi": "kPa"}


@lru_cache(maxsize=256)
def _factor(unit: str, base: str) -> Fraction:
    if unit not in COMMON or base not in COMMON:
        return _registered_factor(unit, base)
    (factor, dimension), (base_factor, base_dimension) = COMMON[unit], COMMON[base]
    if dimension != base_dimension:
        raise _other_dimension(unit, base)
    return factor / base_factor


def _other_dimension(unit: str, base: str) -> UnitError:
    examples = _EXAMPLES.get(base, base)
    return UnitError(f"unit '{unit}' cannot be converted to {base}; accepted are for example {examples}")


def _registered_factor(unit: str, base: str) -> Fraction:
    examples = _EXAMPLES.get(base, base)
    factor, dimension = _root(unit, examples)
    base_factor, base_dimension = _root(base, examples)
    if dimension != base_dimension:
        raise _other_dimension(unit, base)
    quotient = factor / base_factor
    if not 1e-30 < quotient < 1e30:
        raise UnitError(f"unit '{unit}' is out of all proportion to {base}; accepted are for example {examples}")
    # The registry knows some factors (pi) to 28 digits only; floats need 17.
    return quotient.limit_denominator(10**15) if quotient.denominator > 10**15 else quotient


@cache
def _registry() -> Any:
    # Imported and built on first use: it costs a quarter of a second, and many problems need no conversion at all.
    from decimal import Decimal

    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


def _root(unit: str, examples: str) -> tuple[Fraction, str]:
    """Factor to root units (second, meter, gram, radian ...) and the root units' name."""
    from decimal import Decimal
    from tokenize import TokenError

    from pint.errors import PintError

    unknown = UnitError(f"unknown unit '{unit[:_MAX_LENGTH]}'; accepted are for example {examples}")
    if len(unit) > _MAX_LENGTH:
        raise unknown
    registry = _registry()
    try:
        parsed = registry.parse_units(unit)
        offset = registry.Quantity(0, parsed).to_root_units().magnitude
        factor, root = registry.get_root_units(parsed)
        if factor and abs(Decimal(factor).adjusted()) > _MOST_DIGITS:
            raise unknown
        exact = Fraction(factor)
    except (PintError, TokenError, SyntaxError, ValueError, TypeError, AssertionError, LookupError, ArithmeticError):
        # The parser of units answers nonsense with whatever its internals raise.
        raise unknown from None
    if offset != 0 or exact <= 0:
        raise UnitError(
            f"unit '{unit}' is not a plain multiple of {examples.split(',')[-1].strip()}; use a unit without offset"
        )
    return exact, str(root)


def meant_unit(
    value: float, base: str, usual: Callable[[float], bool], *, given: str | None = None
) -> tuple[str, float] | None:
    """Return the unit in which a value is a usual one, and that value in the base unit; None where there is none.

    ``value`` is in the base unit and was given in the unit ``given``, the base unit where that is None.
    """
    base = base.replace("³", "^3")
    written = value if given is None else float(convert(value, base or "1", given or "1"))
    for unit in (base or "1", *_CANDIDATES.get(base.replace("^3", "³"), ())):
        if same_unit(unit, base if given is None else given):
            continue
        moved = float(convert(written, unit, base or "1"))
        if usual(moved):
            return unit, moved
    return None


def with_unit(value: float, unit: str) -> str:
    """A value as a sentence shows it."""
    return f"{value:.6g} {shown_unit(unit)}".rstrip()
