"""A footing with CalculiX: calibrated, compared with our own finite elements, and not fooled by its two traps."""

from __future__ import annotations

import json
import runpy
import shutil
from pathlib import Path

import numpy as np
import pytest

from geoswarm.cli import main
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.forward.cross_section import SectionModel
from geoswarm.solver.identifiability import design, from_evaluations
from geoswarm.solver.identifiability.optimum.polish import polish
from geoswarm.solver.problem import load_problem, parse_problem
from geoswarm.solver.runs.synthetic import write_readings
from tests.examples.engines import HERE, assert_identified, assert_same_readings, copy_of, find_engine

TRUTH = {"E_upper": 8000.0, "E_lower": 25000.0}
POINTS = {"centre": 0.0, "at_2m": 2.0, "at_5m": 5.0}


@pytest.fixture
def problem(tmp_path: Path) -> Path:
    find_engine("ccx", "calculix-ccx")
    return copy_of("calculix", tmp_path / "example")


@pytest.mark.slow
def test_the_true_values_lie_in_the_intervals(
    problem: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert_identified(problem, tmp_path / "out", capsys, TRUTH, ratio=1.15)


def test_the_readings_are_those_of_the_program(problem: Path) -> None:
    runpy.run_path(str(problem.parent / "generate_data.py"), run_name="__main__")
    assert_same_readings("calculix", problem.parent, digit=0.01)


def test_the_deck_is_that_of_the_script() -> None:
    script = runpy.run_path(str(HERE / "calculix" / "make_deck.py"))
    assert script["deck"]() == (HERE / "calculix" / "footing.inp.in").read_text(encoding="utf-8")


def settled(problem: Path, values: dict[str, float], loads: FloatArray) -> FloatArray:
    """Settlements of the three points, (3, n), m."""
    found = load_problem(problem).model.prepare(dict.fromkeys(POINTS, loads))(values | {"nu": 0.3})
    return np.array([found[name] for name in POINTS])


def test_what_is_read_is_smooth_far_below_the_noise(problem: Path) -> None:
    """Seven digits are printed, and nothing is interpolated: within 1e-4 of the noise of 0.2 mm.

    Elastic settlements are proportional to the load and to 1/E; third differences over E show no steps.
    """
    noise = 0.2e-3
    loads = np.array([50.0, 100.0, 150.0, 200.0])
    found = settled(problem, TRUTH, loads)
    assert found == pytest.approx(found[:, -1:] * loads / 200.0, abs=1e-4 * noise)
    stiffer = {name: 2.0 * value for name, value in TRUTH.items()}
    assert settled(problem, stiffer, loads) == pytest.approx(found / 2.0, abs=1e-4 * noise)
    for name, value in TRUTH.items():
        steps = [settled(problem, TRUTH | {name: value * (1.0 + 1e-3 * step)}, loads) for step in range(-3, 4)]
        assert np.abs(np.diff(steps, 3, axis=0)).max() < 5e-4 * noise
        assert np.abs(np.diff(steps, 1, axis=0)).max() > 0.02 * noise


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_intervals_hold_the_true_values_whatever_the_seed(problem: Path) -> None:
    """Of 20 intervals of 95 %, 16 or fewer hold the truth once in 60 times, 14 or fewer once in 3000."""
    held = dict.fromkeys(TRUTH, 0)
    for seed in range(1, 21):
        write_readings(problem, TRUTH, seed, "CalculiX 2.20", decimals=2)
        calibration = Calibration(load_problem(problem), 1)
        optimum = polish(calibration, np.array(list(TRUTH.values()))).parameters
        plan = design(calibration, optimum, step=2e-3)
        found = from_evaluations(calibration, plan, [calibration.evaluate(x) for x in plan.positions])
        for name, value in TRUTH.items():
            interval = found.interval(name)
            assert interval is not None
            held[name] += interval[0] < value < interval[1]
    assert all(count >= 17 for count in held.values()), held
    assert sum(held.values()) < 40, "intervals of 95 % that never miss are too wide"


# 16 s; tests/solver/fem/test_solve.py compares the same elements with closed forms
@pytest.mark.slow
def test_our_own_finite_elements_settle_alike(problem: Path) -> None:
    """Eight-node rectangles there, six-node triangles here: 0.2 % apart at most, at 200 kPa."""
    loaded = load_problem(problem)
    loads = np.array([50.0, 200.0])
    theirs = loaded.model.prepare(dict.fromkeys(POINTS, loads))(TRUTH | {"nu": 0.3})
    section = {
        "kind": "section",
        "surface": [[0, 0], [20, 0]],
        "layers": [{"name": "upper", "thickness": 3, "rows": 8}, {"name": "lower", "bottom": -10, "rows": 8}],
        "segments": [{"name": "footing", "start": 0, "end": 1}],
        "points": {name: {"x": x} for name, x in POINTS.items()},
        "element_length": 0.25,
        "fixities": {"left": "horizontal", "right": "horizontal", "bottom": "both"},
        "materials": {name: {"law": "elastic", "E": f"E_{name}", "nu": 0.3} for name in ("upper", "lower")},
        "phases": [
            {"name": "weightless", "kind": "gravity", "materials": {"upper": "upper", "lower": "lower"}},
            {"name": "load", "kind": "plastic", "loads": [{"boundary": "footing", "pressure": 200}]},
        ],
    }
    ours = parse_problem(
        {
            "forward_model": section,
            "parameters": {name: {"lower": 1000, "upper": 1e5} for name in TRUTH},
            "observations": [{"series": "centre.uy", "points": {"x": [0.0], "y": [0.0]}}],
            "stopping": {"max_evaluations": 10},
        }
    ).model
    assert isinstance(ours, SectionModel)
    moved = ours.calculate(TRUTH).displacements("load")
    for name in POINTS:
        settled = -moved[ours.nominal.points[name], 1]
        assert theirs[name][1] == pytest.approx(settled, rel=2e-3)
        assert theirs[name][0] == pytest.approx(theirs[name][1] / 4.0, rel=1e-6)


def tried(problem: Path, capsys: pytest.CaptureFixture[str]) -> tuple[str, str, str]:
    """Reason, failure and how the program ended, of a single run."""
    assert main(["model", "try", str(problem), "--json"]) == 1
    document = json.loads(capsys.readouterr().out)
    (run,) = document["runs"]
    shutil.rmtree(run["folder"])
    return document["reason"], run["failure"], run["ended"]


def test_exit_status_0_without_a_deck_is_a_failure(problem: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = problem.read_text(encoding="utf-8")
    problem.write_text(text.replace("[ccx, -i, footing]", "[ccx, -i, fotting]"), encoding="utf-8")
    reason, failure, ended = tried(problem, capsys)
    assert (reason, ended) == ("program_failed", "ended with exit status 0")
    assert "output: *ERROR in readinput: cannot open file fotting.inp" in failure


def test_no_rule_is_needed_to_see_it(problem: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = problem.read_text(encoding="utf-8").replace("[ccx, -i, footing]", "[ccx, -i, fotting]")
    kept = [line for line in text.splitlines() if not line.startswith(("  success:", "  fail:"))]
    problem.write_text("\n".join(kept), encoding="utf-8")
    reason, failure, ended = tried(problem, capsys)
    assert (reason, ended) == ("no_output", "ended with exit status 0")
    assert "ccx ended with exit status 0, but has not written footing.dat" in failure


@pytest.mark.parametrize("call", ["fotting", "footing"])
def test_an_old_result_never_counts(problem: Path, call: str, capsys: pytest.CaptureFixture[str]) -> None:
    """An old footing.dat among the files: refused where the program leaves it, replaced where it runs."""
    loaded = load_problem(problem)
    series = {name: np.array([200.0]) for name in POINTS}
    right = loaded.model.prepare(series)(TRUTH | {"nu": 0.3})
    old = "\n".join(
        f" displacements (vx,vy,vz) for set POINTS and time {time}\n\n" + "   1 0.0 -1.0 0.0\n" * 3
        for time in range(1, 5)
    )
    (problem.parent / "footing.dat").write_text(old, encoding="utf-8")
    text = problem.read_text(encoding="utf-8").replace(
        "[ccx, -i, footing]", f"[ccx, -i, {call}]\n  files: [footing.dat]"
    )
    kept = [line for line in text.splitlines() if not line.startswith(("  success:", "  fail:"))]
    problem.write_text("\n".join(kept), encoding="utf-8")
    if call == "fotting":
        reason, failure, ended = tried(problem, capsys)
        assert (reason, ended) == ("no_output", "ended with exit status 0")
        assert "footing.dat is older than the run" in failure
    else:
        again = load_problem(problem).model.prepare(series)(TRUTH | {"nu": 0.3})
        assert {name: y.tolist() for name, y in again.items()} == {name: y.tolist() for name, y in right.items()}
