"""Texts for other programs: numbers as they read them, files without a byte changed outside placeholders."""

from __future__ import annotations

import math
from pathlib import Path

from geoswarm.solver.errors import message_of
from geoswarm.solver.external.errors import InputError, TemplateError

__all__ = ["checked", "number_text", "read_template_file", "write_input_file"]


MAX_TEMPLATE_BYTES = 64 * 2**20
"""Largest template; bigger files that do not change are linked."""


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


def read_template_file(path: Path) -> str:
    """Return the text of a template. Line ends stay; bytes that are not UTF-8 are kept as they are.

    Raises
    ------
    TemplateError
        It is missing, unreadable or too large.
    """
    if path.exists() and not path.is_file():
        raise TemplateError("is not a regular file", str(path))
    try:
        with path.open("rb") as file:
            content = file.read(MAX_TEMPLATE_BYTES + 1)
    except OSError as error:
        raise TemplateError(f"cannot be read: {error.strerror or error}", str(path)) from error
    if len(content) > MAX_TEMPLATE_BYTES:
        raise TemplateError(f"is larger than {MAX_TEMPLATE_BYTES // 2**20} MB", str(path))
    return content.decode("utf-8", errors="surrogateescape")


def write_input_file(path: Path, text: str) -> None:
    """Write a filled template; the counterpart of :func:`read_template_file`."""
    path.write_bytes(text.encode("utf-8", errors="surrogateescape"))
