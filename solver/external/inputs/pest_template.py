"""Templates of PEST (``.tpl``).

::

    ptf %
    permeability %  k1          %   porosity %n    %

Between two markers stands the name of a parameter; the markers and what is between them are the space for its number,
which is written right aligned with as many digits as fit. Names are case insensitive and may stand in several spaces,
each of which takes what fits it. The first line names the marker and is not copied. ``jtf`` is read like ``ptf``.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from geoswarm.solver.external.errors import InputError, TemplateError, place
from geoswarm.solver.external.inputs.pest_numbers import Precision, number_in_space
from geoswarm.solver.external.inputs.texts import checked
from geoswarm.solver.words import did_you_mean

__all__ = ["PestTemplate", "Space", "parse_pest_template"]

_HEADER = re.compile(r"\s*[pj]tf\s+(?P<marker>\S+)\s*", re.IGNORECASE)
_MOST_NAME = 200
_NO_MARKER = "[]():!&"


@dataclass(frozen=True, slots=True)
class Space:
    """One parameter space: its name in lower case, its width with the markers, and its place."""

    name: str
    width: int
    line: int
    column: int


@dataclass(frozen=True, slots=True)
class PestTemplate:
    """A template of PEST that was read. ``file`` is its name in messages.

    Parameters
    ----------
    precision, point
        As PEST's control file has them: ``single`` or ``double``, and ``point`` (true) or ``nopoint``.
    """

    file: str
    pieces: tuple[str | Space, ...]
    precision: Precision = "double"
    point: bool = True

    @property
    def spaces(self) -> tuple[Space, ...]:
        """The spaces in the order of the file."""
        return tuple(piece for piece in self.pieces if isinstance(piece, Space))

    @property
    def names(self) -> frozenset[str]:
        """The parameters that the template uses, in lower case."""
        return frozenset(space.name for space in self.spaces)

    def check(self, known: Collection[str]) -> None:
        """Compare the names with the known parameters, whatever their case.

        Raises
        ------
        TemplateError
            A name is not a parameter, or two parameters differ in nothing but their case.
        """
        lower = self._by_lower_case(known)
        for space in self.spaces:
            if space.name not in lower:
                listed = ", ".join(sorted(known)[:20]) or "none"
                message = f"{space.name} is not a parameter{did_you_mean(space.name, lower)}; parameters: {listed}"
                raise TemplateError(message, self.file, space.line, space.column)

    def used(self, known: Collection[str]) -> frozenset[str]:
        """Which of the known parameters the template uses, as they are spelt there."""
        return frozenset(name for name in known if name.lower() in self.names)

    def fill(self, values: Mapping[str, float]) -> str:
        """Return the file with the values in their spaces.

        Raises
        ------
        TemplateError
            A name has no value.
        InputError
            A value is not finite, or not one of its digits fits the space.
        """
        self.check(values)
        lower = self._by_lower_case(values)
        return "".join(
            piece if isinstance(piece, str) else self._written(piece, values[lower[piece.name]])
            for piece in self.pieces
        )

    def _written(self, space: Space, value: float) -> str:
        where = f"{place(self.file, space.line, space.column)}: {space.name}"
        number = checked(value, where)
        try:
            return number_in_space(number, space.width, self.precision, point=self.point)
        except InputError as error:
            raise InputError(f"{where}: {error}") from None

    def _by_lower_case(self, known: Collection[str]) -> dict[str, str]:
        lower: dict[str, str] = {}
        for name in known:
            if lower.setdefault(name.lower(), name) != name and name.lower() in self.names:
                message = f"parameters {lower[name.lower()]} and {name} differ in case only, which PEST does not see"
                raise TemplateError(message, self.file)
        return lower


def parse_pest_template(text: str, file: str, precision: Precision = "double", *, point: bool = True) -> PestTemplate:
    """Read a template of PEST.

    Raises
    ------
    TemplateError
        The first line is not ``ptf`` and a marker, a marker has no partner in its line, or a space has no name.
    """
    first, newline, body = text.removeprefix("\ufeff").partition("\n")
    marker = _marker(first, file)
    pieces: list[str | Space] = []
    for number, line in enumerate(body.split("\n") if newline else [], start=2):
        pieces.append("\n" if number > 2 else "")
        parts = line.split(marker)
        if len(parts) % 2 == 0:
            message = f"{len(parts) - 1} markers '{marker}' in the line; a space has one at each end"
            raise TemplateError(message, file, number, len(line) - len(parts[-1]))
        column = 1
        for index, part in enumerate(parts):
            if index % 2:
                pieces.append(_space(part, marker, file, number, column))
                column += len(part) + 2
            else:
                pieces.append(part)
                column += len(part)
    return PestTemplate(file, tuple(piece for piece in pieces if piece != ""), precision, point)


def _marker(first: str, file: str) -> str:
    found = _HEADER.fullmatch(first)
    if found is None:
        message = f"'{first.strip()[:40]}' must be ptf and the marker of parameter spaces, such as: ptf %"
        raise TemplateError(message, file, 1)
    marker = found["marker"]
    if len(marker) != 1 or marker.isalnum() or marker in _NO_MARKER:
        message = f"marker '{marker[:20]}' must be one character, no letter or digit and none of {_NO_MARKER}"
        raise TemplateError(message, file, 1)
    return marker


def _space(part: str, marker: str, file: str, line: int, column: int) -> Space:
    name = part.strip().lower()
    if not name or len(name) > _MOST_NAME or any(sign.isspace() for sign in name):
        what = "no name" if not name else f"'{name[:40]}'"
        message = f"between the markers '{marker}' there is {what}; the name of one parameter is expected"
        raise TemplateError(message, file, line, column)
    return Space(name, len(part) + 2, line, column)
