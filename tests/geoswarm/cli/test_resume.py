"""A run that is cut off loses nothing that it has finished, and goes on to the same history."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.cli import main
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.runs.journal import read_journal
from tests.contracts.repository import ROOT
from tests.geoswarm.cli.interruptions import history
from tests.solver.problems import decay_document

pytestmark = pytest.mark.usefixtures("tables_only")


def write(folder: Path, **changes: Any) -> str:
    path = folder / "problem.json"
    path.write_text(json.dumps(decay_document(stopping={"max_evaluations": 40}, **changes)), encoding="utf-8")
    return str(path)


def interrupt_at(monkeypatch: pytest.MonkeyPatch, run: int, error: type[BaseException] = KeyboardInterrupt) -> None:
    """The forward run of that number, counted from 1, never comes to its end."""
    evaluate, count = Calibration.evaluate, [0]

    def evaluate_some(self: Calibration, parameters: Any) -> Any:
        count[0] += 1
        if count[0] == run:
            raise error
        return evaluate(self, parameters)

    monkeypatch.setattr(Calibration, "evaluate", evaluate_some)


def cut_off(monkeypatch: pytest.MonkeyPatch, problem: str, output: Path, run: int) -> None:
    """A calibration that Ctrl-C ends in the forward run of that number."""
    with monkeypatch.context() as patch:
        interrupt_at(patch, run)
        assert main(["run", problem, "--output", str(output)]) == 130


@pytest.mark.slow
@pytest.mark.timeout(1200)  # more than a hundred processes begin: minutes on a busy machine
def test_a_run_cut_off_at_random_moments_ends_at_the_same_history(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tests.geoswarm.cli.interruptions", str(tmp_path), "21", "swarm", "learning"],
        cwd=ROOT,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    for found in json.loads(done.stdout.splitlines()[-1]):
        assert found["different"] == 0, found
        assert found["unfinished"] >= 5, found  # the faults came while there was something to lose


def test_ctrl_c_says_what_is_kept_and_how_to_go_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    method = {"kind": "particle_swarm", "particles": 8}
    problem, output = write(tmp_path, method=method, answer=None), tmp_path / "output"
    cut_off(monkeypatch, problem, output, 21)
    said = capsys.readouterr().err
    assert f"20 finished runs are kept in {output / 'run.journal'}" in said
    assert f"'geoswarm run {problem} --output {output} --resume' continues" in said
    with (output / "evaluations.csv").open(encoding="utf-8", newline="") as stream:
        assert len(list(csv.DictReader(stream))) == 16  # two whole generations can be looked at meanwhile
    with (output / "generations.csv").open(encoding="utf-8", newline="") as stream:
        assert len(list(csv.DictReader(stream))) == 2

    assert main(["statistics", str(output)]) == 2
    assert "was interrupted" in capsys.readouterr().err
    assert main(["run", problem, "--output", str(output)]) == 2
    assert "holds 20 runs of an interrupted calibration: --resume continues" in capsys.readouterr().err

    runs: list[int] = []
    evaluate = Calibration.evaluate

    def counted(self: Calibration, parameters: Any) -> Any:
        runs.append(1)
        return evaluate(self, parameters)

    monkeypatch.setattr(Calibration, "evaluate", counted)
    assert main(["run", problem, "--output", str(output), "--resume"]) == 0
    assert "continuing after 20 runs" in capsys.readouterr().err
    with (output / "evaluations.csv").open(encoding="utf-8", newline="") as stream:
        places = {(row["amplitude"], row["rate"]) for row in csv.DictReader(stream)}
    assert len(runs) == len(places) - 20  # no run is done twice
    assert json.loads((output / "result.json").read_text(encoding="utf-8"))["answer"] is not None
    assert main(["run", problem, "--output", str(tmp_path / "whole")]) == 0
    assert history(output) == history(tmp_path / "whole")


def test_a_seed_that_was_drawn_is_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, output = write(tmp_path, seed=None), tmp_path / "output"
    cut_off(monkeypatch, problem, output, 9)
    seed = json.loads((output / "problem.json").read_text(encoding="utf-8"))["seed"]
    assert main(["run", problem, "--output", str(output), "--resume", "--seed", str(seed + 1)]) == 2
    assert "with another seed" in capsys.readouterr().err
    assert main(["run", problem, "--output", str(output), "--resume", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["seed"] == seed


def test_another_problem_does_not_go_on_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, output = write(tmp_path), tmp_path / "output"
    cut_off(monkeypatch, problem, output, 9)
    other = write(tmp_path, parameters={"amplitude": {"lower": 0.1, "upper": 9}, "rate": {"value": 0.7}})
    assert main(["run", other, "--output", str(output), "--resume"]) == 2
    assert "with another parameters" in capsys.readouterr().err


def test_resume_of_a_finished_run_shows_its_result(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    problem, output = write(tmp_path), tmp_path / "output"
    assert main(["run", problem, "--output", str(output), "--json", "--resume"]) == 0  # nothing there: it begins
    first = json.loads(capsys.readouterr().out)
    assert main(["run", problem, "--output", str(output), "--json", "--resume"]) == 0
    captured = capsys.readouterr()
    told = json.loads(captured.out)
    assert told == {name: first[name] for name in told}
    assert "is finished" in captured.err
    assert main(["run", problem, "--output", str(output), "--resume"]) == 0
    assert "amplitude" in capsys.readouterr().out
    assert main(["run", write(tmp_path, name="other"), "--output", str(output), "--resume"]) == 2
    assert "another name" in capsys.readouterr().err
    assert main(["run", problem, "--resume"]) == 2
    assert "--resume needs --output" in capsys.readouterr().err


@pytest.mark.parametrize("as_json", [False, True])
def test_results_are_printed_before_anything_is_written(
    as_json: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, output = write(tmp_path), tmp_path / "output"

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("geoswarm.solver.report.folder.run_folder.write_responses", full)
        assert main(["run", problem, "--output", str(output), *(["--json"] if as_json else [])]) == 1
    captured = capsys.readouterr()
    assert "amplitude" in captured.out
    assert f"{output / 'responses.npz'}: No space left on device" in captured.err
    assert "40 finished runs are kept" in captured.err
    assert "--resume" in captured.err
    assert main(["statistics", str(output)]) == 0  # the journal has all runs
    assert main(["run", problem, "--output", str(output), "--resume"]) == 0
    assert (output / "responses.npz").exists()


SLOW_MODEL = """
import os, time
import numpy as np

def curve(x, amplitude, rate):
    time.sleep(0.08)
    with open(CALLS, "a") as calls:
        calls.write(f"{amplitude!r} {rate!r}\\n")
    return amplitude * np.exp(-rate * x)
"""


def write_slow(folder: Path) -> tuple[str, Path]:
    """A problem whose answer may take more than a minute, and the file in which its function lists its calls."""
    calls = folder / "calls.txt"
    (folder / "slow.py").write_text(SLOW_MODEL.replace("CALLS", repr(str(calls))), encoding="utf-8")
    model = {"kind": "python", "file": "slow.py", "function": "curve", "series": {"y": {}}}
    x = [0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0]
    path = folder / "problem.json"
    document = decay_document(
        forward_model=model,
        observations=[{"series": "y", "points": {"x": x, "y": [3.02, 2.11, 1.43, 1.07, 0.74, 0.40, 0.17]}}],
        method={"kind": "particle_swarm", "particles": 6},
        stopping={"max_evaluations": 4000, "stagnation_generations": 3},
        answer={"max_evaluations": 1000},
    )
    path.write_text(json.dumps(document), encoding="utf-8")
    return str(path), calls


def answered(journal: Path) -> int:
    """Finished runs of the answer in a journal."""
    stored = read_journal(journal) if journal.exists() else None
    ends = [] if stored is None else [step.progress for step in stored.steps.values() if step.progress.answer]
    return 0 if stored is None or not ends else len(stored.evaluations) - ends[0].evaluations


# 21 s; test_worker_processes_end_with_the_run_and_their_runs_are_kept ends a search in its middle
@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_kill_in_the_answer_costs_the_runs_in_flight_only(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (problem, calls), output = write_slow(tmp_path), tmp_path / "output"
    command = [sys.executable, "-c", "import sys; from geoswarm.cli import main; sys.exit(main(sys.argv[1:]))"]
    arguments = ["run", problem, "--output", str(output)]
    with subprocess.Popen([*command, *arguments], cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as run:
        while answered(output / "run.journal") < 4:
            assert run.poll() is None
            time.sleep(0.02)
        run.kill()
        said = run.communicate()[1].decode()
    assert f"The search has ended, and its result is in {output}" in said
    early = json.loads((output / "result.json").read_text(encoding="utf-8"))
    assert (early["state"], early["intervals"], early["verdicts"]) == ("running", None, None)
    assert early["parameters"] == early["search_best"]["parameters"]
    assert early["evaluations"] == early["answer"]["parts"][0]["evaluations"]
    assert all((output / name).is_file() for name in ("responses.npz", "report.html", "report.pdf", "fit.png"))

    assert main(["statistics", str(output), "--json"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out)["samples"]["total"] == early["evaluations"]
    assert f"--output {output} --resume' continues them" in captured.err
    assert main(["report", str(output), "--html", "--output", str(tmp_path / "report")]) == 0
    assert "continues them" in (tmp_path / "report" / "report.html").read_text(encoding="utf-8")

    assert main(["sensitivity", str(output)]) == 2
    assert "--resume' continues it" in capsys.readouterr().err

    stored = read_journal(output / "run.journal")
    assert stored is not None
    finished, before = set(stored.evaluations), len(calls.read_text(encoding="utf-8").splitlines())
    assert before - len(finished) <= 1
    assert main([*arguments, "--resume", "--workers", "2"]) == 0
    again = calls.read_text(encoding="utf-8").splitlines()[before:]
    assert 0 < len(again) == len(set(again))
    assert not finished & {np.array([float(value) for value in line.split()]).tobytes() for line in again}
    assert main(["run", problem, "--output", str(tmp_path / "whole")]) == 0
    assert history(output) == history(tmp_path / "whole")


def test_a_short_answer_is_waited_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, output = write(tmp_path, method={"kind": "particle_swarm", "particles": 8}, answer={}), tmp_path / "output"
    cut_off(monkeypatch, problem, output, 35)
    assert not (output / "result.json").exists()
    assert main(["statistics", str(output)]) == 0
    assert "continues them" in capsys.readouterr().err
    monkeypatch.setattr("geoswarm.solver.report.folder.run_folder._SHORT_ANSWER", 0.0)
    longer = tmp_path / "longer"
    cut_off(monkeypatch, problem, longer, 35)
    assert json.loads((longer / "result.json").read_text(encoding="utf-8"))["state"] == "running"
    (longer / "run.journal").unlink()
    capsys.readouterr()
    assert main(["run", problem, "--output", str(longer), "--resume"]) == 0
    assert "starting a new run" in capsys.readouterr().err


def test_two_processes_do_not_run_into_one_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    problem, output = write(tmp_path), tmp_path / "output"
    hold = (
        "import fcntl, sys\n"
        "file = open(sys.argv[1], 'wb'); fcntl.flock(file, fcntl.LOCK_EX); print('held', flush=True); input()"
    )
    output.mkdir()
    with subprocess.Popen(
        [sys.executable, "-c", hold, str(output / "run.journal")], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == b"held\n"
        assert main(["run", problem, "--output", str(output)]) == 2
        other.communicate(b"\n")
    assert "another process is running into this folder" in capsys.readouterr().err


def test_worker_processes_end_with_the_run_and_their_runs_are_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, output = write(tmp_path), tmp_path / "output"

    def stop(*_: Any) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("geoswarm.solver.runs.local.generation_record", stop)
        patch.setattr("geoswarm.solver.report.folder.run_folder.generation_record", stop)
        assert main(["run", problem, "--output", str(output), "--workers", "2"]) == 130
    assert "8 finished runs are kept" in capsys.readouterr().err
    assert main(["run", problem, "--output", str(output), "--resume"]) == 0
    assert main(["run", problem, "--output", str(tmp_path / "whole")]) == 0
    assert history(output) == history(tmp_path / "whole")
