"""The methods: ours through its own ask / tell, the libraries through an objective that counts and stops them."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from benchmarks.search.problems import Task
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.particle_swarm import ParticleSwarm, SwarmSettings
from geoswarm.solver.search.runs import Runs

__all__ = ["METHODS", "Outcome"]

LIMIT = 1590  # evaluations, the paper's number
PARTICLES = 10
MOST_REFUSED = 20 * LIMIT  # infeasible points that a library may ask for
FAILED = 1e6  # objective that a library gets for a failed or infeasible point, in targets


@dataclass(frozen=True)
class Outcome:
    """Evaluations until the target was first reached, and those of all generations begun; processor time of the method
    itself a generation [s]."""

    solved: bool
    evaluations: int
    generations: int
    overhead: float


class SolvedError(Exception):
    """The target is reached or the evaluations are used up."""


class Counter:
    """Counts forward runs for a library; an infeasible point costs none."""

    def __init__(self, task: Task, *, sequential: bool = False) -> None:
        self.task, self.evaluations, self.solved, self.sequential = task, 0, False, sequential
        self.refused = 0
        self.spent, self.began = 0.0, time.process_time()

    def residuals(self, unit: FloatArray) -> FloatArray:
        unit = np.clip(np.asarray(unit, dtype=np.float64), 0.0, 1.0)
        bad = np.full(1 if self.task.scalar else self.task.outputs, 0.0)
        bad[0] = np.sqrt(FAILED * self.task.target)
        if not self.task.feasible(unit):
            self.refused += 1
            if self.refused > MOST_REFUSED:
                raise SolvedError
            return bad
        if self.evaluations >= LIMIT:
            raise SolvedError
        began = time.process_time()
        r = self.task.residuals(unit)
        self.spent += time.process_time() - began
        self.evaluations += 1
        if r is None:
            return bad
        if float(r @ r) <= self.task.target:
            self.solved = True
            raise SolvedError
        return r

    def objective(self, unit: FloatArray) -> float:
        r = self.residuals(unit)
        return float(r @ r)

    def outcome(self) -> Outcome:
        generations = self.evaluations if self.sequential else -(-self.evaluations // PARTICLES)
        own = time.process_time() - self.began - self.spent
        return Outcome(self.solved, self.evaluations, generations, own / max(generations, 1))


def swarm(
    task: Task, seed: int, acceleration: Literal["none", "response_surface"], particles: int = PARTICLES
) -> Outcome:
    """Run our swarm; evaluations count up to the one that reached the target, generations are whole."""
    settings = SwarmSettings(particles=particles, acceleration=acceleration)
    search = ParticleSwarm(task.calibration.space, settings, seed)
    outputs = 1 if task.scalar else task.outputs
    positions, rows, overhead, generations = np.empty((0, task.dimension)), np.empty((0, outputs)), 0.0, 0
    while True:
        asked = search.ask()
        units = (task.calibration.space.to_search(asked) - task.lower) / task.width
        found = [task.residuals(unit) for unit in units]
        objectives = np.array([np.inf if r is None else float(r @ r) for r in found])
        before = len(positions)
        positions = np.concatenate([positions, asked])
        rows = np.concatenate([rows, [np.full(outputs, np.nan) if r is None else r for r in found]])
        generations += 1
        if objectives.min() <= task.target:
            first = int(np.argmax(objectives <= task.target))
            return Outcome(True, before + first + 1, generations, overhead / generations)
        if len(positions) >= LIMIT:
            return Outcome(False, LIMIT, generations, overhead / generations)
        began = time.process_time()
        search.tell(objectives, Runs.of(positions, rows))
        overhead += time.process_time() - began


def differential_evolution(counter: Counter, seed: int) -> None:
    from scipy.optimize import differential_evolution

    d = counter.task.dimension
    start = np.random.default_rng(seed).random((PARTICLES, d))
    differential_evolution(
        counter.objective, [(0, 1)] * d, init=start, rng=seed, polish=False, maxiter=10**6, tol=0, updating="deferred"
    )


def least_squares_multistart(counter: Counter, seed: int) -> None:
    from scipy.optimize import least_squares

    random, d = np.random.default_rng(seed), counter.task.dimension
    while True:
        least_squares(counter.residuals, random.random(d), bounds=(0, 1), x_scale=0.1)


def dfo_ls(counter: Counter, seed: int) -> None:
    """Restarted from random points; the settings are those that suit this suite best."""
    import dfols

    quiet()
    random, d = np.random.default_rng(seed), counter.task.dimension
    np.random.seed(seed)  # noqa: NPY002  the library knows no other way
    while True:
        dfols.solve(
            counter.residuals,
            random.random(d),
            bounds=(np.zeros(d), np.ones(d)),
            rhobeg=0.2,
            rhoend=1e-5,
            maxfun=300,
            do_logging=False,
        )


def py_bobyqa(counter: Counter, seed: int) -> None:
    """The same for the objective alone."""
    import pybobyqa

    quiet()
    random, d = np.random.default_rng(seed), counter.task.dimension
    np.random.seed(seed)  # noqa: NPY002  the library knows no other way
    while True:
        pybobyqa.solve(
            counter.objective,
            random.random(d),
            bounds=(np.zeros(d), np.ones(d)),
            rhobeg=0.2,
            rhoend=1e-5,
            maxfun=300,
            do_logging=False,
        )


def quiet() -> None:
    """Keep libraries from logging."""
    import logging

    logging.disable(logging.CRITICAL)


def pymoo_swarm(counter: Counter, seed: int) -> None:
    from pymoo.algorithms.soo.nonconvex.pso import PSO
    from pymoo.core.problem import ElementwiseProblem
    from pymoo.optimize import minimize

    class Wrapped(ElementwiseProblem):  # type: ignore[misc]  # a library without types
        def __init__(self) -> None:
            super().__init__(n_var=counter.task.dimension, n_obj=1, xl=0.0, xu=1.0)

        def _evaluate(self, x: FloatArray, out: dict[str, float], *_: object, **__: object) -> None:
            out["F"] = counter.objective(x)

    minimize(Wrapped(), PSO(pop_size=PARTICLES), ("n_eval", 10**6), seed=seed, verbose=False)


def pyswarms_swarm(counter: Counter, seed: int) -> None:
    from pyswarms.single.global_best import GlobalBestPSO

    quiet()
    np.random.seed(seed)  # noqa: NPY002  the library knows no other way
    d = counter.task.dimension
    options = {"c1": 1.49618, "c2": 1.49618, "w": 0.7298}
    optimiser = GlobalBestPSO(PARTICLES, d, options, bounds=(np.zeros(d), np.ones(d)))
    optimiser.optimize(lambda x: np.array([counter.objective(u) for u in x]), 10**5, verbose=False)


def pycma(counter: Counter, seed: int) -> None:
    import cma

    d = counter.task.dimension
    options = {"bounds": [0, 1], "seed": seed + 1, "verbose": -9, "popsize": PARTICLES}
    start = np.random.default_rng(seed).random(d)
    while True:  # restarts, as its own driver makes them
        cma.fmin2(counter.objective, start, 0.3, options)
        start = np.random.default_rng(seed + counter.evaluations).random(d)


def optuna_with(sampler: str) -> Callable[[Counter, int], None]:
    def run(counter: Counter, seed: int) -> None:
        import optuna

        optuna.logging.set_verbosity(optuna.logging.ERROR)
        chosen = {
            "cma": lambda: optuna.samplers.CmaEsSampler(seed=seed),
            "tpe": lambda: optuna.samplers.TPESampler(seed=seed, multivariate=True),
        }[sampler]()
        study = optuna.create_study(sampler=chosen)
        names = [f"u{i}" for i in range(counter.task.dimension)]
        study.optimize(lambda t: counter.objective(np.array([t.suggest_float(n, 0, 1) for n in names])), n_trials=10**5)

    return run


LIBRARIES: dict[str, Callable[[Counter, int], None]] = {
    "pymoo PSO": pymoo_swarm,
    "pyswarms": pyswarms_swarm,
    "SciPy DE": differential_evolution,
    "Optuna CMA": optuna_with("cma"),
    "Optuna TPE": optuna_with("tpe"),
    "pycma": pycma,
    "least_squares": least_squares_multistart,
    "DFO-LS": dfo_ls,
    "Py-BOBYQA": py_bobyqa,
}
SEQUENTIAL = ("least_squares", "DFO-LS", "Py-BOBYQA")
WIDTHS = (1, 2, 4, 40)  # of our generations, beside ten


def library(name: str) -> Callable[[Task, int], Outcome]:
    def run(task: Task, seed: int) -> Outcome:
        counter = Counter(task, sequential=name in SEQUENTIAL)
        with contextlib.suppress(SolvedError):
            LIBRARIES[name](counter, seed)
        return counter.outcome()

    return run


def geoswarm(particles: int) -> Callable[[Task, int], Outcome]:
    return lambda task, seed: swarm(task, seed, "response_surface", particles)


METHODS: dict[str, Callable[[Task, int], Outcome]] = (
    {"geoswarm": geoswarm(PARTICLES)}
    | {f"geoswarm, {particles} at once": geoswarm(particles) for particles in WIDTHS}
    | {"textbook swarm": lambda task, seed: swarm(task, seed, "none")}
    | {name: library(name) for name in LIBRARIES}
)
