"""Finds the springs of the pile from its load test: python fit.py"""

from pathlib import Path

import numpy as np
from pile import settlement

import geoswarm as gs

HERE = Path(__file__).parent


def fit(workers=1):
    """Calibrate the function of pile.py; returns the result."""
    load, measured = np.loadtxt(HERE / "load_test.csv", delimiter=",", skiprows=2, unpack=True)
    return gs.calibrate(
        settlement,
        parameters={
            "shaft": gs.free(10, 300, scale="log"),  # kPa
            "w_shaft": gs.free(2e-4, 2e-2, scale="log"),  # m
            "base": gs.free(300, 10_000, scale="log"),  # kPa
            "w_base": gs.fixed(0.03),  # m, 5 % of the diameter
        },
        observations={"settlement": gs.observed(load, measured, error=0.1, x_unit="kN", y_unit="mm")},
        series={"settlement": gs.series(x_unit="kN", y_unit="m")},
        method={"kind": "particle_swarm", "particles": 12},
        stopping={"max_evaluations": 900, "stagnation_generations": 30},
        seed=5,
        workers=workers,
        quick_runs=True,
    )


if __name__ == "__main__":
    result = fit(workers=2)
    for name, value in result.parameters.items():
        print(f"{name:8} {value:10.5g}")
    for verdict in result.statistics().verdicts:
        print(verdict.sentence)
