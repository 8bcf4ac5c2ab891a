"""What a file that is attached to a job is: decided by its content, never by what the client says."""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Callable, Mapping
from pathlib import PurePath
from types import MappingProxyType
from typing import IO

from geoswarm.workers.errors import AttachmentRefusedError

__all__ = ["ENDINGS", "checked_name", "media_type_of"]

SPREADSHEET = "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet"
OPEN_SPREADSHEET = "application/vnd.oasis.opendocument.spreadsheet"

ENDINGS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "image/png": (".png",),
        "image/jpeg": (".jpg", ".jpeg"),
        "image/webp": (".webp",),
        "application/pdf": (".pdf",),
        SPREADSHEET: (".xlsx",),
        OPEN_SPREADSHEET: (".ods",),
        "text/csv": (".csv",),
        "text/tab-separated-values": (".tsv",),
        "text/plain": (".txt", ".md", ".log", ".dat", ".asc", ".ags"),
    }
)
"""Media types that are accepted, and how the names of such files end."""

ACCEPTED = "images (PNG, JPEG, WebP), PDF, text (.txt, .md, .log, .dat, .asc), CSV, TSV, AGS, workbooks (XLSX, ODS)"
LONGEST_NAME = 200  # bytes; file systems take 255
HEAD_BYTES = 1024
TAIL_BYTES = 256 * 1024  # the table of contents of a workbook, which is its end
PIECE_BYTES = 256 * 1024
TEXT_BYTES = bytes(byte for byte in range(256) if byte >= 32 or byte in b"\t\n\r\f")  # of UTF-8, or an older encoding


def checked_name(name: str) -> str:
    """Return the name of a file as it is stored: in composed letters, with usual blanks.

    Raises
    ------
    AttachmentRefusedError
        When it is empty or too long, names a folder, or has characters that cannot be seen.
    """
    plain = "".join(" " if unicodedata.category(letter) == "Zs" else letter for letter in name)
    plain = unicodedata.normalize("NFC", plain).strip()
    shown = ascii(name[:80])
    if not plain.strip(". "):
        raise AttachmentRefusedError("name", f"{shown} is no name; give one such as 'specimen.jpg'")
    if "/" in plain or "\\" in plain:
        raise AttachmentRefusedError("name", f"{shown} names a folder; give the name of the file without it")
    if not plain.isprintable():
        raise AttachmentRefusedError("name", f"{shown} has control characters; give a name of printable characters")
    if (size := len(plain.encode())) > LONGEST_NAME:
        raise AttachmentRefusedError("name", f"{shown}... has {size} bytes; a name may have {LONGEST_NAME}")
    return plain


def media_type_of(name: str, content: IO[bytes]) -> str:
    """Return the media type of a file.

    Parameters
    ----------
    content
        Any place in it; afterwards, too.

    Raises
    ------
    AttachmentRefusedError
        When files of this type are not accepted, or the ending of the name belongs to another type.
    """
    content.seek(0)
    head = content.read(HEAD_BYTES)
    content.seek(-min(TAIL_BYTES, content.seek(0, os.SEEK_END)), os.SEEK_END)
    tail = content.read()
    ending = PurePath(name).suffix.lower()
    for found, matches in SIGNATURES.items():
        if matches(head, tail):
            if ending not in ENDINGS[found]:
                wanted = " or ".join(ENDINGS[found])
                raise AttachmentRefusedError("name", f"{name!r} must end with {wanted}: its content is {found}")
            return found
    named = next((media_type for media_type, endings in ENDINGS.items() if ending in endings), None)
    if named is None:
        raise AttachmentRefusedError("name", f"{name!r} is of no type that can be attached; accepted: {ACCEPTED}")
    if named in SIGNATURES:
        why = f"{name!r} is not {named} by its content"
        if named == SPREADSHEET:
            why += ", or has macros; save it as a workbook without macros (.xlsx)"
        raise AttachmentRefusedError("content", f"{why}; accepted: {ACCEPTED}")
    _require_text(name, head, content)
    return named


def _require_text(name: str, head: bytes, content: IO[bytes]) -> None:
    if head.removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"<"):
        raise AttachmentRefusedError("content", f"{name!r} is HTML, SVG or XML by its content; accepted: {ACCEPTED}")
    content.seek(0)
    while piece := content.read(PIECE_BYTES):
        if strange := piece.translate(None, delete=TEXT_BYTES):
            raise AttachmentRefusedError(
                "content", f"{name!r} is no text: it has the byte 0x{strange[0]:02x}; save it as text in UTF-8"
            )


def _is_workbook(head: bytes, tail: bytes) -> bool:
    return head.startswith(b"PK\x03\x04") and b"xl/workbook.xml" in tail and b"vbaProject" not in tail


SIGNATURES: Mapping[str, Callable[[bytes, bytes], bool]] = MappingProxyType(
    {
        "image/png": lambda head, _: head.startswith(b"\x89PNG\r\n\x1a\n"),
        "image/jpeg": lambda head, _: head.startswith(b"\xff\xd8\xff"),
        "image/webp": lambda head, _: head.startswith(b"RIFF") and head[8:12] == b"WEBP",
        "application/pdf": lambda head, _: head.startswith(b"%PDF-"),
        SPREADSHEET: _is_workbook,
        OPEN_SPREADSHEET: lambda head, _: head[30:].startswith(b"mimetype" + OPEN_SPREADSHEET.encode()),
    }
)
"""How a type is recognised by the beginning and the end of a file; text has no such sign."""
