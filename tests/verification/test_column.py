"""Layered ground against series, closed forms, an independent discretisation, and itself refined."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.column.drains import equal_strain, influence
from geoswarm.solver.column.section import ColumnSpec
from geoswarm.verification.exact.consolidation import barron, degree, isochrone, mu_by_quadrature, two_layers
from geoswarm.verification.specimens.grounds import MUD, slurry
from geoswarm.verification.specimens.laboratory import consolidation, run
from tests.solver.column.grounds import CLAY, STIFF, WATER, embankment, ground

K = 1.0e-4
"""m/day."""
HEIGHT, LOAD = 8.0, 50.0
TIME = HEIGHT**2 * WATER / (K * STIFF)
"""Of consolidation, day."""
FACTORS = np.array([0.01, 0.05, 0.2, 0.5, 1.0])
SOIL = {"a.E": STIFF, "a.nu": 0.0, "a.k": K}


def elastic(layers: Any = (("a", HEIGHT),), stages: Any = ((LOAD, 3.0 * TIME),), **changes: Any) -> ColumnSpec:
    """Linear elasticity at small strain, in soils of one letter."""
    soils = {name: {"material": "elastic"} for name, _ in layers}
    return ground(layers, soils, stages, **{"geometry": "fixed", "tolerance": 1.0e-6, "cells": 60, **changes})


def test_isochrones_are_those_of_terzaghi() -> None:
    depths = {"P1": 0.1, "P2": 0.3, "P3": 0.55, "P4": 1.0}
    spec = elastic(points={name: {"depth": part * HEIGHT} for name, part in depths.items()})
    names = [f"{name}.excess_pore_pressure" for name in depths]
    settlement, *pores = run(spec, SOIL, FACTORS * TIME, "settlement", *names)
    assert settlement == pytest.approx(LOAD * HEIGHT / STIFF * degree(FACTORS), abs=2.0e-4 * LOAD * HEIGHT / STIFF)
    for part, pore in zip(depths.values(), pores, strict=True):
        assert pore / LOAD == pytest.approx(isochrone(part, FACTORS), abs=4.0e-4)


def test_drained_at_the_base_it_is_symmetrical() -> None:
    spec = elastic(base="drained", points={"P1": {"depth": 2.0}, "P2": {"depth": 6.0}, "M": {"depth": 4.0}})
    names = ("settlement", "P1.excess_pore_pressure", "P2.excess_pore_pressure", "M.settlement")
    settlement, upper, lower, middle = run(spec, SOIL, FACTORS * TIME / 4.0, *names)
    assert settlement == pytest.approx(LOAD * HEIGHT / STIFF * degree(FACTORS), abs=5.0e-4 * LOAD * HEIGHT / STIFF)
    assert upper == pytest.approx(lower, abs=1.0e-6 * LOAD)
    assert upper / LOAD == pytest.approx(isochrone(0.5, FACTORS), abs=1.0e-3)
    assert middle == pytest.approx(0.5 * settlement, rel=1.0e-6)


def test_one_layer_is_the_consolidation_test() -> None:
    """As heavy as water, it has no effective weight."""
    stages = [(200.0, 1.0, 0.0), (150.0, 1.0, 0.2)]
    values = CLAY | {"k": 2.0e-5, "C_k": 0.5}
    x = np.array([1.0e-3, 0.1, 0.5, 1.0, 1.1, 1.3, 2.0])
    specimen = consolidation(
        "modified_cam_clay", stages, drainage="one_side", initial_void_ratio=1.0, tolerance=1.0e-6, cells=30
    )
    loads = [(stress - 100.0, *times) for stress, *times in stages]
    with pytest.raises(ValueError, match="greater than or equal to 0"):
        ground([("a", 0.02)], {"a": {"material": "elastic"}}, [(-10.0, 1.0)])
    column = ground(
        [("clay", 0.02)],
        {"clay": {"material": "modified_cam_clay", "initial_void_ratio": 1.0}},
        loads,
        points={"B": {"depth": 0.02}},
        tolerance=1.0e-6,
        cells=30,
    )
    expected = run(specimen, values, x, "settlement", "pore_pressure")
    found = run(
        column, {f"clay.{name}": value for name, value in values.items()}, x, "settlement", "B.excess_pore_pressure"
    )
    assert found[0] == pytest.approx(expected[0], abs=2.0e-6 * 0.02)
    assert found[1] == pytest.approx(expected[1], abs=0.05)


@pytest.mark.parametrize("ratio", [0.02, 0.5, 30.0])
def test_two_layers_follow_their_series(ratio: float) -> None:
    upper, lower = (3.0, K, STIFF), (5.0, ratio * K, 0.4 * STIFF)
    time = 25.0 * WATER / (ratio * K * 0.4 * STIFF) + 9.0 * WATER / (K * STIFF)
    times = FACTORS * time
    spec = elastic((("a", 3.0), ("b", 5.0)), [(LOAD, 2.0 * time)])
    soils = SOIL | {"b.E": lower[2], "b.nu": 0.0, "b.k": lower[1]}
    (settlement,) = run(spec, soils, times, "settlement")
    expected = LOAD * two_layers(times, upper, lower, WATER)
    end = LOAD * (3.0 / upper[2] + 5.0 / lower[2])
    assert settlement == pytest.approx(expected, abs=5.0e-4 * end)


@pytest.mark.parametrize(("n", "s", "ratio"), [(20.0, 1.0, 1.0), (15.0, 3.0, 4.0), (5.0, 2.0, 2.0)])
def test_mu_is_that_of_the_flow_to_a_drain(n: float, s: float, ratio: float) -> None:
    assert equal_strain(n, s, ratio) == pytest.approx(mu_by_quadrature(n, s, ratio), rel=1.0e-6)
    if s == 1.0:
        assert equal_strain(n, s, ratio) == pytest.approx(barron(n), rel=1.0e-12)


DRAINS = {"spacing": 1.5, "diameter": 0.066, "bottom": HEIGHT}


@pytest.mark.parametrize(
    ("more", "parameters"),
    [
        ({}, {}),
        ({"pattern": "square"}, {}),
        ({"smear_diameter": 0.2, "smear_ratio": 3.0}, {}),
        ({"smear_diameter": 0.2}, {"drains.smear_ratio": 2.0}),
        ({"discharge_capacity": 0.05}, {}),
        ({"discharge_capacity": 9.9}, {"drains.discharge_capacity": 0.02}),
    ],
)
def test_flow_to_drains_alone_is_that_of_barron_and_hansbo(more: dict[str, Any], parameters: dict[str, float]) -> None:
    """u = load exp(-8 c_h t/(mu d_e^2)) at each depth; water hardly flows upwards."""
    drains = {**DRAINS, **more}
    horizontal = 1.0e-3
    outer = influence(1.5, str(drains.get("pattern", "triangular")))
    n, s = outer / 0.066, float(drains.get("smear_diameter", 0.066)) / 0.066
    mu = equal_strain(n, s, parameters.get("drains.smear_ratio", float(drains.get("smear_ratio", 1.0))))
    capacity = parameters.get("drains.discharge_capacity", drains.get("discharge_capacity", math.inf))
    time = mu * outer**2 * WATER / (8.0 * horizontal * STIFF)
    spec = elastic(
        stages=[(LOAD, 3.0 * time)],
        drains=drains,
        cells=40,
        points={"P": {"depth": 4.0}, "Q": {"depth": 6.0}},
    )
    x = time * np.array([0.1, 0.5, 1.0, 2.0])
    values = SOIL | {"a.k": 1.0e-9, "a.k_ratio": horizontal / 1.0e-9} | parameters
    for z, name in ((4.0, "P"), (6.0, "Q")):
        (pore,) = run(spec, values, x, f"{name}.excess_pore_pressure")
        well = math.pi * z * (2.0 * HEIGHT - z) * (1.0 - 1.0 / n**2) * horizontal / float(capacity)
        assert pore == pytest.approx(LOAD * np.exp(-x / time * mu / (mu + well)), abs=1.0e-3 * LOAD)


def test_flow_upwards_and_to_drains_multiply_as_carrillo_found() -> None:
    outer = influence(3.0, "triangular")
    time = equal_strain(outer / 0.066, 1.0, 1.0) * outer**2 * WATER / (8.0 * 5.0 * K * STIFF)
    spec = elastic(drains={**DRAINS, "spacing": 3.0})
    (settlement,) = run(spec, SOIL | {"a.k_ratio": 5.0}, FACTORS * TIME, "settlement")
    expected = 1.0 - (1.0 - degree(FACTORS)) * np.exp(-FACTORS * TIME / time)
    assert settlement / (LOAD * HEIGHT / STIFF) == pytest.approx(expected, abs=2.0e-4)


def test_drains_in_a_part_of_the_depth_work_there() -> None:
    x = 0.1 * TIME * np.array([0.2, 1.0])
    points = {"U": {"depth": 2.0}, "L": {"depth": 7.5}}
    names = ("settlement", "U.excess_pore_pressure", "L.excess_pore_pressure")
    found = {
        bottom: run(elastic(drains={**DRAINS, "bottom": bottom}, points=points), SOIL, x, *names)
        for bottom in (4.0, 8.0)
    }
    none = run(elastic(points=points), SOIL, x, *names)
    assert (found[8.0][0] > found[4.0][0]).all()
    assert (found[4.0][0] > none[0]).all()
    assert (found[8.0][1] < found[4.0][1]).all()
    assert (found[4.0][1] < 0.3 * none[1]).all()
    assert found[4.0][2][0] == pytest.approx(none[2][0], rel=1.0e-2)
    assert (found[8.0][2] < 0.9 * found[4.0][2]).all()


def test_drains_lose_permeability_with_the_voids() -> None:
    """In thin ground without vertical flow, soft soil follows one ordinary differential equation.

    What flows to the surface has no place in it: with k_v = 1e-9 m/day that was 4.7e-4 of the settlement, nearly all of
    what was left. 1e-12 m/day leave 7e-6, the errors of the steps.
    """
    mu = equal_strain(influence(1.5, "triangular") / 0.066, 1.0, 1.0)
    outer = influence(1.5, "triangular")
    spec = ground(
        [("clay", 1.0)],
        {"clay": {"material": "soft_soil", "initial_void_ratio": 1.0}},
        [(100.0, 400.0)],
        drains={**DRAINS, "bottom": 1.0},
        tolerance=1.0e-6,
        cells=8,
    )
    law = {"lambda_star": 0.1, "kappa_star": 0.02, "c": 1.0e-6, "phi": 25.0}
    values = {f"clay.{name}": value for name, value in law.items()}
    x = np.array([5.0, 20.0, 60.0, 200.0])
    (settlement,) = run(spec, values | {"clay.k": 1.0e-12, "clay.k_ratio": 1.0e8, "clay.C_k": 0.4}, x, "settlement")
    rate = 8.0 * 1.0e-4 / (WATER * outer**2 * mu)

    def flow(_: float, strain: FloatArray) -> FloatArray:
        stress = 100.0 * np.exp(strain / 0.1)
        lost = -np.expm1(-strain)
        rated: FloatArray = rate * 10.0 ** (-2.0 * lost / 0.4) * (200.0 - stress)
        return rated

    exact = solve_ivp(flow, (0.0, 200.0), [0.0], t_eval=x, rtol=1e-10, atol=1e-13, method="LSODA")
    assert settlement == pytest.approx(-np.expm1(-exact.y[0]), rel=2.0e-5)


def test_mud_begins_with_its_weight_in_the_water() -> None:
    """How it goes on and ends is in the verification manual."""
    found = run(
        slurry(2.0e5, {"P2": {"depth": 2.5}}),
        MUD,
        [0.0],
        "P2.excess_pore_pressure",
        "P2.effective_stress",
        "P2.pore_pressure",
    )
    assert [value[0] for value in found] == pytest.approx([3.19 * 2.5, 1.0, 13.0 * 2.5], rel=1.0e-6)


def test_fill_that_sinks_below_the_water_weighs_less() -> None:
    """s = (q - gamma_w s) H/E at the end, and the same series for the part of the load that is left."""
    spec = elastic(buoyancy=WATER, stages=[(LOAD, 20.0 * TIME)], points={"B": {"depth": HEIGHT}})
    soft = SOIL | {"a.E": 400.0, "a.k": K * STIFF / 400.0}
    end = [20.0 * TIME]
    settlement, stress = run(spec, soft, end, "settlement", "B.effective_stress")
    expected = LOAD * HEIGHT / (400.0 + WATER * HEIGHT)
    assert settlement == pytest.approx([expected], rel=1.0e-5)
    assert stress == pytest.approx([100.0 + LOAD - WATER * expected], rel=1.0e-5)


def test_buoyancy_begins_at_the_water_table() -> None:
    spec = elastic((("a", 3.0), ("b", 5.0)), [(LOAD, 40.0 * TIME)], buoyancy=WATER, water_table=3.0)
    soils = SOIL | {"b.E": 400.0, "b.nu": 0.0, "b.k": K}
    (settlement,) = run(spec, soils, [40.0 * TIME], "settlement")
    left = LOAD / (1.0 + WATER * 5.0 / 400.0)
    assert settlement == pytest.approx([left * (3.0 / STIFF + 5.0 / 400.0)], rel=1.0e-4)


def test_errors_fall_with_the_square_of_the_cells() -> None:
    x = np.array([5.0, 30.0, 60.0, 100.0, 360.0, 362.0, 1000.0, 3000.0])
    values = {f"clay.{name}": value for name, value in CLAY.items()} | {
        "clay.e0": 1.6,
        "clay.k": 5.0e-5,
        "clay.C_k": 0.8,
    }
    values |= {"crust.E": 5.0e3, "crust.nu": 0.3, "crust.k": 1.0e-4}
    names = ("settlement", "S1.settlement", "P1.excess_pore_pressure")

    def found(cells: int) -> FloatArray:
        layers = [
            {"soil": "crust", "thickness": 1.5, "cells": cells // 4},
            {"soil": "clay", "thickness": 8.5, "cells": cells},
        ]
        one = run(embankment("modified_cam_clay", layers=layers, tolerance=1.0e-7), values, x, *names)
        return np.concatenate([one[0], one[1], 0.01 * one[2]])

    coarse, middle, fine = (found(cells) for cells in (16, 32, 64))
    rate = np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine)
    assert 3.0 < rate < 5.5
    assert np.abs(middle - fine).max() < 1.0e-3


def test_the_error_in_time_is_of_the_size_of_the_tolerance() -> None:
    x = np.array([1.0, 5.0, 30.0, 60.0, 100.0, 360.0, 360.1, 362.0, 1000.0, 3000.0])
    law = {"lambda_star": 0.08, "kappa_star": 0.015, "mu_star": 0.003, "c": 2.0, "phi": 25.0, "OCR": 1.3}
    values = {f"clay.{name}": value for name, value in law.items()} | {"clay.k": 5.0e-5, "clay.C_k": 0.8}
    values |= {"crust.E": 5.0e3, "crust.nu": 0.3, "crust.k": 1.0e-4}

    def found(tolerance: float) -> tuple[FloatArray, ...]:
        spec = embankment("soft_soil_creep", cells=20, tolerance=tolerance)
        return run(spec, values, x, "settlement", "P1.excess_pore_pressure")

    settlement, pore = found(1.0e-7)
    for tolerance in (1.0e-3, 1.0e-4, 1.0e-5):
        one = found(tolerance)
        assert np.abs(one[0] - settlement).max() < tolerance * 10.0
        assert np.abs(one[1] - pore).max() < 3.0e3 * tolerance
