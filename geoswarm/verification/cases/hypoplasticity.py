"""Hypoplasticity of sand and clay: closed forms, published numbers, independent integration."""

from __future__ import annotations

import math

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.material_point import follow, point_under
from geoswarm.solver.element_test.setups import drained_triaxial, undrained_triaxial
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.verification.case import Answer, Curve, Plot, case, check
from geoswarm.verification.exact.hypoplastic_rates import State, sand_rates, triaxial
from geoswarm.verification.exact.hypoplasticity import DORTMUND, HOCHSTETTEN, TOYOURA, bauer, critical_slope

__all__ = ["CASES"]

ALL_ROUND = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
HERLE = "Herle & Gudehus (1999); von Wolffersdorff (1996)"


def _sand(**changes: float) -> Soil:
    return find_law("hypoplastic_sand").soil({**TOYOURA, **changes})


def _bauer(e0: float, p: FloatArray | float) -> FloatArray:
    return bauer(e0, p, TOYOURA["h_s"], TOYOURA["n"])


def _stepped(soil: Soil, stress: FloatArray, state: FloatArray, strain: FloatArray) -> tuple[FloatArray, FloatArray]:
    new, new_state, _, _ = soil.law.update(strain, -math.inf, stress, state, soil.constants)
    return new, new_state


@case(
    "hypoplastic-bauer",
    "Compression of the loosest sand: Bauer's law",
    shows="Toyoura sand at its largest void ratio, compressed isotropically from 10 kPa to 20 MPa.",
    given="φ_c = 30°, h_s = 2.6 GPa, n = 0.27, e_d0 = 0.61, e_c0 = 0.98, e_i0 = 1.10, α = 0.18, β = 1.1",
    source=f"Bauer (1996); {HERLE}, table of Toyoura sand",
    reference="e_i = e_i0 exp(−(3 p/h_s)^n)",
    allowed="integration errors of the law (1e-7)",
)
def loosest() -> Answer:
    """Void ratio over stress."""
    p = np.geomspace(10.0, 2.0e4, 25)
    e = _bauer(TOYOURA["e_i0"], p)
    soil = _sand(e0=float(e[0]))
    stress = p[0] * ALL_ROUND
    state = soil.law.initial_state(stress, soil.constants)
    found = [float(p[0])]
    for before, after in zip(e[:-1].tolist(), e[1:].tolist(), strict=True):
        volume = math.log((1.0 + before) / (1.0 + after))
        stress, state = _stepped(soil, stress, state, volume / 3.0 * ALL_ROUND)
        found.append(float(stress[0]))
    curve = Curve("", np.array(found), e, p[::2], e[::2])
    plot = Plot("mean stress [kPa]", "void ratio [-]", (curve,), log_x=True)
    return Answer((check("mean stress at the void ratio of the law", "kPa", found, p, 1.0e-6),), plot)


@case(
    "hypoplastic-critical-state",
    "Sand of any density ends in the critical state",
    shows="Drained compression of loose, medium and dense Toyoura sand at 100 kPa, and extension of medium sand.",
    given="Toyoura sand as before; e₀ = 0.9, 0.8 and 0.7",
    source=HERLE,
    reference="q/p = 6 sin φ_c/(3 ∓ sin φ_c),  e = e_c0 exp(−(3 p/h_s)^n)",
    allowed="remaining distance from the critical state after 800 % of strain",
)
def critical_state() -> Answer:
    """Void ratio over strain."""
    times = np.concatenate([np.geomspace(2.0e-4, 0.9, 50), [1.0]])
    slopes, ratios, wanted_slopes, wanted_ratios, curves = [], [], [], [], []
    for label, e0, way in (("loose", 0.9, 1.0), ("medium", 0.8, 1.0), ("dense", 0.7, 1.0), ("extension", 0.8, -1.0)):
        soil, stage = _sand(e0=e0), drained_triaxial(way * 8.0, 100.0, 1.0)
        history = follow(soil, point_under(100.0 * ALL_ROUND, soil), [stage], [times], tolerance=1.0e-8)
        slopes.append(history.q[-1] / history.p[-1])
        ratios.append(history.internal[-1, 0])
        wanted_slopes.append(critical_slope(TOYOURA["phi_c"], way))
        wanted_ratios.append(float(_bauer(TOYOURA["e_c0"], history.p[-1])))
        end = np.array([800.0])
        curves.append(Curve(label, 800 * times, history.internal[:, 0], end, np.array(wanted_ratios[-1:])))
    checks = (
        check("q/p at the end", "", slopes, wanted_slopes, 1.0e-5),
        check("void ratio at the end", "", ratios, wanted_ratios, 1.0e-5),
    )
    plot = Plot(
        "axial strain, amount [%]", "void ratio [-]", tuple(curves), log_x=True, caption="Markers: critical states."
    )
    return Answer(checks, plot)


@case(
    "hypoplastic-triaxial",
    "Triaxial tests on sand, against an independent integration",
    shows="Drained and undrained compression of Toyoura sand (e = 0.75) at 100 kPa to 20 % of strain.",
    given="Toyoura sand as before; no intergranular strain",
    source=f"{HERLE}: tensors L and N as printed",
    reference="rate equations in 3 × 3 tensors, integrated by SciPy's DOP853",
    allowed="the tolerance of 1e-9 of strain of the driver",
)
def integrated() -> Answer:
    """Stress over strain."""
    fractions = np.array([0.001, 0.003, 0.01, 0.03, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0])
    fine = np.unique(np.concatenate([fractions, np.linspace(0.01, 1.0, 50)]))
    at = np.searchsorted(fine, fractions)
    soil, checks, curves = _sand(), [], []
    start = State(100.0 * ALL_ROUND, TOYOURA["e0"], np.zeros(6))
    for drained, label in ((True, "drained"), (False, "undrained")):
        path = triaxial(sand_rates(TOYOURA), TOYOURA, start, 0.2, fractions, drained)
        wanted = np.array([one.stress[2] - one.stress[0] for one in path])
        stage = drained_triaxial(0.2, 100.0, 1.0) if drained else undrained_triaxial(0.2, 1.0)
        history = follow(soil, point_under(100.0 * ALL_ROUND, soil), [stage], [fine], tolerance=1.0e-9)
        checks.append(check(f"q, {label}", "kPa", history.q[at], wanted, 1.0e-6, scale=100.0, of="the cell pressure"))
        void = np.array([one.e for one in path])
        checks.append(check(f"void ratio, {label}", "", history.internal[at, 0], void, 1.0e-7))
        curves.append(Curve(label, 20 * fine, history.q, 20 * fractions, wanted))
    return Answer(tuple(checks), Plot("axial strain [%]", "q [kPa]", tuple(curves)))


@case(
    "hypoplastic-published-run",
    "A published calculation with the authors' routine",
    shows=(
        "Oedometer test on Hochstetten sand from 100 kPa all round to 0.5 % and one step back, with a fresh "
        "intergranular strain of zero."
    ),
    given=(
        "φ_c = 33°, h_s = 1 GPa, n = 0.25, e_d0 = 0.55, e_c0 = 0.95, e_i0 = 1.05, α = 0.25, β = 1.5, m_R = "
        "5, m_T = 2, R = 10⁻⁴, β_r = 0.5, χ = 6, e₀ = 0.70"
    ),
    source=(
        "OpenSees documentation, nDMaterial UMAT, worked example Hochstetten sand: expected results of the routine of "
        "Tamagnini, Sellari, Mašín and von Wolffersdorff (soilmodels.com)"
    ),
    reference="published: 294.3 kPa at 0.5 %, modulus of the last step 29 080 kPa, of the first step back 316 559 kPa",
    allowed="half of the last digit (stress), and what the routine's tolerance of 1e-3 may change (moduli, 2e-4)",
)
def published_run() -> Answer:
    """Stress over strain and two moduli."""
    soil = find_law("hypoplastic_sand").soil(HOCHSTETTEN)
    down = np.array([0.0, 1.0e-4, 0.0, 0.0, 0.0, 0.0])
    stress, state = 100.0 * ALL_ROUND, soil.law.initial_state(100.0 * ALL_ROUND, soil.constants)
    path = [float(stress[1])]
    for _ in range(49):
        stress, state = _stepped(soil, stress, state, down)
        path.append(float(stress[1]))
    before = stress
    stress, state = _stepped(soil, before, state, down)
    back, _ = _stepped(soil, stress, state, -down)
    path += [float(stress[1]), float(back[1])]
    checks = (
        check("vertical stress at 0.5 %", "kPa", stress[1], 294.3, 0.05, scale=1.0, of="absolute"),
        check("modulus of the last step", "kPa", (stress[1] - before[1]) / 1.0e-4, 29080.0, 2.0e-4),
        check("modulus of the first step back", "kPa", (stress[1] - back[1]) / 1.0e-4, 316559.0, 2.0e-4),
    )
    strain = np.array([*(0.01 * np.arange(51)), 0.49])
    curve = Curve("", np.array(path), strain, np.array([294.3]), np.array([0.5]))
    plot = Plot(
        "vertical stress [kPa]", "axial strain [%]", (curve,), downwards=True, caption="Marker: published stress."
    )
    return Answer(checks, plot)


@case(
    "hypoplastic-clay-compression",
    "Normal compression of clay",
    shows="Dortmund clay on its isotropic line from 50 kPa to 5 MPa, and at rest with K0 kept.",
    given="φ_c = 27.9°, λ* = 0.057, κ* = 0.008, N = 0.749, ν = 0.38",
    source="Mašín (2013), Clay hypoplasticity with explicitly defined asymptotic states",
    reference="ln(1 + e) = N − λ* ln p; at rest every stress grows by exp(ε_v/λ*)",
    allowed="integration errors of the law (1e-7)",
)
def clay_lines() -> Answer:
    """Void ratio over stress."""
    soil = find_law("hypoplastic_clay").soil(DORTMUND)
    soft, p = DORTMUND["lambda_star"], np.geomspace(50.0, 5.0e3, 21)
    K0 = soil.law.K0(soil.constants)
    assert K0 is not None
    checks, curves = [], []
    lines = (("isotropic", ALL_ROUND, ALL_ROUND / 3.0), ("at rest", np.array([K0, K0, 1.0, 0, 0, 0]), np.eye(6)[2]))
    for label, way, direction in lines:
        stress = p[0] * way
        state = soil.law.initial_state(stress, soil.constants)
        start = math.log(1.0 + state[0])
        stresses, e = [stress], [float(state[0])]
        for factor in (p[1:] / p[:-1]).tolist():
            stress, state = _stepped(soil, stress, state, soft * math.log(factor) * direction)
            stresses.append(stress)
            e.append(float(state[0]))
        found = np.array(stresses)
        checks.append(check(f"axial stress, {label}", "kPa", found[:, 2], p, 1.0e-6))
        checks.append(check(f"lateral stress, {label}", "kPa", found[:, 0], way[0] * p, 1.0e-6))
        exact = np.expm1(start - soft * np.log(p / p[0]))
        curves.append(Curve(label, found[:, 2], np.array(e), p[::2], exact[::2]))
        if label == "isotropic":
            line = np.expm1(DORTMUND["N"] - soft * np.log(p))
            checks.append(check("void ratio, isotropic", "", e, line, 1.0e-9))
    return Answer(tuple(checks), Plot("axial stress [kPa]", "void ratio [-]", tuple(curves), log_x=True))


@case(
    "hypoplastic-clay-undrained",
    "Undrained strength of clay",
    shows="Compression and extension from 100 kPa with overconsolidation ratios of 1, 2 and 10.",
    given="φ_c = 27.9°, λ* = 0.057, κ* = 0.008, N = 0.749, ν = 0.38",
    source="Mašín (2013): the critical state line, ln(1 + e) = N − λ* ln(2 p)",
    reference="p = p_e/2 and q = M p at the end, p_e = exp((N − ln(1 + e))/λ*)",
    allowed="remaining distance from the critical state after 300 % of strain",
)
def clay_strength() -> Answer:
    """Stress paths."""
    times = np.concatenate([np.geomspace(1.0e-4, 0.5, 40), [1.0]])
    ours, wanted, curves = [], [], []
    for OCR in (1.0, 2.0, 10.0):
        soil = find_law("hypoplastic_clay").soil({**DORTMUND, "OCR": OCR})
        start = point_under(100.0 * ALL_ROUND, soil)
        p = 0.5 * math.exp((DORTMUND["N"] - math.log(1.0 + float(start.internal[0]))) / DORTMUND["lambda_star"])
        for way in (1.0, -1.0):
            history = follow(soil, start, [undrained_triaxial(way * 3.0, 1.0)], [times], tolerance=1.0e-7)
            slope = critical_slope(DORTMUND["phi_c"], way)
            ours += [history.p[-1], history.q[-1]]
            wanted += [p, slope * p]
            label = f"OCR {OCR:g}, {'compression' if way > 0 else 'extension'}"
            curves.append(Curve(label, history.p, way * history.q, np.array([p]), np.array([way * slope * p])))
    plot = Plot("p [kPa]", "axial less lateral stress [kPa]", tuple(curves), caption="Markers: critical states.")
    return Answer((check("p and q at the end", "kPa", ours, wanted, 1.0e-5),), plot)


CASES = (loosest, critical_state, integrated, published_run, clay_lines, clay_strength)
