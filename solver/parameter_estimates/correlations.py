"""Published correlations between index properties and quantities that laboratories know."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from geoswarm.solver.index_properties import IndexProperties, SoilClass

__all__ = ["COMPRESSIBILITY", "CORRELATIONS", "Correlated", "PublishedCorrelation", "SAND", "STRENGTH", "correlated"]


@dataclass(frozen=True, slots=True)
class PublishedCorrelation:
    """A correlation.

    Parameters
    ----------
    quantity
        Symbol of what it gives, as in the laboratory's terms.
    equation
        As text.
    of
        The quantity from the index properties of ``valid``, in their order.
    valid
        Range of each of them in which the source gives it: w_L, I_P, w_n and D_r in per cent, e_0, G_s.
    soils
        What it holds for, in words.
    source
        Where it was published.
    unit
        Of the quantity.
    scatter
        Published scatter: relative where ``relative``, else in the unit of the quantity; None: none is published.
    classes
        Classes of soil that it is for; empty: any, and those not given.
    """

    quantity: str
    equation: str
    of: Callable[..., float]
    valid: Mapping[str, tuple[float, float]]
    soils: str
    source: str
    unit: str = ""
    scatter: float | None = None
    relative: bool = True
    classes: tuple[SoilClass, ...] = ()

    @property
    def scatter_in_words(self) -> str:
        """Its scatter, or nothing."""
        if self.scatter is None:
            return ""
        return f"± {100.0 * self.scatter:.0f} %" if self.relative else f"± {self.scatter:g} {self.unit}".rstrip()

    @property
    def authors(self) -> str:
        """Authors and year of its source."""
        found = re.match(r".*?\(\d{4}\)", self.source)
        return found[0] if found else self.source.partition(",")[0]

    def applied_to(self, soil: IndexProperties) -> Correlated | None:
        """What it says about a soil; None where a property is missing, or the class is another."""
        given = [soil.value(name) for name in self.valid]
        values = [value for value in given if value is not None]
        if len(values) < len(given) or (self.classes and soil.soil_class not in self.classes):
            return None
        value = self.of(*values)
        if not math.isfinite(value):
            return None
        outside = [
            f"{name} = {one:g}, published for {low:g} to {high:g}"
            for (name, (low, high)), one in zip(self.valid.items(), values, strict=True)
            if not low <= one <= high
        ]
        half = None if self.scatter is None else self.scatter * (abs(value) if self.relative else 1.0)
        ends = None if half is None else (value - half, value + half)
        return Correlated(self, value, ends, "; ".join(outside))


@dataclass(frozen=True, slots=True)
class Correlated:
    """What a correlation says about one soil.

    ``ends``: value less and plus the published scatter. ``outside``: the properties that are beyond its range, in
    words; empty: none.
    """

    correlation: PublishedCorrelation
    value: float
    ends: tuple[float, float] | None
    outside: str


_MESRI = "Mesri & Castro (1987), J. Geotech. Eng. 113, 230-247; Terzaghi, Peck & Mesri (1996), table 16.1"

_CLASSES: tuple[tuple[SoilClass, str, float], ...] = (
    ("granular", "granular soils, rockfill included", 0.02),
    ("shale", "shale and mudstone", 0.03),
    ("inorganic_clay", "inorganic clays and silts", 0.04),
    ("organic_clay", "organic clays and silts", 0.05),
    ("peat", "peat and muskeg", 0.06),
)

COMPRESSIBILITY = (
    PublishedCorrelation(
        "Cc",
        "0.009 (w_L - 10)",
        lambda w_L: 0.009 * (w_L - 10.0),
        {"w_L": (20.0, 100.0)},
        "undisturbed clays of low to medium sensitivity, normally consolidated",
        "Terzaghi & Peck (1967), Soil Mechanics in Engineering Practice, 2nd ed.",
        scatter=0.3,
    ),
    PublishedCorrelation(
        "Cc",
        "0.007 (w_L - 10), remoulded",
        lambda w_L: 0.007 * (w_L - 10.0),
        {"w_L": (20.0, 100.0)},
        "remoulded clays",
        "Skempton (1944), Q. J. Geol. Soc. London 100, 119-135",
    ),
    PublishedCorrelation(
        "Cc",
        "0.37 (e_0 + 0.003 w_L + 0.0004 w_n - 0.34)",
        lambda e_0, w_L, w_n: 0.37 * (e_0 + 0.003 * w_L + 0.0004 * w_n - 0.34),
        {"e_0": (0.4, 3.5), "w_L": (20.0, 150.0), "w_n": (15.0, 130.0)},
        "678 tests of clays and silts of Greece and the United States; ranges are ours",
        "Azzouz, Krizek & Corotis (1976), Soils and Foundations 16(2), 19-29",
    ),
    PublishedCorrelation(
        "Cc",
        "0.40 (e_0 - 0.25)",
        lambda e_0: 0.40 * (e_0 - 0.25),
        {"e_0": (0.4, 3.5)},
        "clays and silts of Greece and the United States; range is ours",
        "Azzouz, Krizek & Corotis (1976), Soils and Foundations 16(2), 19-29",
    ),
    PublishedCorrelation(
        "Cc",
        "0.01 (w_n - 5)",
        lambda w_n: 0.01 * (w_n - 5.0),
        {"w_n": (15.0, 130.0)},
        "clays and silts of Greece and the United States; range is ours",
        "Azzouz, Krizek & Corotis (1976), Soils and Foundations 16(2), 19-29",
    ),
    PublishedCorrelation(
        "Cc",
        "G_s I_P/200",
        lambda G_s, I_P: G_s * I_P / 200.0,
        {"G_s": (2.5, 2.9), "I_P": (5.0, 100.0)},
        "remoulded clays: strength at the plastic limit is a hundred times that at the liquid limit",
        "Wroth & Wood (1978), Can. Geotech. J. 15, 137-145; Wood (1990), section 9.4",
    ),
    PublishedCorrelation(
        "Cc",
        "2.303 (1 + e_0) I_P/500",
        lambda e_0, I_P: 2.302585092994046 * (1.0 + e_0) * I_P / 500.0,
        {"e_0": (0.4, 5.0), "I_P": (5.0, 150.0)},
        "soft soils; published as lambda* = I_P/500",
        "PLAXIS Material Models Manual, soft soil creep model",
    ),
    PublishedCorrelation(
        "Cc",
        "0.046 + 0.0104 I_P",
        lambda I_P: 0.046 + 0.0104 * I_P,
        {"I_P": (10.0, 50.0)},
        "clays of I_P below 50 %",
        "Nakase, Kamei & Kusakabe (1988), J. Geotech. Eng. 114, 844-858",
    ),
    PublishedCorrelation(
        "Cs",
        "0.000463 w_L G_s",
        lambda w_L, G_s: 0.000463 * w_L * G_s,
        {"w_L": (20.0, 150.0), "G_s": (2.5, 2.9)},
        "saturated uncemented clays; ranges are ours",
        "Nagaraj & Srinivasa Murthy (1985), after Bowles (1996), section 2-10",
    ),
    PublishedCorrelation(
        "Cs",
        "0.00194 (I_P - 4.6)",
        lambda I_P: 0.00194 * (I_P - 4.6),
        {"I_P": (10.0, 50.0)},
        "clays of I_P below 50 %",
        "Nakase, Kamei & Kusakabe (1988), J. Geotech. Eng. 114, 844-858",
    ),
    PublishedCorrelation(
        "Cs",
        "I_P/370",
        lambda I_P: I_P / 370.0,
        {"I_P": (5.0, 100.0)},
        "unloading and reloading, from the critical state",
        "Kulhawy & Mayne (1990), EPRI EL-6800",
    ),
    *(
        PublishedCorrelation(
            "Cα/Cc",
            f"{ratio:g}",
            lambda ratio=ratio: ratio,
            {},
            words,
            _MESRI,
            scatter=0.01,
            relative=False,
            classes=(name,),
        )
        for name, words, ratio in _CLASSES
    ),
    PublishedCorrelation(
        "Cα/(1 + e₀)",
        "0.0001 w_n",
        lambda w_n: 0.0001 * w_n,
        {"w_n": (10.0, 3000.0)},
        "normally consolidated soils, strain in a decade of time",
        "Mesri (1973), J. Soil Mech. Found. Div. 99, 123-137; NAVFAC DM-7.1 (1982)",
    ),
    PublishedCorrelation(
        "C_k",
        "0.5 e_0",
        lambda e_0: 0.5 * e_0,
        {"e_0": (0.8, 3.0)},
        "soft natural clays",
        "Tavenas, Jean, Leblond & Leroueil (1983), Can. Geotech. J. 20, 645-660",
    ),
)


STRENGTH = (
    PublishedCorrelation(
        "φ",
        "sin φ = 0.8 - 0.094 ln I_P",
        lambda I_P: math.degrees(math.asin(min(0.8 - 0.094 * math.log(I_P), 1.0))),
        {"I_P": (5.0, 100.0)},
        "normally consolidated clays, critical state",
        "data of Kenney (1959), line of Mitchell (1976); Kulhawy & Mayne (1990), EPRI EL-6800",
        unit="degree",
    ),
    PublishedCorrelation(
        "K₀",
        "0.44 + 0.0042 I_P",
        lambda I_P: 0.44 + 0.0042 * I_P,
        {"I_P": (5.0, 80.0)},
        "normally consolidated clays",
        "Massarsch (1979), 7th ECSMFE Brighton 2, 245-249",
    ),
    PublishedCorrelation(
        "s_u/σ′v",
        "0.11 + 0.0037 I_P",
        lambda I_P: 0.11 + 0.0037 * I_P,
        {"I_P": (10.0, 120.0)},
        "normally consolidated clays, field vane",
        "Skempton (1957), Proc. ICE 7, 305-307",
    ),
)


_LIMITS = "Herle & Gudehus (1999), Mech. Cohesive-Frict. Materials 4, 461-486"
_SOURCE = "Brinkgreve, Engin & Engin (2010), 7th NUMGE Trondheim, 137-142"


def _of_sand(quantity: str, unit: str, equation: str, of: Callable[[float], float]) -> PublishedCorrelation:
    return PublishedCorrelation(quantity, equation, of, {"D_r": (25.0, 100.0)}, "sand", _SOURCE, unit=unit)


def _of_voids(quantity: str, equation: str, needs: str, of: Callable[[float], float]) -> PublishedCorrelation:
    soils = "sand and gravel without cohesion, at zero pressure"
    return PublishedCorrelation(quantity, equation, of, {needs: (0.25, 1.5)}, soils, _LIMITS)


SAND = (
    _of_sand("E₅₀ʳᵉᶠ", "kPa", "600 D_r", lambda D_r: 600.0 * D_r),
    _of_sand("E_oedʳᵉᶠ", "kPa", "600 D_r", lambda D_r: 600.0 * D_r),
    _of_sand("E_urʳᵉᶠ", "kPa", "1800 D_r", lambda D_r: 1800.0 * D_r),
    _of_sand("m", "", "0.7 - D_r/320", lambda D_r: 0.7 - D_r / 320.0),
    _of_sand("φ", "degree", "28 + D_r/8", lambda D_r: 28.0 + D_r / 8.0),
    _of_sand("ψ", "degree", "-2 + D_r/8", lambda D_r: -2.0 + D_r / 8.0),
    _of_sand("R_f", "", "1 - D_r/800", lambda D_r: 1.0 - D_r / 800.0),
    _of_voids("e_d0", "e_min", "e_min", lambda e_min: e_min),
    _of_voids("e_c0", "e_max", "e_max", lambda e_max: e_max),
    _of_voids("e_i0", "1.15 e_max", "e_max", lambda e_max: 1.15 * e_max),
)


CORRELATIONS: tuple[PublishedCorrelation, ...] = (*COMPRESSIBILITY, *STRENGTH, *SAND)


def correlated(soil: IndexProperties) -> tuple[Correlated, ...]:
    """What all correlations that its properties allow say about a soil."""
    return tuple(found for one in CORRELATIONS if (found := one.applied_to(soil)) is not None)
