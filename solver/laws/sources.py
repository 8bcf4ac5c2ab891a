"""Where the usual ranges of parameters come from: publications, and what is said where there is none."""

from __future__ import annotations

__all__ = [
    "BJERRUM",
    "BOLTON",
    "BOWLES",
    "BRINKGREVE",
    "BRINKGREVE_SAND",
    "DUNCAN",
    "HANSBO",
    "HERLE",
    "HOLTZ",
    "JAKY",
    "KULHAWY",
    "MASIN",
    "MESRI_COHESION",
    "MESRI_CREEP",
    "NIEMUNIS",
    "OVERBURDEN",
    "PLAXIS",
    "SCHOFIELD",
    "TAVENAS",
    "TERZAGHI",
    "VON_SOOS",
    "WOOD",
]

BJERRUM = "Bjerrum (1967), Géotechnique 17, 81-118 (1.2 to 2 by ageing); more by unloading"
BOLTON = (
    "Bolton (1986), Géotechnique 36, 65-78: 0.8 psi is the peak friction above the critical one; about 0 for soft clay"
)
BOWLES = "Bowles (1996), Foundation Analysis and Design, 5th ed., table 2-8 (Young's moduli by soil type)"
BRINKGREVE = "Brinkgreve (1994), thesis, TU Delft: about 3.0 - 2.8 K0nc"
BRINKGREVE_SAND = "Brinkgreve, Engin & Engin (2010), NUMGE, for sand by its relative density; below it for clay"
DUNCAN = "Duncan & Chang (1970), J. Soil Mech. Found. Div. 96, 1629-1653 (0.75 to 1)"
HANSBO = "Hansbo (1981), 10th ICSMFE Stockholm 3, 677-682, and later practice"
HERLE = "after Herle & Gudehus (1999), Mech. Cohesive-Frict. Materials 4, 461-486, six sands and gravels, widened"
HOLTZ = "Holtz, Jamiolkowski, Lancellotta & Pedroni (1991), Prefabricated Vertical Drains, CIRIA"
JAKY = "Jaky (1944), 1 - sin(phi); Mayne & Kulhawy (1982), J. Geotech. Eng. Div. 108, 851-872"
KULHAWY = "Kulhawy & Mayne (1990), EPRI EL-6800 (drained Poisson's ratios by soil type)"
MASIN = (
    "after the clays in Mašín (2005), Int. J. Numerical Anal. Methods Geomech. 29, 311-336; "
    "(2013), Acta Geotech. 8, 481-495"
)
MESRI_COHESION = (
    "after Mesri & Abdel-Ghaffar (1993), J. Geotech. Eng. 119, 1229-1249: some per cent of the preconsolidation stress"
)
MESRI_CREEP = (
    "Mesri & Godlewski (1977), J. Geotech. Eng. Div. 103, 417-430: C_alpha/Cc 0.02 to 0.07, of the range of lambda_star"
)
NIEMUNIS = "after Niemunis & Herle (1997), Mech. Cohesive-Frict. Materials 2, 279-299; clays: Mašín (2005)"
OVERBURDEN = "no published range: what OCR 1 to 4 is at a few metres of depth"
PLAXIS = "PLAXIS Material Models Manual"
SCHOFIELD = "Schofield & Wroth (1968), Critical State Soil Mechanics (kaolin, London and Weald clay), widened"
TAVENAS = "Tavenas, Jean, Leblond & Leroueil (1983), Can. Geotech. J. 20, 645-660: half the void ratio"
TERZAGHI = "Terzaghi, Peck & Mesri (1996), Soil Mechanics in Engineering Practice, 3rd ed."
VON_SOOS = "Janbu (1963), ECSMFE Wiesbaden (0.5 for silt and sand); von Soos (1990), Grundbau-Taschenbuch (0.5 to 1)"
WOOD = "Wood (1990), Soil Behaviour and Critical State Soil Mechanics"
