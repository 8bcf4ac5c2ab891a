"""Warnings of what is probably not meant: wrong problems get one that says what to do, right ones get none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.examples import example_file, example_names
from geoswarm.solver.forward.registry import parse_spec
from geoswarm.solver.plausibility import implausible, impossible
from geoswarm.solver.problem import Problem, load_problem, parse_problem
from geoswarm.solver.runs.check import check_problem
from geoswarm.solver.sentences import Key, plain

STRESSES = (25.0, 50.0, 100.0, 200.0, 400.0, 100.0)
SOIL = {"lambda_star": 0.09, "kappa_star": 0.015, "mu_star": 0.004, "c": 5.0, "phi": 24.0}
TIMES = np.concatenate([day + np.geomspace(1e-3, 0.999, 8) for day in range(len(STRESSES))])


def settlement(stresses: tuple[float, ...] = STRESSES, noise: float = 0.0) -> np.ndarray:
    """Readings in mm at :data:`TIMES` of a test with stages of one day; ``noise`` in mm."""
    stages = [{"stress": stress, "duration": 1.0} for stress in stresses]
    model = parse_spec({"kind": "oedometer", "height": 0.02, "initial_stress": 1.0, "stages": stages}).build()
    found = 1e3 * model.prepare({"settlement": TIMES})(SOIL)["settlement"]
    return np.asarray(found + np.random.default_rng(5).normal(0.0, noise, TIMES.size))


def warnings(*changes: Any, **model: Any) -> tuple[str, ...]:
    """Warnings of an oedometer test; see :func:`oedometer`."""
    return tuple(map(plain, implausible(oedometer(*changes, **model))))


def oedometer(
    observation: dict[str, Any] | None = None, parameters: dict[str, Any] | None = None, **model: Any
) -> Problem:
    """An oedometer test; changes of its observation, parameters and forward model."""
    given = {"x": (1440.0 * TIMES).tolist(), "y": settlement().tolist()}
    document = {
        "forward_model": {
            "kind": "oedometer",
            "height": 0.02,
            "initial_stress": 1.0,
            "stages": [{"stress": stress, "duration": 1.0} for stress in STRESSES],
            **model,
        },
        "parameters": {
            "lambda_star": {"lower": 0.01, "upper": 0.3},
            "kappa_star": {"value": 0.015},
            "mu_star": {"value": 0.004},
            "c": {"value": 5},
            "phi": {"value": 24},
            **(parameters or {}),
        },
        "observations": [
            {"series": "settlement", "points": given, "x_unit": "min", "y_unit": "mm"} | (observation or {})
        ],
        "stopping": {"max_evaluations": 10},
    }
    return parse_problem(document)


def points(x: np.ndarray, y: np.ndarray) -> dict[str, Any]:
    return {"points": {"x": x.tolist(), "y": y.tolist()}}


@pytest.mark.parametrize("name", example_names(engines=False))
def test_the_examples_are_plausible(name: str) -> None:
    with example_file(name) as path:
        assert implausible(load_problem(path)) == ()


@pytest.mark.parametrize("noise", [0.0, 0.005, 0.02])
def test_a_right_test_is_plausible(noise: float) -> None:
    assert warnings(points(1440.0 * TIMES, settlement(noise=noise))) == ()


def test_a_height_in_mm() -> None:
    (height,) = [one for one in warnings(height=20) if "forward_model.height" in one and "usual" in one]
    assert height == (
        "forward_model.height = 20 m is far from what is usual, 0.01 to 0.05 m; if 20 mm is meant, give 0.02, because "
        "the unit here is m"
    )


def test_stages_in_pascal_are_told_once() -> None:
    stages = [{"stress": 1000.0 * stress, "duration": 1.0} for stress in STRESSES]
    (found,) = warnings(stages=stages)
    assert found.startswith(
        "forward_model.stages[].stress = 100000 kPa (in the middle of all) is far from what is usual"
    )
    assert "5 to 1600 kPa; if 100000 Pa is meant, give 100" in found


def test_one_stage_of_400_MPa() -> None:
    stages = [{"stress": 400e3 if stress == 400 else stress, "duration": 1.0} for stress in STRESSES]
    (found,) = [one for one in warnings(stages=stages) if "usual" in one]
    assert found.startswith("forward_model.stages[4].stress = 400000 kPa is far from what is usual, 5 to 1600 kPa")


def test_small_loads_that_others_lead_to_are_no_slip() -> None:
    ladder = (0.1, 0.4, 2.0, 10.0, 50.0, 200.0, 10.0, 0.1)
    assert not any("usual" in one for one in warnings(stages=[{"stress": p, "duration": 1.0} for p in ladder]))
    alone = (0.1, *STRESSES)
    (found,) = [one for one in warnings(stages=[{"stress": p, "duration": 1.0} for p in alone]) if "usual" in one]
    assert "stages[0].stress = 0.1 kPa is far from what is usual, 5 to 1600 kPa; if 0.1 MPa is meant" in found


def test_durations_of_24_days() -> None:
    found = warnings(stages=[{"stress": stress, "duration": 24.0} for stress in STRESSES])
    assert found[0].startswith("forward_model.stages[].duration = 24 day (in the middle of all) is far from")
    assert "if 24 h is meant, give 1, because the unit here is day" in found[0]
    assert "the readings end at 8638.56 min, in stage 1 of 6, which end after 207360 min" in found[1]


def test_one_long_stage_is_nothing_unusual() -> None:
    stages = [{"stress": stress, "duration": 30.0 if stress == 400.0 else 1.0} for stress in STRESSES]
    assert not any("usual" in one for one in warnings(stages=stages))


@pytest.mark.parametrize(
    ("parameters", "begin"),
    [
        (
            {"phi": {"value": 0.42}},
            "parameters.phi.value = 0.42 degree is far from what is usual, 15 to 35 degree; if 0.42 rad",
        ),
        ({"c": {"value": 5000}}, "parameters.c.value = 5000 kPa is far from what is usual, 0 to 50 kPa; if 5000 Pa"),
        ({"lambda_star": {"lower": 4, "upper": 20}}, "parameters.lambda_star.lower = 4 is far from what is usual"),
        ({"mu_star": {"lower": 1e-7, "upper": 5e-6}}, "parameters.mu_star.upper = 5e-06 is far from what is usual"),
    ],
)
def test_parameters(parameters: dict[str, Any], begin: str) -> None:
    (found,) = warnings(parameters=parameters)
    assert found.startswith(begin)


@pytest.mark.parametrize("name", ["K0nc", "M"])
def test_a_default_that_stands_for_a_derived_value_is_usual(name: str) -> None:
    assert warnings(parameters={name: {"value": 0.0}}) == ()


def test_the_published_search_range_is_wide_and_no_mistake() -> None:
    assert warnings(parameters={"mu_star": {"lower": 1e-5, "upper": 0.75, "scale": "log"}}) == ()


def test_readings_larger_than_the_specimen() -> None:
    (found,) = warnings({"y_unit": "m"})
    assert found.startswith("observations[0] (settlement): the largest reading, 5.22 m, is more than the height")
    assert found.endswith("in mm it would be 0.26 of it: y_unit: mm")


def test_readings_next_to_nothing() -> None:
    (found,) = warnings({"y_unit": "um"})
    assert "5.22 um, is only 0.00026 of the height of the specimen, 0.02 m, under 400 times the initial" in found
    assert found.endswith("in mm it would be 0.26 of it: y_unit: mm, or check forward_model.height")
    (found,) = warnings({"y_unit": "nm"})
    assert found.endswith("in mm it would be 0.26 of it: y_unit: mm, or check forward_model.height")


def test_strain_in_percent_without_its_unit() -> None:
    given = points(1440.0 * TIMES, 100.0 * settlement() / 20.0)
    (found,) = warnings({"series": "axial_strain", "y_unit": "1", **given})
    assert "a strain of more than 1, so more than the specimen itself; in % it would be 0.26: y_unit: '%'" in found


def test_settlement_counted_negative() -> None:
    (sign, *_) = warnings(points(1440.0 * TIMES, -settlement()))
    assert sign == (
        "observations[0] (settlement): the readings are negative (down to -5.22 mm) while the stress rises to 400 kPa, "
        "but compression is positive; y_factor: -1 turns them"
    )


def test_swelling_may_be_negative() -> None:
    stages = [{"stress": 100.0, "duration": 1.0}, {"stress": 20.0, "duration": 1.0}]
    x = np.linspace(0.1, 1.0, 10)
    assert warnings({**points(x, -0.3 * x), "x_unit": "day"}, stages=stages, zero_at_stage=2) == ()


def test_a_void_ratio_in_percent() -> None:
    given = points(np.arange(1.0, 7.0), np.array([95.0, 90.0, 82.0, 74.0, 66.0, 67.0]))
    found = warnings({"series": "stage_void_ratio", "x_unit": None, "y_unit": None, **given}, initial_void_ratio=1.0)
    assert "a void ratio of 95 is outside what soils have, 0.05 to 15; if they are in %: y_unit: '%'" in found[0]


@pytest.mark.parametrize(
    ("heading", "unit", "warned"),
    [("settlement [mm]", "cm", True), ("settlement [mm]", "mm", False), ("settlement", "cm", False),
     ("force [kN]", "mm", True), ("load [kPa]", "mm", True), ("settlement in mm", "um", True),
     ("force [kN]", "mm, y_factor: 2", False)],
)  # fmt: skip
def test_the_unit_in_the_heading(heading: str, unit: str, warned: bool, tmp_path: Path) -> None:
    rows = "\n".join(f"{x},{y}" for x, y in zip(TIMES, settlement(), strict=True))
    (tmp_path / "a.csv").write_text(f"time [day],{heading}\n{rows}\n", encoding="utf-8")
    problem = f"""
forward_model:
  kind: oedometer
  height: 0.02
  initial_stress: 1
  stages: [{", ".join(f"{{stress: {stress}, duration: 1}}" for stress in STRESSES)}]
parameters:
  lambda_star: {{lower: 0.01, upper: 0.3}}
  kappa_star: {{value: 0.015}}
  mu_star: {{value: 0.004}}
  c: {{value: 5}}
  phi: {{value: 24}}
observations:
  - {{series: settlement, file: a.csv, x_column: time, y_column: "{heading}", y_unit: {unit}}}
stopping: {{max_evaluations: 10}}
"""
    (tmp_path / "problem.yaml").write_text(problem, encoding="utf-8")
    found = [one for one in map(plain, implausible(load_problem(tmp_path / "problem.yaml"))) if "heading" in one]
    assert bool(found) == warned
    if warned:
        assert found[0].startswith(
            f"observations[0].y_unit = {unit}, but according to its heading column '{heading}' is in "
        )


def test_the_wrong_unit_of_time() -> None:
    (found,) = warnings(points(24.0 * TIMES, settlement()))
    assert "the readings end at 143.976 min, in stage 1 of 6, which end after 8640 min" in found
    assert "in h they would end with it: x_unit: h" in found


def test_stages_that_were_not_read() -> None:
    read = TIMES < 4.0
    (found,) = warnings(points(1440.0 * TIMES[read], settlement()[read]))
    assert "in stage 4 of 6" in found
    assert "or leave out the stages without readings" in found
    gap = (TIMES < 2.0) | (TIMES > 3.0)
    (found,) = warnings(points(1440.0 * TIMES[gap], settlement()[gap]))
    assert "there is no reading in stage 3 of 6; check forward_model.stages against the record" in found
    kept = {**points(1440.0 * TIMES[gap], settlement()[gap]), "leave_out_stages": [3]}
    assert warnings(kept) == ()


def test_a_load_that_the_curve_does_not_show() -> None:
    skipped = (25.0, 50.0, 50.0, 200.0, 400.0, 100.0)
    (found,) = warnings(points(1440.0 * TIMES, settlement(skipped, noise=0.005)))
    assert "the readings show no step at the load of stage 3 (50 to 100 kPa); check stress and duration" in found


def test_unloading_where_the_file_loads() -> None:
    unloaded = (100.0, 400.0, 20.0, 400.0, 600.0, 100.0)
    (found, *_) = warnings(points(1440.0 * TIMES, settlement(unloaded)))
    assert "the readings go back at the load of stage 3 (50 to 100 kPa), where the stress rises" in found


def test_loads_over_the_stage_number() -> None:
    given = points(np.arange(1.0, 7.0), np.array([1.0, 2.0, 2.0, 4.5, 6.0, 5.8]))
    (found,) = warnings({"series": "stage_settlement", "x_unit": None, **given})
    assert "no step at the load of stage 3 (50 to 100 kPa)" in found


def test_a_part_of_a_combined_test_is_named() -> None:
    spec = {
        "kind": "oedometer",
        "height": 20,
        "initial_stress": 1.0,
        "stages": [{"stress": stress, "duration": 1.0} for stress in STRESSES],
    }
    given = points(TIMES, settlement())
    parameters = {name: {"value": value} for name, value in SOIL.items()} | {
        "lambda_star": {"lower": 0.01, "upper": 0.3}
    }
    document = {
        "forward_model": {"kind": "combined", "parts": {"ring": spec}},
        "parameters": parameters,
        "observations": [{"series": "ring.settlement", "y_unit": "m", **given}],
        "stopping": {"max_evaluations": 10},
    }
    found = [plain(one) for one in implausible(parse_problem(document))]
    assert found[0].startswith("forward_model.parts.ring.height = 20 m is far from what is usual")
    document["observations"] = [{"series": "ring.settlement", "y_unit": "km", **given}]
    found = [plain(one) for one in implausible(parse_problem(document))]
    assert "observations[0] (ring.settlement): the largest reading" in found[1]
    assert "in m it would be 0.26 of it" in found[1]
    document["observations"] = [
        {"series": "ring.settlement", "y_unit": "m", **points(TIMES, np.full(TIMES.size, 1e12))}
    ]
    found = [plain(one) for one in implausible(parse_problem(document))]
    assert "forward_model.parts.ring.height" in found[1]


def test_check_tells_all_of_it() -> None:
    document = {
        "forward_model": {
            "kind": "oedometer",
            "height": 20,
            "initial_stress": 1.0,
            "stages": [{"stress": 50, "duration": 1}],
        },
        "parameters": {name: {"value": value} for name, value in SOIL.items()} | {"c": {"lower": 1, "upper": 20}},
        "observations": [{"series": "settlement", "points": {"x": [0.1, 1.0], "y": [0.5, 0.7]}}],
        "stopping": {"max_evaluations": 10},
    }
    assert any("forward_model.height = 20 m" in one for one in check_problem(parse_problem(document)).warnings)


def test_stresses_and_state_variables_are_no_strains() -> None:
    stages = np.arange(1.0, len(STRESSES) + 1.0)
    for series, y in (("stage_K0", np.full(stages.size, 1.6)), ("stage_log_pp", np.full(stages.size, 4.0))):
        given = points(stages, y)["points"]
        assert warnings({"series": series, "points": given, "x_unit": None, "y_unit": None}) == ()


@pytest.mark.parametrize(
    ("changes", "refused"),
    [
        ({"y_unit": "m"}, True),  # more than the specimen
        ({"y_unit": "nm"}, True),  # nothing
        ({"y_unit": "um"}, True),  # its modulus would be that of rock
        ({"y_unit": "um", "points": {"x": [1, 2], "y": [7, 15]}}, False),  # hardly, and a very stiff soil may
        ({"series": "axial_strain", "y_unit": "1", "points": {"x": [1, 2], "y": [3, 5]}}, True),
        ({"series": "axial_strain", "y_unit": "%", "points": {"x": [1, 2], "y": [3, 5]}}, False),
        ({"points": {"x": [1, 2], "y": [-3, -5]}}, False),
    ],
)
def test_readings_that_no_soil_can_have_are_refused(changes: dict[str, Any], refused: bool) -> None:
    problem = oedometer(changes)
    assert [issue.path for issue in impossible(problem)] == ["observations[0].y_unit"] * refused
    if not refused:
        return
    series = problem.observations[0].series
    (issue,) = impossible(problem)
    assert issue.message.endswith(f"; accept: [{series}] runs the problem as it is")
    with pytest.raises(ProblemError, match="the largest reading"):
        check_problem(problem)
    accepted = parse_problem(problem.document() | {"accept": [series]})
    assert impossible(accepted) == []
    assert parse_problem(accepted.document()) == accepted
    assert any("the largest reading" in one for one in check_problem(accepted).warnings)


def test_a_sentence_names_the_keys_that_a_form_words() -> None:
    """The form showed ``y_unit: mm``."""
    (sentence,) = [one for one in implausible(oedometer({"y_unit": "m"})) if "largest" in plain(one)]
    keys = [part for part in sentence if isinstance(part, Key)]
    assert [(key.path, key.value) for key in keys] == [
        ("observations[0]", "settlement"),
        ("observations[0].y_unit", "mm"),
    ]
    assert plain(sentence).endswith("it would be 0.26 of it: y_unit: mm")
    (issue,) = impossible(oedometer({"y_unit": "m"}))
    assert plain(issue.parts) == issue.message
    assert [part.path for part in issue.parts if isinstance(part, Key)] == ["observations[0].y_unit", "accept"]


def test_what_is_accepted_is_a_series() -> None:
    problem = parse_problem(oedometer().document() | {"accept": ["settlements"]})
    assert [str(issue) for issue in impossible(problem)] == [
        "accept[0]: unknown series 'settlements'; did you mean settlement?"
    ]


@pytest.mark.parametrize(("back", "first"), [(0.0, 199.5), (200.0, 201.0)])
def test_pore_pressures_that_hold_the_back_pressure(back: float, first: float) -> None:
    cam_clay = {"kappa": 0.02, "M": 1.2, "nu": 0.2, "e0": 0.9, "OCR": 1.0}
    document = {
        "forward_model": {
            "kind": "triaxial",
            "material": "modified_cam_clay",
            "initial_stress": 100.0,
            "back_pressure": back,
            "drainage": "undrained",
            "shearing": [{"kind": "monotonic", "axial_strain": 0.1}],
        },
        "parameters": {"lambda": {"lower": 0.05, "upper": 0.5}}
        | {name: {"value": value} for name, value in cam_clay.items()},
        "observations": [
            {"series": "pore_pressure", "points": {"x": [0.0, 0.01, 0.05], "y": [first, first + 30, first + 60]}}
        ],
        "stopping": {"max_evaluations": 10},
    }
    doubts = [issue.message for issue in impossible(parse_problem(document))]
    found = (
        "the pore pressure begins at 199.5 kPa, but the back pressure of the test is 0 kPa; give back_pressure: 200, "
        "or the excess pore pressure; accept: [pore_pressure] runs the problem as it is"
    )
    assert doubts == [found] * (back == 0.0)
