"""What commands say where a user was led astray before."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from geoswarm.cli import main
from geoswarm.cli.service import submit
from geoswarm.cli.service.connection import SLOW_ANSWER
from geoswarm.client import Client, GeoswarmError
from geoswarm.solver.examples import example_file
from geoswarm.solver.problem import load_problem, parse_problem
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from tests.solver.problems import decay_document

SCRIPT = """
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.examples import example_file
from geoswarm.solver.problem import load_problem
calibrate(load_problem("problem.json"), workers=2)
"""


def write(folder: Path, **changes: Any) -> str:
    path = folder / "problem.json"
    path.write_text(json.dumps(decay_document(**changes)), encoding="utf-8")
    return str(path)


def test_a_script_needs_no_main_guard_where_processes_are_watched(tmp_path: Path) -> None:
    write(tmp_path, stopping={"max_evaluations": 16})
    at_once = "from geoswarm.solver.runs import evaluators\nevaluators._START_SECONDS = 0.0\n"
    (tmp_path / "script.py").write_text(at_once + SCRIPT, encoding="utf-8")
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, check=False)
    assert done.returncode == 0


def test_a_script_without_a_main_guard_is_told_of_it_elsewhere(tmp_path: Path) -> None:
    write(tmp_path, stopping={"max_evaluations": 16})
    elsewhere = (
        "from geoswarm.solver.runs import evaluators\nevaluators.WATCHED, evaluators._START_SECONDS = False, 0.0\n"
    )
    (tmp_path / "script.py").write_text(elsewhere + SCRIPT, encoding="utf-8")
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    last = done.stderr.strip().splitlines()[-1]
    assert "must be below if __name__ == '__main__':" in last
    assert "out of memory" not in done.stderr


@pytest.mark.parametrize(
    "arguments", [["keys", "list"], ["keys", "revoke", "0f3a5c7e9b1d"], ["prune", "--older-than", "1d"]]
)
def test_looking_for_a_database_makes_none(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("GEOSWARM_DATABASE_URL", raising=False)
    assert main(arguments) == 2
    assert f"there is no database {tmp_path / 'geoswarm.db'}; name that of the service" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_keys_name_their_database(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    url = f"sqlite:///{tmp_path / 'jobs.db'}"
    Store(Settings(database_url=url)).close()
    assert main(["keys", "list", "--database", url]) == 0
    assert f"No keys in {url}" in capsys.readouterr().out
    assert main(["keys", "create", "--owner", "ann", "--database", url]) == 0
    assert f"Made in {url}" in capsys.readouterr().err


def test_a_key_that_cannot_be_sent(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    assert main(["list", "--api-key", "schlüssel"]) == 2
    assert "the API key has the character 'ü'; keys are printable ASCII" in capsys.readouterr().err
    monkeypatch.setenv("GEOSWARM_API_KEY", "a\nb")
    with pytest.raises(GeoswarmError, match="the API key in GEOSWARM_API_KEY has the character"):
        Client()


def test_an_export_is_what_its_name_says(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "latest", "--output", "r.xlsx"]) == 2
    assert "--output r.xlsx: the file could be .csv, .json or .parquet" in capsys.readouterr().err


def test_run_and_jobs_of_a_service(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    learning = {"kind": "particle_swarm", "particles": 8}
    assert main(["run", write(tmp_path, method=learning, warm_start={"jobs": ["abcd"]})]) == 2
    said = capsys.readouterr().err
    assert "'geoswarm submit' runs this problem there; here, give --warm-start DIR" in said


def test_the_root_mean_square_is_in_the_unit_of_the_data(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = {"kind": "formula", "series": {"y": {"expression": "a * x", "x_unit": "day", "y_unit": "m"}}}
    points = {"x": [1.0, 2.0], "y": [1003.0, 1996.0], "weight": [2.0, 2.0]}
    observation = {"series": "y", "points": points, "y_unit": "mm"}
    path = write(
        tmp_path,
        forward_model=model,
        parameters={"a": {"lower": 0.5, "upper": 1.5}},
        observations=[observation],
        stopping={"max_evaluations": 16},
    )
    assert main(["evaluate", path, "--set", "a=1"]) == 0
    assert "3.54 mm" in capsys.readouterr().out  # sqrt((3^2 + 4^2) / 2), whatever the weights have in common
    assert main(["check", path]) == 0
    assert "root mean square  y 3.54 mm" in capsys.readouterr().out
    assert main(["run", path]) == 0
    assert "root mean square" in capsys.readouterr().out


def test_a_cost_estimate_counts_the_search() -> None:
    from geoswarm.solver.runs.check import check_problem

    plain = check_problem(parse_problem(decay_document(stopping={"max_evaluations": 400})))
    method = {"kind": "particle_swarm", "particles": 8}
    learning = check_problem(parse_problem(decay_document(method=method, stopping={"max_evaluations": 400})))
    assert plain.estimated_seconds == pytest.approx(400 * plain.test_run.seconds)
    assert learning.estimated_seconds is not None
    assert learning.estimated_seconds > 2 * 400 * learning.test_run.seconds  # a search costs far more than this formula


class Service:
    """A service with five earlier jobs of the same forward model."""

    sent: Any = None

    def warm_starts(self, _problem: Any) -> list[Any]:
        return [SimpleNamespace(job=f"job{i}", name="decay", evaluations=10 * i) for i in range(1, 6)]

    def get(self, job: str) -> Any:
        return SimpleNamespace(id=f"whole-{job}")

    def submit(self, problem: Any, idempotency_key: str | None) -> Any:
        del idempotency_key
        Service.sent = problem
        return SimpleNamespace(id="new")

    def __enter__(self) -> Client:
        return cast(Client, self)

    def __exit__(self, *_: object) -> None:
        return None


def test_one_remark_on_jobs_to_learn_from_and_an_option_for_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(submit, "connect", lambda *_: Service())
    path = write(tmp_path, method={"kind": "particle_swarm", "particles": 8})
    assert main(["submit", path]) == 0
    captured = capsys.readouterr()
    assert captured.out == "new\n"
    assert len(captured.err.splitlines()) == 1
    assert "job1 (decay, 10 evaluations), job2" in captured.err
    assert f"and 2 more. To do so: geoswarm submit {path} --warm-start job1" in captured.err
    assert main(["submit", path, "--warm-start", "job1", "--warm-start", "job2"]) == 0
    assert capsys.readouterr().err == ""
    assert Service.sent == load_problem(path).document() | {"warm_start": {"jobs": ["whole-job1", "whole-job2"]}}


def test_a_posterior_sample_may_take_its_time() -> None:
    assert SLOW_ANSWER >= 600


def test_starters_can_be_checked_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from geoswarm.cli.start.starters import STARTERS

    for kind in STARTERS:
        folder = tmp_path / kind
        assert main(["init", kind, "--output", str(folder)]) == 0
        problem = load_problem(folder / "problem.yaml")
        assert problem.forward_model.kind in (kind, "combined")
        wanted = "tests:\n" if kind == "tests" else f"kind: {kind}\n"
        assert wanted in (folder / "problem.yaml").read_text(encoding="utf-8")
        assert list(folder.glob("*.csv"))
    assert main(["check", str(tmp_path / "oedometer" / "problem.yaml")]) == 0
    assert "measured points   226" in capsys.readouterr().out
    assert (tmp_path / "oedometer" / "problem.yaml").read_text(encoding="utf-8").count("#") > 15
    assert main(["init", "--output", str(tmp_path / "oedometer")]) == 2
    assert "never overwritten" in capsys.readouterr().err
    assert main(["init", "cone"]) == 2


def test_inline_writes_what_the_service_takes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["init", "formula", "--output", str(tmp_path)]) == 0
    capsys.readouterr()
    assert main(["inline", str(tmp_path / "problem.yaml")]) == 0
    document = json.loads(capsys.readouterr().out)
    assert parse_problem(document) == load_problem(tmp_path / "problem.yaml")
    assert document["observations"][0]["x_unit"] == "day"
    assert main(["inline", str(tmp_path / "problem.yaml"), "--output", str(tmp_path / "p.json")]) == 0
    assert json.loads((tmp_path / "p.json").read_text(encoding="utf-8")) == document


def test_readings_that_no_soil_can_have_need_accept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with example_file("oedometer") as file:
        document = load_problem(file).document()
    document["observations"][0]["y_unit"] = "m"
    document["stopping"] = {"max_evaluations": 10}
    path = tmp_path / "problem.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    for command in (["check"], ["run", "--output", str(tmp_path / "out")]):
        assert main([command[0], str(path), *command[1:]]) == 2
        told = capsys.readouterr().err
        assert "observations[0].y_unit: the largest reading, 3.66 m, is more than the height of the specimen" in told
        assert "accept: [settlement] or --accept settlement runs the problem as it is" in told
    assert not (tmp_path / "out").exists()
    assert main(["check", str(path), "--accept", "settlement"]) == 0
    assert "is more than the height of the specimen" in capsys.readouterr().err
    assert main(["check", str(path), "--accept", "settlements"]) == 2
    assert "accept[0]: unknown series 'settlements'; did you mean settlement?" in capsys.readouterr().err
    path.write_text(json.dumps(document | {"noise": {"kind": "white", "series": ["settlements"]}}), encoding="utf-8")
    assert main(["check", str(path), "--accept", "settlement"]) == 2
    assert "noise.series[0]: unknown series 'settlements'; did you mean settlement?" in capsys.readouterr().err
