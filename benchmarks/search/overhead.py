"""Own time of a generation: ``python -m benchmarks.search.overhead``. Runs with long responses."""

from __future__ import annotations

import time

import numpy as np
from threadpoolctl import threadpool_limits

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.search.particle_swarm import ParticleSwarm, SwarmSettings
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace

__all__ = ["measure"]

DIMENSION, REPEATS = 5, 7


def measure(count: int, outputs: int, particles: int = 10) -> tuple[float, float]:
    """Median and largest processor time of closing one generation [s], with ``count`` stored runs."""
    random = np.random.default_rng(1)
    names = tuple(f"p{i}" for i in range(DIMENSION))
    lower, upper = np.zeros(DIMENSION), np.ones(DIMENSION)
    space = SearchSpace(names, lower, upper, np.zeros(DIMENSION, dtype=np.bool_), lambda _: True)
    mixing = random.standard_normal((2 * DIMENSION, outputs)) / np.sqrt(outputs)

    def residuals(x: FloatArray) -> FloatArray:
        bent = np.concatenate([x - 0.4, 0.3 * (x - 0.4) * np.roll(x, 1, axis=1)], axis=1)
        rows: FloatArray = bent @ mixing
        return rows + 0.01

    # half of the runs lie around the minimum, as after a long search
    far = random.random((count // 2, DIMENSION))
    near = np.clip(0.4 + 0.05 * random.standard_normal((count - count // 2, DIMENSION)), 0.0, 1.0)
    positions = np.concatenate([far, near])
    objectives = np.concatenate([(residuals(part) ** 2).sum(axis=1) for part in np.array_split(positions, 20)])
    swarm = ParticleSwarm(space, SwarmSettings(particles, acceleration="response_surface"), 1)
    spent = []
    for _ in range(REPEATS):
        asked = swarm.ask()
        if asked is None:
            raise RuntimeError("the search has ended")
        new = (residuals(asked) ** 2).sum(axis=1)
        positions, objectives = np.concatenate([positions, asked]), np.concatenate([objectives, new])

        def rows(chosen: IntArray, known: FloatArray = positions) -> FloatArray:
            return residuals(known[chosen])

        began = time.process_time()
        swarm.tell(new, Runs(positions, objectives, rows))
        spent.append(time.process_time() - began)
    return float(np.median(spent)), max(spent)


if __name__ == "__main__":
    with threadpool_limits(limits=1):
        for particles in (1, 10, 40):
            for count, outputs in ((500, 200), (500, 2000), (20_000, 200), (20_000, 2000)):
                median, largest = measure(count, outputs, particles)
                took = f"{1e3 * median:6.1f} ms, at most {1e3 * largest:6.1f} ms"
                print(f"{particles:3d} particles, {count:6d} runs x {outputs:4d} outputs: {took}")
