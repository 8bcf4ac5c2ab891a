"""The formats of placeholders: those of C's printf."""

from __future__ import annotations

import re
from dataclasses import dataclass

from geoswarm.solver.external.errors import InputError
from geoswarm.solver.external.inputs.texts import number_text

__all__ = ["ACCEPTED", "NumberFormat", "parse_format"]

ACCEPTED = "%e, %f, %g, %d and %s, with a width and digits behind the point such as %10.3e"

_FORMAT = re.compile(
    r"%(?P<flags>[-+ 0#]{0,5})(?P<width>[1-9]\d{0,2})?(?:\.(?P<precision>\d{1,3}))?l?(?P<kind>[eEfgGds])", re.ASCII
)


@dataclass(frozen=True, slots=True)
class NumberFormat:
    """How a number is written; ``text`` as the user wrote it.

    A width is that of the whole field: shorter numbers are filled up with blanks, longer ones are an error, for they
    would shift or overwrite the columns behind.
    """

    text: str
    pattern: str
    kind: str
    width: int | None

    def write(self, value: float) -> str:
        """Write a finite number.

        Raises
        ------
        InputError
            It does not fit the width, or is not whole where a whole number is wanted.
        """
        if self.kind == "d":
            if not value.is_integer():
                raise InputError(f"{number_text(value)} is not whole, as {self.text} wants it; round it, or use %g")
            written = self.pattern % int(value)
        elif self.kind == "s":
            written = self.pattern % number_text(value)
        else:
            written = self.pattern % value
        if self.width is not None and len(written) > self.width:
            raise InputError(
                f"'{written}' has {len(written)} characters, but {self.text} has room for {self.width}; "
                f"use a wider field or fewer digits"
            )
        return written


def parse_format(text: str) -> NumberFormat:
    """Read a format.

    Raises
    ------
    ValueError
        It is none; the message says what is accepted.
    """
    found = _FORMAT.fullmatch(text)
    if found is None:
        raise ValueError(f"format '{text}' is not supported; accepted are {ACCEPTED}")
    kind, precision = found["kind"], found["precision"]
    if precision is not None and kind in "ds":
        raise ValueError(f"format '{text}': %{kind} takes a width, but no digits behind the point")
    width = None if found["width"] is None else int(found["width"])
    flags = found["flags"].replace("0", "").replace("+", "") if kind == "s" else found["flags"]
    pattern = f"%{flags}{found['width'] or ''}{'' if precision is None else f'.{precision}'}{kind}"
    return NumberFormat(text, pattern, kind, width)
