"""The first page that anybody follows: README and quick start, from the example to the service and Python."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from scripts.reader import Reader
from tests.documentation.pages import block
from tests.documentation.service import USUAL, followed, serving, typed
from tests.servers import free_port

README = "README.md"
QUICK_START = "docs/quick-start.md"
COMMANDS = "geoswarm examples oedometer oedometer"


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Reader, str]]:
    """Who has typed the commands of the README, and what they printed."""
    port = free_port()
    with Reader(tmp_path_factory.mktemp("reader"), {"GEOSWARM_URL": f"http://127.0.0.1:{port}"}) as made:
        made.program("xdg-open", '#!/bin/sh\ntest -s "$1" && echo "shown: $1"\n')
        yield made, made.shell(typed(block(README, COMMANDS).text, port))


def commands(page: str) -> list[str]:
    return re.sub(r" +#.*", "", block(page, COMMANDS).text).splitlines()


def test_the_quick_start_types_what_the_readme_types() -> None:
    assert commands(QUICK_START) == commands(README)


@pytest.mark.timeout(280)
def test_its_commands_run(reader: tuple[Reader, str]) -> None:
    typist, printed = reader
    assert "oedometer-san-cassiano: valid" in printed
    assert "shown: oedometer/" not in printed
    assert "shown: output/oedometer/fit.png" in printed
    assert "lambda_star" in (typist.folder / "runs.csv").read_text(encoding="utf-8").partition("\n")[0]
    assert re.search(r"oedometer-san-cassiano +.*finished", printed)


def test_the_verdicts_of_the_readme_are_those_of_the_example(reader: tuple[Reader, str]) -> None:
    folder = reader[0].folder / "output" / "oedometer"
    told = block(README, "λ*  0.0825").text
    found = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    written = " ".join((folder / "report.html").read_text(encoding="utf-8").split())
    for symbol, name in {"λ*": "lambda_star", "κ*": "kappa_star", "c": "c"}.items():
        ((value, verdict, interval),) = re.findall(
            rf"^{re.escape(symbol)} +(\S+)(?: kPa)? +(\D+?) +95 % interval (\S+ to \S+)", told, re.MULTILINE
        )
        assert value == f"{found['parameters'][name]:#.3g}"
        assert f"{name} is {verdict} only: its 95 % interval at the optimum is {interval}, " in written
    search = found["answer"]["parts"][0]["evaluations"]
    assert f"{search} runs of the search, {found['evaluations'] - search} for minimum and intervals." in told
    (share,) = re.findall(r"could still hide\nin (\d+ %) of the searched space", told)
    assert f"a basin like this one could still hide in {share} of the searched space" in written
    assert told.splitlines()[-1] in written


FOUND = r"^[234]\.\d+e-09 \{'lambda_star': 0\.08"


@pytest.mark.slow  # the one below runs by default
def test_its_python_runs_with_the_service(reader: tuple[Reader, str], tmp_path: Path) -> None:
    (tmp_path / "oedometer").symlink_to(reader[0].folder / "oedometer")
    text = block(QUICK_START, "from geoswarm import Client").text
    with serving(tmp_path) as (other, url):
        assert USUAL in text
        assert re.search(FOUND, other.python(text.replace(USUAL, url)))


def test_its_python_runs_without_one(reader: tuple[Reader, str]) -> None:
    assert re.search(FOUND, followed(reader[0], block(QUICK_START, "gs.calibrate(")))
