"""The examples of docs/python.md run as scripts, and the example of the pile finds what its data were made from."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import geoswarm as gs
from tests.api.conftest import line_problem
from tests.integration.engines import PATIENCE

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
PILE = ROOT / "examples" / "pile_tz"


def ran(script: Path, *options: str) -> str:
    command = [sys.executable, "-W", "error", *options, str(script)]
    # All of this environment: settings of the linear algebra library change the last bits of a search.
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "agg"}
    done = subprocess.run(
        command, cwd=script.parent, env=environment, capture_output=True, text=True, check=False, timeout=PATIENCE
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize(
    ("number", "longer", "shorter", "expected"),
    [
        (0, '"max_evaluations": 600', '"max_evaluations": 60', "s_end is identified"),
        # tests/geoswarm/test_python_interface.py resumes a calibration and reads its runs
        pytest.param(
            1,
            "seed=1,",
            'seed=1, stopping={"max_evaluations": 60},',
            r"max_evaluations: .*\n.* \(\d+, 3\)\n",
            marks=pytest.mark.slow,
        ),
        (2, "120", "30", "'a': "),
    ],
)
def test_examples_of_the_page_run(tmp_path: Path, number: int, longer: str, shorter: str, expected: str) -> None:
    """With fewer evaluations than the page shows, which take half of the time."""
    assert len(BLOCKS) == 3
    assert BLOCKS[number].count(longer) == 1
    (tmp_path / "problem.yaml").write_text(json.dumps(line_problem()))
    script = tmp_path / "example.py"
    script.write_text(BLOCKS[number].replace(longer, shorter))
    assert re.search(expected, ran(script))
    if number == 0:
        assert (tmp_path / "report" / "report.html").is_file()


def test_every_name_of_the_page_is_there_and_no_other_is_missing() -> None:
    assert all(hasattr(gs, name) for name in re.findall(r"\bgs\.(\w+)", PAGE))
    told = {"DEFAULT_STOPPING", "InProcessWarning", "ProblemError", "SolverError", "calibrate", "evaluate", "series"}
    assert all(name in PAGE for name in told | {"fixed", "free", "linked", "load_problem", "observed", "problem"})


def test_the_readings_of_the_pile_are_those_of_its_model() -> None:
    namespace: dict[str, object] = {"__file__": str(PILE / "pile.py"), "__name__": "pile"}
    exec(compile((PILE / "pile.py").read_text(), "pile.py", "exec"), namespace)  # noqa: S102
    load, settlement = namespace["readings"]()  # type: ignore[operator]
    stored = np.loadtxt(PILE / "load_test.csv", delimiter=",", skiprows=2)
    np.testing.assert_array_equal(stored[:, 0], load)
    np.testing.assert_allclose(stored[:, 1], 1000.0 * settlement, atol=1e-9)


@pytest.mark.slow
def test_the_pile_finds_the_truth_by_script_and_problem_file() -> None:
    printed = ran(PILE / "fit.py", "-B")
    found = {name: float(value) for name, value in re.findall(r"^(\w+) +([\d.e+-]+)$", printed, re.MULTILINE)}
    assert 52.0 < found["shaft"] < 57.0
    assert 2.2e-3 < found["w_shaft"] < 2.8e-3
    assert 2100.0 < found["base"] < 2800.0
    assert printed.count("is identified") == 3
    result = gs.calibrate(gs.load_problem(PILE / "problem.yaml"))
    assert found == {name: float(f"{value:.5g}") for name, value in result.parameters.items()}
    assert 2e-9 < result.objective < 2e-8  # a reading error of 0.1 mm
