"""Classical values of readings stand beside the identified ones: curves in closed form give their own slopes back."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.parameter_estimates.classical import classical_values
from geoswarm.solver.parameter_estimates.values import ClassicalValue
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.report.document.laboratory_table import Beside, laboratory_document, laboratory_table
from geoswarm.solver.report.laboratory import laboratory_values
from tests.solver.ags.synthetic import CC, CS, E0, START, STRESSES, void_ratio


def problem(series: str, x: list[float], y: list[float], stresses: tuple[float, ...], **model: Any) -> Problem:
    """An oedometer test on soft soil without anything to be identified but psi."""
    section = {
        "kind": "oedometer",
        "material": "soft_soil",
        "height": 0.02,
        "initial_stress": START,
        "stages": [{"stress": stress, "duration": 1.0} for stress in stresses],
        **model,
    }
    values = {"lambda_star": 0.1, "kappa_star": 0.02, "c": 0.0, "phi": 25.0, "POP": 80.0}
    return parse_problem(
        {
            "forward_model": section,
            "parameters": {
                **{name: {"value": value} for name, value in values.items()},
                "psi": {"lower": 0.0, "upper": 5.0},
            },
            "observations": [{"series": series, "points": {"x": x, "y": y}}],
            "stopping": {"max_evaluations": 10},
        }
    )


def found(one: Problem) -> dict[tuple[str, str], ClassicalValue]:
    return {(value.symbol, value.method): value for value in classical_values(one) if value.stage in (None, 2)}


NUMBERS = [float(n) for n in range(1, len(STRESSES) + 1)]


def test_void_ratios_at_the_ends_of_stages() -> None:
    one = problem("stage_void_ratio", NUMBERS, void_ratio(STRESSES), STRESSES, initial_void_ratio=E0)
    values = found(one)
    assert values["Cc", "steepest part"].value == pytest.approx(CC, rel=1e-9)
    assert values["Cs", "unloading"].value == pytest.approx(CS, rel=1e-9)
    for method in ("Casagrande", "log-log"):
        told = values["σ′p", method].value
        assert told is not None
        assert 50.0 < told < 130.0  # the break is at 80 kPa, between the readings at 50 and 100 kPa
    table = laboratory_table(laboratory_values(one, one.values([0.0]), None), "", Beside(classical_values(one)))
    columns = ("symbol", "quantity", "identified", "95 % interval", "from the readings", "from the calculated curve")
    assert table.columns[:6] == columns
    assert table.rows[0][:3] == ("Cc", "compression index; 2.303 λ* (1 + e₀)", "0.5066")
    assert table.rows[0][4:6] == ("0.5 (steepest part)", "–")
    assert "Casagrande" in table.rows[2][4]
    assert "log-log" in table.rows[2][4]
    assert "Values from the readings rest on these alone" in table.note
    assert laboratory_document(classical_values(one))[0]["value"] == pytest.approx(CC, rel=1e-9)


def test_strains_give_ratios_and_no_log_log() -> None:
    strain = [(E0 - e) / (1.0 + E0) for e in void_ratio(STRESSES)]
    values = found(problem("stage_axial_strain", NUMBERS, strain, STRESSES))
    assert values["Cc/(1 + e₀)", "steepest part"].value == pytest.approx(CC / (1.0 + E0), rel=1e-9)
    assert ("σ′p", "log-log") not in values


def test_what_the_readings_do_not_allow_is_reported() -> None:
    one = problem("stage_void_ratio", NUMBERS[:2], void_ratio(STRESSES)[:2], STRESSES, initial_void_ratio=E0)
    values = found(one)
    assert values["Cc", "steepest part"].value is None
    assert values["Cc", "steepest part"].why == "2 points of first loading; at least 3 are needed"
    table = laboratory_table(laboratory_values(one, one.values([0.0]), None), "", Beside(classical_values(one)))
    assert "from the readings" not in table.columns  # nothing stands beside
    assert "from the readings rest" not in table.note


def test_secondary_compression_is_read_from_a_stage() -> None:
    """Consolidation to a strain of 0.05 under the second load, as 1 - exp(-t/0.01 day), and 0.004 a decade beyond."""
    times = 10.0 ** np.linspace(-4.0, 0.0, 41)
    strain = 0.05 * -np.expm1(-times / 0.01) + 0.004 * np.log10(1.0 + times / 0.01)
    x, y = [1.0, *(1.0 + times).tolist()], [0.01, *(0.01 + strain).tolist()]
    values = found(problem("axial_strain", x, y, (50.0, 100.0, 50.0), initial_void_ratio=E0))
    told = values["Cα", "log time"].value
    # over the last half decade log10(1 + t/0.01) has a slope of 0.98
    assert told == pytest.approx(0.004 * (1.0 + E0), rel=0.025)
    assert math.isfinite(told)


def test_readings_that_count_from_a_later_stage_are_not_evaluated() -> None:
    e = void_ratio(STRESSES)
    strain = [(e[0] - now) / (1.0 + E0) for now in e]
    one = problem("stage_axial_strain", NUMBERS[1:], strain[1:], STRESSES, zero_at_stage=2)
    assert classical_values(one) == ()
