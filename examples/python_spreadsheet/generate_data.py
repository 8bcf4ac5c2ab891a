"""Makes the readings anew: what the spreadsheet gives at known parameters, with normal noise; their loads stay."""

from __future__ import annotations

from pathlib import Path

from geoswarm.solver.runs.synthetic import write_readings

HERE = Path(__file__).resolve().parent
TRUTH = {"Cc": 0.45, "sigma_p": 75.0}  # -, kPa
SEED = 1585

if __name__ == "__main__":
    write_readings(HERE / "problem.yaml", TRUTH, SEED, "the spreadsheet of this example in LibreOffice", decimals=1)
