"""Correlations of compressibility, creep and the change of permeability."""

from __future__ import annotations

from geoswarm.solver.correlations.correlation import Correlation
from geoswarm.solver.correlations.properties import SoilClass

__all__ = ["COMPRESSIBILITY"]

_MESRI = "Mesri & Castro (1987), J. Geotech. Eng. 113, 230-247; Terzaghi, Peck & Mesri (1996), table 16.1"

_CLASSES: tuple[tuple[SoilClass, str, float], ...] = (
    ("granular", "granular soils, rockfill included", 0.02),
    ("shale", "shale and mudstone", 0.03),
    ("inorganic_clay", "inorganic clays and silts", 0.04),
    ("organic_clay", "organic clays and silts", 0.05),
    ("peat", "peat and muskeg", 0.06),
)

COMPRESSIBILITY = (
    Correlation(
        "Cc",
        "",
        "0.009 (w_L - 10)",
        ("w_L",),
        lambda w_L: 0.009 * (w_L - 10.0),
        ((20.0, 100.0),),
        "undisturbed clays of low to medium sensitivity, normally consolidated",
        "Terzaghi & Peck (1967), Soil Mechanics in Engineering Practice, 2nd ed.",
        0.3,
    ),
    Correlation(
        "Cc",
        "",
        "0.007 (w_L - 10), remoulded",
        ("w_L",),
        lambda w_L: 0.007 * (w_L - 10.0),
        ((20.0, 100.0),),
        "remoulded clays",
        "Skempton (1944), Q. J. Geol. Soc. London 100, 119-135",
    ),
    Correlation(
        "Cc",
        "",
        "0.37 (e_0 + 0.003 w_L + 0.0004 w_n - 0.34)",
        ("e_0", "w_L", "w_n"),
        lambda e_0, w_L, w_n: 0.37 * (e_0 + 0.003 * w_L + 0.0004 * w_n - 0.34),
        ((0.4, 3.5), (20.0, 150.0), (15.0, 130.0)),
        "678 tests of clays and silts of Greece and the United States; ranges are ours",
        "Azzouz, Krizek & Corotis (1976), Soils and Foundations 16(2), 19-29",
    ),
    Correlation(
        "Cc",
        "",
        "0.40 (e_0 - 0.25)",
        ("e_0",),
        lambda e_0: 0.40 * (e_0 - 0.25),
        ((0.4, 3.5),),
        "clays and silts of Greece and the United States; range is ours",
        "Azzouz, Krizek & Corotis (1976), Soils and Foundations 16(2), 19-29",
    ),
    Correlation(
        "Cc",
        "",
        "0.01 (w_n - 5)",
        ("w_n",),
        lambda w_n: 0.01 * (w_n - 5.0),
        ((15.0, 130.0),),
        "clays and silts of Greece and the United States; range is ours",
        "Azzouz, Krizek & Corotis (1976), Soils and Foundations 16(2), 19-29",
    ),
    Correlation(
        "Cc",
        "",
        "G_s I_P/200",
        ("G_s", "I_P"),
        lambda G_s, I_P: G_s * I_P / 200.0,
        ((2.5, 2.9), (5.0, 100.0)),
        "remoulded clays: strength at the plastic limit is a hundred times that at the liquid limit",
        "Wroth & Wood (1978), Can. Geotech. J. 15, 137-145; Wood (1990), section 9.4",
    ),
    Correlation(
        "Cc",
        "",
        "2.303 (1 + e_0) I_P/500",
        ("e_0", "I_P"),
        lambda e_0, I_P: 2.302585092994046 * (1.0 + e_0) * I_P / 500.0,
        ((0.4, 5.0), (5.0, 150.0)),
        "soft soils; published as lambda* = I_P/500",
        "PLAXIS Material Models Manual, soft soil creep model",
    ),
    Correlation(
        "Cc",
        "",
        "0.046 + 0.0104 I_P",
        ("I_P",),
        lambda I_P: 0.046 + 0.0104 * I_P,
        ((10.0, 50.0),),
        "clays of I_P below 50 %",
        "Nakase, Kamei & Kusakabe (1988), J. Geotech. Eng. 114, 844-858",
    ),
    Correlation(
        "Cs",
        "",
        "0.000463 w_L G_s",
        ("w_L", "G_s"),
        lambda w_L, G_s: 0.000463 * w_L * G_s,
        ((20.0, 150.0), (2.5, 2.9)),
        "saturated uncemented clays; ranges are ours",
        "Nagaraj & Srinivasa Murthy (1985), after Bowles (1996), section 2-10",
    ),
    Correlation(
        "Cs",
        "",
        "0.00194 (I_P - 4.6)",
        ("I_P",),
        lambda I_P: 0.00194 * (I_P - 4.6),
        ((10.0, 50.0),),
        "clays of I_P below 50 %",
        "Nakase, Kamei & Kusakabe (1988), J. Geotech. Eng. 114, 844-858",
    ),
    Correlation(
        "Cs",
        "",
        "I_P/370",
        ("I_P",),
        lambda I_P: I_P / 370.0,
        ((5.0, 100.0),),
        "unloading and reloading, from the critical state",
        "Kulhawy & Mayne (1990), EPRI EL-6800",
    ),
    *(
        Correlation(
            "Cα/Cc",
            "",
            f"{ratio:g}",
            (),
            lambda ratio=ratio: ratio,
            (),
            words,
            _MESRI,
            0.01,
            False,
            (name,),
        )
        for name, words, ratio in _CLASSES
    ),
    Correlation(
        "Cα/(1 + e₀)",
        "",
        "0.0001 w_n",
        ("w_n",),
        lambda w_n: 0.0001 * w_n,
        ((10.0, 3000.0),),
        "normally consolidated soils, strain in a decade of time",
        "Mesri (1973), J. Soil Mech. Found. Div. 99, 123-137; NAVFAC DM-7.1 (1982)",
    ),
    Correlation(
        "C_k",
        "",
        "0.5 e_0",
        ("e_0",),
        lambda e_0: 0.5 * e_0,
        ((0.8, 3.0),),
        "soft natural clays",
        "Tavenas, Jean, Leblond & Leroueil (1983), Can. Geotech. J. 20, 645-660",
    ),
)
