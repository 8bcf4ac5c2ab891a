from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.search.space import diversity


@pytest.mark.parametrize("dimension", [1, 3, 20])
def test_an_even_distribution_has_diversity_one(dimension: int) -> None:
    units = np.random.default_rng(1).random((20_000, dimension))
    assert diversity(units) == pytest.approx(1.0, abs=0.02)
    assert diversity(0.25 * units + 0.6) == pytest.approx(0.25, abs=0.005)


def test_extremes_and_mean_over_the_parameters() -> None:
    assert diversity(np.full((7, 3), 0.4)) == pytest.approx(0.0, abs=1e-12)
    assert diversity(np.array([[0.0, 1.0], [1.0, 0.0]])) == pytest.approx(np.sqrt(3.0), rel=1e-12)
    assert diversity(np.array([[0.0, 0.5], [1.0, 0.5]])) == pytest.approx(np.sqrt(1.5), rel=1e-12)
