"""Sections of laws in libraries: what is refused and told, where they are accepted, what a problem keeps of them."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ForwardError, ProblemError
from geoswarm.solver.forward.oedometer import OedometerSpec
from geoswarm.solver.forward.registry import parse_spec
from geoswarm.solver.problem import Problem, load_problem, parse_problem, problem_schema
from geoswarm.solver.user_laws.library import opened
from geoswarm.solver.user_laws.mfront import MfrontSection
from geoswarm.solver.user_laws.umat import UmatSection
from geoswarm.solver.warm import groups_of
from tests.solver.user_laws.routines import DRUCKER_PRAGER, ELASTIC, MISBEHAVING, SOURCES, library, section

STAGES = [{"stress": 60.0, "duration": 1.0}, {"stress": 150.0, "duration": 2.0}]
STRAINED = {"kind": "monotonic", "axial_strain": 0.2, "duration": 1.0}
CONFINED = 5.0e3 * 0.7 / (1.3 * 0.4)


def document(
    material: Mapping[str, Any], parameters: Mapping[str, Any] | None = None, **changes: Any
) -> dict[str, Any]:
    """An oedometer of a routine at small strain."""
    return {
        "name": "routine",
        "forward_model": {
            **{"kind": "oedometer", "material": dict(material), "height": 0.02, "initial_stress": 20.0},
            **{"stages": STAGES, "geometry": "fixed", **changes},
        },
        "parameters": {
            "E": {"lower": 1.0e3, "upper": 2.0e4, "initial": 5.0e3},
            "nu": {"value": 0.3},
            **(parameters or {}),
        },
        "observations": [{"series": "stage_axial_strain", "points": {"x": [1.0, 2.0], "y": [0.006, 0.02]}}],
        "method": {"kind": "monte_carlo", "samples": 1},
    }


def written(folder: Path, problem: Mapping[str, Any]) -> Path:
    """A problem file."""
    path = folder / "problem.json"
    path.write_text(json.dumps(problem), encoding="utf-8")
    return path


def calculated(problem: Problem, **values: float) -> dict[str, np.ndarray]:
    """The observed series."""
    run = problem.model.prepare({one.series: one.x for one in problem.observations})
    return run({**problem.values([5.0e3]), **values})


def issues(problem: Mapping[str, Any], folder: Path) -> str:
    """What is wrong with a problem file."""
    with pytest.raises(ProblemError) as refused:
        load_problem(written(folder, problem))
    return str(refused.value)


@pytest.mark.parametrize("discretization", ["material_point", "finite_element"])
def test_an_elastic_routine_settles_by_the_confined_modulus(discretization: str, tmp_path: Path) -> None:
    extra = {"unit_weight": 0.0} if discretization == "finite_element" else {}
    problem = load_problem(written(tmp_path, document(section(ELASTIC), discretization=discretization, **extra)))
    found = calculated(problem)["stage_axial_strain"]
    assert found == pytest.approx(np.array([40.0, 130.0]) / CONFINED, rel=1.0e-7)
    group = "section" if discretization == "finite_element" else "element_test"
    assert {group, "umat"} <= set(groups_of(problem.forward_model))


def test_a_triaxial_test_of_a_routine_reaches_the_strength_in_closed_form(tmp_path: Path) -> None:
    """q = 2 (sigma_3 sin phi + c cos phi) / (1 - sin phi); flags of the routine are those of a step, not means."""
    problem = document(section(DRUCKER_PRAGER), {"c": {"value": 5.0}, "phi": {"value": 30.0}})
    test = {"kind": "triaxial", "initial_stress": 100.0, "shearing": [STRAINED]}
    problem["forward_model"] = {**test, "material": section(DRUCKER_PRAGER), "geometry": "fixed"}
    problem["observations"] = [
        {"series": name, "points": {"x": [0.001, 0.2], "y": [0.0, 0.0]}} for name in ("q", "yields")
    ]
    found = calculated(load_problem(written(tmp_path, problem)))
    assert found["q"] == pytest.approx([5.0, 2.0 * (50.0 + 5.0 * np.sqrt(0.75)) / 0.5], rel=1.0e-6)
    assert found["yields"].tolist() == [0.0, 1.0]


def test_a_problem_keeps_where_the_library_is_and_what_is_in_it(tmp_path: Path) -> None:
    shutil.copy(library("elastic.f"), tmp_path / "libsand.so")
    problem = load_problem(written(tmp_path, document({**section(ELASTIC), "library": "libsand.so"})))
    kept = problem.document()["forward_model"]["material"]
    assert kept["folder"] == str(tmp_path)
    assert kept["version"] == hashlib.sha256((tmp_path / "libsand.so").read_bytes()).hexdigest()
    again = parse_problem(problem.document(), programs=True)
    assert again.document() == problem.document()
    assert calculated(again)["stage_axial_strain"] == pytest.approx(np.array([40.0, 130.0]) / CONFINED, rel=1.0e-7)
    shutil.copy(library("norton.f90"), tmp_path / "libsand.so")
    with pytest.raises(ForwardError, match="has changed since the problem was read") as failed:
        calculated(again)
    assert failed.value.reason == "not_started"
    (tmp_path / "libsand.so").unlink()
    assert "libsand.so of law: umat is not there" in (again.forward_model.unavailable() or "")


def test_a_service_takes_no_library() -> None:
    for programs in (False, True):
        with pytest.raises(ProblemError, match="library of the machine it runs on" if not programs else "names a file"):
            parse_problem(document({**section(ELASTIC), "library": "libsand.so"}), programs=programs)
    text = json.dumps(problem_schema())
    assert "umat" not in text
    assert "mfront" not in text
    assert "libsand" not in text


def test_the_parts_of_a_combined_problem_may_be_routines(tmp_path: Path) -> None:
    plain = document(section(ELASTIC))
    parts = {"first": plain["forward_model"], "second": {**plain["forward_model"], "material": "elastic"}}
    plain["forward_model"] = {"kind": "combined", "parts": parts}
    plain["observations"] = [
        {"series": f"{name}.stage_axial_strain", "points": {"x": [1.0, 2.0], "y": [0.006, 0.02]}} for name in parts
    ]
    problem = load_problem(written(tmp_path, plain))
    assert problem.forward_model.runs_programs
    assert problem.forward_model.runs_outside
    found = calculated(problem)
    assert found["first.stage_axial_strain"] == pytest.approx(found["second.stage_axial_strain"], rel=1.0e-7)


def test_a_section_may_have_soils_of_routines(tmp_path: Path) -> None:
    soil = section(DRUCKER_PRAGER, values={"E": "E", "nu": 0.3, "c": 50, "phi": 25}, unit_weight=0)
    problem = {
        **document(section(ELASTIC)),
        "forward_model": {
            "kind": "section",
            "surface": [[0, 2], [4, 2]],
            "layers": [{"name": "ground", "thickness": 2}],
            "points": {"A": {"x": 2}},
            "element_length": 2,
            "materials": {"sand": soil},
            "phases": [
                {"name": "weight", "kind": "gravity", "materials": {"ground": "sand"}},
                {"name": "load", "kind": "plastic", "loads": [{"boundary": "surface", "pressure": 50}]},
            ],
            "zero_at_phase": "load",
        },
        "parameters": {"E": {"lower": 1.0e3, "upper": 2.0e4}},
        "observations": [{"series": "A.uy", "points": {"x": [0.0], "y": [0.0]}}],
    }
    loaded = load_problem(written(tmp_path, problem))
    assert [info.name for info in loaded.model.parameters] == ["E"]
    assert loaded.model.parameters[0].description == "E"
    assert set(groups_of(loaded.forward_model)) == {"section", "elastic", "umat"}
    assert calculated(loaded)["A.uy"] == pytest.approx([-2.0 * 50.0 / CONFINED], rel=1.0e-6)
    assert parse_problem(loaded.document(), programs=True).document() == loaded.document()
    soil["values"] = {"E": "E", "nu": 0.3, "c": 50, "fi": 25}
    assert "forward_model.materials.sand.values.fi: is unknown" in issues(problem, tmp_path)
    soil["values"] = {"E": "E", "nu": 0.3, "c": 50}
    assert "forward_model.materials.sand.values.phi: is missing" in issues(problem, tmp_path)
    soil["values"] = {"E": "E", "nu": 0.6, "c": 50, "phi": 25}
    assert "nu must be at least 0 and at most 0.499, got 0.6" in issues(problem, tmp_path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"law": "umatt"}, "law must be one of umat, mfront in a section of a material; did you mean umat?"),
        ({"library": "none.so"}, "forward_model.material.library: none.so is not in "),
        ({"library": "."}, "forward_model.material.library: . is not a file"),
        ({"props": ["E", "mu"]}, "props[1]: mu is unknown; known: E, nu, r13, r23"),
        ({"props": ["E", "nu"]}, "parameters.r13 is used nowhere"),
        ({"props": ["E", "nu", "r13 > r23"]}, "is a comparison; give a number or an expression"),
        ({"props": ["E", "nu", "r13 +"]}, "forward_model.material.props[2]"),
        ({"props": ["E", "nu", True]}, "must be a number, or an expression of parameters as text"),
        ({"state": [{"name": "a"}, {"name": "a"}]}, "the name a is given to two variables"),
        ({"state": [{"name": "total_time"}]}, "the name total_time is given to two variables"),
        ({"state": [{"name": "a", "initial": "OCR"}]}, "state.a.initial: OCR is unknown"),
        ({"limit": "yields"}, "limit: yields is not a state variable; known: none"),
        ({"shear_order": ["xy", "xz", "xz"]}, "shear_order must be [xy, xz, yz] or [xy, yz, xz]"),
        ({"stress_unit": "m"}, "'m'"),
        ({"least_time": 0}, "least_time: must be above 0"),
        ({"name": "x" * 65}, "forward_model.material.name"),
        ({"parameters": {"p": {}, "E": {}}}, "parameters.p: the name stands for the stress"),
        ({"parameters": {"E": {"lower": 2, "upper": 1}}}, "lower 2 must be below upper 1"),
        ({"propz": []}, "propz is an unknown key; did you mean props?; accepted: law, library, parameters, K0"),
        ({"K0": None}, "K0 is missing: material umat has none"),
    ],
)
def test_what_is_wrong_with_a_section_is_reported(changes: dict[str, Any], message: str, tmp_path: Path) -> None:
    assert message in issues(document({**section(ELASTIC), **changes}), tmp_path)


@pytest.mark.parametrize(
    ("material", "message"),
    [
        ("umat", "law umat needs a section: {law: umat, library: libsand.so, ...}"),
        ("elastik", "unknown law 'elastik'"),
        ({"library": "a"}, "law must be one of umat, mfront"),
        (3, "forward_model.material"),
    ],
)
def test_a_law_is_a_name_or_a_section(material: Any, message: str, tmp_path: Path) -> None:
    problem = document({})
    problem["forward_model"]["material"] = material
    assert message in issues(problem, tmp_path)


def test_limits_of_parameters_are_those_declared(tmp_path: Path) -> None:
    told = issues(document(section(ELASTIC), {"nu": {"value": 0.5}}), tmp_path)
    assert "parameters.nu.value: " in told
    assert "0.499" in told
    assert "parameters.phi: unknown parameter" in issues(document(section(ELASTIC), {"phi": {"value": 1}}), tmp_path)


def test_a_library_without_the_routine_or_its_utilities_is_reported(tmp_path: Path) -> None:
    bare = tmp_path / "libbare.so"
    call = ["gfortran", "-shared", "-fPIC", "-std=legacy", "-fcray-pointer", "-I", str(tmp_path), "-o", str(bare)]
    (tmp_path / "aba_param.inc").write_text("      IMPLICIT REAL*8 (A-H,O-Z)\n", encoding="utf-8")
    subprocess.run([*call, str(SOURCES / "misbehaving.f")], check=True, capture_output=True)
    problem = load_problem(written(tmp_path, document({**section(MISBEHAVING), "library": "libbare.so"})))
    with pytest.raises(ForwardError, match=r"it calls (xit_|stdb_abqerr_), which it does not have; `geoswarm model"):
        calculated(problem)
    other = load_problem(written(tmp_path, document({**section(ELASTIC), "function": "vumat_"})))
    with pytest.raises(ForwardError, match="there is no function 'vumat_'") as failed:
        calculated(other)
    assert failed.value.reason == "not_started"
    bare.write_bytes(b"no library")
    broken = load_problem(written(tmp_path, document({**section(ELASTIC), "library": "libbare.so"})))
    with pytest.raises(ForwardError, match="cannot be loaded"):
        calculated(broken)


def test_a_library_is_not_opened_before_a_run(tmp_path: Path) -> None:
    (tmp_path / "libsand.so").write_bytes(b"no library")
    problem = load_problem(written(tmp_path, document({**section(ELASTIC), "library": "libsand.so"})))
    before = opened.cache_info()
    assert problem.model.check({"E": 1.0, "nu": 0.3}) is None
    assert problem.model.check({"E": -1.0}) == "E must be at least 0, got -1 kPa"
    assert opened.cache_info() == before


def test_sections_of_python_are_strict() -> None:
    with pytest.raises(ValueError, match="valid boolean"):
        OedometerSpec.model_validate(document({**section(ELASTIC), "stateful": "yes"})["forward_model"])
    spec = parse_spec(document(section(ELASTIC))["forward_model"])
    assert [law.law for law in spec.user_laws] == ["umat"]
    assert not spec.quick


def test_the_page_has_every_key() -> None:
    page = (Path(__file__).parents[3] / "docs" / "user-laws.md").read_text(encoding="utf-8")
    rows = [line.split("|")[1] for line in page.splitlines() if line.startswith("| `")]
    documented = {name for row in rows for name in re.findall(r"`(\w+)`", row)}
    kept = {"law", "folder", "version", "read"}
    assert documented == (UmatSection.model_fields.keys() | MfrontSection.model_fields.keys()) - kept
