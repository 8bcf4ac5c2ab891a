"""Mohr-Coulomb, Drucker-Prager and Matsuoka-Nakai with tension cut-off against closed forms and projections.

With s = sin(phi), N = (1 + s)/(1 - s), K = 9 + 8 tan(phi)^2 and a = c cot(phi). In plane strain a perfectly plastic
body fails with no plastic strain out of its plane, which gives the stress there and the strength. Stresses of
Matsuoka-Nakai are shifted by a: I1 I2 = K I3.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from geoswarm.solver.constitutive.tensors import rotation_matrix
from geoswarm.solver.element_test.boundary_conditions import Stage, strain_change, stress_value
from geoswarm.solver.element_test.material_point import History, follow, point_under
from geoswarm.solver.element_test.setups import drained_triaxial, simple_shear
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.forward.oedometer import OedometerSpec
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law

E, NU, C, PHI = 1.0e4, 0.25, 4.0, 30.0
S, TAN = math.sin(math.radians(PHI)), math.tan(math.radians(PHI))
N, K, A = (1.0 + S) / (1.0 - S), 9.0 + 8.0 * TAN**2, C / TAN
LAWS: dict[str, tuple[str, dict[str, Any]]] = {
    "mohr_coulomb": ("mohr_coulomb", {}),
    "matsuoka_nakai": ("matsuoka_nakai", {}),
    "compression": ("drucker_prager", {"match": "compression"}),
    "extension": ("drucker_prager", {"match": "extension"}),
    "plane_strain": ("drucker_prager", {"match": "plane_strain"}),
}
EVERY = pytest.mark.parametrize("name", LAWS)
DILATANCY = pytest.mark.parametrize("psi", [0.0, 8.0, PHI])
NO_SHEAR = tuple(strain_change(0.0, **{name: 1}) for name in ("xy", "yz", "zx"))


def soil(name: str, **changes: Any) -> Soil:
    """A soil of one of the laws."""
    law, settings = LAWS[name]
    given = {"E": E, "nu": NU, "c": C, "phi": PHI, "psi": 0.0, **settings}
    return find_law(law).soil({**given, **changes})


def circle(name: str, psi: float) -> tuple[float, float, float]:
    """Slope and strength of q over p of Drucker-Prager, and slope of its flow."""
    side = {"compression": -1.0, "extension": 1.0}.get(name)
    cosine, sine = math.cos(math.radians(PHI)), math.sin(math.radians(psi))
    if side is not None:
        return 6.0 * S / (3.0 + side * S), 6.0 * C * cosine / (3.0 + side * S), 6.0 * sine / (3.0 + side * sine)
    if psi == PHI:  # Drucker & Prager (1952), in terms of sqrt(J2) and I1
        alpha, k = TAN / math.sqrt(9.0 + 12.0 * TAN**2), 3.0 * C / math.sqrt(9.0 + 12.0 * TAN**2)
        return 3.0 * math.sqrt(3.0) * alpha, math.sqrt(3.0) * k, 3.0 * math.sqrt(3.0) * alpha
    assert psi == 0.0
    return math.sqrt(3.0) * S, math.sqrt(3.0) * C * cosine, 0.0


def sheared(of: Soil, stages: list[Stage], times: list[float], stress: float = 60.0) -> History:
    """From an all-round stress through stages of a day."""
    start = point_under([stress, stress, stress, 0.0, 0.0, 0.0], of)
    return follow(of, start, stages, [[] for _ in stages[:-1]] + [np.array(times)], tolerance=1.0e-7)


@EVERY
@DILATANCY
@pytest.mark.parametrize("strain", [0.2, -0.2])
def test_strength_and_dilatancy_in_the_triaxial_test(name: str, psi: float, strain: float) -> None:
    """Compression (strain above 0) and extension at a cell pressure of 60 kPa."""
    if name == "plane_strain" and psi not in (0.0, PHI):
        psi = 0.0
    history = sheared(soil(name, psi=psi), [drained_triaxial(strain, 60.0, 1.0)], [0.5, 1.0])
    axial, sine = history.stress[-1, 2], math.sin(math.radians(psi))
    if name in ("mohr_coulomb", "matsuoka_nakai"):
        expected = (60.0 + A) * N - A if strain > 0.0 else (60.0 + A) / N - A
        dilation = -2.0 * sine / (1.0 - sine) if strain > 0.0 else 2.0 * sine / (1.0 + sine)
    else:
        slope, strength, flow = circle(name, psi)
        sign = math.copysign(1.0, strain)
        expected = 60.0 + sign * (slope * 60.0 + strength) / (1.0 - sign * slope / 3.0)
        dilation = -sign * flow / (1.0 - sign * flow / 3.0)
    assert axial == pytest.approx(max(expected, 0.0), abs=1.0e-6)
    if expected > 0.0:
        change = np.diff(history.strain[:, :3], axis=0)[0]
        assert change.sum() / change[2] == pytest.approx(dilation, abs=1.0e-6)


def _plane_strain(name: str, psi: float) -> tuple[float, float]:
    """Largest and intermediate principal stress in plane strain with a smallest of 60 kPa."""
    if name in ("mohr_coulomb", "plane_strain"):
        largest = (60.0 + A) * N - A
        d = _d(circle(name, psi)[2]) if name == "plane_strain" else math.nan
        return largest, _out_of_plane(60.0, largest, d)
    if name == "matsuoka_nakai":
        if psi == 0.0:  # flow of a circle: s = 0 out of the plane, (I1 I2/I3 = K) is C^2/(s1 s3) = (K - 3)/6
            sine = math.sqrt(1.0 - 6.0 / (K - 3.0))
            largest = (60.0 + A) * (1.0 + sine) / (1.0 - sine) - A
            return largest, 0.5 * (60.0 + largest)
        both = math.sqrt(K) - 1.0  # associated: s2 = sqrt(s1 s3), (s1 + s3)/s2 = sqrt(K) - 1
        root = 0.5 * (both + math.sqrt(both**2 - 4.0))
        return (60.0 + A) * root**2 - A, (60.0 + A) * root - A
    slope, strength, flow = circle(name, psi)
    d = _d(flow)
    J = (60.0 + strength / slope) / (math.sqrt(3.0) / slope - d / 3.0 - math.sqrt(1.0 - d * d / 3.0))
    largest = 60.0 + 2.0 * J * math.sqrt(1.0 - d * d / 3.0)
    return largest, _out_of_plane(60.0, largest, d)


def _d(flow: float) -> float:
    """Flow of sqrt(J2) over p."""
    return flow / math.sqrt(3.0)


def _out_of_plane(smallest: float, largest: float, d: float) -> float:
    """Stress with the deviator 2/3 d sqrt(J2)."""
    radius = 0.5 * (largest - smallest)
    J = radius / math.sqrt(1.0 - d * d / 3.0)
    return 0.5 * (largest + smallest) + d * J


@EVERY
@pytest.mark.parametrize("psi", [0.0, PHI])
def test_strength_and_dilatancy_in_plane_strain(name: str, psi: float) -> None:
    controls = (stress_value(60.0, xx=1), strain_change(0.0, yy=1), strain_change(0.6, zz=1), *NO_SHEAR)
    history = sheared(soil(name, psi=psi), [Stage("plane strain", 1.0, controls)], [0.9, 1.0])
    largest, between = _plane_strain(name, psi)
    assert history.stress[-1, 2] == pytest.approx(largest, rel=1.0e-5)
    if not math.isnan(between):
        assert history.stress[-1, 1] == pytest.approx(between, rel=1.0e-4)
    change = np.diff(history.strain[:, :3], axis=0)[0]
    sine = math.sin(math.radians(psi))
    if name in ("mohr_coulomb", "plane_strain") or psi == 0.0:
        assert change.sum() / (change[2] - change[0]) == pytest.approx(-sine, abs=1.0e-4)


@EVERY
@pytest.mark.parametrize("psi", [0.0, 8.0, PHI])
def test_strength_in_simple_shear(name: str, psi: float) -> None:
    """Davis (1968): without strain along it, a plane carries (c cos phi + sigma sin phi) cos psi/(1 - sin phi sin psi).

    So do laws with the strength of Mohr-Coulomb in plane strain; Matsuoka-Nakai without dilatancy carries the radius of
    its circle.
    """
    sine, cosine = math.sin(math.radians(psi)), math.cos(math.radians(psi))
    if name in ("mohr_coulomb", "plane_strain"):
        expected = (C * math.cos(math.radians(PHI)) + 60.0 * S) * cosine / (1.0 - S * sine)
    elif name == "matsuoka_nakai" and psi == 0.0:
        expected = (60.0 + A) * math.sqrt(1.0 - 6.0 / (K - 3.0))
    else:
        expected = math.nan
    history = sheared(soil(name, psi=psi), [simple_shear(1.0, 60.0, 1.0)], [0.8, 1.0])
    assert history.stress[-1, 5] == pytest.approx(history.stress[0, 5], rel=1.0e-4)
    if not math.isnan(expected):
        assert history.stress[-1, 5] == pytest.approx(expected, rel=1.0e-4)


def _reserves(name: str, values: np.ndarray) -> list[float]:
    """Values, kPa, that are at least 0 within the limit, of principal stresses in any order; associated flow."""
    if name == "mohr_coulomb":
        cosine = math.cos(math.radians(PHI))
        return [
            2.0 * C * cosine - values[i] * (1.0 - S) + values[j] * (1.0 + S)
            for i, j in ((0, 1), (1, 0), (0, 2), (2, 0), (1, 2), (2, 1))
        ]
    if name == "matsuoka_nakai":
        x, y, z = values + A
        return [(K * x * y * z - (x + y + z) * (x * y + y * z + z * x)) / ((x + y + z) ** 2 + 1.0e-12), x, y, z]
    slope, strength, _ = circle(name, PHI)
    p = values.mean()
    return [slope * p + strength - math.sqrt(1.5 * ((values - p) ** 2).sum() + 1.0e-24)]


@EVERY
@pytest.mark.parametrize("tension", [None, 0.0, 2.0])
def test_associated_flow_ends_at_the_nearest_admissible_stress(name: str, tension: float | None) -> None:
    """Nearest in elastic energy, found by minimisation; six components with axes in all directions."""
    of = soil(name, psi=PHI, tension_cutoff=tension)
    flexible = np.full((3, 3), -NU / E) + (1.0 + NU) / E * np.eye(3)
    random = np.random.default_rng(3)
    compared = 0
    for axes in Rotation.random(40, rng=random).as_matrix():
        Q = rotation_matrix(axes)
        trial = random.choice([60.0, 5.0, -10.0]) + random.normal(size=3) * random.choice([10.0, 60.0])
        strain = np.linalg.inv(Q).T @ np.append(flexible @ (trial - 60.0), [0.0, 0.0, 0.0])
        start = 60.0 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        new, _, _, status = of.law.update(strain, -math.inf, start, np.zeros(0), of.constants)
        assert status >= 0
        if status == 0:
            assert min(_reserves(name, trial)) >= -1.0e-6
            continue
        local = np.linalg.inv(Q) @ new
        assert local[3:] == pytest.approx(np.zeros(3), abs=1.0e-8)

        def limits(values: np.ndarray) -> np.ndarray:
            found = _reserves(name, values)
            return np.array(found if tension is None else [*found, *(values + tension)])

        def energy(values: np.ndarray, trial: np.ndarray = trial) -> float:
            return float(0.5e3 * (values - trial) @ flexible @ (values - trial))

        assert limits(local[:3]).min() > -1.0e-6
        begin = np.full(3, 60.0)
        found = minimize(
            energy,
            begin,
            constraints={"type": "ineq", "fun": limits},
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 500},
        )
        # The axes x = y = 0 solve I1 I2 = K I3, too, and are not within the limit.
        x, y, z = found.x + A
        within = min(x, y, z) > 0.0 and (x + y + z) * (x * y + y * z + z * x) < 1.001 * K * x * y * z
        if not found.success or (name == "matsuoka_nakai" and not within):
            continue
        compared += 1
        assert energy(local[:3]) <= found.fun * (1.0 + 1.0e-6) + 1.0e-9
        assert local[:3] == pytest.approx(found.x, abs=2.0e-2)
    assert compared >= 10


@EVERY
@pytest.mark.parametrize("tension", [0.0, 3.0])
def test_pulled_soil_carries_its_tension_and_no_more(name: str, tension: float) -> None:
    """Pulled along one axis, two or three, which are turned against the components."""
    of = soil(name, tension_cutoff=tension)
    for count in (1, 2, 3):
        for axes in Rotation.random(5, rng=np.random.default_rng(count)).as_matrix():
            Q = rotation_matrix(axes)
            pull = np.array([-1.0e-3 if i < count else 2.0e-4 for i in range(3)] + [0.0, 0.0, 0.0])
            stress, state = np.array([5.0, 5.0, 5.0, 0.0, 0.0, 0.0]), np.zeros(0)
            for _ in range(30):
                stress, state, _, status = of.law.update(
                    np.linalg.inv(Q).T @ pull, -math.inf, stress, state, of.constants
                )
                assert status >= 0
            local = np.linalg.inv(Q) @ stress
            assert local[:3].min() == pytest.approx(-tension, abs=1.0e-8)
            assert np.sort(local[:3])[:count] == pytest.approx(np.full(count, -tension), abs=1.0e-8)
            assert local[3:] == pytest.approx(np.zeros(3), abs=1.0e-8)


@EVERY
def test_without_a_cut_off_pulled_soil_ends_at_the_tip(name: str) -> None:
    of = soil(name, psi=8.0 if name != "plane_strain" else PHI, tension_cutoff=None)
    for axes in Rotation.random(5, rng=np.random.default_rng(9)).as_matrix():
        Q = rotation_matrix(axes)
        pull = np.linalg.inv(Q).T @ np.array([-0.02, -0.025, -0.03, 0.0, 0.0, 0.0])
        new, _, _, status = of.law.update(
            pull, -math.inf, np.array([5.0, 5.0, 5.0, 0.0, 0.0, 0.0]), np.zeros(0), of.constants
        )
        assert status == 1
        assert new == pytest.approx([-A, -A, -A, 0.0, 0.0, 0.0], abs=1.0e-8)


def test_matsuoka_nakai_is_its_ratio_of_invariants_in_every_direction() -> None:
    of = soil("matsuoka_nakai", tension_cutoff=None)
    random = np.random.default_rng(1)
    for _ in range(200):
        strain = random.normal(size=6) * 0.03
        new, _, _, status = of.law.update(
            strain, -math.inf, np.array([80.0, 80.0, 80.0, 0.0, 0.0, 0.0]), np.zeros(0), of.constants
        )
        xx, yy, zz, xy, yz, zx = new
        shifted = np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]) + A * np.eye(3)
        first, third = np.trace(shifted), np.linalg.det(shifted)
        second = 0.5 * (first**2 - (shifted @ shifted).trace())
        if status == 1 and np.linalg.norm(shifted) > 1.0e-6:
            assert first * second == pytest.approx(K * third, rel=1.0e-8)


@EVERY
def test_flow_without_friction_keeps_the_volume(name: str) -> None:
    """phi = 0: Tresca, or a cylinder around it, at which q = 2 c in triaxial compression (plane strain: sqrt(3) c)."""
    history = sheared(soil(name, phi=0.0, c=20.0), [drained_triaxial(0.2, 60.0, 1.0)], [0.5, 1.0])
    expected = math.sqrt(3.0) * 20.0 if name == "plane_strain" else 40.0
    assert history.q[-1] == pytest.approx(expected, rel=1.0e-6)
    assert np.diff(history.strain[:, :3].sum(axis=1))[0] == pytest.approx(0.0, abs=1.0e-7)


@pytest.mark.parametrize("law", ["drucker_prager", "matsuoka_nakai"])
def test_a_stress_beyond_the_strength_is_reported(law: str) -> None:
    of = find_law(law).soil({"E": E, "nu": NU, "c": 0.0, "phi": PHI})
    with pytest.raises(InfeasibleError, match="initial principal stresses 100, 10, 10 kPa violate the strength"):
        point_under([10.0, 10.0, 100.0, 0.0, 0.0, 0.0], of)
    with pytest.raises(InfeasibleError, match="psi must be at most phi = "):
        find_law(law).soil({"E": E, "nu": NU, "c": 0.0, "phi": PHI, "psi": 31.0})


def test_an_oedometer_keeps_to_the_limit_of_matsuoka_nakai() -> None:
    """With nu = 0 the lateral stress stays until the strength of triaxial compression is reached, then follows it."""
    section = {
        **{"kind": "oedometer", "material": "matsuoka_nakai", "height": 0.02, "initial_stress": 20.0, "K0": 1.0},
        **{"geometry": "fixed", "tolerance": 1.0e-7, "stages": [{"stress": s, "duration": 1.0} for s in (50.0, 100.0)]},
    }
    run = OedometerSpec.model_validate(section).build().prepare({"stage_axial_strain": np.array([1.0, 2.0])})
    found = run({"E": E, "nu": 0.0, "c": 0.0, "phi": PHI, "psi": 0.0})["stage_axial_strain"]
    # Elastic to 60 kPa; then without volume change by flow, 3 (1 - 2 nu) dp/E with dp = (1 + 2/N)/3 d sigma_v.
    expected = [30.0 / E, 40.0 / E + (1.0 + 2.0 / N) * 40.0 / E]
    assert found == pytest.approx(expected, rel=1.0e-6)
