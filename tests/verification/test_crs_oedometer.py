"""The oedometer at constant rate of strain against closed forms of consolidation, and against itself refined."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.material_point import follow, point_under
from geoswarm.solver.element_test.setups import constant_rate_oedometer
from geoswarm.solver.laws.registry import BUILT_IN, find_law
from geoswarm.verification.exact.consolidation import crs_strain
from geoswarm.verification.specimens.laboratory import crs_oedometer, run
from tests.solver.laws.checks import usual_values

WATER = 9.81
STIFF, K, HEIGHT, RATE = 2.0e3, 2.0e-5, 0.02, 0.25
"""kPa, m/day, m, 1/day."""
SOIL = {"E": STIFF, "nu": 0.0, "k": K}
CV = K * STIFF / WATER
TIME = HEIGHT**2 / CV
"""Of consolidation, day."""
CLAY = {"M": 1.0, "lambda": 0.2, "kappa": 0.04, "nu": 0.25, "e0": 1.0}


def linear(stages: list[dict[str, Any]], **changes: Any) -> Any:
    """Linear elasticity at small strain."""
    return crs_oedometer("elastic", stages, geometry="fixed", **changes)


def test_the_transient_state_is_that_of_wissa_and_others() -> None:
    times = TIME * np.array([0.02, 0.1, 0.3, 1.0, 3.0])
    spec = linear([{"axial_strain": 3.0 * TIME * RATE, "rate": RATE}], intervals=160, tolerance=1.0e-7)
    names = ("time_axial_stress", "time_pore_pressure", "time_mean_effective_stress", "time_axial_strain")
    stress, pore, mean, strain = run(spec, SOIL, times, *names)
    size = STIFF * RATE * TIME
    top = np.array([crs_strain(1.0, t) for t in times / TIME])
    base = np.array([crs_strain(0.0, t) for t in times / TIME])
    assert strain == pytest.approx(RATE * times, rel=1.0e-9)
    assert mean == pytest.approx(100.0 + STIFF * RATE * times, rel=1.0e-7)
    assert stress == pytest.approx(100.0 + STIFF * RATE * times + size * top, abs=5.0e-4 * size)
    assert pore == pytest.approx(size * (top - base), abs=5.0e-4 * size)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_steady_state_is_a_parabola_whatever_the_intervals(way: float) -> None:
    """u_b = gamma_w r H^2/(2 k), and the mean effective stress is less by two thirds of it (Wissa et al. 1971).

    The mean of a parabola by trapezia is too small by 1/(6 N^2) of it.
    """
    for intervals in (4, 20):
        end = way * 4.0 * TIME * RATE
        spec = linear([{"axial_strain": end, "rate": RATE}], intervals=intervals, tolerance=1.0e-7, back_pressure=50)
        names = ("pore_pressure", "axial_stress", "effective_stress", "mean_effective_stress")
        pore, stress, evaluated, mean = run(spec, SOIL, end, *names)
        excess = way * WATER * RATE * HEIGHT**2 / (2.0 * K)
        assert pore == pytest.approx([50.0 + excess], rel=1.0e-5)
        trapezia = excess / (6.0 * intervals**2)
        assert stress == pytest.approx([100.0 + STIFF * end + excess * 2.0 / 3.0 - trapezia], rel=1.0e-5)
        assert evaluated == pytest.approx(mean - trapezia, rel=1.0e-5)
        assert mean == pytest.approx([100.0 + STIFF * end], rel=1.0e-7)


@pytest.mark.parametrize(("keep", "mode"), [("stress", 0.25), ("strain", 1.0)])
def test_pore_pressures_dissipate_as_their_slowest_mode(keep: str, mode: float) -> None:
    """exp(-pi^2 T/4) under a constant stress, exp(-pi^2 T) at a constant height: then no water leaves (Terzaghi)."""
    load = {"axial_strain": 0.02, "rate": RATE}
    first = 0.02 / RATE
    spec = linear([load, {"kind": "hold", "keep": keep, "duration": 4.0 * TIME}], intervals=160, tolerance=1.0e-8)
    spread = np.array([0.5, 1.0]) if keep == "strain" else np.array([1.0, 2.0])
    (pore,) = run(spec, SOIL, first + TIME * spread, "time_pore_pressure")
    assert pore[1] / pore[0] == pytest.approx(math.exp(-(math.pi**2) * mode * (spread[1] - spread[0])), rel=1.0e-3)
    strain, stress = run(spec, SOIL, [1.0, 2.0], "stage_axial_strain", "stage_axial_stress")
    if keep == "strain":
        assert strain[1] == pytest.approx(0.02, rel=1.0e-9)
        assert stress[1] == pytest.approx(100.0 + STIFF * 0.02, rel=1.0e-6)
    else:
        assert stress[1] == pytest.approx(stress[0], rel=1.0e-9)
        settled = (stress[1] - 100.0) / STIFF
        assert strain[1] == pytest.approx(settled, rel=1.0e-4)


@pytest.mark.parametrize("kind", BUILT_IN)
def test_fast_drainage_gives_the_law_at_a_point(kind: str) -> None:
    law = find_law(kind)
    values = usual_values(law)
    soil = law.soil(values)
    K0 = law.K0(soil.constants)
    assert K0 is not None
    x = np.array([0.005, 0.02, 0.04])
    stages = [{"axial_strain": 0.04, "rate": 0.2}]
    spec = crs_oedometer(kind, stages, geometry="fixed", tolerance=1.0e-7, intervals=4)
    stress, K0_mean, pore = run(spec, values | {"k": 1.0e4}, x, "axial_stress", "K0", "pore_pressure")
    start = point_under([100.0 * K0, 100.0 * K0, 100.0, 0.0, 0.0, 0.0], soil)
    history = follow(soil, start, [constant_rate_oedometer(0.04, 0.2)], [x / 0.2], tolerance=1.0e-7)
    error = 1.0e-7 * law.elastic_moduli(soil.constants, 100.0)[0]  # that both calculations admit
    assert stress == pytest.approx(history.stress[:, 2], rel=1.0e-5, abs=error)
    assert K0_mean == pytest.approx(history.stress[:, 0] / history.stress[:, 2], rel=1.0e-5)
    assert pore == pytest.approx(np.zeros(3), abs=1.0e-4)


def clay_test(**changes: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Modified Cam clay loaded, unloaded and held, at large strain with a permeability that falls."""
    stages: list[dict[str, Any]] = [
        {"axial_strain": 0.15, "rate": 0.5},
        {"axial_strain": 0.14, "rate": 0.2},
        {"kind": "hold", "duration": 1.0},
    ]
    spec = crs_oedometer("modified_cam_clay", stages, initial_void_ratio=1.0, **changes)
    names = ("time_axial_stress", "time_pore_pressure", "time_axial_strain")
    stress, pore, strain = run(spec, CLAY | {"k": 1.0e-5, "C_k": 0.5}, [0.05, 0.1, 0.3, 0.32, 0.35, 0.36, 1.35], *names)
    return stress, pore, strain


def test_errors_fall_with_the_square_of_the_intervals() -> None:
    coarse, middle, fine = (clay_test(intervals=count, tolerance=1.0e-7) for count in (15, 30, 60))
    for one, two, four in zip(coarse[:2], middle[:2], fine[:2], strict=True):
        rate = np.linalg.norm(one - two) / np.linalg.norm(two - four)
        assert 3.0 < rate < 5.5
        assert np.linalg.norm(two - four) < 1.0e-3 * np.linalg.norm(four)


def test_the_error_in_time_is_of_the_size_of_the_tolerance() -> None:
    best = clay_test(intervals=15, tolerance=1.0e-8)
    bulk = 2.0 * 500.0 / 0.04
    for tolerance in (1.0e-4, 1.0e-5, 1.0e-6):
        stress, pore, strain = clay_test(intervals=15, tolerance=tolerance)
        assert np.abs(stress - best[0]).max() < 2.0 * tolerance * bulk
        assert np.abs(pore - best[1]).max() < 2.0 * tolerance * bulk
        assert np.abs(strain - best[2]).max() < tolerance


def test_slow_steady_compression_of_clay_has_the_pore_pressure_of_its_permeability() -> None:
    """With small excess pressures k is uniform: u_b = gamma_w v h/(2 k), v the speed of the top and h the height."""
    spec = crs_oedometer(
        "modified_cam_clay", [{"axial_strain": 0.3, "rate": 0.01}], initial_void_ratio=1.0, tolerance=1.0e-7
    )
    x = np.array([0.1, 0.2, 0.3])
    pore, e = run(spec, CLAY | {"k": 1.0e-4, "C_k": 0.5}, x, "pore_pressure", "void_ratio")
    permeability = 1.0e-4 * 10.0 ** ((e - 1.0) / 0.5)
    assert e == pytest.approx(1.0 - 2.0 * x, rel=1.0e-9)
    assert pore == pytest.approx(WATER * 0.01 * HEIGHT**2 * (1.0 - x) / (2.0 * permeability), rel=0.02)
