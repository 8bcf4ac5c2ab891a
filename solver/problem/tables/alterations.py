"""What makes the numbers of a column another quantity than the unit beside it says: a factor, a function, a sum."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Literal, TypeAlias

from geoswarm.solver.problem.tables.unit_words import PARTS, SUMS, compiled

__all__ = ["ALTERED", "Alteration", "alteration_in", "change_in", "is_switch", "referred_apart"]

Alteration: TypeAlias = Literal["factor", "offset", "sign", "function", "increment", "sum", "absolute", "share"]

ALTERED: dict[Alteration, str] = {
    "factor": "has a factor",
    "offset": "may have an offset",
    "sign": "has a sign",
    "function": "has a function",
    "increment": "is a step",
    "sum": "is a sum or a product",
    "absolute": "is an absolute pressure",
    "share": "is a share of full scale",
}
"""What is said of a column."""

_SCALED = (
    r"[×*·÷]\s*\d|(?<![^\W\d_])x\s*(?:\d\d|0[.,])|\d+\s*[×*·]|(?<![\d.,])10+\s*x|10\s*(?:\^|\*\*|[⁻²³⁴⁵⁶⁷⁸⁹])"
    r"|(?<!\w)1e\d|(?<![^\W\d_])(?:\d[\d.,]*)?e[-+]\d|(?<![\w.,/])1\s?/\s?10+(?!\d)|(?<![\d.,])0?[.,]0*1(?![\d.,])|/[₀-₉]"
    rf"|(?<!\w)(?:{PARTS})(?![^\W\d])|(?<![\d:])(?!1\s?:\s?1(?!\d))(?:\d+\s?:\s?1|1\s?:\s?\d+)(?![\d:])|(?<![\d/])\s*/\s*10+(?![\d/])|fa[ck]tor\s*[=:]?\s*\d|(?<!\w)[½⅓¼¾]"
    r"|\0[\])}]?\s?/\s?\d|^\d\s?/\s?\d\s*(?=[^\W\d])|^(?:halbe|doppelte|half|double|twice)[rns]?\s"
    r"|(?:\d+\s?-?|zehn|hundert|tausend)fach(?![^\W\d])|(?:\d+\s?-?|ten|hundred)fold|überhöht|exaggerated"
    r"|halbiert|halved|verdoppelt|doubled|(?<![^\W\d_])(?:scaled?|skaliert)(?![^\W\d_])|ma(?:ß|ss)stab"
    r"|[(\[]\s*x\s?(?!1\W)\d|(?<![\w.,])(?!1\D)\d+(?:[.,]\d+)?\s?x\s*[)\]]|(?<![^\W\d_])(?:(?:dixi|centi|milli)[èe]mes?"
    r"|(?:ti|hundr[ae]|tusen)dels?|(?:d[ée]ci|cent[ée]si|mil[ée]si)mas?|(?:setn|tysięczn|dziesiąt)\w*)(?![^\W\d_])"
    r"|[^\W\d_]{3,}\s(?:d[ei]|of|van|von|av)\s\0"  # "centesimi di mm"
)
_OF_FULL_SCALE = r"\0[\])]?\s?(?:of )?(?:full[ -]?scale|fs(?!\w))"
_SHARE = re.compile(_OF_FULL_SCALE, re.IGNORECASE)
_ALTERED = (
    rf"(?:{_SCALED}|{SUMS}|{_OF_FULL_SCALE}"
    r"|[√∛]|(?<![^\W\d_])(?:sqrt|(?:quadrat)?wurzel|(?:square ?)?root|log(?:arithm\w*)?|lg|ln|exp)"
    r"(?![^\W\d_])|\0[\])}]?\s(?:per|pro|je|par)\s|^1\s*/\s*(?=[^\W\d])|(?<=[^\W\d])[²³]|(?<=\))[²³]|\^|e\d\s*\0|(?<!\w)hh?:)[^\s\0\[\](){}<>]*"
)
"""What makes numbers another quantity than the unit beside it says: ``√t [min]``, ``q x 10 [kPa]``; \\0 is the unit."""
_ONLY_SCALED = rf"(?:{_SCALED})[^\s\0\[\](){{}}<>]*"
_SCALED_OR_SUM = rf"{_ONLY_SCALED}|{SUMS}"
_SYMBOL = r"[∆Δδ]?[^\W\d_]{1,5}(?:_\w{1,4}|[\d₀-₉]{1,2})?['’′]?"
_MULTIPLE = re.compile(rf"(?:=\s*|^)(?:\d{{1,6}}(?:[.,]\d+)?|\d/\d)(?:\s?({_SYMBOL})|\([^()]*[-+−–][^()]*\))$")
"""All of a heading: ``10q``, ``0.5 s``, ``1/2 q``, ``0.5(s1-s3)``."""
_MEAN = re.compile(r"\([^()\-−–]*\+[^()\-−–]*\)\s*/\s*[23](?!\d)")
_QUOTIENT = re.compile(
    rf"(?<![\w'’′∆Δδ])({_SYMBOL})\s*/\s*({_SYMBOL})(?![\w'’′])|(?:(?<![\w'’′∆Δδ]){_SYMBOL}|\))"
    r"\s*/\s*\d+(?:[.,]\d+)?(?![\d/])"
)
_NORMALISED = re.compile(r"(?<!\w)norm(?:ali[sz](?:ed|é\w*)|alisiert\w*|iert\w*)", re.IGNORECASE)
_SIGN = re.compile(
    r"^[-−–]\s?[^\W\d]\w*|^neg(?:ati(?:ve[rs]?|v))?\.?\s|(?<![^\W\d_])neg(?:ati(?:ve?|v))?\.?$", re.IGNORECASE
)
_UPWARDS = re.compile(r"hebung|heben|heav|swell|quell|zug|tension|suction|saug", re.IGNORECASE)  # what is negative
_RATE = re.compile(r"(?<!\w)[dδ∆]\s?\(?\w{0,4}\)?\s?/\s?[dδ∆]\s?\(?t\)?(?!\w)", re.IGNORECASE)
_INCREMENT = {
    "day": re.compile(r"(?:zeit|time)[ _-]?(?:schritt|inkrement|step|increment|interval)\w*", re.IGNORECASE),
    "m": re.compile(r"\w*zuwachs|(?<![^\W\d_])(?:in[kc]rement\w*|zunahme)", re.IGNORECASE),
}
"""Words for the steps of times and of settlements."""
_ABSOLUTE = re.compile(r"(?<!\w)abs(?:olut(?:e[nrs]?|druck)?)?(?!\w)", re.IGNORECASE)
_REFERRED = re.compile(
    r"(?<![^\W\d_])((?:[kMhm]?Pa|m?bar|psi))(?:\s?\(\s?(?P<brackets>a|g|[üu]|abs\.?|absolute?|gauge|rel(?:ativ)?\.?)\s?\)"
    r"|(?P<glued>[agü])(?!\w)|\s(?P<apart>(?:abs\.?|absolute?|gauge|[agü])(?=\s*(?:[\])}]|$))))",
    re.IGNORECASE,
)
"""A pressure and the one that it counts from: ``kPa(a)``, ``psig``, ``bar abs``."""
_SHARE_INSIDE = re.compile(
    r"([\[(]?)%\s*(?:(?:of )?(?:the )?(?:full[ -]?scale|f\.?s\.?(?![^\W\d_])(?:o\.?)?|range)"
    r"|(?:v\.?|vom )\s?(?:E(?:ndwert)?|MBE?|Messbereich(?:sendwert)?)\b\.?)\s*([\])]?)",
    re.IGNORECASE,
)


def alteration_in(rest: str, bases: set[str | None], is_word: Callable[[str], bool]) -> tuple[Alteration | None, str]:
    """What makes the numbers another quantity, and its text; None where nothing does.

    Parameters
    ----------
    rest
        A heading whose units are \\0.
    bases
        Dimensions of its units, without that of plain numbers.
    is_word
        Whether a few letters are a word or a unit, not the symbol of a quantity.
    """
    rest = _MEAN.sub("", rest)
    sized = bool(bases - {None, "dimensionless"})
    if (altered := compiled(_ALTERED if bases else _SCALED_OR_SUM).search(rest)) is not None:
        return _kind(altered), altered[0].strip(" \0[]()")
    name = " ".join(re.sub(r"[\[({<|]?\0[\])}>|]?|\[.*?\]", " ", rest).split()).rstrip(",;:/")
    sign = _SIGN.search(re.sub(r"[()]", " ", name).strip())
    if sign is not None and _UPWARDS.search(name) is None:
        return "sign", sign[0].strip()
    if (rate := _RATE.search(name)) is not None:
        return "function", rate[0]
    for base, words in _INCREMENT.items():
        if base in bases and (step := words.search(name)) is not None:
            return "increment", step[0]
    if (multiple := _MULTIPLE.search(name)) is not None and not is_word(multiple[1] or ""):
        return "factor", multiple[0].lstrip("= ")
    for one in _QUOTIENT.finditer(name) if bases else ():
        if one[1] is None:
            return "factor", one[0]
        if sized and not (is_word(one[1]) or is_word(one[2])):
            return "function", one[0]
    if not sized:
        return None, ""
    if (normalised := _NORMALISED.search(name)) is not None:
        return "function", normalised[0]
    if "kPa" in bases and (above := _ABSOLUTE.search(name)) is not None:
        return "absolute", above[0]
    return None, ""


def _kind(altered: re.Match[str]) -> Alteration:
    if _SHARE.match(altered[0]) is not None:
        return "share"
    if re.match(rf"\s?\+|{SUMS}", altered[0]):
        return "sum"
    return "factor" if compiled(_ONLY_SCALED).match(altered[0]) else "function"


def referred_apart(heading: str) -> str:
    """A heading in which the unit is apart from what a pressure counts from, or from the full scale of a gauge.

    >>> referred_apart("u [kPa(a)]"), referred_apart("u (psig)"), referred_apart("u [% FS]")
    ('u [kPa] abs', 'u (psi)', 'u [%] FS')
    """
    heading = _SHARE_INSIDE.sub(r"\1%\2 FS", heading)
    found = _REFERRED.search(heading)
    if found is None:
        return heading
    word = found["brackets"] or found["glued"] or found["apart"]
    plain = f"{heading[: found.start()]}{found[1]}{heading[found.end() :]}"
    return f"{plain} abs" if word[0] in "aA" else plain


_GAUGE = (
    r"(?:messuhr\w*|(?:weg|kraft|druck)?aufnehmer\w*|sensor\w*|(?:weg|mess)?geber\w*|messgerät\w*|wegtaster\w*|gauges?|dials?|lvdts?"
    r"|transducers?|gerät\w*|instruments?|devices?|apparatus|capteurs?|comparateurs?|sonda|reloj\w*|czujnik\w*|givare\w*|mätur\w*)"
)
_EXCHANGED = (
    r"(?:\w*(?:getausch|gewechsel|ersetzt|gesetzt|versetz|verschoben|gestellt|justier|bewegt)\w*|neu|replaced|changed|moved|adjusted|swapped"
    r"|shifted|repositioned|bumped|knocked|remplac\w*|déplac\w*|chang[ée]\w*|cambi\w*|reempla\w*|movid\w*|wymien\w*|przestaw\w*"
    r"|przesun\w*|bytt\w*|byt\w*|flytt\w*)"
)
_NEW = (
    r"(?:neue[rsmn]?|new|replaced|changed|another|andere[rsmn]?|nouve\w+|nuev\w+|now\w+|ny[at]?|bytt?|wechsel|tausch|wymiana|zmiana"
    r"|changement|cambio|umstellung|changing|change of)"
)
_RANGE = (
    r"(?:(?:mess|anzeige)?bereich\w*|range|plage|gamme|rango|zakres\w*|(?:mät)?område\w*|einheit(?:en)?|units?|unités?|unidad(?:es)?"
    r"|jednostk\w*|enhet(?:en|er)?|skala|skalierung|scale|scaling|échelle|escala|skal[aęi]|maßstab|gain|verstärkung|sensitivity"
    r"|empfindlichkeit|faktor|factor|facteur|calibration|kalibrierung)"
)
_SWITCHED = (
    r"(?:\w*(?:geschaltet|gewechselt|geändert|gestellt)|changed?|switched|chang[ée]e?s?|modifi\w*|cambi\w*|zmien\w*|zmian\w*|ändra\w*|bytt?"
    r"|now|jetzt|[x×*:]\s*\d+)"
)
_ZEROED = (
    r"re-?set\w*|re-?zero\w*|zeroe?d\w*|zeroing|(?:new|shifted?|changed?) (?:zero|origin|datum)"
    r"|zero (?:again|shifted?|changed|reset|reading|offset|point)|(?:re)?set (?:back )?to (?:zero|0)(?![.,\d])"
    r"|tar(?:ed|ing|iert\w*|ado|owan\w*)|genullt"
    r"|null(?:ung|punkt\w*|abgleich\w*|gestellt|gesetzt|setzen|stellen|stellung|ablesung\w*|messung\w*)"
    r"|(?:auf|zu) (?:null|0) (?:ge|zurück)\w+|(?:zurück|neu ?(?:ein)?|nach|um)gestellt|(?:zu)?rückgesetzt"
    r"|rückstellung|neu (?:ein)?gestellt|neu (?:justiert|kalibriert|gestartet)|neustart\w*|neue[rs]? bezug\w*"
    r"|(?:new|gauge|zero|neuer?|anderer?) offset|offset (?:now|set|changed|reset|geändert|neu)"
    r"|(?:re)?mise? (?:à|a) (?:zéro|0)|remis à (?:zéro|0)|réinitialis\w*|puest\w+ a (?:cero|0)|reinici\w*|\w*zerowa\w*"
    r"|nollst\w+|nolla[dt]\w*|nollning\w*|omnoll\w*|återställ\w*|restart\w*|recalibrated|re-?gauged"
)
_BETWEEN = r"\W+(?:[\w.]+\W+){0,3}?"
_CHANGE = (
    rf"(?<![^\W\d_])(?:{_GAUGE}{_BETWEEN}{_EXCHANGED}|{_NEW}{_BETWEEN}(?:{_GAUGE}|{_RANGE})|{_RANGE}{_BETWEEN}{_SWITCHED}"
    rf"|{_SWITCHED}{_BETWEEN}{_RANGE}|{_ZEROED})(?![^\W\d_])"
)
_SWITCH = (
    r"(?<![^\W\d_])(?:ab|von|from|since|seit|now|jetzt|nun|hier|here|below|following|\w*folgend\w*|umgestellt"
    r"|umgeschaltet|\w*gewechselt|\w*wechsel|geändert|änderung|chang\w+|switch\w*|à partir|a partir|dès|désormais"
    r"|maintenant|ahora|desde|od|odtąd|teraz|zmian\w*|zmienion\w*|från|härifrån|byt\w*|ändr\w*|onwards?|hereafter|danach|thereafter)(?![^\W\d_])"
)


def change_in(text: str) -> bool:
    """Whether a note says that the zero, the range or the gauge of readings changed.

    >>> change_in("Gauge reset"), change_in("Messuhr neu gestellt"), change_in("Laststufe 2")
    (True, True, False)
    """
    return compiled(_CHANGE).search(text) is not None


def is_switch(text: str) -> bool:
    """Whether a note says that something holds from a place on: ``ab hier``, ``from now on``."""
    return compiled(_SWITCH).search(text) is not None
