"""Direct simple shear tests: stress ratio on the horizontal plane, and undrained strength."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.estimates.value import ClassicalValue
from geoswarm.solver.forward.combined import ModelPart
from geoswarm.solver.laboratory.shear.simple_shear import DirectSimpleShearSpec, SimpleShearMonotonic
from geoswarm.solver.problem import Problem

__all__ = ["simple_shear_values"]


def simple_shear_values(problem: Problem, part: ModelPart) -> Iterator[ClassicalValue]:
    """Angle of the largest ratio of shear to normal stress, and of a test at constant volume s_u.

    The horizontal plane is taken for the plane of failure, tan(phi) = tau/sigma'_v; a soil that fails at critical state
    while the horizontal plane is one of largest shear has sin(phi) there, and a larger angle.
    """
    spec = part.spec
    assert isinstance(spec, DirectSimpleShearSpec)
    prefix = f"{part.name}." if part.name else ""
    observed = {o.series.removeprefix(prefix): o for o in problem.observations if o.series.startswith(prefix)}
    shear = observed.get("shear_stress") or observed.get("branch_1.shear_stress")
    first = spec.shearing[0]
    method = "largest τ/σ′v on the horizontal plane"
    if shear is None or not isinstance(first, SimpleShearMonotonic):
        why = "shear_stress over the shear strain of a monotonic first stage was not read"
        yield ClassicalValue(part.name, "φ", method, None, why, "degree")
        return
    vertical = spec.consolidation[-1].normal_stress if spec.consolidation else spec.initial_stress
    order = np.argsort(shear.x, kind="stable")
    strain, tau = shear.x[order], np.abs(shear.y[order])
    volume_kept = (first.constant or spec.constant) == "volume"
    if volume_kept:
        yield ClassicalValue(part.name, "s_u/σ′v", "largest τ over σ′v before shearing", float(tau.max() / vertical))
    normal: FloatArray | None = None if volume_kept else np.full(tau.size, vertical)
    for name, sign, start in (("normal_stress", 1.0, 0.0), ("pore_pressure", -1.0, vertical)):
        one = observed.get(name) or observed.get(f"branch_1.{name}")
        if volume_kept and normal is None and one is not None:
            along = np.argsort(one.x, kind="stable")
            normal = np.asarray(start + sign * np.interp(strain, one.x[along], one.y[along]))
    if normal is None:
        why = "a test at constant volume without normal_stress or pore_pressure gives no effective stress"
        yield ClassicalValue(part.name, "φ", method, None, why, "degree")
        return
    good = normal > 0.0
    angle = math.degrees(math.atan(float((tau[good] / normal[good]).max()))) if good.any() else None
    yield ClassicalValue(part.name, "φ", method, angle, "" if good.any() else "σ′v is nowhere above 0 kPa", "degree")
