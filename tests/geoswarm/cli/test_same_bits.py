"""A calibration gives the same bits with every set of instructions that its processor offers to NumPy and OpenBLAS."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from geoswarm.solver.system import environment
from tests.contracts.repository import ROOT
from tests.geoswarm.cli.interruptions import history

HASWELL = {"OPENBLAS_CORETYPE": "Haswell"}
NARROW = {"NPY_DISABLE_CPU_FEATURES": environment.WIDER}
PROBLEMS: dict[str, dict[str, Any]] = {
    "oedometer": {"stopping": {"max_evaluations": 60}},
    "isotropic_compression": {"stopping": {"max_evaluations": 60}},
    "combined": {"stopping": {"max_evaluations": 60}},
    "slope": {"stopping": {"max_evaluations": 20}},
    "formula": {"method": {"kind": "monte_carlo", "samples": 200}, "stopping": {}},
}


@pytest.mark.slow  # the slope's runs take seconds; the variables themselves are tested in tests/solver/system
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("name", PROBLEMS)
def test_histories_are_the_same_with_all_instructions(name: str, tmp_path: Path) -> None:
    folder = ROOT / "examples" / name
    problem = yaml.safe_load((folder / "problem.yaml").read_text(encoding="utf-8")) | PROBLEMS[name]
    for table in folder.glob("*.csv"):
        (tmp_path / table.name).write_bytes(table.read_bytes())
    (tmp_path / "problem.json").write_text(json.dumps(problem), encoding="utf-8")
    neutral = {
        key: value for key, value in os.environ.items() if key not in {**HASWELL, **NARROW, environment.SWITCH: ""}
    }
    histories = []
    for number, given in enumerate(({}, HASWELL, NARROW, HASWELL | NARROW)):
        output = tmp_path / str(number)
        command = [sys.executable, "-m", "geoswarm", "run", "problem.json", "--seed", "1", "--output", str(output)]
        subprocess.run(command, cwd=tmp_path, env=neutral | given, capture_output=True, check=True)
        histories.append(history(output))
    assert histories[1:] == histories[:1] * 3
