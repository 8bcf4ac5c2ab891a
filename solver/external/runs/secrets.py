"""Values that no message may show: those of variables that a program is given."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from fnmatch import fnmatchcase

from geoswarm.solver.system.environment import ALLOWED

__all__ = ["HIDDEN", "Secrets", "private_values"]

HIDDEN = "***"
"""Replaces their values."""

_SHORT = 2  # characters: such a value is hidden where it stands alone, or no word would be left
_PLACEHOLDERS = re.compile(r"(\{[A-Za-z_]\w*\})*")


class Secrets:
    """Hides values in texts.

    Parameters
    ----------
    passed
        Values that are hidden wherever they stand; those of at most two characters where they stand as words.
    private
        Values that are hidden where they stand as words.

    Examples
    --------
    >>> Secrets(["rosebud", "7"], ["fine"]).hidden("key=rosebud7 pin 7, fine or finer")
    'key=***7 pin ***, *** or finer'
    """

    def __init__(self, passed: Iterable[str], private: Iterable[str] = ()) -> None:
        parts = {value: len(value) <= _SHORT for value in _lines(passed)}
        parts = dict.fromkeys(_lines(private), True) | parts
        longest_first = sorted(parts.items(), key=lambda part: -len(part[0]))
        patterns = [rf"(?<!\w){re.escape(value)}(?!\w)" if word else re.escape(value) for value, word in longest_first]
        self._pattern = re.compile("|".join(patterns)) if patterns else None

    def hidden(self, text: str, *own: str) -> str:
        """Return a text without the values.

        Parameters
        ----------
        *own
            Words of ours in the text, which tell nothing of any value: ``ended with exit status 1``, the run folder.
        """
        if self._pattern is None:
            return text
        ours = re.compile("|".join(re.escape(words) for words in own)) if own else None
        pieces, kept = (ours.split(text), ours.findall(text)) if ours else ([text], [])
        hidden = [self._pattern.sub(HIDDEN, piece) for piece in pieces]
        return "".join(part for pair in zip(hidden, [*kept, ""], strict=True) for part in pair)


def _lines(values: Iterable[str]) -> set[str]:
    """Values, and the lines of those that have several: a message may quote one of them."""
    parts = (part.strip() for value in values for part in (value, *value.splitlines()))
    return {part for part in parts if part}


def private_values(environment: Mapping[str, str], given: Mapping[str, str]) -> list[str]:
    """Return what a section gives as values of variables, but for those that any program may see (``OMP_NUM_THREADS``).

    Parameters
    ----------
    environment
        By name, as written in the section. One that consists of placeholders alone is what a user has chosen.
    given
        The same with all placeholders replaced.
    """
    return [
        given[name]
        for name, text in environment.items()
        if not _PLACEHOLDERS.fullmatch(text) and not any(fnmatchcase(name, pattern) for pattern in ALLOWED)
    ]
