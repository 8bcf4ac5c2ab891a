"""Soft soil: closed forms, integration of its rate equations, and soft soil creep as its creep vanishes.

a = c cot(phi), P = p + a, x = P (translated) or p. Brinkgreve (1994); PLAXIS Material Models Manual, soft soil model.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from geoswarm.solver.element_test.boundary_conditions import Stage, strain_change
from geoswarm.solver.element_test.material_point import PointState, follow, point_under
from geoswarm.solver.element_test.setups import (
    confined_load,
    constant_rate_oedometer,
    drained_triaxial,
    isotropic_load,
    undrained_triaxial,
)
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.forward.oedometer import OedometerSpec
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.report.laboratory import laboratory_values

LAMBDA, KAPPA, NU, PHI = 0.11, 0.02, 0.15, 28.0
CLAY: dict[str, Any] = {"lambda_star": LAMBDA, "kappa_star": KAPPA, "nu_ur": NU, "phi": PHI, "c": 0.0}
SHEAR = 1.5 * (1.0 - 2.0 * NU) / (1.0 + NU)
COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")


def clay(**changes: Any) -> Soil:
    """A soft clay."""
    return find_law("soft_soil").soil({**CLAY, **changes})


def triaxial(axial: float, lateral: float, soil: Soil) -> PointState:
    """Placed under an axial and a lateral stress."""
    return point_under([lateral, lateral, axial, 0.0, 0.0, 0.0], soil)


def attraction(c: float) -> float:
    """c cot(phi), kPa."""
    return c / math.tan(math.radians(PHI))


@pytest.mark.parametrize(("formulation", "c"), [("translated", 0.0), ("translated", 12.0), ("untranslated", 12.0)])
def test_isotropic_compression_follows_both_lines(formulation: str, c: float) -> None:
    soil = clay(c=c, formulation=formulation, OCR=1.6)
    shift = attraction(c) if formulation == "translated" else 0.0
    past = 1.6 * (50.0 + shift)
    loads = (60.0, 300.0, 40.0, 400.0)
    history = follow(
        soil, triaxial(50.0, 50.0, soil), [isotropic_load(load, 1.0) for load in loads], [[1.0]] * 4, tolerance=1.0e-8
    )
    x = [load + shift for load in loads]
    first = KAPPA * math.log(x[0] / (50.0 + shift))
    second = KAPPA * math.log(past / (50.0 + shift)) + LAMBDA * math.log(x[1] / past)
    third = second - KAPPA * math.log(x[1] / x[2])
    fourth = second + LAMBDA * math.log(x[3] / x[1])
    assert history.strain[:, :3].sum(axis=1) == pytest.approx([first, second, third, fourth], rel=1.0e-9)


@pytest.mark.parametrize("K0nc", [0.45, 0.6])
@pytest.mark.parametrize("c", [0.0, 8.0])
def test_one_dimensional_compression_and_swelling(K0nc: float, c: float) -> None:
    """Translated stresses keep the ratio K0nc with slope lambda*; swelling is elastic at nu/(1 - nu)."""
    soil, a = clay(K0nc=K0nc, c=c), attraction(c)
    lateral = K0nc * (50.0 + a) - a
    stages = [confined_load(load, 1.0) for load in (80.0, 200.0, 400.0, 300.0)]
    history = follow(soil, triaxial(50.0, lateral, soil), stages, [[1.0]] * 4, tolerance=1.0e-8)
    axial = history.stress[:, 2]
    assert (history.stress[:3, 0] + a) / (axial[:3] + a) == pytest.approx(K0nc, rel=1.0e-6)
    expected = LAMBDA * np.log((axial[:3] + a) / (50.0 + a))
    assert history.strain[:3, 2] == pytest.approx(expected, rel=1.0e-7)
    assert history.stress[3, 0] == pytest.approx(history.stress[2, 0] - 100.0 * NU / (1.0 - NU), rel=1.0e-6)
    swelling = KAPPA * math.log((history.p[3] + a) / (history.p[2] + a))
    assert history.strain[3, 2] - history.strain[2, 2] == pytest.approx(swelling, rel=1.0e-6)


def test_the_stress_ratio_at_rest_is_found_from_elsewhere() -> None:
    soil = clay(K0nc=0.55)
    history = follow(soil, triaxial(20.0, 20.0, soil), [constant_rate_oedometer(0.5, 1.0)], [[1.0]], tolerance=1.0e-8)
    assert history.stress[0, 0] / history.stress[0, 2] == pytest.approx(0.55, rel=1.0e-4)


def test_M_gives_the_stress_ratio_of_its_rates() -> None:
    """Steady one-dimensional compression with M given: elastic and plastic shear over volume strain are 2/3."""
    M = 1.25
    eta = brentq(
        lambda x: 2.0 * x / (M**2 - x**2) * (1.0 - KAPPA / LAMBDA) + x * KAPPA / LAMBDA / (3.0 * SHEAR) - 2.0 / 3.0,
        *(0.01, M - 0.01),
    )
    soil = clay(M=M)
    history = follow(soil, triaxial(20.0, 20.0, soil), [constant_rate_oedometer(0.6, 1.0)], [[1.0]], tolerance=1.0e-8)
    expected = (3.0 - eta) / (3.0 + 2.0 * eta)
    assert history.stress[0, 0] / history.stress[0, 2] == pytest.approx(expected, rel=1.0e-4)


@pytest.mark.parametrize("OCR", [1.0, 1.3])
def test_undrained_compression_ends_where_its_path_meets_the_strength(OCR: float) -> None:
    """p ((M^2 + eta^2)/M^2)^(1 - kappa*/lambda*) is constant at yield, up to q = M_c p of the friction angle."""
    soil, sine = clay(OCR=OCR), math.sin(math.radians(PHI))
    M, strength = float(soil.constants[3]), 6.0 * sine / (3.0 - sine)
    assert strength < M
    start = triaxial(100.0, 100.0, soil)
    times = [np.array([0.003, 0.01, 0.03, 0.2, 1.0])]
    history = follow(soil, start, [undrained_triaxial(0.3, 1.0)], times, tolerance=1.0e-8)
    eta, first = history.q / history.p, M * math.sqrt(OCR - 1.0)
    expected = 100.0 * np.minimum(((M**2 + first**2) / (M**2 + eta**2)) ** (1.0 - KAPPA / LAMBDA), 1.0)
    assert history.p == pytest.approx(expected, rel=1.0e-6)
    assert eta[-1] == pytest.approx(strength, rel=1.0e-7)


@pytest.mark.parametrize("psi", [0.0, 5.0])
def test_triaxial_strength_and_dilatancy(psi: float) -> None:
    soil = clay(c=5.0, phi=25.0, psi=psi, OCR=20.0)
    history = follow(
        soil, triaxial(100.0, 100.0, soil), [drained_triaxial(0.1, 100.0, 1.0)], [[0.5, 1.0]], tolerance=1.0e-7
    )
    assert history.q == pytest.approx([162.0881, 162.0881], abs=1.0e-3)
    volume, axial = np.diff(history.strain[:, :3].sum(axis=1))[0], np.diff(history.strain[:, 2])[0]
    sine = math.sin(math.radians(psi))
    assert volume / axial == pytest.approx(-2.0 * sine / (1.0 - sine), abs=1.0e-6)


def _tensor(components: np.ndarray, shear: float = 1.0) -> np.ndarray:
    xx, yy, zz, xy, yz, zx = components
    return np.array([[xx, shear * xy, shear * zx], [shear * xy, yy, shear * yz], [shear * zx, shear * yz, zz]])


@pytest.mark.parametrize(("formulation", "c"), [("translated", 0.0), ("translated", 10.0), ("untranslated", 10.0)])
def test_a_path_with_turning_axes_is_that_of_the_rate_equations(formulation: str, c: float) -> None:
    soil = clay(c=c, formulation=formulation, K0nc=0.5)
    a = attraction(c)
    shift, M = a if formulation == "translated" else 0.0, float(soil.constants[3])
    strain = np.array([0.015, 0.005, 0.05, 0.03, -0.015, 0.02])
    start = point_under([60.0, 70.0, 100.0, 4.0, -6.0, 2.0], soil)
    identity, rate = np.eye(3), _tensor(strain, 0.5)

    def stiff(tensor: np.ndarray, bulk: float) -> np.ndarray:
        trace = np.trace(tensor)
        return bulk * trace * identity + 2.0 * SHEAR * bulk * (tensor - trace / 3.0 * identity)

    def change(_: float, y: np.ndarray) -> np.ndarray:
        stress, past = y[:9].reshape(3, 3), y[9]
        p = np.trace(stress) / 3.0
        s = stress - p * identity
        bulk, P = (p + shift) / KAPPA, p + a
        normal = (1.0 - 1.5 * (s * s).sum() / (M * P) ** 2) * identity / 3.0 + 3.0 * s / (M**2 * P)
        grows = past / (LAMBDA - KAPPA) * np.trace(normal)
        multiplier = (normal * stiff(rate, bulk)).sum() / ((normal * stiff(normal, bulk)).sum() + grows)
        assert multiplier > 0.0
        return np.append(stiff(rate - multiplier * normal, bulk).ravel(), grows * multiplier)

    y = np.append(_tensor(start.stress).ravel(), math.exp(start.internal[0]))
    y = solve_ivp(change, (0.0, 1.0), y, method="DOP853", rtol=1.0e-11, atol=1.0e-10).y[:, -1]
    controls = tuple(strain_change(float(value), **{name: 1}) for value, name in zip(strain, COMPONENTS, strict=True))
    end = follow(soil, start, [Stage("path", 1.0, controls)], [[1.0]], tolerance=1.0e-9).end
    assert _tensor(end.stress) == pytest.approx(y[:9].reshape(3, 3), rel=1.0e-5, abs=1.0e-4)
    assert math.exp(end.internal[0]) == pytest.approx(y[9], rel=1.0e-6)


@pytest.mark.parametrize("path", ["oedometer", "undrained", "drained"])
@pytest.mark.parametrize("c", [0.0, 6.0])
def test_it_is_the_limit_of_soft_soil_creep(path: str, c: float) -> None:
    """Loaded within days, not at once, strain and stress differ by multiples of mu* ln(mu*).

    So does the overconsolidation of steady compression, (mu* lambda*/(rate (lambda* - kappa*)))^(mu*/(lambda* -
    kappa*)).
    """
    stages = {
        "oedometer": [constant_rate_oedometer(strain, 1.0) for strain in (0.1, -0.01, 0.1)],
        "undrained": [undrained_triaxial(0.05, 1.0)],
        "drained": [drained_triaxial(0.1, 60.0, 1.0)],
    }[path]

    def ends(soil: Soil) -> np.ndarray:
        start = triaxial(60.0, 60.0, soil)
        history = follow(soil, start, stages, [[1.0]] * len(stages), tolerance=1.0e-6)
        return np.concatenate([history.strain.ravel(), history.stress.ravel() / 1000.0, history.internal.ravel()])

    limit = ends(clay(c=c, OCR=1.2))
    rests = []
    for mu in (1.0e-3, 1.0e-4, 1.0e-5):
        creeping = find_law("soft_soil_creep").soil({**CLAY, "c": c, "OCR": 1.2, "mu_star": mu})
        rests.append(np.abs(ends(creeping) - limit).max())
    assert rests[1] < 0.18 * rests[0]
    assert rests[2] < 0.18 * rests[1]
    assert rests[2] < 1.0e-3


SECTION = {
    **{"kind": "oedometer", "material": "soft_soil", "height": 0.02, "initial_stress": 40.0, "tolerance": 1.0e-6},
    "stages": [{"stress": stress, "duration": 1.0} for stress in (80.0, 160.0, 320.0)],
}


@pytest.mark.parametrize("discretization", ["material_point", "finite_element"])
def test_the_oedometer_gives_strains_on_a_line(discretization: str) -> None:
    extra = {"unit_weight": 0.0} if discretization == "finite_element" else {}
    spec = OedometerSpec.model_validate({**SECTION, "discretization": discretization, **extra, "geometry": "fixed"})
    found = spec.build().prepare({"stage_axial_strain": np.array([1.0, 2.0, 3.0])})(CLAY)["stage_axial_strain"]
    close = 1.0e-7 if discretization == "material_point" else 2.0e-3
    assert found == pytest.approx(LAMBDA * np.log([2.0, 4.0, 8.0]), abs=close)


def test_reports_have_the_values_of_the_laboratory() -> None:
    problem = parse_problem(
        {
            "name": "soft",
            "forward_model": {**SECTION, "OCR": 1.5, "initial_void_ratio": 1.0},
            "parameters": {
                **{name: {"value": value} for name, value in CLAY.items()},
                "lambda_star": {"lower": 0.05, "upper": 0.2},
            },
            "observations": [{"series": "stage_settlement", "points": {"x": [1.0], "y": [0.001]}}],
            "method": {"kind": "monte_carlo", "samples": 1},
        }
    )
    values = {one.symbol: one.value for one in laboratory_values(problem, CLAY, None)}
    assert values["Cc"] == pytest.approx(math.log(10.0) * LAMBDA * 2.0)
    assert values["σ′p"] == pytest.approx(60.0, rel=1.0e-9)
    assert "Cα" not in values


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"phi": 0.0}, "phi must be above 0 and below 90 degree, got 0 degree: soft soil needs friction"),
        ({"kappa_star": 0.2}, "lambda_star must be above kappa_star = 0.2, got 0.11"),
        ({"K0nc": 0.5, "M": 1.2}, "K0nc = 0.5 and M = 1.2 are both given; give only one, the other follows from it"),
        ({"K0nc": 0.05, "nu_ur": 0.4, "lambda_star": 0.021}, "gives no M"),
        ({"OCR": 2.0, "POP": 10.0}, "OCR = 2 and POP = 10 kPa are both given"),
        ({"psi": 30.0}, "psi must be at most phi = "),
    ],
)
def test_what_does_not_fit_together_is_reported(values: dict[str, float], message: str) -> None:
    with pytest.raises(InfeasibleError, match=message):
        clay(**values)
