from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geoswarm.solver.errors import InfeasibleSpaceError
from geoswarm.solver.search.determinism import particle_generator
from geoswarm.solver.search.space import SearchSpace
from tests.solver.search.spaces import box, oedometer_space


@given(
    lower=st.floats(1e-9, 1e3),
    factor=st.floats(1.001, 1e6),
    fraction=st.floats(0.0, 1.0),
    log=st.booleans(),
)
def test_coordinates_round_trip_inside_the_bounds(lower: float, factor: float, fraction: float, log: bool) -> None:
    upper = lower * factor
    space = SearchSpace(("x",), np.array([lower]), np.array([upper]), np.array([log]), lambda _: True)
    search = space.search_lower + fraction * (space.search_upper - space.search_lower)
    natural = space.to_natural(search)
    assert lower <= natural[0] <= upper
    assert space.to_natural(space.to_search(natural))[0] == pytest.approx(natural[0], rel=1e-13)


def test_log_coordinates_are_natural_logarithms_as_published() -> None:
    space = oedometer_space()
    assert space.search_lower[:2] == pytest.approx([-6.21, -6.91], abs=0.005)
    assert space.search_upper[:2] == pytest.approx([0.0, -0.69], abs=0.005)
    assert space.search_upper[2] == 100.0


def test_draw_satisfies_constraints_and_keeps_the_users_estimate() -> None:
    space = oedometer_space()
    estimate = np.array([np.nan, 0.035, np.nan])
    for particle in range(50):
        point = space.to_natural(space.draw(particle_generator(1, 0, particle), estimate))
        assert point[0] > point[1]
        assert point[1] == pytest.approx(0.035, rel=1e-14)


def test_a_space_without_feasible_points_is_an_error_that_says_what_to_do() -> None:
    space = box(2, feasible=lambda _: False)
    with pytest.raises(InfeasibleSpaceError, match=r"10000 draws inside the bounds of x0, x1; widen the bounds"):
        space.draw(particle_generator(1, 0, 0))
