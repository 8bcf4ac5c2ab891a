"""Without the extras: each command works, or names the extra that it needs."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from geoswarm.cli.commands import COMMANDS, cli
from geoswarm.cli.words.error_messages import CommandContext, report
from geoswarm.solver.system.extras import extra_of, needs_extra
from tests.contracts.repository import project
from tests.installation import Installation, install
from tests.solver.ags.synthetic import content
from tests.solver.problems import decay_document

URL = ("--url", "http://127.0.0.1:9")  # nothing listens there
MESHED = {
    "name": "meshed",
    "forward_model": {
        "kind": "finite_element",
        "mesh": {"file": "slope.msh"},
        "points": {"A": [0, 0]},
        "materials": {"soil": {"law": "elastic", "E": "E", "nu": 0.3, "unit_weight": 18}},
        "phases": [{"name": "weight", "kind": "gravity", "materials": {"soil": "soil"}}],
    },
    "parameters": {"E": {"lower": 1e3, "upper": 1e5}},
    "observations": [{"series": "A.uy", "points": {"x": [1.0], "y": [-0.01]}}],
    "method": {"kind": "particle_swarm", "particles": 8},
    "stopping": {"max_evaluations": 16},
}

# One process for all: most of the time would go into starting Python.
ONE_AFTER_THE_OTHER = """
import contextlib, io, json, sys
from geoswarm.cli import main
answers = []
for arguments in json.loads(sys.argv[1]):
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
        code = main(arguments)
    answers.append((code, text.getvalue()))
print(json.dumps(answers))
"""

# command: arguments, exit code, extra that it names
CASES: dict[str, list[tuple[list[str], int, str | None]]] = {
    "check": [(["problem.json"], 0, None), (["meshed.json"], 2, "mesh"), (["sobol.json"], 2, "statistics")],
    "estimate": [(["problem.json"], 0, None)],
    "evaluate": [(["problem.json", "--set", "amplitude=1", "--set", "rate=1"], 0, None)],
    "run": [(["problem.json", "--output", "again", "--json"], 0, "plots"), (["sobol.json"], 2, "statistics")],
    "paper": [(["A", "--output", "paper"], 2, "plots")],
    "verify": [(["--list"], 0, None), (["strength", "--output", "verified"], 2, "plots")],
    "init": [(["--output", "begun"], 0, None)],
    "inline": [(["problem.json"], 0, None)],
    "examples": [([], 0, None), (["formula", "formula"], 0, None)],
    "model new": [(["--run", "a", "--input", "none", "--mark", "a=1", "--result", "b"], 2, None)],
    "model try": [(["problem.json"], 2, None)],
    "model build-umat": [(["none.f"], 2, None)],
    "models list": [([], 0, None)],
    "models show": [(["none"], 2, None)],
    "models check": [(["none"], 2, None)],
    "models sign": [(["none", "--secret-file", "s", "--output", "o"], 2, None)],
    "import ags": [(["data.ags"], 0, None), (["data.ags", "--output", "ags", "--specimen", "BH1/3/1"], 0, None)],
    "import pest": [(["case.pst", "--output", "made"], 2, "pest")],
    "umbridge": [(["none.json"], 2, None)],
    "demo": [([], 2, "server")],
    "serve": [(["--port", "0"], 2, "server"), (["--broker", "redis://127.0.0.1:9/0"], 2, "server")],
    "worker": [(["--broker", "redis://127.0.0.1:9/0"], 2, "server")],
    "sweep": [([], 2, "server")],
    "agent": [(["--server", "nowhere"], 2, None)],
    "submit": [(["problem.json", *URL], 2, None)],
    **{name: [(["latest", *URL], 2, None)] for name in ("watch", "show", "cancel", "pause", "resume", "retry-failed")},
    **{name: [([*URL], 2, None)] for name in ("list", "workers")},
    "label": [(["latest", "--tag", "dam", *URL], 2, None), (["latest", *URL], 2, None)],
    "export": [(["latest", "--output", "x.parquet", *URL], 2, None), (["latest", *URL], 2, None)],
    "report": [(["run"], 2, "plots"), (["run", "--figures", "--posterior"], 2, "plots"), (["latest", *URL], 2, None)],
    "statistics": [(["run"], 0, None), (["run", "--accept", "fix:rate=1", "--output", "next.json"], 0, None)],
    "sensitivity": [(["run"], 0, None)],
    "profile": [(["run", "--parameter", "rate", "--noise", "0.01"], 0, None)],
    "jackknife": [(["run"], 2, None)],
    "explore": [(["run", "--runs", "20"], 0, None)],
    "predict": [(["run", "--problem", "later.json", "--runs", "40", "--noise", "0.01"], 0, "plots")],
    "design": [(["run", "--candidates", "candidates.json", "--draws", "1", "--noise", "0.01"], 0, "plots")],
    "influence": [(["run"], 2, "statistics"), (["problem.json", "--kind", "morris"], 2, "statistics")],
    "posterior": [(["run"], 2, "statistics")],
    "reweight": [(["run", "--weight", "y=2"], 0, None)],
    "hooks add": [(["https://example.org/hook", *URL], 2, None)],
    "attachments add": [(["latest", "data.ags", *URL], 2, None)],
    **{f"attachments {name}": [(["latest", *URL], 2, None)] for name in ("list", "save")},
    "attachments remove": [(["latest", "data.ags", *URL], 2, None)],
    "hooks list": [([*URL], 2, None)],
    **{name: [(["x", *URL], 2, None)] for name in ("hooks test", "hooks remove")},
    "keys create": [(["--owner", "a"], 2, "server")],
    "keys list": [([], 2, "server")],
    "keys revoke": [(["x"], 2, "server")],
    "prune": [(["--older-than", "90d"], 2, "server")],
}


def commands() -> Iterator[str]:
    """Every command that does something, those of groups with the group's name before it."""
    for name in COMMANDS:
        found = cli.get_command(click.Context(cli), name)
        if isinstance(found, click.Group):
            yield from (f"{name} {below}" for below in found.commands)
        else:
            yield name


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Installation:
    """The wheel without extras."""
    return install(tmp_path_factory.mktemp("base"))


@pytest.fixture(scope="module")
def folder(base: Installation, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Problems, and the folder of a run."""
    made = tmp_path_factory.mktemp("work")
    sobol = decay_document(method={"kind": "sobol", "samples": 8}, stopping={})
    for name, document in {"problem": decay_document(), "sobol": sobol, "meshed": MESHED}.items():
        (made / f"{name}.json").write_text(json.dumps(document), encoding="utf-8")
    there = [{"series": "y", "points": {"x": [6.0]}}]
    later = {"forward_model": decay_document()["forward_model"], "observations": there}
    (made / "later.json").write_text(json.dumps(later), encoding="utf-8")
    candidates = [{"name": "later", "observations": there}]
    (made / "candidates.json").write_text(json.dumps({"candidates": candidates}), encoding="utf-8")
    (made / "case.pst").write_text("pcf\n", encoding="utf-8")
    (made / "data.ags").write_bytes(content())
    (made / "slope.msh").write_text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", encoding="utf-8")
    done = base.geoswarm("run", "problem.json", "--output", "run", folder=made)
    assert done.returncode == 0, done.stderr
    return made


def test_no_command_is_forgotten() -> None:
    assert sorted(CASES) == sorted(commands())


@pytest.mark.slow
def test_each_command_works_in_the_base_installation_or_names_the_extra(base: Installation, folder: Path) -> None:
    calls = [(name, *case) for name, cases in CASES.items() for case in cases]
    lines = json.dumps([[*name.split(), *arguments] for name, arguments, _, _ in calls])
    done = subprocess.run(
        [base.python, "-c", ONE_AFTER_THE_OTHER, lines],
        cwd=folder,
        env=base.environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    for (name, arguments, code, extra), (ended, text) in zip(calls, json.loads(done.stdout), strict=True):
        told = f"geoswarm {name} {' '.join(arguments)}\n{text}"
        for wrong in ("fault of geoswarm", "Traceback", "ModuleNotFoundError", "ImportError"):
            assert wrong not in text, told
        assert ended == code, told
        if extra is None:
            assert "the extra" not in text, told
        else:
            assert f"needs the extra {extra}: pip install 'geoswarm[{extra}]'" in text, told


@pytest.mark.slow  # it makes an installation without extras
def test_a_run_says_before_it_begins_that_there_will_be_no_figures(base: Installation, folder: Path) -> None:
    done = base.geoswarm("run", "problem.json", "--output", "tables", folder=folder)
    assert done.stderr.startswith(
        "Note: tables only, no report and no figures: geoswarm run --output needs the extra plots: "
        "pip install 'geoswarm[plots]'\n"
    )
    assert sorted(path.suffix for path in (folder / "tables").iterdir()) == [".csv", ".csv", ".json", ".json", ".npz"]


@pytest.mark.parametrize("extra", ["server", "plots", "mesh", "statistics", "parquet", "tracing", "pest"])
def test_every_package_of_an_extra_leads_to_an_extra_that_has_it(extra: str) -> None:
    extras = project()["project"]["optional-dependencies"]
    for requirement in extras[extra]:
        name = requirement.split(">")[0].split("[")[0]
        found = extra_of(name.replace("-", "_"))
        assert found not in (None, "dev", "bench"), name
        assert any(one.startswith(name) for one in extras[found]), name


def test_a_part_of_a_package_leads_to_its_extra() -> None:
    assert extra_of("opentelemetry.sdk.trace") == "tracing"
    assert extra_of("prometheus_client.core") == "server"
    assert extra_of("numpy") is None
    assert needs_extra("a thing", "antigravity") == "a thing needs the package antigravity: pip install antigravity"


def test_a_module_that_no_extra_brings_is_a_fault_of_ours(capsys: pytest.CaptureFixture[str]) -> None:
    assert report(ModuleNotFoundError("No module named 'nope'", name="nope"), CommandContext(command="run")) == 1
    assert "fault of geoswarm" in capsys.readouterr().err


def test_tracing_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    from geoswarm.workers.errors import SettingsError
    from geoswarm.workers.tracing import start_tracing

    monkeypatch.setenv("OTEL_EXPORTER_OTLP_ENDPOINT", "http://127.0.0.1:9")
    for name in [name for name in sys.modules if name.split(".")[0] == "opentelemetry"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "opentelemetry", None)
    with pytest.raises(SettingsError, match=r"needs the extra tracing: pip install 'geoswarm\[tracing\]'"):
        start_tracing("serve")
