"""Hardening soil, with and without small-strain stiffness, against its closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.material_point import History, PointState, follow, point_under
from geoswarm.solver.element_test.setups import (
    constant_rate_oedometer,
    drained_triaxial,
    isotropic_load,
    undrained_triaxial,
)
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.verification.case import Answer, Curve, Plot, case, check
from geoswarm.verification.exact.hardening_soil import DECAY, Drained, HardeningSand, backbone, masing_damping

__all__ = ["CASES"]

STIFF = HardeningSand()
EOED, G0, THRESHOLD = 2.2e4, 2.0e5, 2.0e-4
SAND: dict[str, Any] = {
    **{"E50_ref": STIFF.E50, "Eoed_ref": EOED, "Eur_ref": STIFF.Eur, "R_f": STIFF.R_f, "nu_ur": STIFF.nu},
    **{"m": 0.5, "c": 0.0, "phi": 34.0},
}
SCHANZ = "Schanz, Vermeer & Bonnier (1999), The hardening soil model: formulation and verification"
BENZ = "Benz (2007), Small-strain stiffness of soils and its numerical consequences"
FAR = "; the cap is far away (OCR 50)"
STEPS = "integration errors, bounded by the tolerance: 1e-8 of strain, and of stress this times the elastic modulus"


def _sand(**changes: Any) -> Soil:
    return find_law("hardening_soil").soil({**SAND, **changes})


def _isotropic(p: float, soil: Soil) -> PointState:
    return point_under([p, p, p, 0.0, 0.0, 0.0], soil)


def _sheared(soil: Soil, cell: float, strain: float, times: FloatArray) -> History:
    stage = drained_triaxial(strain, cell, 1.0)
    return follow(soil, _isotropic(cell, soil), [stage], [times], tolerance=1.0e-8)


@case(
    "hardening-soil-hyperbola",
    "The hyperbola of drained compression",
    shows=f"Cell pressures of 50, 100 and 300 kPa, to 98 % of the strength{FAR}.",
    given=("E50_ref = 25 MPa, Eur_ref = 80 MPa, m = 0.5, R_f = 0.9, ν = 0.2, φ = 34°, c = 0, ψ = 0, p_ref = 100 kPa"),
    source=SCHANZ,
    reference="q = E ε/(1 + E ε R_f/q_f),  E = 2 E50/(2 − R_f) ((σ₃ + a)/(p_ref + a))^m",
    allowed=STEPS,
)
def hyperbola() -> Answer:
    """Deviator over axial strain."""
    fractions = np.geomspace(2.0e-3, 1.0, 40)
    checks, curves = [], []
    for cell in (50.0, 100.0, 300.0):
        exact = Drained(cell)
        strain = float(exact.axial(np.array(0.98 * exact.strength)))
        history = _sheared(_sand(OCR=50.0), cell, strain, fractions)
        wanted = exact.deviator(strain * fractions)
        checks.append(
            check(f"q, cell {cell:g} kPa", "kPa", history.q, wanted, 1.0e-5, scale=exact.strength, of="the strength")
        )
        at = 100 * strain * fractions
        curves.append(Curve(f"{cell:g} kPa", at, history.q, at[::4], wanted[::4]))
    return Answer(tuple(checks), Plot("axial strain [%]", "q [kPa]", tuple(curves)))


@case(
    "hardening-soil-moduli",
    "Moduli over the cell pressure: E50, Eur and the power m",
    shows=f"Secant to half the strength, and unloading from there, from 10 to 1000 kPa with m = 0.5 and 0.8{FAR}.",
    given="E50_ref = 25 MPa, Eur_ref = 80 MPa, R_f = 0.9, ν = 0.2, φ = 34°, c = 0, ψ = 0, p_ref = 100 kPa",
    source=SCHANZ,
    reference="E50 = E50_ref (σ₃/p_ref)^m,  Eur = Eur_ref (σ₃/p_ref)^m",
    allowed=STEPS,
)
def moduli() -> Answer:
    """Both moduli for two powers."""
    cells = np.geomspace(10.0, 1000.0, 7)
    checks, curves = [], []
    for m in (0.5, 0.8):
        secants, backs = [], []
        for cell in cells.tolist():
            exact, soil = Drained(cell, m=m), _sand(m=m, OCR=50.0)
            half = 0.5 * exact.strength / (STIFF.E50 * exact.stiff)
            stages = [drained_triaxial(half, cell, 1.0), drained_triaxial(-0.1 * half, cell, 1.0)]
            loop = follow(soil, _isotropic(cell, soil), stages, [[1.0], [1.0]], tolerance=1.0e-8)
            secants.append(loop.q[0] / loop.strain[0, 2])
            backs.append((loop.q[0] - loop.q[1]) / (loop.strain[0, 2] - loop.strain[1, 2]))
        for name, ours, at_reference in (("E50", secants, STIFF.E50), ("Eur", backs, STIFF.Eur)):
            wanted = at_reference * (cells / 100.0) ** m
            checks.append(check(f"{name}, m = {m:g}", "kPa", ours, wanted, 1.0e-6))
            curves.append(Curve(f"{name}, m = {m:g}", cells, np.array(ours) / 1000.0, cells, wanted / 1000.0))
    plot = Plot("cell pressure [kPa]", "modulus [MPa]", tuple(curves), log_x=True, log_y=True)
    return Answer(tuple(checks), plot)


@case(
    "hardening-soil-dilatancy",
    "Dilatancy of Rowe up to its limit",
    shows=f"Drained compression at 100 kPa with ψ = 6°, with and without contraction before{FAR}.",
    given=("E50_ref = 25 MPa, Eur_ref = 80 MPa, m = 0.5, R_f = 0.9, ν = 0.2, φ = 34°, c = 0, ψ = 6°; to 2 % of strain"),
    source=f"{SCHANZ}; Rowe (1962)",
    reference="ε_v = (1 − 2ν) q/Eur − ∫ sin ψ_m dγ^p,  sin ψ_m = (sin φ_m − sin φ_cv)/(1 − sin φ_m sin φ_cv)",
    allowed=STEPS,
)
def dilatancy() -> Answer:
    """Volume strain over axial strain."""
    fractions = np.geomspace(2.0e-3, 1.0, 40)
    exact, checks, curves = Drained(100.0, psi=6.0), [], []
    for contraction, label in (("none", "without contraction"), ("rowe", "with contraction")):
        soil = _sand(psi=6.0, OCR=50.0, contraction=contraction)
        history = _sheared(soil, 100.0, 0.02, fractions)
        plastic = [exact.dilation(q, contracts=contraction == "rowe") for q in history.q.tolist()]
        wanted = (1.0 - 2.0 * STIFF.nu) * history.q / STIFF.Eur + np.array(plastic)
        ours = history.strain[:, :3].sum(axis=1)
        checks.append(check(f"volume strain, {label}", "", ours, wanted, 1.0e-7, scale=1.0, of="absolute"))
        curves.append(Curve(label, 2.0 * fractions, 100 * ours, 2.0 * fractions[::3], 100 * wanted[::3]))
    plot = Plot("axial strain [%]", "volume strain [%]", tuple(curves), downwards=True)
    return Answer(tuple(checks), plot)


@case(
    "hardening-soil-oedometer",
    "One-dimensional compression: Eoed and K0nc",
    shows="From 40 kPa at rest, without cohesion, for m = 0.5, 0.8 and 1: the law finds its cap by itself.",
    given=(
        "E50_ref = 25 MPa, Eoed_ref = 22 MPa, Eur_ref = 80 MPa, R_f = 0.9, ν = 0.2, φ = 34°, c = 0, K0nc = 1 − sin φ"
    ),
    source=SCHANZ,
    reference="E_oed = Eoed_ref (σ₁/p_ref)^m integrated over strain;  σ₃ = K0nc σ₁",
    allowed="integration errors, bounded by the tolerance of 1e-9 of strain",
)
def oedometer() -> Answer:
    """Vertical stress over strain."""
    fractions = np.linspace(0.025, 1.0, 40)
    K0, start, rate = 1.0 - math.sin(math.radians(34.0)), 40.0, 0.02
    checks, curves = [], []
    for m in (0.5, 0.8, 1.0):
        soil = _sand(m=m)
        point = point_under([K0 * start, K0 * start, start, 0.0, 0.0, 0.0], soil)
        history = follow(soil, point, [constant_rate_oedometer(rate, 1.0)], [fractions], tolerance=1.0e-9)
        growth = rate * fractions * EOED / 100.0
        vertical = (
            start * np.exp(growth)
            if m == 1.0
            else 100.0 * ((start / 100.0) ** (1.0 - m) + (1.0 - m) * growth) ** (1.0 / (1.0 - m))
        )
        checks.append(check(f"vertical stress, m = {m:g}", "kPa", history.stress[:, 2], vertical, 1.0e-5))
        ratio = history.stress[:, 0] / history.stress[:, 2]
        checks.append(check(f"stress ratio, m = {m:g}", "", ratio, K0, 1.0e-5))
        at = 100 * rate * fractions
        curves.append(Curve(f"m = {m:g}", history.stress[:, 2], at, vertical[::4], at[::4]))
    return Answer(tuple(checks), Plot("vertical stress [kPa]", "axial strain [%]", tuple(curves), downwards=True))


@case(
    "hardening-soil-isotropic",
    "Isotropic compression: elastic part and cap",
    shows="Isotropic stress from 50 to 400 kPa, with m = 0.5; the modulus H of the cap is the one reported by the law.",
    given=("E50_ref = 25 MPa, Eoed_ref = 22 MPa, Eur_ref = 80 MPa, m = 0.5, R_f = 0.9, ν = 0.2, φ = 34°, c = 0"),
    source=SCHANZ,
    reference="ε_v = p_ref ((p/p_ref)^(1−m) − (p₀/p_ref)^(1−m))/(1 − m) (3 (1 − 2ν)/Eur + 1/H)",
    allowed="integration errors, bounded by the tolerance of 1e-9 of strain",
)
def isotropic() -> Answer:
    """Volume strain over stress."""
    soil = _sand()
    H = float(soil.constants[13])
    p = np.geomspace(60.0, 400.0, 20)
    loads = [isotropic_load(one, 1.0) for one in p.tolist()]
    history = follow(soil, _isotropic(50.0, soil), loads, [[1.0]] * p.size, tolerance=1.0e-9)
    power = 2.0 * ((p / 100.0) ** 0.5 - 0.5**0.5)
    exact = 100.0 * power * (3.0 * (1.0 - 2.0 * STIFF.nu) / STIFF.Eur + 1.0 / H)
    ours = history.strain[:, :3].sum(axis=1)
    curve = Curve("", p, 100 * ours, p[::3], 100 * exact[::3])
    plot = Plot("mean stress [kPa]", "volume strain [%]", (curve,), downwards=True)
    return Answer((check("volume strain", "", ours, exact, 1.0e-6),), plot)


def _small(**changes: Any) -> Soil:
    given = {**SAND, "G0_ref": G0, "gamma_07": THRESHOLD, "OCR": 50.0, **changes}
    return find_law("hardening_soil_small").soil(given)


def _held(p: float, soil: Soil) -> PointState:
    """Sheared close to the strength before, so that small shear is elastic."""
    point = _isotropic(p, soil)
    point.internal[0] = 1.0
    return point


def _simple_shear(soil: Soil, increments: FloatArray) -> FloatArray:
    """Shear stress after each increment of engineering shear strain, (n,), from 100 kPa all round."""
    point = _held(100.0, soil)
    stress, state = point.stress, point.internal
    found = []
    for gamma in increments.tolist():
        strain = np.array([0.0, 0.0, 0.0, gamma, 0.0, 0.0])
        stress, state, _, _ = soil.law.update(strain, -math.inf, stress, state, soil.constants)
        found.append(float(stress[3]))
    return np.array(found)


@case(
    "small-strain-reduction",
    "Stiffness at small strains: the curve of Hardin and Drnevich",
    shows=(
        "Secant shear modulus of triaxial compression, drained at 50 and 200 kPa (m = 0.5) and undrained (m = 0), of a "
        "soil that has been sheared before."
    ),
    given=(
        "G0_ref = 200 MPa, γ_0.7 = 2·10⁻⁴, E50_ref = 25 MPa, Eur_ref = 80 MPa, ν = 0.2, φ = 34°, c = 0, p_ref = 100 kPa"
    ),
    source=f"{BENZ}; Hardin & Drnevich (1972); Santos & Correia (2001)",
    reference="G_s/G0 = 1/(1 + 0.385 γ/γ_0.7),  G0 = G0_ref (σ₃/p_ref)^m",
    allowed=STEPS,
)
def reduction() -> Answer:
    """Secant over shear strain."""
    times = np.geomspace(1.0e-3, 1.0, 30)
    checks, curves = [], []
    cases = (
        ("drained, 50 kPa", 0.5, 50.0, True),
        ("drained, 200 kPa", 0.5, 200.0, True),
        ("undrained", 0.0, 100.0, False),
    )
    for label, m, cell, drained in cases:
        soil = _small(m=m)
        stage = drained_triaxial(4.0e-4, cell, 1.0) if drained else undrained_triaxial(4.0e-4, 1.0)
        history = follow(soil, _held(cell, soil), [stage], [times], tolerance=1.0e-9)
        gamma = history.strain[:, 2] - history.strain[:, 0]
        initial = G0 * (cell / 100.0) ** m
        q = 2.0 * backbone(gamma, initial, THRESHOLD)
        secant, wanted = history.q / (2.0 * gamma), q / (2.0 * gamma)
        checks.append(check(f"secant modulus, {label}", "kPa", secant, wanted, 1.0e-4, scale=initial, of="G0"))
        curves.append(Curve(label, gamma, secant / 1000.0, gamma[::3], wanted[::3] / 1000.0))
    plot = Plot("shear strain [-]", "secant shear modulus [MPa]", tuple(curves), log_x=True)
    return Answer(tuple(checks), plot)


@case(
    "small-strain-damping",
    "Loops of Masing and their damping",
    shows="Cycles of simple shear of three amplitudes: loops close on the first curve, their area gives the damping.",
    given=(
        "G0_ref = 200 MPa, γ_0.7 = 2·10⁻⁴, m = 0, from isotropic 100 kPa; γ is 3/2 ε_q, √3/2 of the engineering strain"
    ),
    source=f"{BENZ}; Masing (1926); the doubled hyperbola integrated (Brinkgreve, Kappert & Bonnier 2007)",
    reference="D = 4/π (1 + 1/x)(1 − ln(1 + x)/x) − 2/π,  x = 0.385 γ/γ_0.7",
    allowed="rounding for the tip of the loop; 800 trapezia under a branch for its area",
)
def loops() -> Answer:
    """Loops and damping."""
    soil, count = _small(m=0.0), 400
    amplitudes = np.array([3.0e-5, 1.0e-4, 4.0e-4])
    tips, damped, curves = [], [], []
    for amplitude in amplitudes.tolist():
        shear = 2.0 / math.sqrt(3.0) * amplitude  # 3/2 eps_q is sqrt(3)/2 of the engineering strain
        first = np.full(count, shear / count)
        increments = np.concatenate([first, np.full(2 * count, -shear / count), np.full(2 * count, shear / count)])
        tau, gamma = _simple_shear(soil, increments), np.cumsum(increments)
        tips.append(tau[-1] * 0.5 * math.sqrt(3.0))
        area = float(np.trapezoid(tau[count - 1 :], gamma[count - 1 :]))
        damped.append(area / (2.0 * math.pi * tau[-1] * shear))
        tip = float(backbone(amplitude, G0, THRESHOLD)) * 2.0 / math.sqrt(3.0)
        ends = 1.0e4 * np.array([shear, -shear])
        curves.append(
            Curve(f"γ = {1.0e4 * amplitude:g}·10⁻⁴", 1.0e4 * gamma[::20], tau[::20], ends, np.array([tip, -tip]))
        )
    checks = (
        check("shear stress at the tip", "kPa", tips, backbone(amplitudes, G0, THRESHOLD), 1.0e-9),
        check("damping ratio", "", damped, masing_damping(amplitudes, THRESHOLD), 1.0e-4),
    )
    plot = Plot(
        "engineering shear strain [10⁻⁴]", "shear stress [kPa]", tuple(curves), caption="Markers: ±τ of the curve."
    )
    return Answer(checks, plot)


@case(
    "small-strain-tangent",
    "Where small strains end: the tangent modulus of unloading",
    shows="Simple shear far beyond the cut-off, where the tangent has fallen from G0 to Gur and stays.",
    given=(
        "G0_ref = 200 MPa, γ_0.7 = 2·10⁻⁴, Eur_ref = 80 MPa, ν = 0.2, so Gur = 33.3 MPa; m = 0, c = 60 kPa, φ = 34°"
    ),
    source=BENZ,
    reference="γ_c = γ_0.7/0.385 (√(G0/Gur) − 1);  G_t = G0/(1 + 0.385 γ/γ_0.7)², at least Gur",
    allowed="the step of the difference quotient",
)
def tangent() -> Answer:
    """Tangent over shear strain."""
    Gur = STIFF.Eur / (2.0 * (1.0 + STIFF.nu))
    soil = _small(m=0.0, c=60.0)
    measure = np.geomspace(2.0e-6, 1.4e-3, 40)
    factor = 2.0 / math.sqrt(3.0)
    step = 1.0e-4
    edges = np.sort(np.concatenate([measure * (1.0 - step), measure * (1.0 + step)])) * factor
    tau = _simple_shear(soil, np.diff(edges, prepend=0.0))
    ours = (tau[1::2] - tau[::2]) / (edges[1::2] - edges[::2])
    exact = np.maximum(G0 / (1.0 + DECAY * measure / THRESHOLD) ** 2, Gur)
    curve = Curve("", measure, ours / 1000.0, measure[::3], exact[::3] / 1000.0)
    plot = Plot("shear strain 3/2 ε_q [-]", "tangent shear modulus [MPa]", (curve,), log_x=True)
    return Answer((check("tangent modulus", "kPa", ours, exact, 1.0e-5),), plot)


CASES = (hyperbola, moduli, dilatancy, oedometer, isotropic, reduction, tangent, loops)
