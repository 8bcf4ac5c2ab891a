"""How values of a series are matched: loops, cycles, paths that turn, times at a change of stages, state variables."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.verification.specimens.laboratory import CREEP, ELASTIC, MOHR_COULOMB, run, triaxial

YOUNG = ELASTIC["E"]
LOOP = [{"axial_strain": 0.012}, {"deviator_stress": 40.0}, {"axial_strain": 0.03}]
FAILURE = (2.0 * 5.0 * 0.75**0.5 + 100.0) / 0.5


def test_over_strain_the_first_time_counts_and_loops_have_series_of_their_own() -> None:
    spec = triaxial("mohr_coulomb", LOOP)
    (q,) = run(spec, MOHR_COULOMB, [0.005, 0.0119, 0.02], "q")
    assert q == pytest.approx([0.005 * YOUNG, FAILURE, FAILURE], rel=1.0e-8)
    turn = 0.012 - (FAILURE - 40.0) / YOUNG
    x = turn + np.array([1.0e-3, 2.0e-3])
    (down,) = run(spec, MOHR_COULOMB, x, "branch_2.q")
    (up,) = run(spec, MOHR_COULOMB, x, "branch_3.q")
    assert down == pytest.approx(40.0 + YOUNG * (x - turn), rel=1.0e-7)
    assert up == pytest.approx(down, rel=1.0e-7)
    (below,) = run(spec, MOHR_COULOMB, turn - 1.0e-3, "branch_2.q")  # never reached: the closest approach
    assert below == pytest.approx([40.0], rel=1.0e-9)


def test_one_stage_needs_no_series_of_stages() -> None:
    names = {info.name for info in triaxial("elastic", [{"axial_strain": 0.01}]).build().series}
    assert not any(name.startswith(("branch_", "cycle_", "consolidation_")) for name in names)
    assert {"q", "time_q", "stage_q", "path_q", "secant_modulus"} <= names
    assert not names & {"axial_strain", "pore_pressure", "void_ratio"}


def test_a_change_of_stages_belongs_to_the_earlier_one() -> None:
    stages = [{"axial_strain": 0.01, "duration": 2.0}, {"axial_strain": 0.0, "duration": 1.0}]
    (strain,) = run(triaxial("elastic", stages), ELASTIC, [0.0, 1.0, 2.0, 2.5, 3.0], "time_axial_strain")
    assert strain == pytest.approx([0.0, 0.005, 0.01, 0.005, 0.0], abs=1.0e-12)


@pytest.mark.parametrize(("way", "low", "high"), [("two_way", -1.0, 1.0), ("one_way", 0.0, 2.0)])
def test_cycles_of_stress_on_elasticity(way: str, low: float, high: float) -> None:
    cyclic = {"kind": "cyclic", "deviator_stress_amplitude": 30.0, "cycles": 3, "period": 0.5, "way": way}
    spec = triaxial("elastic", [{"deviator_stress": 10.0}, cyclic])
    names = ("cycle_axial_strain", "cycle_max_axial_strain", "cycle_min_axial_strain", "cycle_max_q", "cycle_min_q")
    end, largest, smallest, highest, lowest = run(spec, ELASTIC, [1.0, 2.0, 3.0], *names)
    assert end == pytest.approx(np.full(3, 10.0 / YOUNG), rel=1.0e-8)
    assert largest == pytest.approx(np.full(3, (10.0 + high * 30.0) / YOUNG), rel=1.0e-8)
    assert smallest == pytest.approx(np.full(3, (10.0 + low * 30.0) / YOUNG), rel=1.0e-8)
    assert highest == pytest.approx(np.full(3, 10.0 + high * 30.0), rel=1.0e-9)
    assert lowest == pytest.approx(np.full(3, 10.0 + low * 30.0), rel=1.0e-9)
    quarter = 1.0 + 0.5 * (0.25 if way == "two_way" else 0.5)
    (q,) = run(spec, ELASTIC, [quarter, 1.5, 2.5], "time_q")
    assert q == pytest.approx([10.0 + high * 30.0, 10.0, 10.0], rel=1.0e-9)


def test_cycles_of_strain_turn_at_their_amplitude() -> None:
    cyclic = {"kind": "cyclic", "axial_strain_amplitude": 0.002, "cycles": 2}
    spec = triaxial("elastic", [cyclic], drainage="undrained", geometry="updated")
    largest, smallest, u = run(
        spec, ELASTIC, [1.0, 2.0], "cycle_max_axial_strain", "cycle_min_axial_strain", "cycle_pore_pressure"
    )
    assert largest == pytest.approx([0.002] * 2, rel=1.0e-9)
    assert smallest == pytest.approx([-0.002] * 2, rel=1.0e-9)
    assert u == pytest.approx([0.0, 0.0], abs=1.0e-8)


def test_a_path_counts_where_its_stress_is_first_reached() -> None:
    (q,) = run(triaxial("elastic", LOOP), ELASTIC, [101.0, 110.0, 500.0], "path_q")
    assert q == pytest.approx([3.0, 30.0, 0.03 * YOUNG], rel=1.0e-7)


def test_state_variables_of_the_law_are_series() -> None:
    stages = [{"axial_strain": 0.02, "rate": 0.5}]
    spec = triaxial("soft_soil_creep", stages, drainage="undrained", consolidation=[{"axial": 150.0, "duration": 10.0}])
    state, after = run(spec, CREEP, [0.0, 0.01, 0.02], "log_pp")[0], run(spec, CREEP, [1.0], "consolidation_log_pp")[0]
    assert state[0] == pytest.approx(after[0], rel=1.0e-12)
    assert (np.diff(state) > 0.0).all()
    # Creep under constant stress: eps_v = mu* ln(1 + t/tau r^beta), d ln p_p = d eps_v/(lambda* - kappa*).
    attraction, strength = 2.0 / np.tan(np.radians(28.0)), CREEP["lambda_star"] - CREEP["kappa_star"]
    ratio = (150.0 + attraction) / (100.0 + attraction)
    creep = CREEP["mu_star"] * np.log(1.0 + 10.0 * ratio ** (strength / CREEP["mu_star"]))
    assert after[0] == pytest.approx(np.log(100.0 + attraction) + creep / strength, rel=1.0e-6)


def test_the_secant_modulus_is_that_of_elasticity() -> None:
    (modulus,) = run(triaxial("elastic", [{"axial_strain": 0.01}]), ELASTIC, [1.0e-6, 0.01], "secant_modulus")
    assert modulus == pytest.approx([YOUNG, YOUNG], rel=1.0e-7)


def test_drained_shearing_after_undrained_shearing_keeps_the_pore_pressure() -> None:
    stages = [{"axial_strain": 0.002, "drainage": "undrained"}, {"axial_strain": 0.004}]
    u, p = run(triaxial("elastic", stages), ELASTIC, [1.0, 2.0], "stage_pore_pressure", "stage_p")
    rise = 3.0 * YOUNG / 2.6 * 0.002 / 3.0
    assert u == pytest.approx([rise, rise], rel=1.0e-8)
    assert p[1] == pytest.approx(100.0 + YOUNG * 0.002 / 3.0, rel=1.0e-8)


def test_only_points_that_the_test_has_are_accepted() -> None:
    model = triaxial("elastic", [{"axial_strain": 0.01}], consolidation=[{"axial": 100.0}]).build()
    for name, x, words in (
        ("q", 0.02, r"x must be from 0 to 0.01, got 0.02"),
        ("time_q", 1.5, r"x must be from 0 to 1 day, got 1.5 day"),
        ("stage_q", 1.5, r"whole numbers from 1 to 1"),
        ("tau", 1.0, "'tau' is unknown; known are q, p"),
    ):
        with pytest.raises(ProblemError, match=words):
            model.prepare({name: np.array([x])})


def test_grids_are_within_the_series() -> None:
    spec = triaxial("mohr_coulomb", [*LOOP, {"kind": "cyclic", "axial_strain_amplitude": 0.01, "cycles": 4}])
    for model in (spec.build(), triaxial("elastic", [{"axial_strain": -0.02}]).build()):
        for info in model.series:
            grid = model.grid(info.name)
            assert (np.diff(grid) > 0.0).all()
            assert grid.size == 0 or (info.x_lower or grid[0]) <= grid[0] <= grid[-1] <= (info.x_upper or grid[-1])
