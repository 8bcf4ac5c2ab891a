"""The scalar physics of soft soil creep: constants, derivatives, guards."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.constitutive.soft_soil_creep.physics import (
    ALPHA_GUARD,
    SoftSoilCreep,
    creep_increment,
    elastic_strain,
    equivalent_pressure,
    friction_constant,
    secant_compliance,
    soft_soil_creep,
)
from geoswarm.solver.errors import InfeasibleError

USUAL = {"lambda_star": 0.1, "kappa_star": 0.02, "mu_star": 0.005, "c": 5.0, "phi": 25.0}


def soil(**changes: object) -> SoftSoilCreep:
    return soft_soil_creep(**{**USUAL, **changes})  # type: ignore[arg-type]


@pytest.mark.parametrize(("K0nc", "ratio", "M"), [(0.61, 6.5625, 1.29598), (0.5, 5.0, 1.58858)])
def test_friction_constant_has_its_check_values(K0nc: float, ratio: float, M: float) -> None:
    assert friction_constant(K0nc, 0.15, ratio) == pytest.approx(M, abs=5.0e-6)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"phi": 0.0}, "phi = 0"),
        ({"phi": 90.0}, "phi = 90"),
        ({"phi": -3.0}, "phi = -3"),
        ({"lambda_star": 0.02}, "lambda_star = 0.02"),
        ({"kappa_star": 0.0}, "kappa_star = 0"),
        ({"mu_star": 0.0}, "mu_star = 0"),
        ({"mu_star": math.nan}, "mu_star = nan"),
        ({"c": -1.0}, "c = -1 kPa"),
        ({"psi": 26.0}, "psi = 26"),
        ({"nu_ur": 0.5}, "nu_ur = 0.5"),
        ({"K0nc": 0.5, "M": 1.2}, "both given"),
        ({"K0nc": 1.0}, "K0nc = 1"),
        ({"M": -1.0}, "M = -1"),
        ({"K0nc": 0.01, "nu_ur": 0.4}, "gives no M"),
        ({"tension_cutoff": -1.0}, "tension_cutoff = -1"),
        ({"tau": 0.0}, "tau = 0"),
    ],
)
def test_inadmissible_constants_are_refused_by_name_and_value(changes: dict[str, float], words: str) -> None:
    name, given, value = words.partition(" = ")
    with pytest.raises(InfeasibleError, match=rf"^{name} must be .*got {value}" if given else words):
        soil(**changes)


def test_formulations_differ_by_the_attraction_only() -> None:
    attraction = 5.0 / math.tan(math.radians(25.0))
    translated, untranslated = soil(), soil(formulation="untranslated")
    q2 = 30.0**2
    width = q2 / (translated.M**2 * (50.0 + attraction))
    assert equivalent_pressure(50.0, q2, translated)[0] == pytest.approx(50.0 + attraction + width, rel=1.0e-14)
    assert equivalent_pressure(50.0, q2, untranslated)[0] == pytest.approx(50.0 + width, rel=1.0e-14)
    assert translated.attraction == pytest.approx(untranslated.attraction, rel=1.0e-15)


@pytest.mark.parametrize("formulation", ["translated", "untranslated"])
@pytest.mark.parametrize(("p", "q"), [(60.0, 40.0), (3.0, 2.0), (60.0, 75.0), (20.0, 60.0)])
def test_creep_derivatives_are_those_of_the_increment(formulation: str, p: float, q: float) -> None:
    material = soil(formulation=formulation)
    log_pp = math.log(70.0)

    def values(p: float, q2: float) -> np.ndarray:
        result = creep_increment(p, q2, 0.3, log_pp, material)
        return np.array([result[0], result[3]])

    _, volume_p, volume_q2, _, factor_p, factor_q2 = creep_increment(p, q * q, 0.3, log_pp, material)
    h = 1.0e-5
    by_p = (values(p + h, q * q) - values(p - h, q * q)) / (2.0 * h)
    by_q2 = (values(p, q * q + h) - values(p, q * q - h)) / (2.0 * h)
    assert by_p == pytest.approx([volume_p, factor_p], rel=1.0e-5, abs=1.0e-12)
    assert by_q2 == pytest.approx([volume_q2, factor_q2], rel=1.0e-4, abs=1.0e-12)


def test_flow_stays_bounded_and_continuous_where_the_ellipse_turns() -> None:
    material = soil(M=0.6)
    P = 60.0 + material.attraction
    just_above = (1.0 - ALPHA_GUARD) * (material.M * P) ** 2
    low = creep_increment(60.0, just_above * (1.0 - 1.0e-9), 0.0, math.log(80.0), material)[3]
    high = creep_increment(60.0, just_above * (1.0 + 1.0e-9), 0.0, math.log(80.0), material)[3]
    beyond = creep_increment(60.0, 2.0 * just_above, 0.0, math.log(80.0), material)
    assert low == pytest.approx(high, rel=1.0e-6)
    assert np.isfinite(beyond).all()
    assert beyond[0] > 0.0
    assert beyond[3] > high


def test_extreme_creep_exponents_neither_overflow_nor_vanish() -> None:
    material = soil(mu_star=1.0e-6)
    volume = creep_increment(100.0, 0.0, 0.0, math.log(50.0), material)[0]
    limit = 0.08 * math.log((100.0 + material.attraction) / 50.0)
    assert volume == pytest.approx(limit, rel=1.0e-12)
    assert creep_increment(20.0, 0.0, 0.0, math.log(50.0), material)[0] == 0.0


def test_an_instantaneous_step_has_no_creep() -> None:
    assert creep_increment(60.0, 400.0, -math.inf, math.log(20.0), soil()) == (0.0,) * 6


@pytest.mark.parametrize("p", [100.0, 100.0 * (1.0 + 5.0e-4), 100.0 * (1.0 + 2.0e-3), 31.0, 400.0])
def test_secant_compliance_is_exact_and_smooth(p: float) -> None:
    material = soil(c=0.0)
    strain, compliance, slope = secant_compliance(100.0, p, material)
    assert strain == pytest.approx(0.02 * math.log(p / 100.0), rel=1.0e-12, abs=1.0e-16)
    h = 1.0e-3
    difference = secant_compliance(100.0, p + h, material)[1] - secant_compliance(100.0, p - h, material)[1]
    assert slope == pytest.approx(difference / (2.0 * h), rel=1.0e-6)
    assert compliance > 0.0


def test_stiffness_keeps_its_value_below_the_pressure_floor() -> None:
    material = soil(formulation="untranslated")
    assert elastic_strain(0.2, material)[1] == pytest.approx(0.02, rel=1.0e-15)
    assert elastic_strain(-5.0, material)[1] == pytest.approx(0.02, rel=1.0e-15)
    strain, _, _ = secant_compliance(0.5, 2.0, material)
    assert strain == pytest.approx(0.02 * (0.5 + math.log(2.0)), rel=1.0e-13)
