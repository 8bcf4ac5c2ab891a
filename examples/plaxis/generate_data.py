"""Makes the readings anew with what answers as PLAXIS, at known parameters, with normal noise; their days stay."""

from __future__ import annotations

from pathlib import Path

from geoswarm.solver.runs.synthetic import write_readings

HERE = Path(__file__).resolve().parent
TRUTH = {"lambda_star": 0.1, "mu_star": 5.0e-3}
SEED = 1586

if __name__ == "__main__":
    write_readings(HERE / "problem.yaml", TRUTH, SEED, "a stand-in for PLAXIS", decimals=1)
