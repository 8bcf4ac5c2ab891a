"""The commands about jobs against a real ``geoswarm serve`` with its own worker."""

from __future__ import annotations

import csv
import io
import json
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from geoswarm.cli import main
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from tests.integration.engines import PATIENCE
from tests.solver.problems import decay_document


@dataclass(frozen=True, slots=True)
class Service:
    """A running ``geoswarm serve`` and a problem file."""

    url: str
    problem: str


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """Start it on a free port with a fresh database; it must stop cleanly on SIGTERM."""
    folder = tmp_path_factory.mktemp("service")
    problem = folder / "problem.json"
    problem.write_text(json.dumps(decay_document()), encoding="utf-8")
    command = [sys.executable, "-m", "geoswarm", "serve", "--port", "0", "--workers", "1"]
    command += ["--database", f"sqlite:///{folder / 'jobs.db'}"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            line = process.stderr.readline()
            found = re.search(r"geoswarm serves at (http://127\.0\.0\.1:\d+) with 1 worker", line)
            assert found, line
            yield Service(found[1], str(problem))
            process.send_signal(signal.SIGTERM)
            rest = process.stderr.read()
            assert process.wait(timeout=PATIENCE) == 0
        finally:
            process.kill()
    assert rest == "Stopped.\n"


def call(capsys: pytest.CaptureFixture[str], service: Service, *arguments: str, code: int = 0) -> tuple[str, str]:
    """Run a command against the service and return what it wrote."""
    assert main([*arguments, "--url", service.url]) == code
    captured = capsys.readouterr()
    return captured.out, captured.err


def call_json(capsys: pytest.CaptureFixture[str], service: Service, *arguments: str, code: int = 0) -> Any:
    """Run a command with --json and return what it printed."""
    return json.loads(call(capsys, service, *arguments, "--json", code=code)[0])


@pytest.fixture
def finished(service: Service, capsys: pytest.CaptureFixture[str]) -> str:
    """Submit the problem once in the life of the service (same key) and wait for its end; its id."""
    job = call_json(capsys, service, "submit", service.problem, "--idempotency-key", "decay", "--watch")
    assert job["state"] == "finished"
    identifier: str = job["id"]
    return identifier


def test_submit_and_watch_give_what_an_in_process_run_gives(
    service: Service, finished: str, capsys: pytest.CaptureFixture[str]
) -> None:
    job = call_json(capsys, service, "watch", finished)
    expected = calibrate(parse_problem(decay_document()))
    assert job["objective"] == expected.objective
    assert job["parameters"] == expected.parameters
    assert (job["evaluations"], job["generations"]) == (expected.evaluations, expected.generations)
    assert job["stop_reasons"] == ["target_objective"]


def test_submit_prints_the_id_alone(service: Service, finished: str, capsys: pytest.CaptureFixture[str]) -> None:
    out, err = call(capsys, service, "submit", service.problem, "--idempotency-key", "decay")
    assert out == f"{finished}\n"
    assert err == ""


def test_list_and_show(service: Service, finished: str, capsys: pytest.CaptureFixture[str]) -> None:
    page = call_json(capsys, service, "list", "--state", "finished")
    assert finished in [job["id"] for job in page["items"]]
    assert page["next_cursor"] is None
    assert finished in call(capsys, service, "list")[0]
    assert call(capsys, service, "list", "--state", "paused")[0] == "No job is paused.\n"
    shown = call_json(capsys, service, "show", finished)
    assert shown["best"]["objective"] == shown["objective"]
    assert shown["best"]["parameters"] == shown["parameters"]
    assert sorted(shown["best"]["responses"]["y"]) == ["x", "y"]
    assert shown["created_at"].endswith("Z")
    assert shown["verdicts"] == {"amplitude": "undecided", "rate": "undecided"}  # by the search alone
    text = call(capsys, service, "show", finished)[0]
    for words in ("decay", "finished", "amplitude", "verdict", "undecided", "objective at or below the target"):
        assert words in text


def test_ids_may_be_abbreviated(service: Service, finished: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert call_json(capsys, service, "show", finished[:8])["id"] == finished
    assert call_json(capsys, service, "show", "latest")["state"] != ""
    assert "at least 4 characters" in call(capsys, service, "show", finished[:3], code=2)[1]
    assert "there is no job 'zzzzzz'" in call(capsys, service, "show", "zzzzzz", code=2)[1]


def test_a_job_is_renamed_and_tagged(service: Service, finished: str, capsys: pytest.CaptureFixture[str]) -> None:
    given = ("--name", "Dam, core", "--tag", "dam")
    assert "(Dam, core) has the tags dam\n" in call(capsys, service, "label", finished, *given)[0]
    assert "Dam, core" in call(capsys, service, "list")[0]
    assert "give --name, --tag" in call(capsys, service, "label", finished, code=2)[1]
    assert "at least 1 character" in call(capsys, service, "label", finished, "--name", "", code=2)[1]
    assert call_json(capsys, service, "label", finished, "--name", "decay", "--no-tags")["name"] == "decay"


def test_a_running_job_is_paused_resumed_and_cancelled(
    service: Service, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    endless = tmp_path / "endless.json"
    endless.write_text(json.dumps(decay_document(stopping={"max_seconds": 600})), encoding="utf-8")
    job = call(capsys, service, "submit", str(endless))[0].strip()
    assert call_json(capsys, service, "pause", job)["state"] == "paused"
    assert call_json(capsys, service, "show", job)["state"] == "paused"
    assert call_json(capsys, service, "resume", job)["state"] in ("queued", "running")
    assert call(capsys, service, "cancel", job)[0] == f"{job} (decay) is cancelled\n"
    refused = call(capsys, service, "resume", job, code=2)[1]
    assert "cancelled" in refused
    assert "was cancelled" in call(capsys, service, "watch", job, code=1)[1]


def test_a_failed_job_ends_the_watch_with_one(
    service: Service, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    failing = tmp_path / "failing.json"
    model = {"kind": "formula", "series": {"y": "ln(-amplitude) * exp(-rate * x)"}}
    document = decay_document(forward_model=model, stopping={"max_evaluations": 16})
    failing.write_text(json.dumps(document), encoding="utf-8")
    assert main(["submit", str(failing), "--watch", "--url", service.url]) == 1
    captured = capsys.readouterr()
    assert "all 16 evaluations failed (16 not finite)" in captured.err
    assert "failed" in captured.out


def test_export_as_csv_and_json(
    service: Service, finished: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    expected = calibrate(parse_problem(decay_document())).history
    out = call(capsys, service, "export", finished)[0]
    rows = list(csv.DictReader(io.StringIO(out)))
    assert [float(row["objective"]) for row in rows] == [record.evaluation.objective for record in expected]
    file = tmp_path / "runs.json"
    call(capsys, service, "export", finished, "--output", str(file))
    evaluations = json.loads(file.read_text(encoding="utf-8"))
    assert len(evaluations) == len(expected)
    assert evaluations[3]["responses"]["y"]["y"] == expected[3].evaluation.responses["y"].tolist()
    assert [path.name for path in tmp_path.iterdir()] == ["runs.json"]
    call(capsys, service, "export", finished, "--output", str(tmp_path / "runs.parquet"))
    assert (tmp_path / "runs.parquet").read_bytes()[:4] == b"PAR1"
    assert "needs --output" in call(capsys, service, "export", finished, "--format", "parquet", code=2)[1]
    message = call(capsys, service, "export", finished, "--output", str(tmp_path / "no" / "runs.csv"), code=2)[1]
    assert "there is no folder" in message


def test_files_are_attached_saved_and_removed(
    service: Service, finished: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    photo, table, page = (tmp_path / name for name in ("Probe: 3.jpg", "readings.csv", "page.html"))
    photo.write_bytes(b"\xff\xd8\xff\xe0 a photo")
    table.write_text("1;2")
    page.write_text("<html>")
    command = ["attachments", "add", finished, str(photo), str(table)]
    assert call(capsys, service, *command)[0].splitlines()[0] == f"Probe: 3.jpg is attached to {finished}"
    assert "page.html' is of no type" in call(capsys, service, "attachments", "add", finished, str(page), code=2)[1]
    listed = call_json(capsys, service, "attachments", "list", finished)["items"]
    assert [(one["name"], one["size"]) for one in listed] == [("Probe: 3.jpg", 12), ("readings.csv", 3)]
    assert "image/jpeg" in call(capsys, service, "attachments", "list", finished)[0]
    output = ("--output", str(tmp_path / "saved"))
    call(capsys, service, "attachments", "save", finished, *output)
    call(capsys, service, "attachments", "save", finished, listed[1]["sha256"][:8], *output)
    saved = {path.name: path.read_bytes() for path in (tmp_path / "saved").iterdir()}
    assert saved == {"Probe_ 3.jpg": photo.read_bytes(), "readings.csv": b"1;2", "readings-2.csv": b"1;2"}
    missing = call(capsys, service, "attachments", "remove", finished, "other.csv", code=2)[1]
    assert f"has no file 'other.csv'; it has Probe: 3.jpg ({listed[0]['sha256'][:12]}), readings.csv" in missing
    for name in ("Probe: 3.jpg", "readings.csv"):
        assert call(capsys, service, "attachments", "remove", finished, name)[0] == f"{name} is removed\n"
    assert call(capsys, service, "attachments", "list", finished)[0].startswith("No files.")


def test_workers_are_listed(service: Service, finished: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert finished
    workers = call_json(capsys, service, "workers")["items"]
    assert [worker["engine"] for worker in workers] == ["embedded"]
    assert "embedded" in call(capsys, service, "workers")[0]


def test_mistakes_are_told_before_anything_is_sent(
    service: Service, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = len(call_json(capsys, service, "list", "--limit", "200")["items"])
    bad = tmp_path / "bad.json"
    bad.write_text(json.dumps(decay_document(parameters={"amplitude": {"lower": 2, "upper": 1}})), encoding="utf-8")
    error = call(capsys, service, "submit", str(bad), code=2)[1]
    assert "parameters.amplitude.lower" in error
    assert "Traceback" not in error
    assert len(call_json(capsys, service, "list", "--limit", "200")["items"]) == before


def test_port_in_use_is_one_message(service: Service, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    port = service.url.rpartition(":")[2]
    assert main(["serve", "--port", port, "--database", f"sqlite:///{tmp_path / 'jobs.db'}"]) == 2
    error = capsys.readouterr().err
    assert f"127.0.0.1:{port}" in error
    assert "already in use" in error
    assert not (tmp_path / "jobs.db").exists()


def test_statistics_report_and_other_weights_of_a_job(
    service: Service, finished: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    found = call_json(capsys, service, "statistics", finished)
    assert [verdict["parameter"] for verdict in found["verdicts"]] == ["amplitude", "rate"]
    following = tmp_path / "next.json"
    call(capsys, service, "statistics", finished, "--accept", "fix:rate=0.7", "--output", str(following))
    assert json.loads(following.read_text(encoding="utf-8"))["parameters"]["rate"] == {"value": 0.7}
    weighted = call_json(capsys, service, "reweight", finished, "--weight", "y=2")
    assert weighted["weights"][0]["share"] == 1.0
    (tmp_path / "book.yaml").write_text("amplitude: 2\nrate: 1\n", encoding="utf-8")
    options = ("--figures", "--html", "--compare", str(tmp_path / "book.yaml"), "--output", str(tmp_path / "report"))
    _, written = call(capsys, service, "report", finished, *options)
    assert "Compared with book" in (tmp_path / "report" / "report.html").read_text(encoding="utf-8")
    names = {path.name for path in (tmp_path / "report").iterdir()}
    assert {"report.html", "matrix.png", "matrix.svg", "matrix.csv", "fit.csv"} <= names
    assert "report.pdf" not in names
    assert "report.html" in written
