"""Modified Cam clay and soft soil: closed forms and quadrature of the rate equations."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.optimize import brentq

from geoswarm.solver.element_test.material_point import PointState, follow, point_under
from geoswarm.solver.element_test.setups import (
    confined_load,
    constant_rate_oedometer,
    drained_triaxial,
    isotropic_load,
    undrained_triaxial,
)
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.verification.case import Answer, Curve, Plot, case, check
from geoswarm.verification.exact.cam_clay import CamClay
from geoswarm.verification.specimens.laboratory import run, simple_shear

__all__ = ["CASES"]

EXACT = CamClay(M=0.95, lambda_=0.2, kappa=0.04, e0=1.1, nu=0.3)
CLAY: dict[str, Any] = {"M": 0.95, "lambda": 0.2, "kappa": 0.04, "e0": 1.1, "nu": 0.3}
WOOD = "Wood (1990), Soil Behaviour and Critical State Soil Mechanics"


def _clay(**changes: Any) -> Soil:
    return find_law("modified_cam_clay").soil({**CLAY, **changes})


def _isotropic(p: float, soil: Soil) -> PointState:
    return point_under([p, p, p, 0.0, 0.0, 0.0], soil)


@case(
    "cam-clay-undrained",
    "Undrained path of modified Cam clay",
    shows="Compression from isotropic 100 kPa with overconsolidation ratios of 1, 1.5 and 4, to the critical state.",
    given="M = 0.95, λ = 0.2, κ = 0.04, e₀ = 1.1, ν = 0.3",
    source=f"{WOOD}, section 5.4; Roscoe & Burland (1968)",
    reference="p = p₀ up to yield, then p ((M² + η²)/M²)^Λ constant, Λ = 1 − κ/λ; end p = p₀ (OCR/2)^Λ, q = M p",
    allowed="integration errors, bounded by the tolerance of 1e-8 of strain",
)
def undrained() -> Answer:
    """Stress paths."""
    checks, curves = [], []
    for OCR in (1.0, 1.5, 4.0):
        soil = _clay(OCR=OCR)
        times = np.geomspace(5.0e-4, 1.0, 150)
        history = follow(soil, _isotropic(100.0, soil), [undrained_triaxial(1.5, 1.0)], [times], tolerance=1.0e-8)
        yielding = history.internal[:, 0] != 100.0 * OCR
        exact = np.where(yielding, EXACT.undrained_p(history.q / history.p, 100.0, OCR), 100.0)
        checks.append(check(f"mean stress, OCR {OCR:g}", "kPa", history.p, exact, 1.0e-6))
        end = 100.0 * (OCR / 2.0) ** EXACT.plastic
        checks.append(check(f"q at the end, OCR {OCR:g}", "kPa", history.q[-1], EXACT.M * end, 1.0e-5))
        eta = np.linspace(EXACT.M * math.sqrt(OCR - 1.0) + 1.0e-9, EXACT.M, 9)
        p = EXACT.undrained_p(eta, 100.0, OCR)
        curves.append(Curve(f"OCR {OCR:g}", history.p, history.q, p, eta * p))
    return Answer(tuple(checks), Plot("p [kPa]", "q [kPa]", tuple(curves)))


@case(
    "cam-clay-drained",
    "Drained compression of modified Cam clay",
    shows="From an isotropic stress of 80 kPa, normally consolidated and with OCR 1.4: strains over the stress path.",
    given="M = 0.95, λ = 0.2, κ = 0.04, e₀ = 1.1, ν = 0.3",
    source=f"{WOOD}, chapter 5: rate equations",
    reference="quadrature of elastic and plastic strain rates over p along q = 3 (p − p₀)",
    allowed="integration errors, bounded by the tolerance of 1e-9 of strain",
)
def drained() -> Answer:
    """Stress and volume over strain."""
    p0 = 80.0
    pressures = p0 + (3.0 * p0 / (3.0 - EXACT.M) - p0) * np.array([0.05, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95])
    checks, curves = [], []
    for OCR in (1.0, 1.4):
        soil = _clay(OCR=OCR)
        strains = np.array([EXACT.drained_strains(p, p0, OCR * p0) for p in pressures.tolist()])
        end = float(strains[-1, 1])
        times = np.unique(np.concatenate([strains[:, 1] / end, np.linspace(0.002, 1.0, 50)]))
        history = follow(soil, _isotropic(p0, soil), [drained_triaxial(end, p0, 1.0)], [times], tolerance=1.0e-9)
        at = np.searchsorted(times, strains[:, 1] / end)
        volume = history.strain[:, :3].sum(axis=1)
        checks.append(check(f"mean stress, OCR {OCR:g}", "kPa", history.p[at], pressures, 1.0e-6))
        checks.append(check(f"volume strain, OCR {OCR:g}", "", volume[at], strains[:, 0], 1.0e-5))
        curves.append(Curve(f"OCR {OCR:g}", 100 * times * end, history.q, 100 * strains[:, 1], 3.0 * (pressures - p0)))
    return Answer(tuple(checks), Plot("axial strain [%]", "q [kPa]", tuple(curves)))


@case(
    "cam-clay-softening",
    "Overconsolidated clay: peak and critical state",
    shows="Drained compression from 50 kPa with OCR 6: the peak is on the yield surface, the end on the critical line.",
    given="M = 0.95, λ = 0.2, κ = 0.04, e₀ = 1.1, ν = 0.3",
    source=f"{WOOD}, chapters 5 and 6",
    reference="peak: p + q²/(M² p) = OCR p₀ with q = 3 (p − p₀); end: q = M p, v = Γ − λ ln p",
    allowed="the peak lies between readings (0.5 %); the end is reached to 1e-6 after 300 % of strain",
)
def softening() -> Answer:
    """Peak and end."""
    soil, p0, OCR, M = _clay(OCR=6.0), 50.0, 6.0, EXACT.M
    times = np.concatenate([np.linspace(1.0e-4, 0.02, 200), np.geomspace(0.022, 1.0, 40)])
    history = follow(soil, _isotropic(p0, soil), [drained_triaxial(3.0, p0, 1.0)], [times], tolerance=1.0e-7)
    peak = brentq(lambda p: p + 9.0 * (p - p0) ** 2 / (M**2 * p) - OCR * p0, p0, 4.0 * p0)
    end = 3.0 * p0 / (3.0 - M)
    first = 1.0 + CLAY["e0"] + 0.2 * math.log(OCR * p0) - 0.04 * math.log(OCR)
    volume = first - 0.2 * math.log(end) - 0.16 * math.log(2.0)
    checks = (
        check("mean stress at the peak", "kPa", history.p.max(), peak, 5.0e-3),
        check("mean stress at the end", "kPa", history.p[-1], end, 1.0e-6),
        check("specific volume at the end", "", 1.0 + history.internal[-1, 1], volume, 1.0e-6),
    )
    top = float(300.0 * times[int(np.argmax(history.p))])
    curve = Curve("", 300.0 * times, history.q, np.array([top, 300.0]), 3.0 * (np.array([peak, end]) - p0))
    return Answer(checks, Plot("axial strain [%]", "q [kPa]", (curve,), log_x=True))


@case(
    "cam-clay-simple-shear",
    "Direct simple shear of clay at constant volume",
    shows="From K0 = 0.6 with OCR 1 and 4: stresses at the critical state.",
    given="M = 1, λ = 0.2, κ = 0.04, e₀ = 1, ν = 0.25, vertical stress 100 kPa",
    source=f"{WOOD}, section 5.4, with the stress sheared purely",
    reference="τ = M p_f/√3, σ_v = p_f = p₀ (p_c/(2 p₀))^Λ",
    allowed="remaining distance from the critical state after 90 % of shear strain",
)
def sheared() -> Answer:
    """Shear stress over strain, and its end."""
    M, plastic = 1.0, 0.8
    clay = {"M": M, "lambda": 0.2, "kappa": 0.04, "nu": 0.25, "e0": 1.0}
    checks, curves = [], []
    gamma = np.concatenate([np.linspace(0.002, 0.1, 40), np.linspace(0.12, 0.9, 30)])
    for OCR in (1.0, 4.0):
        p0 = 100.0 * 2.2 / 3.0
        past = OCR * (p0 + 40.0**2 / (M**2 * p0))
        end = p0 * (past / (2.0 * p0)) ** plastic
        spec = simple_shear("modified_cam_clay", [{"shear_strain": 0.9}], initial_ratio=0.6, tolerance=1.0e-6)
        tau, normal = run(spec, clay | {"OCR": OCR}, gamma, "shear_stress", "normal_stress")
        strength = M * end / math.sqrt(3.0)
        checks += [
            check(f"shear stress, OCR {OCR:g}", "kPa", tau[-1], strength, 1.0e-6),
            check(f"normal stress, OCR {OCR:g}", "kPa", normal[-1], end, 1.0e-6),
        ]
        curves.append(Curve(f"OCR {OCR:g}", 100 * gamma, tau, np.array([90.0]), np.array([strength])))
    return Answer(tuple(checks), Plot("shear strain [%]", "shear stress [kPa]", tuple(curves)))


SOFT: dict[str, Any] = {"lambda_star": 0.11, "kappa_star": 0.02, "nu_ur": 0.15, "phi": 28.0}
BRINKGREVE = "Brinkgreve (1994), Geomaterial models and numerical analysis of softening; PLAXIS, soft soil model"


@case(
    "soft-soil-isotropic",
    "Soft soil: both lines of isotropic compression",
    shows="Loaded, unloaded and loaded again beyond a past stress of 1.6 times the first one.",
    given="λ* = 0.11, κ* = 0.02, ν = 0.15, φ = 28°, c = 12 kPa, from 50 kPa",
    source=BRINKGREVE,
    reference="ε_v = κ* ln(P/P₀) below the past stress, λ* ln(P/P_p) more beyond it; P = p + c cot φ",
    allowed="rounding: stress paths along the lines are integrated exactly",
)
def soft_soil_lines() -> Answer:
    """Strain over stress."""
    soil = find_law("soft_soil").soil({**SOFT, "c": 12.0, "OCR": 1.6})
    a = 12.0 / math.tan(math.radians(28.0))
    up, down, again = np.geomspace(52.0, 300.0, 19), np.geomspace(270.0, 40.0, 9), np.geomspace(45.0, 500.0, 15)
    loads = np.concatenate([up, down, again])
    history = follow(
        soil, _isotropic(50.0, soil), [isotropic_load(p, 1.0) for p in loads.tolist()], [[1.0]] * loads.size,
        tolerance=1.0e-8,
    )  # fmt: skip
    exact, past, before, total = [], 1.6 * (50.0 + a), 50.0 + a, 0.0
    for P in (loads + a).tolist():
        total += 0.02 * math.log(P / before)
        if past < P:
            total, past = total + 0.09 * math.log(P / past), P
        before = P
        exact.append(total)
    ours = history.strain[:, :3].sum(axis=1)
    curve = Curve("", loads, 100 * ours, loads[::2], 100 * np.array(exact)[::2])
    return Answer(
        (check("volume strain", "", ours, exact, 1.0e-9, scale=1.0, of="absolute"),),
        Plot("mean stress [kPa]", "volume strain [%]", (curve,), log_x=True, downwards=True),
    )


@case(
    "soft-soil-oedometer",
    "Soft soil: one-dimensional compression and stress ratio at rest",
    shows="Loads from 50 to 400 kPa, then 300 kPa: slope λ*, the given stress ratio K0nc, elastic swelling.",
    given="λ* = 0.11, κ* = 0.02, ν = 0.15, φ = 28°, c = 0, K0nc = 0.45 and 0.6",
    source=BRINKGREVE,
    reference="ε = λ* ln(σ_v/σ_v0), σ_h = K0nc σ_v; unloading dσ_h = ν/(1 − ν) dσ_v",
    allowed="integration errors, bounded by the tolerance of 1e-8 of strain",
)
def soft_soil_oedometer() -> Answer:
    """Stress path and strain."""
    ratios, curves, checks = (0.45, 0.6), [], []
    loads = np.array([60.0, 80.0, 120.0, 200.0, 280.0, 400.0, 300.0])
    for K0 in ratios:
        soil = find_law("soft_soil").soil({**SOFT, "c": 0.0, "K0nc": K0})
        start = point_under([K0 * 50.0, K0 * 50.0, 50.0, 0.0, 0.0, 0.0], soil)
        stages = [confined_load(load, 1.0) for load in loads.tolist()]
        history = follow(soil, start, stages, [[1.0]] * loads.size, tolerance=1.0e-8)
        lateral = K0 * loads
        lateral[-1] = lateral[-2] - 100.0 * 0.15 / 0.85
        strain = 0.11 * np.log(loads[:-1] / 50.0)
        checks.append(check(f"horizontal stress, K0nc {K0:g}", "kPa", history.stress[:, 0], lateral, 1.0e-6))
        checks.append(check(f"axial strain, K0nc {K0:g}", "", history.strain[:-1, 2], strain, 1.0e-6))
        curves.append(Curve(f"K0nc = {K0:g}", loads, history.stress[:, 0], loads, lateral))
    return Answer(tuple(checks), Plot("vertical stress [kPa]", "horizontal stress [kPa]", tuple(curves)))


@case(
    "cam-clay-at-rest",
    "Stress ratio at rest of modified Cam clay",
    shows="One-dimensional compression from an isotropic stress of 20 kPa, for four slopes M: final stress ratio.",
    given="M = 0.7 to 1.3, λ = 0.2, κ = 0.04, e₀ = 1.1, ν = 0.3",
    source=f"{WOOD}, chapter 10: shear strain is 2/3 of volume strain",
    reference="2η/(M² − η²) Λ + η κ/(3 λ G/K) = 2/3 with K0 = (3 − η)/(3 + 2η)",
    allowed="remaining effect of the initial stress ratio after 50 % of strain",
)
def at_rest() -> Answer:
    """K0 over M."""
    slopes = np.array([0.7, 0.9, 1.1, 1.3])
    ours = []
    for M in slopes.tolist():
        soil = _clay(M=M)
        stage = constant_rate_oedometer(0.5, 1.0)
        end = follow(soil, _isotropic(20.0, soil), [stage], [[1.0]], tolerance=1.0e-8).stress[0]
        ours.append(end[0] / end[2])
    eta = np.array([CamClay(M=M, lambda_=0.2, kappa=0.04, e0=1.1, nu=0.3).eta_at_rest() for M in slopes.tolist()])
    exact = (3.0 - eta) / (3.0 + 2.0 * eta)
    return Answer(
        (check("K0", "", ours, exact, 1.0e-6),),
        Plot("M [-]", "K0 [-]", (Curve("", slopes, np.array(ours), slopes, exact),)),
    )


CASES = (undrained, drained, softening, at_rest, sheared, soft_soil_lines, soft_soil_oedometer)
