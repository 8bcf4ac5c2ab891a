"""Makes the readings anew: what CalculiX gives at known parameters, with normal noise; their loads stay."""

from __future__ import annotations

from pathlib import Path

from geoswarm.solver.runs.synthetic import write_readings

HERE = Path(__file__).resolve().parent
TRUTH = {"E_upper": 8000.0, "E_lower": 25000.0}  # kPa
SEED = 1

if __name__ == "__main__":
    write_readings(HERE / "problem.yaml", TRUTH, SEED, "CalculiX 2.20", decimals=2)
