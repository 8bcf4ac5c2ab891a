"""Numbers in the parameter spaces of PEST: as many digits as the width takes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal, TypeAlias

from geoswarm.solver.external.errors import InputError
from geoswarm.solver.external.inputs.texts import number_text

__all__ = ["Precision", "number_in_space"]

Precision: TypeAlias = Literal["single", "double"]

WIDEST: dict[Precision, int] = {"single": 13, "double": 23}
"""Characters that a number takes at most; the rest of a wider space stays blank."""


def number_in_space(value: float, width: int, precision: Precision = "double", *, point: bool = True) -> str:
    """Write a number into a space, right aligned, with as many significant digits as fit.

    Digits that change nothing are left out: a number of few digits is written exactly, and blanks stand before it. The
    exponent's letter is ``e`` for both precisions, which Fortran reads as ``d``, and other languages too.

    Parameters
    ----------
    value
        Finite.
    width
        Characters of the space, 1 at least.
    precision
        ``single``: only the last 13 characters of the space are used, ``double``: the last 23.
    point
        Whether there is always a decimal point (``point`` in the control file, not ``nopoint``).

    Raises
    ------
    InputError
        Not one significant digit fits.

    Examples
    --------
    >>> number_in_space(1.23456789e-5, 9), number_in_space(20.0, 6), number_in_space(2e5, 3, point=False)
    ('1.2346e-5', '  20.0', '2e5')
    """
    room = min(width, WIDEST[precision])
    for text in _texts(value, point):
        if len(text) <= room and math.isfinite(float(text)):  # 1.7e308 must not be rounded up to 2e308
            return text.rjust(width)
    raise InputError(
        f"{number_text(value)} cannot be written in {width} characters, not even with one significant digit"
        f"{' and a decimal point' if point else ''}; make the space wider"
    )


def _texts(value: float, point: bool) -> Iterator[str]:
    """Give the ways to write a number, the most precise first, and of equal ones the most readable."""
    if value == 0.0:
        yield from ("0.0", "0.", ".0")
        if not point:
            yield "0"
        return
    sign, magnitude = ("-" if value < 0.0 else ""), abs(value)
    most = len(repr(magnitude).partition("e")[0].replace(".", "").strip("0"))
    for count in range(max(most, 1), 0, -1):
        mantissa, _, power = f"{magnitude:.{count - 1}e}".partition("e")
        digits, exponent = mantissa.replace(".", ""), int(power)
        yield from (sign + text for text in _written(digits, exponent, point))


def _written(digits: str, exponent: int, point: bool) -> Iterator[str]:
    """Give the ways to write ``d.ddd e exponent``; those without a point where none is needed."""
    count = len(digits)
    if -5 <= exponent < 0:
        fraction = "0" * (-exponent - 1) + digits
        yield from (f"0.{fraction}", f".{fraction}")
    elif 0 <= exponent <= 22:
        if count > exponent + 1:
            yield f"{digits[: exponent + 1]}.{digits[exponent + 1 :]}"
        else:
            whole = digits + "0" * (exponent + 1 - count)
            yield from (f"{whole}.0", f"{whole}.")
            if not point:
                yield whole
    for before in (*range(1, count + 1), 0):  # 12.3e9 is shorter than 1.23e10
        yield f"{digits[:before]}.{digits[before:]}e{exponent + 1 - before}"
    if not point:
        yield f"{digits}e{exponent - count + 1}"
