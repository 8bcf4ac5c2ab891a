"""Behaviours of MFront behind the binary interface: notation, units, tangent, state, time, and what is refused."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.tensors import rotation_matrix
from geoswarm.solver.errors import ForwardError, InfeasibleError, ProblemError
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.solver.problem import load_problem, parse_problem
from geoswarm.solver.user_laws import mfront
from geoswarm.solver.user_laws.behaviour import UnusableBehaviourError, behaviour_in
from geoswarm.solver.user_laws.mfront import MfrontSection
from geoswarm.solver.warm import groups_of
from tests.solver.user_laws.behaviours import MAXWELL, TROUBLED, behaviours, section, soil
from tests.solver.user_laws.test_sections import calculated, document, written

STRESS = np.array([60.0, 100.0, 55.0, 8.0, -5.0, 3.0])
STRAIN = np.array([-4.0e-3, 6.0e-3, -3.0e-3, 8.0e-3, 2.0e-3, -4.0e-3])
MODULI = {"YoungModulus": 1.0e4, "PoissonRatio": 0.3}
G = 1.0e4 / 2.6
SLOW = 1.0e30
ROOT = math.sqrt(2.0)


def maxwell(time: float = SLOW, **changes: Any) -> Soil:
    """Elasticity whose deviator relaxes with a time, day."""
    return soil(MAXWELL, {**MODULI, "RelaxationTime": time}, **changes)


def step(of: Soil, strain: FloatArray, stress: FloatArray, log_time: float = 0.0) -> tuple[Any, ...]:
    """One step from where the soil is placed."""
    return of.law.update(strain, log_time, stress, of.law.initial_state(stress, of.constants), of.constants)


@pytest.mark.parametrize("count", [4, 6])
@pytest.mark.parametrize("tangent", ["routine", "differences"])
def test_an_elastic_behaviour_gives_what_our_elasticity_gives(count: int, tangent: str) -> None:
    ours = find_law("elastic").soil({"E": 1.0e4, "nu": 0.3})
    expected = step(ours, STRAIN[:count], STRESS[:count])
    found = step(maxwell(tangent=tangent), STRAIN[:count], STRESS[:count])
    assert found[0] == pytest.approx(expected[0], rel=1.0e-12)
    assert found[2] == pytest.approx(expected[2], rel=1.0e-12 if tangent == "routine" else 1.0e-6, abs=1.0e-2)
    assert found[3] == 0


def test_the_initial_elastic_strain_is_that_of_the_stress() -> None:
    """Tension positive, order xx yy zz xy xz yz, shear times sqrt(2) of the tensor's."""
    of = maxwell()
    state = of.law.initial_state(np.stack([STRESS, 2.0 * STRESS]), of.constants)
    volume = STRESS[:3].sum()
    normal = -(1.3 * STRESS[:3] - 0.3 * volume) / 1.0e4
    shear = -STRESS[[3, 5, 4]] / (2.0 * G) * ROOT
    assert state[0, :6] == pytest.approx([*normal, *shear], rel=1.0e-12)
    assert state[1, :6] == pytest.approx(2.0 * state[0, :6])
    assert state[0, 6:] == pytest.approx(np.zeros(7))
    names = [one.name for one in of.law.state]
    assert names[:7] == [f"ElasticStrain_{one}" for one in ("xx", "yy", "zz", "xy", "xz", "yz")] + ["ViscousStrain"]
    assert names[7:] == [f"strain_{one}" for one in ("xx", "yy", "zz", "xy", "yz", "zx")]
    plane = of.law.initial_state(STRESS[:4], of.constants)
    assert plane == pytest.approx([*normal, shear[0], *np.zeros(9)], rel=1.0e-12)


def test_state_and_total_strain_go_on_from_step_to_step() -> None:
    of = maxwell(5.0)
    stress, state = STRESS, of.law.initial_state(STRESS, of.constants)
    for number in (1, 2, 3):
        stress, state, _, status = of.law.update(STRAIN, math.log(0.5), stress, state, of.constants)
        assert status == 0
        assert state[7:] == pytest.approx(number * STRAIN)
    again = -G * 2.0 * (state[3:6] / ROOT)
    assert stress[[3, 5, 4]] == pytest.approx(again, rel=1.0e-12)


@pytest.mark.parametrize("count", [4, 6])
def test_stress_relaxes_by_its_closed_form(count: int) -> None:
    of, stress = maxwell(5.0), STRESS[:count]
    state = of.law.initial_state(stress, of.constants)
    for _ in range(10):
        stress, state, _, _ = of.law.update(np.zeros(count), math.log(0.5), stress, state, of.constants)
    mean = np.array([STRESS[:3].mean()] * 3 + [0.0] * (count - 3))
    assert stress == pytest.approx(mean + (STRESS[:count] - mean) * 1.1**-10, rel=1.0e-12)


def test_units_are_those_of_the_behaviour() -> None:
    plain = maxwell(5.0)
    values = {"YoungModulus": 10.0, "PoissonRatio": 0.3, "RelaxationTime": 5.0 * 86400.0}
    other = soil(MAXWELL, values, stress_unit="MPa", time_unit="s")
    first, second = step(plain, STRAIN, STRESS, math.log(0.5)), step(other, STRAIN, STRESS, math.log(0.5))
    for place in (0, 1, 2):
        assert second[place] == pytest.approx(first[place], rel=1.0e-10)
    assert other.law.elastic_moduli(other.constants, 50.0) == pytest.approx((1.0e4 / 1.2, G), rel=1.0e-6)


def test_turned_axes_give_the_turned_stress() -> None:
    of = maxwell(5.0)
    for axes in Rotation.random(3, rng=np.random.default_rng(5)).as_matrix():
        Q = rotation_matrix(axes)
        back = np.linalg.inv(Q).T
        here, there = step(of, STRAIN, STRESS), step(of, back @ STRAIN, Q @ STRESS)
        assert there[0] == pytest.approx(Q @ here[0], rel=1.0e-10)
        assert there[2] == pytest.approx(Q @ here[2] @ Q.T, rel=1.0e-8, abs=1.0e-6)
        assert there[1][6] == pytest.approx(here[1][6], rel=1.0e-10)


def test_a_time_of_nothing_becomes_the_least_time() -> None:
    of = maxwell(1.0e4, least_time=1.0e-3)
    expected = step(of, STRAIN, STRESS, math.log(1.0e-3))
    assert expected[0] != pytest.approx(step(of, STRAIN, STRESS, math.log(2.0e-3))[0], rel=1.0e-8)
    for log_time in (-math.inf, -9000.0):
        assert step(of, STRAIN, STRESS, log_time)[0] == pytest.approx(expected[0], rel=1.0e-14)


def test_properties_state_and_external_variables_are_expressions() -> None:
    given = {
        **MAXWELL,
        "parameters": {"eta": {"unit": "kPa day", "lower": 0}, "YoungModulus": {"unit": "kPa", "lower": 10}},
        "properties": {"RelaxationTime": "eta / YoungModulus"},
        "external": {"Factor": "2 + 0 * PoissonRatio"},
        "state": {"ViscousStrain": "eta * q / p"},
        "limit": "ViscousStrain",
    }
    of = soil(given, {**MODULI, "eta": 2.5e4})
    assert [info.name for info in of.law.parameters] == ["eta", "YoungModulus", "PoissonRatio"]
    assert of.law.parameters[1].unit == "kPa"
    found, expected = step(of, STRAIN, STRESS), step(maxwell(5.0), STRAIN, STRESS)
    assert found[0] == pytest.approx(expected[0], rel=1.0e-12)
    assert found[3] == 1
    assert expected[3] == 0
    p, q2 = 215.0 / 3.0, 0.5 * (40.0**2 + 45.0**2 + 5.0**2) + 3.0 * (64.0 + 25.0 + 9.0)
    assert of.law.initial_state(STRESS, of.constants)[6] == pytest.approx(2.5e4 * math.sqrt(q2) / p)


def test_limits_of_the_library_hold() -> None:
    for values, told in (
        ({"YoungModulus": -1.0}, "YoungModulus must be at least 0, got -1"),
        ({"PoissonRatio": 0.6}, "PoissonRatio must be at least -1 and at most 0.5, got 0.6"),
    ):
        with pytest.raises(InfeasibleError, match=told):
            soil(MAXWELL, {**MODULI, "RelaxationTime": 1.0, **values})
    with pytest.raises(InfeasibleError, match="RelaxationTime, which is not given"):
        soil(MAXWELL, MODULI)


@pytest.mark.parametrize(
    ("mode", "words"),
    [
        (1, "found no stress 2 times: no convergence after 100 rounds"),
        (2, "gave unreliable results 2 times"),
        (3, "gave numbers that are none 2 times"),
        (4, "gave numbers that are none 2 times"),
        (5, "gave numbers that are none 2 times"),
    ],
)
def test_a_step_has_no_stress_where_the_behaviour_gives_none(mode: int, words: str) -> None:
    of = soil(TROUBLED, {**MODULI, "Mode": mode})
    for _ in range(2):
        assert step(of, STRAIN, STRESS)[3] == -1
    assert of.law.troubles().endswith(words)  # type: ignore[attr-defined]
    of.law.forget_troubles()  # type: ignore[attr-defined]
    assert of.law.troubles() == ""  # type: ignore[attr-defined]
    assert step(of, np.zeros(6), STRESS)[3] == 0


def test_a_state_that_does_not_belong_to_the_stress_is_reported() -> None:
    """Here by what relaxes within the least time."""
    of = maxwell(1.0, least_time=1.0)
    with pytest.raises(InfeasibleError, match=r"placed under 60, 100, 55 kPa the behaviour has 65\.8"):
        of.law.initial_state(STRESS, of.constants)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("None", "there is no behaviour 'None' in it"),
        ("Large", "behaviour Large takes DeformationGradient; behaviours from small strain to stress are accepted"),
        ("Orthotropic", "behaviour Orthotropic is orthotropic; isotropic behaviours are accepted"),
        ("PlaneOnly", "behaviour PlaneOnly knows neither three dimensions nor plane strain"),
        ("Other", "behaviour Other was made for the interface Abaqus; generic behaviours are accepted"),
        ("Tensorial", "has state variables that are neither numbers nor symmetric tensors"),
        ("Lengthy", "has 126 numbers in its state; at most 120 are accepted"),
    ],
)
def test_a_behaviour_that_is_no_soil_law_is_reported(name: str, told: str) -> None:
    with pytest.raises(UnusableBehaviourError, match=told):
        behaviour_in(behaviours(), "", name)


def test_a_library_that_cannot_be_read_is_reported(tmp_path: Path) -> None:
    (tmp_path / "libsand.so").write_bytes(b"no library")
    with pytest.raises(UnusableBehaviourError, match=r"invalid ELF header|file too short"):
        behaviour_in(tmp_path / "libsand.so", "", "Maxwell")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"library": "none.so"}, "forward_model.material.library: none.so is not in "),
        ({"behaviour": "Maxwel"}, "forward_model.material.behaviour: "),
        ({"behaviour": "a b"}, "forward_model.material.behaviour"),
        ({"properties": {"Relaxation": 1}}, "properties.Relaxation is unknown; did you mean RelaxationTime?"),
        ({"properties": {"RelaxationTime": "tau"}}, "properties.RelaxationTime: tau is unknown"),
        ({"state": {"ElasticStrain": 0}}, "state.ElasticStrain is a tensor, which begins with 0"),
        ({"state": {"Viscous": 0}}, "state.Viscous is unknown"),
        ({"external": {}}, "external.Factor is missing: the behaviour depends on it"),
        ({"external": {"Factor": 1, "Suction": 1}}, "external.Suction is unknown; known: Factor"),
        (
            {"limit": "ElasticStrain"},
            "limit: ElasticStrain is not a state variable that is a number; did you mean ViscousStrain?",
        ),
        ({"parameters": {"E": {}}}, "parameters.E is used nowhere"),
        ({"parameters": {"p": {}}}, "parameters.p: the name stands for the stress"),
        ({"behaviour": "Indexed", "external": {}}, "properties.Normals[0] is missing: its name is none of a parameter"),
        (
            {"behaviour": "Indexed", "external": {}, "properties": {"Normals[0]": 1}},
            "properties.q is missing: its name is none of a parameter",
        ),
        ({"behavior": "Maxwell"}, "behavior is an unknown key; did you mean behaviour?; accepted: law, library"),
        ({"K0": None}, "K0 is missing: material mfront has none"),
    ],
)
def test_what_is_wrong_with_a_section_is_reported(changes: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(ProblemError) as refused:
        load_problem(written(tmp_path, oedometer(**changes)))
    assert message in str(refused.value)


def oedometer(given: dict[str, Any] = MAXWELL, extra: dict[str, Any] | None = None, **changes: Any) -> dict[str, Any]:
    """A problem with the behaviour as its material."""
    made = document(section(given, **changes))
    made["parameters"] = {
        "YoungModulus": {"lower": 1.0e3, "upper": 2.0e4, "initial": 5.0e3},
        "PoissonRatio": {"value": 0.3},
        **({"RelaxationTime": {"value": SLOW}} if extra is None else extra),
    }
    return made


CONFINED = 5.0e3 * 0.7 / (1.3 * 0.4)


@pytest.mark.parametrize("discretization", ["material_point", "finite_element"])
def test_an_elastic_behaviour_settles_by_the_confined_modulus(discretization: str, tmp_path: Path) -> None:
    made = oedometer()
    made["forward_model"]["discretization"] = discretization
    if discretization == "finite_element":
        made["forward_model"]["unit_weight"] = 0.0
    problem = load_problem(written(tmp_path, made))
    found = calculated(problem)["stage_axial_strain"]
    assert found == pytest.approx(np.array([40.0, 130.0]) / CONFINED, rel=1.0e-7)
    group = "section" if discretization == "finite_element" else "element_test"
    assert {group, "mfront"} <= set(groups_of(problem.forward_model))
    again = parse_problem(problem.document(), programs=True)
    assert again.document() == problem.document()
    assert again.document()["forward_model"]["material"]["read"]["properties"][0] == "YoungModulus"
    assert calculated(again)["stage_axial_strain"] == pytest.approx(found, rel=1.0e-15)


def test_a_service_takes_no_library() -> None:
    for programs in (False, True):
        told = "names a file" if programs else "library of the machine it runs on"
        with pytest.raises(ProblemError, match=told):
            parse_problem(oedometer(), programs=programs)


def test_a_registered_model_brings_its_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "models" / "maxwell"
    folder.mkdir(parents=True)
    shutil.copy(behaviours(), folder / "libsand.so")
    plain = oedometer(library="libsand.so")
    declared = {"forward_model": plain["forward_model"], "parameters": {name: {} for name in plain["parameters"]}}
    (folder / "model.yaml").write_text(json.dumps(declared), encoding="utf-8")
    monkeypatch.setenv("GEOSWARM_MODELS", str(folder.parent))
    problem = parse_problem({**plain, "forward_model": {"kind": "registered", "model": "maxwell"}})
    assert calculated(problem)["stage_axial_strain"] == pytest.approx(np.array([40.0, 130.0]) / CONFINED, rel=1.0e-7)
    declared["forward_model"]["material"]["library"] = "ogs"
    (folder / "model.yaml").write_text(json.dumps(declared), encoding="utf-8")
    with pytest.raises(ProblemError, match="'ogs': the library must lie in the folder of the model"):
        parse_problem({**plain, "forward_model": {"kind": "registered", "model": "maxwell"}})


def test_failures_are_told_in_the_words_of_the_behaviour(tmp_path: Path) -> None:
    problem = load_problem(written(tmp_path, oedometer(TROUBLED, {"Mode": {"value": 1}})))
    with pytest.raises(ForwardError, match=r"found no stress .* times: no convergence after 100 rounds") as failed:
        calculated(problem)
    assert failed.value.reason == "diverged"
    problem = load_problem(written(tmp_path, oedometer(TROUBLED, {"Mode": {"value": 6}})))
    with pytest.raises(ForwardError, match="ended its process by SIGABRT") as failed:
        calculated(problem)
    assert failed.value.reason == "worker_lost"


class Distribution:
    """A package as ``importlib.metadata`` tells it."""

    def __init__(self, path: Path) -> None:
        self.files = [self]
        self.name = path.name
        self._path = path

    def locate(self) -> Path:
        """Where its file is."""
        return self._path


def test_the_library_of_opengeosys_is_found_in_its_package(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    place = tmp_path / "libOgsMFrontBehaviour.so"
    place.write_bytes(behaviours().read_bytes())
    monkeypatch.setattr(mfront, "distribution", lambda _name: Distribution(place))
    made = MfrontSection.model_validate({**MAXWELL, "library": "ogs"}).with_files(tmp_path, "material")
    assert made.place == place
    assert made.read is not None
    monkeypatch.setattr(mfront, "distribution", lambda _name: Distribution(tmp_path / "other.so"))
    with pytest.raises(ProblemError, match=r"material.library: library: ogs needs the .*; or name your own library"):
        MfrontSection.model_validate({**MAXWELL, "library": "ogs"}).with_files(tmp_path, "material")
