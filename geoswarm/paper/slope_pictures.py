"""Figures of the slope: mesh, deformed mesh, vectors measured against calculated, shear zone profile."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from geoswarm.paper.study import Picture
from geoswarm.solver.forward.cross_section import SectionModel
from geoswarm.solver.problem import Problem
from geoswarm.solver.report.figures.cross_section_plot import deformed_figure, mesh_figure, vectors_figure, vectors_rows
from geoswarm.solver.report.figures.profile_plot import depth_profile, profile_figure, profile_rows

__all__ = ["slope_pictures"]

_SURVEY, _BEFORE, _SHEAR_ZONE = "survey", "creep", "shear_zone"


def slope_pictures(problem: Problem, values: Mapping[str, float]) -> dict[str, Picture]:
    """Draw the slope with these parameters; the problem's observations are the measured vectors."""
    model = problem.model
    assert isinstance(model, SectionModel)
    run = model.calculate(values)
    mesh = run.mesh
    survey = run.displacements(_SURVEY) - run.displacements(_BEFORE)
    points = model.spec.vectors["gps"].points
    measured = {o.series: o.y for o in problem.observations}
    vectors = {
        "measured (synthetic)": np.stack([measured["gps.ux"], measured["gps.uy"]], axis=1),
        "calculated": survey[[mesh.points[name] for name in points]],
    }
    # Further up the columns lean with the secondary shear zone.
    profiles = {name: depth_profile(mesh, survey, name, _SHEAR_ZONE) for name in points[-4:]}
    x, y = mesh.nodes[mesh.points[points[0]]].tolist()
    nodes: list[list[object]] = [[*place, *u] for place, u in zip(mesh.nodes.tolist(), survey.tolist(), strict=True)]
    triangles: list[list[object]] = [
        [mesh.region_names[region], *corners]
        for region, corners in zip(mesh.regions.tolist(), mesh.triangles.tolist(), strict=True)
    ]
    return {
        "mesh": Picture(
            mesh_figure("Mesh", mesh, window=(x - 150.0, x + 110.0, y - 75.0, y + 40.0)),
            f"{len(mesh.triangles)} six-node triangles; below: the head, with the crack and the secondary shear zone.",
            (["region", *(f"node {number}" for number in range(6))], triangles),
        ),
        "deformed": Picture(
            deformed_figure("Three years of the survey", mesh, survey),
            "Deformed mesh of the identified set; dashed: before.",
            (["x [m]", "y [m]", "ux [m]", "uy [m]"], nodes),
        ),
        "vectors": Picture(
            vectors_figure("Displacements in three years", mesh, points, vectors),
            "Displacement vectors of the points, measured (synthetic) against calculated.",
            vectors_rows(points, vectors),
        ),
        "profiles": Picture(
            profile_figure("Three years of the survey", profiles, unit="cm"),
            "Horizontal displacement over depth; shaded: the shear zone, which takes nearly all of it.",
            profile_rows(profiles),
        ),
    }
