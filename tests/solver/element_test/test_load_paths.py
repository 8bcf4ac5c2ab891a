"""Load paths of a material point: steps with kinks, values between the ends of steps, mixed rows, first crossings."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.element_test.load_paths import LoadPath, Path, PointState, follow_load_path, point_under
from geoswarm.solver.element_test.trace import Trace
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law

ELASTIC = find_law("elastic").soil({"E": 1.0e4, "nu": 0.25})
FRICTION = find_law("mohr_coulomb").soil({"E": 1.0e4, "nu": 0.25, "c": 3.0, "phi": 30.0})
CREEP = {"lambda_star": 0.1, "kappa_star": 0.02, "mu_star": 1.0e-3, "c": 1.0, "phi": 30.0, "OCR": 50.0}
ROUND = [100.0, 100.0, 100.0, 0.0]


def load_path(
    stress: dict[int, list[float]], strain: dict[int, list[float]], goal: list[float], duration: float = 1.0
) -> LoadPath:
    """Rows by their number."""
    rows = np.zeros((2, 4, 4))
    for which, given in enumerate((stress, strain)):
        for number, row in given.items():
            rows[which, number] = row
    return LoadPath("leg", rows[0], rows[1], np.array(goal), duration)


def all_strains(*goal: float, duration: float = 1.0) -> LoadPath:
    return load_path({}, {k: np.eye(4)[k].tolist() for k in range(4)}, list(goal), duration)


def shear(gamma: float) -> LoadPath:
    """At constant vertical stress."""
    rows = {0: [1.0, 0.0, 0.0, 0.0], 2: [0.0, 0.0, 1.0, 0.0], 3: [0.0, 0.0, 0.0, 1.0]}
    return load_path({1: [0.0, 1.0, 0.0, 0.0]}, rows, [0.0, math.nan, 0.0, gamma])


def test_a_linear_law_takes_a_few_steps_and_is_exact_between_them() -> None:
    path = follow_load_path(ELASTIC, all_strains(1.0e-3, 2.0e-3, 0.0, 5.0e-4), point_under(ROUND, ELASTIC), 1.0e-8)
    assert len(path.places) < 8
    x = np.array([0.0, 0.3, 0.77, 1.0])
    values = path.at(x)
    stiffness = ELASTIC.law.update(np.zeros(4), -math.inf, np.zeros(4), np.zeros(0), ELASTIC.constants)[2]
    expected = np.array(ROUND) + x[:, np.newaxis] * (stiffness @ [1.0e-3, 2.0e-3, 0.0, 5.0e-4])
    assert values[:, :4] == pytest.approx(expected, rel=1.0e-12)
    assert values[:, 4:] == pytest.approx(x[:, np.newaxis] * [1.0e-3, 2.0e-3, 0.0, 5.0e-4], rel=1.0e-12)


@pytest.mark.parametrize("tolerance", [1.0e-4, 1.0e-5, 1.0e-6])
def test_a_path_that_the_law_takes_exactly_is_curved_between_the_ends_of_steps(tolerance: float) -> None:
    """Elasticity of soft soil creep far below creep: p + a = (p_0 + a) exp(eps_v/kappa*), whatever the steps."""
    soil = find_law("soft_soil_creep").soil(CREEP)
    path = follow_load_path(
        soil, all_strains(2.0e-3, 2.0e-3, 2.0e-3, 0.0, duration=1.0e-9), point_under(ROUND, soil), tolerance
    )
    x = np.linspace(0.0, 1.0, 101)
    attraction = 1.0 / math.tan(math.radians(30.0))
    expected = (100.0 + attraction) * np.exp(x * 6.0e-3 / 0.02) - attraction
    bulk = 100.0 / 0.02
    assert np.abs(path.at(x)[:, :3].mean(axis=1) - expected).max() < tolerance * bulk * 1.5


@pytest.mark.parametrize("tolerance", [1.0e-4, 1.0e-5, 1.0e-6])
def test_a_kink_is_found_to_the_tolerance(tolerance: float) -> None:
    """Simple shear: the limit is reached inside the load path, and stresses turn behind it."""
    x = np.linspace(0.0, 1.0, 400)
    found, best = (
        follow_load_path(FRICTION, shear(0.1), point_under(ROUND, FRICTION), one).at(x) for one in (tolerance, 1.0e-8)
    )
    bulk = FRICTION.law.elastic_moduli(FRICTION.constants, 100.0)[0]
    assert np.abs(found - best)[:, 4:8].max() < tolerance
    assert np.abs(found - best)[:, :4].max() < 2.0 * tolerance * bulk


def test_rows_of_stress_and_strain_together_are_springs() -> None:
    """A vertical spring k holds the specimen while it is strained sideways: sigma_v + k eps_v stays."""
    spring = 3.0e3
    rows = {0: [1.0, 0.0, 0.0, 0.0], 1: [0.0, spring, 0.0, 0.0], 2: [0.0, 0.0, 1.0, 0.0], 3: [0.0, 0.0, 0.0, 1.0]}
    path = follow_load_path(
        ELASTIC,
        load_path({1: [0.0, 1.0, 0.0, 0.0]}, rows, [0.01, math.nan, 0.0, 0.0]),
        point_under(ROUND, ELASTIC),
        1.0e-6,
    )
    lame, shear_modulus = 1.0e4 * 0.25 / (1.25 * 0.5), 1.0e4 / 2.5
    vertical = -lame * 0.01 / (lame + 2.0 * shear_modulus + spring)
    assert path.end.strain[1] == pytest.approx(vertical, rel=1.0e-10)
    assert path.end.stress[1] == pytest.approx(100.0 - spring * vertical, rel=1.0e-10)


def test_creep_under_constant_stress_is_exact_at_any_time() -> None:
    """eps_v = mu* ln(1 + t/tau) from p_eq = p_p on, though steps are taken in logarithmic time."""
    soil = find_law("soft_soil_creep").soil(CREEP | {"OCR": 1.0})
    one = load_path({}, {}, [0.0] * 4, 100.0)
    hold = LoadPath("hold", np.eye(4), np.zeros((4, 4)), one.goal, 100.0, hold=True)
    path = follow_load_path(soil, hold, point_under(ROUND, soil), 1.0e-7)
    times = np.array([0.0, 1.0e-6, 0.01, 0.5, 3.0, 77.0, 100.0])
    assert path.at(times / 100.0)[:, 4:7].sum(axis=1) == pytest.approx(1.0e-3 * np.log1p(times), abs=1.0e-7)


def made(nodes: list[float], load_paths: int = 1) -> Trace:
    """A trace of a point whose one number takes values at ends and middles of steps of equal length."""
    values = np.array(nodes)[:, np.newaxis]
    steps = (len(nodes) - 1) // 2
    each = steps // load_paths
    paths = []
    for load_path_ in range(load_paths):
        first = 2 * load_path_ * each
        places = np.array([[k / each, (k + 1) / each, math.nan, 1.0] for k in range(each)])
        own = values[first : first + 2 * each + 1]
        paths.append(Path(1.0, places, own[1::2], own[::2], 0))
    return Trace(paths)


def test_a_crossing_is_the_first_one() -> None:
    trace = made([0.0, 1.0, 2.0, 1.5, 1.0, 3.0, 5.0, 2.0, -1.0], load_paths=2)
    found = trace.where_first(np.ones(1), np.array([0.5, 2.0, 3.0, 5.0, -0.5, 0.0]))
    assert found.rows[:, 0] == pytest.approx([0.5, 2.0, 3.0, 5.0, -0.5, 0.0], abs=1.0e-12)
    assert found.load_path.tolist() == [0, 0, 1, 1, 1, 0]
    missed = trace.where_first(np.ones(1), np.array([9.0, -9.0]))
    assert missed.rows[:, 0] == pytest.approx([5.0, -1.0])
    second = trace.where_first(np.ones(1), np.array([0.5, 1.0]), range(1, 2))
    assert second.rows[:, 0] == pytest.approx([0.5, 1.0], abs=1.0e-12)
    assert second.load_path.tolist() == [1, 1]


def test_times_are_those_of_the_legs() -> None:
    trace = made([0.0, 1.0, 2.0, 1.5, 1.0, 3.0, 5.0, 2.0, -1.0], load_paths=2)
    found = trace.at_times(np.array([0.0, 0.25, 1.0, 1.25, 2.0, 7.0]))
    assert found.rows[:, 0] == pytest.approx([0.0, 1.0, 1.0, 3.0, -1.0, -1.0])
    assert found.load_path.tolist() == [0, 0, 0, 1, 1, 1]


def test_a_law_without_an_update_for_a_point_says_so() -> None:
    class Plane(type(ELASTIC.law)):  # type: ignore[misc]
        components = frozenset({4})

    soil = Soil(Plane(), ELASTIC.constants)
    with pytest.raises(InfeasibleError, match="no stress update for element tests of 6 components, only for 4"):
        point_under([100.0] * 3 + [0.0] * 3, soil)
    assert isinstance(point_under(ROUND, soil), PointState)


def test_unloading_by_stress_after_softening_leaves_the_limit() -> None:
    """At constant volume this soil has lost a little of its peak, so that yielding on is a solution, too."""
    soil = find_law("matsuoka_nakai").soil({"E": 3.0e4, "nu": 0.25, "c": 25.0, "phi": 23.0})
    start = point_under([60.0, 100.0, 60.0, 0.0], soil)
    path = follow_load_path(soil, all_strains(0.0, 0.0, 0.0, 0.02), start, 1.0e-5)
    assert path.end.stress[3] < path.ends[:, 3].max() - 1.0e-3
    rows = {k: np.eye(4)[k].tolist() for k in range(3)}
    unload = load_path({3: [0.0, 0.0, 0.0, 1.0]}, rows, [0.0, 0.0, 0.0, 5.0])
    end = follow_load_path(soil, unload, path.end, 1.0e-5).end
    change = (5.0 - path.end.stress[3]) / soil.law.elastic_moduli(soil.constants, 70.0)[1]
    assert end.stress[3] == pytest.approx(5.0, rel=1.0e-9)
    assert end.strain[3] - 0.02 == pytest.approx(change, rel=1.0e-4)
