"""Compile the numerical kernels ahead of the first calibration: ``python -m geoswarm.solver.warm``.

Numba caches what it compiles, see :mod:`geoswarm.solver.kernels.cache`. So each installation pays once, at set-up or
when its image is built, or else before the first calibration; every process after that starts warm. An empty file in
the cache folder says that a group of kernels is compiled; its name depends on all that would have it compiled again.
"""

from __future__ import annotations

import hashlib
import inspect
import logging
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.solver.kernels.cache import SOLVER, alone, fingerprint, settle
from geoswarm.solver.laws.registry import BUILT_IN, USER_LAWS, find_law, installed_laws, user_update
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.system.processes import without_garbage_collection

__all__ = [
    "GROUPS",
    "SAMPLES",
    "Tell",
    "compile_for",
    "compile_kernels",
    "groups_of",
    "missing_groups",
    "missing_kernels",
    "note_compiled",
    "run_sample",
    "warm",
]

logger = logging.getLogger(__name__)

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law

Tell: TypeAlias = Callable[[int, int], object]
"""Is told before and after each group of kernels how many are compiled, of how many that were missing."""

MATERIAL: dict[str, Any] = {
    "lambda_star": {"value": 0.1},
    "kappa_star": {"value": 0.02},
    "mu_star": {"value": 1.0e-3},
    "c": {"value": 5.0},
    "phi": {"value": 20.0},
    "psi": {"value": 0.0},
}
OTHER_LAWS = "other_laws"
_VALUES = {"element_test": 1.0e4, "consolidation": 1.0e4}
STAGES: list[dict[str, float]] = [{"stress": 50.0, "duration": 1.0}, {"stress": 20.0, "duration": 1.0}]


def _sample(forward_model: dict[str, Any], series: str) -> dict[str, Any]:
    """Build a problem around one forward model; nothing of it is calibrated, the free parameter only makes it whole."""
    return {
        "name": "warm",
        "forward_model": {"material": "soft_soil_creep", "stages": STAGES, **forward_model},
        "parameters": {**MATERIAL, "mu_star": {"lower": 1.0e-4, "upper": 1.0e-2}},
        "observations": [{"series": series, "points": {"x": [1.0, 2.0], "y": [0.0, 0.0]}}],
        "method": {"kind": "monte_carlo", "samples": 1},
    }


_STIFF = {"law": "elastic", "E": "1e7 * mu_star", "nu": 0.3, "unit_weight": 20.0}
_STRENGTH = {"c": 5.0, "phi": 20.0}
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
            "joint": {"law": "interface", "normal_stiffness": 1e5, "shear_stiffness": 1e4, **_STRENGTH},
        },
        "phases": [
            {"name": "weight", "kind": "gravity", "materials": {"clay": "stiff", "sand": "stiff", "crack": "joint"}},
            {
                **{"name": "creep", "kind": "creep", "duration": 10},
                "loads": [{"boundary": "surface", "pressure": 10, "follows": True}],
                "updated_mesh": True,
            },
        ],
    },
    "parameters": {"mu_star": {"lower": 1.0e-4, "upper": 1.0e-2}},
    "observations": [{"series": "A.uy", "points": {"x": [1.0, 10.0], "y": [0.0, 0.0]}}],
    "method": {"kind": "monte_carlo", "samples": 1},
}
"""A body of the least law with an interface: all kernels of the finite elements are compiled, whatever the laws."""

_OEDOMETER = _sample({"kind": "oedometer", "height": 0.02, "initial_stress": 1.0}, "settlement")
_ELASTIC = _sample(
    {"kind": "oedometer", "height": 0.02, "initial_stress": 1.0, "material": "elastic"}, "settlement"
) | {"parameters": {"E": {"lower": 1.0e2, "upper": 1.0e5}, "nu": {"value": 0.3}}}
_CONSOLIDATION = {
    **_ELASTIC,
    "forward_model": {
        **{"kind": "crs_oedometer", "material": "elastic", "height": 0.02, "initial_stress": 10.0},
        "stages": [{"kind": "monotonic", "axial_strain": 0.01, "duration": 1.0}],
    },
    "parameters": {**_ELASTIC["parameters"], "k": {"value": 1.0e-3}},
    "observations": [{"series": "axial_stress", "points": {"x": [0.0, 0.01], "y": [0.0, 0.0]}}],
}
SAMPLES: dict[str, dict[str, Any]] = {
    "oedometer": _OEDOMETER,
    "section": SECTION,
    "element_test": _ELASTIC,
    "consolidation": _CONSOLIDATION,
}
"""What has to run once so that all kernels of a group are compiled: the fast path of soft soil creep, finite elements,
laboratory tests on any law, and consolidating columns of any law."""

GROUPS = (*SAMPLES, *BUILT_IN, *USER_LAWS, OTHER_LAWS)
"""What is compiled by itself: the samples, each law, what calls laws of libraries, and the laws of other packages."""

_SECONDS = {
    "oedometer": 3,
    "section": 9,
    "element_test": 4,
    "consolidation": 6,
    "drucker_prager": 6,
    "hardening_soil": 8,
    "hardening_soil_small": 4,
    "hypoplastic_clay": 7,
    "mohr_coulomb": 4,
    "soft_soil_creep": 7,
}
"""About how long it takes to compile a group; others but a second."""

_AFTER = {
    "hardening_soil_small": "hardening_soil",
    "hypoplastic_sand": "hypoplastic_clay",
    "matsuoka_nakai": "drucker_prager",
    "soft_soil": "soft_soil_creep",
}
"""Laws with the kernels of another, which has them compiled first."""

_SOURCES = {
    "oedometer": "element_test/constant_load.py",
    "section": "fem/solve.py",
    "element_test": "element_test/load_paths.py",
    "consolidation": "element_test/column_steps.py",
}
"""Where the kernels of the samples begin; below solver."""

_ready: set[str] = set()  # groups that this process has run


def groups_of(spec: ForwardModelSpec) -> tuple[str, ...]:
    """Return the groups of kernels that a forward model needs, in the order of :data:`GROUPS`."""
    wanted = {kernels if kernels in GROUPS else OTHER_LAWS for kernels in spec.kernels}
    return tuple(group for group in GROUPS if group in wanted)


def missing_kernels(spec: ForwardModelSpec) -> tuple[str, ...]:
    """Return the groups of kernels that a forward model needs and that have still to be compiled on this machine."""
    groups = [group for group in groups_of(spec) if group not in _ready]
    if not groups:
        return ()
    if _plain_python():
        return ()
    folder = settle()
    return tuple(group for group in groups if not _is_compiled(folder, group))


def missing_groups() -> tuple[str, ...]:
    """Return all groups of kernels that have still to be compiled on this machine, in the order of :data:`GROUPS`."""
    if _plain_python():
        return ()
    folder = settle()
    return tuple(group for group in GROUPS if not _is_compiled(folder, group))


def _plain_python() -> bool:
    """Whether kernels are not to be compiled at all (NUMBA_DISABLE_JIT)."""
    from numba.core import config  # slow to import, and a formula needs no kernels

    return bool(config.DISABLE_JIT)  # type: ignore[attr-defined]  # Numba sets its options by name


def compile_kernels(problem: Problem, tell: Tell = lambda _compiled, _missing: None) -> float:
    """Compile what a problem needs, or wait until another process has done so; return the time it took [s]."""
    return compile_for(problem.forward_model, tell)


def compile_for(spec: ForwardModelSpec, tell: Tell = lambda _compiled, _missing: None) -> float:
    """Compile what a forward model needs; see :func:`compile_kernels`."""
    if not missing_kernels(spec):
        return 0.0
    began = time.monotonic()
    with alone(settle()):
        missing = missing_kernels(spec)
        for compiled, group in enumerate(missing):
            tell(compiled, len(missing))
            run_sample(group)
            note_compiled(group)
        tell(len(missing), len(missing))
    return time.monotonic() - began


def run_sample(group: str) -> None:
    """Run a sample, or load laws; then the kernels of the group are in this process, compiled or from the cache."""
    with without_garbage_collection():
        if group in SAMPLES:
            problem = parse_problem(SAMPLES[group])
            run = problem.model.prepare({observation.series: observation.x for observation in problem.observations})
            run(problem.values([_VALUES.get(group, MATERIAL["mu_star"]["value"])]))
        elif group in USER_LAWS:
            _ = user_update(group).address
        else:
            for law in _laws_of(group):
                _ = law.update.address
    _ready.add(group)


def _laws_of(group: str) -> tuple[Law, ...]:
    """The law of a group, or those of other packages."""
    if group in BUILT_IN:
        return (find_law(group),)
    return tuple(law for law in installed_laws() if law.kind not in BUILT_IN)


def note_compiled(group: str) -> None:
    """Note that a group of kernels is in the cache folder."""
    folder = settle()
    if folder is not None:
        _mark(folder, group).touch()


def warm(report: Callable[[str, float], None] | None = None) -> None:
    """Have every group compiled, several at once by processes of their own.

    As plain Python (NUMBA_DISABLE_JIT) there is nothing to compile, and laws cannot be called by their address.

    Parameters
    ----------
    report
        Called with the group of kernels and the wall time until it was there [s].
    """
    if _plain_python():
        return
    folder = settle()
    began = time.perf_counter()
    ready = set()

    def done(group: str) -> None:
        note_compiled(group)
        ready.add(group)
        if report is not None:
            report(group, time.perf_counter() - began)

    with alone(folder):
        missing = []
        for group in GROUPS:
            if _is_compiled(folder, group):
                done(group)
            else:
                missing.append(group)
        first = [group for group in missing if _AFTER.get(group) not in missing]
        own, *others = _shares(first, 1 if folder is None else os.cpu_count() or 1)
        helpers = [(share, _compile_apart(share)) for share in others if share]
        for group in own:
            run_sample(group)
            done(group)
        for share, helper in helpers:
            if helper.wait() == 0:
                for group in share:
                    done(group)
        for group in missing:
            if group not in ready:  # it comes after another, or a helper has failed
                run_sample(group)
                done(group)


def _shares(groups: list[str], count: int) -> list[list[str]]:
    """Divide groups among processes so that these end at about the same time; the largest share is the first."""

    def seconds(share: Iterable[str]) -> int:
        return sum(_SECONDS.get(group, 1) for group in share)

    shares: list[list[str]] = [[] for _ in range(count)]
    for group in sorted(groups, key=lambda group: -seconds([group])):
        min(shares, key=seconds).append(group)
    return sorted(shares, key=seconds, reverse=True)


def _compile_apart(groups: list[str]) -> subprocess.Popen[bytes]:
    """Begin to compile groups in another process, which looks for the sources where this one does.

    Numba keeps kernels by the folder of their sources: those of another copy would be compiled again when needed.
    """
    words = f"import sys\nsys.path[:] = {sys.path!r}\nfrom geoswarm.solver.warm import run_sample\n"
    words += f"for group in {groups!r}: run_sample(group)"
    nowhere = subprocess.DEVNULL
    return subprocess.Popen([sys.executable, "-c", words], stdin=nowhere, stdout=nowhere, stderr=nowhere)


def _is_compiled(folder: Path | None, group: str) -> bool:
    return folder is not None and _mark(folder, group).exists()


@cache
def _mark(folder: Path, group: str) -> Path:
    """The file that says that a group is compiled for these sources, this interpreter, Numba and processor."""
    import numba
    from numba.core.registry import cpu_target

    processor = cpu_target.target_context.codegen().magic_tuple()
    state = (_fingerprint_of(group), str(SOLVER), sys.implementation.cache_tag, numba.__version__, processor)
    return folder / f"compiled-{group}-{hashlib.sha256(repr(state).encode()).hexdigest()[:16]}"


def _fingerprint_of(group: str) -> tuple[str, ...]:
    """What changes with the sources of a group."""
    if group in _SOURCES:
        return (fingerprint(SOLVER / _SOURCES[group]),)
    if group in USER_LAWS:
        module = USER_LAWS[group].partition(":")[0].removeprefix("geoswarm.solver.")
        return (fingerprint(SOLVER / f"{module.replace('.', '/')}.py"),)
    return tuple(fingerprint(Path(inspect.getfile(type(law)))) for law in _laws_of(group))


def _main() -> None:
    logging.basicConfig(level=logging.INFO, format="geoswarm: %(message)s", stream=sys.stdout)
    logger.info("compiling the kernels for this machine (a moment the first time)")
    warm(lambda kind, seconds: logger.info("%s is ready (%.1f s)", kind, seconds))


if __name__ == "__main__":
    _main()
