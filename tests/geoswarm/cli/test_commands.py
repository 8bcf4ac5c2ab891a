"""The table of commands, and that help stays light."""

from __future__ import annotations

import subprocess
import sys

import click
import pytest
from click.testing import CliRunner

from geoswarm.cli import main
from geoswarm.cli.commands import COMMANDS, cli
from tests.integration.engines import PATIENCE

WANTED = (
    *("init", "inline", "check", "estimate", "evaluate", "run", "serve", "worker", "sweep", "submit", "watch"),
    *("list", "show", "cancel", "pause", "resume", "label", "retry-failed", "export", "demo", "workers", "attachments"),
    *("report", "statistics", "reweight", "paper", "keys", "prune"),
    *("sensitivity", "profile", "jackknife", "explore", "influence", "predict", "design", "posterior", "examples"),
    *("model", "models", "import", "umbridge", "agent", "hooks", "verify"),
)
READING = (
    *("check", "evaluate", "run", "submit", "watch", "list", "show", "retry-failed", "workers"),
    *("statistics", "reweight", "paper", "prune", "examples", "verify"),
    *("sensitivity", "profile", "jackknife", "explore", "influence", "predict", "design", "posterior"),
)


def command(name: str) -> click.Command:
    found = cli.get_command(click.Context(cli), name)
    assert found is not None
    return found


def test_all_commands_are_there() -> None:
    assert sorted(COMMANDS) == sorted(WANTED)


@pytest.mark.parametrize("name", WANTED)
def test_listing_says_what_the_help_of_the_command_says(name: str) -> None:
    help_text = command(name).help or ""
    assert " ".join(help_text.split("\n\n")[0].split()) == COMMANDS[name].help
    result = CliRunner().invoke(command(name), ["--help"])
    assert result.exit_code == 0
    assert "Usage" in result.output


@pytest.mark.parametrize("name", READING)
def test_reading_commands_speak_json(name: str) -> None:
    assert "--json" in [option for parameter in command(name).params for option in parameter.opts]


def test_help_lists_every_command_by_section(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    text = capsys.readouterr().out
    for name, entry in COMMANDS.items():
        assert f"  {name} " in text
        assert f"{entry.section}:" in text


def test_version_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("geoswarm ")


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys\n"
        "from geoswarm.cli import main\n"
        "assert main(['--help']) == 0\n"
        "heavy = {'numpy', 'numba', 'scipy', 'pydantic', 'pint', 'rich', 'httpx', 'sqlalchemy', 'fastapi', 'celery'}\n"
        "print('loaded:', sorted(heavy & sys.modules.keys()))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=PATIENCE)
    assert done.stdout.splitlines()[-1] == "loaded: []"


def test_closed_pipe_is_quiet() -> None:
    code = "import sys; from geoswarm.cli import main; sys.exit(main(['--help']))"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        error = process.stderr.read()
        assert process.wait(timeout=PATIENCE) == 1
    assert error == b""


def test_module_runs_as_a_program() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "geoswarm", "--version"], capture_output=True, text=True, check=True, timeout=PATIENCE
    )
    assert done.stdout.startswith("geoswarm ")
