"""Template files, read and written without changing a byte outside placeholders."""

from __future__ import annotations

from pathlib import Path

from geoswarm.solver.external.errors import TemplateError

__all__ = ["read_template_file", "write_input_file"]

MAX_TEMPLATE_BYTES = 64 * 2**20
"""Largest template; bigger files that do not change are linked."""


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
