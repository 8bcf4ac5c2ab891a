"""Hardening soil against its closed forms, quadrature and an independent integration of its rate equations.

Schanz, Vermeer & Bonnier (1999). a = c cot(phi), x = (s3 + a)/(p_ref + a), E_i = 2 E50_ref/(2 - R_f).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.boundary_conditions import Stage, strain_change, stress_value
from geoswarm.solver.element_test.material_point import History, PointState, follow, point_under
from geoswarm.solver.element_test.setups import (
    constant_rate_oedometer,
    drained_triaxial,
    isotropic_load,
    undrained_triaxial,
)
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.verification.exact.hardening_soil import Drained

E50, EOED, EUR, NU, PREF, RF = 2.5e4, 2.2e4, 8.0e4, 0.2, 100.0, 0.9
INITIAL = 2.0 * E50 / (2.0 - RF)
SAND: dict[str, Any] = {"E50_ref": E50, "Eoed_ref": EOED, "Eur_ref": EUR, "m": 0.5, "c": 0.0, "phi": 34.0}
TIMES = np.array([0.002, 0.01, 0.03, 0.1, 0.3, 1.0])


def sand(**changes: Any) -> Soil:
    """Medium dense sand."""
    return find_law("hardening_soil").soil({**SAND, **changes})


def isotropic(p: float, soil: Soil) -> PointState:
    """Placed under all-round pressure."""
    return point_under([p, p, p, 0.0, 0.0, 0.0], soil)


def sheared(soil: Soil, cell: float, strain: float) -> History:
    """Drained compression from an isotropic stress."""
    stage = drained_triaxial(strain, cell, 1.0)
    return follow(soil, isotropic(cell, soil), [stage], [TIMES], tolerance=1.0e-8)


@pytest.mark.parametrize("cell", [30.0, 100.0, 400.0])
@pytest.mark.parametrize(("m", "c"), [(0.0, 0.0), (0.5, 0.0), (0.5, 12.0), (1.0, 0.0)])
def test_the_drained_test_is_the_hyperbola(cell: float, m: float, c: float) -> None:
    """With a cap far away. E50 at half the strength grows with the power m; so does the modulus of unloading."""
    soil, exact = sand(m=m, c=c, OCR=50.0), Drained(cell, m=m, c=c)
    strain = float(exact.axial(np.array(0.98 * exact.strength)))
    history = sheared(soil, cell, strain)
    # The tolerance is one of strain: times the elastic modulus it is one of stress.
    assert history.q == pytest.approx(exact.deviator(strain * TIMES), rel=1.0e-9, abs=1.0e-8 * EUR * exact.stiff)
    volume = history.strain[:, :3].sum(axis=1)
    assert volume == pytest.approx((1.0 - 2.0 * NU) * history.q / (EUR * exact.stiff), rel=1.0e-6)
    half = 0.5 * exact.strength / (E50 * exact.stiff)
    loaded = drained_triaxial(half, cell, 1.0)
    back = drained_triaxial(-0.1 * half, cell, 1.0)
    loop = follow(soil, isotropic(cell, soil), [loaded, back], [[1.0], [0.5, 1.0]], tolerance=1.0e-8)
    assert loop.q[0] == pytest.approx(0.5 * exact.strength, rel=1.0e-6)
    modulus = (loop.q[0] - loop.q[1:]) / (loop.strain[0, 2] - loop.strain[1:, 2])
    assert modulus == pytest.approx(EUR * exact.stiff, rel=1.0e-6)


@pytest.mark.parametrize("contraction", ["none", "rowe"])
def test_dilatancy_is_that_of_rowe_up_to_psi(contraction: str) -> None:
    soil, exact = sand(psi=6.0, OCR=50.0, contraction=contraction), Drained(100.0, psi=6.0)
    contracts = contraction == "rowe"
    history = sheared(soil, 100.0, 0.02)
    assert history.q.max() < exact.strength
    plastic = np.array([exact.dilation(q, contracts=contracts) for q in history.q.tolist()])
    volume = history.strain[:, :3].sum(axis=1)
    assert volume == pytest.approx(0.6 * history.q / EUR + plastic, abs=1.0e-7)
    gamma = 2.0 * (exact.axial(history.q) - history.q / EUR)
    assert history.internal[:, 0] == pytest.approx(gamma, rel=1.0e-6, abs=5.0e-8)
    assert history.strain[:, 2] == pytest.approx(history.q / EUR + 0.5 * (gamma + plastic), rel=1.0e-6, abs=5.0e-8)
    failed = follow(soil, isotropic(100.0, soil), [drained_triaxial(0.3, 100.0, 1.0)], [[0.8, 1.0]], tolerance=1.0e-8)
    assert failed.q == pytest.approx(exact.strength, rel=1.0e-9)
    more, sine = failed.strain[1] - failed.strain[0], math.sin(math.radians(6.0))
    assert more[:3].sum() / more[2] == pytest.approx(-2.0 * sine / (1.0 - sine), rel=1.0e-6)
    # At failure gamma stays where the hyperbola meets the strength.
    assert failed.internal[:, 0] == pytest.approx(
        2.0 * (exact.axial(np.array(exact.strength)) - exact.strength / EUR), rel=1.0e-9
    )


def test_strength_in_extension_and_its_hyperbola() -> None:
    """The axis is the minor stress: cell - s = 2 sin/(1 - sin) (s + a)."""
    cell, c, phi = 200.0, 10.0, 30.0
    soil = sand(c=c, phi=phi, OCR=50.0)
    a, sine = c / math.tan(math.radians(phi)), math.sin(math.radians(phi))
    end = follow(soil, isotropic(cell, soil), [drained_triaxial(-0.2, cell, 1.0)], [[1.0]], tolerance=1.0e-8)
    least = (cell * (1.0 - sine) - 2.0 * sine * a) / (1.0 + sine)
    assert end.stress[0, 2] == pytest.approx(least, rel=1.0e-8)


@pytest.mark.parametrize("m", [0.5, 0.8, 1.0])
@pytest.mark.parametrize("K0nc", [0.0, 0.5])
@pytest.mark.parametrize("contraction", ["none", "rowe"])
def test_one_dimensional_compression_has_its_modulus_and_K0(m: float, K0nc: float, contraction: str) -> None:
    """Without cohesion the path is similar to itself: K0nc everywhere, E_oed = Eoed_ref (s1/p_ref)^m."""
    soil = sand(m=m, K0nc=K0nc, contraction=contraction)
    K0 = K0nc or 1.0 - math.sin(math.radians(34.0))
    assert soil.law.K0(soil.constants) == pytest.approx(K0)
    start = 40.0
    point = point_under([K0 * start, K0 * start, start, 0.0, 0.0, 0.0], soil)
    rate = 0.02
    history = follow(soil, point, [constant_rate_oedometer(rate, 1.0)], [TIMES], tolerance=1.0e-9)
    growth = rate * TIMES * EOED / PREF
    if m == 1.0:
        vertical = start * np.exp(growth)
    else:
        vertical = PREF * ((start / PREF) ** (1.0 - m) + (1.0 - m) * growth) ** (1.0 / (1.0 - m))
    assert vertical[-1] > PREF
    assert history.stress[:, 2] == pytest.approx(vertical, rel=1.0e-5)
    assert history.stress[:, 0] == pytest.approx(K0 * history.stress[:, 2], rel=1.0e-5)


@pytest.mark.parametrize("density", [25.0, 50.0, 80.0])
def test_correlations_for_sand_give_soils_with_their_modulus(density: float) -> None:
    """Those of Brinkgreve, Engin & Engin (2010, NUMGE) with the relative density, %."""
    soil = find_law("hardening_soil").soil(
        {
            **{"E50_ref": 600.0 * density, "Eoed_ref": 600.0 * density, "Eur_ref": 1800.0 * density},
            **{"m": 0.7 - density / 320.0, "R_f": 1.0 - density / 800.0, "c": 0.0},
            **{"phi": 28.0 + density / 8.0, "psi": max(density / 8.0 - 2.0, 0.0)},
        }
    )
    K0, strain = 1.0 - math.sin(math.radians(28.0 + density / 8.0)), 1.0e-5
    point = point_under([100.0 * K0, 100.0 * K0, 100.0, 0.0, 0.0, 0.0], soil)
    end = follow(soil, point, [constant_rate_oedometer(strain, 1.0)], [[1.0]], tolerance=1.0e-10).stress[0]
    assert (end[2] - 100.0) / strain == pytest.approx(600.0 * density, rel=3.0e-3)
    assert end[0] == pytest.approx(K0 * end[2], rel=1.0e-6)


def test_one_dimensional_compression_with_cohesion_holds_at_the_reference_stress() -> None:
    soil = sand(c=8.0, K0nc=0.48)
    point = point_under([48.0, 48.0, 100.0, 0.0, 0.0, 0.0], soil)
    strain = 1.0e-5
    end = follow(soil, point, [constant_rate_oedometer(strain, 1.0)], [[1.0]], tolerance=1.0e-10).stress[0]
    assert (end[2] - 100.0) / strain == pytest.approx(EOED, rel=2.0e-3)
    assert (end[0] - 48.0) / (end[2] - 100.0) == pytest.approx(0.48, rel=2.0e-3)


@pytest.mark.parametrize("m", [0.5, 1.0])
def test_isotropic_compression_is_the_closed_form(m: float) -> None:
    """dp/K + dp_p/(H x^m), with H as the law found it; elastic below p_p."""
    soil = sand(m=m)
    H = float(soil.constants[13])
    loads = [isotropic_load(p, 1.0) for p in (100.0, 300.0)]
    history = follow(soil, isotropic(50.0, soil), loads, [[1.0], [1.0]], tolerance=1.0e-9)
    p = np.array([100.0, 300.0])
    power = np.log(p / 50.0) if m == 1.0 else ((p / PREF) ** (1.0 - m) - 0.5 ** (1.0 - m)) / (1.0 - m)
    volume = PREF * power * (3.0 * (1.0 - 2.0 * NU) / EUR + 1.0 / H)
    assert history.p == pytest.approx(p, rel=1.0e-9)
    assert history.strain[:, :3].sum(axis=1) == pytest.approx(volume, rel=1.0e-6)
    assert history.internal[:, 1] == pytest.approx(p, rel=1.0e-8)
    assert history.internal[:, 0] == pytest.approx(0.0, abs=1.0e-12)


class Rates:
    """Rate equations in compression along the axis, both surfaces active; y: s1, s3, gamma, p_p, e1, e3."""

    def __init__(self, soil: Soil, drained: bool, psi: float) -> None:
        self.exact, self.drained = Drained(1.0, phi=34.0, psi=psi), drained
        self.alpha, self.H = soil.constants[12:14].tolist()

    def __call__(self, _: float, y: FloatArray) -> list[float]:
        """Rates for a unit axial strain rate: unknown s1, s3, e3, gamma and the multiplier of the cap."""
        high, low = float(y[0]), float(y[1])
        q, p, x = high - low, (high + 2.0 * low) / 3.0, (low / PREF) ** 0.5
        E = EUR * x
        strength = self.exact.strength * low
        mobilised = q / (high + low)
        sine = max((mobilised - self.exact.critical) / (1.0 - mobilised * self.exact.critical), 0.0)
        curve = 2.0 / (INITIAL * (1.0 - q * RF / strength) ** 2)
        by_q = (curve - 2.0 / EUR) / x
        gamma = q / x * (2.0 / (INITIAL * (1.0 - q * RF / strength)) - 2.0 / EUR)
        by_low = -(0.5 * gamma + curve / x * q * q * RF / strength) / low
        axial, radial = q / self.alpha**2 + p / 3.0, -0.5 * q / self.alpha**2 + p / 3.0
        past = math.hypot(q / self.alpha, p)
        A = np.array(
            [
                [1.0 / E, -2.0 * NU / E, 0.0, 0.5 * (1.0 - sine), axial],
                [-NU / E, (1.0 - NU) / E, -1.0, -0.25 * (1.0 + sine), radial],
                [by_q, by_low - by_q, 0.0, -1.0, 0.0],
                [(q / self.alpha**2 + p / 3.0) / past, (-q / self.alpha**2 + 2.0 * p / 3.0) / past, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0, 0.0] if self.drained else [0.0, 0.0, 2.0, 0.0, 0.0],
            ]
        )
        A[3, 4] = -self.H * (past / PREF) ** 0.5 * (axial + 2.0 * radial)
        found = np.linalg.solve(A, [1.0, 0.0, 0.0, 0.0, 0.0 if self.drained else -1.0])
        return [found[0], found[1], found[3], -A[3, 4] * found[4], 1.0, found[2]]


@pytest.mark.parametrize("psi", [0.0, 5.0])
@pytest.mark.parametrize("drained", [True, False])
def test_both_surfaces_together_are_the_integrated_rates(drained: bool, psi: float) -> None:
    soil = sand(psi=psi)
    strain = 0.03 if drained else 0.01
    stage = drained_triaxial(strain, 100.0, 1.0) if drained else undrained_triaxial(strain, 1.0)
    history = follow(soil, isotropic(100.0, soil), [stage], [TIMES], tolerance=1.0e-9)
    rates = Rates(soil, drained, psi)
    start = [100.0, 100.0, 0.0, 100.0, 0.0, 0.0]
    result = solve_ivp(rates, (0.0, strain), start, "Radau", TIMES * strain, rtol=1.0e-10, atol=1.0e-10)
    high, low, gamma, past, axial, radial = result.y
    assert ((high - low) < rates.exact.strength * low).all()
    assert history.stress[:, 2] == pytest.approx(high, rel=1.0e-5)
    assert history.stress[:, 0] == pytest.approx(low, rel=1.0e-5)
    assert history.internal == pytest.approx(np.column_stack([gamma, past]), rel=1.0e-5, abs=1.0e-9)
    assert history.strain[:, 0] == pytest.approx(radial, rel=1.0e-4, abs=1.0e-8)
    assert history.strain[:, 2] == pytest.approx(axial, rel=1.0e-9)


def test_what_has_been_loaded_is_elastic_below() -> None:
    """The ratio OCR raises both surfaces as a past stress of the same ratios does; so does POP with K0nc."""
    law, stress = find_law("hardening_soil"), np.array([60.0, 60.0, 100.0, 0.0])
    two = sand(OCR=2.0)
    assert law.initial_state(stress, two.constants) == pytest.approx(law.initial_state(2.0 * stress, sand().constants))
    vertical, shift = np.array([50.0, 100.0, 50.0, 0.0]), np.array([0.5, 1.0, 0.5, 0.0])
    POP = sand(POP=40.0, K0nc=0.5)
    past = law.initial_state(vertical + 40.0 * shift, sand(K0nc=0.5).constants)
    assert law.initial_state(vertical, POP.constants) == pytest.approx(past)
    held = law.initial_state(np.array([30.0, 100.0, 30.0, 0.0]), sand(OCR=3.0).constants)
    assert held[0] == pytest.approx(
        3.0**0.5 * law.initial_state(np.array([30.0, 100.0, 30.0, 0.0]), sand().constants)[0]
    )


@pytest.mark.parametrize(("c", "cut"), [(20.0, 0.0), (20.0, 5.0), (20.0, None), (0.0, 0.0)])
def test_tension_ends_at_the_cut_off(c: float, cut: float | None) -> None:
    """Stretched along all axes: no stress falls below it, without one below the tip of the cone."""
    soil = sand(c=c, tension_cutoff=cut)
    least = c / math.tan(math.radians(34.0)) if cut is None else cut
    controls = [strain_change(-0.01 * part, **{name: 1}) for name, part in (("xx", 1.0), ("yy", 0.8), ("zz", 1.2))]
    fixed = [strain_change(0.0, **{name: 1}) for name in ("xy", "yz", "zx")]
    stage = Stage("stretched", 1.0, (*controls, *fixed))
    end = follow(soil, isotropic(50.0, soil), [stage], [[1.0]], tolerance=1.0e-6)
    assert end.stress[0, :3] == pytest.approx([-least] * 3, abs=1.0e-6)


@pytest.mark.parametrize("OCR", [1.0, 50.0])
def test_plane_strain_reaches_the_strength(OCR: float) -> None:
    """Without a cap s2 lies between: the plane of s1 and s3. Its sideways flow brings s2 down to s3: an edge."""
    soil = sand(c=5.0, psi=4.0, OCR=OCR)
    stage = Stage(
        "plane strain",
        1.0,
        (
            strain_change(0.2, zz=1),
            strain_change(0.0, yy=1),
            stress_value(80.0, xx=1),
            *(strain_change(0.0, **{name: 1}) for name in ("xy", "yz", "zx")),
        ),
    )
    end = follow(soil, isotropic(80.0, soil), [stage], [[1.0]], tolerance=1.0e-7)
    sine, a = math.sin(math.radians(34.0)), 5.0 / math.tan(math.radians(34.0))
    assert end.stress[0, 2] - 80.0 == pytest.approx(2.0 * sine / (1.0 - sine) * (80.0 + a), rel=1.0e-8)
    if OCR > 1.0:
        assert 90.0 < end.stress[0, 1] < 0.5 * (80.0 + end.stress[0, 2])
    else:
        assert end.stress[0, 1] == pytest.approx(80.0, rel=1.0e-9)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"Eur_ref": 4.0e4}, r"Eur_ref must be above 2 E50_ref/\(2 - R_f\) = 45454.5 kPa .*, got 40000 kPa"),
        ({"psi": 35.0}, "psi must be at most phi = "),
        ({"OCR": 2.0, "POP": 10.0}, "give only one of them"),
        ({"phi": 0.0}, "phi must be above 0 and below 90, got 0 degree"),
        ({"K0nc": 0.2}, r"K0nc must be above 0.28\d*, which the strength allows, got 0.2"),
        ({"K0nc": 0.32}, "K0nc = 0.32 with Eoed_ref = 22000 kPa: .* raise K0nc"),
        ({"Eoed_ref": 9.0e4}, "Eoed_ref = 90000 kPa with K0nc = .* lower Eoed_ref"),
        ({"tension_cutoff": -1.0}, "tension_cutoff must be at least 0, got -1 kPa"),
    ],
)
def test_what_does_not_fit_together_is_reported(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InfeasibleError, match=message):
        sand(**changes)


def test_a_stress_beyond_the_strength_is_reported() -> None:
    with pytest.raises(InfeasibleError, match="initial principal stresses 500, 50, 50 kPa violate the strength"):
        point_under([50.0, 500.0, 50.0, 0.0, 0.0, 0.0], sand())
