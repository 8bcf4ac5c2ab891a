"""Finite elements at the limit: tube, footing, slopes, sliding block."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from geoswarm.solver.errors import DivergedError
from geoswarm.solver.fem.materials import InterfaceMaterial, Material
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.results import PhaseResult
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.verification.case import Answer, Curve, Plot, case, check
from geoswarm.verification.specimens.bodies import block, embankment, graded, stacked
from geoswarm.verification.specimens.infinite_slopes import InfiniteSlope
from geoswarm.verification.specimens.soils import elastic, mohr_coulomb

__all__ = ["CASES"]

SIDES = (Fixity("left", x=0.0), Fixity("right", x=0.0), Fixity("bottom", x=0.0, y=0.0))
C, E, NU = 50.0, 1.0e4, 0.3


def _widened(material: Material, widening: float) -> tuple[float, PhaseResult]:
    """Pressure that a widening of the inside of a tube of radii 1 and 2 m needs, and the state."""
    mesh = block(graded(1.0, 2.0, 24), np.array([0.0, 0.1]))
    phase = Phase(
        "widening",
        materials={"soil": material},
        fixities=(Fixity("bottom", y=0.0), Fixity("top", y=0.0), Fixity("left", x=widening)),
        load_step=0.05,
        largest_load_step=0.05,
    )
    result = solve_phases(mesh, [phase], geometry="axisymmetric", control=Control(tolerance=1.0e-9))[0]
    inside = np.unique(mesh.boundaries["left"])
    return float(result.reactions[inside, 0].sum()) / 0.1, result


@case(
    "fem-tube",
    "Tube of Tresca and of Mohr and Coulomb from first yield to the limit",
    shows="Radii 1 and 2 m, c = 50 kPa: pressure over the displacement of the outer surface, and limit pressures.",
    given="a = 1 m, b = 2 m, E = 10 MPa, ν = 0.3, c = 50 kPa, φ = 0 and 30°, ψ = 0",
    source="Hill (1950), The Mathematical Theory of Plasticity, chapter V; Yu (2000) for Mohr-Coulomb",
    reference=(
        "p = c (2 ln(ρ/a) + 1 − ρ²/b²),  u(b) = 2 (1 − ν²) c ρ²/(E b);  limits 2 c ln 2 = 69.3147 kPa and "
        "c cot φ (2^(1−1/N) − 1)"
    ),
    allowed="errors of 24 cells over the thickness, 0.1 %",
)
def tube() -> Answer:
    """Pressure over outer displacement."""
    tresca = mohr_coulomb(E, NU, C, 0.0, tension_cutoff=None)
    displaced, pressures = [], []
    for widening in (0.004, 0.0072, 0.01, 0.013, 0.018, 0.025, 0.05):
        pressure, result = _widened(tresca, widening)
        displaced.append(float(result.displacements[:, 0][result.positions[:, 0] > 1.9].min()))
        pressures.append(pressure)
    u, ours = np.array(displaced), np.array(pressures)
    first = 2.0 * (1.0 - NU**2) * C / (E * 2.0)  # of the outside when the inside yields
    front = np.clip(np.sqrt(u / first), 1.0, 2.0)
    plastic = C * (2.0 * np.log(front) + 1.0 - front**2 / 4.0)
    exact = np.where(u < first, 37.5 * u / first, plastic)
    phi = math.radians(30.0)
    N = (1.0 + math.sin(phi)) / (1.0 - math.sin(phi))
    limit = C / math.tan(phi) * (2.0 ** (1.0 - 1.0 / N) - 1.0)
    found, _ = _widened(mohr_coulomb(E, NU, C, 30.0, tension_cutoff=None), 0.06)
    checks = (
        check("pressure, Tresca", "kPa", ours, exact, 1.0e-3, scale=2.0 * C * math.log(2.0), of="the limit"),
        check("limit pressure, Tresca", "kPa", ours[-1], 2.0 * C * math.log(2.0), 1.0e-3),
        check("limit pressure, Mohr-Coulomb", "kPa", found, limit, 1.0e-3),
    )
    curve = Curve("Tresca", 1000.0 * u, ours, 1000.0 * u, exact)
    return Answer(checks, Plot("displacement of the outer surface [mm]", "pressure [kPa]", (curve,)))


def _footing(cells: int) -> float:
    """Bearing capacity over cohesion of a smooth strip footing, half width 1 m, on weightless soil."""
    x = np.concatenate([graded(0.0, 1.0, cells), graded(1.0, 5.0, 2 * cells, 1.25 ** (4 / cells))[1:]])
    mesh = block(x, graded(-4.0, 0.0, 3 * cells, 0.8 ** (4 / cells)))
    under = tuple(int(node) for node in np.unique(mesh.boundaries["top"]) if mesh.nodes[node, 0] < 1.0 + 1.0e-9)
    phase = Phase(
        "footing",
        materials={"soil": mohr_coulomb(1.0e5, 0.49, 100.0, 0.0, tension_cutoff=None)},
        fixities=(*SIDES, Fixity(under, y=-0.03)),
        load_step=0.05,
        largest_load_step=0.1,
    )
    result = solve_phases(mesh, [phase], control=Control(tolerance=1.0e-4))[0]
    return float(-result.reactions[list(under), 1].sum()) / 100.0


@case(
    "fem-footing",
    "Bearing capacity of a strip footing",
    shows="A smooth footing on weightless soil without friction, with 3, 4 and 6 cells below its half width.",
    given="E = 100 MPa, ν = 0.49, c = 100 kPa, φ = 0; ground of 5 m by 4 m, half of it by symmetry",
    source="Prandtl (1920)",
    reference="q/c = 2 + π",
    allowed="discretisation: the mesh is 4 % too strong with 6 cells, and the error must decrease with finer cells",
)
def footing() -> Answer:
    """Capacity over mesh size."""
    counts = np.array([3, 4, 6])
    found = np.array([_footing(int(count)) for count in counts])
    exact = 2.0 + math.pi
    checks = (
        check("capacity over cohesion, 6 cells", "", found[-1], exact, 4.0e-2),
        check("capacity over cohesion, extrapolated to size 0", "", 2.0 * found[-1] - found[0], exact, 2.0e-2),
    )
    size = 1.0 / counts
    curve = Curve(
        "", np.append(size, 0.0), np.append(found, 2.0 * found[-1] - found[0]), np.array([0.0]), np.array([exact])
    )
    plot = Plot("size of the cells below the footing [m]", "q/c [-]", (curve,), caption="At size 0: extrapolated.")
    return Answer(checks, plot)


def _edge(stands: Callable[[float], bool], standing: float, falling: float, close: float) -> float:
    """Where a slope begins to fall, to half of ``close``; nan where it does not stand or fall as expected."""
    if not stands(standing) or stands(falling):
        return math.nan
    while abs(falling - standing) > close:
        middle = 0.5 * (standing + falling)
        if stands(middle):
            standing = middle
        else:
            falling = middle
    return 0.5 * (standing + falling)


@case(
    "fem-infinite-slope",
    "Infinite slope at its limit",
    shows="Slopes of 20 degrees, 5 m deep, with c = 0.5 and 4 kPa: the friction is reduced until they fail.",
    given="β = 20°, z = 5 m, γ = 20 kN/m³, E = 100 MPa, ν = 0.3, ψ = φ",
    source="Skempton & DeLory (1957); limit equilibrium, which is exact here with associated flow",
    reference="F = (c + γ z cos² β tan φ)/(γ z sin β cos β) = 1",
    allowed="the interval between stable and failed (0.02) and errors of five rows of cells",
)
def slope() -> Answer:
    """Safety at the limit over cohesion."""
    found, curves = [], []
    for c in (0.5, 4.0):
        safeties: list[float] = []
        moved_by: list[float] = []

        def stands(safety: float, c: float = c, at: list[float] = safeties, by: list[float] = moved_by) -> bool:
            try:
                result = InfiniteSlope(20.0, 5.0, c, safety, 1.0, 0.0).calculate()
            except DivergedError:
                return False
            at.append(safety)
            by.append(1000.0 * float(np.hypot(*result.displacements.T).max()))
            return True

        for safety in (1.5, 1.2, 1.1):
            stands(safety)
        found.append(_edge(stands, 1.04, 0.96, 0.02))
        order = np.argsort(safeties)
        x, y = np.array(safeties)[order], np.array(moved_by)[order]
        curves.append(Curve(f"stable, c = {c:g} kPa", x, y, np.ones(1), y[:1]))
    plot = Plot(
        "safety in closed form [-]",
        "largest displacement [mm]",
        tuple(curves),
        caption="Markers: F = 1, where it fails.",
    )
    return Answer((check("closed-form safety at failure", "", found, 1.0, 0.02),), plot)


@case(
    "fem-griffiths-lane",
    "A published slope: safety by reduction of strength",
    shows="Slope 2:1, φ = 20°, c/(γH) = 0.05 on a rigid base: the reduction factor at which no equilibrium is found.",
    given="H = 10 m, γ = 20 kN/m³, c = 10 kPa, φ = 20°, ψ = 0, E = 100 MPa, ν = 0.3",
    source="Griffiths & Lane (1999), Slope stability analysis by finite elements, example 1",
    reference="published: about 1.4 by finite elements, 1.380 by the chart of Bishop & Morgenstern (1960)",
    allowed="published steps of 0.05 in the factor; our interval of 0.025",
)
def griffiths() -> Answer:
    """Largest displacement over the reduction factor."""
    mesh = embankment(12.0, 16, 8)
    factors: list[float] = []
    moved_by: list[float] = []

    def stands(factor: float) -> bool:
        c, phi = 10.0 / factor, math.degrees(math.atan(math.tan(math.radians(20.0)) / factor))
        soil = mohr_coulomb(1.0e5, 0.3, c, phi, tension_cutoff=None, unit_weight=20.0)
        phase = Phase("weight", "gravity", materials={"soil": soil}, fixities=SIDES[::2], load_step=0.2)
        try:
            result = solve_phases(mesh, [phase], control=Control(tolerance=1.0e-4, smallest_step=0.01))[0]
        except DivergedError:
            return False
        factors.append(factor)
        moved_by.append(1000.0 * float(np.hypot(*result.displacements.T).max()))
        return True

    stands(1.0)
    stands(1.2)
    limit = _edge(stands, 1.3, 1.5, 0.025)
    order = np.argsort(factors)
    x, y = np.array(factors)[order], np.array(moved_by)[order]
    plot = Plot(
        "reduction of the strength [-]",
        "largest displacement [mm]",
        (Curve("stable states", x, y, np.array([1.4]), y[-1:]),),
        caption="Marker: published factor.",
    )
    return Answer((check("factor of safety", "", limit, 1.4, 0.025, scale=1.0, of="absolute"),), plot)


@case(
    "fem-sliding-block",
    "Block that slides on an interface",
    shows="Four metres wide, pressed with 25 kPa and pushed by 1 mm; the interface has c = 2.5 kPa and tan φ = 0.5.",
    given="interface of 10⁵ kN/m³ in both directions",
    source="equilibrium of forces (Coulomb)",
    reference="H = 4 m × 2.5 kPa + 100 kN/m × 0.5 = 60 kN/m",
    allowed="rounding and the tolerance of the iterations",
)
def block_on_joint() -> Answer:
    """Force over push."""
    lower = block(graded(-1.0, 5.0, 6), graded(-1.0, 0.0, 1), name="base")
    upper = block(graded(0.0, 4.0, 4), graded(0.0, 1.0, 1), name="block")
    mesh = stacked(lower, upper)
    joint = InterfaceMaterial(1.0e5, 1.0e5, 2.5, math.degrees(math.atan(0.5)))
    press = Phase(
        "weight",
        materials={"base": elastic(1.0e6, 0.0), "block": elastic(1.0e6, 0.0), "joint": joint},
        fixities=(Fixity("lower bottom", x=0.0, y=0.0), Fixity("left", x=0.0)),
        tractions=(Traction("top", y=-25.0),),
    )
    left = np.unique(mesh.boundaries["left"])
    pushes = np.array([5.0e-5, 1.0e-4, 1.5e-4, 2.0e-4, 2.5e-4, 3.0e-4, 3.5e-4, 4.0e-4, 6.0e-4, 1.0e-3])
    held = Fixity("lower bottom", x=0.0, y=0.0)
    steps = np.diff(pushes, prepend=0.0).tolist()
    phases = [Phase(f"push {i}", fixities=(held, Fixity("left", x=dx)), load_step=0.25) for i, dx in enumerate(steps)]
    forces = [float(one.reactions[left, 0].sum()) for one in solve_phases(mesh, [press, *phases])[1:]]
    curve = Curve("", 1000.0 * pushes, np.array(forces), 1000.0 * pushes[-1:], np.array([60.0]))
    plot = Plot("push [mm]", "force [kN/m]", (curve,), caption="Marker: closed form.")
    return Answer((check("force", "kN/m", forces[-1], 60.0, 1.0e-6),), plot)


CASES = (tube, footing, slope, griffiths, block_on_joint)
