"""The general update of soft soil creep: order of its tangent, limits, purity, agreement with the axial step."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.constitutive.mohr_coulomb.limit import ACTIVE_SETS, principal_planes
from geoswarm.solver.constitutive.soft_soil_creep.general_update import creep_update
from geoswarm.solver.constitutive.soft_soil_creep.physics import SoftSoilCreep, soft_soil_creep
from geoswarm.solver.constitutive.tensors import principal_axes, rotation_matrix
from geoswarm.solver.element_test.axial import confined_step, strain_increment

STRESS = np.array([60.0, 50.0, 100.0, 5.0, 3.0, -2.0])
LOG_PP = math.log(95.0)

ELASTIC, ONE_DAY = -math.inf, 0.0
STEPS = {
    "general": [1.0e-3, -2.0e-3, 8.0e-3, 1.0e-3, 2.0e-3, -1.0e-3],
    "compression": [1.0e-2, 1.1e-2, 0.9e-2, 1.0e-3, 0.0, 0.0],
    "face": [-2.0e-2, -1.0e-2, 5.0e-2, 1.0e-2, 2.0e-2, 0.0],
    "edge in compression": [-2.0e-2, -2.0e-2, 5.0e-2, 0.0, 0.0, 0.0],
    "edge in extension": [3.0e-2, 3.0e-2, -4.0e-2, 0.0, 0.0, 0.0],
    "edge near the apex": [1.0e-2, 2.0e-2, -6.0e-2, 2.0e-3, 0.0, 1.0e-3],
    "two tension planes": [-6.0e-2, -2.0e-2, -2.2e-2, 1.0e-3, 0.0, 1.0e-3],
    "two tension planes and a face": [-6.0e-2, -6.0e-2, 2.0e-2, 1.0e-3, 0.0, 2.0e-3],
}


def soil(psi: float = 5.0, formulation: str = "translated", tension_cutoff: float | None = 0.0) -> SoftSoilCreep:
    return soft_soil_creep(
        0.1,
        0.02,
        0.005,
        5.0,
        25.0,
        psi,
        formulation=formulation,  # type: ignore[arg-type]
        tension_cutoff=tension_cutoff,
    )


@pytest.mark.parametrize("formulation", ["translated", "untranslated"])
@pytest.mark.parametrize("log_time", [ELASTIC, ONE_DAY, -8.0, 5.0], ids=["instant", "day", "short", "long"])
@pytest.mark.parametrize("step", STEPS)
def test_the_tangent_is_consistent(step: str, log_time: float, formulation: str) -> None:
    """The error of the linearised stress falls with the square of the perturbation: slope 2, two-sided."""
    material = soil(formulation=formulation)
    strain = np.array(STEPS[step])
    stress, tangent, _, active = creep_update(STRESS, strain, log_time, LOG_PP, material)
    assert active >= 0
    rng = np.random.default_rng(11)
    for _ in range(3):
        direction = rng.normal(size=6)
        direction *= np.abs(strain).max() / np.abs(direction).max()
        errors = []
        for size in (1.0e-3, 1.0e-4):
            moved, _, _, moved_active = creep_update(STRESS, strain + size * direction, log_time, LOG_PP, material)
            assert moved_active == active
            errors.append(np.abs(moved - stress - size * tangent @ direction).max())
        if max(errors) < 1.0e-9:
            continue  # linear to rounding: the stress does not leave its corner
        assert 1.8 < math.log10(errors[0] / errors[1]) < 2.2


@pytest.mark.parametrize(
    ("step", "expected"),
    [
        ("general", ()),
        ("face", (0,)),
        ("edge in compression", (0, 1)),
        ("edge in extension", (0, 2)),
        ("two tension planes", (3, 4)),
        ("two tension planes and a face", (0, 3, 4)),
    ],
)
def test_the_expected_planes_are_active(step: str, expected: tuple[int, ...]) -> None:
    active = creep_update(STRESS, np.array(STEPS[step]), ONE_DAY, LOG_PP, soil())[3]
    assert tuple(ACTIVE_SETS[active][ACTIVE_SETS[active] >= 0]) == expected


def test_axisymmetric_compression_ends_on_the_edge() -> None:
    stress = np.array([50.0, 50.0, 100.0, 0.0, 0.0, 0.0])
    new, _, _, active = creep_update(stress, np.array([-0.02, -0.02, 0.05, 0.0, 0.0, 0.0]), ELASTIC, LOG_PP, soil())
    assert set(ACTIVE_SETS[active][ACTIVE_SETS[active] >= 0]) == {0, 1}
    assert new[0] == pytest.approx(new[1], rel=1.0e-12)
    sine, cosine = math.sin(math.radians(25.0)), math.cos(math.radians(25.0))
    assert new[2] * (1.0 - sine) - new[0] * (1.0 + sine) == pytest.approx(2.0 * 5.0 * cosine, rel=1.0e-10)


def test_large_extension_ends_in_the_corner_of_the_cut_off() -> None:
    expansion = np.array([-0.1, -0.1, -0.1, 0.0, 0.0, 0.0])
    cut_off, _, _, _ = creep_update(STRESS, expansion, ONE_DAY, LOG_PP, soil())
    assert cut_off == pytest.approx(np.zeros(6), abs=1.0e-9)
    tougher = soft_soil_creep(0.1, 0.02, 0.005, 5.0, 25.0, tension_cutoff=2.0)
    assert creep_update(STRESS, expansion, ONE_DAY, LOG_PP, tougher)[0] == pytest.approx(
        [-2.0] * 3 + [0.0] * 3, abs=1e-9
    )


@pytest.mark.parametrize("step", STEPS)
def test_no_plane_is_violated(step: str) -> None:
    material = soil()
    stress = creep_update(STRESS, np.array(STEPS[step]), ONE_DAY, LOG_PP, material)[0]
    normals, _, offsets = principal_planes(
        material.cohesion, material.sin_phi, material.cos_phi, material.sin_psi, material.tension
    )
    values, _ = principal_axes(stress)
    assert (normals @ values - offsets).max() < 1.0e-7


def test_inputs_stay_as_they_are() -> None:
    stress, strain = STRESS.copy(), np.array(STEPS["face"])
    kept = strain.copy()
    new, _, log_pp, _ = creep_update(stress, strain, ONE_DAY, LOG_PP, soil())
    assert (stress == STRESS).all()
    assert (strain == kept).all()
    assert not np.shares_memory(new, stress)
    assert log_pp > LOG_PP


def test_the_update_does_not_depend_on_the_frame() -> None:
    angle = 0.7
    axes = np.array(
        [[math.cos(angle), -math.sin(angle), 0.0], [math.sin(angle), math.cos(angle), 0.0], [0.0, 0.0, 1.0]]
    )
    Q = rotation_matrix(axes)
    strain = np.array(STEPS["face"])
    stress, tangent, log_pp, _ = creep_update(STRESS, strain, ONE_DAY, LOG_PP, soil())
    turned, turned_tangent, turned_pp, _ = creep_update(
        Q @ STRESS, np.linalg.inv(Q.T) @ strain, ONE_DAY, LOG_PP, soil()
    )
    assert turned == pytest.approx(Q @ stress, rel=1.0e-9, abs=1.0e-9)
    assert turned_pp == pytest.approx(log_pp, rel=1.0e-12)
    assert turned_tangent == pytest.approx(Q @ tangent @ Q.T, rel=1.0e-6, abs=1.0e-5)


@pytest.mark.parametrize("formulation", ["translated", "untranslated"])
@pytest.mark.parametrize("log_time", [ELASTIC, ONE_DAY, -8.0])
@pytest.mark.parametrize("axial_strain", [0.002, 0.05, -0.01, -0.02])
def test_the_axial_step_is_the_same_physics(axial_strain: float, log_time: float, formulation: str) -> None:
    material = soil(formulation=formulation)
    stress = np.array([60.0, 60.0, 100.0, 0.0, 0.0, 0.0])
    strain = np.array([0.0, 0.0, axial_strain, 0.0, 0.0, 0.0])
    new, _, log_pp, active = creep_update(stress, strain, log_time, LOG_PP, material)
    assert active >= 0
    lateral, axial, creep, converged = confined_step(100.0, 60.0, new[2], log_time, LOG_PP, 60.0, material)
    assert converged
    assert lateral == pytest.approx(new[0], rel=1.0e-8, abs=1.0e-8)
    assert axial == pytest.approx(axial_strain, rel=1.0e-7)
    assert LOG_PP + creep / 0.08 == pytest.approx(log_pp, rel=1.0e-9)


def test_the_axial_strain_has_the_derivative_it_states() -> None:
    material = soil()
    h = 1.0e-4

    def lateral_strain(lateral: float) -> float:
        return strain_increment(100.0, 60.0, 120.0, lateral, ONE_DAY, LOG_PP, material)[1]

    slope = strain_increment(100.0, 60.0, 120.0, 62.0, ONE_DAY, LOG_PP, material)[3]
    assert slope == pytest.approx((lateral_strain(62.0 + h) - lateral_strain(62.0 - h)) / (2.0 * h), rel=1.0e-7)
