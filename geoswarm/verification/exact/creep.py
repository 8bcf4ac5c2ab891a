"""Soft soil creep in its translated form: P = p + a with a = c cot(phi), P_eq = P + q^2/(M^2 P).

Vermeer & Neher (1999); strains are small, compression positive, stresses in kPa and times in days.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from geoswarm.solver.arrays import FloatArray

__all__ = ["Creep", "cone"]


def cone(K0nc: float, nu: float, ratio: float) -> float:
    """M of a stress ratio at rest, ``ratio`` being lambda*/kappa* (Brinkgreve 1994)."""
    deviator = (1.0 - K0nc) / (1.0 + 2.0 * K0nc)
    elastic = (1.0 - K0nc) * (1.0 - 2.0 * nu) * (ratio - 1.0)
    below = (1.0 + 2.0 * K0nc) * (1.0 - 2.0 * nu) * ratio - (1.0 - K0nc) * (1.0 + nu)
    return 3.0 * math.sqrt(deviator**2 + elastic / below)


@dataclass(frozen=True, slots=True)
class Creep:
    """A soil by its constants; ``tau`` in days."""

    lambda_star: float
    kappa_star: float
    mu_star: float
    c: float
    phi: float
    M: float
    nu: float = 0.15
    tau: float = 1.0

    @property
    def attraction(self) -> float:
        """c cot(phi), kPa."""
        return self.c / math.tan(math.radians(self.phi))

    @property
    def beta(self) -> float:
        """(lambda* - kappa*)/mu*."""
        return (self.lambda_star - self.kappa_star) / self.mu_star

    def equivalent(self, lateral: float, vertical: float) -> float:
        """P_eq of a state without shear stresses on its axes."""
        P, q = (2.0 * lateral + vertical) / 3.0 + self.attraction, vertical - lateral
        return P + q * q / (self.M**2 * P)

    def isotropic(self, start: float, OCR: float, stages: Sequence[tuple[float, float]]) -> FloatArray:
        """Volume strain at the end of stages (stress, duration) of all-round stress, in closed form.

        Each begins with the elastic strain kappa* ln(P/P_0) and goes on with mu* ln(1 + t/tau (P/P_p)^beta).
        """
        before, past, creep, elastic = start + self.attraction, OCR * (start + self.attraction), 0.0, 0.0
        found = []
        for stress, duration in stages:
            P = stress + self.attraction
            elastic += self.kappa_star * math.log(P / before)
            more = self.mu_star * math.log1p(duration / self.tau * (P / past) ** self.beta)
            past *= math.exp(more / (self.lambda_star - self.kappa_star))
            before, creep = P, creep + more
            found.append(elastic + creep)
        return np.array(found)

    def rates(self, lateral: float, vertical: float, log_past: float) -> tuple[float, float, float]:
        """Creep rates of volume, lateral and vertical strain."""
        P, q = (2.0 * lateral + vertical) / 3.0 + self.attraction, vertical - lateral
        equivalent = P + q * q / (self.M**2 * P)
        alpha = 1.0 - (q / (self.M * P)) ** 2
        volume = self.mu_star / self.tau * math.exp(self.beta * (math.log(equivalent) - log_past))
        deviator = volume / alpha * 2.0 * q / (self.M**2 * P)  # of the shear strain 2/3 (vertical - lateral)
        return volume, volume / 3.0 - 0.5 * deviator, volume / 3.0 + deviator

    def oedometer(
        self, start: tuple[float, float], OCR: float, stages: Sequence[tuple[float, FloatArray]]
    ) -> list[FloatArray]:
        """Vertical strain, lateral stress and ln(P_p) of an oedometer test, (3, m) for each stage.

        A stage is (stress, times), the times since its beginning. What happens at once is elastic: the lateral stress
        grows by nu/(1 - nu) of the vertical one, the strain by kappa* ln(P/P_0). What follows under the constant
        stress is an initial value problem.
        """
        lateral, vertical = start
        strain, log_past = 0.0, math.log(OCR * self.equivalent(lateral, vertical))
        share = self.nu / (1.0 - self.nu)
        found = []
        for stress, times in stages:
            before = (2.0 * lateral + vertical) / 3.0 + self.attraction
            lateral, vertical = lateral + share * (stress - vertical), stress
            after = (2.0 * lateral + vertical) / 3.0 + self.attraction
            strain += self.kappa_star * math.log(after / before)

            def change(_: float, y: FloatArray, stress: float = stress) -> list[float]:
                sideways = float(y[1])
                volume, across, along = self.rates(sideways, stress, float(y[2]))
                K = ((2.0 * sideways + stress) / 3.0 + self.attraction) / self.kappa_star
                G = 1.5 * K * (1.0 - 2.0 * self.nu) / (1.0 + self.nu)
                stiff, beside = K + 4.0 / 3.0 * G, K - 2.0 / 3.0 * G
                # no lateral strain: elastic = -across there, and the elastic axial strain keeps the vertical stress
                axial = 2.0 * beside * across / stiff
                return [axial + along, beside * axial - (stiff + beside) * across, volume / self.past_slope]

            y = np.array([strain, lateral, log_past])
            path = solve_ivp(
                change, (0.0, float(times[-1])), y, "Radau", times, rtol=1.0e-10, atol=1.0e-12, first_step=1.0e-10
            )
            found.append(path.y)
            strain, lateral, log_past = path.y[:, -1].tolist()
        return found

    @property
    def past_slope(self) -> float:
        """lambda* - kappa*."""
        return self.lambda_star - self.kappa_star
