"""Layered ground: isochrones, two layers, vertical drains, mud under its own weight."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import quad, solve_ivp

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.column.drains import equal_strain
from geoswarm.solver.column.section import ColumnSpec
from geoswarm.verification.case import Answer, Curve, Plot, case, check
from geoswarm.verification.exact.consolidation import barron, degree, isochrone, mu_by_quadrature, two_layers
from geoswarm.verification.specimens.grounds import MUD, WATER, ground, slurry
from geoswarm.verification.specimens.laboratory import run

__all__ = ["CASES"]

STIFF, K, HEIGHT, LOAD = 2.0e3, 1.0e-4, 8.0, 50.0
"""kPa, m/day, m, kPa."""
TIME = HEIGHT**2 * WATER / (K * STIFF)
SOIL = {"a.E": STIFF, "a.nu": 0.0, "a.k": K}
OF_A_TRIANGLE = math.sqrt(2.0 * math.sqrt(3.0) / math.pi)
"""Diameter of the circle with the area that belongs to a drain, over the spacing of a triangular pattern: 1.05."""
DRAINS = {"spacing": 1.5, "diameter": 0.066, "bottom": HEIGHT}


def _elastic(layers: Any = (("a", HEIGHT),), stages: Any = ((LOAD, 3.0 * TIME),), **changes: Any) -> ColumnSpec:
    soils = {name: {"material": "elastic"} for name, _ in layers}
    return ground(layers, soils, stages, **{"geometry": "fixed", "tolerance": 1.0e-6, "cells": 60, **changes})


@case(
    "ground-isochrones",
    "Isochrones of Terzaghi",
    shows="Eight metres of elastic ground on a closed base: excess pore pressure over the depth at five time factors.",
    given="E = 2 MPa, ν = 0, k = 10⁻⁴ m/day, H = 8 m, Δσ = 50 kPa",
    source="Terzaghi & Fröhlich (1936)",
    reference="u/Δσ = Σ 2/M sin(M z/H) exp(−M² T)",
    allowed="errors of 60 cells over the height; they are largest above 1 m at the first of these times",
)
def isochrones() -> Answer:
    """Pore pressure over depth."""
    depths = HEIGHT * np.linspace(0.0625, 1.0, 16)
    T = np.array([0.02, 0.08, 0.2, 0.5, 1.0])
    spec = _elastic(points={f"P{number}": {"depth": float(depth)} for number, depth in enumerate(depths)})
    names = [f"P{number}.excess_pore_pressure" for number in range(depths.size)]
    ours = np.array(run(spec, SOIL, T * TIME, *names)) / LOAD
    exact = np.array([isochrone(float(z), T) for z in depths / HEIGHT])
    curves = tuple(
        Curve(f"T = {t:g}", ours[:, i], depths, exact[::2, i], depths[::2]) for i, t in enumerate(T.tolist())
    )
    plot = Plot("excess pore pressure over the load [-]", "depth [m]", curves, downwards=True)
    return Answer(
        (check("excess pore pressure over the load", "", ours, exact, 4.0e-4, scale=1.0, of="absolute"),), plot
    )


@case(
    "ground-two-layers",
    "Two layers",
    shows="Three metres on five metres that are softer, with 0.02, 0.5 and 30 times the permeability.",
    given="upper layer E = 2 MPa, k = 10⁻⁴ m/day; lower layer E = 0.8 MPa; closed base, Δσ = 50 kPa",
    source="Gray (1945), Simultaneous consolidation of contiguous layers of unlike compressible soils",
    reference="separated variables: shapes and frequencies by the conditions where the layers meet",
    allowed="errors of 60 cells over the height, 5e-4 of the final settlement",
)
def layers() -> Answer:
    """Settlement over time."""
    factors = np.geomspace(3.0e-3, 1.5, 20)
    checks, curves = [], []
    for ratio in (0.02, 0.5, 30.0):
        upper, lower = (3.0, K, STIFF), (5.0, ratio * K, 0.4 * STIFF)
        time = 25.0 * WATER / (lower[1] * lower[2]) + 9.0 * WATER / (K * STIFF)
        spec = _elastic((("a", 3.0), ("b", 5.0)), [(LOAD, 2.0 * time)])
        (settlement,) = run(spec, SOIL | {"b.E": lower[2], "b.nu": 0.0, "b.k": lower[1]}, factors * time, "settlement")
        end = LOAD * (3.0 / upper[2] + 5.0 / lower[2])
        ours, exact = settlement / end, LOAD * two_layers(factors * time, upper, lower, WATER) / end
        checks.append(check(f"settlement, k ratio {ratio:g}", "", ours, exact, 5.0e-4, scale=1.0, of="the final one"))
        curves.append(Curve(f"k ratio {ratio:g}", factors, ours, factors[::2], exact[::2]))
    label = "time over the sum of the layers' own [-]"
    return Answer(
        tuple(checks), Plot(label, "share of the final settlement [-]", tuple(curves), log_x=True, downwards=True)
    )


@case(
    "ground-drains",
    "Flow to vertical drains: Barron and Hansbo",
    shows="Drains of 66 mm every 1.5 m, plain, with a smeared zone, and with a finite discharge capacity.",
    given=(
        "E = 2 MPa, k_h = 10⁻³ m/day, H = 8 m, triangular pattern; smear to 0.2 m with a third of the "
        "permeability; q_w = 0.05 m³/day"
    ),
    source="Barron (1948); Hansbo (1981), Consolidation of fine-grained soils by prefabricated drains",
    reference=(
        "u/Δσ = exp(−8 c_h t/(μ d_e²)),  μ with smear by quadrature of the flow, plus π z (2l − z)(1 − 1/n²) k_h/q_w"
    ),
    allowed="time integration errors and the small upward flow, 1e-5 of the load",
)
def drains() -> Answer:
    """Pore pressure at mid-depth over time."""
    horizontal, outer, z = 1.0e-3, OF_A_TRIANGLE * 1.5, 4.0
    n = outer / 0.066
    plain = barron(n)
    unit = outer**2 * WATER / (8.0 * horizontal * STIFF)
    x = plain * unit * np.linspace(0.1, 3.0, 15)
    variants: tuple[tuple[str, dict[str, float], float, float], ...] = (
        ("plain", {}, 1.0, math.inf),
        ("smeared", {"smear_diameter": 0.2, "smear_ratio": 3.0}, 3.0, math.inf),
        ("capacity 0.05 m³/day", {"discharge_capacity": 0.05}, 1.0, 0.05),
    )
    mus, exact_mus, checks, curves = [], [], [], []
    for label, more, ratio, capacity in variants:
        s = more.get("smear_diameter", 0.066) / 0.066
        mu = mu_by_quadrature(n, s, ratio)
        mus.append(equal_strain(n, s, ratio))
        exact_mus.append(mu)
        well = math.pi * z * (2.0 * HEIGHT - z) * (1.0 - 1.0 / n**2) * horizontal / capacity
        points = {"P": {"depth": z}}
        spec = _elastic(stages=[(LOAD, float(x[-1]))], drains={**DRAINS, **more}, cells=40, points=points)
        values = SOIL | {"a.k": 1.0e-9, "a.k_ratio": horizontal / 1.0e-9}
        (pore,) = run(spec, values, x, "P.excess_pore_pressure")
        exact = np.exp(-x / (unit * (mu + well)))
        checks.append(
            check(f"pore pressure over the load, {label}", "", pore / LOAD, exact, 1.0e-5, scale=1.0, of="absolute")
        )
        curves.append(Curve(label, x, pore / LOAD, x[::2], exact[::2]))
    checks.append(check("μ of equal strain", "", mus, exact_mus, 1.0e-6))
    plot = Plot("time [day]", "excess pore pressure over the load [-]", tuple(curves))
    return Answer(tuple(checks), plot)


@case(
    "ground-carrillo",
    "Flow upwards and to drains at once",
    shows="Drains every 3 m in ground that drains upwards as well.",
    given="E = 2 MPa, k_v = 10⁻⁴ m/day, k_h = 5 k_v, H = 8 m, triangular pattern",
    source="Carrillo (1942), Simple two and three dimensional cases in the theory of consolidation of soils",
    reference="1 − U = (1 − U_v)(1 − U_h)",
    allowed="errors of 60 cells over the height",
)
def carrillo() -> Answer:
    """Settlement over the time factor."""
    T = np.geomspace(3.0e-3, 1.0, 16)
    outer = OF_A_TRIANGLE * 3.0
    time = barron(outer / 0.066) * outer**2 * WATER / (8.0 * 5.0 * K * STIFF)
    spec = _elastic(drains={**DRAINS, "spacing": 3.0})
    (settlement,) = run(spec, SOIL | {"a.k_ratio": 5.0}, T * TIME, "settlement")
    ours, vertical = settlement / (LOAD * HEIGHT / STIFF), degree(T)
    exact = 1.0 - (1.0 - vertical) * np.exp(-T * TIME / time)
    curve = Curve("with drains", T, ours, T[::2], exact[::2])
    plot = Plot(
        "time factor T of the flow upwards [-]", "degree of consolidation [-]", (curve,), log_x=True, downwards=True
    )
    return Answer((check("degree of consolidation", "", ours, exact, 5.0e-4, scale=1.0, of="absolute"),), plot)


def _by_lines(times: FloatArray, count: int) -> FloatArray:
    """Settlement of the mud with equal nodes of particles and another way in time.

    dJ/dt = d/dZ[(k/gamma_w)(1/J) du/dZ], u = weight - sigma'(J) (Gibson, England & Hussey 1967).
    """
    z = np.linspace(0.0, 5.0, count)  # from the top; e is known there
    h = z[1] - z[0]

    def flow(_: float, inside: FloatArray) -> FloatArray:
        J = np.concatenate([[1.0], inside])
        u = 3.19 * z + 1.0 - J ** (-1.0 / 0.12)
        u[0] = 0.0
        mobile = 2.0e-3 / WATER * 10.0 ** (5.0 * (J - 1.0) / 1.5) / J
        between = np.sqrt(mobile[1:] * mobile[:-1]) * np.diff(u) / h
        rate: FloatArray = np.diff(np.append(between, -between[-1])) / h
        return rate

    found = solve_ivp(
        flow, (0.0, times[-1]), np.ones(count - 1), "LSODA", times, rtol=1e-8, atol=1e-10, lband=1, uband=1
    )
    J = np.vstack([np.ones(times.size), found.y])
    return np.asarray(np.trapezoid(1.0 - J, z, axis=0))


@case(
    "ground-gibson",
    "Large strains: mud under its own weight",
    shows="Five metres of slurry with e = 4, with a permeability that decreases with the void ratio, over 3000 days.",
    given="λ* = 0.12, κ* = 0.01, k = 2·10⁻³ m/day at e = 4, C_k = 1.5, γ = 13 kN/m³",
    source="Gibson, England & Hussey (1967), The theory of one-dimensional consolidation of saturated clays",
    reference="method of lines on 101 and 201 equal nodes of particles, extrapolated to zero spacing (LSODA)",
    allowed="errors of 60 cells, 0.1 %",
)
def gibson() -> Answer:
    """Settlement over time."""
    times = np.geomspace(20.0, 3000.0, 12)
    (settlement,) = run(slurry(3000.0, {}), MUD, times, "settlement")
    middle, fine = _by_lines(times, 101), _by_lines(times, 201)
    exact = fine + (fine - middle) / 3.0  # of second order
    plot = Plot(
        "time [day]", "settlement [m]", (Curve("", times, settlement, times, exact),), log_x=True, downwards=True
    )
    return Answer((check("settlement", "m", settlement, exact, 1.0e-3),), plot)


@case(
    "ground-gibson-end",
    "Large strains: the end of self-weight consolidation",
    shows="The same slurry when all excess pore pressure is gone: void ratio and effective stress over the depth.",
    given="λ* = 0.12, κ* = 0.01, k = 2·10⁻³ m/day at e = 4, C_k = 1.5, γ = 13 kN/m³",
    source="Gibson, England & Hussey (1967): equilibrium of the weight under water",
    reference="σ′ = 1 kPa + (γ − γ_w) Z,  ln(1 + e) = ln 5 − λ* ln(σ′/1 kPa),  Z the depth of the particles",
    allowed="errors of 60 cells, 1e-3",
)
def gibson_end() -> Answer:
    """Void ratio over depth."""
    depths = np.array([0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5])
    points = {f"P{number}": {"depth": float(depth)} for number, depth in enumerate(depths)}
    names = [f"{name}.{kind}" for kind in ("void_ratio", "effective_stress") for name in points]
    settlement, *found = run(slurry(2.0e5, points), MUD, np.array([2.0e5]), "settlement", *names)
    ratios, stresses = np.array(found)[:, 0].reshape(2, -1)
    wanted = 5.0 * (1.0 + 3.19 * depths) ** -0.12 - 1.0
    end = quad(lambda z: 1.0 - (1.0 + 3.19 * z) ** -0.12, 0.0, 5.0)[0]
    checks = (
        check("void ratio", "", ratios, wanted, 5.0e-4),
        check("effective stress", "kPa", stresses, 1.0 + 3.19 * depths, 1.0e-3),
        check("settlement", "m", settlement, end, 3.0e-4),
    )
    curve = Curve("", ratios, depths, wanted, depths)
    return Answer(
        checks, Plot("void ratio [-]", "depth of the particles at the beginning [m]", (curve,), downwards=True)
    )


CASES = (isochrones, layers, drains, carrillo, gibson, gibson_end)
