"""Displacements and strains of a whole body, for plots: which models have a body, and what is drawn of it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.triangle import shape_functions
from geoswarm.solver.forward.base import ForwardModel
from geoswarm.solver.forward.combined import CombinedModel
from geoswarm.solver.forward.continuum.model import BodyModel

__all__ = ["body_of", "displacement_fields", "parts_with_body", "shear_strain"]

_PLACES = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5))
_SLOPES = np.array([shape_functions(*place)[1] for place in _PLACES])
"""Slopes (6, 2, 6) of the shape functions at the six nodes."""


def parts_with_body(model: ForwardModel) -> tuple[str, ...]:
    """Names of the parts that have a mesh; the empty name means a model without parts."""
    if isinstance(model, BodyModel):
        return ("",)
    if isinstance(model, CombinedModel):
        return tuple(name for name in model.part_names if isinstance(model.part(name), BodyModel))
    return ()


def body_of(
    model: ForwardModel, part: str, parameters: Mapping[str, float]
) -> tuple[BodyModel, Mapping[str, float]] | None:
    """The model of a body and its parameters by name; None if there is no such body."""
    if part not in parts_with_body(model):
        return None
    if isinstance(model, CombinedModel):
        inner = model.part(part)
        assert isinstance(inner, BodyModel)
        return inner, model.part_values(part, parameters)
    assert isinstance(model, BodyModel)
    return model, parameters


def displacement_fields(model: BodyModel, parameters: Mapping[str, float]) -> dict[str, FloatArray]:
    """Calculate the displacements (n, 2), m, of all nodes at the end of every phase, since the beginning.

    Raises
    ------
    ForwardError
        The parameters are inadmissible, or no solution was found.
    """
    run = model.calculate(parameters)
    return {result.name: run.displacements(result.name) for result in run.results}


def shear_strain(mesh: Mesh, displacement: FloatArray) -> FloatArray:
    """Largest shear strain in the plane at the nodes of each triangle, (e, 6): 2 sqrt(((ex - ey)/2)^2 + (gxy/2)^2).

    Strains are those of small displacements on the undeformed mesh. They are averaged over the triangles of one region
    that share a node, so they jump only where the ground changes.

    Parameters
    ----------
    displacement
        (n, 2), m.
    """
    triangles = mesh.triangles
    jacobian = np.einsum("pin,enj->epij", _SLOPES, mesh.nodes[triangles])
    slopes = np.linalg.solve(jacobian, np.broadcast_to(_SLOPES, (len(triangles), *_SLOPES.shape)))
    gradient = np.einsum("epjn,eni->epij", slopes, displacement[triangles])  # d u_i / d x_j
    strain = np.stack(
        [gradient[..., 0, 0], gradient[..., 1, 1], gradient[..., 0, 1] + gradient[..., 1, 0]], axis=-1
    )  # (e, 6, 3)
    place = mesh.regions.astype(np.int64)[:, None] * len(mesh.nodes) + triangles
    _, shared, count = np.unique(place.ravel(), return_inverse=True, return_counts=True)
    total = np.zeros((len(count), 3))
    np.add.at(total, shared.ravel(), strain.reshape(-1, 3))
    mean = (total / count[:, None])[shared.ravel()].reshape(strain.shape)
    return np.asarray(np.hypot(mean[..., 0] - mean[..., 1], mean[..., 2]))
