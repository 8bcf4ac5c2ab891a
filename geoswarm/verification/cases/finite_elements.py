"""Finite elements: patch test, order of convergence, elastic and creeping bodies, large rotation."""

from __future__ import annotations

import math

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.soft_soil_creep.physics import soft_soil_creep
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.solve import Calculation, solve_phases
from geoswarm.solver.fem.triangle import shape_functions
from geoswarm.verification.case import Answer, Curve, Plot, case, check
from geoswarm.verification.exact.creep import Creep, cone
from geoswarm.verification.specimens.bodies import block, graded, moved, node_at
from geoswarm.verification.specimens.soils import creeping, elastic

__all__ = ["CASES"]

TIGHT, CLOSE = Control(tolerance=1.0e-13), Control(tolerance=1.0e-9)
ELASTIC = elastic(1.0e4, 0.3)
SHEAR = 1.0e4 / 2.6
LAME = 2.0 * SHEAR * 0.3 / 0.4


def _everywhere(mesh: Mesh, field: FloatArray) -> tuple[Fixity, ...]:
    """Prescribe a displacement field (n, 2) on the whole boundary."""
    nodes = np.unique(mesh.boundaries["around"])
    return (Fixity("around", x=field[nodes, 0], y=field[nodes, 1]),)


@case(
    "fem-patch",
    "Patch test",
    shows="A linear displacement field on the boundary of a distorted mesh of six-node triangles, plane strain.",
    given="E = 10 MPa, ν = 0.3; u = (0.01 x + 0.02 y, −0.005 x + 0.03 y)",
    source="Irons & Razzaque (1972); Zienkiewicz & Taylor, The Finite Element Method, patch test",
    reference="the linear field at every inner node, and Hooke's law at every stress point",
    allowed="rounding in the solution of the equations",
)
def patch() -> Answer:
    """Displacements of inner nodes."""
    mesh = block(graded(1.0, 3.0, 4), graded(0.0, 1.0, 3), distortion=0.3)
    gradient = np.array([[0.01, 0.02], [-0.005, 0.03]])
    field = mesh.nodes @ gradient.T
    phase = Phase("patch", materials={"soil": ELASTIC}, fixities=_everywhere(mesh, field))
    result = solve_phases(mesh, [phase], control=TIGHT)[0]
    strain = np.array([gradient[0, 0], gradient[1, 1], 0.0, gradient[0, 1] + gradient[1, 0]])
    stress = 2.0 * SHEAR * strain * [1.0, 1.0, 1.0, 0.5] + LAME * strain[:3].sum() * np.array([1.0, 1.0, 1.0, 0.0])
    inner = np.setdiff1d(np.arange(mesh.nodes.shape[0]), np.unique(mesh.boundaries["around"]))
    checks = (
        check("displacement", "m", result.displacements[inner], field[inner], 1.0e-11, scale=1.0, of="absolute"),
        check(
            "stress",
            "kPa",
            result.stress,
            np.broadcast_to(stress, result.stress.shape),
            1.0e-9,
            scale=1.0,
            of="absolute",
        ),
    )
    curves = []
    for axis, label in enumerate(("horizontal", "vertical")):
        order = np.argsort(field[inner, axis])
        wanted = 1000.0 * field[inner, axis][order]
        curves.append(Curve(label, wanted, 1000.0 * result.displacements[inner, axis][order], wanted[::3], wanted[::3]))
    plot = Plot("linear field at inner nodes [mm]", "displacement [mm]", tuple(curves))
    return Answer(checks, plot)


def _errors(cells: int) -> tuple[float, float]:
    """Errors in displacement and stress (L2) for the gradient of a harmonic function, which needs no weight."""
    mesh = block(graded(0.0, 1.0, cells), graded(0.0, 1.0, cells), distortion=0.2)

    def exact(x: FloatArray) -> FloatArray:
        return np.stack([np.exp(x[..., 0]) * np.cos(x[..., 1]), -np.exp(x[..., 0]) * np.sin(x[..., 1])], axis=-1)

    phase = Phase("rate", materials={"soil": ELASTIC}, fixities=_everywhere(mesh, exact(mesh.nodes)), load_step=1.0)
    result = solve_phases(mesh, [phase], control=TIGHT)[0]
    displacement, stress = 0.0, 0.0
    for xi, eta in np.random.default_rng(0).dirichlet((1.0, 1.0, 1.0), 12)[:, :2]:
        values, slopes = shape_functions(float(xi), float(eta))
        corners = mesh.nodes[mesh.triangles]
        own = result.displacements[mesh.triangles]
        at = np.einsum("n,enj->ej", values, corners)
        jacobian = np.einsum("in,enj->eij", slopes, corners)
        gradient = np.einsum("eij,ejk->eik", np.linalg.inv(jacobian), np.einsum("in,enj->eij", slopes, own))
        area = 0.5 * np.linalg.det(jacobian) / 12.0
        e = np.exp(at[:, 0])
        cosine, sine = e * np.cos(at[:, 1]), e * np.sin(at[:, 1])
        wanted = np.stack([np.stack([cosine, -sine], axis=-1), np.stack([-sine, -cosine], axis=-1)], axis=1)
        off = gradient - wanted
        trace = off[:, 0, 0] + off[:, 1, 1]
        sigma = SHEAR * (off + off.transpose(0, 2, 1)) + (LAME * trace)[:, np.newaxis, np.newaxis] * np.eye(2)
        displacement += float((area * ((np.einsum("n,enj->ej", values, own) - exact(at)) ** 2).sum(axis=1)).sum())
        stress += float((area * (sigma**2).sum(axis=(1, 2))).sum())
    return float(np.sqrt(displacement)), float(np.sqrt(stress))


@case(
    "fem-convergence",
    "Order of convergence of the six-node triangle",
    shows="A smooth elastic field on distorted meshes of 4 × 4 to 16 × 16 cells: errors over the size of the cells.",
    given="E = 10 MPa, ν = 0.3; u = (eˣ cos y, −eˣ sin y) on the unit square",
    source="Strang & Fix (1973): elements of degree 2",
    reference="errors decrease with the third power of the cell size (displacement) and with the second (stress)",
    allowed="the order between the two finest meshes is not yet that of the limit",
)
def convergence() -> Answer:
    """Errors over cell size."""
    counts = np.array([4, 8, 16])
    errors = np.array([_errors(int(count)) for count in counts])
    size = 1.0 / counts
    orders = np.log2(errors[1] / errors[2])
    checks = (
        check("order in displacement", "", orders[0], 3.0, 0.2, scale=1.0, of="absolute"),
        check("order in stress", "", orders[1], 2.0, 0.15, scale=1.0, of="absolute"),
    )
    scaled = errors / errors[0]
    curves = tuple(
        Curve(label, size, scaled[:, i], size, (size / size[0]) ** power)
        for i, (label, power) in enumerate((("displacement", 3), ("stress", 2)))
    )
    plot = Plot("size of cells [-]", "error over that of the coarsest mesh [-]", curves, log_x=True, log_y=True)
    return Answer(checks, plot)


@case(
    "fem-thick-cylinder",
    "Thick cylinder under internal pressure",
    shows="A quarter of a ring of radii 1 and 2 m under 100 kPa in plane strain: displacement over the radius.",
    given="a = 1 m, b = 2 m, p = 100 kPa, E = 10 MPa, ν = 0.3",
    source="Lamé (1852); Timoshenko & Goodier, Theory of Elasticity",
    reference="u(r) = (1 + ν) p a²/(E (b² − a²)) ((1 − 2ν) r + b²/r);  u(a) = 19.067 mm, u(b) = 12.133 mm",
    allowed="errors of the mesh, 1e-4",
)
def cylinder() -> Answer:
    """Radial displacement."""

    def bend(nodes: FloatArray) -> FloatArray:
        return np.column_stack([nodes[:, 0] * np.cos(nodes[:, 1]), nodes[:, 0] * np.sin(nodes[:, 1])])

    mesh = moved(block(graded(1.0, 2.0, 12), graded(0.0, math.pi / 2, 20)), bend)
    phase = Phase(
        "pressure",
        materials={"soil": ELASTIC},
        fixities=(Fixity("bottom", y=0.0), Fixity("top", x=0.0)),
        tractions=(Traction("left", normal=-100.0),),
    )
    result = solve_phases(mesh, [phase], control=CLOSE)[0]
    radius, found = np.hypot(*mesh.nodes.T), 1000.0 * np.hypot(*result.displacements.T)
    exact = 1000.0 * 1.3 * 100.0 / (1.0e4 * 3.0) * (0.4 * radius + 4.0 / radius)
    order = np.argsort(radius)[:: max(radius.size // 60, 1)]
    marks = order[:: max(order.size // 12, 1)]
    curve = Curve("", radius[order], found[order], radius[marks], exact[marks])
    plot = Plot("radius [m]", "radial displacement [mm]", (curve,))
    return Answer((check("radial displacement", "mm", found, exact, 1.0e-4),), plot)


@case(
    "fem-creep-oedometer",
    "Creeping specimen of two triangles",
    shows="The oedometer test with loads in steps (chapter Soft soil creep), axisymmetric with two triangles.",
    given=(
        "λ* = 0.1, κ* = 0.02, μ* = 0.005, c = 0, φ = 30°, K0nc = 0.5, OCR 1.3 at 50 kPa; 100, 200 and 400 "
        "kPa for a day each"
    ),
    source="Vermeer & Neher (1999): rate equations, integrated by SciPy's implicit Runge-Kutta method (Radau)",
    reference="the same integration as for the material point",
    allowed="time integration error, 1e-5 of strain",
)
def creeping_specimen() -> Answer:
    """Axial strain over time."""
    mesh = block(np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    soil = creeping(soft_soil_creep(0.10, 0.02, 0.005, 0.0, 30.0, K0nc=0.5), OCR=1.3)
    sides = (Fixity("left", x=0.0), Fixity("bottom", y=0.0), Fixity("right", x=0.0))
    start = np.array([-25.0, -50.0, -25.0, 0.0])
    rest = Phase(
        "start",
        "K0",
        materials={"soil": soil},
        initial_stress=lambda x: np.tile(start, (x.shape[0], 1)),
        fixities=sides,
    )
    times = np.geomspace(1.0e-3, 1.0, 7)
    loads = (100.0, 200.0, 400.0)
    phases = [
        Phase(
            f"{load:g} kPa",
            "creep",
            duration=1.0,
            tractions=(Traction("top", normal=-load),),
            output_times=tuple(times.tolist()),
            load_step=0.25,
        )
        for load in loads
    ]
    control = Control(tolerance=1.0e-8, time_tolerance=2.0e-6)
    results = solve_phases(
        mesh, [rest, *phases], geometry="axisymmetric", observe=[node_at(mesh, 0.0, 1.0)], control=control
    )
    ours = np.concatenate([-result.history.displacements[-times.size :, 0, 1] for result in results[1:]])
    point = Creep(0.1, 0.02, 0.005, 0.0, 30.0, cone(0.5, 0.15, 5.0))
    exact = np.concatenate([one[0] for one in point.oedometer((25.0, 50.0), 1.3, [(load, times) for load in loads])])
    since = np.concatenate([number + times for number in range(3)])
    plot = Plot(
        "time [day]", "axial strain [%]", (Curve("", since, 100 * ours, since[::2], 100 * exact[::2]),), downwards=True
    )
    return Answer((check("axial strain", "", ours, exact, 2.0e-5, scale=1.0, of="absolute"),), plot)


@case(
    "fem-jaumann",
    "Large simple shear of an elastic body",
    shows="Updated mesh, Poisson's ratio 0.3, shear to γ = 2 in 40 steps: stresses turn with the body.",
    given="G = 1 MPa, ν = 0.3",
    source="Dienes (1979), On the analysis of rotation and stress rate in deforming bodies",
    reference="Jaumann's rate: τ = G sin γ,  σ_x = G (1 − cos γ)",
    allowed="steps of 0.05 in γ; their error is proportional to the square of the step",
)
def jaumann() -> Answer:
    """Stresses over shear."""
    mesh = block(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0]))
    calculation = Calculation(mesh, control=CLOSE)
    materials, found = {"soil": elastic(2.6e3, 0.3)}, []
    gamma = np.linspace(0.2, 2.0, 10)
    for number in range(gamma.size):
        change = np.column_stack([0.2 * mesh.nodes[:, 1], 0.0 * mesh.nodes[:, 0]])
        phase = Phase(
            f"shear {number}",
            materials=materials if number == 0 else {},
            fixities=_everywhere(mesh, change),
            updated_mesh=True,
            load_step=0.25,
            largest_load_step=0.25,
        )
        found.append(calculation.run(phase).stress[0, 0])
    stress = np.array(found)
    tau, normal = 1.0e3 * np.sin(gamma), 1.0e3 * (1.0 - np.cos(gamma))
    checks = (
        check("shear stress", "kPa", stress[:, 3], tau, 1.0e-3, scale=1.0e3, of="G"),
        check("normal stress", "kPa", stress[:, 0], normal, 1.0e-3, scale=1.0e3, of="G"),
    )
    curves = (
        Curve("shear stress", gamma, stress[:, 3], gamma, tau),
        Curve("normal stress", gamma, stress[:, 0], gamma, normal),
    )
    return Answer(checks, Plot("shear γ [-]", "stress [kPa]", curves))


CASES = (patch, convergence, cylinder, creeping_specimen, jaumann)
