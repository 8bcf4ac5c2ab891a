"""Makes the readings anew: what Kratos gives at known parameters, with normal noise; their days stay."""

from __future__ import annotations

from pathlib import Path

from geoswarm.solver.runs.synthetic import write_readings

HERE = Path(__file__).resolve().parent
TRUTH = {"E_clay": 3000.0, "E_sand": 25_000.0}  # kPa
SEED = 1943

if __name__ == "__main__":
    write_readings(HERE / "problem.yaml", TRUTH, SEED, "Kratos 10.4.4", decimals=1)
