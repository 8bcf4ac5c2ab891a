"""Modified Cam clay against its closed forms, quadrature and an independent integration of its rate equations.

Roscoe & Burland (1968); Wood (1990), chapter 5. v = 1 + e, eta = q/p, Lambda = 1 - kappa/lambda.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from geoswarm.solver.element_test.boundary_conditions import Stage, strain_change
from geoswarm.solver.element_test.material_point import History, PointState, follow, point_under
from geoswarm.solver.element_test.setups import (
    constant_rate_oedometer,
    drained_triaxial,
    isotropic_load,
    undrained_triaxial,
)
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.forward.oedometer import OedometerSpec
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.verification.exact.cam_clay import CamClay

M, LAMBDA, KAPPA, NU, E0 = 0.95, 0.2, 0.04, 0.3, 1.1
PLASTIC = 1.0 - KAPPA / LAMBDA
CLAY = {"M": M, "lambda": LAMBDA, "kappa": KAPPA, "e0": E0}
ELASTIC: dict[str, dict[str, Any]] = {"constant nu": {"nu": NU}, "constant G": {"G": 2.5e3}}
COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")


@pytest.fixture(params=ELASTIC.values(), ids=ELASTIC.keys())
def elastic(request: pytest.FixtureRequest) -> dict[str, Any]:
    """Both kinds of elasticity."""
    found: dict[str, Any] = request.param
    return found


def clay(**changes: Any) -> Soil:
    """Clay of a soft deposit."""
    return find_law("modified_cam_clay").soil({**CLAY, **changes})


def isotropic(p: float, soil: Soil) -> PointState:
    """Placed under all-round pressure."""
    return point_under([p, p, p, 0.0, 0.0, 0.0], soil)


def volume(history: History) -> np.ndarray:
    """Specific volume over time."""
    return 1.0 + history.internal[:, 1]


@pytest.mark.parametrize("OCR", [1.0, 1.5, 4.0])
def test_the_undrained_path_is_the_closed_form(elastic: dict[str, Any], OCR: float) -> None:
    """Elastic at constant p up to yield, then p ((M^2 + eta^2)/M^2)^Lambda stays what it is, whatever elasticity is."""
    soil = clay(**elastic, OCR=OCR)
    times = np.array([0.002, 0.005, 0.01, 0.02, 0.05, 0.2, 0.5, 1.0])
    history = follow(soil, isotropic(100.0, soil), [undrained_triaxial(1.5, 1.0)], [times], tolerance=1.0e-8)
    eta, at_yield = history.q / history.p, M * math.sqrt(OCR - 1.0)
    beyond = 100.0 * ((M**2 + at_yield**2) / (M**2 + eta**2)) ** PLASTIC
    yielding = history.internal[:, 0] != 100.0 * OCR
    assert yielding[-4:].all()
    assert history.p == pytest.approx(np.where(yielding, beyond, 100.0), rel=1.0e-6)
    assert volume(history) == pytest.approx(1.0 + E0, rel=1.0e-12)
    end = 100.0 * (OCR / 2.0) ** PLASTIC
    assert history.p[-1] == pytest.approx(end, rel=1.0e-5)
    assert history.q[-1] == pytest.approx(M * end, rel=1.0e-5)


def test_the_undrained_path_from_rest_is_the_closed_form() -> None:
    soil = clay(nu=NU)
    K0 = soil.law.K0(soil.constants)
    assert K0 is not None
    start = point_under([100.0 * K0, 100.0 * K0, 100.0, 0.0, 0.0, 0.0], soil)
    p0, eta0 = (1.0 + 2.0 * K0) / 3.0 * 100.0, 3.0 * (1.0 - K0) / (1.0 + 2.0 * K0)
    for strain in (0.6, -0.6):
        times = np.array([0.1, 0.3, 1.0])
        history = follow(soil, start, [undrained_triaxial(strain, 1.0)], [times], tolerance=1.0e-8)
        end = p0 * ((M**2 + eta0**2) / (2.0 * M**2)) ** PLASTIC
        assert history.q[-1] == pytest.approx(M * end, rel=1.0e-4)
        assert history.p[-1] == pytest.approx(end, rel=1.0e-4)
        if strain > 0.0:
            eta = history.q / history.p
            assert history.p == pytest.approx(p0 * ((M**2 + eta0**2) / (M**2 + eta**2)) ** PLASTIC, rel=1.0e-6)


def test_the_friction_angle_of_the_critical_state_gives_M() -> None:
    for phi in (20.0, 32.0):
        soil = find_law("modified_cam_clay").soil({**CLAY, "nu": NU, "M": 0.0, "phi_cs": phi})
        times = [np.array([1.0])]
        end = follow(soil, isotropic(100.0, soil), [drained_triaxial(2.0, 100.0, 1.0)], times, tolerance=1.0e-7)
        major, minor = end.stress[0, 2], end.stress[0, 0]
        assert (major - minor) / (major + minor) == pytest.approx(math.sin(math.radians(phi)), rel=1.0e-4)


@pytest.mark.parametrize("OCR", [1.0, 1.4])
def test_drained_compression_is_the_quadrature_of_the_rate_equations(elastic: dict[str, Any], OCR: float) -> None:
    soil, p0 = clay(**elastic, OCR=OCR), 80.0
    exact = CamClay(M, LAMBDA, KAPPA, E0, **elastic)
    critical = 3.0 * p0 / (3.0 - M)
    pressures = p0 + (critical - p0) * np.array([0.05, 0.2, 0.5, 0.8, 0.95])
    strains = np.array([exact.drained_strains(p, p0, OCR * p0) for p in pressures.tolist()])
    times = strains[:, 1] / strains[-1, 1]
    stage = drained_triaxial(float(strains[-1, 1]), p0, 1.0)
    history = follow(soil, isotropic(p0, soil), [stage], [times], tolerance=1.0e-9)
    assert history.p == pytest.approx(pressures, rel=1.0e-6)
    assert history.strain[:, :3].sum(axis=1) == pytest.approx(strains[:, 0], rel=1.0e-5)


def test_overconsolidated_clay_softens_to_the_critical_state() -> None:
    """Peak where the path meets the yield surface, end at q = M p on the critical state line."""
    soil, p0, OCR = clay(nu=NU, OCR=6.0), 50.0, 6.0
    times = np.append(np.linspace(1.0e-4, 0.02, 200), 1.0)
    history = follow(soil, isotropic(p0, soil), [drained_triaxial(3.0, p0, 1.0)], [times], tolerance=1.0e-7)
    peak = brentq(lambda p: p + 9.0 * (p - p0) ** 2 / (M**2 * p) - OCR * p0, p0, 4.0 * p0)
    assert history.p.max() == pytest.approx(peak, rel=5.0e-3)
    assert history.p.max() < peak * (1.0 + 1.0e-6)
    end = 3.0 * p0 / (3.0 - M)
    assert history.p[-1] == pytest.approx(end, rel=1.0e-4)
    start = 1.0 + E0 + LAMBDA * math.log(OCR * p0) - KAPPA * math.log(OCR)  # N of the soil
    assert volume(history)[-1] == pytest.approx(
        start - LAMBDA * math.log(end) - (LAMBDA - KAPPA) * math.log(2.0), rel=1.0e-5
    )


@pytest.mark.parametrize("specific_volume", ["present", "initial"])
def test_isotropic_compression_follows_both_lines(specific_volume: str) -> None:
    soil = clay(nu=NU, OCR=1.5, specific_volume=specific_volume)
    stages = [isotropic_load(load, 0.0) for load in (120.0, 400.0, 80.0, 500.0)]
    history = follow(soil, isotropic(100.0, soil), stages, [[0.0]] * 4, tolerance=1.0e-8)
    drop = [KAPPA * math.log(1.2)]
    drop += [KAPPA * math.log(1.5) + LAMBDA * math.log(400.0 / 150.0)]
    drop += [drop[1] - KAPPA * math.log(5.0)]
    drop += [drop[1] + LAMBDA * math.log(500.0 / 400.0)]
    assert volume(history) == pytest.approx(1.0 + E0 - np.array(drop), rel=1.0e-9)
    strain = history.strain[:, :3].sum(axis=1)
    expected = -np.log1p(-np.array(drop) / (1.0 + E0)) if specific_volume == "present" else np.array(drop) / (1.0 + E0)
    assert strain == pytest.approx(expected, rel=1.0e-9)
    assert history.internal[:, 0] == pytest.approx([150.0, 400.0, 400.0, 500.0], rel=1.0e-9)


def test_one_dimensional_compression_keeps_and_finds_its_stress_ratio() -> None:
    soil = clay(nu=NU)
    K0 = soil.law.K0(soil.constants)
    assert K0 is not None
    eta = CamClay(M, LAMBDA, KAPPA, E0, nu=NU).eta_at_rest()
    assert soil.law.K0(soil.constants) == pytest.approx((3.0 - eta) / (3.0 + 2.0 * eta), rel=1.0e-12)
    times = np.linspace(0.1, 1.0, 10)
    at_rest = point_under([100.0 * K0, 100.0 * K0, 100.0, 0.0, 0.0, 0.0], soil)
    kept = follow(soil, at_rest, [constant_rate_oedometer(0.25, 1.0)], [times], tolerance=1.0e-8)
    assert kept.stress[:, 0] / kept.stress[:, 2] == pytest.approx(K0, rel=1.0e-6)
    assert volume(kept) == pytest.approx(1.0 + E0 - LAMBDA * np.log(kept.stress[:, 2] / 100.0), rel=1.0e-7)
    found = follow(soil, isotropic(20.0, soil), [constant_rate_oedometer(0.5, 1.0)], [[1.0]], tolerance=1.0e-8)
    assert found.stress[0, 0] / found.stress[0, 2] == pytest.approx(K0, rel=1.0e-4)


def test_without_elastic_shear_the_ratio_at_rest_is_the_classical_one() -> None:
    soil = clay(G=1.0e7)
    eta = 0.5 * (math.sqrt(9.0 * PLASTIC**2 + 4.0 * M**2) - 3.0 * PLASTIC)
    assert soil.law.K0(soil.constants) == pytest.approx((3.0 - eta) / (3.0 + 2.0 * eta), rel=1.0e-12)
    found = follow(soil, isotropic(20.0, soil), [constant_rate_oedometer(0.5, 1.0)], [[1.0]], tolerance=1.0e-7)
    assert found.stress[0, 0] / found.stress[0, 2] == pytest.approx((3.0 - eta) / (3.0 + 2.0 * eta), rel=1.0e-4)


def _tensor(components: np.ndarray, shear: float = 1.0) -> np.ndarray:
    xx, yy, zz, xy, yz, zx = components
    return np.array([[xx, shear * xy, shear * zx], [shear * xy, yy, shear * yz], [shear * zx, shear * yz, zz]])


@pytest.mark.parametrize("OCR", [1.0, 8.0])
def test_a_path_with_turning_axes_is_that_of_the_rate_equations(elastic: dict[str, Any], OCR: float) -> None:
    """Elastoplastic rates of full tensors by SciPy's Runge-Kutta method: hardening, and softening beyond M."""
    soil = clay(**elastic, OCR=OCR)
    dilation = 0.0 if OCR == 1.0 else -0.005
    strain = np.array([-0.01 + dilation, -0.024 + dilation, 0.05 + dilation, 0.04, -0.02, 0.03])
    start = point_under([60.0, 70.0, 100.0, 4.0, -6.0, 2.0], soil)
    identity, rate = np.eye(3), _tensor(strain, 0.5)

    def moduli(p: float, v: float) -> tuple[float, float]:
        bulk = v * p / KAPPA
        return bulk, elastic.get("G") or 1.5 * (1.0 - 2.0 * NU) / (1.0 + NU) * bulk

    def stiff(tensor: np.ndarray, bulk: float, shear: float) -> np.ndarray:
        trace = np.trace(tensor)
        return bulk * trace * identity + 2.0 * shear * (tensor - trace / 3.0 * identity)

    def change(_: float, y: np.ndarray, plastic: bool) -> np.ndarray:
        stress, past, v = y[:9].reshape(3, 3), y[9], y[10]
        p = np.trace(stress) / 3.0
        s = stress - p * identity
        q2 = 1.5 * (s * s).sum()
        bulk, shear = moduli(p, v)
        normal = (1.0 - q2 / (M * p) ** 2) * identity / 3.0 + 3.0 * s / (M**2 * p)
        multiplier = 0.0
        if plastic:
            hardening = v * past / (LAMBDA - KAPPA) * np.trace(normal)
            multiplier = (normal * stiff(rate, bulk, shear)).sum()
            multiplier /= (normal * stiff(normal, bulk, shear)).sum() + hardening
        harder = v * past / (LAMBDA - KAPPA) * multiplier * np.trace(normal)
        return np.append(stiff(rate - multiplier * normal, bulk, shear).ravel(), [harder, -v * np.trace(rate)])

    def beyond(_: float, y: np.ndarray, plastic: bool) -> float:
        del plastic
        stress = y[:9].reshape(3, 3)
        p = np.trace(stress) / 3.0
        s = stress - p * identity
        return float(p + 1.5 * (s * s).sum() / (M**2 * p) - y[9])

    beyond.terminal, beyond.direction = True, 1.0  # type: ignore[attr-defined]
    y, begin = np.append(_tensor(start.stress).ravel(), [start.internal[0], 1.0 + E0]), 0.0
    accuracy: dict[str, Any] = {"method": "DOP853", "rtol": 1.0e-11, "atol": 1.0e-10}
    if OCR > 1.0:
        touched = solve_ivp(change, (0.0, 1.0), y, args=(False,), events=beyond, **accuracy)
        y, begin = touched.y[:, -1], touched.t[-1]
        assert 0.0 < begin < 1.0
    y = solve_ivp(change, (begin, 1.0), y, args=(True,), **accuracy).y[:, -1]
    controls = tuple(strain_change(float(value), **{name: 1}) for value, name in zip(strain, COMPONENTS, strict=True))
    end = follow(soil, start, [Stage("path", 1.0, controls)], [[1.0]], tolerance=1.0e-9).end
    assert _tensor(end.stress) == pytest.approx(y[:9].reshape(3, 3), rel=1.0e-5, abs=1.0e-4)
    assert end.internal == pytest.approx([y[9], y[10] - 1.0], rel=1.0e-6)


@pytest.mark.parametrize("discretization", ["material_point", "finite_element"])
def test_the_oedometer_gives_void_ratios_on_a_line(discretization: str) -> None:
    section = {
        **{"kind": "oedometer", "material": "modified_cam_clay", "height": 0.02, "initial_stress": 50.0},
        **{"initial_void_ratio": E0, "discretization": discretization, "tolerance": 1.0e-6},
        "stages": [{"stress": stress, "duration": 1.0} for stress in (100.0, 200.0, 400.0)],
    }
    section |= {"unit_weight": 0.0} if discretization == "finite_element" else {}
    run = OedometerSpec.model_validate(section).build().prepare({"stage_void_ratio": np.array([1.0, 2.0, 3.0])})
    found = run({"M": M, "lambda": LAMBDA, "kappa": KAPPA, "nu": NU, "e0": E0})["stage_void_ratio"]
    expected = E0 - LAMBDA * np.log([2.0, 4.0, 8.0])
    assert found == pytest.approx(expected, abs=1.0e-5 if discretization == "material_point" else 2.0e-3)


def test_the_state_where_it_is_placed() -> None:
    stress = np.array([[50.0, 100.0, 50.0, 0.0], [30.0, 60.0, 30.0, 10.0]])
    law = find_law("modified_cam_clay")

    def placed(**values: float) -> np.ndarray:
        return law.initial_state(stress, clay(nu=NU, **values).constants)

    p, q2 = np.array([200.0 / 3.0, 40.0]), np.array([50.0**2, 30.0**2 + 3.0 * 10.0**2])
    least = p + q2 / (M**2 * p)
    assert placed(OCR=2.0) == pytest.approx(np.column_stack([2.0 * least, [E0, E0]]))
    assert placed(p_c=300.0)[:, 0] == pytest.approx([300.0, 300.0])
    N = 3.1
    e = N - 1.0 - LAMBDA * np.log(2.0 * least) + KAPPA * np.log(2.0 * least / p)
    assert placed(OCR=2.0, N=N, e0=0.0) == pytest.approx(np.column_stack([2.0 * least, e]))
    K0 = law.K0(clay(nu=NU).constants)
    assert K0 is not None
    past = np.array(
        [[50.0 + 20.0 * K0, 120.0, 50.0 + 20.0 * K0, 0.0], [30.0 + 20.0 * K0, 80.0, 30.0 + 20.0 * K0, 10.0]]
    )
    normal = clay(nu=NU)
    assert placed(POP=20.0)[:, 0] == pytest.approx(law.initial_state(past, normal.constants)[:, 0])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"nu": NU, "G": 1.0e3}, "nu = 0.3 and G = 1000 are both given; give only one of them"),
        ({"phi_cs": 25.0, "nu": NU}, "M = 0.95 and phi_cs = 25 are both given"),
        ({"N": 3.0, "nu": NU}, "e0 = 1.1 and N = 3 are both given"),
        ({}, "give exactly one of nu and G, a value above 0"),
        ({"nu": NU, "kappa": 0.2}, "lambda must be above kappa = 0.2, got 0.2"),
        ({"nu": NU, "OCR": 2.0, "POP": 10.0}, "OCR = 2 and POP = 10 are given; give only one of them"),
        ({"nu": NU, "OCR": 2.0, "p_c": 300.0}, "OCR = 2 and p_c = 300 are given"),
        ({"nu": NU, "e0": -0.1}, "e0 must be at least 0, got -0.1"),
        ({"nu": NU, "e0": 0.0, "N": 3.0, "specific_volume": "initial"}, "an initial specific volume needs e0"),
    ],
)
def test_what_does_not_fit_together_is_reported(values: dict[str, Any], message: str) -> None:
    with pytest.raises(InfeasibleError, match=message):
        clay(**values)


@pytest.mark.parametrize(
    ("values", "stress", "message"),
    [
        ({}, 0.0, "initial mean stress = 0 kPa: modified Cam clay needs a value above 0 kPa where it is placed"),
        ({"p_c": 80.0}, 100.0, "of the initial stress, 100 kPa, got 80 kPa"),
        ({"N": 1.5, "e0": 0.0}, 100.0, "N = 1.5 gives the void ratio -0.42.*; give a larger N"),
    ],
)
def test_a_stress_that_does_not_fit_is_reported(values: dict[str, Any], stress: float, message: str) -> None:
    soil = clay(nu=NU, **values)
    with pytest.raises(InfeasibleError, match=message):
        isotropic(stress, soil)
