"""A pace that neither the law nor a reading knows of is warned of."""

from __future__ import annotations

from typing import Any

import pytest

from geoswarm.solver.plausibility import implausible
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.sentences import Key, plain

CREEP = {"lambda_star": 0.05, "kappa_star": 0.01, "c": 1.0, "phi": 30.0}


def warnings(shearing: list[dict[str, Any]], series: str = "q", **section: Any) -> list[tuple[str | Key, ...]]:
    """Of two elastic triaxial tests, the second without a pace."""
    part = {"kind": "triaxial", "material": "elastic", "initial_stress": 100, **section}
    bare = [{key: value for key, value in stage.items() if key not in ("rate", "duration")} for stage in shearing]
    document = {
        "forward_model": {
            "kind": "combined",
            "parts": {"A": part | {"shearing": shearing}, "B": part | {"shearing": bare}},
        },
        "parameters": {"E": {"lower": 1000, "upper": 9000}, "nu": {"value": 0.3}},
        "observations": [{"series": f"A.{series}", "points": {"x": [0.01, 0.02], "y": [50, 100]}}],
        "stopping": {"max_evaluations": 10},
    }
    return [one for one in implausible(parse_problem(document)) if "has no effect" in plain(one)]


def test_a_rate_on_a_law_without_time_is_named() -> None:
    (found,) = warnings([{"kind": "monotonic", "axial_strain": 0.1, "rate": 0.24}])
    assert found[0] == Key("forward_model.parts.A.shearing[0].rate", "rate")
    assert plain(found) == (
        "rate of forward_model.parts.A.shearing[0] has no effect: material elastic does not depend on time, and no "
        "series over time is observed. Leave it out, or take a law with creep."
    )


def test_many_stages_are_one_warning() -> None:
    shearing = [{"kind": "monotonic", "axial_strain": 0.01 * number, "duration": 0.1} for number in range(1, 6)]
    (found,) = warnings(shearing)
    assert plain(found).startswith("duration of forward_model.parts.A.shearing[0], ")
    assert "shearing[2] and 2 more has no effect" in plain(found)


@pytest.mark.parametrize(
    ("shearing", "section", "key"),
    [
        ([{"kind": "cyclic", "axial_strain_amplitude": 0.01, "cycles": 2, "period": 0.1}], {}, "period"),
        (
            [{"kind": "monotonic", "axial_strain": 0.1}],
            {"consolidation": [{"axial": 200, "loading_time": 0.5}]},
            "loading_time",
        ),
    ],
)
def test_so_are_periods_and_times_of_loading(shearing: list[dict[str, Any]], section: dict[str, Any], key: str) -> None:
    assert {found[0].text for found in warnings(shearing, **section) if isinstance(found[0], Key)} == {key}


def test_readings_over_time_need_the_pace() -> None:
    assert not warnings([{"kind": "monotonic", "axial_strain": 0.1, "rate": 0.24}], "time_q")


def test_a_law_with_creep_needs_it() -> None:
    document = {
        "forward_model": {
            "kind": "triaxial",
            "material": "soft_soil_creep",
            "initial_stress": 100,
            "shearing": [{"kind": "monotonic", "axial_strain": 0.1, "rate": 0.24}],
        },
        "parameters": {name: {"value": value} for name, value in CREEP.items()}
        | {"mu_star": {"lower": 0.001, "upper": 0.01}},
        "observations": [{"series": "q", "points": {"x": [0.01, 0.02], "y": [50, 100]}}],
        "stopping": {"max_evaluations": 10},
    }
    assert not [one for one in map(plain, implausible(parse_problem(document))) if "has no effect" in one]
