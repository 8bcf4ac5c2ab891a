"""``geoswarm run``: the in-process calibration, its summary and its files."""

from __future__ import annotations

import csv
import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from geoswarm.cli import main
from geoswarm.cli.words.result import show_values
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.report.document.build import Report
from geoswarm.solver.runs import evaluators
from geoswarm.solver.system.versions import versions
from tests.solver.problems import decay_document

KEYS = [
    *("state", "stop_reasons", "objective", "parameters", "intervals", "verdicts", "search_best"),
    *("evaluations", "generations", "seconds", "seed", "fit"),
]


def write(folder: Path, **changes: Any) -> str:
    path = folder / "problem.json"
    path.write_text(json.dumps(decay_document(**changes)), encoding="utf-8")
    return str(path)


def test_json_has_exactly_the_agreed_keys(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stopping = {"max_evaluations": 1200, "target_objective": 1e-8}
    assert main(["run", write(tmp_path, answer=None, stopping=stopping), "--json"]) == 0
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert list(document) == [*KEYS, "compile_seconds"]
    assert document["compile_seconds"] == 0.0  # a formula needs no kernels
    assert document["state"] == "finished"
    assert document["stop_reasons"] == ["target_objective"]
    assert document["parameters"]["amplitude"] == pytest.approx(3.0, abs=1e-3)
    assert document["parameters"]["rate"] == pytest.approx(0.7, abs=1e-3)
    assert document["verdicts"] == {"amplitude": "identified", "rate": "identified"}
    assert document["seed"] == 11


def test_limits_that_cannot_be_kept_are_not_ignored_silently(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(evaluators, "WATCHED", False)
    assert main(["run", write(tmp_path, limits={"seconds_per_evaluation": 5}), "--json"]) == 0
    captured = capsys.readouterr()
    assert "limits apply only in the service" in captured.err
    assert json.loads(captured.out)["state"] == "finished"


def test_number_of_workers_and_seed_do_what_they_say(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path)
    outcomes = []
    for options in (["--seed", "5"], ["--seed", "5", "--workers", "2"], ["--seed", "6"]):
        assert main(["run", path, "--json", *options]) == 0
        document = json.loads(capsys.readouterr().out)
        del document["seconds"]
        outcomes.append(document)
    assert outcomes[0] == outcomes[1]
    assert outcomes[2]["seed"] == 6
    assert outcomes[2]["parameters"] != outcomes[0]["parameters"]


@pytest.mark.usefixtures("tables_only")
def test_the_written_problem_has_the_seed_that_was_used(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "output"
    assert main(["run", write(tmp_path, seed=None), "--output", str(folder), "--json"]) == 0
    first = json.loads(capsys.readouterr().out)
    assert main(["run", str(folder / "problem.json"), "--json"]) == 0
    second = json.loads(capsys.readouterr().out)
    told = {"seconds": 0}
    assert first | told == second | told


def test_table_shows_what_was_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    book = tmp_path / "book.yaml"
    book.write_text("amplitude: 2.5\nrate: 0.7\n", encoding="utf-8")
    assert main(["run", write(tmp_path), "--compare", str(book)]) == 0
    text = capsys.readouterr().out
    for words in ("amplitude", "best fit", "0.7", "objective at or below the target", "share of the objective"):
        assert words in text
    assert "that of book" in text


def test_a_set_with_mistakes_is_refused_before_the_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "book.yaml").write_text("amplitude: 2.5\n", encoding="utf-8")
    output = tmp_path / "out"
    command = ["run", write(tmp_path), "--output", str(output), "--compare", str(tmp_path / "book.yaml")]
    assert main(command) == 2
    assert "the set must give every free parameter; rate is missing" in capsys.readouterr().err
    assert not output.exists()


def test_output_folder_holds_tables_figures_and_a_problem_that_runs_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "deep" / "output"
    assert main(["run", write(tmp_path, answer=None), "--output", str(folder), "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    figures = ("convergence", "fit", "intervals", "matrix", "traces")
    tables = ("evaluations.csv", "generations.csv", "problem.json", "responses.npz", "result.json")
    expected = [
        *tables,
        "report.html",
        "report.pdf",
        *(f"{n}.{form}" for n in figures for form in ("png", "svg", "csv")),
    ]
    assert sorted(path.name for path in folder.iterdir()) == sorted(expected)
    result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    assert summary["fit"]["kind"] == "describes"
    assert {key: result[key] for key in KEYS if key != "fit"} == {key: summary[key] for key in KEYS if key != "fit"}
    assert result["versions"] == dict(versions())
    with (folder / "evaluations.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == summary["evaluations"]
    assert min(float(row["objective"]) for row in rows) == summary["objective"]
    assert ",".join(rows[0]) == "generation,particle,state,objective,amplitude,rate,misfit.y,reason,message,seconds"
    with (folder / "generations.csv").open(encoding="utf-8", newline="") as stream:
        generations = list(csv.DictReader(stream))
    assert len(generations) == summary["generations"]
    assert float(generations[-1]["objective"]) == summary["objective"]
    assert main(["run", str(folder / "problem.json"), "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    told = {"seconds": 0}
    assert again | told == summary | told


def test_without_matplotlib_the_tables_are_still_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    folder = tmp_path / "output"
    assert main(["run", write(tmp_path), "--output", str(folder)]) == 0
    assert "geoswarm[plots]" in capsys.readouterr().err
    assert sorted(path.name for path in folder.iterdir()) == (
        ["evaluations.csv", "generations.csv", "problem.json", "responses.npz", "result.json"]
    )


def test_tables_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "output"
    assert main(["run", write(tmp_path), "--output", str(folder), "--tables-only"]) == 0
    assert "figures" not in capsys.readouterr().err
    assert sorted(path.name for path in folder.iterdir()) == (
        ["evaluations.csv", "generations.csv", "problem.json", "responses.npz", "result.json"]
    )
    assert main(["run", write(tmp_path), "--tables-only"]) == 2
    assert "--tables-only needs --output DIR" in capsys.readouterr().err


@pytest.mark.usefixtures("tables_only")
def test_a_run_without_success_fails_with_its_reasons(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = {"kind": "formula", "series": {"y": "ln(-amplitude) * exp(-rate * x)"}}
    path = write(tmp_path, forward_model=model, stopping={"max_evaluations": 16})
    folder = tmp_path / "output"
    assert main(["run", path, "--json", "--output", str(folder)]) == 1
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert (document["state"], document["objective"], document["parameters"]) == ("failed", None, None)
    assert "all 16 evaluations failed (16 not finite)" in captured.err
    assert (folder / "evaluations.csv").exists()


@pytest.mark.usefixtures("tables_only")
def test_a_program_that_does_not_use_its_parameters_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = {"kind": "formula", "series": {"y": "0 * amplitude * rate + x"}}
    assert main(["run", write(tmp_path, forward_model=model, stopping={"max_evaluations": 24})]) == 0
    assert capsys.readouterr().err.count("runs so far gave the same objective, though their parameters differ") == 1


@pytest.mark.usefixtures("tables_only")
def test_some_failures_are_told_with_their_reasons(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = {"kind": "formula", "series": {"y": "amplitude * exp(-rate * x) + 0 * sqrt(rate - 0.4)"}}
    assert main(["run", write(tmp_path, forward_model=model, stopping={"max_evaluations": 24})]) == 0
    assert re.search(r"failed +\d+: \d+ not_finite \(series 'y' is nan", capsys.readouterr().out)


def test_output_that_cannot_be_made_is_refused_before_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    taken = tmp_path / "taken"
    taken.write_text("a file", encoding="utf-8")
    assert main(["run", write(tmp_path), "--output", str(taken / "below")]) == 2
    captured = capsys.readouterr()
    assert f"--output {taken / 'below'}" in captured.err
    assert captured.out == ""


def test_interrupted_run_tells_the_best_so_far(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from geoswarm.cli.local import run as run_module

    class Interrupting:
        def __init__(self, *_arguments: object) -> None:
            self.calls = 0

        def __enter__(self) -> Any:
            return self

        def __exit__(self, *_details: object) -> None:
            return None

        def __call__(self, *_arguments: object) -> None:
            self.calls += 1
            if self.calls == 3:
                raise KeyboardInterrupt

    monkeypatch.setattr(run_module, "progress_bar", Interrupting)
    assert main(["run", write(tmp_path)]) == 130
    captured = capsys.readouterr()
    assert "Best after 24 evaluations: objective" in captured.err
    assert "Interrupted." in captured.err


@pytest.mark.usefixtures("tables_only")
def test_a_warm_start_takes_the_runs_of_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sampling = {"method": {"kind": "monte_carlo", "samples": 60}, "stopping": None}
    aimed = {"method": {"kind": "particle_swarm", "particles": 8}}
    assert main(["run", write(tmp_path, **sampling), "--output", str(tmp_path / "first"), "--json"]) == 0
    evaluations = []
    for options in ([], ["--warm-start", str(tmp_path / "first")]):
        capsys.readouterr()
        assert main(["run", write(tmp_path, **aimed), "--json", *options]) == 0
        evaluations.append(json.loads(capsys.readouterr().out)["evaluations"])
    assert evaluations[1] <= evaluations[0]
    other = {"forward_model": {"kind": "formula", "series": {"y": "amplitude * exp(-rate * x / 2)"}}}
    assert main(["run", write(tmp_path, **aimed, **other), "--warm-start", str(tmp_path / "first")]) == 2
    assert "first has another forward model" in capsys.readouterr().err
    assert main(["run", write(tmp_path, **aimed), "--warm-start", str(tmp_path)]) == 2
    assert "lacks result.json" in capsys.readouterr().err


@pytest.mark.usefixtures("blank_figures")
def test_the_total_time_is_that_of_the_clock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ticks = iter([1000.0, 1510.0])
    monkeypatch.setattr("geoswarm.cli.local.run.monotonic", lambda: next(ticks))
    assert main(["run", write(tmp_path), "--output", str(tmp_path / "run")]) == 0
    told = capsys.readouterr()
    assert "8 min 30 s in all, with report and figures" in told.out
    assert "time of the runs" in told.out
    assert re.search(r"Writing the report and \d+ figures to ", told.err)


def test_the_answer_is_shown_before_figures_are_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shown: list[str] = []

    def save(report: Report, folder: Path, *, told: Callable[[int, int], None]) -> list[Path]:
        del report, told
        shown.append(capsys.readouterr().out)
        return [folder / "report.html"]

    monkeypatch.setattr(Report, "save", save)
    assert main(["run", write(tmp_path), "--output", str(tmp_path / "run")]) == 0
    assert "95 % from" in shown[0]
    assert "root mean square" in shown[0]


def test_the_answer_ends_with_the_next_step(capsys: pytest.CaptureFixture[str]) -> None:
    basins = {"what_to_do": [{"text": "'geoswarm explore' searches for further basins."}]}
    found = {"fit": {"kind": "describes"}, "linearisation": None, "verdicts": [], "basins": basins}
    problem = parse_problem(decay_document())
    show_values(problem, dict.fromkeys(problem.parameters, 1.0), found)
    assert capsys.readouterr().out.endswith("  Next: 'geoswarm explore' searches for further basins.\n")
