"""Material point under mixed control: set-ups, times, failures."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.constitutive.soft_soil_creep.physics import soft_soil_creep
from geoswarm.solver.element_test.boundary_conditions import Stage, strain_change, stress_value
from geoswarm.solver.element_test.material_point import follow
from geoswarm.solver.element_test.setups import (
    confined_load,
    constant_rate_oedometer,
    drained_triaxial,
    isotropic_load,
    isotropic_strain,
    relaxation,
    simple_shear,
    undrained_triaxial,
)
from geoswarm.solver.errors import DivergedError
from geoswarm.verification.specimens.soils import creep_law, creep_point

SOIL = soft_soil_creep(0.1, 0.02, 0.005, 5.0, 25.0)
START = creep_point([60.0, 60.0, 100.0, 0.0, 0.0, 0.0], SOIL, OCR=1.2)


def test_controls_are_met_at_every_output() -> None:
    stages = [confined_load(150.0, 1.0), constant_rate_oedometer(0.02, 0.5), relaxation(2.0)]
    history = follow(creep_law(SOIL), START, stages, [[0.0, 0.3, 1.0], [0.0, 0.25, 0.5], [2.0]])
    assert history.stress[:3, 2] == pytest.approx([150.0] * 3, rel=1.0e-10)
    assert np.abs(history.strain[:, :2]).max() < 1.0e-12
    assert history.strain[4, 2] - history.strain[3, 2] == pytest.approx(0.01, rel=1.0e-10)
    assert history.strain[6, 2] == pytest.approx(history.strain[5, 2], rel=1.0e-12)
    assert history.stress[6, 2] < history.stress[5, 2]
    assert history.stage.tolist() == [0, 0, 0, 1, 1, 1, 2]
    assert history.end.stress == pytest.approx(history.stress[-1], rel=1.0e-14)


def test_the_state_after_a_stage_is_its_end_without_output_there() -> None:
    with_output = follow(creep_law(SOIL), START, [confined_load(150.0, 1.0)], [[1.0]], tolerance=1.0e-8)
    without = follow(creep_law(SOIL), START, [confined_load(150.0, 1.0)], [[]], tolerance=1.0e-8)
    assert without.stress.shape == (0, 6)
    assert without.end.strain == pytest.approx(with_output.end.strain, abs=1.0e-8)


def test_undrained_shear_keeps_the_volume_and_drained_shear_the_cell_pressure() -> None:
    undrained = follow(creep_law(SOIL), START, [undrained_triaxial(0.05, 1.0)], [[0.5, 1.0]])
    assert undrained.strain[:, :3].sum(axis=1) == pytest.approx([0.0, 0.0], abs=1.0e-11)
    drained = follow(creep_law(SOIL), START, [drained_triaxial(0.05, 60.0, 1.0)], [[0.5, 1.0]])
    assert drained.stress[:, 0] == pytest.approx([60.0, 60.0], rel=1.0e-10)
    assert drained.stress[:, 1] == pytest.approx([60.0, 60.0], rel=1.0e-10)


def test_a_stress_combination_can_be_led() -> None:
    shear = (strain_change(0.0, xy=1), strain_change(0.0, yz=1), strain_change(0.0, zx=1))
    controls = (stress_value(70.0, zz=1, xx=-1), stress_value(0.0, xx=1, yy=-1), strain_change(0.0, xx=1, yy=1, zz=1))
    history = follow(creep_law(SOIL), START, [Stage("undrained load", 0.1, (*controls, *shear))], [[0.1]])
    assert history.stress[0, 2] - history.stress[0, 0] == pytest.approx(70.0, rel=1.0e-9)
    assert history.strain[0, :3].sum() == pytest.approx(0.0, abs=1.0e-11)


def test_simple_shear_approaches_a_limit_under_constant_axial_stress() -> None:
    history = follow(creep_law(SOIL), START, [simple_shear(0.4, 100.0, 1.0)], [[0.1, 0.2, 1.0]])
    assert history.stress[:, 2] == pytest.approx([100.0] * 3, rel=1.0e-9)
    assert (np.diff(history.stress[:, 5]) > -1.0e-6).all()
    assert 35.0 < history.stress[-1, 5] < 60.0


def test_isotropic_set_ups_agree() -> None:
    start = creep_point([50.0, 50.0, 50.0, 0.0, 0.0, 0.0], SOIL)
    load = follow(creep_law(SOIL), start, [isotropic_load(100.0, 1.0)], [[1.0]])
    volume = float(load.strain[0, :3].sum())
    strain = follow(creep_law(SOIL), start, [isotropic_strain(volume, 1.0e-3), relaxation(1.0)], [[], [1.0]])
    assert load.q == pytest.approx([0.0], abs=1.0e-9)
    assert 60.0 < strain.p[0] < 110.0


def test_halving_the_tolerance_changes_less_than_the_tolerance() -> None:
    for tolerance in (1.0e-4, 1.0e-5, 1.0e-6):
        coarse, fine = (
            follow(
                creep_law(SOIL),
                START,
                [confined_load(300.0, 5.0), confined_load(50.0, 5.0)],
                [[1.0, 5.0], [5.0]],
                tolerance=t,
            )
            for t in (tolerance, 0.5 * tolerance)
        )
        assert np.abs(coarse.strain - fine.strain).max() < tolerance


def test_a_load_above_the_strength_names_stage_and_fraction() -> None:
    shear = (strain_change(0.0, xy=1), strain_change(0.0, yz=1), strain_change(0.0, zx=1))
    controls = (stress_value(60.0, xx=1), stress_value(60.0, yy=1), stress_value(500.0, zz=1))
    stage = Stage("too much", 0.0, (*controls, *shear), instant=True)
    with pytest.raises(DivergedError, match=r"stage too much: no solution at \d+ % of its load"):
        follow(creep_law(SOIL), START, [stage], [[0.0]])


@pytest.mark.parametrize(
    ("duration", "instant", "words"),
    [(-1.0, True, "duration must be above 0, .*got -1 day"), (0.0, False, "0 when instant"), (math.inf, True, "inf")],
)
def test_bad_durations_are_refused(duration: float, instant: bool, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Stage("bad", duration, relaxation(1.0).controls, instant)


def test_bad_controls_and_times_are_refused() -> None:
    with pytest.raises(ValueError, match="zz"):
        stress_value(1.0, vertical=1)
    with pytest.raises(ValueError, match="6 controls are needed, got 5"):
        Stage("bad", 1.0, relaxation(1.0).controls[:5])
    with pytest.raises(ValueError, match="times must increase from 0 to 1 day"):
        follow(creep_law(SOIL), START, [relaxation(1.0)], [[0.5, 0.2]])
