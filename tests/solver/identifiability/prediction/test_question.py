"""What a prediction asks: the scatter of the parameters, and the problem that they are run through."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.identifiability.prediction.draws import basins_of, draw_around
from geoswarm.solver.identifiability.prediction.question import predict_problem
from geoswarm.solver.identifiability.prediction.shapes import shape_of
from tests.solver.identifiability.cases import WHITE, free, linearised, problem_of


def test_many_readings_take_memory_by_their_number() -> None:
    """It was by its square: 20 GB for 50 000 readings of a logger."""
    x = np.linspace(0.0, 9.0, 5000)
    found = linearised(problem_of("a + b * x", {"a": free(), "b": free()}, 1.0 + 2.0 * x, x, noise=WHITE), [1.0, 2.01])
    tracemalloc.start()
    shape_of(found)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 50e6


def test_a_mistake_in_the_forward_model_brings_no_others() -> None:
    """What the job identifies was called unknown where an expression used it."""
    problem = problem_of(
        "a + b * x", {"a": free(), "b": free()}, np.array([1.0, 3.1, 4.9]), np.arange(3.0), noise=WHITE
    )
    basins = basins_of(Calibration(problem, 1), linearised(problem, [1.05, 1.95]), 1.0, (), (), None)
    other = {
        "forward_model": {"kind": "oedometer", "material": "elastic", "height": -1.0},
        "parameters": {"nu": {"expression": "0.1 * a"}},
        "observations": [{"series": "settlement", "points": {"x": [1.0]}}],
    }
    with pytest.raises(ProblemError) as caught:
        predict_problem(problem, other, draw_around(Calibration(problem, 1), basins, 10, 1), seed=1)
    assert {issue.path.partition(".")[0] for issue in caught.value.issues} == {"forward_model"}
