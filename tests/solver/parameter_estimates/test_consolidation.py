"""Single stages: Terzaghi's series through a whole problem gives c_v, k and the end of consolidation back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.parameter_estimates.classical import classical_evaluation, classical_values
from geoswarm.solver.problem import Problem, parse_problem

HEIGHT, C_V = 0.02, 2.0e-3  # m, m²/day, of a specimen that drains to both sides; else four times as much
TIMES = np.array([0.1, 0.25, 0.5, 1, 2, 4, 8, 15, 30, 60, 120, 240, 480, 1440])  # minutes, as laboratories read


def degree(minutes: np.ndarray, path: float) -> np.ndarray:
    """Terzaghi's average degree of consolidation."""
    M = 0.5 * math.pi * (2.0 * np.arange(2000) + 1.0)
    T = C_V * minutes / 1440.0 / path**2  # one side: c_v and path² are four times as large, T and readings the same
    return np.asarray(1.0 - (2.0 / M**2 * np.exp(-np.multiply.outer(T, M**2))).sum(axis=-1))


def problem(drainage: str, creep: float = 0.0, **selection: float) -> Problem:
    """Two loads, 50 to 100 and to 200 kPa, with strains of 4 % and 5 % by consolidation."""
    path = 0.5 * HEIGHT
    strain = np.concatenate(
        [
            0.04 * degree(TIMES, path),
            0.04 + 0.05 * degree(TIMES, path * (1.0 - 0.065)) + creep * np.log10(1.0 + TIMES / 20.0),
        ]
    )
    minutes = np.concatenate([TIMES, 1440.0 + TIMES])
    return parse_problem(
        {
            "forward_model": {
                "kind": "consolidation",
                "material": "soft_soil",
                "height": HEIGHT,
                "drainage": drainage,
                "initial_stress": 50.0,
                "initial_void_ratio": 1.0,
                "stages": [{"stress": 100.0, "duration": 1.0}, {"stress": 200.0, "duration": 1.0}],
            },
            "parameters": {
                **{name: {"value": value} for name, value in (("c", 1.0), ("phi", 25.0), ("kappa_star", 0.02))},
                "lambda_star": {"lower": 0.03, "upper": 0.3},
                "k": {"lower": 1e-6, "upper": 1e-3},
            },
            "observations": [
                {
                    **{"series": "axial_strain", "points": {"x": minutes.tolist(), "y": strain.tolist()}},
                    **{"x_unit": "min", **selection},
                }
            ],
            "stopping": {"max_evaluations": 10},
        }
    )


@pytest.mark.parametrize("drainage", ["one_side", "two_sides"])
@pytest.mark.parametrize("method", ["root time", "log time"])
def test_terzaghis_series_gives_its_coefficient_and_the_permeability(drainage: str, method: str) -> None:
    """The first stage ends at a strain of 4 %, so its mean height is 0.98 of the initial one: c_v is 0.96 of its own.

    k is c_v m_v gamma_w, m_v the strain of primary consolidation over the increase of 50 kPa.
    """
    found = [one for one in classical_values(problem(drainage)) if one.stage == 1 and one.method.startswith(method)]
    values = {one.symbol: one.value for one in found}
    true = 0.98**2 * C_V * (4.0 if drainage == "one_side" else 1.0)
    assert values["c_v"] == pytest.approx(true, rel=0.02)
    assert values["k"] == pytest.approx(true * 0.04 / 50.0 * 9.81, rel=0.02)
    assert {one.unit for one in found if one.symbol == "c_v"} == {"m²/day"}


def test_readings_that_the_search_leaves_out_after_each_load_count() -> None:
    late = problem("two_sides", 0.004, stage_x_from=120.0)
    assert len(late.observations[0].x) == 8
    assert classical_values(late) == classical_values(problem("two_sides", 0.004))


def test_the_height_of_the_middle_of_a_later_stage_counts() -> None:
    values = {(one.symbol, one.stage, one.method[:4]): one.value for one in classical_values(problem("two_sides"))}
    # the series was made for the height at 6.5 % of strain, the mean of 4 % and 9 %; the first reading is at 4.5 %
    assert values["c_v", 2, "root"] == pytest.approx(C_V, rel=0.03)
    assert values["c_v", 2, "log "] == pytest.approx(C_V, rel=0.03)


def test_secondary_compression_stands_beside_the_void_ratio() -> None:
    """A creep of 0.4 % a decade from 20 minutes on, e_0 = 1: C_alpha is 0.008."""
    one = next(v for v in classical_values(problem("two_sides", 0.004)) if (v.symbol, v.stage) == ("Cα", 2))
    assert one.value == pytest.approx(0.008, rel=0.05)


def test_constructions_go_through_the_points_that_they_name() -> None:
    found = {one.name: one for one in classical_evaluation(problem("two_sides")).constructions}
    root, log = found["root_time_1"], found["log_time_1"]
    mark = root.marks[-1]  # at t_90 the second line meets the curve, which is at 90 % there
    assert mark.y == pytest.approx(100.0 * 0.9 * 0.04, rel=0.01)
    assert mark.x**2 / 1440.0 == pytest.approx(0.848 * 0.01**2 / C_V, rel=0.02)
    second = root.lines[1]
    assert np.interp(mark.x, second.x, second.y) == pytest.approx(mark.y, rel=1e-9)
    assert log.marks[-1].y == pytest.approx(100.0 * 0.5 * 0.04, rel=0.01)
    assert root.downwards
    assert log.log


def loading(**selection: float) -> Problem:
    """Six increments that bend at 100 kPa, the third one read for an hour only; times of the test as a whole."""
    stresses = np.array([25.0, 50.0, 100.0, 200.0, 400.0, 800.0])
    ends = 0.02 * np.log10(stresses / 12.5) + 0.15 * np.log10(np.maximum(stresses / 100.0, 1.0))
    minutes, strain, begin, before = [], [], 0.0, 0.0
    stages = []
    for number, (stress, end) in enumerate(zip(stresses, ends, strict=True), 1):
        times = TIMES[TIMES <= 60.0] if number == 3 else TIMES
        share = degree(times, 0.5 * HEIGHT)
        minutes += (begin + times).tolist()
        strain += (before + (end - before) * share / share[-1]).tolist()
        stages.append({"stress": stress, "duration": times[-1] / 1440.0})
        begin, before = begin + times[-1], end
    document = problem("two_sides").document()
    document["forward_model"] |= {"stages": stages, "initial_stress": 12.5}
    points = {"x": minutes, "y": strain}
    document["observations"] = [{"series": "axial_strain", "points": points, "x_unit": "min", **selection}]
    return parse_problem(document)


def test_increments_that_the_search_leaves_out_whole_count_for_the_preconsolidation_stress() -> None:
    """Without the increment to 100 kPa, which ends within the first two hours, the curve would bend elsewhere."""
    whole, late = loading(), loading(stage_x_from=120.0)
    assert len(late.observations[0].x) == 5 * 4
    found = {one.method: one.value for one in classical_values(late) if one.symbol == "σ′p"}
    assert found == {one.method: one.value for one in classical_values(whole) if one.symbol == "σ′p"}
    assert found["log-log"] == pytest.approx(100.0, rel=0.1)
    assert classical_values(late) == classical_values(whole)
