"""Load and settlement of the head of a bored pile: hyperbolic t-z springs along the shaft, one at the base.

Run it to make load_test.csv anew: the model at TRUTH plus a reading error of NOISE. The data are synthetic.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

LENGTH, DIAMETER = 12.0, 0.6  # m
MODULUS = 30e6  # kPa, concrete
SLICES = 60

TRUTH = {"shaft": 55.0, "w_shaft": 0.0025, "base": 2400.0}  # kPa, m, kPa
NOISE = 1.0e-4  # m, standard deviation of a settlement reading
SEED = 20
LOADS = np.arange(100.0, 1401.0, 100.0)  # kN


def settlement(shaft, w_shaft, base, w_base=0.03):
    """Settlement of the head [m] over the load [kN].

    Parameters
    ----------
    shaft, base
        Largest shear stress along the shaft and pressure at the base [kPa].
    w_shaft, w_base
        Displacements at which half of it acts [m].

    Returns
    -------
    By series load and settlement: geoswarm interpolates at the loads of the test.
    """
    area = 0.25 * np.pi * DIAMETER**2
    step = LENGTH / SLICES
    displacement = np.geomspace(1e-7, 0.5, 400)  # of the base; then up the shaft, slice by slice
    force = area * base * displacement / (displacement + w_base)
    for _ in range(SLICES):
        middle = displacement + 0.5 * step * force / (MODULUS * area)
        force = force + np.pi * DIAMETER * step * shaft * middle / (middle + w_shaft)
        displacement = middle + 0.5 * step * force / (MODULUS * area)
    return {"settlement": (force, displacement)}


def readings():
    """Loads [kN] and settlements [m] of the test, rounded to 0.01 mm."""
    force, displacement = settlement(**TRUTH)["settlement"]
    error = np.random.default_rng(SEED).normal(0.0, NOISE, LOADS.size)
    return LOADS, np.round(np.interp(LOADS, force, displacement) + error, 5)


if __name__ == "__main__":
    lines = [f"{load:.0f},{1000.0 * value:.2f}" for load, value in zip(*readings(), strict=True)]
    head = f"# SYNTHETIC: the model at {TRUTH}, reading error {1000 * NOISE:g} mm, seed {SEED}\nx,y\n"
    path = Path(__file__).with_name("load_test.csv")
    path.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")
