"""What users of a service see of a registered model tells nothing of its machine."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.external.runs import fingerprints
from geoswarm.solver.forward.registry import parse_spec
from geoswarm.solver.registered.spec import RegisteredSpec, without_paths
from tests.solver.external.zoo import register, zoo_problem


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("/srv/models/good/deck.inp, line 3", "good/deck.inp, line 3"),
        ("'/srv/models/good' has more than 10000 files", "'good' has more than 10000 files"),
        ("no /srv/models/good.", "no good."),
        ("not /srv/models/goodness/a", "not a"),
        ('File "/usr/lib/python3/json.py", line 3', 'File "json.py", line 3'),
        ("/usr/bin/env:/etc/a b=/usr/x.py:12", "env:a b=x.py:12"),
        ("file:///etc/passwd and -I/usr/include/x -L /usr/lib/", "passwd and -Ix -L lib"),
        *((text, text) for text in ("http://host/usr/x", "3 kN/m", "a/usr/b", "~/usr", "../usr/y", "2 /m", "/gone/a")),
    ],
)
def test_paths_are_relative(text: str, shown: str, monkeypatch: pytest.MonkeyPatch) -> None:
    root = {"/usr", "/etc", "/srv", "/bin"}
    monkeypatch.setattr("os.path.lexists", lambda path: path in root)
    assert without_paths(text, "good", [Path("/srv/models/good")]) == shown


def test_the_temporary_folder_is_not_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", "/mnt/of lab")
    told = without_paths("run folder: /mnt/of lab/geoswarm-1/runs/failed-2", "good")
    assert told == "run folder: geoswarm-1/runs/failed-2"


TELLS = """\
import os, sys
from pathlib import Path
print(sorted(os.environ))
print("at", Path.cwd(), sys.executable, os.environ["DECK"], os.environ["PIN"], os.environ["PORT"], os.environ["CHOSEN"])
print("passed", os.environ["KEY"], os.environ["NUMBER"], os.environ["OMP_NUM_THREADS"])
raise SystemExit(2)
"""


@pytest.fixture
def models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of registered models, of which "good" tells all that it knows."""
    register(tmp_path / "models")
    folder = tmp_path / "models" / "good"
    (folder / "zoo.py").write_text(TELLS)
    monkeypatch.setenv("GEOSWARM_MODELS", str(tmp_path / "models"))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    monkeypatch.setenv("KEY", "rosebud")
    monkeypatch.setenv("NUMBER", "2")
    section = {
        "kind": "command",
        "run": ["{python}", "zoo.py"],
        "files": ["zoo.py"],
        "write": {"p.json": "json"},
        "pass": ["KEY", "NUMBER"],
        "environment": {
            "DECK": str(folder / "deck.lic"),
            "PIN": "47",
            "PORT": "50{slot}",
            "CHOSEN": "{steps}",
            "OMP_NUM_THREADS": "1",
        },
        "series": {"y": {"file": "out.csv", "x": "x", "y": "y"}},
    }
    declare(tmp_path / "models", section)
    return tmp_path / "models"


def declare(models: Path, section: dict[str, Any]) -> None:
    settings = {"steps": {"type": "integer", "default": 5}}
    declared = {"forward_model": section, "parameters": {"slope": {}}, "settings": settings}
    (models / "good" / "model.yaml").write_text(json.dumps(declared))


def message(name: str = "good") -> str:
    problem = zoo_problem(name)
    return Calibration(problem, 1).evaluate_values({"slope": 0.5}).message or ""


@pytest.mark.usefixtures("models")
def test_a_failed_run_tells_neither_folders_nor_values(tmp_path: Path) -> None:
    told = message()
    first, _, printed = told.partition("\n")
    assert first.endswith("ended with exit status 2")  # no value, though one that is passed is 2
    assert "'CHOSEN', 'DECK'" in printed
    assert "at geoswarm-" in printed
    assert f"{Path(sys.executable).name} *** *** *** 5\n" in printed
    assert "passed *** *** 1\n" in printed
    assert "run folder: geoswarm-" in told
    assert str(tmp_path) not in told
    assert str(Path(sys.executable).parent) not in told


@pytest.mark.usefixtures("models")
def test_a_value_that_is_part_of_the_run_folders_path_leaves_it_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KEY", tmp_path.name)
    told = message()
    assert "at geoswarm-" in told
    assert "passed *** *** 1\n" in told
    assert tmp_path.name not in told


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ({"kind": "command", "run": ["x"], "files": ["gone.inc"]}, "gone.inc is not in good"),
        ({"kind": "command", "run": ["x"], "templates": {"a": "gone.in"}}, "gone.in"),
        ({"kind": "python", "file": "gone.py", "function": "f"}, "good/gone.py is not there"),
        ({"kind": "registered"}, "forward_model.kind must be one of formula, combined, oedometer"),
    ],
)
def test_a_broken_model_is_told_by_its_name(section: dict[str, Any], words: str, models: Path, tmp_path: Path) -> None:
    series: dict[str, Any] = {"y": {"file": "out.csv", "x": 1, "y": 2} if section["kind"] == "command" else {}}
    declare(models, section | {"series": series})
    with pytest.raises(ProblemError) as caught:
        zoo_problem("good")
    assert "model good is broken: " in str(caught.value)
    assert words in str(caught.value)
    assert str(tmp_path) not in str(caught.value)


def test_a_model_that_cannot_be_looked_at_is_told_by_its_name(models: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = zoo_problem("good")
    assert models.is_dir()
    monkeypatch.setattr(fingerprints, "MOST_FILES", 1)
    why = problem.forward_model.unavailable() or ""
    assert why == "good has more than 1 files, or a link in it leads back to it"
    assert Calibration(problem, 1).evaluate_values({"slope": 0.5}).message == why


def test_what_functions_raise_and_log_is_told_without_folders(models: Path, tmp_path: Path) -> None:
    source = "from pathlib import Path\ndef f(slope):\n    return open(Path(__file__).with_name('gone.csv')).read()\n"
    (models / "good" / "model.py").write_text(source)
    declare(models, {"kind": "python", "file": "model.py", "function": "f", "series": {"y": {}}})
    told = message()
    assert "No such file or directory: 'good/gone.csv'" in told
    assert str(tmp_path) not in told
    log = f"{models}/good/model.py:3: RuntimeWarning: overflow"
    shown = zoo_problem("good").forward_model.shown(log)
    assert shown == "good/model.py:3: RuntimeWarning: overflow"


def test_a_server_behind_a_model_is_not_told(models: Path) -> None:
    url = "http://127.0.0.1:9/deep/"
    series = {"y": {"x": [0, 4]}}
    declare(models, {"kind": "umbridge", "url": url, "tries": 1, "inputs": [["slope"]], "series": series})
    told = message()
    assert told.startswith("the server of good cannot be reached: Connection refused")
    assert "127.0.0.1" not in told


def test_the_note_of_a_fallback_is_told_without_folders(models: Path, tmp_path: Path) -> None:
    program = "import sys; open('out.csv', 'w').write('x,y\\n0,0\\n4,4\\n')"
    section = {"kind": "command", "run": [f"{tmp_path}/gone"], "then": [["{python}", "-c", program]]}
    section |= {"write": {"p.json": "json"}, "series": {"y": {"file": "out.csv", "x": "x", "y": "y"}}}
    declare(models, section)
    told = message()
    assert "after not_started: " in told
    assert str(tmp_path) not in told


def test_parts_of_a_combined_model_are_told_by_their_names(models: Path) -> None:
    formula = {"kind": "formula", "series": {"y": "a * x"}}
    parts = {"one": {"kind": "registered", "model": "good"}, "two": formula}
    assert parse_spec(formula).shown(f"{models}/good/a") == f"{models}/good/a"
    assert parse_spec({"kind": "combined", "parts": parts}).shown(f"{models}/good/a") == "good/a"


def test_a_model_that_is_gone_still_tells_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEOSWARM_MODELS", str(tmp_path))
    spec = RegisteredSpec(kind="registered", model="gone")
    assert str(tmp_path) not in spec.shown(f"{tmp_path}/gone/a.csv")
