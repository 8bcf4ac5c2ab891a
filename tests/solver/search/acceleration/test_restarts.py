"""Restarts and covariance moves: state that survives JSON, finished basins, the elite."""

from __future__ import annotations

import json

import numpy as np

from geoswarm.solver.search.acceleration.basins import Basins
from geoswarm.solver.search.acceleration.covariance import CovarianceMoves


def test_a_basin_is_finished_after_generations_without_gain() -> None:
    points = np.array([[0.2, 0.2], [0.8, 0.8]])
    basins = Basins()
    for _ in range(5):
        basins = basins.after(points, np.array([1.0, 3.0]), patience=4)
    assert basins.finished == ((0.2, 0.2),)
    assert (basins.restarts, basins.best, basins.gained) == (1, None, False)
    assert basins.outside(np.array([[0.22, 0.2], [0.3, 0.2]])).tolist() == [False, True]
    # now the best outside counts
    assert basins.after(points, np.array([1.0, 3.0]), 4).best == 3.0
    assert Basins.from_json(json.loads(json.dumps(basins.to_json()))) == basins


def test_a_small_gain_does_not_count_and_a_large_one_does() -> None:
    points = np.array([[0.5]])
    basins = Basins().after(points, np.array([1.0]), 4)
    assert basins.after(points, np.array([0.99]), 4).waiting == 1
    assert basins.after(points, np.array([0.9]), 4).waiting == 0


def test_the_rim_of_a_finished_basin_is_no_basin_of_its_own() -> None:
    basins = Basins(finished=((0.2, 0.2),), restarts=1)
    # from the centre over two steps up its side, then two runs of another basin, then one on no side
    points = np.array([[0.2, 0.2], [0.24, 0.2], [0.28, 0.2], [0.6, 0.6], [0.32, 0.2], [0.62, 0.6], [0.4, 0.2]])
    assert basins.open_runs(points).tolist() == [False, False, False, True, False, True, True]
    assert basins.after(points, np.arange(1.0, 8.0), 4).best == 4.0
    open_ = basins.open_runs(points)
    wanted = [([0.3, 0.22], False), ([0.6, 0.62], True), ([0.32, 0.35], True), ([0.23, 0.23], False)]
    assert [basins.admits(np.array(point), points, open_) for point, _ in wanted] == [
        admitted for _, admitted in wanted
    ]
    assert Basins().open_runs(points).all()
    assert Basins().admits(np.array([0.2, 0.2]), points, open_)


def test_openness_is_that_of_the_definition() -> None:
    """Against the definition run by run: ties, repeats, and points exactly at the radius."""
    random = np.random.default_rng(3)
    for case in range(60):
        dimension, count = int(random.integers(1, 8)), int(random.integers(0, 260))
        basins = Basins(finished=tuple(map(tuple, random.random((2, dimension)))), radius=0.2)
        points = random.random((count, dimension))
        if case % 2:
            points = np.round(points / 0.1) * 0.1
        wanted = basins.outside(points)
        for i in range(1, min(count, 200)):
            distances = np.abs(points[:i] - points[i]).max(axis=1)
            if not wanted[int(np.argmin(distances))] and distances.min() <= basins.radius:
                wanted[i] = False
        np.testing.assert_array_equal(basins.open_runs(points), wanted)


def test_when_everything_is_finished_it_begins_again() -> None:
    basins = Basins(finished=((0.5,),), restarts=1).after(np.array([[0.5]]), np.array([1.0]), 4)
    assert (basins.finished, basins.restarts, basins.best) == ((), 2, 1.0)


def test_covariance_moves_minimise_and_survive_json_bit_for_bit() -> None:
    target = np.array([0.3, 0.7, 0.5])
    moves = CovarianceMoves.begin(np.full(3, 0.5), 0.2)
    for generation in range(60):
        state = moves.state()
        moves = CovarianceMoves(state)  # as every generation of a search does
        restored = CovarianceMoves(json.loads(json.dumps(state, allow_nan=False)))
        random, again = np.random.default_rng(generation), np.random.default_rng(generation)
        for _ in range(3):  # fewer than a population
            point = moves.ask(random)
            assert restored.ask(again).tobytes() == point.tobytes()
            objective = float(((point - target) ** 2).sum()) if generation != 5 else np.inf
            moves.tell(point, objective)
            restored.tell(point, objective)
        assert json.dumps(restored.state()) == json.dumps(moves.state())
    assert np.abs(moves.ask(np.random.default_rng(0)) - target).max() < 0.1
    assert not moves.exhausted


def test_covariance_moves_end_when_they_have_contracted() -> None:
    moves = CovarianceMoves.begin(np.array([0.5]), 0.01)
    random = np.random.default_rng(1)
    for _ in range(500):
        if moves.exhausted:
            break
        point = moves.ask(random)
        moves.tell(point, float((point[0] - 0.5) ** 2))
    assert moves.exhausted
