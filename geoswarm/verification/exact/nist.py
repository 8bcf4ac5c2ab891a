"""Four problems of the NIST Statistical Reference Datasets, nonlinear regression, with their certified results.

Source: National Institute of Standards and Technology, StRD archive (Misra1a: D. Misra 1978; Thurber: R. Thurber 1979;
MGH09: Kowalik and Osborne 1978, in More, Garbow and Hillstrom 1981; BoxBOD: Box, Hunter and Hunter 1978). Certified
values have eleven digits. ``tests/verification/nist`` checks them against each other with 60-digit arithmetic: at the
certified parameters the residual sum of squares and the gradient are what they must be, which a mistyped digit would
spoil.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

__all__ = ["PROBLEMS", "Certified"]


@dataclass(frozen=True, slots=True)
class Certified:
    """A data set: model, points, bounds that we chose, and certified values.

    ``parameters`` maps a name to (certified value, certified standard deviation, lower bound, upper bound);
    ``start`` are the second start values.
    """

    name: str
    expression: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    parameters: dict[str, tuple[float, float, float, float]]
    residual_sum_of_squares: float
    start: tuple[float, ...]

    def document(self, **changes: Any) -> dict[str, Any]:
        """As a problem file of kind ``formula``."""
        return {
            "name": self.name,
            "forward_model": {"kind": "formula", "series": {"y": self.expression}},
            "parameters": {
                name: {"lower": lower, "upper": upper} for name, (_, _, lower, upper) in self.parameters.items()
            },
            "observations": [{"series": "y", "points": {"x": list(self.x), "y": list(self.y)}}],
            "method": {"kind": "particle_swarm", "particles": 20},
            "stopping": {"max_evaluations": 2000},
            "seed": 1,
        } | changes


MISRA1A = Certified(
    "Misra1a",
    "b1 * (1 - exp(-b2 * x))",
    (77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0),
    (10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78),
    {
        "b1": (2.3894212918e02, 2.7070075241e00, 50.0, 600.0),
        "b2": (5.5015643181e-04, 7.2668688436e-06, 1e-4, 2e-3),
    },
    1.2455138894e-01,
    (250.0, 5.0e-4),
)

THURBER = Certified(
    "Thurber",
    "(b1 + b2 * x + b3 * x**2 + b4 * x**3) / (1 + b5 * x + b6 * x**2 + b7 * x**3)",
    (
        *(-3.067, -2.981, -2.921, -2.912, -2.840, -2.797, -2.702, -2.699, -2.633, -2.481, -2.363, -2.322, -1.501),
        *(-1.460, -1.274, -1.212, -1.100, -1.046, -0.915, -0.714, -0.566, -0.545, -0.400, -0.309, -0.109, -0.103),
        *(0.010, 0.119, 0.377, 0.790, 0.963, 1.006, 1.115, 1.572, 1.841, 2.047, 2.200),
    ),
    (
        *(80.574, 84.248, 87.264, 87.195, 89.076, 89.608, 89.868, 90.101, 92.405, 95.854, 100.696, 101.060, 401.672),
        *(390.724, 567.534, 635.316, 733.054, 759.087, 894.206, 990.785, 1090.109, 1080.914, 1122.643, 1178.351),
        *(1260.531, 1273.514, 1288.339, 1327.543, 1353.863, 1414.509, 1425.208, 1421.384, 1442.962, 1464.350),
        *(1468.705, 1447.894, 1457.628),
    ),
    {
        "b1": (1.2881396800e03, 4.6647963344e00, 1000.0, 1600.0),
        "b2": (1.4910792535e03, 3.9571156086e01, 1000.0, 2000.0),
        "b3": (5.8323836877e02, 2.8698696102e01, 200.0, 1000.0),
        "b4": (7.5416644291e01, 5.5675370270e00, 0.0, 200.0),
        "b5": (9.6629502864e-01, 3.1333340687e-02, 0.5, 1.5),
        "b6": (3.9797285797e-01, 1.4984928198e-02, 0.2, 0.6),
        "b7": (4.9727297349e-02, 6.5842344623e-03, 0.0, 0.15),
    },
    5.6427082397e03,
    (1300.0, 1500.0, 500.0, 75.0, 1.0, 0.4, 0.05),
)

MGH09 = Certified(
    "MGH09",
    "b1 * (x**2 + b2 * x) / (x**2 + b3 * x + b4)",
    (4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625),
    (0.1957, 0.1947, 0.1735, 0.16, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246),
    {
        "b1": (1.9280693458e-01, 1.1435312227e-02, 0.01, 1.0),
        "b2": (1.9128232873e-01, 1.9633220911e-01, 0.0, 2.0),
        "b3": (1.2305650693e-01, 8.0842031232e-02, 0.0, 2.0),
        "b4": (1.3606233068e-01, 9.0025542308e-02, 0.0, 2.0),
    },
    3.0750560385e-04,
    (0.25, 0.39, 0.415, 0.39),
)

BOXBOD = Certified(
    "BoxBOD",
    "b1 * (1 - exp(-b2 * x))",
    (1.0, 2.0, 3.0, 5.0, 7.0, 10.0),
    (109.0, 149.0, 149.0, 191.0, 213.0, 224.0),
    {
        "b1": (2.1380940889e02, 1.2354515176e01, 50.0, 500.0),
        "b2": (5.4723748542e-01, 1.0455993237e-01, 0.05, 3.0),
    },
    1.1680088766e03,
    (100.0, 0.75),
)

PROBLEMS = (MISRA1A, THURBER, MGH09, BOXBOD)
