"""Follow-ups, such as ``geoswarm sensitivity`` and ``predict``: on a folder, a problem file, and a job."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from geoswarm.cli import main
from geoswarm.client import Client
from tests.api.test_uncertainty import noisy, textbook
from tests.geoswarm.cli.conftest import without_figures
from tests.geoswarm.client.conftest import client, engine, server
from tests.integration.engines import PATIENCE
from tests.solver.identifiability.test_leaving_out import curves, fit, scattered

__all__ = ["client", "engine", "server"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sampling of a noisy line."""
    place = tmp_path_factory.mktemp("run")
    path = place / "problem.json"
    path.write_text(json.dumps(noisy()), encoding="utf-8")
    with without_figures():
        assert main(["run", str(path), "--output", str(place / "out"), "--json"]) == 0
    return place / "out"


def told(capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    found: dict[str, object] = json.loads(capsys.readouterr().out)
    return found


@pytest.mark.usefixtures("blank_figures")
def test_a_folder_keeps_what_was_evaluated(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sensitivity", str(folder)]) == 0
    shown = capsys.readouterr()
    assert "standard error" in shown.out
    assert f"Evaluations kept in {folder / 'sensitivity'}" in shown.err
    assert main(["profile", str(folder), "--json"]) == 0
    profiles = told(capsys)["profiles"]
    assert [p["parameter"] for p in profiles] == ["a", "b"]  # type: ignore[attr-defined]
    assert main(["influence", str(folder), "--kind", "morris", "--samples", "8"]) == 0
    assert "mean |effect|" in capsys.readouterr().out
    assert main(["posterior", str(folder), "--noise", "0.05", "--json"]) == 0
    assert told(capsys)["trusted"] is True
    assert main(["statistics", str(folder), "--json"]) == 0
    row = told(capsys)["linearisation"]["parameters"]["b"]  # type: ignore[index]
    assert row["standard_error"] == pytest.approx(textbook()[1], rel=1e-5)
    assert main(["report", str(folder), "--figures", "--posterior", "--output", str(tmp_path)]) == 0
    assert {"profiles.svg", "posterior.png", "global_sensitivity.csv"} <= {path.name for path in tmp_path.iterdir()}
    assert main(["report", str(folder / "profile"), "--html", "--output", str(tmp_path)]) == 0
    assert "Profile objectives of a, b" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_sensitivities_elsewhere_do_not_change_the_result(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = tmp_path / "out"
    copy.mkdir()
    for file in folder.iterdir():
        if file.is_file():
            (copy / file.name).write_bytes(file.read_bytes())
    assert main(["sensitivity", str(copy), "--at", "a=3", "--at", "b=1", "--no-polish"]) == 0
    capsys.readouterr()
    assert main(["statistics", str(copy), "--json"]) == 0
    found = told(capsys)
    best = json.loads((copy / "result.json").read_text(encoding="utf-8"))["parameters"]
    assert {one["parameter"]: one["best"] for one in found["projections"]} == best  # type: ignore[attr-defined]


def test_a_follow_up_that_was_cut_off_continues(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = tmp_path / "out"
    shutil.copytree(folder, copy, ignore=shutil.ignore_patterns("sensitivity", "profile", "morris"))

    @contextmanager
    def cut_off(*_: object) -> Iterator[Callable[..., None]]:
        def stop(*_: object) -> None:
            raise KeyboardInterrupt

        yield stop

    with monkeypatch.context() as changed:
        changed.setattr("geoswarm.cli.local.running.progress_bar", cut_off)
        assert main(["sensitivity", str(copy)]) == 130
    assert (copy / "sensitivity" / "run.journal").is_file()
    assert main(["statistics", str(copy), "--json"]) == 0
    capsys.readouterr()
    assert main(["sensitivity", str(copy)]) == 0
    assert "Continuing after 5 runs." in capsys.readouterr().err
    assert not (copy / "sensitivity" / "run.journal").exists()
    whole = tmp_path / "whole"
    shutil.copytree(folder, whole, ignore=shutil.ignore_patterns("sensitivity", "profile", "morris"))
    assert main(["sensitivity", str(whole)]) == 0
    told = [(place / "sensitivity" / "responses.npz").read_bytes() for place in (copy, whole)]
    assert told[0] == told[1]


def test_a_problem_file_needs_an_optimum(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    problem = str(folder / "problem.json")
    assert main(["sensitivity", problem]) == 2
    assert "a, b: no value; give --at NAME=VALUE" in capsys.readouterr().err
    assert main(["sensitivity", problem, "--at", "a=1", "--at", "q=2"]) == 2
    assert "q: no free parameter" in capsys.readouterr().err
    assert main(["sensitivity", problem, "--at", "a=1", "--at", "b=2", "--no-polish", "--json"]) == 0
    assert told(capsys)["linearisation"]["at_optimum"] is False  # type: ignore[index]
    assert main(["profile", problem, "--at", "a=1", "--at", "b=2", "--parameter", "b", "--noise", "y=0.05"]) == 0
    shown = capsys.readouterr().out
    assert "95 % from" in shown
    assert main(["sensitivity", problem, "--noise", "much"]) == 2
    assert "--noise must be a number, or SERIES=NUMBER; got much" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.usefixtures("blank_figures")
def test_each_test_of_a_folder_is_left_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    problem = curves(*scattered(1, 4))
    path, folder = tmp_path / "problem.json", tmp_path / "out"
    path.write_text(json.dumps(problem.document() | {"seed": 1}), encoding="utf-8")
    assert main(["run", str(path), "--output", str(folder), "--json"]) == 0
    capsys.readouterr()
    assert main(["jackknife", str(folder), "--by", "test"]) == 0
    shown = capsys.readouterr()
    assert "At most 19 runs, which the fits without each test share." in shown.err
    assert "fitted without each test" in shown.out
    assert "pulled most by" in shown.out
    assert main(["statistics", str(folder), "--json"]) == 0
    found = told(capsys)["linearisation"]["without_tests"]["parameters"]["b"]  # type: ignore[index]
    assert found["values"]["test_2"] == pytest.approx(fit(problem, 1)[1], rel=1e-3)
    assert main(["report", str(folder), "--html", "--output", str(tmp_path)]) == 0
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.count("Fitted again without each test.") == 1
    assert "By linearisation, without further runs." not in page
    assert main(["report", str(folder / "jackknife"), "--html", "--output", str(tmp_path)]) == 0
    assert "Fitted without each of 4 tests." in (tmp_path / "report.html").read_text(encoding="utf-8")


@pytest.mark.usefixtures("blank_figures")
def test_a_table_of_tests_is_predicted_with_the_law_of_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, folder, table = tmp_path / "problem.json", tmp_path / "out", tmp_path / "further.csv"
    y = [10.1, 19.8, 30.3, 39.9, 60.1]
    document = {
        "forward_model": {
            **{"kind": "triaxial", "material": "elastic", "initial_stress": 50},
            "shearing": [{"kind": "monotonic", "axial_strain": 0.01}],
        },
        "parameters": {"E": {"lower": 1000, "upper": 100000}, "nu": {"value": 0.3}},
        "observations": [{"series": "q", "points": {"x": [0.001, 0.002, 0.003, 0.004, 0.006], "y": y}}],
        "stopping": {"max_evaluations": 60},
        "seed": 1,
    }
    path.write_text(json.dumps(document), encoding="utf-8")
    (tmp_path / "A.csv").write_text("axial strain [%],q [kPa]\n0.1,10\n0.2,20\n", encoding="utf-8")
    table.write_text("file,kind,cell pressure [kPa]\nA.csv,CD,100\n", encoding="utf-8")
    assert main(["run", str(path), "--output", str(folder), "--json"]) == 0
    capsys.readouterr()
    assert main(["predict", str(folder), "--tests", str(table), "--runs", "40", "--json"]) == 0
    (one,) = told(capsys)["series"]  # type: ignore[misc,attr-defined]
    assert (one["series"], one["inside"]) == ("A.q", 2)
    assert (folder / "predict" / "further" / "prediction.json").is_file()
    assert main(["predict", str(folder)]) == 2
    assert "give --problem or --tests; neither is given" in capsys.readouterr().err


def test_of_one_test_none_is_left_out(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["jackknife", str(folder)]) == 2
    assert "needs at least 3 tests with readings, got a single one" in capsys.readouterr().err


@pytest.mark.slow
def test_a_job_gets_follow_up_jobs(client: Client, capsys: pytest.CaptureFixture[str]) -> None:
    job = client.wait(client.submit(noisy()).id, timeout=PATIENCE).id
    url = ["--url", client.base_url]
    assert main(["profile", job, "--parameter", "a", "--json", *url]) == 0
    captured = capsys.readouterr()
    assert "The sensitivities at the optimum come first." in captured.err
    found = json.loads(captured.out)
    assert found["job"] != job
    assert [p["parameter"] for p in found["profiles"]] == ["a"]
    assert main(["sensitivity", job, "--no-polish", *url]) == 0
    assert "standard error" in capsys.readouterr().out
    assert main(["influence", job, "--kind", "morris", "--samples", "8", *url]) == 0
    assert main(["posterior", job, *url]) == 0
    assert "equivalent to" in capsys.readouterr().out
    assert main(["profile", job, "--at", "a=1", *url]) == 2
    assert "give it to 'sensitivity'" in capsys.readouterr().err
