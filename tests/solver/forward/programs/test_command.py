"""The section ``kind: command``: what it refuses, what stays secret, what a run gets."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.cli.words.output import parameter_rows
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import ForwardError, ProblemError
from geoswarm.solver.external.interpolation import at_points
from geoswarm.solver.external.runs.folder import private_folder
from geoswarm.solver.external.runs.slots import slot
from geoswarm.solver.problem import Problem, load_problem, parse_problem
from geoswarm.solver.report.figures.labels import parameter_labels
from geoswarm.solver.runs.local import calibrate

ECHO = """
import json
p = json.load(open("p.json"))
lines = ["x,y", f"0,{p['a']!r}", f"2,{p['b']!r}"]
open("out.csv", "w").write(chr(10).join(lines))
"""


def problem(folder: Path, **changes: Any) -> Problem:
    section = {
        "kind": "command",
        "run": ["{python}", "-c", ECHO],
        "write": {"p.json": "json"},
        "series": {"y": {"file": "out.csv", "x": "x", "y": "y", "x_unit": "min", "y_unit": "mm"}},
    }
    units = {} if "series" in changes else {"x_unit": "min", "y_unit": "mm"}
    document = {
        "forward_model": section | changes,
        "parameters": {"a": {"lower": 0, "upper": 1}, "b": {"value": 0.1}},
        "observations": [{"series": "y", **units, "points": {"x": [0, 1, 2], "y": [0, 0, 0]}}],
        "stopping": {"max_evaluations": 10},
    }
    (folder / "problem.json").write_text(json.dumps(document))
    return load_problem(folder / "problem.json")


def run(given: Problem, **values: float) -> dict[str, Any]:
    calculate = given.model.prepare({o.series: o.x for o in given.observations})
    return calculate({"a": 0.25, "b": 0.75, **values})


@pytest.fixture(autouse=True)
def _own_temporary_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)


def test_units_are_converted_and_points_between_are_interpolated(tmp_path: Path) -> None:
    found = run(problem(tmp_path))["y"]
    assert np.allclose(found, [0.25e-3, 0.5e-3, 0.75e-3], rtol=1e-15)


@pytest.mark.parametrize("value", [0.1, 1 / 3, 1e-300, 123456789.123456789, 5e-324, -0.0])
def test_numbers_reach_the_program_to_the_last_bit(value: float, tmp_path: Path) -> None:
    code = "import struct; open('out.csv', 'w').write('x,y\\n0,' + repr(float(open('in').read())) + '\\n2,0\\n')"
    (tmp_path / "in.in").write_text("{{a}}\n")
    given = problem(
        tmp_path,
        run=["{python}", "-c", code],
        write={},
        templates={"in": "in.in"},
        series={"y": {"file": "out.csv", "x": 1, "y": 2}},
    )
    assert run(given, a=value)["y"][0].hex() == value.hex()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"run": []}, "run"),
        ({"run": [" "]}, "the program is empty"),
        ({"files": ["../secret"]}, "must stay in the folder"),
        ({"files": ["/etc/passwd"]}, "must be relative"),
        ({"files": ["missing.inc"]}, "missing.inc is not in"),
        ({"files": ["device"]}, "device is neither a file nor a folder"),
        ({"templates": {"p.json": "t.in"}}, "p.json is in templates and in write"),
        ({"link": ["mesh"], "write": {"mesh/p.json": "json"}}, "lies in the linked folder mesh"),
        ({"series": {"y": {"file": "../out.csv", "x": 1, "y": 2}}}, "must stay in the folder"),
        ({"series": {"y": {"file": "out.csv", "x": 1, "y": 2, "y_unit": "furlongs/x"}}}, "unknown unit"),
        ({"templates": {"in": "bad.in"}}, "bad.in: line 1, column 1"),
        ({"success": {"text": {"log": "("}}}, "is not a regular expression"),
        (
            {"link": ["mesh"], "series": {"y": {"file": "mesh/o.csv", "x": 1, "y": 2}}},
            "it could be that of another run",
        ),
        ({"link": ["mesh"], "success": {"files": ["mesh"]}}, "it could be that of another run"),
        ({"fail": {"exit": {"3": "sunburnt"}}}, "forward_model.fail.exit"),
        ({"environment": {"A B": "1"}}, "forward_model.environment"),
        ({"seconds": 0}, "seconds"),
        ({"slots": 0}, "slots"),
    ],
)
def test_mistakes_are_told_with_their_place(changes: dict[str, Any], words: str, tmp_path: Path) -> None:
    (tmp_path / "t.in").write_text("{{a}}")
    (tmp_path / "bad.in").write_text("{{a")
    (tmp_path / "device").symlink_to("/dev/full")
    (tmp_path / "mesh").mkdir()
    with pytest.raises(ProblemError) as caught:
        problem(tmp_path, **changes)
    assert words in str(caught.value)
    assert all(issue.path.startswith("forward_model") for issue in caught.value.issues)


def test_it_is_refused_unless_it_was_accepted(tmp_path: Path) -> None:
    document = problem(tmp_path).document()
    with pytest.raises(ProblemError, match="accepted from problem files and Python only"):
        parse_problem(document)
    assert parse_problem(document, programs=True) == problem(tmp_path)
    combined = {"kind": "combined", "parts": {"one": document["forward_model"]}}
    with pytest.raises(ProblemError, match="accepted from problem files and Python only"):
        parse_problem(document | {"forward_model": combined})


def test_the_environment_is_clean_and_what_is_passed_is_never_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PLAXIS_PASSWORD", "rosebud")
    monkeypatch.setenv("GEOSWARM_API_KEY", "sesame")
    monkeypatch.setenv("OTHER", "thing")
    code = "import os; e = os.environ; print(sorted(e)); print(e['PLAXIS_PASSWORD'], e['PORT']); raise SystemExit(3)"
    given = problem(
        tmp_path,
        run=["{python}", "-c", code],
        **{"pass": ["PLAXIS_PASSWORD"]},
        environment={"PORT": "50{slot}"},
        fail={"text": {"output": {r"\w+ 500": "diverged"}}},
    )
    with pytest.raises(ForwardError) as caught:
        run(given)
    told = str(caught.value)
    assert "rosebud" not in told
    assert "*** 500" in told
    assert "GEOSWARM_API_KEY" not in told
    assert "OTHER" not in told
    assert "rosebud" not in json.dumps(given.document())


def test_a_run_folder_that_cannot_be_filled_is_reported(tmp_path: Path) -> None:
    """With a limit of the size of files in place of a full disk."""
    (tmp_path / "in.in").write_text("{{a}} " + "x" * 100_000)
    problem(tmp_path, templates={"in": "in.in"})
    code = (
        "import resource, sys; from pathlib import Path\n"
        "from geoswarm.solver.calibration import Calibration\n"
        "from geoswarm.solver.problem import load_problem\n"
        "calibration = Calibration(load_problem(Path(sys.argv[1])), 1)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))\n"
        "found = calibration.evaluate_values({'a': 0.5, 'b': 0.5})\n"
        "print(found.reason, found.message)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "problem.json")], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("not_started the run folder cannot be filled")
    assert "File too large" in done.stdout


def test_files_that_change_do_not_change_a_calibration(tmp_path: Path) -> None:
    (tmp_path / "tool.py").write_text(ECHO)
    given = problem(tmp_path, run=["{python}", "tool.py"], files=["tool.py"])
    calculate = given.model.prepare({"y": np.array([0.0])})
    assert calculate({"a": 0.25, "b": 0.75})["y"].tolist() == [0.25e-3]
    (tmp_path / "tool.py").write_text("raise SystemExit(9)")
    assert calculate({"a": 0.5, "b": 0.75})["y"].tolist() == [0.5e-3]
    with pytest.raises(ForwardError, match=r"tool.py in .* has changed since the problem was read"):
        run(given)


@pytest.mark.parametrize(("rule", "reason"), [("success", "program_failed"), ("fail", None)])
def test_texts_of_an_earlier_run_do_not_count(rule: str, reason: str | None, tmp_path: Path) -> None:
    (tmp_path / "job.log").write_text("FINISHED")
    rules = {"success": {"text": {"job.log": "FINISHED"}}, "fail": {"text": {"job.log": {"FINISHED": "diverged"}}}}
    given = problem(tmp_path, files=["job.log"], **{rule: rules[rule]})
    found = Calibration(given, 1).evaluate_values({"a": 0.5, "b": 0.5})
    assert found.reason == reason


def test_texts_at_the_end_of_a_long_output_count(tmp_path: Path) -> None:
    code = f"{ECHO}\nimport os\nfor _ in range(100): os.write(1, b'x' * 70_000)\nos.write(1, b'*ERROR')"
    given = problem(tmp_path, run=["{python}", "-c", code], fail={"text": {"output": {r"\\*ERROR": "diverged"}}})
    assert Calibration(given, 1).evaluate_values({"a": 0.5, "b": 0.5}).reason == "diverged"


OLD = {
    "symbolic link": "os.symlink(old, name)",
    "hard link": "os.link(old, name)",
    "copy with its times": "shutil.copy2(old, name)",
    "file of yesterday": "shutil.move(old, name)",
    "link to a result of the run": "shutil.copy(old, name + '_'); os.symlink(name + '_', name)",
}


@pytest.mark.parametrize("way", OLD)
def test_what_this_run_has_not_written_does_not_count(way: str, tmp_path: Path) -> None:
    old = tmp_path / "old.csv"
    begin = f"import os, shutil\nold = {str(old)!r}\n"
    why = "is a link" if "link" in way else "is older than the run"

    def found(name: str, code: str, **rules: Any) -> tuple[str | None, str]:
        old.write_text("x,y\n0,FINISHED\n2,1\n" if name == "job.log" else "x,y\n0,1\n2,1\n")
        os.utime(old, (time.time() - 86400.0,) * 2)
        code = f"{ECHO if name != 'out.csv' else ''}\n{begin}name = {name!r}\n{code}"
        given = problem(tmp_path, run=["{python}", "-c", code], **rules)
        evaluation = Calibration(given, 1).evaluate_values({"a": 0.5, "b": 0.5})
        return evaluation.reason, evaluation.message or ""

    reason, message = found("out.csv", OLD[way])
    assert (reason, f"out.csv {why}" in message) == ("no_output", True)
    finished = {"job.log": "FINISHED"}
    assert found("job.log", OLD[way], success={"text": finished})[0] == "program_failed"
    assert found("job.log", OLD[way], fail={"text": {"job.log": {"FINISHED": "diverged"}}})[0] is None
    assert found("job.log", "shutil.copy(old, name)", success={"text": finished})[0] is None


def test_a_file_in_a_linked_folder_does_not_count(tmp_path: Path) -> None:
    """It may be there from yesterday, however new its times are."""
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "out.csv").write_text("x,y\n0,1\n2,1\n")
    link = "os.rmdir('res'); os.symlink(old, 'res'); os.utime('res/out.csv')"
    code = f"import os\nold = {str(tmp_path / 'old')!r}\n{link}"
    series = {"y": {"file": "res/out.csv", "x": "x", "y": "y"}}
    given = problem(tmp_path, run=["{python}", "-c", code], series=series)
    found = Calibration(given, 1).evaluate_values({"a": 0.5, "b": 0.5})
    assert (found.reason, "res/out.csv is in a linked folder" in (found.message or "")) == ("no_output", True)


def test_new_collections_of_results_with_old_times_are_refused(tmp_path: Path) -> None:
    code = (
        "import os\nopen('old.vtu', 'w').write('<VTKFile></VTKFile>'); os.utime('old.vtu', (1, 1))\n"
        "open('r.pvd', 'w').write('<DataSet timestep=\"0\" file=\"old.vtu\"/>')"
    )
    series = {"y": {"file": "r.pvd", "point": [0, 0], "field": "u"}}
    found = Calibration(problem(tmp_path, run=["{python}", "-c", code], series=series), 1).evaluate_values(
        {"a": 0, "b": 0}
    )
    assert (found.reason, "r.pvd names old.vtu, which is older" in (found.message or "")) == ("no_output", True)


def test_new_collections_of_old_results_are_refused(tmp_path: Path) -> None:
    (tmp_path / "old.vtu").write_text("<VTKFile></VTKFile>")
    code = "open('r.pvd', 'w').write('<DataSet timestep=\"0\" file=\"old.vtu\"/>')"
    series = {"y": {"file": "r.pvd", "point": [0, 0], "field": "u"}}
    given = problem(tmp_path, run=["{python}", "-c", code], files=["old.vtu"], series=series)
    found = Calibration(given, 1).evaluate_values({"a": 0.5, "b": 0.5})
    assert (found.reason, "r.pvd names old.vtu, which is older" in (found.message or "")) == ("no_output", True)


def test_problems_with_one_pool_share_slots(tmp_path: Path) -> None:
    code = f"{ECHO}\nimport sys; print('slot', sys.argv[1]); raise SystemExit(3)"
    numbers = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        given = problem(tmp_path / name, run=["{python}", "-c", code, "{slot}"], slots=2, pool="licence")
        with slot(private_folder("slots", "pool-licence"), 2) as taken, pytest.raises(ForwardError) as caught:
            run(given)
        numbers.append((taken, f"slot {1 - taken}" in str(caught.value)))
    assert numbers == [(0, True), (0, True)]


def hold_slots(folder: Path, seconds: float) -> subprocess.Popen[bytes]:
    """Hold the only slot below a folder in another process, for some time from now on."""
    program = (
        "import sys, time; from pathlib import Path; from geoswarm.solver.external.runs.slots import slot\n"
        "with slot(Path(sys.argv[1]), 1): print(flush=True); time.sleep(float(sys.argv[2]))"
    )
    process = subprocess.Popen([sys.executable, "-c", program, str(folder), str(seconds)], stdout=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.readline()
    process.stdout.close()
    return process


@pytest.mark.timing
@pytest.mark.parametrize("workers", [1, 2])
def test_waiting_for_a_slot_is_no_time_of_a_run(workers: int, tmp_path: Path) -> None:
    """The slot is held for longer than a run may take; the measured time is that of the run alone."""
    limits = {"seconds_per_evaluation": 3.0}
    search = {"method": {"kind": "monte_carlo", "samples": 2, "batch": 2}, "stopping": {}}
    document = problem(tmp_path, slots=1, pool="P").document() | {"limits": limits} | search
    with hold_slots(private_folder("slots", "pool-P"), 4.0) as holder:
        result = calibrate(parse_problem(document, programs=True), workers=workers)
        assert holder.wait() == 0
    found = [record.evaluation for record in result.history]
    assert [one.reason for one in found] == [None, None], [one.message for one in found]
    assert all(0.0 < one.seconds < 4.0 for one in found)  # one that takes longer than 3 s is killed


@pytest.mark.slow
@pytest.mark.timing
def test_calls_that_a_licence_was_refused_for_are_no_time_of_a_run(tmp_path: Path) -> None:
    """Four refusals with pauses of 2 s, while a run may take 6 s."""
    code = (
        "import pathlib, sys; t = pathlib.Path(sys.argv[1]); n = len(t.read_text()) if t.exists() else 0\n"
        "t.write_text('x' * (n + 1))\n"
        "sys.exit(4) if n < 4 else pathlib.Path('out.csv').write_text('x,y\\n0,0\\n2,0\\n')"
    )
    section = {
        "run": ["{python}", "-c", code, str(tmp_path / "tries")],
        "fail": {"exit": {"4": "no_licence"}},
        "licence_pause": 2.0,
    }
    search = {"method": {"kind": "monte_carlo", "samples": 1, "batch": 1}, "stopping": {}}
    document = problem(tmp_path, **section).document() | {"limits": {"seconds_per_evaluation": 6.0}} | search
    result = calibrate(parse_problem(document, programs=True), workers=2)
    (one,) = [record.evaluation for record in result.history]
    assert (one.reason, one.message) == (None, None)
    assert (tmp_path / "tries").read_text() == "xxxxx"
    assert 0.0 < one.seconds < 8.0  # one that takes longer than 6 s is killed


HANGING = {
    "run": ["{python}", "-c", "open('log.txt', 'w').write('a' * 60 + '\\n')"],
    "series": {"y": {"file": "log.txt", "find": "(?P<x>a+)+(?P<y>a+)+b"}},
}


@pytest.mark.slow
def test_a_pattern_that_would_take_for_ever_is_ended_with_its_name(tmp_path: Path) -> None:
    with pytest.raises(ForwardError, match=r"reading series y from log\.txt took longer than 5 s \(seconds\)") as told:
        run(problem(tmp_path, **HANGING, seconds=5.0))
    assert told.value.reason == "timeout"
    fail = {"text": {"log.txt": {"(a+)+b": "diverged"}}}
    with pytest.raises(ForwardError, match="reading texts of success and fail took longer than 5 s") as told:
        run(problem(tmp_path, **HANGING, seconds=5.0, fail=fail))
    assert told.value.reason == "timeout"


def test_the_limit_of_an_evaluation_tells_what_was_read(tmp_path: Path) -> None:
    search = {"method": {"kind": "monte_carlo", "samples": 1, "batch": 1}, "stopping": {}}
    document = problem(tmp_path, **HANGING).document() | {"limits": {"seconds_per_evaluation": 5.0}} | search
    (one,) = [record.evaluation for record in calibrate(parse_problem(document, programs=True)).history]
    assert one.reason == "timeout"
    assert one.message == (
        "ran for longer than 5 s (limits.seconds_per_evaluation) and was killed while reading series y from log.txt"
    )


def test_units_of_parameters_are_shown_and_convert_nothing(tmp_path: Path) -> None:
    given = problem(tmp_path, units={"a": "kPa", "b": "degree"})
    labels = parameter_labels(given)
    assert {name: label.unit for name, label in labels.items()} == {"a": "kPa", "b": "°"}
    assert [row[3] for row in parameter_rows(given, {"a": 1.0, "b": 2.0})] == ["kPa", "degree"]
    assert run(given)["y"].tolist() == run(problem(tmp_path))["y"].tolist()
    assert parse_problem(given.document(), programs=True).model.parameters == given.model.parameters


def test_a_unit_of_what_is_no_parameter_is_a_mistake(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match=r"parameters\.aa: is missing \(Named in forward_model\.units, kPa\)"):
        problem(tmp_path, units={"aa": "kPa"})


def test_a_unit_names_a_parameter_of_pest_in_its_own_capitals(tmp_path: Path) -> None:
    (tmp_path / "in.tpl").write_text("ptf #\n#   a    #\n")
    given = problem(tmp_path, templates={"in": "in.tpl"}, units={"b": "m"})
    assert {one.name: one.unit for one in given.model.parameters} == {"a": "", "b": "m"}
    given = problem(tmp_path, templates={"in": "in.tpl"}, units={"a": "m"})
    assert {one.name: one.unit for one in given.model.parameters} == {"a": "m"}


def test_a_series_that_turns_back_has_no_values_between_its_points() -> None:
    x, y = np.array([1.0, 2.0, 1.5, 0.5]), np.array([1.0, 2.0, 1.9, 1.5])
    assert at_points("y", x, y, np.array([1.5, 2.0])).tolist() == [1.9, 2.0]
    with pytest.raises(ForwardError, match=r"y turns back at x = 2 \(point 2 of 4\)"):
        at_points("y", x, y, np.array([0.75]))
    assert at_points("y", x[::-1][2:], y[::-1][2:], np.array([1.25])).tolist() == [1.25]
