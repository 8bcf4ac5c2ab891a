"""The plastic slope beside OpenGeoSys on the same mesh, in turns on the same core.

Run: ``python -m benchmarks.finite_elements_peer [FOLDER]``. OpenGeoSys is installed with pip into a virtual environment
in the folder (a temporary one unless given) and nowhere else; where it cannot be installed the program says so and
ends. Prints processor time of both for the solution alone, that is without start, reading and compilation.

Six-node triangles with three points, Mohr-Coulomb (c 10 kPa, phi 20, psi 0 degree), 20 equal steps of the weight. The
peer's law is the one of Abbo and Sloan, whose corners are rounded, so its displacement differs in the third digit.
"""

from __future__ import annotations

import math
import os
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path

import meshio
import numpy as np

from benchmarks.finite_elements import weight
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.verification.specimens.bodies import slope

STEPS = 20
ROUNDS = 3
CONSTANTS = {
    "YoungModulus": 1.0e5,
    "PoissonRatio": 0.3,
    "Cohesion": 10.0,
    "FrictionAngle": 20.0,
    "DilatancyAngle": 0.0,
    "TransitionAngle": 25.0,
    "TensionCutOffParameter": 1.0,
    "nothing": 0.0,
}
HELD = (("left", 0), ("right", 0), ("bottom", 0), ("bottom", 1))


def installed(folder: Path) -> Path | None:
    """The peer's program in a virtual environment below the folder; None where it cannot be had."""
    home = folder / "venv"
    program = home / "bin" / "ogs"
    if not program.exists():
        venv.create(home, with_pip=True)
        done = subprocess.run([home / "bin" / "pip", "install", "-q", "ogs"], capture_output=True, text=True)
        if done.returncode != 0 or not program.exists():
            print(f"OpenGeoSys cannot be installed, nothing is compared: {done.stderr.strip().splitlines()[-1:]}")
            return None
    return program


def write_meshes(folder: Path, mesh: Mesh) -> None:
    """The domain and the held boundaries, as the peer reads them."""
    flat = np.column_stack([mesh.nodes, np.zeros(mesh.nodes.shape[0])])
    triangles = mesh.triangles.astype(np.int64)
    domain = meshio.Mesh(
        flat, [("triangle6", triangles)], cell_data={"MaterialIDs": [np.zeros(len(triangles), dtype=np.int32)]}
    )
    domain.write(folder / "domain.vtu", file_format="vtu", binary=False)
    for name in ("left", "right", "bottom"):
        edges = mesh.boundaries[name]
        nodes, numbers = np.unique(edges, return_inverse=True)
        part = meshio.Mesh(
            flat[nodes],
            [("line3", numbers.reshape(edges.shape))],
            point_data={"bulk_node_ids": nodes.astype(np.uint64)},
            cell_data={"bulk_element_ids": [np.zeros(len(edges), dtype=np.uint64)]},
        )
        part.write(folder / f"{name}.vtu", file_format="vtu", binary=False)


def project() -> str:
    """The peer's input: weight by a density that grows with time."""
    law = "".join(f'<material_property name="{name}" parameter="{name}"/>' for name in CONSTANTS if name != "nothing")
    numbers = "".join(
        f"<parameter><name>{name}</name><type>Constant</type><value>{value}</value></parameter>"
        for name, value in CONSTANTS.items()
    )
    held = "".join(
        f"<boundary_condition><mesh>{name}</mesh><type>Dirichlet</type><component>{axis}</component>"
        "<parameter>nothing</parameter></boundary_condition>"
        for name, axis in HELD
    )
    return f"""<?xml version="1.0" encoding="ISO-8859-1"?>
<OpenGeoSysProject>
<meshes><mesh>domain.vtu</mesh><mesh>left.vtu</mesh><mesh>right.vtu</mesh><mesh>bottom.vtu</mesh></meshes>
<processes><process><name>SD</name><type>SMALL_DEFORMATION</type><integration_order>2</integration_order>
<constitutive_relation><type>MFront</type><behaviour>MohrCoulombAbboSloan</behaviour>
<material_properties>{law}</material_properties></constitutive_relation>
<specific_body_force>0 -1</specific_body_force>
<process_variables><process_variable>displacement</process_variable></process_variables>
</process></processes>
<time_loop><processes><process ref="SD"><nonlinear_solver>newton</nonlinear_solver>
<convergence_criterion><type>DeltaX</type><norm_type>NORM2</norm_type><reltol>1e-6</reltol></convergence_criterion>
<time_discretization><type>BackwardEuler</type></time_discretization>
<time_stepping><type>FixedTimeStepping</type><t_initial>0</t_initial><t_end>1</t_end>
<timesteps><pair><repeat>{STEPS}</repeat><delta_t>{1.0 / STEPS}</delta_t></pair></timesteps></time_stepping>
</process></processes>
<output><type>VTK</type><prefix>result</prefix><suffix>_{{:timestep}}</suffix>
<timesteps><pair><repeat>1</repeat><each_steps>{STEPS}</each_steps></pair></timesteps>
<variables><variable>displacement</variable></variables></output></time_loop>
<media><medium><phases><phase><type>Solid</type><properties><property><name>density</name><type>Parameter</type>
<parameter_name>density</parameter_name></property></properties></phase></phases></medium></media>
<parameters>{numbers}
<parameter><name>density</name><type>Function</type><expression>20 * t</expression></parameter>
<parameter><name>start</name><type>Constant</type><values>0 0</values></parameter></parameters>
<process_variables><process_variable><name>displacement</name><components>2</components><order>2</order>
<initial_condition>start</initial_condition><boundary_conditions>{held}</boundary_conditions>
</process_variable></process_variables>
<nonlinear_solvers><nonlinear_solver><name>newton</name><type>Newton</type><max_iter>50</max_iter>
<linear_solver>direct</linear_solver></nonlinear_solver></nonlinear_solvers>
<linear_solvers><linear_solver><name>direct</name><eigen><solver_type>SparseLU</solver_type></eigen>
</linear_solver></linear_solvers>
</OpenGeoSysProject>
"""


def peer(program: Path, folder: Path) -> tuple[float, float, int, float]:
    """Processor time of the process and of its time steps, s; iterations; largest displacement, m."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(
        [program, "-o", folder, folder / "slope.prj"],
        capture_output=True,
        text=True,
        env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
    )
    after, whole = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter() - began
    if done.returncode != 0:
        raise SystemExit(f"OpenGeoSys failed:\n{done.stdout[-2000:]}\n{done.stderr[-1000:]}")
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    steps = [float(found) for found in re.findall(r"Time step #\d+ took ([0-9.eE+-]+) s", done.stdout)]
    iterations = len(re.findall(r"Iteration #\d+ took", done.stdout))
    result = meshio.read(folder / f"result_{STEPS}.vtu")
    largest = float(np.hypot(*result.point_data["displacement"].T[:2]).max())
    return spent, spent * sum(steps) / whole, iterations, largest


def main() -> None:
    """Print the comparison."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(sys.argv[1] if len(sys.argv) > 1 else temporary)
        folder.mkdir(parents=True, exist_ok=True)
        program = installed(folder)
        if program is None:
            return
        mesh = slope(20.0, 20.0, 10.0, (13, 13, 12), 14)
        write_meshes(folder, mesh)
        (folder / "slope.prj").write_text(project(), encoding="ascii")
        weight(mesh)
        ours, theirs, processes = [], [], []
        for _ in range(ROUNDS):
            spent, iterations, largest = weight(mesh)
            ours.append(1.0e-3 * spent)
            process, solution, their_iterations, their_largest = peer(program, folder)
            theirs.append(solution)
            processes.append(process)
        print(
            f"slope 2:1, {mesh.triangles.shape[0]} triangles, Mohr-Coulomb, weight in {STEPS} steps, {ROUNDS} rounds:"
        )
        print(f"  geoswarm    solution {statistics.median(ours):6.2f} s  {iterations:4d} iterations  {largest:.7f} m")
        print(
            f"  OpenGeoSys  solution {statistics.median(theirs):6.2f} s  {their_iterations:4d} iterations  "
            f"{their_largest:.7f} m  (process {statistics.median(processes):.2f} s)"
        )
        ratios = [their / our for their, our in zip(theirs, ours, strict=True)]
        print(f"  ratio {statistics.median(ratios):.1f} (rounds {min(ratios):.1f} to {max(ratios):.1f})")
        if not math.isclose(largest, their_largest, rel_tol=0.01):
            print("  the displacements differ by more than 1 %: the two did not solve the same problem")


if __name__ == "__main__":
    main()
