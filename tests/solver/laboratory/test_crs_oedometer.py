"""The oedometer at constant rate of strain: stages, series, what is refused, failures as data."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.registry import BUILT_IN, find_law
from geoswarm.solver.problem import load_problem
from geoswarm.verification.specimens.laboratory import CREEP, ELASTIC, crs_oedometer, run
from tests.contracts.repository import ROOT
from tests.solver.laws.checks import usual_values

CLAY = {"M": 1.0, "lambda": 0.2, "kappa": 0.04, "nu": 0.25, "e0": 1.0, "k": 1.0e-5, "C_k": 0.5}
LOOP: list[dict[str, Any]] = [
    {"axial_strain": 0.1, "rate": 0.5},
    {"axial_strain": 0.095, "rate": 0.25},
    {"axial_strain": 0.15, "rate": 0.5},
]


def test_over_strain_the_first_time_counts_and_loops_have_series_of_their_own() -> None:
    spec = crs_oedometer("modified_cam_clay", LOOP, initial_void_ratio=1.0)
    names = ("axial_stress", "pore_pressure", "pore_pressure_ratio", "effective_stress", "void_ratio")
    stress, pore, ratio, effective, e = run(spec, CLAY, [0.05, 0.098, 0.12], *names)
    assert (pore > 0.0).all()
    assert ratio == pytest.approx(pore / stress, rel=1.0e-12)
    assert effective == pytest.approx(stress - 2.0 / 3.0 * pore, rel=1.0e-12)
    assert e == pytest.approx(1.0 - 2.0 * np.array([0.05, 0.098, 0.12]), rel=1.0e-9)
    (down,) = run(spec, CLAY, [0.098], "branch_2.axial_stress")
    (up,) = run(spec, CLAY, [0.098], "branch_3.axial_stress")
    assert down[0] < 0.9 * stress[1]
    assert up[0] > down[0]
    negative = run(spec, CLAY, [0.0951], "branch_2.pore_pressure")[0]
    assert negative[0] < 0.0


def test_times_and_stages_are_those_of_the_section() -> None:
    stages = [*LOOP[:2], {"kind": "hold", "duration": 0.5}, {"axial_strain": 0.12, "duration": 0.1}]
    spec = crs_oedometer("modified_cam_clay", stages)
    (strain,) = run(spec, CLAY | {"C_k": 0.0}, [0.0, 0.1, 0.2, 0.22], "time_axial_strain")
    assert strain == pytest.approx([0.0, 0.05, 0.1, 0.095], abs=1.0e-9)
    ends, stress = run(spec, CLAY | {"C_k": 0.0}, [1.0, 2.0, 3.0, 4.0], "stage_axial_strain", "stage_axial_stress")
    assert ends[[0, 1, 3]] == pytest.approx([0.1, 0.095, 0.12], abs=1.0e-9)
    assert ends[2] != pytest.approx(0.095, abs=1.0e-5)
    assert stress[2] == pytest.approx(stress[1], rel=1.0e-9)


def test_compression_curves_run_over_the_effective_stress() -> None:
    spec = crs_oedometer("modified_cam_clay", LOOP[:1], initial_void_ratio=1.0)
    effective, e = run(spec, CLAY, [0.03, 0.08], "effective_stress", "void_ratio")
    (curve,) = run(spec, CLAY, effective, "path_void_ratio")
    assert curve == pytest.approx(e, abs=1.0e-5)


@pytest.mark.parametrize("kind", BUILT_IN)
def test_every_law_is_loaded_unloaded_and_held(kind: str) -> None:
    stages = [
        {"axial_strain": 0.02, "rate": 0.2},
        {"axial_strain": 0.0195, "rate": 0.1},
        {"kind": "hold", "keep": "strain", "duration": 0.5},
        {"axial_strain": 0.03, "rate": 0.2},
        {"kind": "hold", "duration": 0.5},
    ]
    spec = crs_oedometer(kind, stages, intervals=10, back_pressure=200)
    numbers = np.arange(1.0, 6.0)
    model = spec.build()
    names = [info.name for info in model.series if info.name.startswith("stage_")]
    found = model.prepare(dict.fromkeys(names, numbers))(usual_values(find_law(kind)) | {"k": 1.0e-5})
    assert all(np.isfinite(values).all() for values in found.values())
    assert found["stage_axial_strain"][:4] == pytest.approx([0.02, 0.0195, 0.0195, 0.03], abs=1.0e-9)
    assert found["stage_pore_pressure"][0] > 200.0
    assert abs(found["stage_pore_pressure"][4] - 200.0) < abs(found["stage_pore_pressure"][3] - 200.0)
    assert found["stage_axial_stress"][4] == pytest.approx(found["stage_axial_stress"][3], rel=1.0e-9)


@pytest.mark.usefixtures("other_laws")
def test_a_law_of_six_components_gives_what_four_give() -> None:
    soil = {"E": 5.0e3, "nu": 0.25, "ratio": 1.5, "T": 0.1, "k": 1.0e-5}
    stages = [{"axial_strain": 0.02, "rate": 0.2}, {"kind": "hold", "duration": 0.3}]
    x = [0.05, 0.1, 0.2, 0.4]
    names = ("time_axial_stress", "time_pore_pressure", "time_axial_strain")
    four = run(crs_oedometer("standard_solid", stages, initial_ratio=0.5), soil, x, *names)
    six = run(crs_oedometer("no_plane", stages, initial_ratio=0.5), soil, x, *names)
    for one, other in zip(four, six, strict=True):
        assert one == pytest.approx(other, rel=1.0e-9, abs=1.0e-12)


@pytest.mark.parametrize(
    ("stages", "changes", "message"),
    [
        ([{"axial_strain": 0.1}], {}, "give exactly one of rate, duration; none is given"),
        ([{"axial_strain": 0.1, "rate": 1.0, "duration": 1.0}], {}, "rate and duration are given"),
        ([{"axial_strain": 0.95, "rate": 1.0}], {}, "less than or equal to 0.9"),
        ([{"axial_strain": 0.1, "rate": 1.0}], {"height": 0.0}, "greater than 0"),
        ([{"axial_strain": 0.1, "rate": 1.0}], {"intervals": 2}, "greater than or equal to 4"),
        ([{"axial_strain": 0.0, "rate": 1.0}], {}, r"stages\[0\].axial_strain = 0: the stage before ends there"),
        (
            [{"axial_strain": 0.1, "rate": 1.0}, {"axial_strain": 0.1, "rate": 1.0}],
            {},
            r"stages\[1\].axial_strain = 0.1: the stage before ends there",
        ),
    ],
)
def test_sections_that_cannot_be_are_refused(
    stages: list[dict[str, Any]], changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValidationError, match=message):
        crs_oedometer("elastic", stages, **changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"k": 0.0}, r"k must be above 0, got 0 m/day"),
        ({"C_k": -0.5}, r"C_k must be at least 0"),
        ({"C_k": 0.5}, r"C_k needs the initial void ratio; where that is not given C_k must be 0, got 0.5"),
        ({"nu": 0.6}, "nu must be "),
    ],
)
def test_parameters_that_cannot_be_are_told_and_fail_a_run(changes: dict[str, float], message: str) -> None:
    model = crs_oedometer("elastic", LOOP[:1]).build()
    parameters = ELASTIC | {"k": 1.0e-4} | changes
    assert str(model.check(parameters)).startswith(message.split(":")[0])
    with pytest.raises(InfeasibleError, match=message):
        model.prepare({"axial_stress": np.array([0.01])})(parameters)


def test_a_soil_without_voids_is_a_failed_evaluation() -> None:
    spec = crs_oedometer("elastic", [{"axial_strain": 0.4, "rate": 1.0}], initial_void_ratio=0.3)
    with pytest.raises(InfeasibleError, match=r"stage 1: the void ratio falls to -\d"):
        run(spec, ELASTIC | {"k": 1.0e-3}, 0.1, "axial_stress")


def test_a_specimen_that_is_pulled_apart_has_no_stress_left() -> None:
    """Modified Cam clay swells along its lines for ever."""
    spec = crs_oedometer("modified_cam_clay", [{"axial_strain": -0.4, "rate": 1.0}])
    (stress,) = run(spec, CLAY | {"C_k": 0.0, "k": 1.0}, [-0.4], "axial_stress")
    assert stress == pytest.approx([0.0], abs=0.1)


def test_creep_goes_on_under_the_stress_that_is_held() -> None:
    stages = [{"axial_strain": 0.05, "rate": 0.5}, {"kind": "hold", "duration": 100.0}]
    strain, pore = run(
        crs_oedometer("soft_soil_creep", stages),
        CREEP | {"k": 1.0e-4},
        [1.0, 10.0, 100.0],
        "time_axial_strain",
        "time_pore_pressure",
    )
    # mu* for each e-fold of time, at a K0 that hardly changes
    assert np.diff(strain) == pytest.approx(np.full(2, CREEP["mu_star"] * np.log(10.0)), rel=0.1)
    assert abs(pore[2]) < 0.05 * abs(pore[0])


@pytest.mark.parametrize(
    "values",
    [
        {"lambda_star": 0.10887, "kappa_star": 0.017844, "POP": 54.127, "k": 2.7428e-5, "C_k": 0.50132},
        {"lambda_star": 0.10605, "kappa_star": 0.019217, "POP": 48.887, "k": 1.7546e-5, "C_k": 0.32175},
        {"lambda_star": 0.10240, "kappa_star": 0.023146, "POP": 36.905, "k": 1.5234e-5, "C_k": 0.81138},
    ],
)
def test_the_turn_to_unloading_has_a_solution_near_the_optimum_of_the_example(values: dict[str, float]) -> None:
    """Steps that grew as fast as errors fell before the turn found none in these."""
    problem = load_problem(ROOT / "examples" / "crs_oedometer" / "problem.yaml")
    found = Calibration(problem, 1).evaluate_values(problem.values([values[name] for name in problem.free_names]))
    assert found.reason is None, found.message
