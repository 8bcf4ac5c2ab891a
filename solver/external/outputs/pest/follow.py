"""Reads a file after the instructions of PEST, from its first line to its last and never back."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from geoswarm.solver.external.errors import OutputError, OutputReason, place
from geoswarm.solver.external.outputs.numbers import number_of, reason_of
from geoswarm.solver.external.outputs.pest.instructions import (
    DUMMY,
    Advance,
    Fixed,
    Free,
    Instruction,
    InstructionLine,
    Instructions,
    Marker,
    Tab,
    Whitespace,
)
from geoswarm.solver.words import visible

__all__ = ["Value", "follow"]

_BETWEEN = " \t,"
_LOWER = {code: code + 32 for code in range(ord("A"), ord("Z") + 1)}  # lower() may change the length of other letters


class Value(NamedTuple):
    """A number and its line."""

    number: float
    line: int
    text: str


def follow(instructions: Instructions, lines: Iterator[tuple[int, str]], file: str) -> dict[str, Value]:
    """Read a file.

    Words end at a blank, a tab or a comma, and before a secondary marker that follows. Where a line of instructions
    holds nothing but markers up to one that is missing in the line, the search goes on for the first of them.

    Parameters
    ----------
    lines
        Of the file ``file``, with their numbers.

    Raises
    ------
    OutputError
        The file ends too early, a marker or a column is missing, or something is not a number; the message names lines
        of both files.
    """
    reader = _Reader(instructions, lines, file)
    for row in instructions.rows:
        reader.read(row)
    return reader.values


class _Reader:
    """``cursor`` is the index of the next character in the line."""

    def __init__(self, instructions: Instructions, lines: Iterator[tuple[int, str]], file: str) -> None:
        self.values: dict[str, Value] = {}
        self._instructions, self._lines, self._file = instructions, lines, file
        self._number, self._line, self._cursor = 0, "", 0
        self._at = 0

    def read(self, row: InstructionLine) -> None:
        index = 0
        while index < len(row.steps):
            step, self._at = row.steps[index], row.lines[index]
            following = row.steps[index + 1] if index + 1 < len(row.steps) else None
            if self._take(step, following):
                index += 1
            elif all(isinstance(one, Marker) for one in row.steps[:index]) and index:
                index = 0
            else:
                assert isinstance(step, Marker)
                raise self._wrong(f"the marker '{step.text}' is not in the rest of the line")

    def _take(self, step: Instruction, following: Instruction | None) -> bool:
        """Follow one instruction; False when a secondary marker is not in the line."""
        match step:
            case Advance(count):
                for _ in range(count):
                    self._next(f"line {count} from there")
            case Marker(text, True):
                self._next(f"the marker '{text}'")
                while (start := self._find(text, 0)) < 0:
                    self._next(f"the marker '{text}'")
                self._cursor = start + len(text)
            case Marker(text, _):
                start = self._find(text, self._cursor)
                if start < 0:
                    return False
                self._cursor = start + len(text)
            case Whitespace():
                self._cursor = self._word(self._end_of_word(self._cursor))
            case Tab(column):
                if column > len(self._line):
                    raise self._wrong(f"the line has {len(self._line)} columns; t{column} does not exist")
                self._cursor = column - 1
            case Fixed():
                self._fixed(step)
            case Free(name):
                self._free(name, following)
        return True

    def _next(self, wanted: str) -> None:
        try:
            self._number, self._line = next(self._lines)
        except StopIteration:
            message = f"{place(self._file, self._number)}: the file ends; expected is {wanted} ({self._where})"
            raise OutputError("bad_output", message) from None
        self._cursor = 0

    def _find(self, text: str, start: int) -> int:
        """Place of a marker's text in the line whatever its case, -1 when it is not there."""
        return _lower(self._line).find(_lower(text), start)

    def _word(self, start: int) -> int:
        """Beginning of the next word at or behind a place."""
        while start < len(self._line) and self._line[start] in _BETWEEN:
            start += 1
        if start == len(self._line):
            raise self._wrong("the line ends; another word is expected")
        return start

    def _end_of_word(self, start: int) -> int:
        while start < len(self._line) and self._line[start] not in _BETWEEN:
            start += 1
        return start

    def _fixed(self, step: Fixed) -> None:
        first, last = step.first - 1, min(step.last, len(self._line))
        inside = self._line[first:last]
        if not inside.strip():
            raise self._wrong(f"columns {step.first} to {step.last} are blank; {step.name} is expected there")
        if step.loose:
            first += next(at for at, sign in enumerate(inside) if sign not in _BETWEEN)
            last = self._end_of_word(first)
            while first > 0 and self._line[first - 1] not in _BETWEEN:
                first -= 1
        self._store(step.name, self._line[first:last])
        self._cursor = last

    def _free(self, name: str, following: Instruction | None) -> None:
        start = self._word(self._cursor)
        end = self._end_of_word(start)
        if isinstance(following, Marker):
            marker = self._find(following.text, start)
            end = marker if start < marker < end else end
        self._store(name, self._line[start:end])
        self._cursor = end

    def _store(self, name: str, text: str) -> None:
        if name == DUMMY:
            return
        try:
            self.values[name] = Value(number_of(text), self._number, self._line)
        except ValueError as error:
            raise self._wrong(f"{name}: {visible(str(error))}", reason_of(error)) from None

    @property
    def _where(self) -> str:
        return place(self._instructions.file, self._at)

    def _wrong(self, message: str, reason: OutputReason = "bad_output") -> OutputError:
        return OutputError(reason, f"{place(self._file, self._number)}: {message} ({self._where})")


def _lower(text: str) -> str:
    return text.lower() if text.isascii() else text.translate(_LOWER)
