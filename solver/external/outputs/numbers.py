"""Numbers as programs write them, those of Fortran included."""

from __future__ import annotations

import math
import re

from geoswarm.solver.external.errors import OutputReason

__all__ = ["NotFiniteNumberError", "looks_like_number", "number_of", "reason_of"]

# The plain form, with D or Q for the exponent, and with three digits that left no room for its letter: 1.5-103.
_NUMBER = re.compile(
    r"(?P<mantissa>[+-]?(?:\d+\.?\d*|\.\d+))(?:(?:[eEdDqQ](?P<power>[+-]?\d+))|(?P<bare>[+-]\d+))?", re.ASCII
)
_STARS = re.compile(r"[+-]?\*+(?:\.\*+)?")
_NOT_FINITE = re.compile(r"[+-]?(?:nan(?:\([^)]*\))?|inf|infinity|1\.#\w+|-?nan\w*)", re.IGNORECASE)
_GLUED = re.compile(r"[+-]?\d*\.\d*[eEdD][+-]\d{2,3}[+-]?\d*\.\d", re.ASCII)
_LONGEST = 400


class NotFiniteNumberError(ValueError):
    """A number is NaN or infinite."""


def reason_of(error: ValueError) -> OutputReason:
    """Why a run has failed whose output has such a number."""
    return "not_finite" if isinstance(error, NotFiniteNumberError) else "bad_output"


def number_of(text: str, decimal: str = ".") -> float:
    """Read one number.

    Accepted are ``1.5e-3``, Fortran's ``1.5D-03`` and ``1.5-103``, and with ``decimal=","`` a comma for the point.

    Raises
    ------
    ValueError
        The text is not a finite number; the message says what it is and what would be accepted.

    Examples
    --------
    >>> number_of("1.5D-03"), number_of("1.5-103"), number_of("2,5", ",")
    (0.0015, 1.5e-103, 2.5)
    """
    if decimal == ",":
        if "." in text:
            raise ValueError(f"'{text[:40]}' has a point, but the decimal sign is set to a comma")
        text = text.replace(",", ".")
    try:
        number = float(text)
    except ValueError:
        number = _fortran(text.strip())
    if not math.isfinite(number):
        raise NotFiniteNumberError(f"'{text.strip()[:40]}' is not finite; a finite number is expected")
    if "_" in text:
        raise ValueError(f"'{text.strip()[:40]}' is not a number")
    return number


def _fortran(text: str) -> float:
    found = _NUMBER.fullmatch(text) if len(text) <= _LONGEST else None
    if found is None:
        if text and _STARS.fullmatch(text):
            raise ValueError(f"'{text[:40]}': the program had no room for the number; let it write a wider field")
        if _NOT_FINITE.fullmatch(text):
            raise NotFiniteNumberError(f"'{text[:40]}' is not finite; a finite number is expected")
        if text.count(",") == 1 and _NUMBER.fullmatch(text.replace(",", ".")):
            raise ValueError(f"'{text[:40]}' has a comma; if it is the decimal sign, write decimal: ','")
        if _GLUED.match(text):
            raise ValueError(f"'{text[:40]}' is several numbers without a blank between; give fixed columns")
        raise ValueError(f"'{text[:40]}' is not a number" if text else "there is nothing where a number is expected")
    return float(f"{found['mantissa']}e{found['power'] or found['bare'] or 0}")


def looks_like_number(text: str) -> bool:
    """Whether a cell is meant as a number, also one that is not finite or did not fit its field."""
    text = text.strip()
    if not text or len(text) > _LONGEST:
        return False
    return any(form.fullmatch(text) for form in (_NUMBER, _STARS, _NOT_FINITE)) or bool(
        _NUMBER.fullmatch(text.replace(",", "."))
    )
