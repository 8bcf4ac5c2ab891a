"""Time of finite elements on one core: solvers of sparse equations, a plastic slope, its growth, creep.

Run: ``python -m benchmarks.finite_elements``. Prints processor time, the least of some repeats, without compilation.
"""

from __future__ import annotations

import math
import platform
import time
from collections.abc import Callable

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.soft_soil_creep.physics import soft_soil_creep
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.multifrontal import equations_of, factorise, solve_factorised
from geoswarm.solver.fem.phases import Fixity, Phase, Traction
from geoswarm.solver.fem.results import PhaseResult
from geoswarm.solver.fem.setup import elements_of, fronts_of
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.verification.specimens.bodies import block, slope
from geoswarm.verification.specimens.soils import creeping, mohr_coulomb

HELD = (Fixity("left", x=0.0), Fixity("right", x=0.0), Fixity("bottom", x=0.0, y=0.0))
SOIL = mohr_coulomb(1.0e5, 0.3, 10.0, 20.0, tension_cutoff=None, unit_weight=20.0)
YEARS = 33


def least_ms(call: Callable[[], object], repeats: int) -> float:
    """Least processor time of a call, ms, after one call that is not counted."""
    call()
    seconds = []
    for _ in range(repeats):
        start = time.process_time()
        call()
        seconds.append(time.process_time() - start)
    return 1.0e3 * min(seconds)


def stiffness(mesh: Mesh) -> tuple[csc_matrix, FloatArray]:
    """A non-symmetric matrix with the pattern of the mesh, sparse and element by element."""
    random = np.random.default_rng(1)
    elements = elements_of(mesh)
    tangents = random.standard_normal((elements.shape[0], 12, 12))
    tangents = tangents @ tangents.transpose(0, 2, 1) + 0.3 * random.standard_normal(tangents.shape) + 3.0 * np.eye(12)
    dofs = np.stack([2 * elements, 2 * elements + 1], axis=2).reshape(-1, 12)
    rows, columns = np.repeat(dofs, 12, axis=1).ravel(), np.tile(dofs, 12).ravel()
    return csc_matrix((tangents.ravel(), (rows, columns))), tangents


def solvers(mesh: Mesh) -> None:
    """Compare factorisations of one matrix."""
    plan = fronts_of(mesh)
    equations = equations_of(plan)
    matrix, equations.tangents[:] = stiffness(mesh)
    free = np.zeros(mesh.nodes.size, dtype=np.bool_)
    order = np.concatenate(
        [plan.rows[start : start + count] for start, count in zip(plan.start[:-1], plan.pivots, strict=True)]
    )
    ordered = csc_matrix(matrix[order][:, order])
    symmetric = {"SymmetricMode": True}
    x = np.ones(mesh.nodes.size)
    print(f"{mesh.triangles.shape[0]} triangles, {mesh.nodes.size} unknowns, {matrix.nnz} entries; one factorisation:")
    print(f"  fronts                            {least_ms(lambda: factorise(plan, equations, free), 20):8.1f} ms")
    print(f"  fronts, one solution              {least_ms(lambda: solve_factorised(plan, equations, x), 20):8.1f} ms")
    print(f"  SuperLU, default                  {least_ms(lambda: splu(matrix), 3):8.1f} ms")
    by_degree = least_ms(
        lambda: splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=1.0e-3, options=symmetric), 3
    )
    print(f"  SuperLU, MMD_AT_PLUS_A, symmetric {by_degree:8.1f} ms")
    by_order = least_ms(lambda: splu(ordered, permc_spec="NATURAL", diag_pivot_thresh=1.0e-3, options=symmetric), 3)
    print(f"  SuperLU, our order, symmetric     {by_order:8.1f} ms")


def weight(mesh: Mesh) -> tuple[float, int, float]:
    """Processor time, ms, iterations and largest displacement of the plastic slope under its weight in 20 steps."""
    phase = Phase("weight", "gravity", {"soil": SOIL}, fixities=HELD, load_step=0.05, largest_load_step=0.05)
    results: list[PhaseResult] = []
    spent = least_ms(lambda: results.extend(solve_phases(mesh, [phase])), 3)
    return spent, results[-1].iterations, float(np.hypot(*results[-1].displacements.T).max())


def growth() -> None:
    """The plastic slope on finer and finer meshes."""
    print("slope 2:1, Mohr-Coulomb, weight in 20 steps:")
    known: list[tuple[int, float]] = []
    for factor in (1, 2, 4):
        mesh = slope(20.0, 20.0, 10.0, (13 * factor, 13 * factor, 12 * factor), 14 * factor)
        spent, iterations, largest = weight(mesh)
        known.append((mesh.triangles.shape[0], spent))
        print(f"  {mesh.triangles.shape[0]:6d} triangles {spent:9.0f} ms  {iterations:4d} iterations  {largest:.7f} m")
    (few, short), (many, long) = known[0], known[-1]
    print(f"  time grows with the power {math.log(long / short) / math.log(many / few):.2f} of the triangles")


def creep() -> None:
    """Two triangles in an oedometer of 16 stages; a slope that creeps for 33 years on an updated mesh."""
    soil = soft_soil_creep(0.05, 0.01, 0.002, 10.0, 22.0)
    specimen = block(np.array([0.0, 0.025]), np.array([0.0, 0.02]))
    sides = (Fixity("left", x=0.0), Fixity("right", x=0.0), Fixity("bottom", y=0.0))
    stages = [Phase("start", "K0", {"soil": creeping(soil)}, fixities=sides, surcharge=5.0)]
    for number in range(16):
        load = (Traction("top", normal=-10.0 * 1.3**number),)
        stages.append(Phase(f"{number}", "creep", tractions=load, duration=1.0, output_times=(0.0, 0.1, 0.5, 1.0)))
    spent = least_ms(lambda: solve_phases(specimen, stages, geometry="axisymmetric"), 10)
    print(f"oedometer, two triangles, 16 stages: {spent:.1f} ms")
    mesh = slope(20.0, 20.0, 10.0, (13, 13, 12), 14)
    days = 365.0 * YEARS
    phases = [
        Phase("weight", "gravity", {"soil": mohr_coulomb(1.0e4, 0.35, 10.0, 22.0, unit_weight=20.0)}, fixities=HELD),
        Phase(
            "creep",
            "creep",
            {"soil": creeping(soil, 20.0)},
            duration=days,
            updated_mesh=True,
            output_times=tuple(np.linspace(0.0, days, YEARS + 1)),
        ),
    ]
    spent = least_ms(lambda: solve_phases(mesh, phases), 2)
    print(f"slope, {mesh.triangles.shape[0]} triangles, {YEARS} years of creep, updated mesh: {spent:.0f} ms")


def main() -> None:
    """Print all measurements."""
    print(f"Python {platform.python_version()}, NumPy {np.__version__}, {platform.machine()}")
    for factor in (1, 4):
        solvers(slope(20.0, 20.0, 10.0, (13 * factor, 13 * factor, 12 * factor), 14 * factor))
    growth()
    creep()


if __name__ == "__main__":
    main()
