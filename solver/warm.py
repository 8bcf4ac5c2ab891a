"""Compile the numerical kernels ahead of the first calibration: ``python -m geoswarm.solver.warm``.

Numba caches what it compiles, see :mod:`geoswarm.solver.kernel_cache`. So each installation pays once, at set-up or
when its image is built, or else before the first calibration; every process after that starts warm. An empty file in
the cache folder says that a group of kernels is compiled; its name depends on all that would have it compiled again.
"""

from __future__ import annotations

import hashlib
import logging
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, TypeAlias

from geoswarm.solver.errors import in_words
from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.solver.forward.combined import CombinedSpec
from geoswarm.solver.kernel_cache import SOLVER, alone, fingerprint, settle
from geoswarm.solver.problem import Problem, parse_problem

__all__ = [
    "SAMPLES",
    "Tell",
    "compile_kernels",
    "groups_of",
    "import_models",
    "load_kernels",
    "missing_kernels",
    "note_compiled",
    "run_sample",
    "warm",
]

logger = logging.getLogger(__name__)

Tell: TypeAlias = Callable[[int, int], object]
"""Is told after every kernel how many have been compiled, and about how many there are."""

MATERIAL: dict[str, Any] = {
    "lambda_star": {"value": 0.1},
    "kappa_star": {"value": 0.02},
    "mu_star": {"value": 1.0e-3},
    "c": {"value": 5.0},
    "phi": {"value": 20.0},
    "psi": {"value": 0.0},
}
STAGES: list[dict[str, float]] = [{"stress": 50.0, "duration": 1.0}, {"stress": 20.0, "duration": 1.0}]


def import_models() -> None:
    """Import every forward model, ahead of the first evaluation."""
    for entry in entry_points(group="geoswarm.forward_models"):
        try:
            entry.load()
        except Exception as error:  # noqa: BLE001  anybody's code: it concerns only jobs that name it, which will say so
            logger.warning("forward model %r cannot be imported: %s", entry.name, in_words(error))


def _sample(forward_model: dict[str, Any], series: str) -> dict[str, Any]:
    """Build a problem around one forward model; nothing of it is calibrated, the free parameter only makes it whole."""
    return {
        "name": "warm",
        "forward_model": {"material": "soft_soil_creep", "stages": STAGES, **forward_model},
        "parameters": {**MATERIAL, "mu_star": {"lower": 1.0e-4, "upper": 1.0e-2}},
        "observations": [{"series": series, "points": {"x": [1.0, 2.0], "y": [0.0, 0.0]}}],
        "method": {"kind": "monte_carlo", "samples": 1},
    }


_STIFF = {"law": "elastic", "E": 1.0e4, "nu": 0.3, "unit_weight": 20.0}
_STRENGTH = {"c": 5.0, "phi": 20.0}
_CLAY = {"law": "soft_soil_creep", "lambda_star": 0.1, "kappa_star": 0.02, "mu_star": "mu_star", **_STRENGTH}
SECTION: dict[str, Any] = {
    "name": "warm",
    "forward_model": {
        "kind": "section",
        "surface": [[0, 4], [4, 4]],
        "layers": [{"name": "clay", "thickness": 2}, {"name": "sand", "thickness": 2}],
        "cuts": [{"name": "crack", "x": 2, "through": "clay"}],
        "points": {"A": {"x": 1}},
        "element_length": 2,
        "materials": {
            "stiff": _STIFF,
            "sand": {**_STIFF, "law": "mohr_coulomb", **_STRENGTH},
            "clay": {**_CLAY, "unit_weight": 18.0},
            "joint": {"law": "interface", "normal_stiffness": 1e5, "shear_stiffness": 1e4, **_STRENGTH},
        },
        "phases": [
            {"name": "weight", "kind": "gravity", "materials": {"clay": "stiff", "sand": "stiff", "crack": "joint"}},
            {"name": "strength", "kind": "plastic", "materials": {"sand": "sand"}},
            {
                **{"name": "creep", "kind": "creep", "duration": 10, "materials": {"clay": "clay"}},
                "loads": [{"boundary": "surface", "pressure": 10, "follows": True}],
                "updated_mesh": True,
            },
        ],
    },
    "parameters": {"mu_star": {"lower": 1.0e-4, "upper": 1.0e-2}},
    "observations": [{"series": "A.uy", "points": {"x": [1.0, 10.0], "y": [0.0, 0.0]}}],
    "method": {"kind": "monte_carlo", "samples": 1},
}
"""A body with every material and an interface, so that all kernels of the finite elements are compiled."""

SAMPLES: dict[str, dict[str, Any]] = {
    "oedometer": _sample({"kind": "oedometer", "height": 0.02, "initial_stress": 1.0}, "settlement"),
    "section": SECTION,
}
"""What has to run once so that all kernels of a group are compiled: element tests, finite elements."""

KERNELS = {"oedometer": 15, "section": 41}
"""About how many kernels each of them compiles."""

_ready: set[str] = set()  # groups that this process has run


def groups_of(spec: ForwardModelSpec) -> tuple[str, ...]:
    """Return the groups of kernels, keys of :data:`SAMPLES`, that a forward model needs."""
    if isinstance(spec, CombinedSpec):
        parts = {group for part in spec.parts.values() for group in groups_of(part)}
        return tuple(group for group in SAMPLES if group in parts)
    if spec.kind in ("section", "finite_element") or getattr(spec, "discretization", None) == "finite_element":
        return ("section",)
    return ("oedometer",) if spec.kind in ("oedometer", "isotropic_compression") else ()


def missing_kernels(spec: ForwardModelSpec) -> tuple[str, ...]:
    """Return the groups of kernels that a forward model needs and that have still to be compiled on this machine."""
    groups = [group for group in groups_of(spec) if group not in _ready]
    if not groups:
        return ()
    from numba.core import config  # slow to import, and a formula needs no kernels

    folder = settle()
    if config.DISABLE_JIT:  # type: ignore[attr-defined]  # Numba sets its options by name
        return ()
    return tuple(group for group in groups if not _is_compiled(folder, group))


def compile_kernels(problem: Problem, tell: Tell = lambda _compiled, _planned: None) -> float:
    """Compile what a problem needs, or wait until another process has done so; return the time it took [s]."""
    if not missing_kernels(problem.forward_model):
        return 0.0
    began = time.monotonic()
    with alone(settle()):
        missing = missing_kernels(problem.forward_model)
        planned = sum(KERNELS[group] for group in missing)
        with _counting(lambda compiled: tell(compiled, max(planned, compiled))):
            for group in missing:
                run_sample(group)
                note_compiled(group)
    return time.monotonic() - began


def run_sample(group: str) -> None:
    """Run a sample; afterwards the kernels of its group are in this process, compiled or from the cache."""
    problem = parse_problem(SAMPLES[group])
    run = problem.model.prepare({observation.series: observation.x for observation in problem.observations})
    run(problem.values([MATERIAL["mu_star"]["value"]]))
    _ready.add(group)


def note_compiled(group: str) -> None:
    """Note that a group of kernels is in the cache folder."""
    folder = settle()
    if folder is not None:
        _mark(folder, group).touch()


def load_kernels() -> None:
    """Load all groups of kernels that are in the cache folder."""
    folder = settle()
    for group in SAMPLES:
        if _is_compiled(folder, group):
            run_sample(group)


def warm(report: Callable[[str, float], None] | None = None) -> None:
    """Run every sample once.

    Parameters
    ----------
    report
        Is told the group of kernels and the wall time of its first run [s].
    """
    with alone(settle()):
        for group in SAMPLES:
            began = time.perf_counter()
            run_sample(group)
            note_compiled(group)
            if report is not None:
                report(group, time.perf_counter() - began)


def _is_compiled(folder: Path | None, group: str) -> bool:
    return folder is not None and _mark(folder, group).exists()


@cache
def _mark(folder: Path, group: str) -> Path:
    """The file that says that a group is compiled for these sources, this interpreter, Numba and processor."""
    import numba
    from numba.core.registry import cpu_target

    processor = cpu_target.target_context.codegen().magic_tuple()
    state = (fingerprint(), str(SOLVER), sys.implementation.cache_tag, numba.__version__, processor)
    return folder / f"compiled-{group}-{hashlib.sha256(repr(state).encode()).hexdigest()[:16]}"


@contextmanager
def _counting(tell: Callable[[int], object]) -> Iterator[None]:
    """Tell after each kernel compiled in the body how many there were."""
    from numba.core import event

    class Counter(event.Listener):
        compiled = 0

        def on_start(self, started: Any) -> None:
            """Nothing is done yet."""

        def on_end(self, ended: Any) -> None:
            """Count kernels of ours, not the functions of Numba that they call."""
            if ended.data["dispatcher"].py_func.__module__.startswith("geoswarm."):
                self.compiled += 1
                tell(self.compiled)

    with event.install_listener("numba:compile", Counter()):
        yield


def _main() -> None:
    logging.basicConfig(level=logging.INFO, format="geoswarm: %(message)s", stream=sys.stdout)
    logger.info("compiling the kernels for this machine (a moment the first time)")
    warm(lambda kind, seconds: logger.info("%s is ready (%.1f s)", kind, seconds))


if __name__ == "__main__":
    _main()
