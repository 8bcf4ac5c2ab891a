"""Numbers as other programs read them."""

from __future__ import annotations

import math

from geoswarm.solver.errors import message_of
from geoswarm.solver.external.errors import InputError

__all__ = ["checked", "number_text"]


def checked(value: float, what: str) -> float:
    """Return a value as a float.

    Raises
    ------
    InputError
        It is not a finite number; ``what`` names it: ``parameter E``.
    """
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{what}: a finite number is expected ({message_of(error)})") from None
    if not math.isfinite(number):
        raise InputError(f"{what} is {number}; only finite numbers are written")
    return number


def number_text(value: float) -> str:
    """Return the shortest text that reads back to the same bits: 17 significant digits at most.

    There is always a decimal point: Fortran puts one where it misses one, so that ``1e-05`` or ``20`` would be read by
    ``E10.3`` as a thousandth of what was meant. Whole numbers are therefore ``20.0``.

    >>> number_text(20.0), number_text(1e-05), number_text(0.1 + 0.2)
    ('20.0', '1.0e-05', '0.30000000000000004')
    """
    text = repr(float(value))
    mantissa, exponent, power = text.partition("e")
    return f"{mantissa}.0e{power}" if exponent and "." not in mantissa else text
