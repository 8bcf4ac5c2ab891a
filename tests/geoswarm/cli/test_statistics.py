"""``geoswarm statistics``, ``report`` and ``reweight`` on a folder, and the follow-up problem."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from geoswarm.cli import main
from geoswarm.solver.problem import FixedParameter, LinkedParameter, load_problem
from tests.geoswarm.cli.conftest import without_figures
from tests.solver.problems import decay_document


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sampling in which two parameters act through their product only, as in ``a * k``."""
    place = tmp_path_factory.mktemp("run")
    document = decay_document(
        forward_model={"kind": "formula", "series": {"y": "amplitude * k * exp(-rate * x)"}},
        method={"kind": "monte_carlo", "samples": 2000},
        stopping={},
    )
    document["parameters"]["k"] = {"lower": 0.2, "upper": 5, "scale": "log"}
    path = place / "problem.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    with without_figures():
        assert main(["run", str(path), "--output", str(place / "out"), "--json"]) == 0
    return place / "out"


def test_statistics_say_what_the_data_say(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["statistics", str(folder)]) == 0
    assert "the sampling is too thin to judge" in capsys.readouterr().out
    assert main(["statistics", str(folder), "--threshold", "0.05"]) == 0
    captured = capsys.readouterr()
    assert "amplitude is determined only in combination with" in captured.out
    assert "fix:amplitude" in captured.out
    assert "of 2000 evaluations (monte carlo)" in captured.out
    assert main(["statistics", str(folder), "--threshold", "0.05", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["threshold"] == {
        "value": 0.05,
        "origin": "given",
        "explanation": "the threshold that you chose",
        "wanted": None,
    }


def test_accepted_proposals_give_a_problem_that_runs(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    following = tmp_path / "next.json"
    accept = ["--accept", "fix:k=2", "--accept", "fix:rate"]
    assert main(["statistics", str(folder), *accept, "--output", str(following)]) == 2
    assert "no such proposal; there are:" in capsys.readouterr().err
    assert main(["statistics", str(folder), "--accept", "fix:k=2", "--output", str(following)]) == 0
    problem = load_problem(following)
    assert problem.free_names == ("amplitude", "rate")
    fixed = problem.parameters["k"]
    assert isinstance(fixed, FixedParameter)
    assert fixed.value == 2.0
    assert main(["run", str(following), "--json"]) == 0
    capsys.readouterr()
    assert main(["statistics", str(folder), "--threshold", "0.05", "--accept", "link:k"]) == 0
    linked = json.loads(capsys.readouterr().out)
    path = tmp_path / "linked.json"
    path.write_text(json.dumps(linked), encoding="utf-8")
    assert isinstance(load_problem(path).parameters["k"], LinkedParameter)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["statistics", "{}", "--threshold", "-1"], "--threshold must be above 0, got -1"),
        (["statistics", "{}", "--accept", "fix:k=two"], "'two' is not a number"),
        (["statistics", "{}", "--accept", "link:k=2"], "only fix:NAME=VALUE takes a value"),
        (["statistics", "{}", "--output", "next.json"], "--output is the problem file of --accept"),
        (["statistics", "{}/problem.json"], "is a file; give the id of a job or the folder"),
        (["report", "{}", "--threshold", "0"], "--threshold must be above 0, got 0"),
        (["report", "{0}", "--compare", "{0}/problem.json"], "k: must be a number, got a mapping"),
        (["reweight", "{}"], "give --weight SERIES=WEIGHT or --weighting SCHEME"),
        (["reweight", "{}", "--weight", "y"], "--weight must be NAME=NUMBER, for example --weight settlement=2; got y"),
        (["reweight", "{}", "--weight", "q=1"], "unknown series q"),
    ],
)
def test_mistakes_are_reported(
    folder: Path, arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([argument.format(folder) for argument in arguments]) == 2
    assert words in capsys.readouterr().err


def test_a_folder_without_a_run_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(tmp_path)]) == 2
    assert "lacks problem.json" in capsys.readouterr().err


@pytest.mark.usefixtures("blank_figures")
def test_report_writes_what_is_asked_for(folder: Path, tmp_path: Path) -> None:
    assert main(["report", str(folder), "--html", "--output", str(tmp_path / "one")]) == 0
    assert [p.name for p in (tmp_path / "one").iterdir()] == ["report.html"]
    assert main(["report", str(folder), "--pdf", "--figures", "--output", str(tmp_path / "two")]) == 0
    names = {p.name for p in (tmp_path / "two").iterdir()}
    assert {"report.pdf", "matrix.svg", "matrix.png", "matrix.csv"} <= names
    assert "report.html" not in names


def test_reweight_tells_shares_and_writes_the_problem(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    changed = tmp_path / "changed.json"
    assert main(["reweight", str(folder), "--weight", "y=4", "--output", str(changed)]) == 0
    assert "100 %" in capsys.readouterr().out
    assert load_problem(changed).observations[0].weight == 4.0
    assert main(["reweight", str(folder), "--weighting", "by_error", "--noise", "y=0.1", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["moved"] is False
    assert document["best"]["objective"] == document["best_before"]["objective"]
