"""Makes the readings anew: what OpenGeoSys gives at known parameters, with normal noise; their days stay."""

from __future__ import annotations

from pathlib import Path

from geoswarm.solver.runs.synthetic import write_readings

HERE = Path(__file__).resolve().parent
TRUTH = {"E": 20_000.0, "c": 6.0, "phi": 20.0}  # kPa, kPa, degree
SEED = 1776

if __name__ == "__main__":
    write_readings(HERE / "problem.yaml", TRUTH, SEED, "OpenGeoSys 6.5.9", decimals=2)
