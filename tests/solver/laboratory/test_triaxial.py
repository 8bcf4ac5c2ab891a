"""The triaxial test against closed forms of elasticity and of Mohr and Coulomb."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.errors import DivergedError
from geoswarm.verification.specimens.laboratory import ELASTIC, MOHR_COULOMB, run, triaxial

YOUNG, POISSON = ELASTIC["E"], ELASTIC["nu"]
BULK = YOUNG / (3.0 * (1.0 - 2.0 * POISSON))
SHEAR = YOUNG / (2.0 * (1.0 + POISSON))
STRAINS = np.array([0.0, 1.0e-4, 1.0e-3, 4.0e-3, 0.01])
SIN, COS = 0.5, math.sqrt(0.75)
COHESION, PSI = MOHR_COULOMB["c"], math.radians(MOHR_COULOMB["psi"])


@pytest.mark.parametrize("end", [0.01, -0.01])
def test_elastic_drained_shearing_is_hookes_law(end: float) -> None:
    spec = triaxial("elastic", [{"axial_strain": end}], initial_void_ratio=0.8)
    x = STRAINS * np.sign(end)
    names = ("q", "p", "radial_strain", "volumetric_strain", "void_ratio", "stress_ratio", "radial_stress")
    q, p, radial, volume, e, ratio, kept = run(spec, ELASTIC, x, *names)
    assert q == pytest.approx(YOUNG * x, rel=1.0e-9, abs=1.0e-9)
    assert p == pytest.approx(100.0 + YOUNG * x / 3.0, rel=1.0e-9)
    assert radial == pytest.approx(-POISSON * x, rel=1.0e-9, abs=1.0e-14)
    assert volume == pytest.approx((1.0 - 2.0 * POISSON) * x, rel=1.0e-9, abs=1.0e-14)
    assert e == pytest.approx(0.8 - 1.8 * volume, rel=1.0e-12)
    assert ratio == pytest.approx(q / p, rel=1.0e-12)
    assert kept == pytest.approx(np.full(5, 100.0), rel=1.0e-12)


@pytest.mark.parametrize(("constant", "A"), [("radial_stress", 1 / 3), ("mean_stress", 0.0), ("axial_stress", -2 / 3)])
def test_pore_pressure_of_elasticity_follows_skempton(constant: str, A: float) -> None:
    spec = triaxial("elastic", [{"axial_strain": 0.01, "constant": constant}], drainage="undrained", back_pressure=200)
    q, u, volume, p = run(spec, ELASTIC, STRAINS, "q", "pore_pressure", "volumetric_strain", "p")
    assert q == pytest.approx(3.0 * SHEAR * STRAINS, rel=1.0e-9, abs=1.0e-9)
    assert u == pytest.approx(200.0 + A * q, rel=1.0e-9)
    assert volume == pytest.approx(np.zeros(5), abs=1.0e-13)
    assert p == pytest.approx(np.full(5, 100.0), rel=1.0e-10)


def test_soft_water_lets_the_volume_change_by_skemptons_B() -> None:
    water, e = 2.0e4, 0.8
    spec = triaxial(
        "elastic", [{"axial_strain": 0.01}], drainage="undrained", water_bulk_modulus=water, initial_void_ratio=e
    )
    q, u, volume = run(spec, ELASTIC, STRAINS, "q", "pore_pressure", "volumetric_strain")
    B = 1.0 / (1.0 + e / (1.0 + e) * BULK / water)
    assert u == pytest.approx(B * q / 3.0, rel=1.0e-9, abs=1.0e-9)
    assert volume == pytest.approx((1.0 - B) * q / 3.0 / BULK, rel=1.0e-9, abs=1.0e-14)


def test_large_strains_are_engineering_strains_outside() -> None:
    spec = triaxial("elastic", [{"axial_strain": 0.2}], geometry="updated", initial_void_ratio=0.8)
    x = np.array([0.05, 0.2])
    q, radial, volume, e = run(spec, ELASTIC, x, "q", "radial_strain", "volumetric_strain", "void_ratio")
    inside = -np.log(1.0 - x)
    assert q == pytest.approx(YOUNG * inside, rel=1.0e-9)
    assert radial == pytest.approx(1.0 - np.exp(POISSON * inside), rel=1.0e-9)
    assert volume == pytest.approx(1.0 - (1.0 - x) * (1.0 - radial) ** 2, rel=1.0e-9)
    assert (1.0 + e) / 1.8 == pytest.approx(1.0 - volume, rel=1.0e-9)


@pytest.mark.parametrize(
    ("end", "constant", "strength"),
    [
        # sigma_1 (1 - sin phi) = sigma_3 (1 + sin phi) + 2 c cos phi
        (0.1, "radial_stress", (2.0 * COHESION * COS + 2.0 * 100.0 * SIN) / (1.0 - SIN)),
        (-0.1, "radial_stress", -(2.0 * COHESION * COS + 2.0 * 100.0 * SIN) / (1.0 + SIN)),
        (0.1, "axial_stress", (2.0 * COHESION * COS + 2.0 * 100.0 * SIN) / (1.0 + SIN)),
        (0.1, "mean_stress", (6.0 * COHESION * COS + 6.0 * 100.0 * SIN) / (3.0 - SIN)),
        (-0.1, "mean_stress", -(6.0 * COHESION * COS + 6.0 * 100.0 * SIN) / (3.0 + SIN)),
    ],
)
def test_mohr_coulomb_fails_at_its_strength(end: float, constant: str, strength: float) -> None:
    spec = triaxial("mohr_coulomb", [{"axial_strain": end, "constant": constant}])
    x = end * np.array([0.5, 0.8, 1.0])
    q, volume, elastic = run(spec, MOHR_COULOMB, x, "q", "volumetric_strain", "radial_strain")
    assert q == pytest.approx(np.full(3, strength), rel=1.0e-8)
    # Flow at an edge of the pyramid: the strain along the different stress is (1 - sin psi)/(1 + sin psi) of the rest.
    flow = math.sin(PSI)
    slope = -2.0 * flow / (1.0 - flow) if end > 0.0 else 2.0 * flow / (1.0 + flow)
    assert np.diff(volume) / np.diff(x) == pytest.approx([slope, slope], rel=1.0e-6)
    assert elastic.size == 3


def test_undrained_mohr_coulomb_without_dilatancy_keeps_the_mean_stress() -> None:
    spec = triaxial("mohr_coulomb", [{"axial_strain": 0.05}], drainage="undrained")
    q, u, p = run(spec, MOHR_COULOMB | {"psi": 0.0}, [0.04, 0.05], "q", "pore_pressure", "p")
    strength = (6.0 * COHESION * COS + 6.0 * 100.0 * SIN) / (3.0 - SIN)
    assert q == pytest.approx([strength] * 2, rel=1.0e-8)
    assert p == pytest.approx([100.0] * 2, rel=1.0e-8)
    assert u == pytest.approx(q / 3.0, rel=1.0e-8)


def test_consolidation_at_rest_has_the_ratio_of_elasticity() -> None:
    stages = [{"axial": 200.0, "radial": "K0"}, {"axial": 300.0, "radial": 160.0}, {"axial": 150.0}]
    spec = triaxial("elastic", [{"axial_strain": 0.01}], consolidation=stages, initial_ratio="K0")
    names = ("consolidation_axial_strain", "consolidation_radial_strain", "consolidation_K0", "consolidation_p")
    axial, radial, K0, p = run(spec, ELASTIC, [1.0, 2.0, 3.0], *names)
    rest = POISSON / (1.0 - POISSON)
    confined = YOUNG * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
    assert pytest.approx([rest, 160.0 / 300.0, 1.0], rel=1.0e-9) == K0
    assert axial[0] == pytest.approx(100.0 / confined, rel=1.0e-9)
    assert radial[0] == pytest.approx(0.0, abs=1.0e-14)
    assert p == pytest.approx([200.0 * (1.0 + 2.0 * rest) / 3.0, 620.0 / 3.0, 150.0], rel=1.0e-9)
    changes = np.array([150.0 - 100.0, 150.0 - 100.0 * rest])
    assert axial[2] == pytest.approx((changes[0] - 2.0 * POISSON * changes[1]) / YOUNG, rel=1.0e-9)
    q, first = run(spec, ELASTIC, 0.01, "q", "radial_stress")
    assert q == pytest.approx([YOUNG * 0.01], rel=1.0e-9)
    assert first == pytest.approx([150.0], rel=1.0e-12)


def test_stress_led_shearing_ends_at_its_stress() -> None:
    stages = [{"deviator_stress": 60.0, "rate": 30.0}, {"deviator_stress": -20.0, "duration": 1.0}]
    spec = triaxial("elastic", stages)
    q, strain = run(spec, ELASTIC, [1.0, 2.0], "stage_q", "stage_axial_strain")
    assert q == pytest.approx([60.0, -20.0], rel=1.0e-9)
    assert strain == pytest.approx([60.0 / YOUNG, -20.0 / YOUNG], rel=1.0e-9)
    # 2 days to 60 kPa, then 80 kPa down within a day.
    (over_time,) = run(spec, ELASTIC, [0.0, 1.0, 2.0, 2.5, 3.0, 9.0], "time_q")
    assert over_time == pytest.approx([0.0, 30.0, 60.0, 20.0, -20.0, -20.0], rel=1.0e-9, abs=1.0e-9)


def test_a_strength_that_is_not_there_is_a_failed_evaluation() -> None:
    spec = triaxial("mohr_coulomb", [{"axial_strain": 0.001}, {"deviator_stress": 500.0}])
    where = r"stage shearing 2: no solution .* at normal stresses 100, \d+\.?\d*, 100 kPa and strains .* \(x, y, z\)"
    with pytest.raises(DivergedError, match=where):
        run(spec, MOHR_COULOMB, [1.0], "stage_q")


def test_a_specimen_that_is_deformed_beyond_its_length_is_a_failed_evaluation() -> None:
    spec = triaxial("elastic", [{"deviator_stress": 60.0}])
    with pytest.raises(DivergedError, match=r"stage shearing 1: strain beyond 1, at normal stresses 100, 1[2-6].*"):
        run(spec, {"E": 20.0, "nu": 0.25}, [1.0], "stage_q")


@pytest.mark.usefixtures("other_laws")
@pytest.mark.parametrize("drainage", ["drained", "undrained"])
def test_a_law_of_six_components_gives_what_four_give(drainage: str) -> None:
    soil = {"E": 5.0e3, "nu": 0.25, "ratio": 1.5, "T": 2.0}
    stages = [
        {"axial_strain": 0.02, "duration": 0.3},
        {"kind": "hold", "duration": 2.0},
        {"kind": "hold", "keep": "strain", "duration": 1.0},
    ]
    names = ("time_q", "time_axial_strain", "time_radial_strain", "time_p")
    x = [0.1, 0.3, 0.4, 2.0, 2.3, 2.5, 3.3]
    four = run(triaxial("standard_solid", stages, drainage=drainage), soil, x, *names)
    six = run(triaxial("no_plane", stages, drainage=drainage), soil, x, *names)
    for one, other in zip(four, six, strict=True):
        assert one == pytest.approx(other, rel=1.0e-9, abs=1.0e-12)
    assert four[0][4] == pytest.approx(four[0][1], rel=1.0e-6)  # creep keeps q, relaxation does not
    assert four[0][6] < 0.9 * four[0][4]
