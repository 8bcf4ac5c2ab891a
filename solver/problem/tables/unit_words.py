"""The words for units that laboratories write, German and English."""

from __future__ import annotations

import functools
import re

__all__ = ["ALIASES", "ATOMS", "CASE_MATTERS", "PARTS", "SUMS", "compiled", "in_signs"]

_WORDS = {
    "s": "s sec secs second seconds sek sekunde sekunden seg segundos sekund",
    "min": "min mins minute minutes minuten minutos minut minuter",
    "h": "h hr hrs hour hours std stunde stunden heures horas godz godzin tim timmar",
    "day": "d days tag tage tagen tg jours días dni dygn",
    "week": "weeks woche wochen",
    "month": "months monat monate",
    "year": "a years jahr jahre yr yrs",
    "ms": "msec msecs millisecond milliseconds millisekunde millisekunden",
    "um": "µm μm my mü micron microns mikrons micrometer micrometers micrometre micrometres mikrometer mikron micras",
    "mm": "mm millimeter millimeters millimetern millimetre millimetres",
    "cm": "cm centimeter centimeters centimetre centimetres zentimeter zentimetern",
    "m": "meter meters metern metre metres",
    "inch": "inches zoll",
    "thou": "mil mils thou",
    "ft": "feet foot",
    "Pa": "pascal",
    "mH2O": "mh2o mws",
    "cmH2O": "cmh2o cmws",
    "ftH2O": "fth2o",
    "inH2O": "inh2o",
    "mmHg": "mmhg",
    "kPa": "kpa kilopascal kilopascals",
    "MPa": "mpa megapascal megapascals",
    "bar": "bar",
    "torr": "torr",
    "ksi": "ksi kips/in2",
    "kN/m^2": "kn/m2 kn/qm kilonewton/m2",
    "MN/m^2": "mn/m2 mn/qm",
    "N/mm^2": "n/mm2",
    "kgf/cm^2": "kg/cm2 kgf/cm2 kp/cm2 kg/qcm kp/qcm ksc",
    "kgf/m^2": "kg/m2 kgf/m2 kp/m2",
    "kgf/mm^2": "kg/mm2 kgf/mm2 kp/mm2",
    "tf/m^2": "t/m2 to/m2 tf/m2 mp/m2 tsm tonf/m2 ton/m2 tons/m2 tonne/m2 tonnes/m2",
    "lbf/ft^2": "psf lb/ft2 lbf/ft2 lbs/ft2",
    "kip/ft^2": "ksf kips/ft2",
    "force_ton/ft^2": "tsf ton/ft2 tons/ft2 tonf/ft2",
    "psi": "psi lb/in2 lbf/in2 lbs/in2",
    "degree": "° deg degrees grad altgrad",
    "rad": "radian radians",
    "%": "percent prozent proz pct vol.-% vol-% vol.% vol% v.-% vh v.h",
    "permille": "‰ promille permil o/oo",
    "um/m": "µm/m μm/m µε με microstrain ustrain µstrain",
    "dimensionless": "- – — -- 1 dimensionslos unitless decimal dezimal fraction",
}
ALIASES = {word: unit for unit, words in _WORDS.items() for word in words.split()} | {
    "per mille": "permille",
    "mm hg": "mmHg",
    **{f"{unit} {water}": f"{unit}H2O" for unit in ("m", "cm") for water in ("ws", "h2o", "h₂o")},
    **{f"{unit} {water}": f"{unit}H2O" for unit in ("ft", "in") for water in ("h2o", "h₂o")},
}
"""What laboratories write, in lower case, and what the registry of units (or a problem file) calls it."""

CASE_MATTERS = frozenset(("mPa", "Mm"))
"""Other units in small letters."""

ATOMS = frozenset(
    re.findall(
        r"\S+",
        "nm um mm cm dm m km in inch thou ft s ms min h hr d day week month year Pa hPa kPa MPa GPa bar mbar atm torr "
        "mH2O cmH2O mmHg N daN kN MN dyn kgf tf lbf kip force_ton psi ksi g kg mg Mg t degree deg rad mrad permille "
        "ppm ml cl l A mA V mV kV Hz % dimensionless",
    )
)
"""What a unit may be made of: the registry knows many words (rod, point, e) that mean something else in headings."""

PARTS = (
    r"zehntel|hundertstel|tausendstel|tenths?\b|hundredths?\b|thousandths?\b"
    r"|(?:1\s?/\s?)?10{1,6}\s?-?(?:stel|tel|th[s]?)"
)
"""Words for parts of a unit, as a regular expression."""

_QUANTITY = r"[∆Δδ]?(?:[a-zα-ω]{1,3}|sigma|eps(?:ilon)?|gamma)_?[\d₀-₉]?['’′]?"
_NUMBER = r"\d+(?:[.,]\d+)?"
SUMS = (
    rf"(?-i:(?<![\w\-+·*.,])(?:{_QUANTITY}\s*\+\s*(?:{_QUANTITY}|{_NUMBER})|{_QUANTITY}\s*[·*]\s*[A-Zα-ω](?!\w)"
    rf"|(?:(?<=^)|(?<=\()){_NUMBER}\s*[-+−–]\s*{_QUANTITY})(?![\w\-+])|(?<=[a-zäöüß])\s?\+\s?{_NUMBER})"
)
"""Sums and products of symbols, as a regular expression: ``p0+10``, ``σ·A``, ``100-ε``; ``σ1-σ3`` is the deviator."""

_PART = re.compile(rf"^({PARTS})(?: of(?: an?)?)?[ -]?(?=\S)", re.IGNORECASE)
_DIVISORS = {"zehnt": 10, "hunde": 100, "tause": 1000, "tenth": 10, "hundr": 100, "thous": 1000}
_PREFIX = re.compile(r"^(milli|[cz]enti|mi[ck]ro|kilo|mega)[ -](?=[^\W\d_])", re.IGNORECASE)
_PREFIXES = {"mil": "m", "zen": "c", "cen": "c", "mik": "u", "mic": "u", "kil": "k", "meg": "M"}


@functools.cache
def compiled(pattern: str) -> re.Pattern[str]:
    """A long pattern in any case; processes that read no files never compile it."""
    return re.compile(pattern, re.IGNORECASE)


def in_signs(text: str) -> str:
    """A unit with signs for its first word, where that is a part or a prefix.

    >>> in_signs("100stel mm"), in_signs("hundredths of a mm"), in_signs("milli m")
    ('1/100 mm', '1/100 mm', 'mm')
    """
    text = _PART.sub(lambda found: f"1/{_divisor(found[1].casefold())} ", text)
    return _PREFIX.sub(lambda found: _PREFIXES[found[1][:3].casefold()], text)


def _divisor(part: str) -> str:
    return str(_DIVISORS.get(part[:5]) or re.sub("[^0-9]", "", part.rpartition("/")[2]))
