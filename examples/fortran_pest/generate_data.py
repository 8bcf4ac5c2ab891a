"""Makes the readings anew: what the program gives at known parameters, with normal noise; their days stay."""

from __future__ import annotations

from pathlib import Path

from geoswarm.solver.runs.synthetic import write_readings

HERE = Path(__file__).resolve().parent
TRUTH = {"E_oed": 1800.0, "k": 2.0e-4}  # kPa, m/day
SEED = 1581

if __name__ == "__main__":
    write_readings(HERE / "problem.yaml", TRUTH, SEED, "the Fortran program of this example", decimals=2)
