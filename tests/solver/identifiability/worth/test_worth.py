"""The worth of candidate tests: against the textbook for a line, and by brute force."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.calibration import calibrate
from geoswarm.solver.errors import ProblemError, SolverError
from geoswarm.solver.problem.draft import inlined_document
from tests.solver.identifiability.cases import WHITE, X, free, problem_of
from tests.solver.identifiability.worth.brute_force import PROBLEMS, designed, fitted, scatter

NOISE = 0.05 * np.random.default_rng(2).standard_normal(X.size)


def reading(name: str, *x: float, error: float | None = 0.05, **more: Any) -> dict[str, Any]:
    one = {"series": "y", "points": {"x": list(x)}} | ({} if error is None else {"error": error})
    return {"name": name, "observations": [one]} | more


@pytest.fixture(scope="module")
def line() -> Any:
    points = {"x": X.tolist(), "y": (1.0 + 2.0 * X + NOISE).tolist()}
    problem = problem_of(
        "a + b * x",
        {"a": free(-10.0), "b": free(-10.0)},
        X,
        observations=[{"series": "y", "points": points, "error": 0.05}],
        method={"kind": "particle_swarm", "particles": 10, "acceleration": "none"},
        noise=WHITE,
    )
    return calibrate(problem, seed=3)


def test_reductions_of_a_line_are_those_of_the_normal_equations(line: Any) -> None:
    found = line.design({"candidates": [reading("near", 0.0), reading("far", 8.0, 9.0)]}, draws=0)
    rows = np.stack([np.ones_like(X), X], axis=1)
    before = np.linalg.inv(rows.T @ rows)
    for candidate in found.candidates:
        at = np.array([[1.0, 0.0]]) if candidate.name == "near" else np.array([[1.0, 8.0], [1.0, 9.0]])
        after = np.linalg.inv(rows.T @ rows + at.T @ at)
        expected = 1.0 - np.sqrt(np.diag(after) / np.diag(before))
        assert list(candidate.parameters.values()) == pytest.approx(expected, abs=2e-4)
        volume = 1.0 - (np.linalg.det(after) / np.linalg.det(before)) ** 0.25
        assert candidate.volume == pytest.approx(volume, abs=2e-4)
        half = 1.959964 * 0.05 * np.sqrt(after[1, 1])
        low, high = candidate.intervals["b"]
        assert (high - low) / 2.0 == pytest.approx(half, rel=1e-3)
    assert found.best.name == "far"


def test_a_prediction_decides_where_one_is_given(line: Any) -> None:
    candidates = {"candidates": [reading("at zero", *[0.0] * 6), reading("far", 9.0, cost=2.0)]}
    for one in candidates["candidates"]:
        one["cost"] = 2.0
    other = {
        "name": "intercept",
        "forward_model": {"kind": "formula", "series": {"s": "a + 0 * b * x"}},
        "observations": [{"series": "s", "points": {"x": [1.0]}}],
    }
    found = line.design(candidates, predict=other, draws=0)
    assert (found.criterion, found.predicted, found.best.name) == ("prediction", "intercept", "at zero")
    rows = np.stack([np.ones_like(X), X], axis=1)
    at = np.array([[1.0, 0.0]] * 6)
    before, after = np.linalg.inv(rows.T @ rows), np.linalg.inv(rows.T @ rows + at.T @ at)
    assert found.best.prediction == pytest.approx(1.0 - np.sqrt(after[0, 0] / before[0, 0]), abs=2e-4)
    assert found.best.per_cost == pytest.approx(-np.log(1.0 - found.best.prediction) / 2.0)


def test_readings_of_the_same_series_have_the_error_of_the_job(line: Any) -> None:
    found = line.design({"candidates": [reading("stated", 8.0), reading("of the job", 8.0, error=None)]}, draws=2)
    first, second = found.candidates
    assert first.widths == pytest.approx(second.widths)


def test_a_parameter_without_influence_is_told_by_the_test_that_reads_it() -> None:
    problem = problem_of(
        "a * x + 0 * b",
        {"a": free(), "b": free(1.0, 5.0)},
        2.0 * X + NOISE,
        method={"kind": "particle_swarm", "particles": 10, "acceleration": "none"},
    )
    reads_b = reading("b itself", 1.0, error=0.01, forward_model={"kind": "formula", "series": {"y": "b * x"}})
    found = calibrate(problem, seed=3).design({"candidates": [reading("more of a", 4.0), reads_b]})
    assert found.best.name == "b itself"
    assert found.best.parameters["b"] > 0.98
    assert found.best.parameters["a"] == pytest.approx(0.0, abs=1e-6)


def test_two_basins_are_told_apart_by_the_reading_that_differs() -> None:
    y = 4.0 * np.exp(-0.5 * X) + 1.3**2 * X + NOISE
    problem = problem_of(
        "b * exp(-0.5 * x) + (a - 3)**2 * x",
        {"a": free(0.1, 5.9), "b": free()},
        y,
        stopping={"max_evaluations": 600},
        method={"kind": "particle_swarm", "particles": 30, "acceleration": "none"},
    )
    other = {"kind": "formula", "series": {"y": "a * x"}}
    candidates = {"candidates": [reading("again", 1.0, 2.0), reading("a", 1.0, error=0.5, forward_model=other)]}
    found = {c.name: c for c in calibrate(problem, seed=5).design(candidates).candidates}
    assert found["again"].distinguishes == pytest.approx(0.5, abs=0.1)
    assert found["a"].distinguishes == pytest.approx(0.995, abs=0.01)  # 2.6 apart in units of 0.5


def expression(name: str, formula: str, **more: Any) -> dict[str, Any]:
    return reading(name, 8.0, forward_model={"kind": "formula", "series": {"y": formula}}, **more)


def test_a_candidate_that_fails_leaves_the_others_their_places(line: Any) -> None:
    """A place at which one candidate failed was lost for all."""
    sound, optimum = expression("sound", "a + b * x"), line.parameters["a"]
    (alone,) = line.design({"candidates": [sound]}, draws=6).candidates
    fragile = expression("fragile", f"a + b * x + 0 * ln(a - {optimum - 0.02})")
    found = line.design({"candidates": [fragile, sound]}, draws=6)
    assert {c.name: c for c in found.candidates}["sound"] == alone
    assert {c.name for c in found.candidates} == {"fragile", "sound"}
    assert found.centres == 7
    assert 0 < found.failed < 35
    assert any(f"Of 35 runs, {found.failed} of fragile failed, such as not_finite: " in one for one in found.remarks)
    (places,) = [one for one in found.remarks if one.startswith("Of 7 places around the optimum, ")]
    assert "fragile has its worth from " in places
    assert "sound" not in places
    found = line.design({"candidates": [expression("never", "ln(-1 - a**2 - b**2)"), sound]}, draws=6)
    assert found.candidates == (alone,)
    assert "Never has no worth, because its runs failed." in found.remarks
    other = {"name": "later", "forward_model": {"kind": "formula", "series": {"s": "ln(-1 - a**2 - b**2)"}}}
    with pytest.raises(SolverError, match="no sensitivities of later could be calculated, because runs failed: not_f"):
        line.design(
            {"candidates": [sound]}, predict=other | {"observations": [{"series": "s", "points": {"x": [1.0]}}]}
        )


@pytest.mark.parametrize(
    ("change", "path"),
    [
        ({"candidates": []}, "candidates"),
        ({"candidates": [reading("x", 1.0), reading("x", 2.0)]}, "candidates"),
        ({"candidates": [reading("x", 1.0, cost=1.0), reading("y", 2.0)]}, "candidates"),
        ({"candidates": [{"name": "x", "observations": [{"series": "z", "points": {"x": [1]}}]}]},
         "candidates[0].observations[0].series"),
        ({"candidates": [reading("x", 1.0, error=None, forward_model={"kind": "formula", "series": {"y": "a * x"}})]},
         "candidates[0].observations[0].error"),
        ({"candidates": [reading("x", 1.0, forward_model={"kind": "formula", "series": {"y": "k * x"}})]},
         "parameters.k"),
        ({"candidates": [reading("x", 1.0, forward_model={"kind": "nonsense"})]}, "candidates[0].forward_model.kind"),
        ({"forward_model": {"kind": "formula", "series": {"y": "a * x"}}}, "forward_model"),
        ({"candidates": [reading("x", 1.0)], "weighting": "by_test"}, "weighting"),
    ],
)  # fmt: skip
def test_mistakes_are_told_with_their_path(line: Any, change: dict[str, Any], path: str) -> None:
    with pytest.raises(ProblemError) as caught:
        line.design(change)
    assert path in {issue.path for issue in caught.value.issues}, caught.value


def table(folder: Path, changes: str = "") -> Path:
    """A file of two triaxial tests in a table, the second over ten times the strain."""
    for name, scale in (("short", 1.0), ("long", 10.0)):
        rows = "\n".join(f"{scale * x},{10.0 * x}" for x in (0.1, 0.2, 0.4))
        (folder / f"{name}.csv").write_text(f"axial strain [%],q [kPa]\n{rows}\n")
    (folder / "tests.csv").write_text("file,kind,cell pressure [kPa]\nshort.csv,CD,100\nlong.csv,CD,100\n")
    file = folder / "further.yaml"
    file.write_text(f"tests: {{table: tests.csv, material: elastic{changes}}}\nparameters: {{nu: {{value: 0.3}}}}\n")
    return file


def test_each_test_of_a_table_is_a_candidate(tmp_path: Path) -> None:
    problem = problem_of("E * x", {"E": free(100.0, 5000.0)}, 1000.0 * X + 20.0 * NOISE)
    result = calibrate(problem, seed=3, method={"kind": "particle_swarm", "particles": 10, "acceleration": "none"})
    file = table(tmp_path, ", q_error: 1")
    found = result.design(file, draws=0)
    assert [one.name for one in found.candidates] == ["long", "short"]
    alone = reading("short", 0.001, 0.002, 0.004, error=1.0)
    alone["observations"][0]["series"] = "q"
    alone["forward_model"] = {
        "kind": "triaxial",
        "material": "elastic",
        "initial_stress": 100.0,
        "shearing": [{"kind": "monotonic", "axial_strain": 0.004}],
    }
    same = result.design({"candidates": [alone], "parameters": {"nu": {"value": 0.3}}}, draws=0)
    assert found.candidates[1].widths == pytest.approx(same.best.widths)
    sent = {key: value for key, value in inlined_document(file).items() if key != "name"}  # as the client does
    assert result.design(sent, draws=0).to_json() == found.to_json()
    near = {"candidates": [reading("x", 1.0, error=1.0)]}
    assert result.design(near, predict=file, draws=0).predicted == "further"
    with pytest.raises(ProblemError, match="no error of a reading of q"):
        result.design(table(tmp_path), draws=0)


def _rank(name: str, repeats: int, draws: int, seed: int) -> int:
    """Place of the proposed candidate in the order by brute force, from 1."""
    choice = PROBLEMS[name]
    y = choice.curve(np.array(choice.truth), choice.x)
    y = y + choice.error * np.random.default_rng(seed).standard_normal(y.size)
    low, high = (np.array([p[end] for p in choice.parameters.values()]) for end in ("lower", "upper"))
    log = np.array([p["scale"] == "log" for p in choice.parameters.values()])
    unit = fitted(choice, y, ())
    best = np.where(log, low * (high / low) ** unit, low + unit * (high - low))
    found = designed(choice, y, best, draws)
    measured = scatter(choice, repeats)
    return sorted(measured, key=lambda candidate: measured[candidate]).index(found.best.name) + 1


@pytest.mark.parametrize("name", list(PROBLEMS))
def test_the_proposed_test_is_best_or_second_best_by_brute_force(name: str) -> None:
    assert _rank(name, 40, 2, 0) <= 3  # 40 experiments know a deviation to a tenth


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", list(PROBLEMS))
def test_the_proposed_test_is_best_or_second_best_of_ten_in_many_experiments(name: str, seed: int) -> None:
    assert _rank(name, 600, 8, seed) <= 2
