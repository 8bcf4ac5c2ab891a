"""Behaviours of MFront in the library of OpenGeoSys, installed from PyPI, beside our laws of the same equations."""

from __future__ import annotations

import math
import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ruamel.yaml import YAML

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.boundary_conditions import Stage
from geoswarm.solver.element_test.material_point import follow, point_under
from geoswarm.solver.element_test.setups import drained_triaxial, undrained_triaxial
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.solver.problem import load_problem
from geoswarm.solver.user_laws.behaviour import UnusableBehaviourError, behaviour_in
from geoswarm.solver.user_laws.mfront import MfrontSection
from tests.examples.engines import OPENGEOSYS, from_pypi
from tests.solver.laws.checks import Case, by_element_test, by_finite_element
from tests.solver.user_laws.test_sections import written

pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]

PAGE = Path(__file__).parents[2] / "docs" / "user-laws.md"
M, LAMBDA, KAPPA, NU, E0 = 1.2, 0.2, 0.04, 0.3, 1.0
ALL_ROUND = 200.0 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])


@cache
def library() -> Path:
    """The library of the wheel."""
    (found,) = from_pypi(*OPENGEOSYS).parent.glob("lib/**/libOgsMFrontBehaviour.so")
    return found


def behaviour(name: str, values: dict[str, float], **section: Any) -> Soil:
    """A soil of a behaviour."""
    made = MfrontSection.model_validate({"library": str(library()), "behaviour": name, "K0": 1, **section})
    return made.with_files(library().parent, "material").made.soil(values)


def theirs(OCR: float) -> Soil:
    """Modified Cam clay of OpenGeoSys."""
    values = {
        **{"PoissonRatio": NU, "CriticalStateLineSlope": M, "SwellingLineSlope": KAPPA},
        **{"VirginConsolidationLineSlope": LAMBDA, "CharacteristicPreConsolidationPressure": 1.0e5},
        **{"InitialVolumeRatio": 1.0 + E0},
    }
    state = {
        "PreConsolidationPressure": f"1000 * {OCR} * (p + q**2 / ({M}**2 * p))",
        "VolumeRatio": "InitialVolumeRatio",
    }
    return behaviour("ModCamClay_semiExpl", values, state=state, stress_unit="Pa")


def ours(OCR: float) -> Soil:
    """Ours, whose compressibilities refer to the initial volume, as there."""
    given = {"M": M, "lambda": LAMBDA, "kappa": KAPPA, "nu": NU, "e0": E0, "OCR": OCR, "specific_volume": "initial"}
    return find_law("modified_cam_clay").soil(given)


def strained(of: Soil, stress: FloatArray, strain: FloatArray, count: int) -> FloatArray:
    """Stress after a strain in equal steps."""
    state = of.law.initial_state(stress, of.constants)
    for _ in range(count):
        stress, state, _, status = of.law.update(strain / count, -math.inf, stress, state, of.constants)
        assert status >= 0
    return stress


@pytest.mark.parametrize("OCR", [1.0, 1.5])
@pytest.mark.parametrize(
    "strain",
    [[-0.1, -0.1, 0.2, 0.0, 0.0, 0.0], [0.0, 0.0, 0.05, 0.0, 0.0, 0.0], [-0.002, 0.001, 0.008, 0.004, -0.003, 0.002]],
    ids=["undrained", "oedometric", "general"],
)
def test_modified_cam_clay_goes_to_ours_along_any_strain(OCR: float, strain: list[float]) -> None:
    """Its steps are of first order (elasticity and hardening as at their beginning): half the step, half the error."""
    path, counts = np.array(strain), (400, 800)
    found, expected = ([strained(of, ALL_ROUND, path, n) for n in counts] for of in (theirs(OCR), ours(OCR)))
    size = np.abs(expected[1]).max()
    far, near = (np.abs(a - b).max() / size for a, b in zip(found, expected, strict=True))
    assert near < 2.0e-4
    assert 1.8 < far / near < 2.2
    assert 2.0 * found[1] - found[0] == pytest.approx(2.0 * expected[1] - expected[0], abs=2.0e-5 * size)


@pytest.mark.parametrize(
    ("OCR", "stage"),
    [
        (1.0, drained_triaxial(0.1, 200.0, 1.0)),
        (1.0, undrained_triaxial(0.1, 1.0)),
        (2.0, drained_triaxial(0.1, 200.0, 1.0)),
        (1.5, undrained_triaxial(0.3, 1.0)),
    ],
)
def test_triaxial_tests_of_modified_cam_clay_are_ours(OCR: float, stage: Stage) -> None:
    times = [0.2, 0.5, 1.0]
    found, expected = (
        follow(of, point_under(ALL_ROUND, of), [stage], [times], tolerance=1.0e-6) for of in (theirs(OCR), ours(OCR))
    )
    assert found.stress == pytest.approx(expected.stress, rel=2.0e-5, abs=1.0e-6)
    if OCR == 1.5:
        assert found.p[-1] == pytest.approx(200.0 * 0.75 ** (1.0 - KAPPA / LAMBDA), rel=1.0e-4)
        assert found.q[-1] == pytest.approx(M * found.p[-1], rel=1.0e-4)


def test_one_finite_element_gives_what_the_element_test_gives() -> None:
    of = theirs(1.5)
    values = {info.name: value for info, value in zip(of.law.parameters, of.constants[-6:].tolist(), strict=True)}
    case = Case("modified Cam clay of OpenGeoSys", of.law, values)
    stress, state, lateral = by_element_test(case, 0.02, 20)
    found = by_finite_element(case, 0.02, 20)
    assert found[0] == pytest.approx(stress[:4], rel=1.0e-6, abs=1.0e-6)
    assert found[1] == pytest.approx(state, rel=1.0e-6, abs=1.0e-9)
    assert found[2] == pytest.approx(lateral, rel=1.0e-6)


@pytest.mark.parametrize("tangent", ["routine", "differences"])
@pytest.mark.parametrize("count", [4, 6])
def test_elasticity_is_ours(tangent: str, count: int) -> None:
    moduli = {"YoungModulus": 1.0e4, "PoissonRatio": 0.3}
    of = behaviour("StandardElasticityBrick", moduli, tangent=tangent)
    our = find_law("elastic").soil({"E": 1.0e4, "nu": 0.3})
    stress, strain = np.array([60.0, 100.0, 55.0, 8.0, -5.0, 3.0]), np.array([-4e-3, 6e-3, -3e-3, 8e-3, 2e-3, -4e-3])
    state = of.law.initial_state(stress[:count], of.constants)
    found = of.law.update(strain[:count], 0.0, stress[:count], state, of.constants)
    expected = our.law.update(strain[:count], 0.0, stress[:count], np.zeros(0), our.constants)
    assert found[0] == pytest.approx(expected[0], rel=1.0e-12)
    assert found[2] == pytest.approx(expected[2], rel=1.0e-6, abs=1.0e-2)


def test_mohr_coulomb_is_ours_between_its_rounded_edges() -> None:
    """Its edges and its tip are rounded (Abbo & Sloan 1995): strength in triaxial compression is less by some 1 %."""
    values = {
        **{"YoungModulus": 1.0e4, "PoissonRatio": 0.3, "Cohesion": 5.0, "FrictionAngle": 25.0, "DilatancyAngle": 5.0},
        **{"TransitionAngle": 29.0, "TensionCutOffParameter": 0.1},
    }
    of = behaviour("MohrCoulombAbboSloan", values)
    our = find_law("mohr_coulomb").soil({"E": 1.0e4, "nu": 0.3, "c": 5.0, "phi": 25.0, "psi": 5.0})
    strain = np.array([-0.006, 0.001, 0.008, 0.004, -0.003, 0.002])
    found, expected = (strained(one, 0.5 * ALL_ROUND, strain, 200) for one in (of, our))
    assert found == pytest.approx(expected, rel=2.0e-5)
    stage = drained_triaxial(0.1, 100.0, 1.0)
    end = follow(of, point_under(0.5 * ALL_ROUND, of), [stage], [[1.0]], tolerance=1.0e-6)
    strength = 162.0881  # closed form
    assert 0.98 * strength < end.stress[-1, 2] - 100.0 < strength


def test_the_example_of_the_page_compresses_along_its_lines(tmp_path: Path) -> None:
    """All round from 100 to 120 and 400 kPa, yield at 130: kappa and lambda over the initial volume, in ln p."""
    blocks = re.findall(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    (text,) = [block for block in blocks if "law: mfront" in block]
    material = YAML(typ="safe", pure=True).load(text)["material"]
    values = {
        **{"phi": 30.0, "OCR": 1.3, "PoissonRatio": NU, "SwellingLineSlope": KAPPA},
        **{"VirginConsolidationLineSlope": LAMBDA, "InitialVolumeRatio": 1.0 + E0},
    }
    model = {
        **{"kind": "isotropic_compression", "material": {**material, "library": str(library())}, "height": 0.02},
        **{"stages": [{"stress": 120, "duration": 1}, {"stress": 400, "duration": 1}], "geometry": "fixed"},
        **{"initial_stress": 100.0, "diameter": 0.01},
    }
    document = {
        "name": "page",
        "forward_model": model,
        "parameters": {name: {"value": value} for name, value in values.items()} | {"OCR": {"lower": 1, "upper": 3}},
        "observations": [{"series": "stage_volumetric_strain", "points": {"x": [1, 2], "y": [0, 0]}}],
        "method": {"kind": "monte_carlo", "samples": 1},
    }
    problem = load_problem(written(tmp_path, document))
    run = problem.model.prepare({"stage_volumetric_strain": np.array([1.0, 2.0])})
    exact = np.array([KAPPA * math.log(1.2), KAPPA * math.log(1.3) + LAMBDA * math.log(4.0 / 1.3)]) / (1.0 + E0)
    assert run(values)["stage_volumetric_strain"] == pytest.approx(exact, rel=1.0e-4)


def test_the_library_is_found_where_the_package_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    packages = next(one for one in library().parents if one.name == "site-packages")
    monkeypatch.syspath_prepend(str(packages))
    section = {"library": "ogs", "behaviour": "StandardElasticityBrick", "K0": 1}
    found = MfrontSection.model_validate(section).with_files(PAGE.parent, "material")
    assert found.place.samefile(library())


def test_the_laws_of_the_page_are_accepted() -> None:
    text = PAGE.read_text(encoding="utf-8")
    listed = re.findall(r"`(\w+)`", text[text.index("It contains the soil laws") : text.index("Their equations are")])
    assert len(listed) == 13
    for name in listed:
        assert behaviour_in(library(), "", name).fault is None
    for name, told in (
        ("NeoHooke", "behaviours from small strain to stress are accepted"),
        ("ThermoPoroElasticity", "behaviours from small strain to stress are accepted"),
        ("MohrCoulombAbboSloanOrtho", "is orthotropic"),
    ):
        with pytest.raises(UnusableBehaviourError, match=told):
            behaviour_in(library(), "", name)
