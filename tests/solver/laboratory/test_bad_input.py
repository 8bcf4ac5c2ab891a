"""What a laboratory test cannot be is told with field, value and remedy; what fails in a run is data."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from geoswarm.solver.errors import ForwardError, InfeasibleError, ProblemError
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.check import check_problem
from geoswarm.verification.specimens.laboratory import CREEP, ELASTIC, MOHR_COULOMB, run, triaxial

STRAIN = [{"axial_strain": 0.01}]


@pytest.mark.parametrize(
    ("material", "shearing", "changes", "message"),
    [
        ("elastik", STRAIN, {}, "unknown law 'elastik'"),
        ("elastic", [{}], {}, "give exactly one of axial_strain, deviator_stress; none is given"),
        (
            "elastic",
            [{"axial_strain": 0.01, "deviator_stress": 5.0}],
            {},
            "give exactly one of axial_strain, deviator_stress; axial_strain and deviator_stress are given",
        ),
        ("elastic", [{"axial_strain": 0.01, "rate": 1.0, "duration": 1.0}], {}, "rate and duration are both given"),
        ("elastic", [{"kind": "cyclic", "cycles": 2}], {}, "exactly one of axial_strain_amplitude"),
        ("elastic", STRAIN, {"initial_ratio": -0.5}, r"initial_ratio must be above 0 and at most 100, or K0; got -0.5"),
        (
            "no_plane",
            STRAIN,
            {"initial_ratio": "K0"},
            "initial_ratio must be a number, got K0: material no_plane has no K0",
        ),
        ("soft_soil_creep", STRAIN, {}, r"shearing\[0\]: rate or duration is missing: time has an effect on material"),
        (
            "soft_soil_creep",
            [{"kind": "cyclic", "axial_strain_amplitude": 0.01, "cycles": 2}],
            {},
            r"shearing\[0\]: period is missing",
        ),
        ("elastic", STRAIN, {"water_bulk_modulus": 2.0e6}, "no stage of shearing is undrained"),
        (
            "elastic",
            STRAIN,
            {"water_bulk_modulus": 2.0e6, "drainage": "undrained"},
            "initial_void_ratio is missing: with water_bulk_modulus",
        ),
        ("elastic", STRAIN, {"initial_void_ratio": -0.4}, "greater than 0"),
        ("elastic", STRAIN, {"consolidation": [{"axial": 100.0, "radial": -5.0}]}, "radial must be above 0"),
        (
            "elastic",
            STRAIN,
            {"consolidation": [{"axial": 100.0, "duration": 1.0, "loading_time": 2.0}]},
            "loading_time must be at most the duration, 1 day, got 2 day",
        ),
        ("elastic", STRAIN, {"settings": {"formulation": "translated"}}, "settings.formulation: material elastic has"),
        ("mohr_coulomb", STRAIN, {"settings": {"tension_cutoff": -1.0}}, "tension_cutoff must be at least 0"),
        ("mohr_coulomb", STRAIN, {"settings": {"tension_cutoff": "no"}}, "must be a number of at least 0, got 'no'"),
        (
            "soft_soil_creep",
            [{"axial_strain": 0.01, "rate": 1.0}],
            {"settings": {"formulation": "other"}},
            "must be one of translated, untranslated, got ",
        ),
        (
            "elastic",
            [{"kind": "cyclic", "axial_strain_amplitude": 1e-3, "cycles": 15000}] * 2,
            {},
            "30000 cycles in all; at most 20000",
        ),
    ],
)
@pytest.mark.usefixtures("other_laws")
def test_sections_that_cannot_be_are_refused(
    material: str, shearing: list[dict[str, Any]], changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValidationError, match=message):
        triaxial(material, shearing, **changes)


@pytest.mark.parametrize("combined", [False, True])
def test_series_of_the_void_ratio_say_what_they_need(combined: bool) -> None:
    section = triaxial("elastic", STRAIN).model_dump(mode="json", exclude_none=True)
    name, model = (
        ("soft.void_ratio", {"kind": "combined", "parts": {"soft": section}})
        if combined
        else (
            "void_ratio",
            section,
        )
    )
    problem = {
        "name": "voids",
        "forward_model": model,
        "parameters": {"E": {"lower": 1.0e3, "upper": 1.0e4}, "nu": {"value": 0.3}},
        "observations": [{"series": name, "points": {"x": [0.01], "y": [0.8]}}],
        "stopping": {"max_evaluations": 10},
    }
    with pytest.raises(ProblemError, match=rf"unknown series '{name}' of .*; it needs initial_void_ratio; known"):
        parse_problem(problem)


@pytest.mark.parametrize(
    ("section", "series", "messages"),
    [
        (
            {"shearing": [{"axial_strain": 0.01}]},
            "q",
            ["forward_model.shearing[0]: kind is missing; accepted: monotonic, cyclic, hold"],
        ),
        (
            {"shearing": [{"kind": "monotonous", "axial_strain": 0.01}]},
            "q",
            ["forward_model.shearing[0]: kind is text 'monotonous'; did you mean monotonic?; accepted: monotonic, "],
        ),
        (
            {"shearing": [{"kind": "monotonic", "axial_strain": 10}]},
            "q",
            ["forward_model.shearing[0].axial_strain: must be at most 0.9, got 10"],
        ),
        ({"shearing": []}, "q", ["forward_model.shearing: must not be empty"]),
        ({}, "pore_pressure", ["it needs undrained shearing (drainage: undrained)"]),
        ({"kind": "direct_simple_shear"}, "pore_pressure", ["it needs shearing at constant volume (constant: volume)"]),
    ],
)
def test_a_mistake_is_one_message_with_its_place_and_what_is_accepted(
    section: dict[str, Any], series: str, messages: list[str]
) -> None:
    model: dict[str, Any] = {"kind": "triaxial", "material": "elastic", "initial_stress": 20.0}
    strain = "axial_strain" if section.get("kind") is None else "shear_strain"
    model |= {"shearing": [{"kind": "monotonic", strain: 0.01}]} | section
    model |= {"constant": "normal_stress"} if strain == "shear_strain" else {}
    document = {
        "name": "mistaken",
        "forward_model": model,
        "parameters": {"E": {"lower": 1.0e3, "upper": 1.0e5}, "nu": {"value": 0.3}},
        "observations": [{"series": series, "points": {"x": [0.005], "y": [10.0]}}],
        "method": {"kind": "monte_carlo", "samples": 2},
        "stopping": {"max_evaluations": 2},
    }
    with pytest.raises(ProblemError) as refused:
        parse_problem(document)
    found = [str(issue) for issue in refused.value.issues]
    assert len(found) == len(messages)
    assert all(message in one for message, one in zip(messages, found, strict=True)), found


def test_a_void_ratio_that_falls_to_zero_is_a_failed_evaluation() -> None:
    spec = triaxial("elastic", [{"axial_strain": 0.4}], initial_void_ratio=0.1)
    with pytest.raises(
        InfeasibleError, match=r"stage shearing 1: the void ratio falls to -0\.0\d+; above 0 is accepted"
    ):
        run(spec, ELASTIC, 0.1, "q")


def test_an_initial_stress_beyond_the_strength_is_a_failed_evaluation() -> None:
    spec = triaxial("mohr_coulomb", STRAIN, initial_ratio=0.1)
    with pytest.raises(InfeasibleError, match=r"initial horizontal stress = 10 kPa \(K0 = 0.1\) violates the strength"):
        run(spec, MOHR_COULOMB | {"c": 0.0}, 0.01, "q")


def test_consolidation_beyond_the_strength_names_its_stage() -> None:
    spec = triaxial("mohr_coulomb", STRAIN, consolidation=[{"axial": 120.0}, {"axial": 900.0, "radial": 100.0}])
    with pytest.raises(ForwardError, match="stage consolidation 2: no solution at"):
        run(spec, MOHR_COULOMB, 0.01, "q")


def test_parameters_that_a_law_refuses_are_told_before_a_run() -> None:
    model = triaxial("mohr_coulomb", STRAIN).build()
    assert model.check({"phi": 95.0}) == "phi must be at least 0 and below 90, got 95 degree"
    with pytest.raises(InfeasibleError, match="E and G"):
        model.prepare({"q": np.array([0.01])})({"nu": 0.3, "c": 1.0, "phi": 30.0})


def test_drained_and_undrained_creep_run_to_their_strength() -> None:
    for drainage in ("drained", "undrained"):
        spec = triaxial("soft_soil_creep", [{"axial_strain": 0.2, "rate": 0.2}], drainage=drainage)
        ratio, q = run(spec, CREEP, [0.1, 0.2], "stress_ratio", "q")
        assert np.isfinite(q).all()
        assert (ratio < 6.0 * np.sin(np.radians(28.0)) / (3.0 - np.sin(np.radians(28.0))) * (1.0 + 0.2)).all()


def test_rigid_water_is_an_assumption_that_is_reported() -> None:
    silent = triaxial("elastic", STRAIN, drainage="undrained")
    (sentence,) = silent.assumptions
    assert sentence.startswith("The bulk modulus of water is not given, so pore water is rigid")
    assert "above 0 kPa, with the void ratio" in sentence
    told = triaxial("elastic", STRAIN, drainage="undrained", water_bulk_modulus=2.2e6, initial_void_ratio=0.8)
    drained = triaxial("elastic", STRAIN)
    assert told.assumptions == drained.assumptions == ()
    parts = {
        name: spec.model_dump(mode="json", exclude_none=True)
        for name, spec in zip("abc", (silent,) * 2 + (told,), strict=True)
    }
    problem = parse_problem(
        {
            "name": "water",
            "forward_model": {"kind": "combined", "parts": parts},
            "parameters": {"E": {"lower": 1.0e3, "upper": 1.0e4}, "nu": {"value": 0.3}},
            "observations": [{"series": "a.q", "points": {"x": [0.01], "y": [40.0]}}],
            "stopping": {"max_evaluations": 10},
        }
    )
    assert check_problem(problem).assumptions == (f"a and b: {sentence}",)
