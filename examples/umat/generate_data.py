"""Makes the readings anew: what the routine gives at known parameters, with normal noise; the stages stay."""

from __future__ import annotations

from pathlib import Path

from geoswarm.solver.runs.synthetic import write_readings

HERE = Path(__file__).resolve().parent
TRUTH = {"E_ref": 4000.0, "m": 0.6, "ratio": 5.0}  # kPa, 1, 1
SEED = 1939

if __name__ == "__main__":
    write_readings(HERE / "problem.yaml", TRUTH, SEED, "the user routine of this example", decimals=3)
