"""What water that flows in a specimen adds to a test: the permeability, and what is measured of a column of points."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laboratory.quantities import Quantity
from geoswarm.solver.laws.base import Law
from geoswarm.solver.laws.sources import TAVENAS, TERZAGHI
from geoswarm.solver.parameter_info import ParameterInfo, outside_limits

__all__ = [
    "AXIAL_STRAIN",
    "BASE",
    "FLOW",
    "HORIZONTAL",
    "K0_MEAN",
    "MEAN_STRESS",
    "OUTPUT",
    "STRAIN",
    "STRESS",
    "VERTICAL",
    "VOID_RATIO",
    "flow_fault",
    "growth_of",
    "permeability_of",
    "pore_pressure_at",
]

OUTPUT: Final = 5
STRESS, STRAIN, BASE, VERTICAL, HORIZONTAL = range(OUTPUT)
"""What is observed of a column: total vertical stress, settlement over the initial height, excess pore pressure at the
base (or where it is measured), mean vertical and mean horizontal effective stress over the height of particles."""

FLOW = (
    ParameterInfo(
        "k",
        "k",
        "m/day",
        "Permeability where the test begins; 1e-9 m/s is 8.64e-5 m/day.",
        lower=0.0,
        lower_open=True,
        typical=(1.0e-7, 1.0e-2),
        source=f"{TERZAGHI}, article 14 (silts and clays)",
    ),
    ParameterInfo(
        "C_k",
        "C_k",
        "",
        "Change of the void ratio for a tenfold permeability; 0: the permeability is constant.",
        default=0.0,
        lower=0.0,
        typical=(0.2, 2.0),
        source=TAVENAS,
    ),
)

AXIAL_STRAIN = Quantity(
    "axial_strain",
    "Axial strain",
    "axial strain",
    "",
    lambda seen: seen.rows[:, STRAIN] - seen.reference[STRAIN],
)
VOID_RATIO = Quantity(
    "void_ratio",
    "Mean void ratio",
    "void ratio",
    "",
    lambda seen: seen.voids.of_settlement(seen.rows[:, STRAIN]),
)
MEAN_STRESS = Quantity(
    "mean_effective_stress",
    "Vertical effective stress, mean over the height",
    "mean effective stress",
    "kPa",
    lambda seen: seen.rows[:, VERTICAL],
)
K0_MEAN = Quantity(
    "K0",
    "Ratio of horizontal to vertical effective stress, means over the height",
    "K0",
    "",
    lambda seen: seen.rows[:, HORIZONTAL] / seen.rows[:, VERTICAL],
)


def pore_pressure_at(where: str) -> Quantity:
    """The pore pressure where it is measured, in words."""
    return Quantity(
        "pore_pressure",
        f"Pore pressure {where}",
        "pore pressure",
        "kPa",
        lambda seen: seen.rows[:, BASE] + seen.pore,
    )


def flow_fault(law: Law, parameters: Mapping[str, float], knows_voids: bool) -> str | None:
    """What is inadmissible about the parameters given, of a law and of the flow in a specimen, or None."""
    fault = outside_limits(FLOW, parameters)
    if fault is None and parameters.get("C_k", 0.0) > 0.0 and not knows_voids:
        fault = f"C_k needs the initial void ratio; where that is not given C_k must be 0, got {parameters['C_k']:g}"
    own = {info.name for info in FLOW}
    return fault or law.inadmissible({name: one for name, one in parameters.items() if name not in own})


def growth_of(change: float, void_ratio: float | None) -> float:
    """Growth of ln k with the relative length: ln(10)/C_k for each unit of the void ratio; C_k = 0: none."""
    return math.log(10.0) * (1.0 + (void_ratio or 0.0)) / change if change > 0.0 else 0.0


def permeability_of(law: Law, parameters: Mapping[str, float], void_ratio: float | None) -> tuple[float, float]:
    """Permeability where the test begins, m/day, and its growth.

    Raises
    ------
    InfeasibleError
        A parameter is missing or inadmissible.
    """
    fault = flow_fault(law, parameters, void_ratio is not None)
    if fault is not None or "k" not in parameters:
        raise InfeasibleError(fault or "the flow of water needs k, which is not given")
    return parameters["k"], growth_of(parameters.get("C_k", 0.0), void_ratio)
