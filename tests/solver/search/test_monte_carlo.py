from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import InfeasibleSpaceError
from geoswarm.solver.search.monte_carlo import MonteCarlo, MonteCarloSettings
from geoswarm.solver.search.space import SearchSpace
from tests.solver.search.spaces import box, oedometer_space

SAMPLINGS = ["random", "latin_hypercube", "sobol"]


def drawn(space: SearchSpace, settings: MonteCarloSettings, seed: int = 4) -> FloatArray:
    sampling = MonteCarlo(space, settings, seed)
    batches = []
    while (positions := sampling.ask()) is not None:
        batches.append(positions)
        sampling.tell(np.zeros(len(positions)))
    assert all(len(batch) == settings.batch for batch in batches[:-1])
    return np.concatenate(batches)


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_gives_the_number_asked_for_inside_bounds_and_constraints(sampling: Any) -> None:
    space = oedometer_space()
    points = drawn(space, MonteCarloSettings(333, sampling, batch=50))
    assert points.shape == (333, 3)
    assert np.all((points >= space.lower) & (points <= space.upper))
    assert np.all(points[:, 0] > points[:, 1])
    assert len(np.unique(points, axis=0)) == 333


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_covers_the_box_evenly(sampling: Any) -> None:
    points = drawn(box(2, 0.0, 1.0), MonteCarloSettings(1024, sampling))
    assert points.mean(axis=0) == pytest.approx([0.5, 0.5], abs=0.04)
    assert points.var(axis=0) == pytest.approx([1 / 12, 1 / 12], rel=0.1)


def test_latin_hypercube_has_one_point_a_stratum() -> None:
    points = drawn(box(3, 0.0, 1.0), MonteCarloSettings(200, "latin_hypercube"))
    assert np.array_equal(np.sort((points * 200).astype(int), axis=0), np.tile(np.arange(200)[:, None], 3))


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_a_restored_sampling_goes_on_bit_for_bit_alike(sampling: Any) -> None:
    space, settings = oedometer_space(), MonteCarloSettings(120, sampling, batch=25)
    whole = drawn(space, settings)
    first = MonteCarlo(space, settings, 4)
    first.tell(np.zeros(25))
    restored = MonteCarlo.restore(space, settings, 4, first.snapshot())
    second = restored.ask()
    assert second is not None
    assert second.tobytes() == whole[25:50].tobytes()


@pytest.mark.parametrize("sampling", ["latin_hypercube", "sobol"])
def test_too_few_feasible_points_is_an_error_with_the_counts(sampling: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("geoswarm.solver.search.monte_carlo._LARGEST_DESIGN", 256)
    space = box(2, 0.0, 1.0, feasible=lambda x: bool(x[0] < 1e-9))
    with pytest.raises(
        InfeasibleSpaceError, match=r"only 0 of 256 .* points .* satisfy the constraints, 16 are needed"
    ):
        MonteCarlo(space, MonteCarloSettings(16, sampling), 1).ask()
