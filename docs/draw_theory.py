"""Draws the figures of the theory pages: what each laboratory test does, a section, and the surfaces of the laws.

Run ``python docs/draw_theory.py`` after a change of a sketch or of an equation. Tests are drawn as the form and the
reports draw them, from the example of their section; surfaces from the equations on the pages of the laws, not from
the code that is to be explained.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.examples import example_file
from geoswarm.solver.forward.registry import find_spec, parse_spec, sketches_of
from geoswarm.solver.problem.text.reading import read_problem_file
from geoswarm.solver.report.figures.sketch_plot import sketch_figure
from geoswarm.solver.report.figures.style import BLUE, GREEN, ORANGE, drawing
from geoswarm.verification.exact.hardening_soil import Drained

FOLDER = Path(__file__).parent / "pictures" / "theory"
TESTS = {
    "oedometer": "Oedometer",
    "isotropic_compression": "Isotropic compression",
    "crs_oedometer": "Oedometer at constant rate of strain",
    "consolidation": "Consolidation",
    "triaxial": "Triaxial test",
    "direct_simple_shear": "Direct simple shear",
    "column": "Layered ground",
}
PHI = math.radians(30.0)
SLOPE = 6.0 * math.sin(PHI) / (3.0 - math.sin(PHI))
"""q/p of triaxial compression at 30 degrees."""


def tests() -> Iterator[tuple[str, Figure]]:
    """Specimen and loading programme of each test's example."""
    for kind, title in TESTS.items():
        spec = find_spec(kind)
        example = spec.example()
        assert example is not None
        (sketch,) = sketches_of(spec.model_validate(example)).values()
        yield f"test-{kind.replace('_', '-')}", sketch_figure(title, sketch)


def sections() -> Iterator[tuple[str, Figure]]:
    """The section of the slope in the examples."""
    with example_file("slope") as path:
        spec = parse_spec(read_problem_file(path)["forward_model"])
    (sketch,) = sketches_of(spec).values()
    yield "section-slope", sketch_figure("Section of a slope", sketch)


def mohr_coulomb(theta: FloatArray) -> FloatArray:
    """q at p = 1 over the Lode angle, 0: triaxial compression, 60 degrees: extension."""
    sine, greatest, least = math.sin(PHI), np.cos(theta), np.cos(theta + 2.0 * math.pi / 3.0)
    found: FloatArray = 3.0 * sine / (greatest - least - sine * (greatest + least))
    return found


def matsuoka_nakai(theta: FloatArray) -> FloatArray:
    """The same for I1 I2/I3 = 9 + 8 tan(phi)^2, by bisection."""
    limit, q = 9.0 + 8.0 * math.tan(PHI) ** 2, np.empty_like(theta)
    for n, one in enumerate(theta):
        low, high = 0.0, SLOPE
        for _ in range(60):
            middle = 0.5 * (low + high)
            s = 1.0 + 2.0 / 3.0 * middle * np.cos(one + np.array([0.0, -2.0, 2.0]) * math.pi / 3.0)
            inside = s.min() > 0.0 and s.sum() * (s[0] * s[1] + s[1] * s[2] + s[2] * s[0]) <= limit * s.prod()
            low, high = (middle, high) if inside else (low, middle)
        q[n] = low
    return q


def cones() -> Figure:
    """The three strength surfaces in the deviatoric plane and over the mean stress."""
    figure = Figure(figsize=(8.4, 3.9))
    plane, meridian = figure.subplots(1, 2)
    sixth = np.linspace(0.0, math.pi / 3.0, 121)
    for q, label, colour, style in (
        (mohr_coulomb(sixth), "Mohr-Coulomb", BLUE, "-"),
        (matsuoka_nakai(sixth), "Matsuoka-Nakai", GREEN, "--"),
        (np.full(sixth.size, SLOPE), "Drucker-Prager, match: compression", ORANGE, ":"),
    ):
        half = np.concatenate([q, q[::-1]])
        turn = np.concatenate([sixth, 2.0 * math.pi / 3.0 - sixth[::-1]])
        around, size = np.concatenate([turn + n * 2.0 * math.pi / 3.0 for n in range(3)]), np.tile(half, 3)
        plane.plot(-size * np.sin(around), size * np.cos(around), style, color=colour, label=label)
    for n, name in enumerate(("σ₁", "σ₃", "σ₂")):
        x, y = math.sin(2.0 * n * math.pi / 3.0), math.cos(2.0 * n * math.pi / 3.0)
        plane.plot([0.0, 1.5 * x], [0.0, 1.5 * y], color="0.6", linewidth=0.8, zorder=0)
        plane.annotate(name, (1.62 * x, 1.62 * y), ha="center", va="center")
    plane.set_aspect("equal")
    plane.set_axis_off()
    plane.set_title("Deviatoric plane, φ = 30°")
    plane.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), frameon=False, fontsize=8)
    c, cut = 10.0, 5.0
    p = np.linspace(-c / math.tan(PHI), 60.0, 200)
    compression = SLOPE * (p + c / math.tan(PHI))
    extension = 6.0 * math.sin(PHI) / (3.0 + math.sin(PHI)) * (p + c / math.tan(PHI))
    meridian.plot(p, compression, color=BLUE, label="strength, compression and extension")
    meridian.plot(p, -extension, color=BLUE)
    # the least stress is p - q/3 in compression and p - 2 q/3 in extension
    q = np.linspace(-60.0, 110.0, 2000)
    cut_off = np.where(q > 0.0, q / 3.0, -2.0 * q / 3.0) - cut
    inside = (q < np.interp(cut_off, p, compression)) & (-q < np.interp(cut_off, p, extension))
    meridian.plot(cut_off[inside], q[inside], "--", color=ORANGE, label="tension cut-off, 5 kPa")
    finish(
        meridian,
        "p [kPa]",
        "q [kPa], negative in extension",
        "Mohr-Coulomb, c = 10 kPa, φ = 30°",
        (-20.0, 60.0),
        (-70.0, 140.0),
    )
    figure.tight_layout()
    return figure


def cam_clay() -> Figure:
    """Ellipse and critical state line of modified Cam clay; the cap of the soft soil laws with its cohesion."""
    figure = Figure(figsize=(8.4, 3.6))
    left, right = figure.subplots(1, 2)
    M, angle = 1.0, np.linspace(0.0, math.pi, 200)
    for size, style in ((100.0, "-"), (60.0, "--")):
        left.plot(
            0.5 * size * (1.0 + np.cos(angle)),
            0.5 * M * size * np.sin(angle),
            style,
            color=BLUE,
            label=f"q² = M² p (p_c − p), p_c = {size:g} kPa",
        )
    p = np.linspace(0.0, 75.0, 2)
    left.plot(p, M * p, color=ORANGE, label="critical state, q = M p")
    finish(left, "p [kPa]", "q [kPa]", "Modified Cam clay, M = 1", (0.0, 120.0), (0.0, 110.0))
    c, cap = 5.0, 100.0
    a, top = c / math.tan(PHI), 1.3
    x = np.linspace(-a, cap, 400)
    size = cap + a
    q = top * np.sqrt(np.maximum((x + a) * (size - (x + a)), 0.0))
    strength = SLOPE * (x + a)
    right.plot(x, q, color=BLUE, label="cap, p_eq = p_p = 100 kPa")
    below = strength < 95.0
    right.plot(x[below], strength[below], color=ORANGE, label="Mohr-Coulomb, c = 5 kPa, φ = 30°")
    right.fill_between(x, 0.0, np.minimum(q, strength), color=BLUE, alpha=0.12, linewidth=0.0)
    finish(right, "p [kPa]", "q [kPa]", "Soft soil and soft soil creep, M = 1.3", (-12.0, 120.0), (0.0, 130.0))
    figure.tight_layout()
    return figure


def hardening_soil() -> Figure:
    """Shear surfaces for growing plastic shear strain, strength and cap of hardening soil, in triaxial compression."""
    figure = Figure(figsize=(5.6, 4.0))
    axes = figure.subplots()
    s3, share = np.linspace(0.5, 220.0, 400), np.linspace(0.0, 1.0, 400)
    tests = [Drained(cell, phi=30.0) for cell in s3.tolist()]
    strength = np.array([test.strength for test in tests])
    for gamma in (0.001, 0.004, 0.016):
        q = np.empty_like(s3)
        for n, test in enumerate(tests):
            qs = share * test.strength
            q[n] = np.interp(gamma, 2.0 * (test.axial(qs) - qs / (test.stiff * test.sand.Eur)), qs)
        axes.plot(s3 + q / 3.0, q, color=BLUE, linewidth=0.7 + 45.0 * gamma, label=f"shear surface, γᵖ = {gamma:.1%}")
    axes.plot(s3 + strength / 3.0, strength, color=ORANGE, label="strength")
    alpha, cap = 1.4, 150.0
    p = np.linspace(0.0, cap, 200)
    axes.plot(p, alpha * np.sqrt(cap**2 - p**2), "--", color=GREEN, label="cap, p_p = 150 kPa")
    finish(axes, "p [kPa]", "q [kPa]", "Hardening soil, φ = 30°, c = 0", (0.0, 240.0), (0.0, 400.0))
    figure.tight_layout()
    return figure


def elastic() -> Figure:
    """Stiffness of linear elasticity with free and with confined sides, and its stress paths in laboratory tests."""
    figure = Figure(figsize=(8.4, 3.6))
    left, right = figure.subplots(1, 2)
    E, strain = 10.0, np.array([0.0, 0.01])
    left.plot(100.0 * strain, 1.0e3 * E * strain, color=BLUE, label="side free: E")
    for nu, style in ((0.2, "-"), (0.3, "--"), (0.4, ":")):
        confined = E * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
        label = f"no lateral strain, ν = {nu:g}: {confined / E:.2f} E"
        left.plot(100.0 * strain, 1.0e3 * confined * strain, style, color=ORANGE, label=label)
    finish(left, "axial strain [%]", "axial stress [kPa]", "Stiffness, E = 10 MPa", (0.0, 1.0), (0.0, 230.0))
    at, K0 = 100.0, 0.3 / (1.0 - 0.3)
    slope = 3.0 * (1.0 - K0) / (1.0 + 2.0 * K0)
    top = 120.0
    right.plot([at, at + top / 3.0], [0.0, top], color=BLUE, label="triaxial, drained: 3")
    right.plot([at, at], [0.0, top], "--", color=BLUE, label="triaxial, undrained: p′ stays")
    right.plot([at, at + top / slope], [0.0, top], color=ORANGE, label=f"oedometer, ν = 0.3: {slope:.2f}")
    right.plot([at, 260.0], [0.0, 0.0], color=GREEN, linewidth=3.0, label="isotropic compression: 0")
    finish(right, "p′ [kPa]", "q [kPa]", "Stress paths from p′ = 100 kPa", (80.0, 260.0), (-5.0, 200.0))
    figure.tight_layout()
    return figure


def finish(axes: Axes, x: str, y: str, title: str, wide: tuple[float, float], tall: tuple[float, float]) -> None:
    """Names, limits and legend."""
    axes.set_xlim(*wide)
    axes.set_ylim(*tall)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title)
    axes.legend(frameon=False, fontsize=8, loc="upper left")


def main() -> None:
    """Draw all and delete what is not drawn any more."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for old in FOLDER.glob("*.svg"):
        old.unlink()
    with drawing():
        laws = {"cones": cones, "cam-clay": cam_clay, "hardening-soil": hardening_soil, "elastic": elastic}
        figures = [*tests(), *sections(), *((name, draw()) for name, draw in laws.items())]
        for name, figure in figures:
            figure.savefig(FOLDER / f"{name}.svg", facecolor="white", metadata={"Date": None})
    print(f"{len(figures)} figures in {FOLDER.name}")


if __name__ == "__main__":
    main()
