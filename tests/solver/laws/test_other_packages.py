"""A law of another package: one file and one line of registration are enough for laboratory tests and sections."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

MODELS = Path(__file__).parents[2] / "models"

CALCULATE = """
import json, sys
import numpy as np
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.warm import groups_of

document = json.loads(sys.argv[1])
problem = parse_problem(document)
run = problem.model.prepare({one.series: one.x for one in problem.observations})
found = run(problem.values([document["at"]])) if "at" in document else run(problem.values([3.0e3]))
print(json.dumps([{name: y.tolist() for name, y in found.items()}, groups_of(problem.forward_model)]))
"""

E, NU, RATIO, TIME = 3.0e3, 0.25, 1.5, 2.0
CONFINED = E * (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU))
TIMES = [0.5, 2.0, 4.0]


def delayed(time: float) -> float:
    """Strain over that at once, under constant stress."""
    return 1.0 + RATIO * -math.expm1(-time / TIME)


def answer(forward_model: dict[str, object], series: str, x: list[float]) -> subprocess.CompletedProcess[str]:
    """Calculate with the package installed, in a process of its own, as a law is there from the beginning."""
    document = {
        "name": "other",
        "forward_model": forward_model,
        "parameters": {"E": {"lower": 1.0, "upper": 1.0e5}}
        | {name: {"value": value} for name, value in (("nu", NU), ("ratio", RATIO), ("T", TIME))},
        "observations": [{"series": series, "points": {"x": x, "y": [0.0] * len(x)}}],
        "method": {"kind": "monte_carlo", "samples": 1},
    }
    paths = os.pathsep.join([str(MODELS), *sys.path])
    return subprocess.run(
        [sys.executable, "-c", CALCULATE, json.dumps(document)],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": paths},
    )


def oedometer(**changes: object) -> dict[str, object]:
    """One load of 50 kPa more."""
    return {
        **{"kind": "oedometer", "material": "standard_solid", "height": 0.02, "initial_stress": 20.0},
        **{"stages": [{"stress": 70.0, "duration": 4.0}], "geometry": "fixed", "tolerance": 1.0e-6, **changes},
    }


@pytest.mark.parametrize(
    ("discretization", "tolerance", "group"),
    [("material_point", 1.0e-4, "element_test"), ("finite_element", 2.0e-3, "section")],
)
def test_the_oedometer_follows_the_closed_form(discretization: str, tolerance: float, group: str) -> None:
    # Finite elements step time to first order: the error goes with the root of what is granted to one step.
    extra = {"unit_weight": 0.0, "tolerance": 1.0e-7} if discretization == "finite_element" else {}
    done = answer(oedometer(discretization=discretization, **extra), "axial_strain", TIMES)
    assert done.returncode == 0, done.stderr
    found, groups = json.loads(done.stdout)
    expected = [50.0 / CONFINED * delayed(time) for time in TIMES]
    assert found["axial_strain"] == pytest.approx(expected, rel=tolerance)
    assert {group, "other_laws"} <= set(groups)


def test_a_section_settles_by_the_closed_form() -> None:
    section = {
        "kind": "section",
        "surface": [[0, 2], [4, 2]],
        "layers": [{"name": "ground", "thickness": 2}],
        "points": {"A": {"x": 2}},
        "element_length": 2,
        "materials": {"clay": {"law": "standard_solid", "E": "E", "nu": "nu", "ratio": "ratio", "T": "T"}},
        "control": {"time_tolerance": 1.0e-6, "largest_steps": 5000},
        "phases": [
            {"name": "weight", "kind": "gravity", "materials": {"ground": "clay"}},
            {
                **{"name": "load", "kind": "creep", "duration": 4},
                "loads": [{"boundary": "surface", "pressure": 50}],
            },
        ],
    }
    done = answer(section, "A.uy", TIMES)
    assert done.returncode == 0, done.stderr
    found, _ = json.loads(done.stdout)
    # Time and displacement are counted from before the load, which is there at once.
    expected = [-2.0 * 50.0 / CONFINED * delayed(time) for time in TIMES]
    assert found["A.uy"] == pytest.approx(expected, rel=1.0e-3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        # Each is a process of its own; tests/solver/forward/test_any_law.py and tests/solver/element_test/
        # test_load_paths.py have the slow three with laws of this package.
        ({"material": "no_plane"}, "K0 is missing: material no_plane has none"),
        pytest.param(
            {"material": "no_plane", "K0": 0.5, "discretization": "finite_element"},
            "no stress update",
            marks=pytest.mark.slow,
        ),
        pytest.param({"OCR": 2.0}, "OCR is given, which material standard_solid does not have", marks=pytest.mark.slow),
        pytest.param({"material": "standard_liquid"}, "unknown law 'standard_liquid'", marks=pytest.mark.slow),
    ],
)
def test_what_is_missing_is_reported(changes: dict[str, object], message: str) -> None:
    done = answer(oedometer(**changes), "axial_strain", TIMES)
    assert done.returncode == 1
    assert message in done.stderr
