"""Calls of ``geoswarm`` on a page name commands and options that exist; shells read the rest, make has its targets."""

from __future__ import annotations

import re
import subprocess
import tomllib
from collections.abc import Iterator

import click
import pytest

from geoswarm.cli.commands import cli
from scripts.blocks import INDENTED
from tests.contracts.repository import ROOT
from tests.documentation.pages import PAGES, blocks_of, inline_code, text_of

SHELLS = ("bash", "sh", "console", "powershell", INDENTED)
CALL = re.compile(r"(?<!import )(?<!-n )(?<!generic )(?:^|(?<=[\s\\/(]))geoswarm ([a-z][^;&#\n]*)")


def calls(page: str) -> Iterator[str]:
    """Yield what follows ``geoswarm`` in the commands of a page, in blocks and in sentences."""
    for one in blocks_of(page):
        if one.kind in SHELLS:
            text = re.sub(r"\$\([^)]*\)", "X", re.sub(r"\\\n", " ", one.text))  # without what other programs say
            yield from CALL.findall(re.sub(r" \| .*", "", text))
    for code in inline_code(page):
        yield from CALL.findall(code)


def refused(call: str) -> str | None:
    """Say what is wrong with a call, None if nothing is."""
    words = re.sub(r"[\[\]'\"]|\.\.\.", " ", call).split()
    command: click.Command = cli
    context = click.Context(cli)
    while isinstance(command, click.Group) and words and not words[0].startswith("-"):
        for name in words.pop(0).split("|"):
            found = command.get_command(context, name)
            if found is None:
                return f"no command {name}"
        assert found is not None
        command, context = found, click.Context(found)
    known = {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
    known |= {"-h", "--help"}
    used = {word.partition("=")[0] for word in words if re.match(r"--?[a-z]", word)}
    return None if used <= known else f"no option {', '.join(sorted(used - known))}"


@pytest.mark.parametrize("page", PAGES)
def test_commands_and_options_of_a_page_exist(page: str) -> None:
    wrong = {call: fault for call in calls(page) if (fault := refused(call))}
    assert wrong == {}


def test_a_wrong_call_is_noticed() -> None:
    assert refused("run problem.yaml --workers 4 --output DIR") is None
    assert refused("keys create --owner anna") is None
    assert refused("walk problem.yaml") == "no command walk"
    assert refused("run problem.yaml --slowly") == "no option --slowly"
    assert refused("keys forge") == "no command forge"


def test_shells_read_every_block_of_commands() -> None:
    texts = [(page, one) for page in PAGES for one in blocks_of(page) if one.kind in ("bash", "sh")]
    read = [subprocess.run(["bash", "-n"], input=one.text, text=True, check=False).returncode for _, one in texts]
    assert [f"{page}:{one.line}" for (page, one), status in zip(texts, read, strict=True) if status] == []
    assert len(texts) > 20


@pytest.mark.parametrize("page", PAGES)
def test_extras_of_the_package_exist(page: str) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    asked = {extra for found in re.findall(r"geoswarm\[([\w,-]+)\]", text_of(page)) for extra in found.split(",")}
    assert asked <= set(project["optional-dependencies"])


@pytest.mark.parametrize("page", PAGES)
def test_targets_of_make_exist(page: str) -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    shown = [line for one in blocks_of(page) if one.kind in SHELLS for line in one.text.splitlines()]
    asked = {word for line in [*shown, *inline_code(page)] for word in re.findall(r"^make ([a-z-]+)", line)}
    assert asked <= targets


@pytest.mark.parametrize("page", PAGES)
def test_files_of_the_repository_that_commands_name_exist(page: str) -> None:
    shown = [one.text for one in blocks_of(page) if one.kind in SHELLS]
    made = ("examples/umat/lib", "examples/fortran_pest/consolidation")
    named = {name for text in shown for name in re.findall(r"\b(?:examples|deploy|scripts|docs)/[\w./-]+", text)}
    assert [name for name in sorted(named) if not name.startswith(made) and not (ROOT / name).exists()] == []
