"""Consolidation in stages of the oedometer against Terzaghi's series, drained stages, and itself refined."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.forward.oedometer import OedometerSpec
from geoswarm.solver.laws.registry import BUILT_IN, find_law
from geoswarm.verification.exact.consolidation import degree, isochrone, ramped_degree
from geoswarm.verification.specimens.laboratory import consolidation, run
from tests.solver.laws.checks import usual_values

WATER = 9.81
STIFF, K, HEIGHT = 2.0e3, 2.0e-5, 0.02
"""kPa, m/day, m."""
SOIL = {"E": STIFF, "nu": 0.0, "k": K}
CV = K * STIFF / WATER
FACTORS = np.array([0.001, 0.01, 0.05, 0.2, 0.5, 1.0, 2.0])
CLAY = {"M": 1.0, "lambda": 0.2, "kappa": 0.04, "nu": 0.25, "e0": 1.0}


@pytest.mark.parametrize(("drainage", "way"), [("one_side", HEIGHT), ("two_sides", 0.5 * HEIGHT)])
def test_a_load_at_once_follows_terzaghi(drainage: str, way: float) -> None:
    time = way**2 / CV
    spec = consolidation(
        "elastic", [(200.0, 3.0 * time)], geometry="fixed", drainage=drainage, cells=60, tolerance=1.0e-6
    )
    names = ("settlement", "axial_strain", "pore_pressure", "mean_effective_stress")
    settlement, strain, pore, mean = run(spec, SOIL, FACTORS * time, *names)
    end = HEIGHT * 100.0 / STIFF
    assert settlement / end == pytest.approx(degree(FACTORS), abs=2.0e-4)
    assert strain == pytest.approx(settlement / HEIGHT, rel=1.0e-12)
    assert pore / 100.0 == pytest.approx(isochrone(1.0, FACTORS), abs=2.0e-4)
    assert mean == pytest.approx(100.0 + 100.0 * settlement / end, rel=1.0e-6)


def test_a_load_that_grows_follows_olson_and_an_unloading_mirrors_it() -> None:
    time = HEIGHT**2 / CV
    stages = [(200.0, 20.0 * time, 0.2 * time), (100.0, 3.0 * time, 0.2 * time)]
    spec = consolidation("elastic", stages, geometry="fixed", drainage="one_side", cells=60, tolerance=1.0e-6)
    names = ("branch_1.settlement", "branch_2.settlement", "branch_1.pore_pressure", "branch_2.pore_pressure")
    up, down, pressed, sucked = run(spec, SOIL, FACTORS * time, *names)
    end = HEIGHT * 100.0 / STIFF
    assert up / end == pytest.approx(ramped_degree(FACTORS, 0.2), abs=2.0e-4)
    assert down == pytest.approx(-up, abs=1.0e-5 * end)
    assert sucked == pytest.approx(-pressed, abs=1.0e-2)


def test_errors_fall_with_the_square_of_the_cells() -> None:
    x = np.array([0.01, 0.1, 0.4, 1.0, 1.02, 1.2, 2.0])
    names = ("settlement", "pore_pressure", "void_ratio")

    def clay(cells: int) -> FloatArray:
        stages = [(200.0, 1.0), (150.0, 1.0)]
        spec = consolidation(
            "modified_cam_clay", stages, initial_void_ratio=1.0, drainage="one_side", cells=cells, tolerance=1.0e-7
        )
        found = run(spec, CLAY | {"k": 2.0e-5, "C_k": 0.5}, x, *names)
        return np.concatenate([found[0] / 1.0e-3, found[1] / 100.0, found[2]])

    coarse, middle, fine = (clay(cells) for cells in (15, 30, 60))
    rate = np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine)
    assert 3.0 < rate < 5.0
    assert np.abs(middle - fine).max() < 5.0e-3


def test_the_error_in_time_is_of_the_size_of_the_tolerance() -> None:
    x = np.array([1.0e-4, 0.01, 0.1, 0.4, 1.0, 1.02, 1.2, 2.0])

    def clay(tolerance: float) -> tuple[FloatArray, ...]:
        spec = consolidation(
            "modified_cam_clay", [(200.0, 1.0), (150.0, 1.0)], initial_void_ratio=1.0, cells=15, tolerance=tolerance
        )
        return run(spec, CLAY | {"k": 2.0e-6, "C_k": 0.5}, x, "axial_strain", "pore_pressure")

    strain, pore = clay(1.0e-8)
    bulk = 2.0 * 300.0 / 0.04
    for tolerance in (1.0e-4, 1.0e-5, 1.0e-6):
        found = clay(tolerance)
        assert np.abs(found[0] - strain).max() < tolerance
        assert np.abs(found[1] - pore).max() < 2.0 * tolerance * bulk


@pytest.mark.parametrize("kind", BUILT_IN)
def test_fast_drainage_gives_the_drained_oedometer(kind: str) -> None:
    values = usual_values(find_law(kind))
    loads = [(150.0, 1.0), (120.0, 0.5), (250.0, 2.0)]
    stages: list[dict[str, Any]] = [{"stress": stress, "duration": time} for stress, time in loads]
    drained = OedometerSpec.model_validate(
        {"material": kind, "height": 0.02, "initial_stress": 100.0, "stages": stages, "tolerance": 1.0e-7}
    )
    x = np.array([1.0, 2.0, 3.0])
    expected = run(drained, values, x, "stage_settlement", "stage_K0")
    spec = consolidation(kind, loads, cells=4, tolerance=1.0e-6)
    settlement, at_rest, pore = run(spec, values | {"k": 1.0}, x, "stage_settlement", "stage_K0", "stage_pore_pressure")
    assert settlement == pytest.approx(expected[0], rel=2.0e-3, abs=2.0e-8)
    assert at_rest == pytest.approx(expected[1], rel=2.0e-3)
    assert pore == pytest.approx(np.zeros(3), abs=1.0e-3)


def test_c_v_is_that_of_the_slope_of_compression() -> None:
    """A small load on Cam clay, normally consolidated: c_v = k/(gamma_w m_v), m_v from its end."""
    spec = consolidation("modified_cam_clay", [(101.0, 1.0)], drainage="one_side", cells=40, tolerance=1.0e-8)
    (end,) = run(spec, CLAY | {"k": 1.0}, 1.0, "settlement")
    m_v = float(end[0]) / HEIGHT / 1.0
    time = HEIGHT**2 * WATER * m_v / 1.0e-5
    spec = consolidation("modified_cam_clay", [(101.0, 3.0 * time)], drainage="one_side", cells=40, tolerance=1.0e-8)
    (settlement,) = run(spec, CLAY | {"k": 1.0e-5}, FACTORS * time, "settlement")
    assert settlement / end == pytest.approx(degree(FACTORS), abs=4.0e-3)
