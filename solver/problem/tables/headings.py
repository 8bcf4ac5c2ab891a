"""The units that headings, units rows and comments of a file of measurements name, German or English."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from geoswarm.solver.problem.tables.alterations import ALTERED, Alteration, alteration_in, referred_apart
from geoswarm.solver.problem.tables.quantities import quantities_of
from geoswarm.solver.problem.tables.unit_words import ALIASES, ATOMS, CASE_MATTERS, PARTS, in_signs
from geoswarm.solver.units import UnitError, base_unit, convert

__all__ = [
    "BASES",
    "Heading",
    "Named",
    "best_unit",
    "guess_unit",
    "heading_of",
    "is_unit",
    "known_unit",
    "number_with_unit",
    "unclear_unit",
    "units_in_comments",
    "units_of",
    "without_brackets",
]

BASES = ("day", "m", "kPa", "degree", "dimensionless")
_FACTOR = re.compile(
    r"(?P<factor>1\s?/\s?10{1,6}|(?:(?:1\s?)?[x×*·]\s?)?10(?:\^[-−]?|[-−])\d|1[eE][-+]?\d{1,2}|(?:[x×*·]\s?)?(?:\d{1,6}(?:[.,]\d{1,6})?|[.,]\d{1,6}))"
    r"(?:\s*[x×*·]\s*|\s*)(?P<unit>.*)"
)
_SMALL = re.compile(
    r"1\s?/\s?10|(?:[x×*·]\s?)?0?[.,]\d|\D{0,4}10\^?[-−]|1[eE]-"
)  # what a dial gauge divides by; "in 5 m depth" is a place
_SQUARE = re.compile(r"(?<![A-Za-z])sq\.?\s?([A-Za-z]{1,4})\b\.?", re.IGNORECASE)
_EXPONENT = re.compile("(?<![⁰¹²³⁴⁵⁶⁷⁸⁹⁻])(?=[⁰¹²³⁴⁵⁶⁷⁸⁹⁻])")
_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_BRACKETS = re.compile(r"\[[^\[\](){}<>]{0,40}\]|\([^\[\](){}<>]{0,40}\)|\{[^\[\](){}<>]{0,40}\}|<[^\[\](){}<>]{0,40}>")
_GLUED = re.compile(r"(?:(?<=[^\W\d_])|(?<=[^\W\d_]\d))(?=[%‰](?:\s|$))|(?<=^[%‰])(?=[^\W\d_])")  # "eps1%", "%strain"
_IN = re.compile(r"(?:^|\s)(?:in|unit:?|einheit:?)\s+(?=\S)", re.IGNORECASE)
_BEHIND = re.compile(r"(?<=.)\s*[/,_:;|=]\s*(?=[^\s,]{1,20}(?:\s[^\s,/]{1,20})?$)|\s[-–]\s(?=\S{1,20}$)")
_VALUE = re.compile(r"([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?)\s*([^\d\s.,+*×·/-].{0,19})")
_COMMENT = re.compile(r"(?<![\w.])([\w.]+) in ([^\s,;]+)")  # from the start of a word only: linear in the text
_LISTED = re.compile(r"[,;]\s+")
_STEPS = re.compile(r"(?:\S+ )?(?:divs?\.?|divisions?|digits?|counts?|ticks?|skt\.?|skalenteile?n?)", re.IGNORECASE)
_SYMBOLS = frozenset("tglAVN")  # in round brackets a unit only where one of its dimension is needed: time, test A
_FORCE = re.compile(r"force|kraft|\blast\b|\bload\b", re.IGNORECASE)
_STEP_BEFORE = re.compile(rf"(?:1/10+|0[.,]\d+|10\^?-\d|{PARTS})_", re.IGNORECASE)
_AND = frozenset(("und", "and", "or", "bzw.", "bzw", "resp."))
_SLASHES = str.maketrans({"⁄": "/", "∕": "/", "⅟": "1/"})
_SYMBOL_OVER = re.compile(r"[a-ln-zA-Z]/(?=\w+$)")
_VALUE_BEFORE = re.compile(
    r"(?:(?:^|[/=|:*·×(])x?\d+(?:[.,]\d+)?|hunderte?|tausende?|zehn|hundreds?|thousands?|ten)$", re.IGNORECASE
)
"""A word that makes the unit behind it a value, ``strain at 100 kPa``."""
_LETTERS = re.compile(r"([A-Za-z]{1,3}):\1")  # a column without a heading: H:H are no hours
_LETTER = re.compile(r"[^\W\dxeE_]|[%‰°]")
_NUMBERED = re.compile(r"^[a-ln-zA-Z]\d+$|[A-Za-z]1(?!\d)")  # s1, A2, min1: names, not powers
_PER = re.compile(r"(?<![^\W_])([µμ]?[^\W\d_]{1,4})[ _]per[ _]([^\W\d_]{1,4})(?![^\W_])", re.IGNORECASE)
_SIGNS = ("%", "‰")
_SIZES = ("m", "kPa")  # "Setzung mm bzw. cm"
_LONGEST = 200


@dataclass(frozen=True, slots=True)
class Named:
    """A unit that a text names.

    Parameters
    ----------
    unit
        As a problem file writes it; None for what stands where a unit stands and is not known.
    base
        Base unit of its dimension.
    certain
        Whether it is in brackets or after ``in``.
    text
        As it stands.
    label
        The rest of the text.
    alters
        What it is that makes the numbers another quantity than a unit beside it says; None for a unit.
    """

    unit: str | None
    base: str | None
    certain: bool
    text: str
    label: str
    alters: Alteration | None = None


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading and the units that it, a comment or the cells below it name.

    ``dates``: the column holds dates, which are read as days. ``in_cells``: the cells themselves have the unit.
    ``named`` also holds what is at the place of a unit and is not known. ``first`` are the first values.
    """

    name: str
    named: tuple[Named, ...] = ()
    dates: bool = False
    in_cells: bool = False
    first: tuple[float, ...] = ()

    def without(self, *alterations: Alteration) -> Heading:
        """The same where somebody says what is to be done about these."""
        return replace(self, named=tuple(one for one in self.named if one.alters not in alterations))

    @property
    def unit(self) -> str | None:
        """The unit that is most certain; None without one."""
        best = best_unit(self.named)
        return None if best is None else best.unit

    @property
    def certain(self) -> bool:
        """Whether that unit is in brackets, after ``in``, or in the cells."""
        best = best_unit(self.named)
        return best is not None and best.certain


def heading_of(
    name: str, comments: Mapping[str, str], *, text: str = "", dates: bool = False, in_cells: str | None = None
) -> Heading:
    """Return the heading of a column: its unit is that of dates, else of the cells, of the text, of a comment.

    Parameters
    ----------
    text
        What stands above the cells, where that is not the ``name``.
    in_cells
        Unit that all cells end with.
    """
    named = units_of(text or name)
    if dates or in_cells is not None:
        unit = "day" if in_cells is None or dates else in_cells
        own = Named(unit, _known(unit)[1], True, unit, name)
        others = (
            one for one in named if one.certain and one.base == own.base and one.base not in ("day", "dimensionless")
        )
        return Heading(name, (own, *others), dates, not dates)
    if not named and name in comments:
        named = tuple(replace(one, certain=False) for one in units_of(f"x [{comments[name]}]") if one.unit is not None)
    return Heading(name, named)


def best_unit(named: Iterable[Named], bases: Sequence[str | None] | None = None) -> Named | None:
    """Return the first unit that is certain, else the first one; of these dimensions, if some are given."""
    known = [one for one in named if one.unit is not None and (bases is None or one.base in bases)]
    return next((one for one in known if one.certain), known[0] if known else None)


def guess_unit(heading: str) -> tuple[str, str | None, str | None]:
    """Split a heading such as ``settlement [mm]`` or ``time in min`` into label, unit and base unit.

    >>> guess_unit("Setzung [1/100 mm] (korr.)")
    ('Setzung (korr.)', '0.01 mm', 'm')
    """
    best = best_unit(units_of(heading), BASES)
    return (" ".join(heading.split()), None, None) if best is None else (best.label, best.unit, best.base)


def unclear_unit(named: Iterable[Named]) -> str | None:
    """Say why the units that a text names leave open what its numbers are in; None where they do not, or are none."""
    named = tuple(named)
    known = [(one.unit, one.base) for one in named if one.unit is not None and one.base is not None]
    for wanted in dict.fromkeys(base for _, base in known):
        units = {float(convert(1.0, unit, base)): unit for unit, base in known if base == wanted}
        if len(units) > 1:
            return f"names several units, {' and '.join(units.values())}"
    strange = next((one.text for one in named if one.unit is None and not one.alters), None)
    altered = next((one for one in named if one.alters), None)
    if altered is not None and altered.alters is not None and (known or strange is None):
        beside = f", beside {' and '.join(unit for unit, _ in known)}" if known else ""
        return f"{ALTERED[altered.alters]}, '{altered.text}'{beside}"
    return None if known or strange is None else f"names '{strange}', which is not a known unit"


def without_brackets(heading: str) -> str:
    """A heading without its brackets, which hold remarks and units."""
    return " ".join(_BRACKETS.sub(" ", heading[:_LONGEST]).split()).rstrip("_")


def known_unit(text: str) -> tuple[str | None, str | None]:
    """Return a unit as a problem file writes it and its base unit; None twice for what is not a unit."""
    unit, base = _known(" ".join(text.split()))
    return (unit, base) if base in BASES else (None, None)


@functools.lru_cache(maxsize=4096)
def units_of(heading: str) -> tuple[Named, ...]:
    """All units that a heading names, in square brackets first; also what stands in such brackets and is not known."""
    heading = _PER.sub(_over, referred_apart(" ".join(heading.split()).translate(_SLASHES)))
    if len(heading) > _LONGEST or _LETTERS.fullmatch(heading) is not None:
        return ()
    found: list[Named] = []
    plain = _GLUED.sub(" ", _BRACKETS.sub(" ", heading))
    for bracket in sorted(_BRACKETS.finditer(heading), key=lambda one: "[{<(".index(one[0][0])):
        inner = re.sub(r"^(in|unit:?|einheit:?)\s+", "", bracket[0][1:-1].strip(), flags=re.IGNORECASE)
        unit, base = _known(re.sub(r"\s*/\s*", "/", inner))
        if unit is None and len(listed := [one for one in _LISTED.split(inner) if is_unit(one)]) == 1:
            inner = listed[0]  # "(gesamt, mm)"
            unit, base = _known(inner, small=True)
        label = " ".join((heading[: bracket.start()] + " " + heading[bracket.end() :]).split()).rstrip("_")
        if unit is not None:
            force = inner == "N" and "[" not in heading and _FORCE.search(label) is not None
            symbol = bracket[0][0] == "(" and inner in _SYMBOLS and not force
            found.append(Named(unit, base, not symbol, inner, label or heading))
        elif inner and (bracket[0][0] != "(" or _is_no_unit(inner)):
            found.append(Named(None, None, True, inner, heading))
    if any(one.certain and one.unit is not None for one in found):
        found = [one for one in found if one.certain]  # "Normalkraft (N) [kN]": N is the symbol
        bases = {one.base for one in found}
        outside = " ".join(plain.split())  # psi [hPa] is a suction
        others = (one for one in _outside(outside, heading) if one.base in bases and one.text != outside)
        found += [
            one for one in others if one.certain or one.text in _SIGNS or (one.base in _SIZES and len(one.text) > 1)
        ]
    if not found:
        found = list(_outside(" ".join(plain.split()), heading))
    found += [one for one in [_altered(heading, found)] if one is not None]
    return tuple(dict.fromkeys(found))


def _over(found: re.Match[str]) -> str:
    """A quotient of two units in signs: ``mm_per_m``."""
    return f"{found[1]}/{found[2]}" if _known(found[1])[0] and _known(found[2])[0] else found[0]


def _altered(heading: str, found: Sequence[Named]) -> Named | None:
    """What makes the numbers another quantity than the units of a heading say; without a unit, a factor."""
    units = [one for one in found if one.unit is not None and (len(found) == 1 or _LETTER.search(one.text))]
    rest = heading
    for one in units:
        unit = re.escape(one.text.rstrip("^"))
        rest = re.sub(rf"(?<![^\W_]){unit}(?![^\W\d_])", lambda _: "\0", rest, count=1)
    bases = {one.base for one in units if one.unit != "dimensionless"}
    kind, text = alteration_in(rest, bases, _is_word)
    return None if kind is None else Named(None, None, True, text, heading, alters=kind)


def _is_word(text: str) -> bool:
    """Whether a text of a few letters is a word or a unit, not the symbol of a quantity."""
    if len(text) < 2:
        return text in ("h", "d")
    return (quantities_of(text) != () and len(text) > 2) or _known(text)[1] is not None


def _outside(text: str, heading: str) -> Iterable[Named]:
    """Units in a text without brackets: behind ``in``, a slash or comma, or among the words."""
    if _STEP_BEFORE.search(text) is not None:
        text = text.replace("_", " ")
    for found in _IN.finditer(text):
        words = text[found.end() :].split()
        for count in range(min(4, len(words)), 0, -1):
            given = " ".join(words[:count]).strip(",;:")
            unit, base = _known(given, small=True)
            if unit is not None:
                label = " ".join([*text[: found.start()].split(), *words[count:]]) or heading
                yield Named(unit, base, len(given) > 1, given, label)
                further = _known(words[count + 1], small=True) if len(words) > count + 1 else (None, None)
                if further[1] == base and words[count].casefold() in _AND:
                    yield Named(*further, True, words[count + 1], label)  # "in h und min"
                return
            if _is_no_unit(given):
                yield Named(None, None, True, given, heading)
                return
    unit, base = _known(text, small=True)
    if unit is not None and base in BASES and len(text) > 1:
        yield Named(unit, base, False, text, heading)
        return
    words = text.split()
    if len(words) > 1 and (one := _among(words, heading)) is not None:
        yield one
        rest = [word for word in re.split(r"[\s/,;|]+", one.label) if len(word) > 1]
        others = [(word, *_known(word, small=True)) for word in rest] if one.base in _SIZES else []
        yield from (Named(unit, base, False, word, heading) for word, unit, base in others if base == one.base)
        return
    for found in _BEHIND.finditer(text):
        given = text[found.end() :]
        unit, base = _known(given, small=True)
        if "_" in found[0] and _is_symbol(given, base, text[: found.start()]):
            return
        if unit is not None or _is_no_unit(given):
            yield Named(unit, base, unit is None, given, text[: found.start()].rstrip() or heading)
            return
    if len(words) > 1 and _VALUE_BEFORE.search(words[-2]) is None:
        unit, base = _known(words[-1], small=True)
        if unit is not None and not _is_symbol(words[-1], base, " ".join(words[:-1])):
            yield Named(unit, base, False, words[-1], " ".join(words[:-1]))


def _is_symbol(letter: str, base: str | None, before: str) -> bool:
    """Whether ``h`` or ``min`` is no unit, but an index or the height in ``delta_h``: no word before it means time."""
    return (len(letter) == 1 or letter == "min") and base == "day" and not {"time", "stage"} & {*quantities_of(before)}


def _among(words: list[str], heading: str) -> Named | None:
    """The longest unit of one to four words anywhere; single letters are symbols, ``in`` joins words."""
    for count in (4, 3, 2, 1):
        for start in range(len(words) - count, -1, -1):
            given = " ".join(words[start : start + count]).strip(",;:")
            if (len(given) < 2 and given not in "%‰") or given.casefold() == "in" or given[:1] in "/,-–|":
                continue
            if start and _VALUE_BEFORE.search(words[start - 1]) is not None:
                continue
            unit, base = _known(given, small=True)
            if unit is not None and base not in BASES and _SYMBOL_OVER.match(given) is not None and start:
                given = given[2:]  # "Zeit t/min" is a time in min, as physicists write it
                unit, base = _known(given, small=True)
            if unit is not None:
                label = " ".join(words[:start] + words[start + count :]).strip(" ,;:/-–|_") or heading
                return Named(unit, base, False, given, label)
            if count == 1 and _is_no_unit(given):
                return Named(None, None, True, given, heading)
    return None


def is_unit(text: str) -> bool:
    """Whether a text is a unit of any dimension, or stands for the steps of an instrument."""
    return _known(" ".join(text.split()))[0] is not None or _is_no_unit(text)


def _is_no_unit(text: str) -> bool:
    """Whether a word stands for readings in steps of an instrument, which only its calibration makes a unit."""
    return _STEPS.fullmatch(text) is not None


@functools.lru_cache(maxsize=4096)
def _known(text: str, small: bool = False) -> tuple[str | None, str | None]:
    """A unit as a problem file writes it, and the base of its dimension, any.

    ``small``: only factors below 1, and a 1 alone is not a unit.
    """
    text = _SQUARE.sub(r"\1^2", in_signs(text.strip()))
    text = _EXPONENT.sub("^", text).translate(_RAISED)
    if not text or len(text) > 40 or (small and text == "1"):  # "Sensor 1"
        return None, None
    factor = ""
    unit = _spelled(text)
    found = _FACTOR.fullmatch(text) if unit is None else None
    if found is not None:
        value, below_1 = _factor(found["factor"]), _SMALL.match(text) is not None
        if value and not found["unit"] and below_1 and not small:
            return {"0.01": "%", "0.001": "permille"}.get(value, f"{value} dimensionless"), "dimensionless"
        unit = _spelled(found["unit"])
        if unit == "dimensionless" or (small and not below_1) or not value:
            return None, None
        factor = f"{value} "
    if unit is None:
        return None, None
    try:
        return factor + unit, base_unit(unit)
    except UnitError:
        return None, None


def _factor(text: str) -> str:
    """A factor as a decimal number: ``1/100``, ``10^-2``, ``0,01`` and ``1e-2`` are all 0.01."""
    plain = re.sub(r"^1?\s?[x×*·]\s?", "", text.replace("−", "-").replace(",", ".")).replace(" ", "")
    if "/" in plain:
        value = 1.0 / float(plain.partition("/")[2])
    elif (power := re.fullmatch(r"10\^?(-\d)|10\^(\d)", plain)) is not None:
        value = 10.0 ** int(power[1] or power[2])
    else:
        value = float(plain)
    larger = value in (10.0, 100.0, 1000.0) and not text.isdigit()  # "q [100 kPa]": of the test at that pressure
    return f"{value:.12f}".rstrip("0").rstrip(".") if 1e-6 <= value < 1.0 or larger else ""


def _spelled(text: str) -> str | None:
    """A unit without a factor in the words of the registry; None for what is none."""
    plain = re.sub(r"(?<=[A-Za-z])\s+(?=[A-Za-z]{1,3}\^?-[123]$)", "*", text.strip().rstrip(".:"))
    plain = plain.replace("·", "*").replace("^", "").replace("**", "")
    if _NUMBERED.search(plain) is not None:
        return None
    letter = len(plain) == 1 and plain.isupper() and plain not in "DHS"  # a symbol
    for given in (plain, *(() if plain in CASE_MATTERS else (plain.casefold(),))):
        if given in ALIASES and not letter:
            return ALIASES[given]
    spelled = re.sub(r"(?<=[A-Za-z])(?=-?\d)", "^", re.sub("[µμ](?=[a-zA-Z])", "u", plain))
    spelled = re.sub(r"(?<![A-Za-z])(kp|kgf)(?![A-Za-z])", "kgf", spelled)
    atoms = re.findall(r"[A-Za-z_%°‰]+(?:\^2O)?", spelled)
    if (
        not atoms
        or any(atom not in ATOMS for atom in atoms)
        or re.fullmatch(r"[A-Za-z_%^0-9/*().\- ]+", spelled) is None
    ):
        return None
    if " " in spelled or re.match(r"\d", spelled):
        return None
    return spelled


def number_with_unit(cell: str) -> tuple[str, str] | None:
    """Split a cell such as ``12,5 %`` into the number and what stands behind it; None for what is not such a cell."""
    found = _VALUE.fullmatch(cell) if len(cell) <= 60 and cell[-1:].isascii() | (cell[-1:] in "°‰²³") else None
    if found is None or _known(found[2])[0] is None:
        return None
    return found[1], found[2]


def units_in_comments(comments: str) -> dict[str, str]:
    """Return what comments such as ``# x in min, y in mm`` say, by heading."""
    return dict(_COMMENT.findall(comments))
