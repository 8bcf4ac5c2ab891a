"""Direct simple shear against closed forms (failure on horizontal planes, critical states) and rates of creep."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from geoswarm.solver.arrays import FloatArray
from geoswarm.verification.specimens.laboratory import run, simple_shear

SAND = {"E": 2.0e4, "nu": 0.3, "c": 5.0, "phi": 30.0}
SIN, ATTRACTION = 0.5, 5.0 / math.tan(math.radians(30.0))
END = [0.3, 0.35, 0.4]

M, LAMBDA, KAPPA, E0 = 1.0, 0.2, 0.04, 1.0
PLASTIC = 1.0 - KAPPA / LAMBDA
CLAY = {"M": M, "lambda": LAMBDA, "kappa": KAPPA, "nu": 0.25, "e0": E0}


@pytest.mark.parametrize(("constant", "psi"), [("normal_stress", 0.0), ("normal_stress", 12.0), ("volume", 0.0)])
@pytest.mark.parametrize("law", ["mohr_coulomb", "drucker_prager"])
def test_failure_on_planes_that_do_not_stretch(law: str, constant: str, psi: float) -> None:
    """tau/(sigma_n + c cot(phi)) = sin(phi) cos(psi)/(1 - sin(phi) sin(psi)), rising by tan(psi) (Davis 1968).

    Stresses and increments of plastic strain have the same axes, and horizontal planes do not stretch. The cone fitted
    to plane strain has the same strength. (With dilatancy a constant volume has no end of its strength.)
    """
    settings = {"match": "plane_strain"} if law == "drucker_prager" else {}
    spec = simple_shear(law, [{"shear_strain": 0.4}], constant=constant, settings=settings, geometry="fixed")
    names = ("shear_stress", "normal_stress", "vertical_strain")
    tau, normal, vertical = run(spec, SAND | {"psi": psi}, END, *names)
    dilatancy = math.radians(psi)
    ratio = SIN * math.cos(dilatancy) / (1.0 - SIN * math.sin(dilatancy))
    assert tau == pytest.approx(ratio * (normal + ATTRACTION), rel=1.0e-5)
    assert np.diff(vertical) == pytest.approx(np.full(2, -0.05 * math.tan(dilatancy)), abs=1.0e-6)


def test_the_friction_angle_of_matsuoka_and_nakai_is_that_of_plane_strain() -> None:
    """Without dilatancy sin(phi)^2 in the plane is 1 - 6/(6 + 8 tan(phi)^2), and tau/sigma_n its sine."""
    spec = simple_shear("matsuoka_nakai", [{"shear_strain": 0.4}], constant="normal_stress", geometry="fixed")
    (tau,) = run(spec, SAND | {"psi": 0.0}, END, "shear_stress")
    sine = math.sqrt(1.0 - 6.0 / (6.0 + 8.0 / 3.0))
    assert tau == pytest.approx(np.full(3, sine * (100.0 + ATTRACTION)), rel=1.0e-5)


@pytest.mark.parametrize("OCR", [1.0, 4.0])
@pytest.mark.parametrize("K0", [1.0, 0.6])
def test_cam_clay_at_constant_volume_ends_at_its_critical_state(OCR: float, K0: float) -> None:
    """tau = M p_f/sqrt(3) and sigma_v = p_f = p_0 (p_c/(2 p_0))^Lambda, the stress being sheared purely (Wood 1990)."""
    p0 = 100.0 * (1.0 + 2.0 * K0) / 3.0
    past = OCR * (p0 + (100.0 * (1.0 - K0)) ** 2 / (M**2 * p0))
    end = p0 * (past / (2.0 * p0)) ** PLASTIC
    spec = simple_shear("modified_cam_clay", [{"shear_strain": 0.9}], initial_ratio=K0, tolerance=1.0e-6)
    names = ("shear_stress", "normal_stress", "p", "pore_pressure", "rotation", "q")
    tau, normal, p, u, rotation, q = run(spec, CLAY | {"OCR": OCR}, 0.9, *names)
    assert p == pytest.approx([end], rel=1.0e-4)
    assert normal == pytest.approx([end], rel=1.0e-4)
    assert q == pytest.approx([M * end], rel=1.0e-4)
    assert tau == pytest.approx([M * end / math.sqrt(3.0)], rel=1.0e-4)
    assert u == pytest.approx(100.0 - normal, rel=1.0e-9)
    assert rotation == pytest.approx([45.0], abs=0.01)


def test_the_path_of_cam_clay_at_constant_volume_is_that_of_any_undrained_test() -> None:
    """p ((M^2 + eta^2)/M^2)^Lambda stays what it is, whatever the shearing (Wood 1990, section 5.4)."""
    spec = simple_shear("modified_cam_clay", [{"shear_strain": 0.5}], initial_ratio=1.0, tolerance=1.0e-7)
    p, q = run(spec, CLAY, [1.0e-3, 5.0e-3, 0.02, 0.1, 0.5], "p", "q")
    assert p == pytest.approx(100.0 * (1.0 + (q / p / M) ** 2) ** -PLASTIC, rel=1.0e-5)


def test_cam_clay_under_constant_normal_stress_ends_on_the_critical_state_line() -> None:
    spec = simple_shear(
        "modified_cam_clay", [{"shear_strain": 0.9}], constant="normal_stress", initial_ratio=1.0, tolerance=1.0e-6
    )
    stiff = CLAY | {"lambda": 0.05, "kappa": 0.01}  # nears its end within a smaller strain
    tau, e, horizontal = run(spec, stiff, 0.9, "shear_stress", "e", "horizontal_stress")
    assert tau == pytest.approx([M * 100.0 / math.sqrt(3.0)], rel=1.0e-4)
    assert horizontal == pytest.approx([100.0], rel=1.0e-4)
    # On the swelling line of p_c = 2 p: e_0 - (lambda - kappa) ln 2.
    assert e == pytest.approx([E0 - 0.04 * math.log(2.0)], abs=1.0e-5)


SOFT = {
    **{"lambda_star": 0.11, "kappa_star": 0.03, "mu_star": 0.004, "c": 30.0, "phi": 35.0},
    **{"nu_ur": 0.2, "M": 1.2, "OCR": 1.3},
}
_A = SOFT["c"] / math.tan(math.radians(SOFT["phi"]))


def creep_rates(constant: str, rate: float) -> Callable[[float, FloatArray], list[float]]:
    """d(sigma_x, sigma_y, sigma_z, tau, ln p_p, eps_y)/dt by the definitions (Vermeer & Neher 1999), translated."""
    stiff, slope = SOFT["lambda_star"] - SOFT["kappa_star"], SOFT["M"] ** 2

    def rates(_: float, y: FloatArray) -> list[float]:
        normal, tau, log_pp = y[:3], float(y[3]), float(y[4])
        P = float(normal.mean()) + _A
        s = normal - normal.mean()
        q2 = 1.5 * float(s @ s) + 3.0 * tau**2
        volume = SOFT["mu_star"] * math.exp(stiff / SOFT["mu_star"] * (math.log(P + q2 / (slope * P)) - log_pp))
        alpha = 1.0 - q2 / (slope * P**2)
        flow = volume / alpha * (alpha / 3.0 + 3.0 * s / (slope * P))
        K = P / SOFT["kappa_star"]
        G = 1.5 * K * (1.0 - 2.0 * SOFT["nu_ur"]) / (1.0 + SOFT["nu_ur"])

        def change(vertical: float) -> FloatArray:
            elastic = np.array([0.0, vertical, 0.0]) - flow
            stress: FloatArray = (K - 2.0 / 3.0 * G) * elastic.sum() + 2.0 * G * elastic
            return stress

        vertical = 0.0 if constant == "volume" else -float(change(0.0)[1]) / (K + 4.0 / 3.0 * G)
        shear = G * (rate - volume / alpha * 6.0 * tau / (slope * P))
        return [*change(vertical).tolist(), shear, volume / stiff, vertical]

    return rates


@pytest.mark.parametrize("constant", ["volume", "normal_stress"])
def test_creep_at_constant_rate_against_an_independent_integration(constant: str) -> None:
    x, rate = np.array([1.0e-3, 0.01, 0.02, 0.03]), 0.5
    start = np.array([70.0, 100.0, 70.0])
    P = float(start.mean()) + _A
    log_pp = math.log(SOFT["OCR"] * (P + 30.0**2 / (SOFT["M"] ** 2 * P)))
    times = x / rate
    result = solve_ivp(
        creep_rates(constant, rate),
        (0.0, times[-1]),
        [*start, 0.0, log_pp, 0.0],
        "Radau",
        times,
        rtol=1.0e-10,
        atol=1.0e-12,
    )
    spec = simple_shear(
        "soft_soil_creep",
        [{"shear_strain": 0.03, "rate": rate}],
        constant=constant,
        initial_ratio=0.7,
        tolerance=1.0e-8,
        geometry="fixed",
    )
    names = ("horizontal_stress", "normal_stress", "p", "shear_stress", "log_pp", "vertical_strain")
    horizontal, normal, p, tau, log_state, vertical = run(spec, SOFT, x, *names)
    assert tau[-1] > 20.0
    assert horizontal == pytest.approx(result.y[0], abs=1.0e-3)
    assert normal == pytest.approx(result.y[1], abs=1.0e-3)
    assert p == pytest.approx(result.y[:3].mean(axis=0), abs=1.0e-3)
    assert tau == pytest.approx(result.y[3], abs=1.0e-3)
    assert log_state == pytest.approx(result.y[4], abs=1.0e-5)
    assert vertical == pytest.approx(result.y[5], abs=1.0e-7)
