"""Parameters of hypoplastic sand: closed forms, and calculated tests of the law itself, give them back."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.forward.registry import built, parse_spec
from geoswarm.solver.parameter_estimates.classical import classical_evaluation, classical_values
from geoswarm.solver.parameter_estimates.law_parameters import alpha_at_peak, bauer_fit, stiffness_exponent
from geoswarm.solver.parameter_estimates.proposal import candidates_of, proposed
from geoswarm.solver.parameter_estimates.values import NoEvaluationError
from geoswarm.solver.problem import Problem, parse_problem

H_S, N, PHI_C = 1.5e6, 0.28, 33.0  # Hochstetten sand (Herle & Gudehus 1999)
LOADS = [12.5, 25.0, 50.0, 100.0, 200.0, 400.0, 800.0, 200.0]


def law(p: np.ndarray, e_0: float) -> np.ndarray:
    """Void ratio of Bauer's law."""
    return e_0 * np.exp(-((3.0 * p / H_S) ** N))


def test_bauers_law_is_found_again() -> None:
    p = np.array([10.0, 40.0, 160.0, 640.0])
    assert bauer_fit(p, law(p, 1.05)) == pytest.approx((H_S, N, 1.05), rel=1e-6)


@pytest.mark.parametrize(
    ("p", "e", "why"),
    [
        ([10.0, 100.0, 1000.0], [1.0, 0.98, 0.95], "first loading has 3 readings"),
        ([10.0, 50.0, 100.0, 1000.0], [0.9, 0.92, 0.94, 0.95], "does not bend"),
    ],
)
def test_readings_that_tell_no_hardness(p: list[float], e: list[float], why: str) -> None:
    with pytest.raises(NoEvaluationError, match=why):
        bauer_fit(np.array(p), np.array(e))


def sand(e_0: dict[str, float]) -> Problem:
    share = (1.0 + 2.0 * (1.0 - math.sin(math.radians(PHI_C)))) / 3.0  # mean over vertical stress, at rest
    parts: dict[str, Any] = {}
    observations = []
    for name, e in e_0.items():
        start, *y = law(share * np.array([5.0, *LOADS]), e).tolist()
        parts[name] = {
            **{"kind": "oedometer", "material": "hypoplastic_sand", "height": 0.02, "initial_stress": 5.0},
            **{"initial_void_ratio": start, "stages": [{"stress": load, "duration": 1.0} for load in LOADS]},
        }
        x = list(range(1, len(LOADS) + 1))
        observations.append({"series": f"{name}.stage_void_ratio", "points": {"x": x, "y": y}})
    fixed = {"phi_c": PHI_C, "e_d0": 0.55, "e_c0": 0.95, "e_i0": 1.05, "alpha": 0.25, "beta": 1.0}
    free = {"h_s": {"lower": 1e5, "upper": 1e8, "scale": "log"}, "n": {"lower": 0.1, "upper": 0.6}}
    return parse_problem(
        {
            "forward_model": {"kind": "combined", "parts": parts},
            "parameters": free | {name: {"value": value} for name, value in fixed.items()},
            "observations": observations,
            "stopping": {"max_evaluations": 10},
        }
    )


def test_the_loosest_specimen_counts_and_its_hardness_is_an_upper_end() -> None:
    """The lower end belongs to twice the exponent: the same compression at the largest stress."""
    found = candidates_of(sand({"dense": 0.7, "loose": 0.95}))
    (h_s,), (n,) = found["h_s"], found["n"]
    assert h_s.value == pytest.approx(H_S, rel=1e-3)
    assert n.value == pytest.approx(N, rel=1e-3)
    assert h_s.source.startswith("loose: Bauer's law through first loading, e = 0.9")
    least, most = h_s.ends
    p = 800.0 * (1.0 + 2.0 * (1.0 - math.sin(math.radians(PHI_C)))) / 3.0
    assert (3.0 * p / least) ** (2.0 * N) == pytest.approx((3.0 * p / H_S) ** N, rel=1e-3)
    assert most == pytest.approx(H_S, rel=1e-3)


KARLSRUHE = {"phi_c": 33.1, "h_s": 4.0e6, "n": 0.27, "e_d0": 0.677, "e_c0": 1.054, "e_i0": 1.212, "alpha": 0.14}
BETA = 2.5


@pytest.mark.parametrize("ratio", [3.6, 4.0, 5.0])
def test_alpha_is_that_of_the_closed_form_of_herle_and_gudehus(ratio: float) -> None:
    sine = math.sin(math.radians(PHI_C))
    a = math.sqrt(3.0) * (3.0 - sine) / (2.0 * math.sqrt(2.0) * sine)
    part = (a / (2.0 + ratio)) ** 2 * (1.0 - ratio * (4.0 - ratio) / (5.0 * ratio - 2.0))
    top = 2.0 * (ratio - 4.0 + 5.0 * part * ratio**2 - 2.0 * part * ratio)
    tangent = top / ((5.0 * ratio - 2.0) * (1.0 + 2.0 * part)) - 1.0
    above = 6.0 * ((2.0 + ratio) ** 2 + a**2 * ratio * (ratio - 1.0 - tangent))
    below = a * (2.0 + ratio) * (5.0 * ratio - 2.0) * math.sqrt(4.0 + 2.0 * (1.0 + tangent) ** 2)
    assert alpha_at_peak(ratio, PHI_C, 0.5) == pytest.approx(math.log(above / below) / math.log(0.5), rel=1e-9)


def calculated(section: dict[str, Any], series: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Responses of the law."""
    model = built(parse_spec({"material": "hypoplastic_sand", **section}))
    return dict(model.prepare(series)(KARLSRUHE | {"beta": BETA}))


def test_the_peak_of_the_law_gives_alpha() -> None:
    e, pressure = 0.75, 100.0
    strain = np.linspace(0.002, 0.1, 50)
    section = {"kind": "triaxial", "initial_stress": pressure, "initial_void_ratio": e}
    found = calculated(
        section | {"shearing": [{"kind": "monotonic", "axial_strain": 0.1}]}, {"q": strain, "void_ratio": strain}
    )
    at = int(np.argmax(found["q"]))
    p = pressure + found["q"][at] / 3.0
    shrunk = math.exp(-((3.0 * p / KARLSRUHE["h_s"]) ** KARLSRUHE["n"]))
    density = (found["void_ratio"][at] / shrunk - KARLSRUHE["e_d0"]) / (KARLSRUHE["e_c0"] - KARLSRUHE["e_d0"])
    value = alpha_at_peak(1.0 + float(found["q"][at]) / pressure, KARLSRUHE["phi_c"], density)
    assert value == pytest.approx(KARLSRUHE["alpha"], rel=0.02)


def test_the_stiffness_of_the_law_gives_beta() -> None:
    stages = [{"stress": load, "duration": 1.0} for load in LOADS[:7]]
    section = {"kind": "oedometer", "height": 0.02, "initial_stress": 6.25, "initial_void_ratio": 0.72}
    e = calculated(section | {"stages": stages}, {"stage_void_ratio": np.arange(1.0, 8.0)})["stage_void_ratio"]
    assert stiffness_exponent(np.array(LOADS[:7]), e, KARLSRUHE) == pytest.approx(BETA, rel=0.02)
    assert math.isnan(stiffness_exponent(np.array([10.0, 20.0]), np.array([0.7, 0.71]), KARLSRUHE))


def test_what_is_read_first_is_known_to_what_follows() -> None:
    """Index tests give the limiting void ratios, which alpha needs; the peak is that of the law, without its noise."""
    strain = np.linspace(0.002, 0.1, 50)
    shear = {"kind": "triaxial", "material": "hypoplastic_sand", "initial_stress": 100, "initial_void_ratio": 0.75}
    shear["shearing"] = [{"kind": "monotonic", "axial_strain": 0.1}]
    read = calculated(shear, {"q": strain, "volumetric_strain": strain})
    one = parse_problem(
        {
            "forward_model": {"kind": "combined", "parts": {"shear": shear}},
            "parameters": {name: {"value": KARLSRUHE[name]} for name in ("phi_c", "h_s", "n")}
            | {"e_c0": {"lower": 0.9, "upper": 1.2}, "alpha": {"lower": 0.05, "upper": 0.5}}
            | {"e_d0": {"expression": "0.6423 * e_c0"}, "e_i0": {"expression": "1.15 * e_c0"}, "beta": {"value": BETA}},
            "observations": [
                {"series": f"shear.{name}", "points": {"x": strain.tolist(), "y": y.tolist()}}
                for name, y in read.items()
            ],
            "index_properties": {"max_void_ratio": KARLSRUHE["e_c0"]},
            "stopping": {"max_evaluations": 10},
        }
    )
    (alpha,) = candidates_of(one)["alpha"]
    assert alpha.value == pytest.approx(KARLSRUHE["alpha"], rel=0.02)
    assert alpha.source == "shear: peak of q; Herle & Gudehus (1999)"


@pytest.mark.parametrize("material", ["hypoplastic_sand", "hardening_soil"])
def test_the_bend_of_sand_is_no_preconsolidation(material: str) -> None:
    document = sand({"dense": 0.7, "loose": 0.95}).document()
    if material == "hardening_soil":
        for part in document["forward_model"]["parts"].values():
            part["material"] = material
        moduli = {"E50_ref": 3e4, "Eoed_ref": 3e4, "Eur_ref": 9e4, "m": 0.5, "c": 0.5, "phi": 33.0}
        document["parameters"] = {name: {"value": value} for name, value in moduli.items()}
        document["parameters"]["Eoed_ref"] = {"lower": 1e3, "upper": 1e5}
        assert "POP" in {one.name for one in proposed(parse_problem(document))}
        document["index_properties"] = {"min_void_ratio": 0.55, "max_void_ratio": 0.95}
    problem = parse_problem(document)
    found = [one for one in classical_values(problem) if one.symbol == "σ′p"]
    assert [(one.part, one.value) for one in found] == [("dense", None), ("loose", None)]
    assert "bends without any preconsolidation" in found[0].why
    assert classical_evaluation(problem).constructions == ()
    assert "POP" not in {one.name for one in proposed(problem)}
