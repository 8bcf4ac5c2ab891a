"""What a column holds, from the words of its heading as laboratories write them, German, English and some others."""

from __future__ import annotations

import re
from collections.abc import Iterable

from geoswarm.solver.problem.tables.unit_words import PARTS, compiled

__all__ = ["dimension_of", "factor_in", "is_column_of_factors", "is_heave", "is_load", "offset_in", "quantities_of"]

_HEAVE = (
    r"(?:(?<![^\W\d_])(?:an|auf|boden|sohl)?hebung(?:en)?|(?<![^\W\d_])(?:heave|heaving|uplift)|(?:auf)?quell(?:ung|dehnung"
    r"|hebung|verformung|ma(?:ß|ss))|schwell(?:ung|dehnung|hebung)"
    r"|(?<![^\W\d_])swell(?:ing)?(?! ?(?:pressure|stress|index))|gonflement|soul[èe]vement"
    r"|hinchamiento|pęcznieni\w|svällning|hävning)"
    r"(?![^\W\d_])(?!\s*\(?[=:]?\s*(?:[-−–]\s*(?:\)|$)|neg))"  # "Setzung, Hebung (-)" is a settlement
    r"|(?:[-−–]|n[ée]g\w*) ?=? ?(?:nach unten|down|vers le bas)|(?:nach unten|down(?:wards?)?) ?=? ?(?:neg|[-−–])"
    r"|(?:\+|pos\w*) ?=? ?(?:nach oben|up)|(?:nach oben|up(?:wards?)?) ?=? ?(?:pos|\+)"
)
_RULES: tuple[tuple[str, tuple[str, ...]], ...] = (
    (
        r"probe(n?(nummer|bezeichnung|nr))?\b|prüfkörper|versuch(s?nummer)?\b|bohrung|borehole"
        r"|(specimen|sample)s?\b(?! ?(air|water|volume|height|length|diameter|area|mass|weight))"
        r"|^test( ?(id|no\.?|nr\.?|number|name))?$",
        ("specimen",),
    ),
    (r"(?<![a-z])rate\b|(strain|dehnungs|verformungs|setzungs|verschiebungs)rate\b|geschwindigkeit|velocity|speed", ()),
    (r"uhrzeit|time of day|\bclock", ("clock",)),
    (r"bemerkung|anmerkung|kommentar|remark|comment", ("remark",)),
    (r"gewicht(ung)?\b|\bweights?\b", ("weight",)),
    (_HEAVE, ("heave",)),
    (
        r"höhe\b|hoehe\b|\bhauteur\b|wysokość|\baltura\b|\bhöjd(?:en)?\b"
        r"|\bheight\b(?! change)(?<!change in height)(?<!change of height)",
        ("height",),
    ),
    (r"stufe|\bstages?\b|load(ing)? step|lastschritt|\bpalier|\bétape\b|\betapa\b|\bescalón|\bstopień", ("stage",)),
    (
        r"überdruck|ueberdruck|excess pore|excess pwp|sur(?:pression)|exceso de presión|nadciśnieni|porövertryck"
        r"|^(delta|[dδ∆]) ?u$",
        ("excess_pore_pressure", "pore_pressure"),
    ),
    (
        r"porenwass|porendruck|pore[ -]?(water[ -]?)?pressure|\bpwp\b|piezomet|^u( ?w)?$|pression interstitielle"
        r"|presión (de poros|intersticial)|ciśnieni\w* porow|por(vatten)?tryck",
        ("pore_pressure",),
    ),
    (
        r"zeit(en)?\b|\btime\b|dauer\b|duration|elapsed|datum|\bdate\b|^tage?$|^days?$|^t$|\btemps\b|\bdurée\b|\btiempo|\bczas"
        r"|\btid(en)?\b",
        ("time",),
    ),
    (
        r"porenzahl|void[ _-]ratio|^e$|indice des vides|índice de (vacíos|huecos|poros)|relación de vacíos"
        r"|wskaźnik porowatości"
        r"|\bportal(et)?\b",
        ("void_ratio", "e"),
    ),
    (r"stress[ _-]ratio|spannungsverhältnis|^q ?/ ?p|^η$", ("stress_ratio",)),
    (
        r"radial\w*[ _-]?(dehnung|stauchung|strain)|querdehnung|(horizontal|lateral) strain|^(ε|eps(ilon)?|e) ?[r3]$",
        ("radial_strain",),
    ),
    (r"radial\w*[ _-]?(verschiebung|verformung|displacement)|durchmesser(ände)", ("radial_displacement",)),
    (
        r"volum\w*[ _-]?(dehnung|stauchung|strain|verformung|änderung|töjning)|(déformation|deformación) volum"
        r"|odkształceni\w* obj"
        r"|\bvol\.? strain|^(ε|eps(ilon)?) ?v(ol)?$",
        ("volumetric_strain",),
    ),
    (
        r"scherdehnung|schubverzerrung|gleitung|scherverformung|shear[ _-]?strain|^(γ|gamma)$|^(ε|eps(ilon)?) ?q$",
        ("shear_strain",),
    ),
    (r"scherspannung|schubspannung|shear[ _-]?stress|^(τ|tau)$", ("shear_stress",)),
    (r"deviator|dewiator|déviat|desviador|^q$|^(σ|sigma) ?d(ev)?$|^(σ|sigma) ?[1av] ?[-−–] ?(σ|sigma) ?[3r]$", ("q",)),
    (r"mittlere \w*[ ]?(haupt)?spannung|mean (effective )?stress|^p['’′]?$", ("p", "mean_effective_stress")),
    (
        r"(horizontal|seiten|radial|zell)\w*[ ]?(spannung|spg\b|druck)"
        r"|(horizontal|lateral|radial|cell|confining) (stress|pressure)|^(σ|sigma) ?['’′]?[23hr]['’′]?$",
        ("lateral_stress", "radial_stress", "horizontal_stress"),
    ),
    (r"ruhedruckbeiwert|^k ?0$", ("K0",)),
    (
        r"(effektive|wirksame) \w*[ ]?(vertikal|normal)?spannung|effective (vertical )?stress",
        ("effective_stress", "normal_stress", "axial_stress"),
    ),
    (r"normalspannung|normal stress", ("normal_stress",)),
    (
        r"(bezogene|spezifische|relative) (setzung|verformung|zusammendrückung)|dehnung|stauchung|strain|déformation"
        r"|deformación|odkształceni|töjning"
        r"|^(ε|eps(ilon)?)",
        ("axial_strain", "vertical_strain"),
    ),
    (
        r"setzung|settlement|zusammendrückung|höhenänderung|tassement|\basiento|asentamiento|osiadani|sättning"
        r"|(change of|change in) height|^s$|^(delta|[dδ∆]) ?h\d?$",
        ("settlement", "axial_displacement"),
    ),
    (
        r"verformung|verschiebung|\bweg\b|wegaufnehmer|displacement|deformation|\bdial|gauge|messuhr|ablesung"
        r"|déplacement|desplazamiento|przemieszczeni|förskjutning",
        ("settlement", "axial_displacement"),
    ),
    (
        r"spannung|spg\b|stress|auflast|\blast\b|^(σ|sigma)|contrainte|esfuerzo|\btensión|naprężeni|obciążeni|spänning|\bcharge\b"
        r"|\bcarga\b",
        ("axial_stress", "normal_stress", "effective_stress"),
    ),
)
"""Patterns of headings and what they mean, the likeliest first; the first pattern that is found counts."""

_KNOWN = tuple((re.compile(pattern), meant) for pattern, meant in _RULES)
_RISES = re.compile(_HEAVE)
_WORD_BEGINS = re.compile("(?<=[a-z])(?=[A-Z])")  # in ShearStrain
_LONGEST = 200


def quantities_of(label: str) -> tuple[str, ...]:
    """What a heading without its unit may stand for, in the words of series; the likeliest first.

    >>> quantities_of("Setzung")
    ('settlement', 'axial_displacement')
    >>> quantities_of("Zeit seit Laststufe")
    ('stage',)
    """
    plain = _plain(label)
    return next((meant for pattern, meant in _KNOWN if pattern.search(plain)), ())


_DIMENSIONS = (
    ("day", r"time"),
    ("m", r"settlement|\w+_displacement"),
    ("dimensionless", r"\w+_strain"),
    ("kPa", r"\w+_stress|\w*pore_pressure|[pq]"),
)
_LOADS = frozenset(("axial_stress", "normal_stress", "effective_stress"))


def dimension_of(quantity: str) -> str | None:
    """Base unit of a quantity, in the words of :func:`quantities_of`; None where that is open."""
    return next((base for base, words in _DIMENSIONS if re.fullmatch(words, quantity)), None)


def is_load(quantities: Iterable[str]) -> bool:
    """Whether these words mean the load of a stage."""
    return not _LOADS.isdisjoint(quantities)


def is_heave(label: str) -> bool:
    """Whether a heading is that of a movement upwards, which as a settlement has the other sign."""
    return _RISES.search(_plain(label)) is not None


def _plain(label: str) -> str:
    return " ".join(_WORD_BEGINS.sub(" ", label.replace("_", " ")).split())[:_LONGEST].casefold()


_FACTOR = r"(?:10\s?(?:\^|\*\*)?\s?[-−]\s?\d|1\s?[/:]\s?10+|\d+(?:[.,]\d+)?(?:e[-+]?\d+)?|[.,]\d+)"
_SCALED_LINE = (
    r"(?:(?<![^\W\d_])(?<!safety )(?<!shape )(?<!form )(?<!gauge )(?<!time )(?:(?:umrechnungs|skalierungs|mess(?:wert)?"
    r"|multiplikations|kalibrier(?:ungs)?|eich|scale|scaling|skal)[- ]?)?(?:fa[ck]t(?:o|eu)r(?:s|en|es)?"
    r"|mnożnik|współczynnik|coefficiente?|coeficiente)"
    r"(?![^\W\d_])"
    r"(?! of safety| (?:der )?sicherheit)"
    r"|(?<![^\W\d_])(?:skala|skalierung|skaliert|scal(?:e|ing|ed)|ma(?:ß|ss)stab|échelle|escala|skala"
    r"|mult(?:iply|ipli\w+)|divi[ds]\w+|exponent|zehnerpotenz"
    r"|(?:(?:dial|gauge|ring|machine|cell|messuhr|geräte?|geraete|kalibrier|eich|aufnehmer)[- ]?)"
    r"(?:constant|[ck]onstante?|stała)|constante d[eu]l? \w+)(?![^\W\d_]))"
    rf"\D{{0,40}}?({_FACTOR})(?![\d.,])"
    rf"|(?:mit|um|durch|by|par|por|przez|med)\s+({_FACTOR})\s+(?:multipli|divi|geteilt|skaliert|scaled|mnoż|dziel)\w*"
    rf"|({_FACTOR})\s*[^\W\d]{{1,3}}\s?/\s?(?:div|digit|count|tick|skt|teilstrich|działk)\w*"
    rf"|(?:(?<![\d.,\s])\s*|^)(?:[×*·]|(?<![^\W\d_])(?:x|mal|times)(?![^\W\d_]))\s*({_FACTOR})\s*\W?$"
    rf"|(?<![^\W\d_])(?:(?:mess)?werte?|values|readings|angaben)\s+(?:(?:in|sind|are)\s+(1\s?/\s?10+|0?[.,]0*1|{PARTS})\s*\W?$"
    rf"|(?:sind |are )?(?:[×*·/]|(?:x|mal|times|durch)(?![^\W\d_]))\s*({_FACTOR}))"
    rf"|^\W*(?:kalibrier|eich|calibration)[^\W\d]*\W+({_FACTOR})\s*$"
    rf"|^\W*1\s*(?:div|digit|count|tick|sk(?:t|alen)|(?:teil)?strich|działk|divisi|delstreck|graduation)[^\W\d_]*\.?\s*[=≙:]\s*({_FACTOR})\s*[^\W\d]"
)
"""A line that scales the numbers of a table: ``Faktor: 0,01``, ``multiply by 0.01``, ``Werte x 0,01``."""


def factor_in(line: str) -> str | None:
    """The factor that a line outside a table names; None for none, and for 1. ``1 div = 0.01 mm`` names one, too.

    >>> factor_in("Skalierung (Setzung): 1/100"), factor_in("scale factor 1.0")
    ('1/100', None)
    """
    found = compiled(_SCALED_LINE).search(line)
    if found is None:
        return None
    rest = line[found.end() :]
    more = re.findall(_FACTOR, rest) if re.fullmatch(r"[\s\d.,;eE+-]*", rest) else []  # a factor for each channel
    factors = [next(filter(None, found.groups())), *more]
    return next((one for one in factors if re.fullmatch(r"0*1(?:[.,]0*)?", one) is None), None)


_OFFSET_LINE = re.compile(
    r"(?:(?<![^\W\d_])(?:offset|null(?:punkt|ablesung|wert|lage)|anfangs(?:wert|ablesung)|tar[ea]|bias"
    r"|(?:zero|initial|start(?:ing)?)[ -](?:reading|point|value|offset))(?![^\W\d_])|^\W*(?:zero|null)(?=\W*\d))"
    r"\D{0,40}?[-+−]?(\d+(?:[.,]\d+)?|[.,]\d+)",
    re.IGNORECASE,
)


def offset_in(line: str) -> str | None:
    """The offset of a gauge that a line outside a table names; None for none, and for 0.

    >>> offset_in("Nullablesung [mm]: 12,31"), offset_in("Offset;0,0")
    ('12,31', None)
    """
    found = _OFFSET_LINE.search(line)
    if found is None:
        return None
    rest = line[found.end() :]
    more = re.findall(_FACTOR, rest) if re.fullmatch(r"[\s\d.,;eE+-]*", rest) else []  # an offset for each channel
    return next((one for one in (found[1], *more) if one.strip("0.,")), None)


_COLUMN_OF_FACTORS = re.compile(
    r"(?:(?:umrechnungs|skalierungs|mess(?:wert)?|multiplikations|kalibrier(?:ungs)?|eich|scale|scaling|conversion"
    r"|calibration)[ -]?)?(?:fa[ck]tor(?:s|en)?|multiplikator|multiplier|skalierung|scale|gain"
    r"|verst(?:ä|ae)rkung|amplification"
    r"|ma(?:ß|ss)stab|exponent|zehnerpotenz|power of (?:ten|10)|10\s*(?:\^|\*\*))(?![^\W\d_])(?! of safety)",
    re.IGNORECASE,
)


def is_column_of_factors(label: str) -> bool:
    """Whether a heading is that of factors of other columns: of the quantity that it names, or of all.

    >>> [is_column_of_factors(one) for one in ("Umrechnungsfaktor Setzung", "Gain", "safety factor")]
    [True, True, False]
    """
    return _COLUMN_OF_FACTORS.match(label.strip()) is not None
