"""Numbers of Meier et al. (2008), doi 10.1155/2008/574613; kN, m, day, degree."""

from __future__ import annotations

from typing import Any

__all__ = ["ISOTROPIC", "OEDOMETER", "SLOPE"]

OEDOMETER: dict[str, Any] = {
    "laboratory": {"lambda_star": 0.064, "kappa_star": 0.035, "mu_star": 1.46e-3, "phi": 20.0, "c": 27.0, "psi": 0.0},
    "identified": {"lambda_star": 0.082, "kappa_star": 0.051, "c": 25.0},
    "bounds": {
        "lambda_star": (0.002, 1.0, "log"),
        "kappa_star": (0.001, 0.5, "log"),
        "mu_star": (1e-5, 0.75, "log"),
        "phi": (8.0, 30.0, "linear"),
        "c": (0.001, 100.0, "linear"),
    },
    "stages": [
        *((9, 2.0), (13, 1.0), (25, 1.0), (50, 1.0), (100, 1.0), (200, 1.0), (400, 1.0), (800, 1.0), (400, 1.0)),
        *((200, 1.0), (100, 1.0), (50, 1.0), (100, 1.0), (200, 1.0), (400, 1.0), (800, 43.0 / 24.0)),
    ],
    "samples": 2000,
    "filter": 1e-7,
    "correlations": {("lambda_star", "c"): 0.88, ("lambda_star", "kappa_star"): 0.64},
    "not_identifiable": ("mu_star", "phi"),
    "cycles": 159,
    "runs": 1590,
    "objective": 5e-9,
    "height": 0.02021,
}
"""Application A. The ring had an inner diameter of 71.45 mm, which a material point does not need."""

ISOTROPIC: dict[str, Any] = {
    "laboratory": {"lambda_star": 0.064, "kappa_star": 0.035, "mu_star": 1.30e-3, "phi": 20.0, "c": 27.0, "psi": 0.0},
    "identified": {"lambda_star": 0.089, "mu_star": 2.33e-3},
    "bounds": {
        "lambda_star": (6.74e-3, 1.0, "log"),
        "mu_star": (1e-5, 0.75, "log"),
        "c": (0.001, 100.0, "linear"),
    },
    "samples": 1820,
    "filter": 2e-7,
    "correlation": 0.96,
    "good_c": (20.0, 90.0),
    "good_lambda_star": (0.064, 0.165),
    "line": (0.057, 0.00106),
    "cycles": 50,
    "runs": 500,
    "height": 0.09855,
    "diameter": 0.04988,
}
"""Application B. The filter and the line are those of an earlier independent calculation: the paper prints neither."""

SLOPE: dict[str, Any] = {
    "laboratory": {
        **{"lambda_star": 0.064, "kappa_star": 0.035, "mu_star": 1.46e-3, "phi": 10.0},
        **{"G": 5560.0, "c": 0.01, "psi": 0.0},
    },
    "identified": {"lambda_star": 1.42, "kappa_star": 0.60, "mu_star": 0.145, "phi": 10.7, "G": 5160.0},
    "bounds": {
        "lambda_star": (0.01, 2.0, "log"),
        "kappa_star": (0.005, 1.0, "log"),
        "mu_star": (0.001, 1.5, "log"),
        "phi": (8.0, 16.0, "linear"),
        "G": (200.0, 20000.0, "log"),
    },
    "correlation": 0.92,
    "cycles": 82,
    "runs": 820,
    "length": 1080.0,
    "triangles": 1070,
    "rock": 20.0,
    "years": 33.0,
}
"""Application C. The paper prints neither the number of its samples nor its filter, and no coordinates."""
