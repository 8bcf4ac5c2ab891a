"""Sentences that name keys of the problem: each surface words these.

A file, a report and the command line name the key (``y_unit: mm``); the form of a new job its field (``“Unit of
settlement” mm``, ``api/static/js/new/words.js``). Nothing takes a sentence apart.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from typing import Any, TypeAlias

__all__ = ["Key", "Sentence", "SentenceError", "parts_json", "plain", "relative", "setting"]


@dataclass(frozen=True, slots=True)
class Key:
    """A key of the problem in a sentence.

    Parameters
    ----------
    path
        Where it stands: ``observations[0].y_unit``.
    text
        What a sentence about a problem file says: ``y_unit: mm``.
    value
        What it is to be given; nothing where it is only named.
    """

    path: str
    text: str
    value: str = ""


Sentence: TypeAlias = tuple[str | Key, ...]


class SentenceError(ValueError):
    """What a validator of a section refuses, with the keys that the message names: paths within the section."""

    def __init__(self, *parts: str | Key) -> None:
        super().__init__(plain(parts))
        self.sentence: Sentence = parts


def setting(path: str, value: str = "") -> Key:
    """A key by its own name, without where it stands, and what to give it."""
    name = path.rpartition(".")[2]
    written = "'%'" if value == "%" else value  # as YAML needs it
    return Key(path, f"{name}: {written}" if value else name, value)


def plain(parts: Iterable[str | Key]) -> str:
    """The sentence in the words of the problem file."""
    return "".join(part if isinstance(part, str) else part.text for part in parts)


def relative(parts: Iterable[str | Key]) -> Sentence:
    """The sentence with keys that stand in no part of the problem yet: without the dot of their parent."""
    return tuple(part if isinstance(part, str) else replace(part, path=part.path.removeprefix(".")) for part in parts)


def parts_json(parts: Iterable[str | Key]) -> list[str | dict[str, Any]]:
    """Return plain JSON values."""
    return [part if isinstance(part, str) else asdict(part) for part in parts]
