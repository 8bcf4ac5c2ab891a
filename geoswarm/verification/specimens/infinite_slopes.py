"""Infinite slopes, whose limit is known in closed form: bodies with the stresses of the limit state at their ends."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.errors import DivergedError
from geoswarm.solver.fem.materials import Material
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.results import PhaseResult
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.verification.specimens.bodies import block, graded, moved
from geoswarm.verification.specimens.soils import elastic, mohr_coulomb

__all__ = ["LENGTH", "WEIGHT", "InfiniteSlope"]

YOUNG, POISSON, WEIGHT = 1.0e5, 0.3, 20.0
LENGTH = 8.0
"""Over depth."""


@dataclass(frozen=True)
class InfiniteSlope:
    """Slope parallel to its rough base, without water, whose friction follows from its factor of safety.

    ``angle`` degree; ``depth`` m, vertical; ``c`` kPa; ``safety`` = (c + gamma z cos^2 tan phi)/(gamma z sin cos);
    ``dilatancy`` psi over phi; ``cutoff`` tension kPa or None.

    The ends carry the stress that touches the limit on planes along the slope when it fails. That stress and the weight
    are in balance and within the limit at every depth for any safety from 1 on, and sliding along the base needs more
    than there is below 1: with associated flow the closed form is the limit of the discrete body, too.
    """

    angle: float
    depth: float
    c: float
    safety: float
    dilatancy: float
    cutoff: float | None

    @property
    def friction(self) -> float:
        """Friction angle, degree."""
        a = math.radians(self.angle)
        weight = WEIGHT * self.depth
        return math.degrees(
            math.atan((self.safety * weight * math.sin(a) * math.cos(a) - self.c) / (weight * math.cos(a) ** 2))
        )

    def soil(self) -> Material:
        """Its material."""
        phi = self.friction
        return mohr_coulomb(YOUNG, POISSON, self.c, phi, self.dilatancy * phi, self.cutoff, WEIGHT)

    def calculate(self) -> PhaseResult:
        """Elastic under its weight, then with its strength; DivergedError where it does not stand."""
        a, length = math.radians(self.angle), LENGTH * self.depth
        tangent = math.tan(a)
        mesh = moved(
            block(graded(0.0, length, 16), graded(-self.depth, 0.0, 5)),
            lambda x: x - np.column_stack([0.0 * x[:, 0], tangent * x[:, 0]]),
        )
        normal, shear = -WEIGHT * math.cos(a) ** 2, WEIGHT * math.sin(a) * math.cos(a)
        along = normal - 2.0 * shear * math.tan(math.radians(self.friction))
        sigma_x = math.cos(a) ** 2 * along + math.sin(a) ** 2 * normal + 2.0 * math.sin(a) * math.cos(a) * shear
        ends = (
            Traction("left", x_slope=sigma_x, y_slope=-sigma_x * tangent, level=0.0),
            Traction("right", x_slope=-sigma_x, y_slope=sigma_x * tangent, level=-length * tangent),
        )
        held = (Fixity("bottom", x=0.0, y=0.0),)
        weight = Phase("weight", "gravity", {"soil": elastic(YOUNG, POISSON, WEIGHT)}, fixities=held, tractions=ends)
        return solve_phases(mesh, [weight, Phase("strength", materials={"soil": self.soil()})], control=Control())[-1]

    def stands(self) -> bool:
        """Whether it carries its weight."""
        try:
            self.calculate()
        except DivergedError:
            return False
        return True
