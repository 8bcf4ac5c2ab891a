"""A vertical section through a layered slope or embankment, in plane strain; its geometry may be identified.

::

    forward_model:
      kind: section
      surface: [[0, 190], [1080, 0]]
      layers:
        - {name: cover, thickness: depth, rows: 2}      # depth: a parameter
        - {name: shear_zone, thickness: 2, rows: 2}
        - {name: bedrock, thickness: 20}
      nominal: {depth: 30}
      ...

Every number of geometry, materials and loads may be an expression of parameters. The mesh keeps its topology while they
vary, and its nodes move smoothly with them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import Field

from geoswarm.solver.errors import InfeasibleError, Issue, MeshError, ProblemError
from geoswarm.solver.fem.mesh.layered import LayeredMesh
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.solver.forward.continuum.body import check_names
from geoswarm.solver.forward.continuum.geometry import GeometrySections, profile_of
from geoswarm.solver.forward.continuum.model import BodyModel
from geoswarm.solver.forward.continuum.phases import BoundaryName, Fixity
from geoswarm.solver.forward.continuum.quantity import quantities_in
from geoswarm.solver.forward.continuum.sketch import SketchedSection

__all__ = ["SectionModel", "SectionSpec"]


class SectionSpec(SketchedSection, ForwardModelSpec):
    """Section through a layered slope or embankment, with finite elements in plane strain.

    Series: ``A.ux`` and ``A.uy`` over time for every point A (m; x to the right, y upwards), and ``gps.ux`` and
    ``gps.uy`` over the number of the point for every entry ``gps`` of ``vectors``. Boundaries are ``surface``,
    ``bottom``, ``left``, ``right``, pieces of the sides such as ``right.cover``, and the segments.
    """

    kind: Literal["section"] = "section"
    fixities: dict[BoundaryName, Fixity] = Field(
        default={"left": "horizontal", "right": "horizontal", "bottom": "vertical"},
        description="Boundaries that are held: horizontal, vertical, both or free.",
    )

    @classmethod
    def example(cls) -> dict[str, Any]:
        """A slope of clay of unknown depth on rock."""
        return {
            "kind": "section",
            "surface": [[0, 10], [10, 10], [25, 2], [40, 2]],
            "layers": [{"name": "clay", "thickness": "depth", "rows": 2}, {"name": "rock", "bottom": -4}],
            "points": {"A": {"x": 8}},
            "element_length": 2.5,
            "nominal": {"depth": 3},
            "materials": {
                "soil": {"law": "elastic", "E": "E", "nu": 0.3, "unit_weight": 20},
                "rock": {"law": "elastic", "E": 1e6, "nu": 0.25, "unit_weight": 22},
            },
            "phases": [
                {"name": "weight", "kind": "gravity", "materials": {"clay": "rock", "rock": "rock"}},
                {"name": "soil", "kind": "plastic", "materials": {"clay": "soil"}},
            ],
            "zero_at_phase": "soil",
        }

    def build(self) -> SectionModel:
        """Build the forward model."""
        return SectionModel(self)


class SectionModel(BodyModel):
    """Forward model of a section."""

    def __init__(self, spec: SectionSpec) -> None:
        super().__init__(spec)
        self.spec = spec
        lengths = list(quantities_in(spec.element_length))
        if lengths:
            text = f"'{lengths[0].expression.text}' must be a number; the number of elements does not vary"
            raise ProblemError([Issue("forward_model.element_length", text)])
        missing = sorted(self._geometry_names() - spec.nominal.keys())
        if missing:
            text = f"{missing[0]} is missing: the mesh is planned for a usual value of every parameter in the geometry"
            raise ProblemError([Issue("forward_model.nominal", text)])
        try:
            geometry = spec.geometry(spec.nominal)
            self._layered = LayeredMesh.plan(geometry, profile_of(spec.element_length, {}, "element_length"))
        except (MeshError, InfeasibleError) as error:
            raise ProblemError([Issue("forward_model", str(error))]) from error
        check_names(spec, self._layered.nominal)

    def _geometry_names(self) -> set[str]:
        parts = [getattr(self.spec, name) for name in GeometrySections.model_fields]
        return {name for quantity in quantities_in(parts) for name in quantity.expression.names}

    @property
    def nominal(self) -> Mesh:
        """The mesh of the nominal geometry."""
        return self._layered.nominal

    def mesh(self, values: Mapping[str, float]) -> Mesh:
        """The mesh for parameters by name."""
        if not self._geometry_names():
            return self._layered.nominal
        try:
            return self._layered.mesh(self.spec.geometry(values))
        except MeshError as error:
            raise InfeasibleError(str(error)) from error
