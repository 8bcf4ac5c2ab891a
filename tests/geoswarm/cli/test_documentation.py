"""The page about the command line names every command and option, and nothing else; the README's commands exist."""

from __future__ import annotations

import re
from pathlib import Path

import click
import pytest

from geoswarm.cli.commands import COMMANDS, cli

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "command-line.md").read_text(encoding="utf-8")


def options(name: str) -> set[str]:
    command = cli.get_command(click.Context(cli), name)
    assert command is not None
    return {option for p in command.params for option in p.opts if option.startswith("--")}


def documented(name: str) -> str:
    """The synopses of a command: headings and the first cell of table rows."""
    found = re.findall(rf"^(?:### |\| )`geoswarm {name}\b.*", PAGE, re.MULTILINE)
    if name in ("pause", "resume"):
        found = re.findall(rf"^\| .*`{name} ID`.*", PAGE, re.MULTILINE)
    assert len(found) == 1, name
    return str(found[0])


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_every_option_is_documented_and_no_other(name: str) -> None:
    everywhere = {"--url", "--api-key", "--log-level", "--log-format"}  # told once for all commands that have them
    written = set(re.findall(r"--[a-z-]+", documented(name)))
    assert options(name) - everywhere == written - everywhere
    for option in everywhere & options(name):
        assert f"`{option}`" in PAGE


@pytest.mark.parametrize("page", ["README.md", "docs/quick-start.md"])
def test_quick_start_is_ten_lines_of_commands_that_exist(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    block = re.search(r"```bash\n(.*?)```", text, re.DOTALL)
    assert block is not None
    lines = [line for line in block[1].splitlines() if line]
    assert len(lines) <= 10
    used = re.findall(r"geoswarm ([a-z]+)", block[1])
    assert len(used) >= 5
    assert set(used) <= COMMANDS.keys()
    for path in re.findall(r"examples/\S+\.yaml", block[1]):
        assert (ROOT / path).is_file()
