"""Slots that stand idle where runs differ in length: ``python -m benchmarks.search.slots``.

A simulation of events: slots take runs in the order of generation and particle; a third of the runs take four times as
long as the others. Compared are generations that wait for their last run and generations asked ahead
(``overlap: true``): the share of the slots' time that is used over 150 runs, and the time until the target, in short
runs.
"""

from __future__ import annotations

import heapq
import warnings
from dataclasses import dataclass

import click
import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.search.problems import PROBLEMS, Task
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.methods.widths import overlapping
from geoswarm.solver.search.particle_swarm import ParticleSwarm, SwarmSettings
from geoswarm.solver.search.runs import Runs

__all__ = ["Timed", "simulate"]

FIRST_SEED = 11_000  # none of these was used while the method was made
LONG, SHARE = 4.0, 1.0 / 3.0
RUNS = 150


@dataclass(frozen=True)
class Timed:
    """Time until the generation with a run on target was closed, inf: never; runs begun then; share of the slots' time
    that was used until then."""

    time: float
    runs: int
    used: float


def lengths(seed: int, generation: int, count: int, long: float) -> FloatArray:
    """Lengths of the runs of a generation: what a run takes does not depend on the search."""
    random = np.random.default_rng([seed, generation, 77])
    return np.where(random.random(count) < SHARE, long, 1.0)


def simulate(
    task: Task, seed: int, slots: int, *, particles: int, overlap: bool, long: float = LONG, target: bool = True
) -> Timed:
    """Run one search on a number of slots; without ``target`` it ends after 150 runs."""
    settings = SwarmSettings(particles=particles, acceleration="response_surface")
    space = task.calibration.space
    begin = ParticleSwarm.begin_overlapping if overlap else ParticleSwarm
    search = begin(space, settings, seed)
    outputs = 1 if task.scalar else task.outputs
    positions, rows = np.empty((0, task.dimension)), np.empty((0, outputs))
    waiting: list[tuple[int, int, float]] = []  # generation, particle, length
    found: dict[int, list[FloatArray | None]] = {}
    missing: dict[int, int] = {}
    asked: dict[int, FloatArray] = {}

    def dispatch(generation: int, at: FloatArray | None) -> None:
        if at is None or generation in asked:
            return
        asked[generation], missing[generation] = at, len(at)
        units = (space.to_search(at) - task.lower) / task.width
        found[generation] = [task.residuals(unit) for unit in units]
        waiting.extend((generation, k, w) for k, w in enumerate(lengths(seed, generation, len(at), long)))

    now, busy, free, begun = 0.0, 0.0, slots, 0
    running: list[tuple[float, int, int]] = []
    dispatch(0, search.ask())
    dispatch(1, search.ask_ahead())
    while True:
        while free and waiting:
            generation, particle, length = waiting.pop(0)
            heapq.heappush(running, (now + length, generation, particle))
            free, begun = free - 1, begun + 1
        then, generation, _ = heapq.heappop(running)
        busy += (slots - free) * (then - now)
        now, free = then, free + 1
        missing[generation] -= 1
        while missing.get(search.generation) == 0:
            current = search.generation
            objectives = np.array([np.inf if r is None else float(r @ r) for r in found[current]])
            positions = np.concatenate([positions, asked[current]])
            rows = np.concatenate([rows, [np.full(outputs, np.nan) if r is None else r for r in found[current]]])
            solved = bool(objectives.min() <= task.target)
            over = len(positions) >= (1590 if target else RUNS)
            if (solved and target) or over:
                return Timed(now if solved or not target else np.inf, begun, busy / (slots * now))
            search.tell(objectives, Runs.of(positions, rows), ahead=overlap)
            dispatch(search.generation, search.ask())
            dispatch(search.generation + 1, search.ask_ahead())


@click.command()
@click.option("--seeds", default=30, show_default=True)
@click.option("--slots", default=4, show_default=True)
@click.option("--long", default=LONG, show_default=True, help="length of a third of the runs")
@click.option("--idle", default=5, show_default=True, help="searches of 150 runs in which idle time is measured")
@click.option("--problem", "problems", multiple=True, type=click.Choice(list(PROBLEMS)))
def main(seeds: int, slots: int, long: float, idle: int, problems: tuple[str, ...]) -> None:
    """Print used shares and times to target, median and 90th percentile, with and without overlap."""
    warnings.simplefilter("ignore")
    ways = {"wait": (slots, False), "ahead": (slots, True), "wider": (overlapping(slots), True)}
    for problem in problems or PROBLEMS:
        task = PROBLEMS[problem]()
        shown = []
        for name, (particles, overlap) in ways.items():
            with threadpool_limits(limits=1):
                given = {"particles": particles, "overlap": overlap, "long": long}
                times = [simulate(task, FIRST_SEED + s, slots, **given).time for s in range(seeds)]
                used = [
                    simulate(task, FIRST_SEED + s, slots, **given, target=False).used for s in range(min(seeds, idle))
                ]
            median, ninth = np.percentile(times, [50, 90], method="higher")
            shown.append(f"{name}: {median:6.1f} /{ninth:6.1f}, used {100 * np.mean(used or [np.nan]):3.0f} %")
        print(f"{problem:20s} {'   '.join(shown)}", flush=True)


if __name__ == "__main__":
    main()
