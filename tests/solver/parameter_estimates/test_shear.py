"""Triaxial and simple shear tests: readings in closed form give strength, stiffness and dilatancy back."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.parameter_estimates.classical import classical_evaluation, classical_values
from geoswarm.solver.parameter_estimates.proposal import candidates_of
from geoswarm.solver.parameter_estimates.values import ClassicalValue
from geoswarm.solver.problem import Problem, parse_problem

PHI, C, PSI, E50, M = 32.0, 10.0, 5.0, 2.0e4, 0.6
STRAIN = np.linspace(0.0, 0.15, 151)
SINE = math.sin(math.radians(PHI))


def strength(radial: float) -> float:
    """Mohr-Coulomb."""
    return 2.0 * SINE / (1.0 - SINE) * (radial + C / math.tan(math.radians(PHI)))


def hyperbola(radial: float) -> np.ndarray:
    """Duncan & Chang's q with R_f = 0.9, its E50 the power of the radial stress, cut at the strength."""
    ultimate = strength(radial)
    modulus = E50 * (radial / 100.0) ** M
    first = modulus / (1.0 - 0.5 * 0.9)  # q = E_i eps/(1 + E_i eps R_f/q_f): at half the strength the secant is E50
    return np.minimum(first * STRAIN / (1.0 + first * STRAIN * 0.9 / ultimate), ultimate)


def part(radial: float, drainage: str = "drained") -> dict[str, Any]:
    return {
        "kind": "triaxial",
        "material": "mohr_coulomb",
        "initial_stress": radial,
        "drainage": drainage,
        "back_pressure": 200.0,
        "shearing": [{"kind": "monotonic", "axial_strain": 0.15}],
    }


def problem(parts: dict[str, Any], readings: dict[str, np.ndarray], **more: Any) -> Problem:
    return parse_problem(
        {
            "forward_model": {"kind": "combined", "parts": parts},
            "parameters": {
                "E": {"lower": 1e3, "upper": 1e5},
                "nu": {"value": 0.3},
                "c": {"lower": 0.0, "upper": 50.0},
                "phi": {"lower": 15.0, "upper": 45.0},
                **more,
            },
            "observations": [
                {"series": series, "points": {"x": STRAIN[-y.size :].tolist(), "y": y.tolist()}}
                for series, y in readings.items()
            ],
            "stopping": {"max_evaluations": 10},
        }
    )


def by_symbol(values: tuple[ClassicalValue, ...]) -> dict[tuple[str, str], float | None]:
    return {(one.part, one.symbol): one.value for one in values}


def test_drained_tests_give_mohr_circles_moduli_their_power_and_dilatancy() -> None:
    """Volumetric strain at the rate of a dilatancy angle of 5 degree: r = -2 sin(psi)/(1 - sin(psi))."""
    dilating = math.sin(math.radians(PSI))
    volume = -2.0 * dilating / (1.0 - dilating) * STRAIN
    radii = {"a": 50.0, "b": 100.0, "c": 200.0}
    readings = {f"{name}.q": hyperbola(radial) for name, radial in radii.items()} | {"a.volumetric_strain": volume}
    one = problem({name: part(radial) for name, radial in radii.items()}, readings)
    found = by_symbol(classical_values(one))
    assert found["", "φ"] == pytest.approx(PHI, rel=1e-6)
    assert found["", "c"] == pytest.approx(C, rel=1e-5)
    assert found["", "ψ"] == pytest.approx(PSI, rel=1e-6)
    for name, radial in radii.items():
        assert found[name, "E₅₀"] == pytest.approx(E50 * (radial / 100.0) ** M, rel=0.01)  # between readings
    assert found["", "E₅₀ʳᵉᶠ"] == pytest.approx(E50, rel=0.01)
    assert found["", "m"] == pytest.approx(M, abs=0.01)
    drawn = classical_evaluation(one).constructions
    assert [c.name for c in drawn] == ["mohr_circles"]
    assert [(arc.smallest, arc.largest) for arc in drawn[0].arcs] == [
        pytest.approx((radial, radial + strength(radial))) for radial in radii.values()
    ]


def test_single_readings_are_those_of_failure() -> None:
    """As files of laboratories hold them, which show no curve, stiffness or critical state."""
    radii = {"a": 50.0, "b": 100.0, "c": 200.0}
    readings = {f"{name}.q": np.array([strength(radial)]) for name, radial in radii.items()}
    found = by_symbol(classical_values(problem({name: part(radial) for name, radial in radii.items()}, readings)))
    assert found == {
        ("", "φ"): pytest.approx(PHI, rel=1e-6),
        ("", "c"): pytest.approx(C, rel=1e-5),
        ("", "φ_cs"): None,
    }


def test_the_critical_angle_is_read_from_specimens_whose_state_changes_no_more() -> None:
    """Hyperbolas end at the strength; a volume that still grows, a short test and a falling q are left out."""
    still, growing = np.zeros(STRAIN.size), -0.2 * STRAIN
    falling = hyperbola(100.0) * np.linspace(1.5, 1.0, STRAIN.size)
    readings = {"a.q": hyperbola(100.0), "a.volumetric_strain": still, "b.q": hyperbola(100.0) * 1.2}
    readings |= {"b.volumetric_strain": growing, "c.q": falling}
    one = problem({name: part(100.0) for name in "abc"}, readings)
    (angle,) = [value for value in classical_values(one) if value.symbol == "φ_cs"]
    assert angle.method == "end of shearing, 1 specimen, c = 0"
    end = strength(100.0)
    assert angle.value == pytest.approx(math.degrees(math.asin(end / (end + 200.0))), rel=1e-6)
    none = problem({"b": part(100.0)}, {"b.q": readings["b.q"], "b.volumetric_strain": growing})
    (angle,) = [value for value in classical_values(none) if value.symbol == "φ_cs"]
    assert angle.value is None
    assert "no specimen is at its critical state at the end" in angle.why


def test_no_power_of_stress_is_read_from_specimens_of_different_density() -> None:
    parts = {
        name: part(radial) | {"initial_void_ratio": e} for name, radial, e in (("a", 50.0, 0.6), ("b", 200.0, 0.9))
    }
    one = problem(parts, {"a.q": hyperbola(50.0), "b.q": hyperbola(200.0)})
    (power,) = [value for value in classical_values(one) if value.symbol == "m"]
    assert power.value is None
    assert "void ratios from 0.6 to 0.9" in power.why
    assert ("", "E₅₀ʳᵉᶠ") not in by_symbol(classical_values(one))


@pytest.mark.parametrize("by", ["pore_pressure", "p"])
def test_undrained_tests_are_evaluated_by_effective_stresses(by: str) -> None:
    """A pore pressure that grows to 60 kPa; q is the strength under the effective radial stress from 2 % on."""
    excess = 60.0 * np.minimum(STRAIN / 0.02, 1.0)
    radial = 150.0 - excess
    q = np.minimum(STRAIN / 0.02, 1.0) * strength(90.0)
    read = {"pore_pressure": 200.0 + excess, "p": radial + q / 3.0}[by]
    one = problem({"a": part(150.0, "undrained")}, {"a.q": q, f"a.{by}": read})
    found = by_symbol(classical_values(one))
    single = math.degrees(math.asin(strength(90.0) / (strength(90.0) + 2.0 * 90.0)))
    assert found["", "φ"] == pytest.approx(single, rel=1e-9)  # one circle: through the origin
    assert ("", "c") not in found
    assert ("a", "E₅₀ᵤ") in found


def test_what_a_triaxial_test_does_not_tell_is_said() -> None:
    q = hyperbola(100.0)
    for section, readings, why in (
        (part(100.0, "undrained"), {"a.q": q}, "an undrained test without p or pore_pressure gives no effective"),
        (part(100.0), {"a.q": -q}, "compression is evaluated"),
        (part(100.0), {"a.volumetric_strain": 0.1 * STRAIN}, "q over the axial strain was not read"),
        (part(100.0) | {"consolidation": [{"axial": 100.0, "radial": "K0"}]}, {"a.q": q}, "K0 consolidation was not"),
    ):
        (told,) = [one for one in classical_values(problem({"a": section}, readings)) if one.symbol == "φ"]
        assert told.value is None
        assert why in told.why


def test_simple_shear_gives_the_stress_ratio_and_the_undrained_strength() -> None:
    """tau = 40 kPa at sigma_v = 80 kPa, which was 160 kPa before: tan(phi) = 0.5, s_u/sigma_v = 0.25."""
    section = {
        "kind": "direct_simple_shear",
        "material": "mohr_coulomb",
        "initial_stress": 160.0,
        "shearing": [{"kind": "monotonic", "shear_strain": 0.2}],
    }
    grown = np.minimum(STRAIN / 0.1, 1.0)
    one = problem({"a": section}, {"a.shear_stress": 40.0 * grown, "a.pore_pressure": 80.0 * grown})
    found = by_symbol(classical_values(one))
    assert found["a", "φ"] == pytest.approx(math.degrees(math.atan(0.5)))
    assert found["a", "s_u/σ′v"] == pytest.approx(0.25)


@pytest.mark.parametrize(("given", "low", "high"), [({"value": M}, M, M), ({"lower": 0.3, "upper": 1.0}, 0.4, 1.0)])
def test_the_reference_modulus_of_one_stress_follows_from_the_power(
    given: dict[str, float], low: float, high: float
) -> None:
    """E50 = E50_ref (sigma_3/100 kPa)^m: m as the problem gives it, or in its usual range."""
    free = {"lower": 1e3, "upper": 1e5}
    document = problem({"a": part(200.0)}, {"a.q": hyperbola(200.0)}).document()
    document["forward_model"] = {"kind": "combined", "parts": {"a": {**part(200.0), "material": "hardening_soil"}}}
    document["parameters"] = {"E50_ref": free, "Eoed_ref": free, "Eur_ref": free, "m": given} | {
        name: document["parameters"][name] for name in ("c", "phi")
    }
    one = parse_problem(document)
    (found,) = candidates_of(one)["E50_ref"]
    read = E50 * 2.0**M
    assert found.ends == pytest.approx((read * 2.0**-high, read * 2.0**-low), rel=0.01)
    assert found.ends[0] <= found.value <= found.ends[1]
    assert "σ′₃ = 200 kPa" in found.source
