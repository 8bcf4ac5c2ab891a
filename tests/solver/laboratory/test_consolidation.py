"""Consolidation in stages of the oedometer: series, stages, what is refused, failures as data."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from geoswarm.solver.errors import InfeasibleError, ProblemError
from geoswarm.solver.laws.registry import BUILT_IN, find_law
from geoswarm.verification.specimens.laboratory import CREEP, ELASTIC, consolidation, run
from tests.solver.laws.checks import usual_values, void_ratio_for

CLAY = {"M": 1.0, "lambda": 0.2, "kappa": 0.04, "nu": 0.25, "e0": 1.0, "k": 2.0e-5, "C_k": 0.5}
STAGES = [(200.0, 1.0), (400.0, 1.0, 0.1), (100.0, 1.0)]


def test_a_stage_has_series_of_its_own_that_count_from_its_load() -> None:
    spec = consolidation("modified_cam_clay", STAGES, initial_void_ratio=1.0, back_pressure=50.0)
    x = np.array([0.0, 0.05, 0.5, 1.0])
    whole, pore = run(spec, CLAY, 1.0 + x, "settlement", "pore_pressure")
    within, own = run(spec, CLAY, x, "branch_2.settlement", "branch_2.pore_pressure")
    assert within == pytest.approx(whole - whole[0], abs=1.0e-12)
    assert own == pytest.approx(pore, rel=1.0e-12)
    ends, strain, e = run(spec, CLAY, [1.0, 2.0, 3.0], "stage_settlement", "stage_axial_strain", "stage_void_ratio")
    assert ends[:2] == pytest.approx(whole[[0, 3]], rel=1.0e-12)
    assert strain == pytest.approx(ends / 0.02, rel=1.0e-12)
    assert e == pytest.approx(1.0 - 2.0 * strain, rel=1.0e-12)
    assert ends[2] < ends[1]
    (swollen,) = run(spec, CLAY, [0.01], "branch_3.pore_pressure")
    assert swollen[0] < 50.0


def test_at_time_zero_is_the_reading_before_the_load() -> None:
    spec = consolidation("elastic", [(200.0, 1.0)])
    (pore,) = run(spec, ELASTIC | {"k": 1.0e-6}, [0.0, 1.0e-4], "pore_pressure")
    assert pore[0] == 0.0
    assert pore[1] == pytest.approx(100.0, rel=1.0e-3)


def test_time_and_settlement_may_count_from_a_later_stage() -> None:
    first = consolidation("modified_cam_clay", STAGES)
    later = consolidation("modified_cam_clay", STAGES, zero_at_stage=2)
    clay = CLAY | {"C_k": 0.0}
    (from_first,) = run(first, clay, [1.0, 1.3, 2.0], "settlement")
    from_second, strain = run(later, clay, [0.0, 0.3, 1.0], "settlement", "axial_strain")
    assert from_second == pytest.approx(from_first - from_first[0], abs=1.0e-12)
    assert strain == pytest.approx(from_second / 0.02, abs=1.0e-12)


@pytest.mark.parametrize("kind", BUILT_IN)
def test_every_law_consolidates_and_swells(kind: str) -> None:
    spec = consolidation(kind, [(150.0, 0.5), (130.0, 0.5), (200.0, 0.5, 0.1)], cells=8, **void_ratio_for(kind, 1.5))
    model = spec.build()
    names = [info.name for info in model.series if info.name.startswith("stage_")]
    found = model.prepare(dict.fromkeys(names, np.arange(1.0, 4.0)))(usual_values(find_law(kind)) | {"k": 1.0e-5})
    assert all(np.isfinite(values).all() for values in found.values())
    settlement = found["stage_settlement"]
    assert settlement[0] > 0.0
    assert settlement[2] > settlement[1]


def test_creep_follows_primary_consolidation() -> None:
    stages = [(200.0, 1000.0)]
    (settlement,) = run(
        consolidation("soft_soil_creep", stages, geometry="fixed"),
        CREEP | {"k": 1.0e-4},
        [10.0, 100.0, 1000.0],
        "axial_strain",
    )
    assert np.diff(settlement) == pytest.approx(np.full(2, CREEP["mu_star"] * np.log(10.0)), rel=0.1)


@pytest.mark.usefixtures("other_laws")
def test_a_law_of_six_components_gives_what_four_give() -> None:
    soil = {"E": 5.0e3, "nu": 0.25, "ratio": 1.5, "T": 0.1, "k": 1.0e-5}
    names = ("settlement", "pore_pressure")
    four = run(consolidation("standard_solid", [(200.0, 1.0)], initial_ratio=0.5), soil, [0.1, 0.4, 1.0], *names)
    six = run(consolidation("no_plane", [(200.0, 1.0)], initial_ratio=0.5), soil, [0.1, 0.4, 1.0], *names)
    for one, other in zip(four, six, strict=True):
        assert one == pytest.approx(other, rel=1.0e-9, abs=1.0e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stages": []}, "at least 1 item"),
        ({"stages": [{"stress": 0.0}]}, "greater than 0"),
        ({"stages": [{"stress": 50.0, "loading_time": 2.0}]}, "loading_time must be at most the duration, 1"),
        ({"height": 0.0}, "greater than 0"),
        ({"cells": 3}, "greater than or equal to 4"),
        ({"drainage": "sides"}, "'one_side' or 'two_sides'"),
        ({"zero_at_stage": 2}, "zero_at_stage must be from 1 to 1, got 2"),
        ({"initial_ratio": -0.5}, "initial_ratio must be above 0"),
        ({"settings": {"shape": 1}}, "settings.shape: material elastic has no such setting"),
    ],
)
def test_sections_that_cannot_be_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        consolidation("elastic", [(200.0, 1.0)], **changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"k": 0.0}, r"k must be above 0, got 0 m/day"),
        ({"C_k": 0.5}, r"C_k needs the initial void ratio; where that is not given C_k must be 0, got 0.5"),
        ({"nu": 0.6}, "nu must be "),
    ],
)
def test_parameters_that_cannot_be_are_told_and_fail_a_run(changes: dict[str, float], message: str) -> None:
    model = consolidation("elastic", [(200.0, 1.0)]).build()
    parameters = ELASTIC | {"k": 1.0e-4} | changes
    assert str(model.check(parameters)).startswith(message.split(":")[0])
    with pytest.raises(InfeasibleError, match=message):
        model.prepare({"settlement": np.array([0.01])})(parameters)


def test_readings_after_the_end_are_refused() -> None:
    model = consolidation("elastic", [(200.0, 1.0)]).build()
    with pytest.raises(ProblemError, match="must be from 0 to 1 day, got"):
        model.prepare({"settlement": np.array([1.5])})
    with pytest.raises(ProblemError, match="must be from 0 to 1 day, got"):
        model.prepare({"branch_1.settlement": np.array([1.5])})


def test_a_soil_without_voids_is_a_failed_evaluation() -> None:
    spec = consolidation("elastic", [(9.0e3, 1.0)], initial_void_ratio=0.3)
    with pytest.raises(InfeasibleError, match=r"stage 1 \(9000 kPa\): the void ratio falls to -\d"):
        run(spec, ELASTIC | {"k": 1.0e-3}, 0.1, "settlement")
