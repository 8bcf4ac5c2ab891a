"""Files of text, line by line: a file of any size is never held as a whole."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Literal, TypeAlias

from geoswarm.solver.external.errors import OutputError, place
from geoswarm.solver.external.outputs.fields import below

__all__ = ["LONGEST_LINE", "Encoding", "decoded", "lines_of", "opened"]

LONGEST_LINE = 1_000_000
"""Bytes of a line; a longer one is no line of a table."""

Encoding: TypeAlias = Literal["utf-8", "latin-1", "cp1252", "utf-16"]
"""Encodings that a section may name; a file with a byte order mark is read by its mark."""

_MARK_8, _MARKS_16 = b"\xef\xbb\xbf", (b"\xff\xfe", b"\xfe\xff")


def opened(folder: Path, file: str) -> BinaryIO:
    """Open a file of a run for reading bytes.

    Raises
    ------
    OutputError
        ``no_output`` when it is missing or empty, ``bad_output`` when it cannot be read.
    """
    path = below(folder, file)
    try:
        if path.exists() and not path.is_file():  # a pipe would be waited for
            raise OutputError("bad_output", f"{file}: is not a regular file")
        stream = path.open("rb")
    except FileNotFoundError:
        raise OutputError("no_output", f"{file}: the run wrote no such file{_others(folder, file)}") from None
    except OSError as error:
        raise OutputError("bad_output", f"{file}: cannot be read: {error.strerror or error}") from error
    if path.stat().st_size == 0:
        stream.close()
        raise OutputError("no_output", f"{file}: the file is empty")
    return stream


def _others(folder: Path, file: str) -> str:
    parent = below(folder, file).parent
    if not parent.is_dir():
        return ""
    names = sorted(entry.name for entry in parent.iterdir())[:10]
    return f"; there are {', '.join(names)}" if names else "; the folder is empty"


def lines_of(
    folder: Path, file: str, encoding: Encoding = "utf-8", longest: int = LONGEST_LINE
) -> Iterator[tuple[int, str]]:
    """Give the lines of a file with their numbers, from 1, without their ends (of Unix or Windows).

    Raises
    ------
    OutputError
        The file is missing, empty or unreadable, a line is too long or not of the encoding, or the file is binary.
    """
    with opened(folder, file) as stream:
        try:
            yield from _numbered(stream, file, encoding, longest)
        except OSError as error:
            raise OutputError("bad_output", f"{file}: cannot be read: {error.strerror or error}") from error


def _numbered(stream: BinaryIO, file: str, encoding: Encoding, longest: int) -> Iterator[tuple[int, str]]:
    mark = stream.read(3)
    if mark[:2] in _MARKS_16 or encoding == "utf-16":
        stream.seek(0)
        yield from _wide(stream, file, longest)
        return
    if mark == _MARK_8:
        encoding = "utf-8"
    else:
        stream.seek(0)
    number = 0
    while raw := stream.readline(longest + 1):
        number += 1
        if len(raw) > longest:
            raise _too_long(file, number, longest)
        if b"\0" in raw:
            raise OutputError(
                "bad_output", f"{place(file, number)}: found a zero byte; the file is binary or truncated"
            )
        yield number, decoded(raw, file, number, encoding).rstrip("\r\n")


def decoded(raw: bytes, file: str, number: int | None, encoding: Encoding) -> str:
    """Return the text of bytes.

    Raises
    ------
    OutputError
        They are not of the encoding; the message names the first byte that is not.
    """
    try:
        return raw.decode(encoding)
    except UnicodeDecodeError as error:
        wrong = raw[error.start : error.start + 1].hex()
        hint = "; if it is of Windows or an old program, write encoding: latin-1" if encoding == "utf-8" else ""
        message = (
            f"{place(file, number)}: found the byte {wrong} at position {error.start + 1}, which is not {encoding}"
        )
        raise OutputError("bad_output", message + hint) from None


def _wide(stream: BinaryIO, file: str, longest: int) -> Iterator[tuple[int, str]]:
    number = 0
    try:
        with io.TextIOWrapper(stream, "utf-16", newline="\n") as text:
            while line := text.readline(longest + 1):
                number += 1
                if len(line) > longest:
                    raise _too_long(file, number, longest)
                yield number, line.rstrip("\r\n")
    except UnicodeError as error:
        message = f"{place(file, number + 1)}: found bytes that are not utf-16 ({error})"
        raise OutputError("bad_output", message) from None


def _too_long(file: str, number: int, longest: int) -> OutputError:
    return OutputError("bad_output", f"{place(file, number)}: the line is longer than {longest} bytes")
