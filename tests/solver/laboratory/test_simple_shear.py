"""The direct simple shear test: elasticity, kinds of stages, series, what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from geoswarm.solver.element_test.material_point import follow, point_under
from geoswarm.solver.element_test.setups import simple_shear as general_simple_shear
from geoswarm.solver.errors import DivergedError
from geoswarm.solver.laws.registry import BUILT_IN, find_law
from geoswarm.verification.specimens.laboratory import CREEP, ELASTIC, MOHR_COULOMB, run, simple_shear
from tests.solver.laws.checks import usual_values, void_ratio_for

YOUNG, POISSON = ELASTIC["E"], ELASTIC["nu"]
SHEAR = YOUNG / (2.0 * (1.0 + POISSON))
REST = POISSON / (1.0 - POISSON)


@pytest.mark.parametrize("constant", ["volume", "normal_stress"])
def test_elasticity_shears_without_volume_or_pore_pressure(constant: str) -> None:
    spec = simple_shear("elastic", [{"shear_strain": 0.1}], constant=constant, initial_void_ratio=0.8)
    x = np.array([0.0, 0.001, 0.05, 0.1])
    names = ("shear_stress", "normal_stress", "horizontal_stress", "vertical_strain", "void_ratio", "q", "rotation")
    tau, normal, horizontal, vertical, e, q, rotation = run(spec, ELASTIC, x, *names)
    assert tau == pytest.approx(SHEAR * x, rel=1.0e-9, abs=1.0e-9)
    assert normal == pytest.approx(np.full(4, 100.0), rel=1.0e-10)
    assert horizontal == pytest.approx(np.full(4, 100.0 * REST), rel=1.0e-10)
    assert vertical == pytest.approx(np.zeros(4), abs=1.0e-12)
    assert e == pytest.approx(np.full(4, 0.8), rel=1.0e-12)
    assert q == pytest.approx(np.hypot(100.0 * (1.0 - REST), math.sqrt(3.0) * tau), rel=1.0e-9)
    assert np.tan(np.radians(2.0 * rotation)) == pytest.approx(2.0 * tau / (100.0 * (1.0 - REST)), rel=1.0e-9)
    (modulus,) = run(spec, ELASTIC, [1.0e-5, 0.1], "secant_modulus")
    assert modulus == pytest.approx([SHEAR, SHEAR], rel=1.0e-7)


def test_consolidation_has_no_horizontal_strain_and_shearing_goes_on_from_it() -> None:
    stages = [{"normal_stress": 200.0}, {"normal_stress": 150.0, "duration": 2.0, "loading_time": 1.0}]
    spec = simple_shear("elastic", [{"shear_strain": -0.02}], consolidation=stages, initial_ratio=0.9)
    names = ("consolidation_vertical_strain", "consolidation_K0", "consolidation_p")
    strain, K0, p = run(spec, ELASTIC, [1.0, 2.0], *names)
    confined = YOUNG * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
    assert strain == pytest.approx(-np.expm1([-100.0 / confined, -50.0 / confined]), rel=1.0e-9)
    sides = 90.0 + REST * np.array([100.0, 50.0])
    assert pytest.approx(sides / [200.0, 150.0], rel=1.0e-9) == K0
    assert p == pytest.approx((np.array([200.0, 150.0]) + 2.0 * sides) / 3.0, rel=1.0e-9)
    tau, vertical = run(spec, ELASTIC, -0.02, "shear_stress", "vertical_strain")
    assert tau == pytest.approx([-0.02 * SHEAR], rel=1.0e-9)
    assert vertical == pytest.approx([0.0], abs=1.0e-12)


def test_stress_led_stages_and_cycles_end_at_their_stress() -> None:
    stages: list[dict[str, Any]] = [
        {"shear_stress": 20.0, "constant": "normal_stress", "duration": 2.0},
        {"kind": "cyclic", "shear_stress_amplitude": 10.0, "cycles": 3, "period": 1.0},
    ]
    spec = simple_shear("elastic", stages)
    ends, strain = run(spec, ELASTIC, [1.0, 2.0], "stage_shear_stress", "stage_shear_strain")
    assert ends == pytest.approx([20.0, 20.0], rel=1.0e-9)
    assert strain == pytest.approx([20.0 / SHEAR] * 2, rel=1.0e-9)
    most, least = run(spec, ELASTIC, [1.0, 2.0, 3.0], "cycle_max_shear_stress", "cycle_min_shear_stress")
    assert most == pytest.approx([30.0] * 3, rel=1.0e-9)
    assert least == pytest.approx([10.0] * 3, rel=1.0e-9)
    over_time = run(spec, ELASTIC, [1.0, 2.25, 2.75, 5.0], "time_shear_stress")[0]
    assert over_time == pytest.approx([10.0, 30.0, 10.0, 20.0], rel=1.0e-9)


@pytest.mark.usefixtures("other_laws")
def test_creep_and_relaxation_in_shear_are_those_of_the_standard_solid() -> None:
    """Strain tau/G (1 + r (1 - exp(-t/T))) under constant stress; tau(t) towards tau_0/(1 + r) at constant strain."""
    soil = {"E": 5.0e3, "nu": 0.25, "ratio": 1.5, "T": 2.0}
    G = 2.0e3
    load: dict[str, Any] = {"shear_stress": 30.0, "duration": 1.0e-6}
    t = np.array([0.1, 1.0, 4.0])
    creep = simple_shear("standard_solid", [load, {"kind": "hold", "duration": 5.0}], tolerance=1.0e-7)
    (strain,) = run(creep, soil, 1.0e-6 + t, "time_shear_strain")
    assert strain == pytest.approx(30.0 / G * (1.0 + 1.5 * (1.0 - np.exp(-t / 2.0))), rel=1.0e-5)
    relaxed = simple_shear(
        "standard_solid", [load, {"kind": "hold", "keep": "strain", "duration": 5.0}], tolerance=1.0e-7
    )
    (tau,) = run(relaxed, soil, 1.0e-6 + t, "time_shear_stress")
    assert tau == pytest.approx(30.0 * (1.0 + 1.5 * np.exp(-t * 2.5 / 2.0)) / 2.5, rel=1.0e-5)


@pytest.mark.usefixtures("other_laws")
def test_a_law_of_six_components_gives_what_four_give() -> None:
    soil = {"E": 5.0e3, "nu": 0.25, "ratio": 1.5, "T": 2.0}
    stages: list[dict[str, Any]] = [{"shear_strain": 0.02, "duration": 0.3}, {"kind": "hold", "duration": 2.0}]
    names = ("time_shear_stress", "time_shear_strain", "time_normal_stress", "time_horizontal_stress")
    x = [0.1, 0.3, 0.4, 2.3]
    four = run(simple_shear("standard_solid", stages, initial_ratio=0.5), soil, x, *names)
    six = run(simple_shear("no_plane", stages, initial_ratio=0.5), soil, x, *names)
    for one, other in zip(four, six, strict=True):
        assert one == pytest.approx(other, rel=1.0e-9, abs=1.0e-12)


@pytest.mark.parametrize("kind", BUILT_IN)
def test_four_components_give_what_the_general_driver_gives_in_six(kind: str) -> None:
    law = find_law(kind)
    soil = law.soil(usual_values(law))
    K0 = law.K0(soil.constants)
    assert K0 is not None
    x = np.array([1.0e-3, 5.0e-3, 0.02])
    start = point_under([100.0 * K0, 100.0 * K0, 100.0, 0.0, 0.0, 0.0], soil)
    history = follow(soil, start, [general_simple_shear(0.02, 100.0, 0.04)], [x / 0.5], tolerance=1.0e-7)
    spec = simple_shear(kind, [{"shear_strain": 0.02, "rate": 0.5}], constant="normal_stress", tolerance=1.0e-7)
    tau, vertical = run(spec, usual_values(law), x, "shear_stress", "vertical_strain")
    assert tau == pytest.approx(history.stress[:, 5], rel=1.0e-4)
    assert vertical == pytest.approx(-np.expm1(-history.strain[:, 2]), abs=1.0e-6)


@pytest.mark.parametrize("kind", BUILT_IN)
@pytest.mark.parametrize("constant", ["volume", "normal_stress"])
def test_every_law_goes_through_every_kind_of_stage(kind: str, constant: str) -> None:
    stages: list[dict[str, Any]] = [
        {"shear_strain": 0.02, "rate": 0.5},
        {"shear_stress": 5.0, "duration": 0.1},
        {"kind": "cyclic", "shear_strain_amplitude": 1.0e-3, "cycles": 2, "period": 0.01},
        {"kind": "hold", "keep": "strain", "duration": 1.0},
        {"kind": "hold", "duration": 1.0},
        {"shear_strain": -0.02, "rate": 0.5},
    ]
    consolidation = [{"normal_stress": 120.0, "duration": 0.5, "loading_time": 0.2}, {"normal_stress": 150.0}]
    spec = simple_shear(kind, stages, constant=constant, consolidation=consolidation, **void_ratio_for(kind, 1.0))
    model = spec.build()
    numbers = {"stage_": np.arange(1.0, 7.0), "consolidation_": np.array([1.0, 2.0]), "cycle_": np.array([1.0, 2.0])}
    points = {
        info.name: next((x for start, x in numbers.items() if info.name.startswith(start)), np.array([0.0, -0.01]))
        for info in model.series
        if not info.name.startswith(("time_", "branch_", "path_"))
    }
    found = model.prepare(points)(usual_values(find_law(kind)))
    assert all(np.isfinite(values[1:]).all() for values in found.values())
    assert found["stage_shear_strain"][[0, 5]] == pytest.approx([0.02, -0.02], abs=1.0e-10)
    assert found["stage_shear_stress"][[1, 4]] == pytest.approx([5.0, found["stage_shear_stress"][3]], rel=1.0e-8)
    if constant == "volume":
        assert found["stage_vertical_strain"] == pytest.approx(np.zeros(6), abs=1.0e-10)
        assert found["stage_normal_stress"] + found["stage_pore_pressure"] == pytest.approx(np.full(6, 150.0), rel=1e-9)
    else:
        assert found["stage_normal_stress"] == pytest.approx(np.full(6, 150.0), rel=1.0e-9)
        assert "pore_pressure" not in found


def test_what_a_path_never_reaches_counts_as_its_closest_approach() -> None:
    spec = simple_shear("soft_soil_creep", [{"shear_strain": 0.2, "rate": 0.2}])
    tau, normal = run(spec, CREEP, [0.02, 0.2], "shear_stress", "normal_stress")
    (path,) = run(spec, CREEP, normal[0], "path_shear_stress")
    assert path[0] == pytest.approx(tau[0], rel=1.0e-3)
    (beyond,) = run(spec, CREEP, 500.0, "path_shear_stress")
    assert beyond == pytest.approx([0.0], abs=1.0e-9)


@pytest.mark.parametrize(
    ("material", "shearing", "changes", "message"),
    [
        ("elastic", [{}], {}, "give exactly one of shear_strain, shear_stress; none is given"),
        ("elastic", [{"shear_strain": 1.5}], {}, "less than or equal to 0.9"),
        ("elastic", [{"shear_strain": 0.1}], {"constant": "height"}, "volume"),
        ("elastic", [{"shear_strain": 0.1}], {"initial_ratio": 0.0}, "initial_ratio must be above 0 and at most 100"),
        (
            "no_plane",
            [{"shear_strain": 0.1}],
            {},
            "initial_ratio must be a number, got K0: material no_plane has no K0",
        ),
        ("soft_soil_creep", [{"shear_strain": 0.1}], {}, r"shearing\[0\]: rate or duration is missing"),
        ("elastic", [{"kind": "cyclic", "cycles": 2}], {}, "exactly one of shear_strain_amplitude"),
        (
            "elastic",
            [{"shear_strain": 0.1}],
            {"consolidation": [{"normal_stress": 50.0, "loading_time": 3.0}]},
            "loading_time must be at most the duration, 1 day, got 3 day",
        ),
    ],
)
@pytest.mark.usefixtures("other_laws")
def test_sections_that_cannot_be_are_refused(
    material: str, shearing: list[dict[str, Any]], changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValidationError, match=message):
        simple_shear(material, shearing, **changes)


def test_a_shear_stress_above_the_strength_is_a_failed_evaluation() -> None:
    spec = simple_shear("mohr_coulomb", [{"shear_stress": 300.0}], constant="normal_stress")
    with pytest.raises(DivergedError, match="stage shearing 1: no solution"):
        run(spec, MOHR_COULOMB, 1.0, "stage_shear_stress")
