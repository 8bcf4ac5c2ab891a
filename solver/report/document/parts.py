"""The parts of a report: cards, pictures, tables."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Alarm", "Card", "Picture", "Table"]


@dataclass(frozen=True, slots=True)
class Alarm:
    """What comes before everything else if results do not hold: heading, what is wrong, what to do."""

    kind: str
    heading: str
    sentence: str
    remedies: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Card:
    """Verdict on one parameter.

    ``value`` is that of the polished optimum where there is one, and ``remark`` then gives that of the best evaluation.
    """

    name: str
    symbol: str
    value: str
    remark: str
    kind: str
    words: str
    sentence: str
    proposals: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Picture:
    """One figure with its heading, its caption, and whether it needs the whole width of a page."""

    name: str
    heading: str
    caption: str
    wide: bool


@dataclass(frozen=True, slots=True)
class Table:
    """One table.

    ``numeric`` are the indices of the columns to align to the right; ``classical``: it belongs to the section of the
    classical evaluation, not among the others.
    """

    heading: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numeric: tuple[int, ...] = ()
    note: str = ""
    classical: bool = False
