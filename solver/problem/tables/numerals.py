"""Numbers as people write them: the sign before decimals, that between thousands, and where either may be meant."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Sequence
from typing import Literal, TypeAlias

from geoswarm.solver.problem.tables.packed import Cell
from geoswarm.solver.problem.tables.reading import DoubtError, cell_number
from geoswarm.solver.sentences import Sentence, setting

__all__ = [
    "DecimalSign",
    "doubtful_cell",
    "evidence",
    "is_mark",
    "no_reading_doubt",
    "number_of",
    "refuse_thousands",
    "sentinels_in",
    "two_readings",
]

DecimalSign: TypeAlias = Literal["comma", "point"]
"""What stands before the decimals; the other sign may then stand between thousands."""

Evidence: TypeAlias = frozenset[DecimalSign]

_NO_MARK = frozenset({"", "0", "no", "nein", "false", "ok", "-"})
_MOST = 60  # characters of a number with thousands
_SIGNS: dict[DecimalSign, str] = {"comma": ",", "point": "."}
_OTHER: dict[DecimalSign, DecimalSign] = {"comma": "point", "point": "comma"}
_GROUPS = {  # 1,000 and 12.345.678: one to three figures, then groups of three; 0,125 is none
    sign: re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:{re.escape(mark)}\d{{3}})+", re.ASCII) for sign, mark in _SIGNS.items()
}
_HUNDREDS = re.compile(r"[+-]?[1-9]\d{2}", re.ASCII)
_DECIMALS = {
    sign: re.compile(rf"[+-]?(?:\d+{re.escape(mark)}\d*|{re.escape(mark)}\d+)(?:[eE][+-]?\d+)?", re.ASCII)
    for sign, mark in _SIGNS.items()
}
_WHOLE = {  # groups by the other sign, an apostrophe or a blank, then decimals
    sign: re.compile(
        rf"([+-]?\d{{1,3}})((?:[{re.escape(_SIGNS[_OTHER[sign]])}'\u2019 \u00a0\u2009\u202f]\d{{3}})+)"
        rf"(?:{re.escape(mark)}(\d*))?",
        re.ASCII,
    )
    for sign, mark in _SIGNS.items()
}


def number_of(cell: Cell, sign: DecimalSign) -> float | None:
    """The finite number in a cell whose decimals follow this sign; None for anything else.

    >>> number_of("1,000", "point"), number_of("1,000", "comma"), number_of("1.234,5", "comma")
    (1000.0, 1.0, 1234.5)
    """
    if isinstance(cell, float):
        return cell if math.isfinite(cell) else None
    if len(cell) <= _MOST and (found := _WHOLE[sign].fullmatch(cell)) is not None:
        digits = "".join(figure for figure in found[2] if figure.isdigit())
        return cell_number(f"{found[1]}{digits}.{found[3] or ''}")
    return None if _SIGNS[_OTHER[sign]] in cell else cell_number(cell)


def two_readings(cell: Cell) -> dict[DecimalSign, float]:
    """What a cell may mean, by the sign before its decimals: ``1,000`` is 1 or 1000."""
    both = {sign: number_of(cell, sign) for sign in _OTHER}
    return {sign: value for sign, value in both.items() if value is not None}


def evidence(cells: Iterable[Cell]) -> Evidence:
    """Signs that certainly stand before decimals somewhere: ``0,25`` says comma, ``1,000`` nothing."""
    return frozenset(
        sign
        for cell in cells
        if isinstance(cell, str) and len(cell) <= _MOST and ("," in cell or "." in cell)
        for sign in _signs(cell)
    )


def _signs(cell: str) -> list[DecimalSign]:
    found: list[DecimalSign] = []
    for known, mark in _SIGNS.items():
        if mark not in cell:
            continue
        plain = _DECIMALS[known].fullmatch(cell) and not _GROUPS[known].fullmatch(cell)
        mixed = _SIGNS[_OTHER[known]] in cell and _WHOLE[known].fullmatch(cell)  # 1.234,5
        if plain or mixed:
            found.append(known)
    return found


def doubtful_cell(cells: Sequence[Cell], others: Iterable[Cell]) -> str | None:
    """First cell of a column that can be read in two ways, or has thousands that must be asked for; None without any.

    Parameters
    ----------
    cells
        Of the column. One of them that is certain, such as 0,25 beside 1,000, decides.
    others
        All cells of the file: they decide where the column does not.
    """
    commas = _first(cells, _GROUPS["comma"])
    points = _first(cells, _GROUPS["point"])
    apart = next((cell for cell in cells if isinstance(cell, str) and _apart(cell)), None)
    if commas is None and points is None:
        return apart
    own = evidence(cells)
    if len(own) == 1:  # 0,25 and 1,000: decimals; but 0.25 and 1,000: thousands
        (sign,) = own
        return _first(cells, _GROUPS[_OTHER[sign]]) or apart
    whole = evidence(others)
    if commas is not None and whole != {"comma"}:
        return commas
    if points is not None and (whole == {"comma"} or points.count(".") > 1 or _has_thousands(cells)):
        return points
    if commas is not None and commas.count(",") > 1:
        return commas
    return apart


def _first(cells: Sequence[Cell], form: re.Pattern[str]) -> str | None:
    return next((cell for cell in cells if isinstance(cell, str) and form.fullmatch(cell)), None)


def _has_thousands(cells: Sequence[Cell]) -> bool:
    """Whether points may be those of thousands, 800 and 1.600: 1.6 would end without 0, or the column rises then."""
    if not any(_HUNDREDS.fullmatch(f"{cell:.15g}" if isinstance(cell, float) else cell) for cell in cells):
        return False
    if any(isinstance(cell, str) and cell.endswith("0") and _GROUPS["point"].fullmatch(cell) for cell in cells):
        return True
    return _rises(cells, "comma") and not _rises(cells, "point")


def _rises(cells: Sequence[Cell], sign: DecimalSign) -> bool:
    values = [value for cell in cells if (value := number_of(cell, sign)) is not None]
    return all(one <= other for one, other in itertools.pairwise(values))


def _apart(cell: str) -> bool:
    """Whether only the reader with a sign understands a cell: 1'000, 1 000, 1.234,5."""
    return len(cell) <= _MOST and cell_number(cell) is None and bool(two_readings(cell))


def is_mark(cell: Cell) -> bool:
    """Whether a cell marks its row, as one of gross errors does."""
    return cell != 0.0 if isinstance(cell, float) else cell.strip().casefold() not in _NO_MARK


_SENTINEL = re.compile(
    r"-?(?:9{2,}(?:\.9+|\.25)?|9\.9{2,}|8{3,}(?:\.8+)?|7{3,}|[67]999|32767|65535|2147483647)|-1|-32768|-2147483648"
)
_HUGE = 1e9
_CODE = -99.0
_FAR = 2.0
_STEPS = 5.0
_LARGE = 10.0
_FEWEST = 2


def sentinels_in(values: Sequence[float]) -> list[float]:
    """Numbers that programs write for no reading, such as -999 and 1e30, and that are far from all others.

    >>> sentinels_in([0.1, 0.2, -999.0, 0.4]), sentinels_in([0.0, 99.0, 200.0]), sentinels_in([0.0, -1.0, 2.0, -1.0])
    ([-999.0], [], [])
    """
    suspects = {value for value in values if abs(value) >= _HUGE or _SENTINEL.fullmatch(f"{value:.12g}") is not None}
    others = [value for value in values if value not in suspects]
    if len(others) < _FEWEST or not suspects:
        return []
    low, high = min(others), max(others)
    return [
        value
        for value in dict.fromkeys(values)
        if value in suspects and (_leaps(values, value, others) if value == -1.0 else _is_far(value, low, high))
    ]


def _is_far(value: float, low: float, high: float) -> bool:
    if value <= _CODE and low >= 0.0:
        return True
    return max(low - value, value - high) > _FAR * (high - low or abs(high))


def _leaps(values: Sequence[float], value: float, others: Sequence[float]) -> bool:
    """Whether a number that returns is below all others, and far from those before and after it in each place."""
    places = [place for place, one in enumerate(values) if one == value]
    if len(places) < 2 or min(others) < 0.0:
        return False
    steps = sorted(abs(one - other) for one, other in itertools.pairwise(others))
    step = steps[len(steps) // 2]
    beside = [values[near] for place in places for near in (place - 1, place + 1) if 0 <= near < len(values)]
    nearest = min((one for one in beside if one != value), default=0.0)
    return nearest >= _LARGE or (step > 0.0 and nearest - value > _STEPS * step)


def no_reading_doubt(where: str, sentinels: Sequence[float]) -> DoubtError:
    """The question whether numbers are readings."""
    named = ", ".join(f"{value:.15g}" for value in dict.fromkeys(sentinels))
    told = (
        f"{where}: {named} {'is' if len(set(sentinels)) == 1 else 'are'} far from the other numbers, as what programs"
    )
    leaves = setting("no_reading", f"[{named}]"), ", which leaves such rows out, or "
    kept = setting("no_reading", "[]"), " where these are readings"
    return DoubtError({"no_reading": tuple(sentinels)}, (f"{told} write for no reading; give ", *leaves, *kept))


def refuse_thousands(file: str, column: str, cells: Sequence[tuple[int, Cell]], others: Iterable[Cell]) -> None:
    """Refuse what may be one number or a thousand times that; ``cells`` of a column with their lines.

    Raises
    ------
    DoubtError
        There is such a cell.
    """
    doubtful = doubtful_cell([cell for _, cell in cells], others)
    if doubtful is not None:
        line = next(line for line, cell in cells if cell == doubtful)
        told: Sentence = (f"'{doubtful}' may have thousands; say how it is written",)
        for between, (sign, value) in zip((": ", ", "), two_readings(doubtful).items(), strict=False):
            told = *told, between, setting("decimal_sign", sign), f" reads {value:.15g}"
        raise DoubtError({"decimal": sign}, (f"{file} line {line}, column {column}: ", *told))
