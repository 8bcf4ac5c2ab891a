"""Instruction files of PEST (``.ins``), parsed.

::

    pif $
    $HEADS AT BORES$
    l2 [h1]10:20 (h2)22:30
    l1 w w !h3! $m above$ !dum! !h4!
    & t60 !h5!

Each line of instructions reads one line of the file. It begins with ``l5`` (five lines on) or a primary marker (on to
the next line that holds the text). Behind stand secondary markers (text in the rest of the line), ``w`` (on to the next
word), ``t12`` (to column 12), ``[name]12:20`` (the text in columns 12 to 20), ``(name)12:20`` (the number of which
some part stands there), ``!name!`` (the next number); the name ``dum`` is read and forgotten. A line that begins with
``&`` continues the one before. The case of names
and of texts does not matter.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TypeAlias

from geoswarm.solver.external.errors import TemplateError

__all__ = [
    "DUMMY",
    "Advance",
    "Fixed",
    "Free",
    "Instruction",
    "InstructionLine",
    "Instructions",
    "Marker",
    "Tab",
    "Whitespace",
    "parse_instructions",
]

DUMMY = "dum"
"""Name of what is read and forgotten."""

_HEADER = re.compile(r"\s*[pj]if\s+(?P<marker>\S+)\s*", re.IGNORECASE)
_NO_MARKER = "[]():!&"
_COLUMNS = re.compile(r"(?P<first>\d{1,6}):(?P<last>\d{1,6})(?=\s|$)", re.ASCII)
_SIMPLE = re.compile(r"(?:(?P<advance>[lL])(?P<lines>\d{1,9})|[tT](?P<column>\d{1,6})|(?P<w>[wW]))(?=\s|$)", re.ASCII)


@dataclass(frozen=True, slots=True)
class Advance:
    """Go on by a number of lines."""

    lines: int


@dataclass(frozen=True, slots=True)
class Marker:
    """Go on to a text: first in a line (primary) through the lines below, else in the rest of the line."""

    text: str
    primary: bool


@dataclass(frozen=True, slots=True)
class Whitespace:
    """Go on to the next word."""


@dataclass(frozen=True, slots=True)
class Tab:
    """Go to a column, from 1."""

    column: int


@dataclass(frozen=True, slots=True)
class Fixed:
    """Read columns ``first`` to ``last``, from 1; ``loose``: the whole word of which a part stands there."""

    name: str
    first: int
    last: int
    loose: bool


@dataclass(frozen=True, slots=True)
class Free:
    """Read the next word."""

    name: str


Instruction: TypeAlias = Advance | Marker | Whitespace | Tab | Fixed | Free


@dataclass(frozen=True, slots=True)
class InstructionLine:
    """The instructions for one line, and the line of the instruction file in which each stands."""

    steps: tuple[Instruction, ...]
    lines: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Instructions:
    """An instruction file. ``file`` is its name in messages."""

    file: str
    rows: tuple[InstructionLine, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """What is read, in the order of the file and in lower case, without ``dum``."""
        steps = (step for row in self.rows for step in row.steps)
        return tuple(step.name for step in steps if isinstance(step, Fixed | Free) and step.name != DUMMY)


def parse_instructions(text: str, file: str) -> Instructions:
    """Parse an instruction file.

    Raises
    ------
    TemplateError
        The first line is not ``pif`` and a marker, an instruction is not understood, or a name is read twice.
    """
    first, *rest = text.removeprefix("\ufeff").split("\n")
    marker = _marker(first, file)
    rows: list[InstructionLine] = []
    seen: dict[str, int] = {DUMMY: 0}
    for number, raw in enumerate(rest, start=2):
        line = raw.rstrip()
        if not line.strip():
            continue
        continued = line.lstrip().startswith("&")
        if continued and not rows:
            raise TemplateError("& continues a line, but there is none before", file, number)
        start = line.index("&") + 1 if continued else 0
        steps = _steps(line, start, marker, file, number, first=not continued)
        for step in steps:
            if isinstance(step, Fixed | Free) and step.name != DUMMY:
                if step.name in seen:
                    message = f"{step.name} is read in line {seen[step.name]} already; each name is read once"
                    raise TemplateError(message, file, number)
                seen[step.name] = number
        before = rows.pop() if continued else InstructionLine((), ())
        rows.append(InstructionLine((*before.steps, *steps), (*before.lines, *[number] * len(steps))))
    if len(seen) == 1:
        raise TemplateError("reads nothing; write for example l1 !h1!", file)
    return Instructions(file, tuple(rows))


def _marker(first: str, file: str) -> str:
    found = _HEADER.fullmatch(first)
    if found is None:
        raise TemplateError(f"'{first.strip()[:40]}' must be pif and a marker, such as: pif $", file, 1)
    marker = found["marker"]
    if len(marker) != 1 or marker.isalnum() or marker in _NO_MARKER:
        message = f"marker '{marker[:20]}' must be one character, no letter or digit and none of {_NO_MARKER}"
        raise TemplateError(message, file, 1)
    return marker


def _steps(line: str, start: int, marker: str, file: str, number: int, *, first: bool) -> list[Instruction]:
    steps: list[Instruction] = []
    position = start
    while position < len(line):
        if line[position].isspace():
            position += 1
            continue
        where = (file, number, position + 1)
        step, position = _step(line, position, marker, where, first and not steps)
        if first and not steps and not isinstance(step, Advance | Marker):
            message = "a line of instructions begins with l and a number, a marker, or &"
            raise TemplateError(message, *where)
        if (steps and isinstance(step, Advance)) or (isinstance(step, Advance) and not first):
            raise TemplateError("l goes to another line and must come first in a line of instructions", *where)
        steps.append(step)
    return steps


def _step(line: str, position: int, marker: str, where: tuple[str, int, int], primary: bool) -> tuple[Instruction, int]:
    sign = line[position]
    if sign == marker:
        end = _closing(line, position, marker, where)
        if end == position + 1:
            raise TemplateError(f"there is no text between the markers {marker}{marker}", *where)
        return Marker(line[position + 1 : end], primary), end + 1
    if sign == "!":
        end = _closing(line, position, "!", where)
        return Free(_name(line[position + 1 : end], where)), end + 1
    if sign in "[(":
        end = _closing(line, position, "]" if sign == "[" else ")", where)
        columns = _COLUMNS.match(line, end + 1)
        if columns is None or not 1 <= int(columns["first"]) <= int(columns["last"]):
            message = f"'{line[position : end + 14].strip()}': first and last column are expected, such as [h1]12:20"
            raise TemplateError(message, *where)
        name = _name(line[position + 1 : end], where)
        return Fixed(name, int(columns["first"]), int(columns["last"]), sign == "("), columns.end()
    found = _SIMPLE.match(line, position)
    if found is None or int(found["lines"] or 1) < 1 or int(found["column"] or 1) < 1:
        message = (
            f"'{line[position:].split()[0][:40]}' is not an instruction; accepted are l5, w, t12, "
            f"{marker}text{marker}, !name!, [name]12:20 and (name)12:20"
        )
        raise TemplateError(message, *where)
    if found["advance"]:
        return Advance(int(found["lines"])), found.end()
    return (Tab(int(found["column"])) if found["column"] else Whitespace()), found.end()


def _closing(line: str, position: int, sign: str, where: tuple[str, int, int]) -> int:
    end = line.find(sign, position + 1)
    if end < 0:
        raise TemplateError(f"'{line[position : position + 40]}' is not closed; '{sign}' is expected", *where)
    return end


def _name(text: str, where: tuple[str, int, int]) -> str:
    name = text.strip().lower()
    if not name or len(name) > 200 or any(sign.isspace() for sign in name):
        raise TemplateError(f"'{text[:40]}' is not the name of an observation", *where)
    return name
