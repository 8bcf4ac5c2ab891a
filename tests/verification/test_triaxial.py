"""The triaxial test against independent integrations, a published table, finite elements, and itself refined."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.verification.exact.creep import cone
from geoswarm.verification.specimens.bodies import block
from geoswarm.verification.specimens.laboratory import CREEP, MOHR_COULOMB, run, triaxial
from geoswarm.verification.specimens.soils import mohr_coulomb

LAMBDA, KAPPA, MU, C, PHI, NU, K0NC, OCR = 0.11, 0.03, 0.004, 30.0, 35.0, 0.2, 0.48, 1.3
SOIL = {
    **{"lambda_star": LAMBDA, "kappa_star": KAPPA, "mu_star": MU, "c": C, "phi": PHI},
    **{"nu_ur": NU, "K0nc": K0NC, "OCR": OCR},
}
ATTRACTION = C / math.tan(math.radians(PHI))
M = cone(K0NC, NU, LAMBDA / KAPPA)
RATE = 0.5


def creep(p: float, q: float, log_pp: float) -> tuple[float, float]:
    """Rates of creep volume strain and shear strain from the definitions (Vermeer & Neher 1999), translated."""
    P = p + ATTRACTION
    p_eq = P + q * q / (M * M * P)
    alpha = 1.0 - q * q / (M * P) ** 2
    volume = MU * math.exp((LAMBDA - KAPPA) / MU * (math.log(p_eq) - log_pp))
    return volume, volume / alpha * 2.0 * q / (M * M * P)


def rates(drained: bool, way: float) -> object:
    """d(p, q, ln p_p, volume strain)/dt at a constant rate of axial strain."""

    def rate(_: float, y: FloatArray) -> list[float]:
        p, q, log_pp, _volume = y.tolist()
        K = (p + ATTRACTION) / KAPPA
        G = 1.5 * K * (1.0 - 2.0 * NU) / (1.0 + NU)
        volume, shear = creep(p, q, log_pp)
        # Drained: 3 dp = dq, with the shear strain axial strain less a third of the volume strain.
        total = (3.0 * K * volume + 3.0 * G * (way * RATE - shear)) / (3.0 * K + G) if drained else 0.0
        change = 3.0 * G * (way * RATE - total / 3.0 - shear)
        return [K * (total - volume), change, volume / (LAMBDA - KAPPA), total]

    return rate


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("drainage", ["drained", "undrained"])
def test_creep_at_constant_rate_against_an_independent_integration(drainage: str, way: float) -> None:
    x = way * np.array([1.0e-4, 1.0e-3, 4.0e-3, 0.007])
    start = [100.0, 0.0, math.log(OCR * (100.0 + ATTRACTION)), 0.0]
    times = np.abs(x) / RATE
    result = solve_ivp(
        rates(drainage == "drained", way), (0.0, times[-1]), start, "Radau", times, rtol=1.0e-10, atol=1.0e-12
    )
    p, q, log_pp, volume = result.y
    assert abs(q[-1]) > 50.0
    spec = triaxial(
        "soft_soil_creep", [{"axial_strain": float(x[-1]), "rate": RATE}], drainage=drainage, tolerance=1.0e-8
    )
    names = ("p", "q", "log_pp", "volumetric_strain")
    found = run(spec, SOIL, x, *names)
    for one, expected, size in zip(found, (p, q, log_pp, volume), (100.0, 100.0, 1.0, 0.01), strict=True):
        assert one == pytest.approx(expected, abs=1.0e-5 * size)
    if drainage == "undrained":
        (u,) = run(spec, SOIL, x, "pore_pressure")
        assert u == pytest.approx(100.0 + q / 3.0 - p, abs=1.0e-3)


@pytest.mark.parametrize(
    ("minutes", "limit", "published"), [(21600, 51.16, 51.06), (2160, 55.80, 55.70), (216, 60.87, 60.76)]
)
def test_peaks_of_stolle_vermeer_and_bonnier(minutes: int, limit: float, published: float) -> None:
    """Stolle, Vermeer & Bonnier (1999), Table I: undrained at constant rates to 20 %, tau = 0.70 minutes."""
    soil = {
        **{"lambda_star": 0.106, "kappa_star": 0.016, "mu_star": 0.004, "nu_ur": 0.25, "M": 1.29},
        **{"phi": 30.0, "psi": 0.0, "c": 0.0},
    }
    stage = {"axial_strain": 0.2, "duration": minutes / 0.7}  # in tau, which is a day
    spec = triaxial("soft_soil_creep", [stage], drainage="undrained")
    (q,) = run(spec, soil, np.linspace(1.0e-3, 0.05, 400), "q")
    assert q.max() == pytest.approx(limit, abs=0.02)
    assert q.max() == pytest.approx(published, rel=0.003)


@pytest.mark.parametrize("material", ["mohr_coulomb", "soft_soil_creep"])
def test_the_error_is_of_the_size_of_the_tolerance(material: str) -> None:
    soil, bulk = (MOHR_COULOMB, 1.7e4) if material == "mohr_coulomb" else (CREEP, 8.0e3)
    stages = [
        {"axial_strain": 0.03, "rate": 0.3},
        {"deviator_stress": 30.0, "duration": 0.01},
        {"axial_strain": 0.06, "rate": 0.3},
    ]
    x = np.linspace(0.0, 0.06, 61)
    found = {}
    for tolerance in (1.0e-4, 1.0e-5, 1.0e-6, 1.0e-8):
        spec = triaxial(material, stages, tolerance=tolerance)
        found[tolerance] = run(spec, soil, x, "q", "volumetric_strain")
    for tolerance in (1.0e-4, 1.0e-5, 1.0e-6):
        q, volume = (np.abs(one - best).max() for one, best in zip(found[tolerance], found[1.0e-8], strict=True))
        assert q < 2.0 * tolerance * bulk
        assert volume < tolerance


def test_finite_elements_give_the_same_drained_test() -> None:
    material = mohr_coulomb(2.0e4, 0.3, 5.0, 30.0, 10.0)
    strains = [0.004, 0.01, 0.012, 0.008]
    mesh = block(np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    sides = (Fixity("left", x=0.0), Fixity("bottom", y=0.0))
    phases = [
        Phase(
            "start",
            "K0",
            materials={"soil": material},
            initial_stress=lambda x: np.tile([-100.0, -100.0, -100.0, 0.0], (x.shape[0], 1)),
            fixities=sides,
            tractions=(Traction("right", normal=-100.0), Traction("top", normal=-100.0)),
        )
    ]
    for number, (before, after) in enumerate(zip([0.0, *strains[:-1]], strains, strict=True)):
        phases.append(
            Phase(
                f"stage {number}",
                "plastic",
                fixities=(*sides, Fixity("top", y=before - after)),
                tractions=(Traction("right", normal=-100.0),),
            )
        )
    results = solve_phases(mesh, phases, geometry="axisymmetric", control=Control(tolerance=1.0e-10))
    stages = [{"axial_strain": strain} for strain in strains]
    q, volume = run(
        triaxial("mohr_coulomb", stages), MOHR_COULOMB, [1.0, 2.0, 3.0, 4.0], "stage_q", "stage_radial_strain"
    )
    for result, expected, radial in zip(results[1:], q, volume, strict=True):
        stress = -result.stress.reshape(-1, 4)
        assert stress[:, 1] - stress[:, 0] == pytest.approx(np.full(len(stress), expected), rel=1.0e-6)
        side = result.displacements[mesh.boundaries["right"], 0]
        assert -side == pytest.approx(np.full(side.shape, radial), rel=1.0e-6)
