"""Consolidation of specimens: loads at once and growing, constant rate of strain."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from geoswarm.verification.case import Answer, Curve, Plot, case, check
from geoswarm.verification.exact.consolidation import crs_strain, degree, isochrone, ramped_degree
from geoswarm.verification.specimens.grounds import WATER
from geoswarm.verification.specimens.laboratory import consolidation, crs_oedometer, run

__all__ = ["CASES"]

STIFF, K, HEIGHT, RATE = 2.0e3, 2.0e-5, 0.02, 0.25
"""kPa, m/day, m, 1/day."""
SOIL = {"E": STIFF, "nu": 0.0, "k": K}
TIME = HEIGHT**2 * WATER / (K * STIFF)
"""Of consolidation, day."""
CELLS = "discretisation errors of 60 cells over the height, proportional to the square of the cell size"


@case(
    "consolidation-terzaghi",
    "Consolidation under a load that acts at once",
    shows="A linearly elastic specimen of 2 cm, drained at one side: settlement, and pore pressure at the closed side.",
    given="E = 2 MPa, ν = 0, k = 2·10⁻⁵ m/day, H = 2 cm, Δσ = 100 kPa",
    source="Terzaghi & Fröhlich (1936), Theorie der Setzung von Tonschichten",
    reference="U = 1 − Σ 2/M² exp(−M² T),  u/Δσ = Σ 2/M sin M exp(−M² T),  M = (m + ½) π,  T = c_v t/H²",
    allowed=CELLS,
)
def terzaghi() -> Answer:
    """Degree and pore pressure over the time factor."""
    T = np.geomspace(1.0e-3, 3.0, 40)
    spec = consolidation(
        "elastic", [(200.0, 3.1 * TIME)], geometry="fixed", drainage="one_side", cells=60, tolerance=1.0e-6
    )
    settlement, pore = run(spec, SOIL, T * TIME, "settlement", "pore_pressure")
    ours, pressure = settlement / (HEIGHT * 100.0 / STIFF), pore / 100.0
    U, u = degree(T), isochrone(1.0, T)
    checks = (
        check("degree of consolidation", "", ours, U, 2.0e-4, scale=1.0, of="absolute"),
        check("pore pressure over the load", "", pressure, u, 2.0e-4, scale=1.0, of="absolute"),
    )
    curves = (
        Curve("degree of consolidation", T, ours, T[::3], U[::3]),
        Curve("pore pressure at the closed side", T, pressure, T[::3], u[::3]),
    )
    return Answer(checks, Plot("time factor T [-]", "share of the load [-]", curves, log_x=True))


@case(
    "consolidation-olson",
    "Consolidation under a load that grows",
    shows="The load grows within a time factor of 0.2, stays, and is taken off in the same way.",
    given="E = 2 MPa, ν = 0, k = 2·10⁻⁵ m/day, H = 2 cm, Δσ = 100 kPa",
    source="Olson (1977), Consolidation under time dependent loading",
    reference="the mean of Terzaghi's degree over the loads before; unloading mirrors loading",
    allowed=CELLS,
)
def olson() -> Answer:
    """Degree over the time factor."""
    T = np.geomspace(3.0e-3, 3.0, 40)
    stages = [(200.0, 20.0 * TIME, 0.2 * TIME), (100.0, 4.0 * TIME, 0.2 * TIME)]
    spec = consolidation("elastic", stages, geometry="fixed", drainage="one_side", cells=60, tolerance=1.0e-6)
    up, down = run(spec, SOIL, T * TIME, "branch_1.settlement", "branch_2.settlement")
    end = HEIGHT * 100.0 / STIFF
    exact = ramped_degree(T, 0.2)
    checks = (
        check("degree, loading", "", up / end, exact, 2.0e-4, scale=1.0, of="absolute"),
        check("degree, unloading", "", -down / end, exact, 2.0e-4, scale=1.0, of="absolute"),
    )
    curve = Curve("", T, up / end, T[::3], exact[::3])
    return Answer(checks, Plot("time factor T [-]", "degree of consolidation [-]", (curve,), log_x=True))


@case(
    "consolidation-rate-transient",
    "Constant rate of strain: the beginning",
    shows="Stress at the top and pore pressure at the base from the first reading to the steady state.",
    given="E = 2 MPa, ν = 0, k = 2·10⁻⁵ m/day, H = 2 cm, r = 0.25 per day",
    source="Wissa, Christian, Davis & Heiberg (1971), equation 5; Carslaw & Jaeger (1959), section 3.8",
    reference="Fourier series of the strain over the height under a constant inflow at the top",
    allowed="errors of 160 intervals over the height and of the step in time, 5e-4 of E r H²/c_v",
)
def transient() -> Answer:
    """Pore pressure and stress over the time factor."""
    T = np.geomspace(0.01, 3.0, 30)
    spec = crs_oedometer(
        "elastic", [{"axial_strain": 3.01 * TIME * RATE, "rate": RATE}], geometry="fixed", intervals=160, tolerance=1e-7
    )
    stress, pore = run(spec, SOIL, T * TIME, "time_axial_stress", "time_pore_pressure")
    size = STIFF * RATE * TIME
    top = np.array([crs_strain(1.0, t) for t in T.tolist()])
    base = np.array([crs_strain(0.0, t) for t in T.tolist()])
    excess = (stress - 100.0 - STIFF * RATE * T * TIME) / size
    checks = (
        check("excess of the stress at the top", "", excess, top, 5.0e-4, scale=1.0, of="E r H²/c_v"),
        check("pore pressure at the base", "", pore / size, top - base, 5.0e-4, scale=1.0, of="E r H²/c_v"),
    )
    curves = (
        Curve("excess stress at the top", T, excess, T[::2], top[::2]),
        Curve("pore pressure at the base", T, pore / size, T[::2], (top - base)[::2]),
    )
    return Answer(checks, Plot("time factor T [-]", "over E r H²/c_v [-]", curves, log_x=True))


@case(
    "consolidation-rate-steady",
    "Constant rate of strain: the steady state",
    shows="Pore pressure at the base after four times the time of consolidation, for rates over two decades.",
    given="E = 2 MPa, ν = 0, k = 2·10⁻⁵ m/day, H = 2 cm, r = 0.01 to 1 per day",
    source="Wissa, Christian, Davis & Heiberg (1971); ASTM D4186",
    reference="u_b = γ_w r H²/(2 k);  the mean effective stress is below the total one by two thirds of it",
    allowed="step in time for the pore pressure; error 1/(6 N²) = 4e-4 of the trapezoidal rule (N = 20) for the mean",
)
def steady() -> Answer:
    """Pore pressure over the rate."""
    rates = np.geomspace(0.01, 1.0, 7)
    pores, means = [], []
    for rate in rates.tolist():
        end = 4.0 * TIME * rate
        spec = crs_oedometer(
            "elastic", [{"axial_strain": end, "rate": rate}], geometry="fixed", intervals=20, tolerance=1.0e-7
        )
        pore, stress, mean = run(spec, SOIL, end, "pore_pressure", "axial_stress", "mean_effective_stress")
        pores.append(pore[0])
        means.append((stress[0] - mean[0]) / pore[0])
    exact = WATER * rates * HEIGHT**2 / (2.0 * K)
    checks = (
        check("pore pressure at the base", "kPa", pores, exact, 1.0e-6),
        check("share lost by the mean effective stress", "", means, 2.0 / 3.0, 1.0e-3),
    )
    curve = Curve("", rates, np.array(pores), rates, exact)
    return Answer(checks, Plot("rate of strain [1/day]", "pore pressure [kPa]", (curve,), log_x=True, log_y=True))


@case(
    "consolidation-dissipation",
    "Dissipation after compression at constant rate",
    shows="Held under a constant stress, or at a constant height, the pore pressure decays as its slowest mode.",
    given="E = 2 MPa, ν = 0, k = 2·10⁻⁵ m/day, H = 2 cm; 2 % of strain at 0.25 per day before",
    source="Terzaghi & Fröhlich (1936); at constant height no water leaves and the first mode is a full cosine",
    reference="exp(−π² T/4) under a constant stress, exp(−π² T) at a constant height",
    allowed="remaining higher modes, and errors of 160 intervals",
)
def dissipation() -> Answer:
    """Pore pressure over the time factor."""
    checks, curves = [], []
    first = 0.02 / RATE
    for keep, mode, spread in (("stress", 0.25, (1.0, 2.0)), ("strain", 1.0, (0.5, 1.0))):
        T = np.linspace(*spread, 11)
        hold = {"kind": "hold", "keep": keep, "duration": 4.0 * TIME}
        stages: list[dict[str, Any]] = [{"axial_strain": 0.02, "rate": RATE}, hold]
        spec = crs_oedometer("elastic", stages, geometry="fixed", intervals=160, tolerance=1.0e-8)
        (pore,) = run(spec, SOIL, first + TIME * T, "time_pore_pressure")
        ours, exact = pore / pore[0], np.exp(-(math.pi**2) * mode * (T - T[0]))
        checks.append(check(f"share left, constant {keep}", "", ours, exact, 1.0e-3))
        curves.append(Curve(f"constant {'stress' if keep == 'stress' else 'height'}", T, ours, T, exact))
    return Answer(
        tuple(checks), Plot("time factor T [-]", "pore pressure over the first [-]", tuple(curves), log_y=True)
    )


CASES = (terzaghi, olson, transient, steady, dissipation)
