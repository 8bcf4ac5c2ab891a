"""Frozen records of the answers that only the client reads: reports, figures, and the body of an evaluation."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

from geoswarm.records.arrays import Floats, Integers

__all__ = ["Displacement", "Figure", "Mesh", "MeshFields", "Phase", "Report"]


@dataclass(frozen=True, slots=True)
class Report:
    """The report of a job: ``html`` is a self-contained page."""

    html: str

    def _repr_html_(self) -> str:
        """Show the page in a notebook, in a frame of its own so that styles do not mix."""
        return f'<iframe srcdoc="{escape(self.html)}" style="width:100%;height:60rem;border:0"></iframe>'


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure of a job: ``form`` is svg, png or csv (the numbers behind it)."""

    name: str
    form: str
    content: bytes

    def _repr_svg_(self) -> str | None:
        """Show it in a notebook."""
        return self.content.decode() if self.form == "svg" else None

    def _repr_png_(self) -> bytes | None:
        """Show it in a notebook."""
        return self.content if self.form == "png" else None


@dataclass(frozen=True, slots=True)
class Phase:
    """What happens to a body; ``end`` [day since the zero of time], None long before it."""

    name: str
    kind: str
    end: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Displacement:
    """Displacement of an observed point between two times [day].

    Attributes
    ----------
    name
        Of the survey, or ``last readings`` of series over time.
    x, y
        Place of the point in the undeformed mesh [m].
    measured, calculated
        Shape (2,), ux and uy [m]; NaN: not measured.
    """

    name: str
    point: str
    x: float
    y: float
    start: float
    end: float
    measured: Floats
    calculated: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """The mesh of an evaluation, undeformed, and the displacements of its observed points.

    Attributes
    ----------
    part, parts
        Of a combined model, else empty; the parts that have a mesh.
    generation, particle
        Of the evaluation; None: none yet, the mesh is that of the nominal geometry.
    nodes
        Shape (n, 2), x and y [m].
    triangles
        Shape (m, 6): nodes at the corners 0, 1, 2, then in the middle of 01, 12 and 20.
    regions
        Shape (m,): place in ``region_names`` of each triangle.
    interfaces
        Shape (i, 6): start, end and middle of side A, then of side B.
    points
        Nodes of named points.
    start, end
        Phases at whose ends the usual period begins and ends; None: before the first.
    """

    part: str
    parts: list[str]
    generation: int | None
    particle: int | None
    objective: float | None
    objective_unit: str
    parameters: dict[str, float]
    nodes: Floats
    triangles: Integers
    regions: Integers
    region_names: list[str]
    interfaces: Integers
    points: dict[str, int]
    phases: list[Phase]
    start: str | None
    end: str
    vectors: list[Displacement]

    def __post_init__(self) -> None:
        """Give an empty list of interfaces its shape."""
        if self.interfaces.size == 0:
            object.__setattr__(self, "interfaces", self.interfaces.reshape(0, 6))


@dataclass(frozen=True, slots=True, eq=False)
class MeshFields:
    """How a body moves between the ends of two phases.

    Attributes
    ----------
    displacement
        Shape (n, 2), ux and uy of every node [m].
    shear_strain
        Shape (m, 6): largest shear strain in the plane at the nodes of every triangle [-].
    """

    start: str | None
    end: str
    generation: int | None
    particle: int | None
    displacement: Floats
    shear_strain: Floats
