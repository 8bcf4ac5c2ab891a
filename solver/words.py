"""Numbers, durations, states and near names as a reader sees them: in a report, and plain in a terminal."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from itertools import islice

__all__ = [
    "FITS",
    "REASONS",
    "VERDICTS",
    "csv_cell",
    "did_you_mean",
    "duration",
    "ends",
    "interval_digits",
    "listed",
    "number",
    "per_cent",
    "power_of_ten",
    "reasons_in_words",
    "typeset",
    "verdict_in_words",
    "visible",
]

VERDICTS = {
    "identified": "identified",
    "bounded_on_one_side": "bounded on one side only",
    "in_combination": "only in combination",
    "not_identified": "not identified",
    "undecided": "undecided",
    "lack_of_fit": "the model does not fit",
    "error_not_met": "stated error not met",
}
"""Kind of verdict -> words."""

FITS = {
    "describes": "the model describes the data",
    "gross_error": "without the readings that the others exclude, the model describes the data",
    "doubtful": "whether the model describes the data is doubtful",
    "lack_of_fit": "the model does not describe the data",
    "error_not_met": "the stated error is not met",
    "untested": "whether the model describes the data has not been tested",
}
"""Kind of the verdict on the fit -> words."""

REASONS = {
    "max_evaluations": "maximum number of evaluations reached",
    "max_seconds": "maximum time reached",
    "target_objective": "objective at or below the target",
    "stagnation_generations": "objective no longer lowered",
    "samples_completed": "all samples evaluated",
    "polished": "polished to a local minimum",
    "polish_unfinished": "polishing ended before a minimum",
    "all_failed": "every run failed",
    "design_completed": "all planned evaluations made",
}
"""Stop reason -> words."""

_UNSEEN = re.compile("[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")
_UNSEEN_BUT_LINES = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_LONGEST_NAME, _MOST_NAMES = 50, 200
_MISSING = "–"
_PLAIN_MISSING = "-"


def number(value: float | None, digits: int = 4, *, plain: bool = False) -> str:
    """Return a number with significant digits, a dash for None.

    Parameters
    ----------
    plain
        ``4.83e-9`` as programs read it, instead of ``4.83·10⁻⁹``.
    """
    if value is None:
        return _PLAIN_MISSING if plain else _MISSING
    if isinstance(value, int):
        return str(value)
    text = f"{value:.{digits}g}"
    mantissa, exponent, power = text.partition("e")
    if exponent and 0 <= int(power) < 7:
        text, exponent = f"{float(text):.0f}", ""
    if plain:
        return f"{mantissa}e{int(power)}" if exponent else text
    if exponent:
        text = power_of_ten(mantissa, power)
    return text.replace("-", "−")


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return ``; did you mean lambda_star?``, or nothing when no known name is near.

    Names of more than 50 characters have no near ones, and only the first 200 known ones are compared: the comparison
    takes the product of both lengths.
    """
    if len(name) > _LONGEST_NAME:
        return ""
    close = get_close_matches(name, [one for one in islice(known, _MOST_NAMES) if len(one) <= _LONGEST_NAME], n=1)
    return f"; did you mean {close[0]}?" if close else ""


def visible(text: str, *, lines: bool = False) -> str:
    """Return a text with its control characters escaped, so that it cannot steer a terminal or forge a line.

    Parameters
    ----------
    lines
        Leave line feeds and tabs as they are.

    Examples
    --------
    >>> visible("red \\x1b[31m\\nnext")
    'red \\\\x1b[31m\\\\nnext'
    """
    pattern = _UNSEEN_BUT_LINES if lines else _UNSEEN
    return pattern.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), text)


def csv_cell(value: object) -> object:
    """Return a value for a cell of a CSV file: of a text no control characters, and none that is a formula there.

    A spreadsheet calculates what begins with ``=``, ``+``, ``-`` or ``@``; behind an apostrophe it is text.

    Examples
    --------
    >>> csv_cell("=1+1"), csv_cell("a=1"), csv_cell(-1.5)
    ("'=1+1", 'a=1', -1.5)
    """
    if not isinstance(value, str):
        return value
    return f"'{visible(value)}" if value.lstrip()[:1] in tuple("=+-@") else visible(value)


def ends(low: float, high: float, *, digits: int = 3, plain: bool = False) -> tuple[str, str]:
    """Return the ends of an interval with as many significant digits as its width needs, ``digits`` at least.

    Rounding an end moves it by a twentieth of the width at most, so that both differ from each other and from a value
    between them.
    """
    digits = interval_digits(low, high, digits)
    return number(low, digits, plain=plain), number(high, digits, plain=plain)


def interval_digits(low: float, high: float, fewest: int = 3) -> int:
    """Return how many significant digits the ends of an interval, and a value in it, need."""
    largest, width = max(abs(low), abs(high)), high - low
    if not (math.isfinite(width) and width > 0.0):
        return fewest
    return max(fewest, min(math.floor(math.log10(largest)) - math.floor(math.log10(0.1 * width)) + 1, 15))


def listed(words: Sequence[str], last: str = "and") -> str:
    """Return words with commas and one conjunction between them: ``a, b and c``; there must be one at least."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} {last} {words[-1]}"


def per_cent(part: float) -> str:
    """Return a part of a whole in per cent, one digit at least that is not 0: ``34 %``, ``2.1 %``, ``0.003 %``."""
    decimals = 0 if part >= 0.1 or part <= 0.0 else 1 if part >= 1e-3 else -math.floor(math.log10(100.0 * part))
    return f"{100.0 * part:.{decimals}f}".removesuffix(".0") + " %" if decimals <= 6 else "less than 0.000001 %"


def power_of_ten(mantissa: str, power: str) -> str:
    """Return ``5.2·10⁻⁸`` of 5.2 and -08; without the mantissa where it is 1."""
    raised = f"10{str(int(power)).translate(_RAISED)}"
    return raised if mantissa == "1" else f"{mantissa}·{raised}"


def typeset(text: str) -> str:
    """Return a sentence as it is printed: ``5.2e-08`` becomes ``5.2·10⁻⁸``, ``95 %`` is not broken."""
    powers = re.sub(
        r"(?<![\w.])(\d+(?:\.\d+)?)e([+-]\d+)\b",
        lambda found: power_of_ten(found[1], found[2]),
        text,
    )
    return re.sub(r"(\d) ?%", "\\1\N{NO-BREAK SPACE}%", powers)


def duration(seconds: float | None, *, plain: bool = False) -> str:
    """Return a time span [s] in words: ``0.8 s``, ``2 min 05 s``, ``3 h 02 min``; a dash for None."""
    if seconds is None:
        return _PLAIN_MISSING if plain else _MISSING
    if seconds < 0.1:
        return f"{seconds * 1000.0:.3g} ms"
    if seconds < 59.95:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min"


def reasons_in_words(stop_reasons: Sequence[str], *, plain: bool = False) -> str:
    """Return stop reasons as a phrase; a dash when there are none."""
    return ", ".join(REASONS.get(reason, reason) for reason in stop_reasons) or (_PLAIN_MISSING if plain else _MISSING)


def verdict_in_words(kind: str) -> str:
    """Return a kind of verdict in words."""
    return VERDICTS.get(kind, kind.replace("_", " "))
