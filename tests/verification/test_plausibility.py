"""How often right oedometer tests are warned of, and how often stages at wrong times are found, in random tests.

The figures stand in docs/command-line.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.forward.registry import parse_spec
from geoswarm.solver.plausibility import implausible
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.problem.checks.consolidation import consolidation_degree
from geoswarm.solver.sentences import plain

TESTS = 300
LOADS = (12.5, 25.0, 50.0, 100.0, 200.0, 400.0, 800.0, 1600.0)


def random_test(random: np.random.Generator) -> tuple[list[dict[str, float]], float, np.ndarray, np.ndarray]:
    """Stages, their duration [day], times [day] and readings [mm]: half of them with primary consolidation."""
    loads = list(LOADS[random.integers(0, 3) : random.integers(5, 9)])
    if random.random() < 0.5:
        loads += [loads[-1] / 2.0, loads[-1] / 4.0]
    if random.random() < 0.3:
        loads += [loads[-3] * 2.0, loads[-3] * 4.0]
    duration = float(random.choice([0.25, 1.0, 1.0, 2.0]))
    stages = [{"stress": load, "duration": duration} for load in loads]
    compression = 10.0 ** random.uniform(-1.7, -0.6)
    soil = {
        "lambda_star": compression,
        "kappa_star": compression * random.uniform(0.1, 0.4),
        "mu_star": compression / random.uniform(15.0, 40.0),
        "c": random.uniform(0.0, 20.0),
        "phi": random.uniform(18.0, 32.0),
        "POP": float(random.choice([0.0, 30.0, 100.0, 200.0])),
    }
    model = parse_spec({"kind": "oedometer", "height": 0.02, "initial_stress": 1.0, "stages": stages}).build()
    count = int(random.integers(4, 20))
    x = np.concatenate([duration * (k + 0.999 * np.geomspace(1e-3, 1.0, count)) for k in range(len(stages))])
    y = model.prepare({"settlement": x})(soil)["settlement"]
    if random.random() < 0.5:
        t90 = duration * 10.0 ** random.uniform(-3.0, -0.5)
        stage = np.minimum((x / duration).astype(int), len(stages) - 1)
        ends = model.prepare({"stage_settlement": np.arange(1.0, len(stages) + 1.0)})(soil)["stage_settlement"]
        before = np.concatenate([[0.0], ends])[stage]
        y = before + (y - before) * consolidation_degree(0.848 * (x - stage * duration) / t90)
    return stages, duration, x, 1e3 * y + random.normal(0.0, random.choice([0.001, 0.005, 0.01]), y.size)


def warnings(stages: list[dict[str, float]], x: np.ndarray, y: np.ndarray) -> str:
    document: dict[str, Any] = {
        "forward_model": {"kind": "oedometer", "height": 0.02, "initial_stress": 1.0, "stages": stages},
        "parameters": {
            "lambda_star": {"lower": 0.01, "upper": 0.5},
            **{k: {"value": v} for k, v in {"kappa_star": 0.005, "mu_star": 1e-3, "c": 5.0, "phi": 25.0}.items()},
        },
        "observations": [{"series": "settlement", "points": {"x": x.tolist(), "y": y.tolist()}, "y_unit": "mm"}],
        "stopping": {"max_evaluations": 10},
    }
    return " ".join(map(plain, implausible(parse_problem(document))))


@pytest.mark.slow
def test_loads_that_are_shown_and_loads_that_are_not() -> None:
    random = np.random.default_rng(3)
    false_alarms = found = 0
    for _ in range(TESTS):
        stages, duration, x, y = random_test(random)
        false_alarms += "no step" in warnings(stages, x, y)
        late = x + 0.5 * duration
        kept = late < duration * len(stages)
        found += "no step" in warnings(stages, late[kept], y[kept])
    assert false_alarms <= 0.02 * TESTS
    assert found >= 0.85 * TESTS
