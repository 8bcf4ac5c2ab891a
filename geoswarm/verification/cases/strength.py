"""Strength and dilatancy of the laws that yield: triaxial, plane strain, simple shear, tension."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np

from geoswarm.solver.element_test.boundary_conditions import Stage, strain_change, stress_value
from geoswarm.solver.element_test.material_point import follow, point_under
from geoswarm.solver.element_test.setups import drained_triaxial
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.verification.case import Answer, Case, Curve, Plot, case, check
from geoswarm.verification.exact.hypoplasticity import davis, plane_sine, triaxial_axial
from geoswarm.verification.specimens.laboratory import run, simple_shear

__all__ = ["CASES"]

C = 4.0
ELASTIC = {"E": 1.0e4, "nu": 0.25}
LAWS: dict[str, tuple[str, dict[str, Any]]] = {
    "Mohr-Coulomb": ("mohr_coulomb", {}),
    "Matsuoka-Nakai": ("matsuoka_nakai", {}),
    "Drucker-Prager": ("drucker_prager", {"match": "plane_strain"}),
}
ANGLES = np.array([15.0, 20.0, 25.0, 30.0, 35.0, 40.0])
NO_SHEAR = tuple(strain_change(0.0, **{name: 1}) for name in ("xy", "yz", "zx"))
RETURN = "the return to the limit is exact; integration errors are below the tolerance of 1e-7 of strain"


def _soil(name: str, **changes: Any) -> Soil:
    law, settings = LAWS[name]
    return find_law(law).soil({**ELASTIC, "c": C, "psi": 0.0, **settings, **changes})


@case(
    "strength-triaxial",
    "Triaxial strength in compression and extension",
    shows="At a cell pressure of 60 kPa with c = 4 kPa, friction angles of 15 to 40 degrees, no dilatancy.",
    given="E = 10 MPa, ν = 0.25, c = 4 kPa, ψ = 0",
    source="Mohr-Coulomb; Matsuoka & Nakai (1974): the same in both tests, I₁I₂/I₃ = 9 + 8 tan² φ",
    reference="σ_a + a = (σ_c + a) N^±1,  N = (1 + sin φ)/(1 − sin φ),  a = c cot φ",
    allowed=RETURN,
)
def triaxial() -> Answer:
    """Axial stress over friction angle."""
    checks, curves = [], []
    for name in ("Mohr-Coulomb", "Matsuoka-Nakai"):
        for way, words in ((1.0, "compression"), (-1.0, "extension")):
            ours, wanted = [], []
            for phi in ANGLES.tolist():
                soil = _soil(name, phi=phi)
                start = point_under([60.0, 60.0, 60.0, 0.0, 0.0, 0.0], soil)
                stage = drained_triaxial(way * 0.2, 60.0, 1.0)
                ours.append(follow(soil, start, [stage], [[1.0]], tolerance=1.0e-7).stress[0, 2])
                wanted.append(triaxial_axial(phi, C, 60.0, way))
            checks.append(check(f"axial stress, {name}, {words}", "kPa", ours, wanted, 1.0e-7))
            curves.append(Curve(f"{name}, {words}", ANGLES, np.array(ours), ANGLES, np.array(wanted)))
    return Answer(tuple(checks), Plot("friction angle [°]", "axial stress [kPa]", tuple(curves)))


@case(
    "strength-every-law",
    "The same strength from every law that has Mohr and Coulomb's",
    shows="Triaxial compression at 100 kPa with c = 5 kPa and φ = 25°, and the dilatancy after it with ψ = 5°.",
    given="c = 5 kPa, φ = 25°, ψ = 5°; stiffness of each law, past stress far away",
    source="Mohr-Coulomb with its non-associated flow",
    reference="q = 2 sin φ/(1 − sin φ) (σ₃ + c cot φ) = 162.0881 kPa;  dε_v/dε_a = −2 sin ψ/(1 − sin ψ)",
    allowed="integration errors, bounded by the tolerance of 1e-7 of strain",
)
def every_law() -> Answer:
    """Deviator over axial strain."""
    common = {"c": 5.0, "phi": 25.0, "psi": 5.0}
    soft = {"lambda_star": 0.1, "kappa_star": 0.02, "OCR": 20.0}
    stiff = {"E50_ref": 2.5e4, "Eoed_ref": 2.2e4, "Eur_ref": 8.0e4, "m": 0.5, "OCR": 50.0}
    laws: dict[str, dict[str, float]] = {
        "Mohr-Coulomb": {"E": 2.0e4, "nu": 0.3},
        "hardening soil": stiff,
        "soft soil": soft,
        "soft soil creep": soft | {"mu_star": 1.0e-5, "OCR": 50.0},
    }
    sine, flow = math.sin(math.radians(25.0)), math.sin(math.radians(5.0))
    strength = 2.0 * sine / (1.0 - sine) * (100.0 + 5.0 / math.tan(math.radians(25.0)))
    times = np.append(np.linspace(0.002, 0.8, 60), 1.0)
    checks, curves = [], []
    for name, values in laws.items():
        soil = find_law(re.sub("[ -]", "_", name.lower())).soil(common | values)
        start = point_under([100.0, 100.0, 100.0, 0.0, 0.0, 0.0], soil)
        history = follow(soil, start, [drained_triaxial(0.12, 100.0, 1.0)], [times], tolerance=1.0e-7)
        checks.append(check(f"q at failure, {name}", "kPa", history.q[-1], strength, 1.0e-7))
        more = history.strain[-1] - history.strain[-2]
        checks.append(check(f"dilatancy, {name}", "", more[:3].sum() / more[2], -2.0 * flow / (1.0 - flow), 1.0e-7))
        curves.append(Curve(name, 12 * times, history.q, np.array([12.0]), np.array([strength])))
    plot = Plot("axial strain [%]", "q [kPa]", tuple(curves), caption="Marker: strength.")
    return Answer(tuple(checks), plot)


@case(
    "strength-plane-strain",
    "Strength in plane strain without dilatancy",
    shows=(
        "With a smallest stress of 60 kPa: Mohr-Coulomb, the cone of Drucker and Prager that is matched to it, and "
        "Matsuoka-Nakai, which is stronger than in the triaxial test."
    ),
    given="E = 10 MPa, ν = 0.25, c = 4 kPa, ψ = 0",
    source="Drucker & Prager (1952); Matsuoka & Nakai (1974): no plastic strain out of the plane",
    reference="(σ₁ + a)/(σ₃ + a) = (1 + s)/(1 − s);  s = sin φ, or s² = 1 − 6/(6 + 8 tan² φ) for Matsuoka-Nakai",
    allowed="remaining elastic strain out of the plane after 60 % of strain",
)
def plane_strain() -> Answer:
    """Largest stress over friction angle."""
    checks, curves = [], []
    controls = (stress_value(60.0, xx=1), strain_change(0.0, yy=1), strain_change(0.6, zz=1), *NO_SHEAR)
    for name, (law, _) in LAWS.items():
        ours, wanted = [], []
        for phi in ANGLES.tolist():
            soil = _soil(name, phi=phi)
            start = point_under([60.0, 60.0, 60.0, 0.0, 0.0, 0.0], soil)
            history = follow(soil, start, [Stage("plane strain", 1.0, controls)], [[1.0]], tolerance=1.0e-7)
            ours.append(history.stress[0, 2])
            sine, a = plane_sine(law, phi), C / math.tan(math.radians(phi))
            wanted.append((60.0 + a) * (1.0 + sine) / (1.0 - sine) - a)
        checks.append(check(f"largest stress, {name}", "kPa", ours, wanted, 1.0e-6))
        curves.append(Curve(name, ANGLES, np.array(ours), ANGLES, np.array(wanted)))
    return Answer(tuple(checks), Plot("friction angle [°]", "largest stress [kPa]", tuple(curves)))


@case(
    "strength-simple-shear",
    "Direct simple shear: planes that do not stretch",
    shows="Mohr-Coulomb and the matched cone under 100 kPa with dilatancies of 0 to 30 degrees (φ = 30°, c = 5 kPa).",
    given="E = 20 MPa, ν = 0.3, c = 5 kPa, φ = 30°",
    source="Davis (1968), Theories of plasticity and the failure of soil masses",
    reference="τ/(σ_n + c cot φ) = sin φ cos ψ/(1 − sin φ sin ψ);  the specimen rises by tan ψ of the shear",
    allowed="remaining elastic strain after 40 % of shear",
)
def sheared() -> Answer:
    """Shear stress over dilatancy."""
    angles = np.array([0.0, 6.0, 12.0, 18.0, 24.0, 30.0])
    a = 5.0 / math.tan(math.radians(30.0))
    wanted = np.array([davis(30.0, psi) for psi in angles.tolist()]) * (100.0 + a)
    checks, curves = [], []
    for name in ("Mohr-Coulomb", "Drucker-Prager"):
        law, settings = LAWS[name]
        spec = simple_shear(
            law, [{"shear_strain": 0.4}], constant="normal_stress", settings=settings, geometry="fixed"
        )  # fmt: skip
        tau, rise = [], []
        for psi in angles.tolist():
            values = {"E": 2.0e4, "nu": 0.3, "c": 5.0, "phi": 30.0, "psi": psi}
            stress, vertical = run(spec, values, [0.35, 0.4], "shear_stress", "vertical_strain")
            tau.append(stress[-1])
            rise.append((vertical[0] - vertical[1]) / 0.05)
        checks.append(check(f"shear stress, {name}", "kPa", tau, wanted, 1.0e-6))
        checks.append(check(f"rise, {name}", "", rise, np.tan(np.radians(angles)), 1.0e-5, scale=1.0, of="absolute"))
        curves.append(Curve(name, angles, np.array(tau), angles, wanted))
    return Answer(tuple(checks), Plot("dilatancy angle [°]", "shear stress at failure [kPa]", tuple(curves)))


CASES: tuple[Case, ...] = (triaxial, every_law, plane_strain, sheared)
